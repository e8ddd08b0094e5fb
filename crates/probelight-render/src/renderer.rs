//! What a camera sees: one primary ray a sample, direct light by shadow rays, everything else from the
//! lightmap.
//!
//! Radiance of a surface that the ray meets: L = Le + ρ/π · (E_direct + E_lightmap), where E_direct comes from
//! point, spot and directional lights, and E_lightmap is all that the signals bring: light that
//! was reflected at least once, the sky, and emissive surfaces. Normals are geometric, as in the reference.
//!
//! Objects that move have no lightmap: what the signals bring them is known in free space for any normal, so they are
//! shaded by their vertices' normals.

use std::f32::consts::FRAC_1_PI;

use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{hash_pair, sobol_owen};
use probelight_runtime::{ObjectInfluence, Runtime, SurfaceColors};
use probelight_scene::{Camera, Lighting, Scene};
use probelight_trace::{
    Cancelled, Hit, Progress, Ray, TracedObject, World, WorldHit, smooth_direct_irradiance,
};
use rayon::prelude::*;

use crate::{Image, PixelFilter};

/// What surfaces look like at present: their colours, and the light they receive from the lightmap.
pub trait Surfaces: Sync {
    /// Irradiance (W/m²) of the lightmap at a hit, on the side that was hit; black where
    /// nothing is known.
    fn irradiance(&self, hit: &Hit) -> Vec3;

    /// Irradiance (W/m²) in free space of a surface at a world position that faces along `normal` (unit); black where
    /// nothing is known.
    fn irradiance_in_air(&self, _position: Vec3, _normal: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    /// What objects make of that light at a point of a surface, of the object of some index or of the scene, where
    /// `irradiance` arrives without them.
    fn object_influence(
        &self,
        _position: Vec3,
        _normal: Vec3,
        _irradiance: Vec3,
        _own: Option<usize>,
    ) -> ObjectInfluence {
        ObjectInfluence::NONE
    }

    /// Diffuse albedo at a hit, linear.
    fn albedo(&self, scene: &Scene, hit: &Hit) -> Vec3 {
        scene.albedo(hit.triangle as usize, hit.barycentric)
    }

    /// Radiance that the front face emits at a hit, W·m⁻²·sr⁻¹, before [`Lighting::emissive_scale`].
    fn emission(&self, scene: &Scene, hit: &Hit) -> Vec3 {
        scene.emission(hit.triangle as usize, hit.barycentric)
    }
}

/// The lightmap of the last frame, under the runtime's present colours.
impl Surfaces for Runtime {
    fn irradiance(&self, hit: &Hit) -> Vec3 {
        match self.baked().lightmap.position(hit.triangle, hit.is_back_face, hit.barycentric) {
            Some(position) => Runtime::irradiance(self).sample(position),
            None => Vec3::ZERO,
        }
    }

    fn irradiance_in_air(&self, position: Vec3, normal: Vec3) -> Vec3 {
        // Of all that is seen, the boxes of objects made the last frame compute it.
        self.grid().irradiance(position, normal).unwrap_or(Vec3::ZERO)
    }

    fn object_influence(
        &self,
        position: Vec3,
        normal: Vec3,
        irradiance: Vec3,
        own: Option<usize>,
    ) -> ObjectInfluence {
        Runtime::object_influence(self, position, normal, irradiance, own)
    }

    fn albedo(&self, scene: &Scene, hit: &Hit) -> Vec3 {
        let texel = scene.base_color_texel(hit.triangle as usize, hit.barycentric).truncate();
        colors(self, scene, hit).map_or(Vec3::ZERO, |colors| colors.base_color * texel)
    }

    fn emission(&self, scene: &Scene, hit: &Hit) -> Vec3 {
        match colors(self, scene, hit) {
            Some(colors) if colors.emission != Vec3::ZERO => {
                colors.emission * scene.emission_texel(hit.triangle as usize, hit.barycentric)
            }
            _ => Vec3::ZERO,
        }
    }
}

fn colors(runtime: &Runtime, scene: &Scene, hit: &Hit) -> Option<SurfaceColors> {
    runtime.surface_colors(scene.triangle_material[hit.triangle as usize] as usize)
}

/// A scene under light, ready to be looked at.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Geometry and materials, and what moves.
    pub world: World<'a>,
    /// Lights, sky and the strength of emissive surfaces.
    pub lighting: &'a Lighting,
    /// Colours and what else surfaces receive.
    pub surfaces: &'a dyn Surfaces,
}

impl<'a> View<'a> {
    /// What the runtime's last frame looks like.
    pub fn of(runtime: &'a Runtime) -> Self {
        Self { world: runtime.world(), lighting: runtime.lighting(), surfaces: runtime }
    }
}

