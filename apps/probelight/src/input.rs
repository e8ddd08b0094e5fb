//! Input files, and the choices that depend on what they hold.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, bail};
use probelight_asset::BakedScene;
use probelight_bake::BakeOptions;
use probelight_runtime::gpu::GpuRuntime;
use probelight_runtime::{Convergence, Runtime, SurfaceColors};
use probelight_scene::{Camera, CameraPath, Scene, Setup, load_gltf};

use crate::console::Console;

/// Whether a file name is that of a glTF scene; anything else is taken for a baked file.
pub(crate) fn is_scene(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    matches!(extension.as_deref(), Some("glb" | "gltf"))
}

/// Reads a scene and warns of what was repaired or left out.
pub(crate) fn load_scene(path: &Path, console: &Console) -> anyhow::Result<Arc<Scene>> {
    let scene = load_gltf(path)?;
    warn_of(&scene, path, console);
    Ok(Arc::new(scene))
}

/// Warns of what was repaired or left out of a file.
pub(crate) fn warn_of(scene: &Scene, path: &Path, console: &Console) {
    for warning in &scene.warnings {
        console.warn(format!("{}: {warning}", path.display()));
    }
}

/// Reads a setup file, or makes a setup of the scene's own lights and cameras where none is given.
pub(crate) fn load_setup(path: Option<&Path>, scene: &Scene) -> anyhow::Result<Setup> {
    match path {
        Some(path) => Ok(Setup::load(path)?),
        None => Ok(Setup::from_scene(scene)),
    }
}

/// Bake settings that trade accuracy for seconds, for a scene that is rendered without a baked file.
pub(crate) fn quick_bake_options() -> BakeOptions {
    BakeOptions {
        receivers: Some(20_000),
        gather_rays: Some(128),
        relight_rays: Some(256),
        sh_degree: Some(5),
        max_rank: Some(16),
        grid_vertices: Some(1_500),
        ..BakeOptions::default()
    }
}

/// Reads a baked file, or bakes a scene in memory with [`quick_bake_options`].
pub(crate) fn load_or_bake(path: &Path, console: &Console) -> anyhow::Result<Arc<BakedScene>> {
    if !is_scene(path) {
        return Ok(Arc::new(BakedScene::read(path)?));
    }
    let scene = load_scene(path, console)?;
    console.note(format!(
        "{} is not baked yet: baking it in memory with quick settings; `probelight bake` does it well and once",
        path.display()
    ));
    Ok(Arc::new(probelight_bake::bake(scene, &quick_bake_options(), None, console)?))
}

/// The materials that a setup colours, and their colours. Warns of names that the scene does not have.
fn changed_materials(setup: &Setup, scene: &Scene, console: &Console) -> Vec<(usize, SurfaceColors)> {
    warn_of_unknown_materials(setup, scene, console);
    let was = SurfaceColors::of(scene);
    let colors = SurfaceColors::changed(scene, &setup.materials);
    let changed = colors.into_iter().enumerate().filter(|(material, colors)| was[*material] != *colors);
    changed.collect()
}

/// The scene in the colours of a setup.
pub(crate) fn colored(setup: &Setup, scene: &Scene) -> Scene {
    let mut colored = scene.clone();
    setup.materials.iter().for_each(|colors| colors.apply(&mut colored));
    colored
}

/// Warns of colours for materials that the scene does not have.
pub(crate) fn warn_of_unknown_materials(setup: &Setup, scene: &Scene, console: &Console) {
    for colors in setup.materials.iter().filter(|colors| colors.materials(scene).next().is_none()) {
        console
            .warn(format!("the setup colours the material {:?}, which the scene does not have", colors.name));
    }
}

/// Largest relative change of the last bounce that still counts as converged.
const CONVERGED: f64 = 1e-3;
/// Bounces after which convergence is given up: enough for albedo 0.97.
const MAX_BOUNCES: usize = 200;

/// Lets the setup's light bounce until nothing changes any more; returns the number of bounces.
pub(crate) fn light(runtime: &mut Runtime, setup: &Setup, console: &Console) -> anyhow::Result<usize> {
    runtime.set_lighting(setup.lighting.clone())?;
    let scene = Arc::clone(&runtime.baked().scene);
    for (material, colors) in changed_materials(setup, &scene, console) {
        runtime.set_base_color(material, colors.base_color)?;
        runtime.set_emission(material, colors.emission)?;
    }
    Ok(settle(runtime, console))
}

/// Lets the present light bounce until nothing changes any more; returns the number of bounces.
pub(crate) fn settle(runtime: &mut Runtime, console: &Console) -> usize {
    note_convergence(runtime.converge(CONVERGED, MAX_BOUNCES), console)
}

/// As [`light`], on a GPU.
pub(crate) fn light_on_gpu(
    runtime: &mut GpuRuntime,
    setup: &Setup,
    console: &Console,
) -> anyhow::Result<usize> {
    runtime.set_lighting(setup.lighting.clone())?;
    let scene = Arc::clone(&runtime.baked().scene);
    for (material, colors) in changed_materials(setup, &scene, console) {
        runtime.set_base_color(material, colors.base_color)?;
        runtime.set_emission(material, colors.emission)?;
    }
    settle_on_gpu(runtime, console)
}

/// As [`settle`], on a GPU.
pub(crate) fn settle_on_gpu(runtime: &mut GpuRuntime, console: &Console) -> anyhow::Result<usize> {
    Ok(note_convergence(runtime.converge(CONVERGED, MAX_BOUNCES)?, console))
}

/// Says if light was still changing at the end; returns the number of bounces.
fn note_convergence(convergence: Convergence, console: &Console) -> usize {
    if convergence.change > CONVERGED {
        console.note(format!(
            "light was still changing by {:.1e} after {MAX_BOUNCES} bounces",
            convergence.change
        ));
    }
    convergence.steps
}

/// The camera called `name`, or the first; with another image size if one is given.
pub(crate) fn choose_camera(
    setup: &Setup,
    name: Option<&str>,
    size: Option<(u32, u32)>,
) -> anyhow::Result<Camera> {
    let camera = setup.camera(name)?;
    let (width, height) = size.unwrap_or((camera.width, camera.height));
    Ok(Camera { width, height, ..camera.clone() })
}

/// The way past a setup file's cameras, with pictures of that size.
pub(crate) fn load_camera_path(path: &Path, size: (u32, u32)) -> anyhow::Result<CameraPath> {
    let mut cameras = Setup::load(path)?.cameras;
    for camera in &mut cameras {
        (camera.width, camera.height) = size;
    }
    CameraPath::new(&cameras).with_context(|| format!("{}: there is no camera to pass", path.display()))
}

/// Parses `WIDTHxHEIGHT`.
pub(crate) fn parse_size(text: &str) -> anyhow::Result<(u32, u32)> {
    let (width, height) = text.split_once('x').context("expected WIDTHxHEIGHT, for example 640x480")?;
    let side = |text: &str| match text.parse::<u32>() {
        Ok(side @ 1..=16_384) => Ok(side),
        _ => bail!("{text:?} is not a number of pixels from 1 to 16384"),
    };
    Ok((side(width)?, side(height)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_positive_numbers() {
        assert_eq!(parse_size("640x480").unwrap(), (640, 480));
        for wrong in ["640", "0x5", "5x", "-1x5", "99999x5", "5x5x5"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn scenes_are_told_by_their_name() {
        assert!(is_scene(Path::new("a/b.GLB")) && is_scene(Path::new("b.gltf")));
        assert!(!is_scene(Path::new("b.plight")) && !is_scene(Path::new("glb")));
    }
}
