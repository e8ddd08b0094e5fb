//! Baked scenes on the GPU, and what is done for them in the background.
//!
//! | module | job |
//! | --- | --- |
//! | [`live_scene`] | a baked scene, lit and drawn frame by frame as the document has it |
//! | [`loader`] | reading files without holding up the window |
//! | [`progress`] | where work in the background stands |
//! | [`reference_picture`] | the path tracer's picture, which grows while nothing changes |
//! | [`pick`] | what is at a place |
//! | [`pending`] | answers of the GPU that are on their way |
//! | [`frame_times`], [`frame_work`] | how long frames take, and what they do |

pub mod frame_times;
pub mod frame_work;
pub mod live_scene;
pub mod loader;
pub mod pending;
pub mod pick;
pub mod progress;
pub mod reference_picture;
