//! Quick bakes of the bundled scenes.
#![allow(dead_code, reason = "each test binary uses a part")]

pub(crate) mod grid;
pub(crate) mod shapes;

use std::path::PathBuf;
use std::sync::Arc;

use probelight_asset::{BakedScene, Method};
use probelight_bake::{BakeOptions, bake};
use probelight_scene::{Scene, load_gltf};
use probelight_trace::Silent;

pub(crate) const METHODS: [Method; 2] = [Method::Paper, Method::Hybrid];

pub(crate) fn load(name: &str) -> Arc<Scene> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name);
    Arc::new(load_gltf(&path).unwrap())
}

/// Coarse settings, for a bake of about a second.
pub(crate) fn quick(method: Method) -> BakeOptions {
    BakeOptions {
        method: Some(method),
        receivers: Some(1500),
        gather_rays: Some(64),
        relight_rays: Some(64),
        sh_degree: Some(4),
        grid_vertices: Some(0),
        ..BakeOptions::default()
    }
}

pub(crate) fn quick_bake(name: &str, method: Method) -> BakedScene {
    bake(load(name), &quick(method), None, &Silent).unwrap()
}
