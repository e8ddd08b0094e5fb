//! How many bytes the stages of a frame move.

use probelight_asset::{BakedScene, Cluster, Surfel};
use probelight_math::glam::Vec3;

use super::plan::{ClusterExtent, FramePlan, receiver_basis_bytes, signal_basis_bytes};
use super::stage::{PerStage, Stage};

/// Bytes of three `f32`.
const RGB: u64 = size_of::<Vec3>() as u64;

/// What the backends keep in forms of their own, bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// What every frame reads of surfels and groups.
    pub(crate) feedback: u64,
    /// What direct light and shading read and write.
    pub(crate) shading: u64,
    /// The number of a scalar signal, and of a probe's coefficient.
    pub(crate) column_numbers: [f64; 2],
    /// A texel of the lightmap.
    pub(crate) texel: u64,
    /// Reading and writing the coarser levels of the lightmap.
    pub(crate) reduction: u64,
}

/// Bytes that each stage of a frame on the CPU must move if it reads each of its inputs once and writes each of its outputs
/// once. Rays of lights are not counted, direct light and shading only if `lights_move`.
pub fn stage_bytes(baked: &BakedScene, plan: &FramePlan, lights_move: bool) -> PerStage<u64> {
    let samples = baked.light_samples.len() as u64;
    let surfels = baked.surfels.len() as u64;
    let groups = size_of_val(&baked.surfel_groups[..]) as u64;
    let held = Held {
        // Per sample a reflectance and a texel, per surfel its kept mean besides its range.
        feedback: samples * (RGB + 4) + surfels * (size_of::<Surfel>() as u64 + RGB) + groups,
        // Per surfel its direct light, written and read, what it emits and reflects, and what shading leaves behind.
        shading: 5 * RGB * surfels,
        column_numbers: [4.0, 4.0 / baked.coefficients() as f64],
        texel: RGB,
        reduction: 0,
    };
    stage_bytes_with(baked, plan, lights_move, &held)
}

/// [`stage_bytes`] on any backend.
pub(crate) fn stage_bytes_with(
    baked: &BakedScene,
    plan: &FramePlan,
    lights_move: bool,
    held: &Held,
) -> PerStage<u64> {
    let scalar_signals = RGB * baked.scalar_signals() as u64;
    let coefficients = RGB * plan.probes().iter().map(|probe| probe.coefficients() as u64).sum::<u64>();
    let rows = plan.clusters().iter().map(|extent| u64::from(extent.rank)).sum::<u64>();
    PerStage::from_fn(|stage| match stage {
        Stage::LightSurfels => {
            let shading = if lights_move { held.shading } else { 0 };
            held.feedback + shading + RGB * baked.receiver_texels.len() as u64 + scalar_signals
        }
        Stage::RelightProbes => relight_bytes(baked, plan) + coefficients,
        Stage::ProjectClusters => {
            project_bytes(baked, plan, held) + scalar_signals + coefficients + (4 + RGB) * rows
        }
        Stage::GatherReceivers => {
            let basis = |(cluster, extent): (&Cluster, ClusterExtent)| receiver_basis_bytes(cluster, extent);
            let basis: u64 = baked.clusters.iter().zip(plan.clusters().iter().copied()).map(basis).sum();
            let borders = size_of_val(&baked.border_blends()[..]) as u64;
            basis + RGB * rows + plan.receivers() * (4 + RGB + held.texel) + borders
        }
        Stage::DilateLightmap => baked.lightmap.dilation.len() as u64 * (8 + RGB + held.texel),
        Stage::ReduceLightmap => held.reduction,
    })
}

/// Rays with their gains, the surfels that they meet, and the table of the basis.
fn relight_bytes(baked: &BakedScene, plan: &FramePlan) -> u64 {
    let rays: u64 = plan.probes().iter().map(|probe| u64::from(probe.rays)).sum();
    let table = baked.relight_directions.len() * baked.coefficients();
    (4 + 1) * rays + RGB * baked.surfels.len() as u64 + 4 * table as u64
}

/// ΣVᵀ, the exponents of its columns and which signals these are, and the clusters' records.
fn project_bytes(baked: &BakedScene, plan: &FramePlan, held: &Held) -> u64 {
    let of_cluster = |(cluster, extent): (&Cluster, ClusterExtent)| {
        let columns = u64::from(extent.columns);
        let scalar = columns.min(u64::from(cluster.signal_count));
        let [of_signal, of_coefficient] = held.column_numbers;
        let numbers = scalar as f64 * of_signal + (columns - scalar) as f64 * of_coefficient;
        signal_basis_bytes(cluster, extent) + columns + numbers as u64
    };
    let records = size_of_val(&baked.clusters[..]) as u64;
    baked.clusters.iter().zip(plan.clusters().iter().copied()).map(of_cluster).sum::<u64>() + records
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ProbeExtent;
    use crate::synthetic::{SyntheticSize, synthetic_room};

    #[test]
    fn smaller_extents_move_fewer_bytes_where_they_are_meant_to() {
        let baked = BakedScene::new(synthetic_room(SyntheticSize::hybrid(4000))).unwrap();
        let full = stage_bytes(&baked, &FramePlan::full(&baked), false);
        let fewer = |extent, probe| {
            let plan = FramePlan::new(&baked, |_| extent, |_| probe);
            let bytes = stage_bytes(&baked, &plan, false);
            Stage::ALL.map(|stage| bytes[stage] < full[stage])
        };
        let all = (ClusterExtent::ALL, ProbeExtent::ALL);
        assert_eq!(fewer(all.0, all.1), [false; 6]);
        let rays = ProbeExtent { rays: 64, ..ProbeExtent::ALL };
        assert_eq!(fewer(all.0, rays), [false, true, false, false, false, false]);
        let rank = ClusterExtent { rank: 5, ..ClusterExtent::ALL };
        assert_eq!(fewer(rank, all.1), [false, false, true, true, false, false]);
        let columns = ClusterExtent { columns: 100, ..ClusterExtent::ALL };
        assert_eq!(fewer(columns, all.1), [false, false, true, false, false, false]);
        let receivers = ClusterExtent { receivers: 99, ..ClusterExtent::ALL };
        assert_eq!(fewer(receivers, all.1), [false, false, false, true, false, false]);
    }

    #[test]
    fn moving_lights_add_to_the_first_stage_alone() {
        let baked = BakedScene::new(synthetic_room(SyntheticSize::hybrid(4000))).unwrap();
        let plan = FramePlan::full(&baked);
        let [still, moving] = [false, true].map(|lights_move| stage_bytes(&baked, &plan, lights_move));
        let more = Stage::ALL.map(|stage| moving[stage] > still[stage]);
        assert_eq!(more, [true, false, false, false, false, false]);
    }
}
