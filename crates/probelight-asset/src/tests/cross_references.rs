//! Each promise that the runtime relies on, broken once.

use std::sync::Arc;

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::{Light, Scene};

use super::fixture::baked_parts;
use crate::packed::Ranks;
use crate::{BakedParts, BakedScene, LightSample, NONE};

/// Breaks the fixture and expects a refusal that contains `words`.
#[track_caller]
fn refused(words: &str, break_it: impl FnOnce(&mut BakedParts)) {
    let mut parts = baked_parts();
    BakedScene::new(parts.clone()).expect("the fixture is valid");
    break_it(&mut parts);
    let reason = BakedScene::new(parts).expect_err("a broken scene was accepted").to_string();
    assert!(reason.contains(words), "{reason}");
}

fn scene(parts: &mut BakedParts) -> &mut Scene {
    Arc::make_mut(&mut parts.scene)
}

#[test]
fn scene_is_checked() {
    refused("triangle 1 uses a vertex", |b| scene(b).triangles[1][2] = 4);
    refused("material 1 uses a texture", |b| scene(b).textures.truncate(1));
    refused("material 1 has a factor", |b| scene(b).materials[1].roughness = f32::NAN);
    refused("light 0", |b| {
        scene(b).lights[0] = Light::Point { position: Vec3::ZERO, intensity: Vec3::INFINITY, range: None };
    });
    refused("light 1: its range", |b| {
        if let Light::Spot { range, .. } = &mut scene(b).lights[1] {
            *range = Some(-1.0);
        }
    });
    refused("camera 0", |b| scene(b).cameras[0].vertical_fov = f32::INFINITY);
    refused("its image is 0 × 200 pixels", |b| scene(b).cameras[0].width = 0);
    refused("1 source triangles for 2 triangles", |b| scene(b).sources.triangles.truncate(1));
    refused("triangle 1 comes from a source instance", |b| scene(b).sources.triangles[1].instance = 2);
}

#[test]
fn settings_and_report_are_checked() {
    refused("degree 12", |b| b.settings.sh_degree = 12);
    refused("sky signals of degree 9", |b| b.settings.sky_degree = Some(9));
    refused("settings", |b| b.settings.probe_spacing = f32::NAN);
    refused("settings", |b| b.settings.surfel_size = f32::INFINITY);
    refused("settings", |b| b.settings.near_radius = Some(f32::NAN));
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
    refused("lit face 2 leaves its page", |b| b.lightmap.faces[2].corners[0].y = 2.9);
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
    refused("5 relight rays", |b| b.relight_surfels.truncate(5));
    refused("5 gains of 6 relight rays", |b| b.relight_gains.truncate(5));
    refused("relight ray 3 meets surfel 3", |b| b.relight_surfels[3] = 3);
}

#[test]
fn memory_of_probes_is_bounded_by_the_file() {
    refused("16385 relight rays, at most 16384", |b| {
        b.relight_directions = vec![Vec3::Y; 16_385];
    });
    // 2²² values are free, which 29,127 probes of degree 11 exceed.
    let many = |rays: usize| {
        move |b: &mut BakedParts| {
            b.settings.sh_degree = 11;
            b.probes.resize(29_128, b.probes[0]);
            b.relight_directions.resize(rays, Vec3::Y);
            b.relight_surfels = vec![NONE; rays * b.probes.len()];
            b.relight_gains = vec![128; rays * b.probes.len()];
        }
    };
    refused("3 relight rays are too few for 29128 probes of degree 11", many(3));
    // Enough rays get to the next check: the clusters still have the columns of degree 1.
    refused("cluster 1 does not start", many(18));
}

#[test]
fn light_samples_are_checked() {
    let on_triangle = |triangle| LightSample::new(triangle, false, Vec2::ZERO, [0; 3]);
    refused("light sample 3 lies on triangle 2", |b| b.light_samples[3] = on_triangle(2));
    refused("light sample 1 lies on triangle", |b| b.light_samples[1] = on_triangle(NONE / 2));
    refused("light sample 0 lies outside of its triangle", |b| {
        b.light_samples[0].weights_and_color = [u16::MAX; 3];
    });
}

#[test]
fn surfels_are_checked() {
    refused("surfel 1 does not start", |b| b.surfels[1].first_sample = 1);
    refused("surfel 2 does not start", |b| b.surfels[1].sample_count = 2);
    refused("surfel 1 has an area", |b| b.surfels[1].area = f32::NAN);
    refused("surfel 2 has no samples", |b| b.surfels[2].sample_count = 0);
    refused("the surfels need 3 light samples, and there are 4", |b| b.surfels.truncate(2));
    refused("the surfels need 4294967298", |b| b.surfels[2].sample_count = u32::MAX);
    refused("surfel group 0 (number 3) is made of [0, 3]", |b| b.surfel_groups[0].children[1] = 3);
    refused("surfel group 1 (number 4) is made of [4, 1]", |b| b.surfel_groups[1].children[0] = 4);
    refused("surfel group 0 has a weight", |b| b.surfel_groups[0].first_weight = -0.1);
    refused("surfel group 1 has a weight", |b| b.surfel_groups[1].first_weight = 1.01);
    refused("surfel group 1 has a weight", |b| b.surfel_groups[1].first_weight = f32::NAN);
}

