//! One file per command.

pub mod bake;
pub mod completions;
pub mod demo;
pub mod eval;
pub mod info;
pub mod man;
pub mod reference;
pub mod render;
