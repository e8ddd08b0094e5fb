//! A baked scene as files that other programs read.
//!
//! | module | job |
//! | --- | --- |
//! | `glb` | glTF with the lightmap's texture coordinates |
//! | `direct_light` | the analytic lights' own light, texel by texel |

pub(crate) mod direct_light;
pub(crate) mod glb;
