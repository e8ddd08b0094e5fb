//! A scene flattened to world space.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{Vec2, Vec3, Vec4};

use crate::{Camera, Light, Material, SceneError, Sources, Texture, Warning};

/// Triangles, materials, lights and cameras in world space (right-handed, +Y up, metres).
///
/// Instances are flattened: each has its own triangles, because each has its own light. Counter-clockwise
/// triangles face the viewer; the geometric normal is `cross(p1 − p0, p2 − p0)`, also under mirroring
/// node transforms.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per vertex.
    pub normals: Vec<Vec3>,
    /// Unit tangents (xyz) and bitangent sign (w), one per vertex (MikkTSpace).
    pub tangents: Vec<Vec4>,
    /// Texture coordinates 0, one per vertex; zero where the file has none.
    pub uv0: Vec<Vec2>,
    /// Texture coordinates 1, one per vertex, or empty if no mesh has any.
    pub uv1: Vec<Vec2>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials`, one per triangle.
    pub triangle_material: Vec<u32>,
    /// Which object of the file each triangle comes from.
    pub sources: Sources,
    /// At least one material.
    pub materials: Vec<Material>,
    /// Decoded images.
    pub textures: Vec<Texture>,
    /// Analytic lights of the file (`KHR_lights_punctual`).
    pub lights: Vec<Light>,
    /// Cameras of the file.
    pub cameras: Vec<Camera>,
    /// What was repaired or left out while reading.
    pub warnings: Vec<Warning>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Bounds {
    /// Smallest corner, metres.
    pub min: Vec3,
    /// Largest corner, metres.
    pub max: Vec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    /// Contains nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Edge lengths, metres.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }

    /// Length of the space diagonal, metres.
    pub fn diagonal(&self) -> f32 {
        self.size().length()
    }

    /// Whether `point` lies inside or on the border.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Distance from `point` to the box, 0 inside.
    pub fn distance(&self, point: Vec3) -> f32 {
        (point - point.clamp(self.min, self.max)).length()
    }
}

impl Scene {
    /// World positions of a triangle's corners.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Unit geometric normal of a triangle's front face.
    #[inline]
    pub fn geometric_normal(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize_or(Vec3::Y)
    }

    /// Unit normal inside a triangle between those of its corners, at barycentric weights of its second and third corner.
    pub fn shading_normal(&self, triangle: usize, barycentric: Vec2) -> Vec3 {
        let [a, b, c] = self.triangles[triangle].map(|v| self.normals[v as usize]);
        let between = a + (b - a) * barycentric.x + (c - a) * barycentric.y;
        between.normalize_or(self.geometric_normal(triangle))
    }

    /// Area of a triangle, m².
    pub fn area(&self, triangle: usize) -> f32 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// World position inside a triangle, metres, at barycentric weights of its second and third corner.
    #[inline]
    pub fn position(&self, triangle: usize, barycentric: Vec2) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        a + (b - a) * barycentric.x + (c - a) * barycentric.y
    }

    /// The material of a triangle.
    #[inline]
    pub fn material(&self, triangle: usize) -> &Material {
        &self.materials[self.triangle_material[triangle] as usize]
    }

    /// Texture coordinates of set 0 or 1 inside a triangle, at barycentric weights of its second and third
    /// corner.
    #[inline]
    pub fn uv(&self, triangle: usize, barycentric: Vec2, set: u32) -> Vec2 {
        let uvs = if set == 1 && !self.uv1.is_empty() { &self.uv1 } else { &self.uv0 };
        let [a, b, c] = self.triangles[triangle].map(|v| uvs[v as usize]);
        a + (b - a) * barycentric.x + (c - a) * barycentric.y
    }

    /// The base colour texture's share of the albedo, without the material's factor; white without texture.
    pub fn base_color_texel(&self, triangle: usize, barycentric: Vec2) -> Vec4 {
        let Some(slot) = self.material(triangle).base_color_texture else { return Vec4::ONE };
        self.textures[slot.texture as usize].sample_srgb(self.uv(triangle, barycentric, slot.tex_coord))
    }

    /// Diffuse albedo of a surface point: factor times texture, linear.
    pub fn albedo(&self, triangle: usize, barycentric: Vec2) -> Vec3 {
        (self.material(triangle).base_color * self.base_color_texel(triangle, barycentric)).truncate()
    }

    /// The emissive texture's share of the emission; white without texture.
    pub fn emission_texel(&self, triangle: usize, barycentric: Vec2) -> Vec3 {
        let Some(slot) = self.material(triangle).emissive_texture else { return Vec3::ONE };
        self.textures[slot.texture as usize]
            .sample_srgb(self.uv(triangle, barycentric, slot.tex_coord))
            .truncate()
    }

    /// Emitted radiance of a surface point's front face, W·m⁻²·sr⁻¹.
    pub fn emission(&self, triangle: usize, barycentric: Vec2) -> Vec3 {
        let emission = self.material(triangle).emission;
        if emission == Vec3::ZERO {
            return emission;
        }
        emission * self.emission_texel(triangle, barycentric)
    }

    /// Triangles that may emit light: those whose material has emission.
    pub fn emissive_triangles(&self) -> Vec<u32> {
        let emits: Vec<bool> = self.materials.iter().map(|m| m.emission != Vec3::ZERO).collect();
        let materials = self.triangle_material.iter().enumerate();
        materials.filter(|(_, m)| emits[**m as usize]).map(|(t, _)| t as u32).collect()
    }

    /// The smallest box around all triangles.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.positions.iter().copied())
    }

    /// Sum of all triangles' areas, m².
    pub fn surface_area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| f64::from(self.area(t))).sum()
    }

    /// Checks what the rest of Probelight relies on. Readers call it last; call it after building a scene
    /// by hand.
    ///
    /// # Errors
    /// Names the first array whose length is wrong, index out of range, value that is not finite, or
    /// triangle without area; that the table of sources does not fit; or that there is no triangle at all.
    pub fn validate(&self) -> Result<(), SceneError> {
        let fail = |reason: String| Err(SceneError::Invalid { reason });
        let vertices = self.positions.len();
        for (name, length) in
            [("normals", self.normals.len()), ("tangents", self.tangents.len()), ("uv0", self.uv0.len())]
        {
            if length != vertices {
                return fail(format!("{length} {name} for {vertices} positions"));
            }
        }
        if !self.uv1.is_empty() && self.uv1.len() != vertices {
            return fail(format!("{} uv1 for {vertices} positions", self.uv1.len()));
        }
        if self.triangle_material.len() != self.triangles.len() {
            return fail("each triangle needs a material".into());
        }
        if self.triangles.is_empty() {
            return fail("it has no triangles with area".into());
        }
        for (v, position) in self.positions.iter().enumerate() {
            let finite = position.is_finite()
                && self.normals[v].is_finite()
                && self.tangents[v].is_finite()
                && self.uv0[v].is_finite()
                && self.uv1.get(v).is_none_or(|uv| uv.is_finite());
            if !finite {
                return fail(format!("vertex {v} has a value that is not finite"));
            }
        }
        for (t, corners) in self.triangles.iter().enumerate() {
            if corners.iter().any(|c| *c as usize >= vertices) {
                return fail(format!("triangle {t} uses a vertex that does not exist"));
            }
            if self.triangle_material[t] as usize >= self.materials.len() {
                return fail(format!("triangle {t} uses a material that does not exist"));
            }
            let area = self.area(t);
            if !area.is_finite() || area <= 0.0 {
                return fail(format!("triangle {t} has no area, or more than a number can hold"));
            }
        }
        self.sources.validate(self.triangles.len())?;
        self.validate_materials()
    }

    fn validate_materials(&self) -> Result<(), SceneError> {
        let fail = |reason: String| Err(SceneError::Invalid { reason });
        for (m, material) in self.materials.iter().enumerate() {
            let mut slots = material.texture_slots().into_iter().flatten();
            if slots.any(|slot| slot.texture as usize >= self.textures.len()) {
                return fail(format!("material {m} uses a texture that does not exist"));
            }
            if !(material.base_color.is_finite() && material.emission.is_finite()) {
                return fail(format!("material {m} has a factor that is not finite"));
            }
        }
        for (t, texture) in self.textures.iter().enumerate() {
            let texels = u64::from(texture.width) * u64::from(texture.height);
            if texels == 0 || texels.checked_mul(4) != Some(texture.rgba8.len() as u64) {
                return fail(format!("texture {t} does not hold {texels} texels"));
            }
        }
        Ok(())
    }
}
