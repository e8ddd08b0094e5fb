//! Putting the finished groups together into a baked scene.

use std::mem::take;
use std::sync::Arc;

use probelight_asset::{BakeReport, BakedParts, Cluster, GridVertex, LightmapLayout, NONE, Probe, Surfel};
use probelight_scene::Bounds;

use crate::checkpoint::FinishedGroup;
use crate::compression::CompressedCluster;
use crate::ground::Groundwork;
use crate::light::SceneLight;
use crate::options::SurfaceSignals;

/// Lines up the groups' clusters, in order, behind the shared arrays.
pub(crate) fn assemble(mut ground: Groundwork, light: SceneLight, groups: &[FinishedGroup]) -> BakedParts {
    let report = report(&ground, groups);
    let sources = light.sources;
    let mut baked = BakedParts {
        scene_hash: ground.scene_hash,
        settings: ground.settings.clone(),
        report,
        lightmap: LightmapLayout {
            width: ground.atlas.width,
            height: ground.atlas.height,
            pages: ground.atlas.pages,
            faces: take(&mut ground.atlas.faces),
            back_faces: take(&mut ground.atlas.back_faces),
            dilation: take(&mut ground.receivers.dilation),
        },
        probes: ground.probes.positions.iter().map(|p| Probe { position: *p, support_radius: 0.0 }).collect(),
        light_samples: sources.surfels.light_samples,
        surfels: sources.surfels.surfels,
        surfel_groups: sources.surfels.groups,
        emitters: sources.emitters.signals,
        relight_directions: take(&mut ground.directions),
        relight_surfels: sources.relight_surfels,
        relight_gains: sources.balance.gains,
        grid: ground.grid.layout,
        grid_blocks: take(&mut ground.grid.blocks),
        grid_vertices: ground.grid.vertices.iter().map(|vertex| GridVertex::at(vertex.offset)).collect(),
        grid_cell_blocks: take(&mut ground.walls.blocks),
        grid_cells: take(&mut ground.walls.cells),
        grid_planes: take(&mut ground.walls.planes),
        scene: Arc::clone(ground.tracer.scene()),
        ..BakedParts::default()
    };
    let probe_numbers = keep_used_probes(&mut baked, groups);
    if ground.plan.surfaces == SurfaceSignals::RelightHits {
        keep_seen_surfels(&mut baked);
    }
    baked.grid_receivers = vec![NONE; baked.grid_vertices.len() * baked.settings.grid_basis.rows()];
    for cluster in groups.iter().flat_map(|g| &g.clusters) {
        append_cluster(&mut baked, cluster, &ground, &probe_numbers);
    }
    baked
}

/// Appends a cluster and its matrices.
fn append_cluster(
    baked: &mut BakedParts,
    cluster: &CompressedCluster,
    ground: &Groundwork,
    probe_numbers: &[u32],
) {
    let positions = || cluster.receivers.iter().map(|row| ground.site_of_row(*row).position);
    let first_receiver = baked.receiver_errors.len() as u32;
    baked.clusters.push(Cluster {
        bounds: Bounds::of(positions()),
        // Clusters never mix air spaces.
        air_space: ground.site_of_row(cluster.receivers[0]).air_space().unwrap_or(NONE),
        first_receiver,
        receiver_count: cluster.receivers.len() as u32,
        first_signal: baked.cluster_signals.len() as u32,
        signal_count: cluster.signals.len() as u32,
        first_probe: baked.cluster_probes.len() as u32,
        probe_count: cluster.probes.len() as u32,
        receiver_ranks: cluster.factors.receiver_ranks,
        signal_ranks: cluster.factors.signal_ranks,
        receiver_basis_offset: baked.receiver_basis.len() as u64,
        signal_basis_offset: baked.signal_basis.len() as u64,
        row_scale_offset: baked.row_scales.len() as u64,
        column_exponent_offset: baked.column_exponents.len() as u64,
        error: cluster.factors.error,
    });
    for p in &cluster.probes {
        let probe = &mut baked.probes[probe_numbers[*p as usize] as usize];
        for position in positions() {
            probe.support_radius = probe.support_radius.max(position.distance(probe.position));
        }
    }
    let texels = ground.texels().end;
    for (row, receiver) in cluster.receivers.iter().zip(first_receiver..) {
        match row.checked_sub(texels) {
            None => baked.receiver_texels.push(ground.receivers.receivers[*row as usize].texel),
            Some(row) => baked.grid_receivers[row as usize] = receiver,
        }
    }
    baked.cluster_signals.extend(&cluster.signals);
    baked.cluster_probes.extend(cluster.probes.iter().map(|p| probe_numbers[*p as usize]));
    baked.receiver_errors.extend(&cluster.factors.receiver_errors);
    baked.receiver_basis.extend(&cluster.factors.receiver_basis);
    baked.signal_basis.extend(&cluster.factors.signal_basis);
    baked.row_scales.extend(&cluster.factors.row_scales);
    baked.column_exponents.extend(&cluster.factors.column_exponents);
}

