//! Finding the texel density that gives the wanted number of receivers.

use probelight_trace::{Progress, Tracer};

use crate::BakeError;
use crate::air::LitSides;
use crate::atlas::{Atlas, unwrap_faces};
use crate::options::Wishes;
use crate::receivers::count_chart_texels;

/// Layouts tried; texel counts follow the density closely enough that more are not needed.
const TRIES: usize = 5;

/// Accepted deviation from the wanted count.
const TOLERANCE: f64 = 0.02;

/// Where the lit faces lie in the lightmap.
pub(crate) struct Layout {
    pub(crate) atlas: Atlas,
    /// The density that the wishes came to.
    pub(crate) texels_per_meter: f32,
}

/// Lays out the lit faces at the wanted density.
pub(crate) fn fit_layout(
    tracer: &Tracer,
    lit_sides: &LitSides,
    seams: &[[bool; 3]],
    wishes: &Wishes,
    progress: &dyn Progress,
) -> Result<Layout, BakeError> {
    progress.begin("laying out the lightmap", TRIES as u64);
    let (target, limit) = (wishes.density.receivers(), wishes.density.limit());
    let unwrap = |density| {
        let atlas = unwrap_faces(tracer.scene(), lit_sides, seams, wishes.use_uv1, density, progress)?;
        Ok::<_, BakeError>(Layout { atlas, texels_per_meter: density })
    };
    let start = target.map_or(limit, |target| density_without_borders(tracer, lit_sides, target).min(limit));
    let mut layout = unwrap(start)?;
    for _ in 1..TRIES {
        progress.advance(1);
        let Some(target) = target else { break };
        let excess = count_chart_texels(&layout.atlas) as f64 / f64::from(target);
        let is_within_limits = excess <= 1.0 && layout.texels_per_meter >= limit;
        if is_within_limits || (excess - 1.0).abs() < TOLERANCE {
            break;
        }
        layout = unwrap((layout.texels_per_meter / excess.sqrt() as f32).min(limit))?;
    }
    Ok(layout)
}

/// The density at which the lit area alone, without the charts' borders, fills the target.
fn density_without_borders(tracer: &Tracer, lit_sides: &LitSides, target: u32) -> f32 {
    let scene = tracer.scene();
    let lit_sides = |t: usize| u8::from(lit_sides.front(t)) + u8::from(lit_sides.back(t));
    let lit_area = |t: usize| f64::from(scene.area(t)) * f64::from(lit_sides(t));
    let area: f64 = (0..scene.triangles.len()).map(lit_area).sum();
    (f64::from(target) / area.max(f64::MIN_POSITIVE)).sqrt() as f32
}
