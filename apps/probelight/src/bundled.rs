//! The scenes that come with the program, each with a light that moves.

use std::path::Path;
use std::sync::Arc;

use clap::ValueEnum;
use probelight_bake::BakeOptions;
use probelight_math::glam::{Vec3, vec3};
use probelight_scene::{Camera, Light, Lighting, Placement, Scene, Sky, parse_gltf};

/// A scene inside the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BundledScene {
    /// A courtyard with two storeys of arcades; the sun crosses the sky
    #[default]
    Atrium,
    /// A building of five rooms; the sun comes in through the openings of the first
    Rooms,
    /// The Cornell box; a lamp moves under the ceiling
    Cornell,
}

/// One position of the moving light.
pub(crate) struct LightPosition {
    /// For people.
    pub(crate) name: String,
    /// All light of that moment.
    pub(crate) lighting: Lighting,
}

impl BundledScene {
    /// What the scene is called in file names.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Atrium => "atrium",
            Self::Rooms => "rooms",
            Self::Cornell => "cornell",
        }
    }

    fn glb(self) -> &'static [u8] {
        match self {
            Self::Atrium => include_bytes!("../../../assets/scenes/atrium.glb"),
            Self::Rooms => include_bytes!("../../../assets/scenes/rooms.glb"),
            Self::Cornell => include_bytes!("../../../assets/scenes/cornell.glb"),
        }
    }

    /// Reads the scene.
    pub(crate) fn load(self) -> anyhow::Result<Arc<Scene>> {
        let path = format!("{}.glb", self.name());
        Ok(Arc::new(parse_gltf(self.glb(), Path::new(&path))?))
    }

    /// The ball that moves along with the light: its model.
    pub(crate) fn ball() -> anyhow::Result<Arc<Scene>> {
        Ok(Arc::new(parse_gltf(Self::ball_glb(), Path::new("ball.glb"))?))
    }

    /// Its file.
    pub(crate) fn ball_glb() -> &'static [u8] {
        include_bytes!("../../../assets/objects/ball.glb")
    }

    /// Where the ball is in each position of the light.
    pub(crate) fn ball_path(self) -> [Placement; 4] {
        let (places, scale): ([Vec3; 4], f32) = match self {
            Self::Atrium => (
                [vec3(-8.5, 0.0, 2.2), vec3(-7.5, 0.0, 0.9), vec3(-8.0, 0.0, -0.6), vec3(-9.0, 0.0, -2.0)],
                1.6,
            ),
            Self::Rooms => {
                ([vec3(2.0, 0.0, 3.2), vec3(2.7, 0.0, 2.9), vec3(3.5, 0.0, 2.6), vec3(4.3, 0.0, 2.2)], 1.0)
            }
            Self::Cornell => {
                ([vec3(1.0, 0.0, 0.7), vec3(1.9, 0.0, 0.5), vec3(3.4, 0.0, 0.7), vec3(4.6, 0.0, 1.2)], 1.5)
            }
        };
        let mut turn = 0.0;
        places.map(|translation| {
            turn += 0.9;
            Placement::upright(translation, turn, scale)
        })
    }

    /// Settings that bring the demo's first picture within half a minute on two cores.
    pub(crate) fn bake_options(self) -> BakeOptions {
        let (receivers, gather_rays) = match self {
            Self::Atrium => (20_000, 128),
            Self::Rooms => (40_000, 512),
            Self::Cornell => (12_000, 1024),
        };
        BakeOptions {
            receivers: Some(receivers),
            gather_rays: Some(gather_rays),
            grid_vertices: Some(2_000),
            ..BakeOptions::default()
        }
    }

    /// Paths per pixel of the reference pictures.
    pub(crate) fn reference_samples(self) -> u32 {
        match self {
            Self::Atrium => 72,
            Self::Rooms => 64,
            Self::Cornell => 128,
        }
    }

    /// Where the pictures are taken from.
    pub(crate) fn camera(self) -> Camera {
        let (position, target, vertical_degrees, width, height): (Vec3, Vec3, f32, u32, u32) = match self {
            Self::Atrium => (vec3(-12.0, 1.7, 0.0), vec3(4.0, 3.6, 0.0), 60.0, 320, 240),
            Self::Rooms => (vec3(0.6, 1.6, 4.4), vec3(5.8, 1.2, 1.2), 65.0, 320, 240),
            Self::Cornell => (vec3(2.78, 2.73, -8.0), vec3(2.78, 2.73, 0.0), 39.3, 256, 256),
        };
        let vertical_fov = vertical_degrees.to_radians();
        Camera { name: "demo".into(), position, target, up: Vec3::Y, vertical_fov, width, height }
    }

    /// The path of the light, in order. Emissive surfaces are off.
    pub(crate) fn light_path(self) -> Vec<LightPosition> {
        match self {
            Self::Atrium => {
                let sky = vec3(0.6, 0.9, 1.5);
                [(0.9, 0.35, 7.0), (0.35, 0.3, 1.0), (-0.3, 0.42, 0.5), (-0.85, 0.25, 6.0)]
                    .map(|(x, z, warmth)| sun(vec3(x, -1.0, z), warmth, sky))
                    .into()
            }
            Self::Rooms => {
                let sky = vec3(0.4, 0.55, 0.8);
                [(-0.6, -0.5, 4.0), (-0.1, -0.8, 1.0), (0.35, -0.75, 1.0), (0.9, -0.5, 4.0)]
                    .map(|(x, y, warmth)| sun(vec3(x, y, 0.7), warmth, sky))
                    .into()
            }
            Self::Cornell => [(0.7, 3.4), (2.0, 4.4), (3.6, 4.4), (4.8, 1.2)]
                .map(|(x, y)| lamp(vec3(x, y, 1.6), vec3(12.0, 11.0, 9.0)))
                .into(),
        }
    }
}

/// The sun shining along `direction`, redder the larger `warmth`, in a uniform sky.
fn sun(direction: Vec3, warmth: f32, sky: Vec3) -> LightPosition {
    let direction = direction.normalize();
    let irradiance = 20.0 * vec3(1.0, 0.93 - 0.04 * warmth, 0.8 - 0.07 * warmth);
    let elevation = (-direction.y).asin().to_degrees();
    let side = if direction.x > 0.0 { "from the left" } else { "from the right" };
    LightPosition {
        name: format!("sun {elevation:.0} degrees high, {side}"),
        lighting: Lighting {
            lights: vec![Light::Directional { direction, irradiance }],
            sky: Sky::Uniform(sky),
            emissive_scale: 0.0,
        },
    }
}

/// A lamp that shines in all directions.
fn lamp(position: Vec3, intensity: Vec3) -> LightPosition {
    LightPosition {
        name: format!("lamp at ({:.1}, {:.1}, {:.1}) m", position.x, position.y, position.z),
        lighting: Lighting {
            lights: vec![Light::Point { position, intensity, range: None }],
            sky: Sky::default(),
            emissive_scale: 0.0,
        },
    }
}
