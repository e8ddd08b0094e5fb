//! The first steps of a bake of a bundled scene, for tests of the later ones.

use std::path::Path;
use std::sync::Arc;

use probelight_scene::load_gltf;
use probelight_trace::Silent;

use crate::BakeOptions;
use crate::ground::{Groundwork, prepare};
use crate::light::SceneLight;
use crate::transport::gather::{GatherRay, gather_rays};

/// A scene that is ready for its groups to be baked.
pub(crate) struct SmallScene {
    pub(crate) ground: Groundwork,
    pub(crate) light: SceneLight,
}

impl SmallScene {
    /// `assets/scenes/NAME` with about 1500 receivers.
    pub(crate) fn load(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name);
        let options = BakeOptions {
            receivers: Some(1500),
            relight_rays: Some(64),
            sh_degree: Some(2),
            ..BakeOptions::default()
        };
        let ground = prepare(Arc::new(load_gltf(&path).unwrap()), &options, &Silent).unwrap();
        let light = SceneLight::prepare(&ground, &Silent).unwrap();
        Self { ground, light }
    }

    /// Gather rays of a receiver.
    pub(crate) fn gather(&self, receiver: u32, rays: u32) -> Vec<GatherRay> {
        gather_rays(&self.ground.tracer, &self.ground.place(receiver), rays, 0).concat()
    }
}
