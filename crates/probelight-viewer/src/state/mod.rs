//! What the window shows and how one changes it. Nothing here needs a window or a GPU.
//!
//! | module | job |
//! | --- | --- |
//! | [`document`] | lights, colours, objects, cameras: what is undone and saved |
//! | [`edit`] | changes to it |
//! | [`history`] | undo and redo |
//! | [`view_state`] | what is shown of it, and how |
//! | [`action`] | all that panels, keys and arguments can ask for; what each does |
//! | [`camera_rig`] | how mouse and keys move the camera |
//! | [`keys`] | which key does what |

pub mod action;
pub mod camera_rig;
pub mod document;
pub mod edit;
pub mod history;
pub mod keys;
pub mod view_state;

pub use action::{Action, Request, State};
pub use document::{Document, Item, LightEntry, ObjectEntry, Selection};
pub use edit::Edit;
pub use view_state::ViewState;
