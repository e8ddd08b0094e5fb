//! Emissive surfaces, each a signal of its own.
//!
//! Gather rays find a small emitter rarely, which leaves grain. So its column holds form factors
//! ([`super::form_factors`]) of the patches that it is divided into.

use probelight_asset::{Emitter, NONE};
use probelight_math::glam::{Vec2, Vec3, vec2};
use probelight_math::sampling::{choose_by_running_sum, hash_pair, sobol_owen, triangle_from_square};
use probelight_scene::{Bounds, Scene};
use probelight_trace::Hit;

/// Patches are split until they are this wide, as a multiple of a surfel's width.
const WIDTHS_PER_PATCH: f32 = 4.0;

/// The emissive surfaces of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Emitters {
    /// The signals: one for each material, or for each patch where a texture varies the emission.
    pub(crate) signals: Vec<Emitter>,
    pub(crate) patches: Vec<EmitterPatch>,
    /// Patch of each triangle, or [`NONE`].
    pub(crate) patch_of_triangle: Vec<u32>,
}

/// Emissive triangles near each other.
#[derive(Clone, Debug)]
pub(crate) struct EmitterPatch {
    pub(crate) signal: u32,
    pub(crate) triangles: Vec<u32>,
    /// Running sum of the triangles' areas, m².
    pub(crate) areas: Vec<f32>,
    pub(crate) bounds: Bounds,
}

impl EmitterPatch {
    pub(crate) fn area(&self) -> f32 {
        self.areas.last().copied().unwrap_or(0.0)
    }
}

impl Emitters {
    /// Finds the emissive surfaces; patches are a few surfels wide.
    pub(crate) fn find(scene: &Scene, surfel_size: f32) -> Self {
        let mut emitters = Self { patch_of_triangle: vec![NONE; scene.triangles.len()], ..Self::default() };
        for (m, material) in scene.materials.iter().enumerate() {
            if material.emission == Vec3::ZERO {
                continue;
            }
            let triangles: Vec<u32> = (0..scene.triangles.len() as u32)
                .filter(|t| {
                    scene.triangle_material[*t as usize] as usize == m && scene.area(*t as usize) > 0.0
                })
                .collect();
            if triangles.is_empty() {
                continue;
            }
            let is_textured = material.emissive_texture.is_some();
            if !is_textured {
                emitters.signals.push(Emitter { material: m as u32, mean_texel: Vec3::ONE });
            }
            emitters.add_patches(scene, triangles, WIDTHS_PER_PATCH * surfel_size, is_textured, m as u32);
        }
        emitters
    }

    fn add_patches(
        &mut self,
        scene: &Scene,
        triangles: Vec<u32>,
        width: f32,
        is_textured: bool,
        material: u32,
    ) {
        let bounds = Bounds::of(triangles.iter().flat_map(|t| scene.corners(*t as usize)));
        let size = bounds.size();
        if triangles.len() > 1 && size.max_element() > width {
            let axis = if size.x >= size.y.max(size.z) {
                0
            } else if size.y >= size.z {
                1
            } else {
                2
            };
            let middle = |t: &u32| scene.corners(*t as usize).iter().map(|c| c[axis]).sum::<f32>();
            let mut sorted = triangles;
            sorted.sort_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
            let upper = sorted.split_off(sorted.len() / 2);
            self.add_patches(scene, sorted, width, is_textured, material);
            self.add_patches(scene, upper, width, is_textured, material);
            return;
        }
        if is_textured {
            let mean_texel = mean_emission_texel(scene, &triangles);
            if mean_texel == Vec3::ZERO {
                return;
            }
            self.signals.push(Emitter { material, mean_texel });
        }
        for t in &triangles {
            self.patch_of_triangle[*t as usize] = self.patches.len() as u32;
        }
        let areas = triangles
            .iter()
            .scan(0.0, |sum, t| {
                *sum += scene.area(*t as usize);
                Some(*sum)
            })
            .collect();
        self.patches.push(EmitterPatch { signal: self.signals.len() as u32 - 1, triangles, areas, bounds });
    }

    /// The signal of a triangle's front face, if it is emissive.
    pub(crate) fn signal_of_triangle(&self, triangle: u32) -> Option<u32> {
        Some(self.patches.get(*self.patch_of_triangle.get(triangle as usize)? as usize)?.signal)
    }

    /// The signal of what a ray hit, if that is emissive.
    pub(crate) fn signal_of_hit(&self, hit: &Hit) -> Option<u32> {
        if hit.is_back_face { None } else { self.signal_of_triangle(hit.triangle) }
    }
}

impl EmitterPatch {
    /// A point of the patch, uniform by area: triangle and barycentric weights.
    pub(crate) fn point(&self, u: Vec2) -> (u32, Vec2) {
        let (chosen, rest) = choose_by_running_sum(&self.areas, u.x);
        (self.triangles[chosen], triangle_from_square(vec2(rest, u.y)))
    }
}

/// Mean emissive texel over triangles, by area; a few hundred lookups.
fn mean_emission_texel(scene: &Scene, triangles: &[u32]) -> Vec3 {
    let per_triangle = (1024 / triangles.len()).clamp(4, 256) as u32;
    let (sum, total) = triangles.iter().fold((Vec3::ZERO, 0.0), |(sum, total), t| {
        let area = scene.area(*t as usize);
        let mean: Vec3 = (0..per_triangle)
            .map(|i| {
                scene.emission_texel(*t as usize, triangle_from_square(sobol_owen(i, hash_pair(*t, 71))))
            })
            .sum::<Vec3>()
            / per_triangle as f32;
        (sum + mean * area, total + area)
    });
    sum / f32::max(total, f32::MIN_POSITIVE)
}
