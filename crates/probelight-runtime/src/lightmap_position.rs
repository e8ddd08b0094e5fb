//! Where in the lightmap the surface at a world position lies.

use probelight_asset::LightmapLayout;
use probelight_math::glam::{Vec2, Vec3};
use probelight_trace::{Ray, Tracer};

/// How far from the given position a surface may lie, in multiples of [`Tracer::offset`] (1e-5 of the scene's
/// diagonal): first what rounding explains, then what positions written with few digits need.
const REACHES: [f32; 2] = [8.0, 100.0];

/// A ray goes on this share of [`Tracer::offset`] behind a hit: beyond rounding, and well below any gap between
/// two surfaces that are meant to be two.
const STEP_PAST_HIT: f32 = 0.1;

/// Cosine of the largest angle (60°) between the given normal and a surface that counts as meant.
const SMALLEST_COSINE: f32 = 0.5;

/// Surfaces looked at along the ray; more within reach would be a heap of coincident triangles.
const MOST_HITS: usize = 16;

/// Lightmap position (texels) of the surface at `position` whose side towards `normal` (unit) is meant; `None`
/// if there is no such surface, `Some(None)` if that side has no light of its own.
///
/// Of several surfaces the nearest counts, so that the two faces of a thin wall are told apart. Where surfaces
/// coincide, one whose side has light counts.
pub fn lightmap_position(
    tracer: &Tracer,
    layout: &LightmapLayout,
    position: Vec3,
    normal: Vec3,
) -> Option<Option<Vec2>> {
    REACHES.into_iter().find_map(|reach| {
        let reach = reach * tracer.offset();
        nearest_surface(tracer, layout, position, normal, reach)
    })
}

/// `None`: no surface within reach; `Some(None)`: one without light.
fn nearest_surface(
    tracer: &Tracer,
    layout: &LightmapLayout,
    position: Vec3,
    normal: Vec3,
    reach: f32,
) -> Option<Option<Vec2>> {
    let start = position + normal * reach;
    let mut travelled = 0.0;
    let mut nearest: Option<(f32, Option<Vec2>)> = None;
    for _ in 0..MOST_HITS {
        let origin = start - normal * travelled;
        let ray = Ray { origin, direction: -normal, max_distance: 2.0 * reach - travelled };
        let Some(hit) = tracer.closest_hit(&ray) else { break };
        let distance = (travelled + hit.distance - reach).abs();
        if hit.normal.dot(normal) >= SMALLEST_COSINE {
            let found = layout.position(hit.triangle, hit.is_back_face, hit.barycentric);
            let is_better = nearest.is_none_or(|(nearest, lit)| {
                if lit.is_none() == found.is_none() {
                    distance < nearest
                } else if found.is_some() {
                    distance <= nearest + tracer.offset()
                } else {
                    distance + tracer.offset() < nearest
                }
            });
            if is_better {
                nearest = Some((distance, found));
            }
        }
        travelled += hit.distance + STEP_PAST_HIT * tracer.offset();
        if travelled >= 2.0 * reach {
            break;
        }
    }
    nearest.map(|(_, found)| found)
}
