//! All limits by which places and points are judged: is this open air, and what does it see?

/// Rays around a place.
pub(super) const PLACE_RAYS: usize = 128;

/// How many of these are enough to know the inside of a solid: most of them meet what is unlit.
pub(super) const FIRST_PLACE_RAYS: usize = 16;

/// Share of the directions in which a place must meet surfaces for the farthest of these to tell how large the space around
/// it is. Doors, windows and an open roof over a court may take the rest.
pub(super) const EXTENT_SHARE: f32 = 0.85;

/// Share of a place's rays that may meet back faces of single-sided materials before an enclosed place counts as the
/// inside of a solid.
pub(super) const MAX_BACK_SHARE: f32 = 0.25;

/// Share of a place's rays that may meet unlit sides before it is no place to measure light.
pub(super) const MAX_UNLIT_SHARE: f32 = 0.2;

/// Share of the rays of a point of a texel that may end on unlit sides before the point lies inside a solid.
pub(crate) const MAX_UNLIT_SHARE_OF_POINT: f32 = 0.3;

/// Places in open air tried for sight of a point, nearest first.
pub(super) const PLACES_TRIED: usize = 12;

/// Smallest cosine between a point's normal and a place that counts as seen: what comes in flatter is a share of
/// 0.0025, its square, of all light at most.
pub(super) const SMALLEST_COSINE: f32 = 0.05;

/// Walks on which light is looked for from a point out of sight of open air, and surfaces that each visits. A point
/// that hardly any of them leads to light gets a few percent of what there is at most.
pub(super) const WALKS: u32 = 16;
pub(super) const STEPS_PER_WALK: u32 = 3;
pub(super) const FEWEST_LIT_WALKS: u32 = 2;

/// If that many walks all end at once, inside a solid, the others would too.
pub(super) const FIRST_WALKS: u32 = 4;

/// Share of the places within the scene's bounds that may be inside solids before it is likely that the scene is a
/// room turned inside out.
pub(super) const MAX_SOLID_SHARE: f32 = 0.5;

/// Points inside a triangle's side that are tried first for light.
pub(super) const FIRST_POINTS: u32 = 4;

/// Further points inside it: one for each square of a quarter voxel, up to that many.
pub(super) const MOST_POINTS: f32 = 64.0;

/// Points along each edge: one for each eighth of a voxel, within limits.
pub(super) const POINTS_PER_EDGE: [f32; 2] = [3.0, 24.0];

/// Points in its corners, along its edges and further inside whose walks tell whether those of the others are worth while.
pub(super) const MOST_SCOUTS: usize = 16;

/// How far points in corners and along edges lie inside, as shares of the side's height.
pub(super) const INSETS: [f32; 2] = [0.05, 0.01];

/// How many times back faces that are lit light further ones (round the corners of a house).
pub(super) const GENERATIONS: usize = 2;

/// Probes tried for sight of a receiver, nearest first, while probes are placed.
pub(crate) const PROBES_TRIED_IN_PLACING: usize = 12;

/// Probes tried for a receiver's outlook, nearest first.
pub(crate) const PROBES_TRIED_FOR_OUTLOOK: usize = 64;

/// Probes tried for sight of each point of a texel, nearest to the texel first.
pub(crate) const PROBES_TRIED_PER_POINT: usize = 8;

/// Exposure of a point with nothing before it, percent.
pub(crate) const FULL_EXPOSURE: u8 = 100;

/// Rays that measure a point's exposure.
pub(crate) const EXPOSURE_RAYS: u32 = 8;

/// Points less exposed than the best beside them by this factor do not count.
pub(crate) const LEAST_EXPOSURE: u32 = 4;

/// Share of a texel's points that must be exposed before the hidden ones do not count.
pub(crate) const SMALLEST_EXPOSED_SHARE: f32 = 0.5;

/// Mean exposure below which a texel's surface is hidden, percent.
pub(crate) const HIDDEN_EXPOSURE: u32 = 50;
