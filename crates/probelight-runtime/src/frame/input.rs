//! What a host says about a frame.

use probelight_math::glam::Vec3;
use probelight_scene::{Bounds, Camera};

/// What a host knows about a frame. Without anything ([`FrameInput::default`]) all of the scene is computed at its first
/// [level](crate::LodSettings).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameInput<'a> {
    /// Who looks; without it everything counts as near.
    pub view: Option<View>,
    /// Boxes around what moves but for the runtime's own objects, metres, world space. Clusters that they touch count as
    /// near, wherever the view is; light in free space is computed in them only.
    pub active_boxes: &'a [Bounds],
    /// Whether light in free space is computed everywhere.
    pub whole_grid: bool,
    /// What the frame may cost.
    pub budget: Option<Budget>,
}

/// Where somebody looks from, and where to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// World position of the eye, metres.
    pub position: Vec3,
    /// Unit direction of the view; zero for one that has everything in front.
    pub direction: Vec3,
}

impl From<&Camera> for View {
    fn from(camera: &Camera) -> Self {
        let direction = (camera.target - camera.position).normalize_or_zero();
        Self { position: camera.position, direction }
    }
}

/// What a frame may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Budget {
    /// Bytes of transport matrices, see [`FramePlan::matrix_bytes`](crate::FramePlan::matrix_bytes). Where more is wanted,
    /// the whole frame takes coarser levels until it fits, or there is no coarser one.
    MatrixBytes(u64),
}
