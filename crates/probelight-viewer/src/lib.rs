//! The window: look at a scene, change its light, bake it again.
//!
//! | module | job |
//! | --- | --- |
//! | [`state`] | what is shown and how one changes it: plain data, [`Action`](state::Action)s and [`Edit`](state::Edit)s |
//! | [`scene`] | scenes on the GPU; what is done for them in the background |
//! | [`picture`] | from a lit scene to a picture in the window |
//! | [`panels`] | what lies around the picture |
//! | [`handles`], [`overlays`], [`mouse`] | what lies over it |
//! | [`viewer`] | [`Viewer`]: events in, actions done, picture out |
//! | `desktop`, `browser` | what a window on a computer and a page in a browser do each in its own way: files, background work, bakes |
//! | [`messages`], [`settings`] | what the window tells, and what it remembers |
//!
//! Panels, keys, the mouse, arguments and tests all speak [`Action`](state::Action)s. A frame takes what happened, does what
//! was asked for, and lights and draws the scene only if something changed.

#[cfg(target_arch = "wasm32")]
pub mod browser;
#[cfg(not(target_arch = "wasm32"))]
pub mod desktop;
pub mod handles;
pub mod messages;
pub mod mouse;
pub mod overlays;
pub mod panels;
pub mod picture;
pub mod scene;
pub mod settings;
pub mod state;
pub mod viewer;

#[cfg(target_arch = "wasm32")]
use self::browser as platform;
#[cfg(not(target_arch = "wasm32"))]
use self::desktop as platform;
#[cfg(not(target_arch = "wasm32"))]
pub use self::desktop::window::{WindowError, WindowOptions, has_display, run};
pub use viewer::{Viewer, ViewerOptions};
