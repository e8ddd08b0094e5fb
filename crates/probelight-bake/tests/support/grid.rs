//! What the vertices of a grid light.

use std::collections::HashSet;

use probelight_asset::{BakedScene, VertexPlace};
use probelight_math::glam::Vec3;
use probelight_runtime::{GridPlaces, IrradianceGrid};

/// Levels that blocks with vertices have.
pub(crate) fn levels(baked: &BakedScene) -> usize {
    let lit = baked.grid_blocks.iter().filter(|block| block.mask() != 0);
    lit.map(|block| block.level).collect::<HashSet<u32>>().len()
}

/// What comes of an irradiance of 1 at all vertices that `is_lit` chooses by where they measure, and of 0 elsewhere, at
/// a surface of the given position and normal.
pub(crate) fn share_of(baked: &BakedScene, is_lit: impl Fn(Vec3) -> bool) -> impl Fn(Vec3, Vec3) -> f32 {
    let value = move |vertex| f32::from(is_lit(vertex));
    light_of(baked, value)
}

/// What comes of an irradiance at all vertices that `value` tells by where they measure.
pub(crate) fn light_of(baked: &BakedScene, value: impl Fn(Vec3) -> f32) -> impl Fn(Vec3, Vec3) -> f32 {
    let mut values = vec![Vec3::ZERO; baked.receiver_count()];
    for VertexPlace { vertex, position, .. } in baked.grid_vertex_places() {
        let receivers = baked.vertex_receivers(vertex);
        assert_eq!(receivers.len(), baked.settings.grid_basis.rows());
        receivers.iter().for_each(|receiver| values[*receiver as usize] = Vec3::splat(value(position)));
    }
    let places = GridPlaces::new(baked);
    move |position, normal| {
        IrradianceGrid::new(baked, &places, &values).irradiance(position, normal).unwrap().x
    }
}
