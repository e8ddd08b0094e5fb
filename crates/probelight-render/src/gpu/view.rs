//! What a picture shows.

/// The one list of what pictures can show: the name, the number that shaders know it by, what it is.
macro_rules! views {
    ($($(#[doc = $documentation:literal])+ $view:ident = $number:literal $name:literal,)*) => {
        /// What a picture shows.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[repr(u32)]
        pub enum GpuView {
            #[default]
            $($(#[doc = $documentation])+ $view = $number,)*
        }

        impl GpuView {
            /// All of them.
            pub const ALL: [Self; [$($number),*].len()] = [$(Self::$view),*];

            /// Its name, in small letters with hyphens.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$view => $name,)* }
            }

            /// What it is, in a sentence.
            pub fn description(self) -> &'static str {
                match self { $(Self::$view => concat!($($documentation),+).trim(),)* }
            }
        }
    };
}

views! {
    /// All light: radiance, W·m⁻²·sr⁻¹.
    Full = 0 "full",
    /// Emission, sky behind the scene, and the direct light of point, spot and directional lights.
    Direct = 1 "direct",
    /// Reflected light of the lightmap only: bounced light, sky light, light of emissive surfaces; the sky is black.
    Indirect = 2 "indirect",
    /// Raw irradiance of the lightmap, W/m², without albedo; as bumps have it if these are shown.
    Irradiance = 3 "irradiance",
    /// Base colours, linear.
    Albedo = 4 "albedo",
    /// Shading normals, from −1 … 1 to 0 … 1.
    Normals = 5 "normals",
    /// The lightmap's texels as they are, W/m², every second one darker; blue where a side has no light of its own.
    LightmapTexels = 6 "lightmap-texels",
    /// A colour for each cluster of receivers.
    Clusters = 7 "clusters",
    /// Probes as white spheres in their own light, in the scene at three tenths of its brightness.
    Probes = 8 "probes",
    /// Points where light is evaluated, as discs as bright as their surfels, in the scene at three tenths of its
    /// brightness.
    LightSamples = 9 "light-samples",
}

impl GpuView {
    /// The one with a [name](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|view| view.name() == name)
    }

    /// Whether pixels are light, which needs an exposure, and not colours from 0 to 1.
    pub fn is_light(self) -> bool {
        !matches!(self, Self::Albedo | Self::Normals | Self::Clusters)
    }

    /// Whether light other than that of the analytic lights is seen.
    pub(super) fn has_soft_light(self) -> bool {
        use GpuView::{Full, Indirect, Irradiance, LightSamples, Probes};
        matches!(self, Full | Indirect | Irradiance | Probes | LightSamples)
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
    /// glTF's metallic-roughness model with normal maps. Of scenes with a grid, surfaces of the scene take the light that
    /// bumps and gloss show from it, as objects do; else light other than that of lamps counts as coming evenly from all
    /// sides.
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
