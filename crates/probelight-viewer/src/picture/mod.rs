//! From a lit scene to the picture in the window.
//!
//! | module | job |
//! | --- | --- |
//! | [`screen`] | draws the picture, and another one beside it, as the view has them |
//! | [`meter`] | how bright the picture is |
//! | [`texel_colors`] | what the colours of clusters stand for |

pub mod charts;
pub mod meter;
pub mod screen;
pub mod texel_colors;
