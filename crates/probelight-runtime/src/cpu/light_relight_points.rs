//! Stage 1: the radiance that each relight ray brings to its probe.
//!
//! A ray that leaves the scene brings the sky's radiance along its direction. A ray that hits a surface brings
//! `L = Le + ρ/π · (E_direct + E_lightmap)`: emission of front faces, and the light that the side which was hit
//! reflects. `E_lightmap` is last frame's lightmap, which holds everything that arrives by way of the probes.
//!
//! What changes rarely is kept: shadow rays are only traced when a light changed, the terms without feedback
//! are only evaluated when a light, the sky or a material changed. Every frame then is one multiplication per
//! point. Feedback is clamped at zero, because truncated matrices can yield slightly negative irradiance and no
//! surface reflects that.

use std::f32::consts::FRAC_1_PI;

use probelight_asset::{BakedScene, NONE, RelightPoint};
use probelight_math::color::linear_from_srgb;
use probelight_math::glam::Vec3;
use probelight_scene::{Light, Lighting, Scene};
use probelight_trace::{Tracer, direct_irradiance};
use rayon::prelude::*;

use crate::IrradianceLightmap;

/// Points a task works through.
const POINTS_PER_TASK: usize = 2048;

/// What a material contributes to light transport, before textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceColors {
    /// Linear base colour factor.
    pub base_color: Vec3,
    /// Emitted radiance of the front face, W·m⁻²·sr⁻¹.
    pub emission: Vec3,
}

impl SurfaceColors {
    /// The colours of a scene's materials.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let colors = |m: &probelight_scene::Material| Self {
            base_color: m.base_color.truncate(),
            emission: m.emission,
        };
        scene.materials.iter().map(colors).collect()
    }
}

/// Radiance of all relight rays, and the parts of it that outlast a frame.
#[derive(Clone, Debug)]
pub struct RelightRadiance {
    /// Irradiance of the analytic lights at each point, W/m².
    direct: Vec<Vec3>,
    /// Radiance without feedback: sky, or emission and reflected direct light.
    unbounced: Vec<Vec3>,
    /// ρ/π of points that read the lightmap, else 0.
    reflectance: Vec<Vec3>,
    /// Where points read the lightmap.
    texels: Vec<u32>,
    /// L, W·m⁻²·sr⁻¹.
    values: Vec<Vec3>,
    linear_from_srgb: [f32; 256],
}

impl RelightRadiance {
    /// Darkness for the relight points of a baked scene.
    pub fn new(baked: &BakedScene) -> Self {
        let dark = vec![Vec3::ZERO; baked.relight_points.len()];
        Self {
            direct: dark.clone(),
            unbounced: dark.clone(),
            reflectance: dark.clone(),
            // Points without a texel have no reflectance to multiply the first texel with.
            texels: baked.relight_points.iter().map(|p| if p.texel == NONE { 0 } else { p.texel }).collect(),
            values: dark,
            linear_from_srgb: std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0)),
        }
    }

    /// Radiance of each relight ray, a probe's rays in a row, W·m⁻²·sr⁻¹.
    pub fn values(&self) -> &[Vec3] {
        &self.values
    }

    /// Traces shadow rays: direct irradiance of all points. Needed when a light changed.
    pub fn trace_direct(&mut self, baked: &BakedScene, tracer: &Tracer, lights: &[Light]) {
        self.direct
            .par_chunks_mut(POINTS_PER_TASK)
            .zip(baked.relight_points.par_chunks(POINTS_PER_TASK))
            .for_each(|(direct, points)| {
                for (direct, point) in direct.iter_mut().zip(points) {
                    *direct = direct_irradiance_at(tracer, lights, point);
                }
            });
    }

    /// Evaluates what does not depend on feedback. Needed when a light, the sky or a material changed.
    pub fn shade(&mut self, baked: &BakedScene, lighting: &Lighting, colors: &[SurfaceColors]) {
        let rays = baked.relight_directions.len().max(1);
        let decode = &self.linear_from_srgb;
        self.unbounced
            .par_chunks_mut(rays)
            .zip(self.reflectance.par_chunks_mut(rays))
            .zip(self.direct.par_chunks(rays).zip(baked.relight_points.par_chunks(rays)))
            .for_each(|((unbounced, reflectance), (direct, points))| {
                for (ray, point) in points.iter().enumerate() {
                    if point.triangle == NONE {
                        unbounced[ray] = lighting.sky.radiance(baked.relight_directions[ray]);
                        reflectance[ray] = Vec3::ZERO;
                        continue;
                    }
                    let material = baked.scene.triangle_material[point.triangle as usize];
                    let colors = &colors[material as usize];
                    let texel =
                        |[r, g, b, _]: [u8; 4]| Vec3::from([r, g, b].map(|code| decode[usize::from(code)]));
                    let reflected = colors.base_color * texel(point.base_color_and_side) * FRAC_1_PI;
                    let is_front = point.base_color_and_side[3] == 0;
                    let emission_factor = if is_front { lighting.emissive_scale } else { 0.0 };
                    let emitted = colors.emission * texel(point.emission_texel) * emission_factor;
                    unbounced[ray] = emitted + reflected * direct[ray];
                    reflectance[ray] = if point.texel == NONE { Vec3::ZERO } else { reflected };
                }
            });
    }

    /// Evaluates the radiance of all points with last frame's lightmap as feedback.
    pub fn light_relight_points(&mut self, lightmap: &IrradianceLightmap) {
        let inputs = (&self.unbounced, &self.reflectance, &self.texels);
        self.values.par_chunks_mut(POINTS_PER_TASK).enumerate().for_each(|(task, values)| {
            let range = task * POINTS_PER_TASK..task * POINTS_PER_TASK + values.len();
            let unbounced = &inputs.0[range.clone()];
            let reflectance = &inputs.1[range.clone()];
            let texels = &inputs.2[range];
            for (((value, unbounced), reflectance), texel) in
                values.iter_mut().zip(unbounced).zip(reflectance).zip(texels)
            {
                let irradiance = lightmap.texels.get(*texel as usize).copied().unwrap_or(Vec3::ZERO);
                *value = *unbounced + *reflectance * irradiance.max(Vec3::ZERO);
            }
        });
    }
}

/// Irradiance that reaches a point straight from the lights, on the side that the relight ray hit.
fn direct_irradiance_at(tracer: &Tracer, lights: &[Light], point: &RelightPoint) -> Vec3 {
    if point.triangle == NONE {
        return Vec3::ZERO;
    }
    let front = tracer.front_normal(point.triangle);
    let normal = if point.base_color_and_side[3] == 0 { front } else { -front };
    direct_irradiance(tracer, lights, point.position, normal)
}
