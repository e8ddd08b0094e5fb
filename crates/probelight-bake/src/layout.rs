//! Finding the texel density that gives the wanted number of receivers.

use probelight_trace::{Progress, Tracer};

use crate::BakeError;
use crate::atlas::{Atlas, unwrap_faces};
use crate::options::Resolved;
use crate::receivers::count_chart_texels;
use crate::sides::LitSides;

/// Layouts tried; texel counts follow the density closely enough that more are not needed.
const TRIES: usize = 5;

/// Accepted deviation from the wanted count.
const TOLERANCE: f64 = 0.02;

/// Lays out the lit faces at the wanted density; `resolved.settings.texels_per_meter` becomes the density
/// used.
pub(crate) fn fit_layout(
    tracer: &Tracer,
    lit_sides: &LitSides,
    seams: &[[bool; 3]],
    use_uv1: bool,
    resolved: &mut Resolved,
    progress: &dyn Progress,
) -> Result<Atlas, BakeError> {
    progress.begin("laying out the lightmap", TRIES as u64);
    let mut density = resolved.settings.texels_per_meter;
    if resolved.receiver_target.is_some() {
        let fitting = density_without_borders(tracer, lit_sides, resolved);
        density = if resolved.target_is_limit { density.min(fitting) } else { fitting };
    }
    let mut atlas = unwrap_faces(tracer.scene(), lit_sides, seams, use_uv1, density, progress)?;
    for _ in 1..TRIES {
        progress.advance(1);
        let Some(target) = resolved.receiver_target else { break };
        let excess = count_chart_texels(&atlas) as f64 / f64::from(target);
        let few_enough =
            resolved.target_is_limit && excess <= 1.0 && density >= resolved.settings.texels_per_meter;
        if few_enough || (excess - 1.0).abs() < TOLERANCE {
            break;
        }
        density /= excess.sqrt() as f32;
        if resolved.target_is_limit {
            density = density.min(resolved.settings.texels_per_meter);
        }
        atlas = unwrap_faces(tracer.scene(), lit_sides, seams, use_uv1, density, progress)?;
    }
    resolved.set_texel_density(density);
    Ok(atlas)
}

/// The density at which the lit area alone, without the charts' borders, fills the target.
fn density_without_borders(tracer: &Tracer, lit_sides: &LitSides, resolved: &Resolved) -> f32 {
    let scene = tracer.scene();
    let area: f64 = (0..scene.triangles.len())
        .map(|t| {
            f64::from(scene.area(t)) * f64::from(u8::from(lit_sides.front(t)) + u8::from(lit_sides.back(t)))
        })
        .sum();
    let target = f64::from(resolved.receiver_target.unwrap_or(u32::MAX));
    (target / area.max(f64::MIN_POSITIVE)).sqrt() as f32
}
