//! One file per command.

pub(crate) mod bake;
pub(crate) mod bench;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod eval;
pub(crate) mod eval_lod;
pub(crate) mod export;
pub(crate) mod info;
pub(crate) mod man;
pub(crate) mod reference;
pub(crate) mod render;
#[cfg(feature = "window")]
pub(crate) mod view;
pub(crate) mod web;