/// Leaves out probes that no cluster draws on; returns the new number of each probe that stays.
fn keep_used_probes(baked: &mut BakedParts, groups: &[FinishedGroup]) -> Vec<u32> {
    let mut is_used = vec![false; baked.probes.len()];
    for probe in groups.iter().flat_map(|g| &g.clusters).flat_map(|c| &c.probes) {
        is_used[*probe as usize] = true;
    }
    let rays = baked.relight_directions.len();
    let is_used_ray = || is_used.iter().flat_map(|used| std::iter::repeat_n(*used, rays));
    retain(&mut baked.relight_surfels, is_used_ray());
    retain(&mut baked.relight_gains, is_used_ray());
    retain(&mut baked.probes, is_used.iter().copied());
    let mut kept = 0;
    let number = |used: &bool| {
        kept += u32::from(*used);
        kept.saturating_sub(1)
    };
    is_used.iter().map(number).collect()
}

fn retain<T>(values: &mut Vec<T>, mut stays: impl Iterator<Item = bool>) {
    values.retain(|_| stays.next().is_some_and(|stays| stays));
}

/// Leaves out the surfels of relight rays whose probe is left out; each has one light sample.
fn keep_seen_surfels(baked: &mut BakedParts) {
    let seen = baked.relight_surfels.iter_mut().filter(|surfel| **surfel != NONE);
    baked.light_samples = (0..)
        .zip(seen)
        .map(|(number, surfel)| baked.light_samples[std::mem::replace(surfel, number) as usize])
        .collect();
    let surfel = |first_sample| Surfel { first_sample, sample_count: 1, area: 0.0 };
    baked.surfels = (0..baked.light_samples.len() as u32).map(surfel).collect();
}

fn report(ground: &Groundwork, groups: &[FinishedGroup]) -> BakeReport {
    let rays = (f64::from(ground.settings.gather_rays) * ground.sites.len() as f64).max(1.0);
    let clusters = || groups.iter().flat_map(|g| &g.clusters);
    let receivers: usize = clusters().map(|c| c.receivers.len()).sum();
    let weighted: f64 = clusters().map(|c| f64::from(c.factors.error) * c.receivers.len() as f64).sum();
    BakeReport {
        chart_texels: ground.receivers.chart_texels,
        invalid_texels: ground.receivers.invalid_texels,
        approximated_fraction: groups.iter().map(|g| g.approximated_rays).sum::<u64>() as f64 / rays,
        uncovered_fraction: groups.iter().map(|g| g.uncovered_rays).sum::<u64>() as f64 / rays,
        mean_cluster_error: weighted / receivers.max(1) as f64,
        max_cluster_error: clusters().map(|c| f64::from(c.factors.error)).fold(0.0, f64::max),
        warnings: ground
            .tracer
            .scene()
            .warnings
            .iter()
            .chain(&ground.warnings)
            .map(ToString::to_string)
            .collect(),
    }
}
