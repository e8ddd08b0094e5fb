//! The analytic lights' own light in the lightmap, for programs that have no lights of their own.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::Light;
use probelight_trace::{Cancelled, Progress, Tracer, direct_irradiance};
use rayon::prelude::*;

/// Points on a texel along each of its edges.
const PER_EDGE: u32 = 4;

/// Mean irradiance of all lights over each texel's own part of the surface, with shadows, W/m²; zero elsewhere.
///
/// # Errors
/// [`Cancelled`] if `progress` asks to stop.
pub(crate) fn direct_light(
    baked: &BakedScene,
    tracer: &Tracer,
    lights: &[Light],
    progress: &dyn Progress,
) -> Result<Vec<Vec3>, Cancelled> {
    let triangles = baked.scene.triangles.len() as u32;
    progress.begin("direct light", u64::from(triangles));
    let sides: Vec<(u32, bool)> = (0..triangles).flat_map(|t| [(t, false), (t, true)]).collect();
    let lit = sides.par_iter().map(|(triangle, is_back)| {
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        progress.advance(u64::from(!is_back));
        Ok(light_side(baked, tracer, lights, *triangle, *is_back))
    });
    let lit: Vec<Vec<(u32, Vec3)>> = lit.collect::<Result<_, _>>()?;
    let texels = baked.lightmap.width as usize * baked.lightmap.height as usize;
    let mut sums = vec![(Vec3::ZERO, 0u32); texels];
    for (texel, irradiance) in lit.into_iter().flatten() {
        let (sum, count) = &mut sums[texel as usize];
        (*sum, *count) = (*sum + irradiance, *count + 1);
    }
    let mut means: Vec<Vec3> = sums.into_iter().map(|(sum, count)| sum / count.max(1) as f32).collect();
    for [texel, source] in &baked.lightmap.dilation {
        means[*texel as usize] = means[*source as usize];
    }
    Ok(means)
}

/// Texels and irradiance of points on one side of a triangle.
fn light_side(
    baked: &BakedScene,
    tracer: &Tracer,
    lights: &[Light],
    triangle: u32,
    is_back: bool,
) -> Vec<(u32, Vec3)> {
    let Some(face) = baked.lightmap.face(triangle, is_back) else { return Vec::new() };
    let normal = tracer.side_normal(triangle, is_back);
    let point = |(place, weights)| {
        let position = baked.scene.position(triangle as usize, weights);
        (baked.lightmap.texel_at(place), direct_irradiance(tracer, lights, position, normal))
    };
    face.points(PER_EDGE).map(point).collect()
}
