//! Probelight in browsers, by WebGPU. Elsewhere this crate is empty.
//!
//! | feature | on by default | what it brings |
//! | --- | --- | --- |
//! | `page` | yes | the viewer on a page's canvas; `static/` has the page around it |
//! | `library` | no | light for the renderers of others; `package/` has what JavaScript calls |
//!
//! `tools/build-web.sh` makes folders of both that any server of static files can hand out.

#[cfg(all(target_arch = "wasm32", feature = "library"))]
pub mod library;
#[cfg(all(target_arch = "wasm32", feature = "page"))]
pub mod page;
