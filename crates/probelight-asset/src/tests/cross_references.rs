//! Each promise that the runtime relies on, broken once.

use half::f16;
use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::Light;

use super::fixture::baked_scene;
use crate::BakedScene;

/// Breaks the fixture and expects a refusal that contains `words`.
#[track_caller]
fn refused(words: &str, break_it: impl FnOnce(&mut BakedScene)) {
    let mut baked = baked_scene();
    baked.validate().expect("the fixture is valid");
    break_it(&mut baked);
    let reason = baked.validate().expect_err("a broken scene was accepted").to_string();
    assert!(reason.contains(words), "{reason}");
}

#[test]
fn scene_is_checked() {
    refused("triangle 1 uses a vertex", |b| b.scene.triangles[1][2] = 4);
    refused("material 1 uses a texture", |b| b.scene.textures.truncate(1));
    refused("material 1 has a factor", |b| b.scene.materials[1].roughness = f32::NAN);
    refused("light 0", |b| {
        b.scene.lights[0] = Light::Point { position: Vec3::ZERO, intensity: Vec3::INFINITY };
    });
    refused("camera 0", |b| b.scene.cameras[0].vertical_fov = f32::INFINITY);
}

#[test]
fn settings_and_report_are_checked() {
    refused("degree 33", |b| b.settings.sh_degree = 33);
    refused("settings", |b| b.settings.probe_spacing = f32::NAN);
    refused("report", |b| b.report.mean_cluster_error = f64::INFINITY);
}

#[test]
fn lightmap_is_checked() {
    refused("a lightmap of 0", |b| b.lightmap.width = 0);
    refused("a lightmap of 4000000000", |b| b.lightmap.width = 4_000_000_000);
    refused("pages", |b| b.lightmap.pages = 0);
    refused("4 lightmap pages", |b| b.lightmap.pages = 4);
    refused("1 lit faces", |b| b.lightmap.faces.truncate(1));
    refused("1 back faces", |b| b.lightmap.back_faces.truncate(1));
    refused("triangle 0 has the back face 3", |b| b.lightmap.back_faces[0] = 3);
    refused("triangle 1 has the back face 0", |b| b.lightmap.back_faces[1] = 0);
    refused("lit face 1 leaves", |b| b.lightmap.faces[1].corners[2].y = 6.5);
    refused("lit face 0 leaves", |b| b.lightmap.faces[0].corners[0] = Vec2::NAN);
}

#[test]
fn texels_are_checked() {
    refused("receiver 4 has texel 12", |b| b.receiver_texels[4] = 12);
    refused("shares texel 2", |b| b.receiver_texels[4] = 2);
    refused("dilation 0 copies texel 12", |b| b.lightmap.dilation[0][1] = 12);
    refused("dilation 2 copies texel 7 to 12", |b| b.lightmap.dilation[2][0] = 12);
    refused("not a receiver's", |b| b.lightmap.dilation[1][1] = 3);
    refused("overwrites texel 0", |b| b.lightmap.dilation[1][0] = 0);
    refused("a second time", |b| b.lightmap.dilation[1][0] = 3);
}

#[test]
fn probes_are_checked() {
    refused("probe 1", |b| b.probes[1].position.z = f32::NAN);
    refused("probe 0", |b| b.probes[0].support_radius = -1.0);
    refused("direction 2", |b| b.relight_directions[2] *= 1.1);
    refused("direction 0", |b| b.relight_directions[0] = Vec3::NAN);
    refused("5 relight points", |b| b.relight_points.truncate(5));
    refused("relight point 3 lies on triangle 2", |b| b.relight_points[3].triangle = 2);
    refused("relight point 3 reads texel 12", |b| b.relight_points[3].texel = 12);
    refused("relight point 0 is not finite", |b| b.relight_points[0].position.x = f32::INFINITY);
}

#[test]
fn clusters_are_checked() {
    refused("entry 2", |b| b.cluster_probes[2] = 2);
    refused("cluster 1 does not start", |b| b.clusters[1].first_receiver = 2);
    refused("cluster 1 does not start", |b| b.clusters[1].receiver_basis_offset = 5);
    refused("cluster 1 does not start", |b| b.clusters[1].signal_basis_offset = 17);
    refused("cluster 1 does not start", |b| b.clusters[1].row_scale_offset = 0);
    refused("cluster 1 does not start", |b| b.clusters[0].rank = 1);
    refused("cluster 1 has probes", |b| b.clusters[1].first_probe = 3);
    refused("cluster 1 has probes", |b| b.clusters[1].first_probe = u32::MAX);
    refused("the clusters need", |b| b.clusters[1].probe_count = 0);
    refused("the clusters need", |b| b.clusters[1].receiver_count = u32::MAX);
    refused("the clusters need", |b| b.clusters.truncate(1));
    refused("the clusters need", |b| b.row_scales.push(1.0));
    refused("cluster 0 has a box", |b| b.clusters[0].bounds.min.x = 2.0);
    refused("cluster 0 has no usable error", |b| b.clusters[0].error = f32::NAN);
}

#[test]
fn matrices_are_checked() {
    refused("transport matrix", |b| b.receiver_basis[7] = f16::NAN);
    refused("transport matrix", |b| b.signal_basis[0] = f16::INFINITY);
    refused("row scale", |b| b.row_scales[2] = f32::NEG_INFINITY);
}
