//! What only a computer with files, threads and a display of its own can do. Its twin is `browser`, which has the same names.
//!
//! | module | job |
//! | --- | --- |
//! | [`window`] | the program's window |
//! | [`mod@file`] | reads files from the disk, and saves them |
//! | [`dialogs`] | asks for files |
//! | [`recording`] | saves all pictures that are drawn |
//! | `rescue` | what is saved when the window ends by accident |
//! | [`baker`] | bakes without holding up the window |
//! | [`background`] | threads |

pub mod background;
pub mod baker;
pub mod dialogs;
pub mod file;
pub mod recording;
mod rescue;
pub mod window;

pub use background::{breathe, spawn};
pub use baker::{FIRST_QUALITY, QUALITIES, Quality};
pub use dialogs::Dialogs;
pub use file::File;
pub(crate) use file::save;
pub use recording::Recording;
