//! What is written comes back.

use std::sync::Arc;

use probelight_math::glam::Vec3;
use probelight_scene::{Bounds, Texture};
use proptest::prelude::*;

use super::fixture::baked_parts;
use super::{baked_scene, checked, encoded};
use crate::packed::Ranks;
use crate::{BakedParts, BakedScene, Cluster, GridBlock, NONE, Probe};

#[test]
fn every_field_survives() {
    let baked = baked_scene();
    let read = BakedScene::from_bytes(&encoded(&baked)).unwrap();
    // `Debug` shows every field of every part, with all digits.
    assert_eq!(format!("{read:#?}"), format!("{baked:#?}"));
    assert_eq!(encoded(&read), encoded(&baked));
}

#[test]
fn files_on_disk_come_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.plight");
    let baked = baked_scene();
    baked.write(&path).unwrap();
    let read = BakedScene::read(&path).unwrap();
    assert_eq!(format!("{read:?}"), format!("{baked:?}"));
    assert_eq!(std::fs::read(&path).unwrap(), encoded(&baked));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn summary_agrees_with_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.plight");
    let baked = baked_scene();
    baked.write(&path).unwrap();
    let info = BakedScene::read_info(&path).unwrap();
    assert_eq!((info.triangles, info.receivers, info.probes, info.clusters), (2, 5, 2, 3));
    assert_eq!((info.grid, info.grid_vertices), (baked.grid, 1));
    assert_eq!(info.grid_bytes, baked.grid_bytes().total());
    assert_eq!((info.light_samples, info.surfels, info.surfel_groups, info.emitters), (4, 3, 2, 1));
    assert_eq!((info.lightmap_width, info.lightmap_height, info.lightmap_pages), (2, 6, 2));
    assert_eq!(
        (info.scene_hash, &info.settings, &info.report),
        (baked.scene_hash, &baked.settings, &baked.report)
    );
    assert_eq!(info.matrix_bytes_per_receiver, baked.matrix_bytes_per_receiver());
    let last = info.sections.last().unwrap();
    assert_eq!(last.offset + last.bytes, info.file_bytes);
    assert!(info.sections.iter().all(|section| section.offset.is_multiple_of(64)));
}

#[test]
fn parts_are_given_back_and_checked_again() {
    let mut parts = baked_scene().into_parts();
    parts.row_scales[0] = f32::NAN;
    assert!(BakedScene::new(parts).unwrap_err().reason.contains("row scale"));
}

#[test]
fn missing_folders_and_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing").join("scene.plight");
    let messages = [
        baked_scene().write(&path).unwrap_err().to_string(),
        BakedScene::read(&path).unwrap_err().to_string(),
        BakedScene::read_info(&path).unwrap_err().to_string(),
    ];
    assert!(messages[0].starts_with("cannot write") && messages[1].starts_with("cannot read"));
    assert!(messages.iter().all(|message| message.contains("scene.plight")));
}

/// Receivers, scalar signals, probes and ranks of a cluster.
type ClusterSize = (u32, u32, u32, [u32; 3]);

/// Replaces the fixture's clusters with ones of the given sizes on a wide enough map.
fn with_clusters(sizes: &[ClusterSize], values: &[f32]) -> BakedParts {
    let mut baked = baked_parts();
    baked.clusters.clear();
    let (mut receivers, mut signals, mut probes) = (0, 0, 0);
    baked.receiver_basis.clear();
    baked.signal_basis.clear();
    baked.row_scales.clear();
    baked.column_exponents.clear();
    let value = |i: usize| values[i % values.len()];
    for (receiver_count, signal_count, probe_count, [f16, snorm8, snorm4]) in sizes.iter().copied() {
        let ranks = Ranks { f16, snorm8, snorm4 };
        let signal_ranks = Ranks { f16: snorm4, snorm8: f16, snorm4: snorm8 };
        let cluster = Cluster {
            bounds: Bounds { min: Vec3::NEG_ONE, max: Vec3::splat(value(receivers as usize).abs()) },
            air_space: signals,
            first_receiver: receivers,
            receiver_count,
            first_signal: signals,
            signal_count,
            first_probe: probes,
            probe_count,
            receiver_ranks: ranks,
            signal_ranks,
            receiver_basis_offset: baked.receiver_basis.len() as u64,
            signal_basis_offset: baked.signal_basis.len() as u64,
            row_scale_offset: baked.row_scales.len() as u64,
            column_exponent_offset: baked.column_exponents.len() as u64,
            error: 0.5,
        };
        let columns = baked.column_count(&cluster);
        for k in 0..ranks.total() as usize {
            let line = |count: usize| (0..count).map(|i| value(i + k)).collect::<Vec<f32>>();
            ranks.precision(k).pack(&line(receiver_count as usize), &mut baked.receiver_basis);
            signal_ranks.precision(k).pack(&line(columns), &mut baked.signal_basis);
            baked.row_scales.push(value(k));
        }
        baked.column_exponents.extend((0..columns).map(|column| (column * 7) as u8));
        baked.clusters.push(cluster);
        (receivers, signals) = (receivers + receiver_count, signals + signal_count);
        probes += probe_count;
    }
    (baked.lightmap.width, baked.lightmap.height) = (64, 64);
    baked.lightmap.dilation.clear();
    (baked.grid_vertices, baked.grid_receivers) = (Vec::new(), Vec::new());
    baked.grid_blocks.fill(GridBlock::default());
    baked.receiver_texels = (0..receivers).rev().collect();
    baked.receiver_errors = (0..receivers).map(|receiver| receiver as u8).collect();
    baked.cluster_signals = (0..signals).map(|s| s % 10).collect();
    baked.cluster_probes = (0..probes).map(|p| p % 2).collect();
    baked
}

proptest! {
    #[test]
    fn any_valid_scene_survives(
        sizes in prop::collection::vec((0u32..40, 0u32..12, 0u32..6, prop::array::uniform3(0u32..4)), 0..6),
        values in prop::collection::vec(-6e4f32..6e4, 1..50),
        (width, height) in (1u32..9, 1u32..9),
        texels in prop::collection::vec(any::<u8>(), 256),
        report in prop::array::uniform4(prop::num::f64::NORMAL),
        probes in prop::collection::vec((prop::num::f32::NORMAL, 0f32..9.0), 2..5),
    ) {
        let mut baked = with_clusters(&sizes, &values);
        let rgba8 = texels[..(width * height * 4) as usize].into();
        let scene = Arc::make_mut(&mut baked.scene);
        scene.textures[1] = Texture { name: "random".into(), width, height, rgba8 };
        baked.report.approximated_fraction = report[0];
        baked.report.uncovered_fraction = report[1];
        baked.report.mean_cluster_error = report[2];
        baked.report.max_cluster_error = report[3];
        scene.materials[0].roughness = values[0] / 3.0;
        baked.relight_surfels = [NONE, 0, 2].repeat(probes.len());
        baked.relight_gains = [128, 7, 255].repeat(probes.len());
        baked.probes = probes
            .iter()
            .map(|(x, support_radius)| Probe { position: Vec3::splat(*x), support_radius: *support_radius })
            .collect();
        let baked = checked(baked);
        let read = BakedScene::from_bytes(&encoded(&baked)).unwrap();
        prop_assert_eq!(format!("{read:?}"), format!("{baked:?}"));
        prop_assert_eq!(encoded(&read), encoded(&baked));
    }
}