#[test]
fn emitters_are_checked() {
    refused("emitter 0 has material 2 of 2", |b| b.emitters[0].material = 2);
    refused("emitter 0 has a mean texel", |b| b.emitters[0].mean_texel.y = -0.1);
    refused("emitter 0 has a mean texel", |b| b.emitters[0].mean_texel.z = f32::INFINITY);
}

#[test]
fn clusters_are_checked() {
    refused("entry 1 of the clusters' signals is 10", |b| b.cluster_signals[1] = 10);
    refused("entry 1 of the clusters' signals is 9 of 6", |b| b.settings.sky_degree = None);
    refused("entry 2 of the clusters' probes is 2", |b| b.cluster_probes[2] = 2);
    refused("cluster 1 does not start", |b| b.clusters[1].first_receiver = 2);
    refused("cluster 1 does not start", |b| b.clusters[1].first_signal = 1);
    refused("cluster 1 does not start", |b| b.clusters[1].first_probe = u32::MAX);
    refused("cluster 1 does not start", |b| b.clusters[1].receiver_basis_offset = 5);
    refused("cluster 1 does not start", |b| b.clusters[1].signal_basis_offset = 17);
    refused("cluster 1 does not start", |b| b.clusters[1].row_scale_offset = 0);
    refused("cluster 1 does not start", |b| b.clusters[1].column_exponent_offset = 11);
    refused("cluster 1 does not start", |b| {
        b.clusters[0].receiver_ranks = Ranks { f16: 2, ..Ranks::default() };
    });
    refused("cluster 2 does not start", |b| b.clusters[1].signal_count = 0);
    refused("cluster 2 does not start", |b| b.clusters[1].probe_count = 0);
    refused("cluster 2 does not start", |b| b.clusters[1].receiver_count = 1);
    refused("the clusters need", |b| b.clusters[2].signal_count = 0);
    refused("the clusters need", |b| b.clusters[2].probe_count = 1);
    refused("the clusters need", |b| b.clusters[2].receiver_count = u32::MAX);
    refused("the clusters need", |b| b.clusters.truncate(1));
    refused("the clusters need", |b| b.row_scales.push(1.0));
    refused("the clusters need", |b| b.column_exponents.push(1));
    refused("4 receivers' errors for 11", |b| b.receiver_errors.truncate(4));
    refused("cluster 1 is too large", |b| b.clusters[1].probe_count = u32::MAX);
    refused("cluster 1 has different numbers", |b| b.clusters[1].signal_ranks.f16 = 1);
    refused("cluster 1 is too large", |b| {
        b.clusters[1].receiver_ranks.f16 = u32::MAX;
        b.clusters[1].signal_ranks.f16 = u32::MAX;
    });
    refused("cluster 0 has a box", |b| b.clusters[0].bounds.min.x = 2.0);
    refused("cluster 0 has no usable error", |b| b.clusters[0].error = f32::NAN);
}

#[test]
fn the_grid_is_checked() {
    refused("origin or a spacing", |b| b.grid.spacing.y = f32::NAN);
    refused("2 blocks of a grid with 3 × 5 × 7 vertices", |b| b.grid.counts.z = 7);
    refused("4 levels of a grid, more than 3", |b| b.grid.levels = 4);
    refused("coarsest cells do not fit", |b| b.grid.counts.x = 4);
    refused("block 0 of the grid has vertices that its level 1", |b| b.grid_blocks[0].level = 1);
    refused("block 1 of the grid has vertices that its level 2", |b| b.grid_blocks[1].level = 2);
    refused("a grid without cells between its vertices", |b| b.grid.counts.z = 1);
    refused("block 1 of the grid's vertices does not start", |b| b.grid_blocks[1].first = 0);
    refused("need 2 vertices, and there are 1", |b| b.grid_blocks[1].present[1] = 1);
    refused("5 rows of 1 vertices of the grid with 6 each", |b| b.grid_receivers.truncate(5));
    refused("1 blocks of cells of a grid with 3 of them", |b| b.grid_cell_blocks.truncate(1));
    refused("block 1 of the grid's cells does not start", |b| b.grid_cell_blocks[1].first = 0);
    refused("need 2 cells, and there are 0", |b| b.grid_cells.clear());
    refused("cell 0 of the grid is divided by plane 2 of 2", |b| b.grid_cells[0].planes[1] = 2);
    refused("a plane of the grid is not finite", |b| b.grid_planes[0].w = f32::INFINITY);
    refused("row 0 of the grid is held by receiver 4", |b| b.grid_receivers[0] = 4);
    refused("row 3 of the grid is held by receiver 11", |b| b.grid_receivers[3] = 11);
    refused("cluster 1 holds receivers of lightmap and grid", |b| b.clusters[1].receiver_count = 3);
}

#[test]
fn matrices_are_checked() {
    refused("matrix of cluster 0", |b| b.receiver_basis[0] |= 0x7c00);
    refused("matrix of cluster 0", |b| b.signal_basis[4] |= 0x7c00_0000);
    refused("matrix of cluster 0", |b| b.receiver_basis[2] = 0x0000_8000);
    refused("matrix of cluster 0", |b| b.signal_basis[7] = 0x80);
    refused("matrix of cluster 1", |b| b.receiver_basis[3] = 0x80);
    refused("matrix of cluster 1", |b| b.signal_basis[8] = 0x8);
    refused("row scale", |b| b.row_scales[2] = f32::NEG_INFINITY);
}
