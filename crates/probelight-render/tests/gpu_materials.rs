//! Materials on the GPU whose look is known on paper.
#![cfg(feature = "gpu")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;
mod support;

use std::f32::consts::PI;

use probelight_math::glam::{Vec3, vec3};
use probelight_render::gpu::{GpuView, Shading, ViewOptions};
use probelight_runtime::gpu::GpuDevice;
use probelight_scene::{AlphaMode, Camera, Light, Lighting, Material};
use support::{GpuPictures, baked_cornell_of};

const INTENSITY: Vec3 = vec3(9.0, 6.0, 3.0);

/// Height of lamp and eye above the floor, metres.
const HEIGHT: f32 = 3.0;

/// Radiance of the floor straight below an eye that is a lamp as well, in a Cornell box of one material.
fn radiance_below(gpu: &GpuDevice, material: Material, shading: Shading) -> Vec3 {
    let mut lit = baked_cornell_of(&material);
    let position = vec3(4.6, HEIGHT, 0.8);
    let lamp = Light::Point { position, intensity: INTENSITY, range: None };
    lit.runtime.set_lighting(Lighting { lights: vec![lamp], ..Lighting::default() }).unwrap();
    lit.camera = Camera {
        name: "down".into(),
        position,
        target: position - Vec3::Y,
        up: Vec3::Z,
        vertical_fov: 0.01,
        width: 8,
        height: 8,
    };
    let options = ViewOptions { view: GpuView::Direct, shading };
    GpuPictures::new(gpu, &lit).draw(&lit, options).pixel(4, 4)
}

fn grey(metallic: f32, roughness: f32) -> Material {
    Material { base_color: vec3(0.5, 0.4, 0.3).extend(1.0), metallic, roughness, ..Material::default() }
}

/// What a surface that faces both lamp and eye reflects, 1/sr: there the distribution is 1 / (π α²), masking and
/// shadowing are 1, and Fresnel's reflectance is that straight on.
fn reflectance_straight_on(material: &Material) -> Vec3 {
    let base = material.base_color.truncate();
    let specular = Vec3::splat(0.04).lerp(base, material.metallic);
    let alpha = material.roughness * material.roughness;
    (1.0 - specular) * base * (1.0 - material.metallic) / PI + specular / (4.0 * PI * alpha * alpha)
}

fn agrees(found: Vec3, expected: Vec3) -> bool {
    // Half floats have a relative precision of 0.05 %; the pixel is a little wide.
    (found / expected - 1.0).abs().max_element() < 5e-3
}

#[test]
fn highlights_follow_their_formula() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let irradiance = INTENSITY / (HEIGHT * HEIGHT);
    for (metallic, roughness) in [(0.0, 1.0), (0.0, 0.5), (1.0, 0.7), (0.5, 0.6)] {
        let material = grey(metallic, roughness);
        let expected = irradiance * reflectance_straight_on(&material);
        let found = radiance_below(gpu, material.clone(), Shading::Physical);
        assert!(agrees(found, expected), "{metallic}, {roughness}: {found}, not {expected}");
        let diffuse = radiance_below(gpu, material.clone(), Shading::Diffuse);
        assert!(agrees(diffuse, irradiance * material.base_color.truncate() / PI), "{diffuse}");
        assert!(!agrees(found, diffuse), "the comparison must tell the two apart");
    }
}

#[test]
fn masked_surfaces_are_there_where_alpha_reaches_the_cutoff() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let masked = |alpha: f32| Material {
        base_color: Vec3::splat(0.5).extend(alpha),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..grey(0.0, 1.0)
    };
    assert_eq!(radiance_below(gpu, masked(0.4), Shading::Diffuse), Vec3::ZERO);
    let expected = INTENSITY / (HEIGHT * HEIGHT) * 0.5 / PI;
    let found = radiance_below(gpu, masked(0.6), Shading::Diffuse);
    assert!(agrees(found, expected), "{found}, not {expected}");
}
