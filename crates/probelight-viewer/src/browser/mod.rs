//! What a page in a browser does in its own way. Its twin is `desktop`, which has the same names.
//!
//! A page has one thread, files only as bytes, and nothing that waits. Scenes are baked elsewhere.
//!
//! | module | job |
//! | --- | --- |
//! | [`mod@file`] | reads what was dropped, chosen or downloaded; saves by a download |
//! | [`dialogs`] | asks for files |
//! | [`background`] | work between two pictures |

pub mod background;
pub mod dialogs;
pub mod file;

pub use background::{breathe, spawn};
pub use dialogs::Dialogs;
pub use file::File;
pub(crate) use file::save;

use crate::viewer::Viewer;

/// How scenes are baked in browsers: not at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {}

/// How scenes are baked when they are opened.
pub const FIRST_QUALITY: Option<Quality> = None;

/// Qualities, and what one gets.
pub const QUALITIES: &[(Quality, &str, &str)] = &[];

/// Pages save no frames.
#[derive(Clone, Copy, Debug)]
pub enum Recording {}

impl Viewer {
    /// Nobody is offered this.
    pub(crate) fn toggle_recording(&mut self) {
        self.messages.error("pages save no frames");
    }

    /// The page shows nothing any more.
    pub(crate) fn end_without_gpu(&mut self) {
        self.messages.error("the GPU was lost: load the page again");
    }

    /// There is nothing to save them in.
    pub(crate) fn record(&mut self) {}

    /// Nobody can ask for this.
    pub(crate) fn bake(&mut self, quality: Quality) {
        match quality {}
    }
}