/// Which light a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RenderOutput {
    /// All of it: radiance, W·m⁻²·sr⁻¹.
    #[default]
    Full,
    /// Emission, sky behind the scene, and the direct light of point, spot and directional lights.
    Direct,
    /// Reflected light of the lightmap only, without what surfaces emit; the sky is black.
    Indirect,
    /// For debugging: raw irradiance of the lightmap, W/m², without albedo.
    Irradiance,
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Which light is shown.
    pub output: RenderOutput,
    /// Primary rays per pixel.
    pub samples: u32,
    /// How samples are placed and weighed.
    pub filter: PixelFilter,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { output: RenderOutput::default(), samples: 16, filter: PixelFilter::default() }
    }
}

/// Makes the picture that `camera` sees. The same arguments give the same picture whatever the number of
/// threads. Progress counts rows.
///
/// # Errors
/// [`Cancelled`] if `progress` asked to stop.
pub fn render(
    view: View,
    camera: &Camera,
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Result<Image, Cancelled> {
    let mut image = Image::filled(camera.width, camera.height, Vec3::ZERO);
    progress.begin("render", u64::from(camera.height));
    image.pixels.par_chunks_mut(camera.width.max(1) as usize).enumerate().try_for_each(|(y, row)| {
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = view.pixel(camera, x as u32, y as u32, options);
        }
        progress.advance(1);
        Ok(())
    })?;
    Ok(image)
}

impl View<'_> {
    /// Mean over one pixel's samples, stratified by an Owen-scrambled Sobol sequence of its own.
    fn pixel(&self, camera: &Camera, x: u32, y: u32, options: &RenderOptions) -> Vec3 {
        let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let samples = options.samples.max(1);
        let sum: Vec3 = (0..samples)
            .map(|sample| {
                let offset = options.filter.offset_from_square(sobol_owen(sample, hash_pair(x, y)));
                let direction = camera.ray_direction(center + offset);
                self.arriving(&Ray::new(camera.position, direction), options.output)
            })
            .sum();
        sum / samples as f32
    }

    /// What arrives at the start of one primary ray.
    fn arriving(&self, ray: &Ray, output: RenderOutput) -> Vec3 {
        let Some(WorldHit { hit, object }) = self.world.closest_hit(ray) else {
            return match output {
                RenderOutput::Full | RenderOutput::Direct => self.lighting.sky.radiance(ray.direction),
                RenderOutput::Indirect | RenderOutput::Irradiance => Vec3::ZERO,
            };
        };
        let position = ray.origin + ray.direction * hit.distance;
        let surface = match object {
            Some(index) => self.object_surface(&self.world.objects[index], &hit),
            None => self.scene_surface(&hit),
        };
        let Surface { shading_normal, emission, .. } = surface;
        let direct = || {
            let Self { world, lighting, .. } = self;
            smooth_direct_irradiance(world, &lighting.lights, position, hit.normal, shading_normal)
        };
        let soft = || {
            let irradiance = match object {
                Some(index) => {
                    let offset = self.world.objects[index].light_offset() * hit.normal;
                    self.surfaces.irradiance_in_air(position + offset, shading_normal)
                }
                None => self.surfaces.irradiance(&hit),
            };
            let objects = self.surfaces.object_influence(position, shading_normal, irradiance, object);
            irradiance * objects.left + objects.reflected
        };
        let reflectance = surface.albedo * FRAC_1_PI;
        match output {
            RenderOutput::Full => emission + reflectance * (direct() + soft()),
            RenderOutput::Direct => emission + reflectance * direct(),
            RenderOutput::Indirect => reflectance * soft(),
            RenderOutput::Irradiance => soft(),
        }
    }

    fn scene_surface(&self, hit: &Hit) -> Surface {
        let scene = self.world.tracer.scene();
        let emission = || self.surfaces.emission(scene, hit) * self.lighting.emissive_scale;
        Surface {
            shading_normal: hit.normal,
            albedo: self.surfaces.albedo(scene, hit),
            emission: if hit.is_back_face { Vec3::ZERO } else { emission() },
        }
    }

    fn object_surface(&self, object: &TracedObject, hit: &Hit) -> Surface {
        let (model, triangle) = (object.tracer().scene(), hit.triangle as usize);
        let front = object.placement().direction(model.shading_normal(triangle, hit.barycentric));
        let shading_normal = if hit.is_back_face { -front } else { front };
        let emission = || model.emission(triangle, hit.barycentric) * self.lighting.emissive_scale;
        Surface {
            shading_normal,
            albedo: model.albedo(triangle, hit.barycentric),
            emission: if hit.is_back_face { Vec3::ZERO } else { emission() },
        }
    }
}

/// What a primary ray met.
struct Surface {
    /// World space, unit.
    shading_normal: Vec3,
    /// Linear.
    albedo: Vec3,
    /// Radiance towards the eye, W·m⁻²·sr⁻¹.
    emission: Vec3,
}
