//! What a picture shows.

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum GpuView {
    /// All light: radiance, W·m⁻²·sr⁻¹.
    #[default]
    Full = 0,
    /// Emission, sky behind the scene, and the direct light of point, spot and directional lights.
    Direct = 1,
    /// Reflected light of the lightmap only; the sky is black.
    Indirect = 2,
    /// Raw irradiance of the lightmap, W/m², without albedo.
    Irradiance = 3,
    /// Base colours, linear.
    Albedo = 4,
    /// Shading normals, from −1 … 1 to 0 … 1.
    Normals = 5,
    /// The lightmap's texels as they are, W/m², every second one darker; blue where a side has no light of its own.
    LightmapTexels = 6,
    /// A colour for each cluster of receivers.
    Clusters = 7,
    /// Probes as white spheres in their own light, in the scene at three tenths of its brightness.
    Probes = 8,
    /// Points where light is evaluated, as discs as bright as their surfels, in the scene at three tenths of its
    /// brightness.
    LightSamples = 9,
}

impl GpuView {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Full,
        Self::Direct,
        Self::Indirect,
        Self::Irradiance,
        Self::Albedo,
        Self::Normals,
        Self::LightmapTexels,
        Self::Clusters,
        Self::Probes,
        Self::LightSamples,
    ];

    /// Whether pixels are light, which needs an exposure, and not colours from 0 to 1.
    pub fn is_light(self) -> bool {
        !matches!(self, Self::Albedo | Self::Normals | Self::Clusters)
    }

    /// Whether the sky is seen behind the scene.
    pub(super) fn has_sky(self) -> bool {
        matches!(self, Self::Full | Self::Direct | Self::Probes | Self::LightSamples)
    }
}

/// How surfaces reflect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Shading {
    /// As the CPU's renderer and the path tracer have it: Lambertian, with geometric normals.
    #[default]
    Diffuse = 0,
    /// glTF's metallic-roughness model with normal maps.
    Physical = 1,
}

/// What a picture shows, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewOptions {
    /// What it shows.
    pub view: GpuView,
    /// How surfaces reflect light.
    pub shading: Shading,
}
