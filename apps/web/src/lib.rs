//! Probelight in browsers: the viewer on a page's canvas, by WebGPU.
//!
//! `static/` has the page, `page.rs` what it calls. `tools/build-web.sh` makes a folder of both that any server of static
//! files can hand out. Elsewhere than in browsers this crate is empty.

#[cfg(target_arch = "wasm32")]
pub mod page;
