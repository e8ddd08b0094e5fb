//! What the probes' relight rays hit: the places whose light the runtime evaluates each frame.

use probelight_asset::{NONE, RelightPoint};
use probelight_math::color::srgb8_from_linear;
use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::atlas::Atlas;

/// Traces all relight rays; a probe's points in a row, in the order of `directions`.
pub(crate) fn trace_relight_rays(
    tracer: &Tracer,
    atlas: &Atlas,
    probes: &[Vec3],
    directions: &[Vec3],
    progress: &dyn Progress,
) -> Result<Vec<RelightPoint>, BakeError> {
    progress.begin("tracing relight rays", probes.len() as u64);
    let points: Vec<Vec<RelightPoint>> = probes
        .par_iter()
        .map(|probe| {
            if progress.is_cancelled() {
                return Vec::new();
            }
            progress.advance(1);
            directions.iter().map(|direction| relight_point(tracer, atlas, *probe, *direction)).collect()
        })
        .collect();
    if progress.is_cancelled() {
        return Err(BakeError::Cancelled);
    }
    Ok(points.into_iter().flatten().collect())
}

fn relight_point(tracer: &Tracer, atlas: &Atlas, probe: Vec3, direction: Vec3) -> RelightPoint {
    let Some(hit) = tracer.closest_hit(&Ray::new(probe, direction)) else {
        return RelightPoint { triangle: NONE, texel: NONE, ..RelightPoint::default() };
    };
    let scene = tracer.scene();
    let triangle = hit.triangle as usize;
    let [r, g, b] = srgb8_from_linear(scene.base_color_texel(triangle, hit.barycentric).truncate());
    let [er, eg, eb] = srgb8_from_linear(scene.emission_texel(triangle, hit.barycentric));
    RelightPoint {
        position: probe + direction * hit.distance,
        triangle: hit.triangle,
        texel: texel_of_hit(atlas, &hit),
        base_color_and_side: [r, g, b, u8::from(hit.is_back_face)],
        emission_texel: [er, eg, eb, 0],
    }
}

/// The lightmap texel at a hit, on the side that was hit.
fn texel_of_hit(atlas: &Atlas, hit: &Hit) -> u32 {
    let face = if hit.is_back_face { atlas.back_faces[hit.triangle as usize] } else { hit.triangle };
    if face == NONE || atlas.face_charts[face as usize] == NONE {
        return NONE;
    }
    let position =
        atlas.faces[face as usize].position(hit.barycentric).max(probelight_math::glam::Vec2::ZERO);
    let (x, y) = ((position.x as u32).min(atlas.width - 1), (position.y as u32).min(atlas.height - 1));
    y * atlas.width + x
}
