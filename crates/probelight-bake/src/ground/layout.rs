//! Finding the texel density that gives the wanted number of receivers.

use std::collections::BTreeSet;

use probelight_asset::NONE;
use probelight_scene::Warning;
use probelight_trace::{Progress, Tracer};

use crate::BakeError;
use crate::air::LitSides;
use crate::ground::atlas::{Atlas, unwrap_faces};
use crate::ground::receivers::count_chart_texels;
use crate::options::Wishes;

/// Layouts tried; texel counts follow the density closely enough that more are not needed.
const TRIES: usize = 5;

/// Accepted deviation from the wanted count.
const TOLERANCE: f64 = 0.02;

/// Texels grow to this width at most, as a multiple of the one at which the lit area alone fills the target. Every
/// chart takes a texel at least, so that no width is enough where there are more of them than receivers asked for.
const WIDEST_TEXEL: f32 = 2.0;

/// Receivers as a multiple of those asked for from which on the author is told why.
const CROWDED: f64 = 1.25;

/// Where the lit faces lie in the lightmap.
pub(crate) struct Layout {
    pub(crate) atlas: Atlas,
    /// The density that the wishes came to.
    pub(crate) texels_per_meter: f32,
    /// If there will be far more receivers than asked for: why.
    pub(crate) warning: Option<Warning>,
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
    let area = lit_area(tracer, lit_sides);
    if area == 0.0 {
        let reason = "no surface is in sight of open air; are all faces turned inside out?".into();
        return Err(BakeError::NothingToLight { reason });
    }
    let unwrap = |density| unwrap_faces(tracer.scene(), lit_sides, seams, wishes.use_uv1, density, progress);
    let limit = wishes.density.limit();
    let Some(target) = wishes.density.receivers() else {
        return Ok(Layout { atlas: unwrap(limit)?, texels_per_meter: limit, warning: None });
    };
    // Without the charts' borders.
    let fitting = (f64::from(target) / area).sqrt() as f32;
    let coarsest = (fitting / WIDEST_TEXEL).min(limit);
    let mut density = fitting.min(limit);
    let mut atlas = unwrap(density)?;
    let mut excess = count_chart_texels(&atlas) as f64 / f64::from(target);
    for _ in 1..TRIES {
        progress.advance(1);
        let next = (density / excess.sqrt() as f32).clamp(coarsest, limit);
        if next == density || (excess - 1.0).abs() < TOLERANCE {
            break;
        }
        density = next;
        atlas = unwrap(density)?;
        excess = count_chart_texels(&atlas) as f64 / f64::from(target);
    }
    let warning = (excess > CROWDED).then(|| crowded(&atlas, target, excess));
    Ok(Layout { atlas, texels_per_meter: density, warning })
}

/// What a scene of too many charts leads to.
fn crowded(atlas: &Atlas, target: u32, excess: f64) -> Warning {
    let charts: BTreeSet<u32> = atlas.face_charts.iter().copied().filter(|chart| *chart != NONE).collect();
    let message = format!(
        "{:.0} texels where {target} receivers were asked for, because each of the {} separate pieces of surface \
         takes whole ones (ask for more receivers, or leave out small objects)",
        excess * f64::from(target),
        charts.len()
    );
    Warning { message, count: 1 }
}

/// Area of all lit sides, m².
fn lit_area(tracer: &Tracer, lit_sides: &LitSides) -> f64 {
    let scene = tracer.scene();
    let sides = |t: usize| u8::from(lit_sides.front(t)) + u8::from(lit_sides.back(t));
    (0..scene.triangles.len()).map(|t| f64::from(scene.area(t)) * f64::from(sides(t))).sum()
}
