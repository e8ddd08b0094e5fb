//! What a frame computes of each cluster and of each probe.

use bytemuck::{Pod, Zeroable};
use probelight_asset::packed::Ranks;
use probelight_asset::{BakedScene, Cluster};
use probelight_math::sh::coefficient_count;

use super::relight_table::prefix_with;

/// What a frame computes of a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ClusterExtent {
    /// Leading singular values.
    pub rank: u32,
    /// Leading columns of ΣVᵀ: signals that are read.
    pub columns: u32,
    /// Leading receivers; with none, nothing of the cluster is computed.
    pub receivers: u32,
    /// Leading singular values that count in full; those behind them are on their way out.
    pub solid: u32,
    /// How much these still count, in parts of [`FADE_STEPS`].
    pub fade: u32,
    /// The level of the lightmap whose texels the leading receivers are, from which the others get their light; with 0
    /// they keep what they have.
    pub fill: u32,
}

/// Parts of a singular value that fades out.
pub const FADE_STEPS: u32 = 16;

/// What a frame computes of a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProbeExtent {
    /// Leading relight rays; with none, the probe keeps its coefficients.
    pub rays: u32,
    /// Highest spherical-harmonics band.
    pub degree: u32,
}

impl ClusterExtent {
    /// Everything that a cluster has.
    pub const ALL: Self = Self {
        rank: u32::MAX,
        columns: u32::MAX,
        receivers: u32::MAX,
        solid: u32::MAX,
        fade: FADE_STEPS,
        fill: 0,
    };

    /// What of it the cluster has.
    fn within(self, baked: &BakedScene, cluster: &Cluster) -> Self {
        if self.receivers.min(cluster.receiver_count) == 0 {
            return Self::default();
        }
        let rank = self.rank.min(cluster.rank());
        // One way only to say that all count in full.
        let is_solid = self.fade >= FADE_STEPS || self.solid >= rank;
        let (solid, fade) = if is_solid { (rank, FADE_STEPS) } else { (self.solid, self.fade) };
        Self {
            rank,
            solid,
            fade,
            fill: if self.receivers < cluster.receiver_count { self.fill } else { 0 },
            columns: self.columns.min(baked.column_count(cluster) as u32),
            receivers: self.receivers.min(cluster.receiver_count),
        }
    }

    /// How much the singular value number `row` counts.
    #[cfg(feature = "cpu")]
    pub(crate) fn weight(self, row: usize) -> f32 {
        if row < self.solid as usize { 1.0 } else { self.fade as f32 / FADE_STEPS as f32 }
    }

    /// Highest band of the cluster's probes that the columns read; `None` if they read nothing of probes.
    fn degree(self, cluster: &Cluster) -> Option<u32> {
        let of_probes = self.columns.saturating_sub(cluster.signal_count);
        (of_probes > 0 && self.rank > 0).then(|| {
            let per_probe = of_probes.div_ceil(cluster.probe_count.max(1)) as usize;
            (0..).find(|degree| coefficient_count(*degree as usize) >= per_probe).unwrap_or(0)
        })
    }
}

impl ProbeExtent {
    /// Everything that a probe has.
    pub const ALL: Self = Self { rays: u32::MAX, degree: u32::MAX };

    /// What of it the probe has; rays are a prefix with quadrature weights of its own, at least as long.
    fn within(self, baked: &BakedScene) -> Self {
        let stored = baked.relight_directions.len() as u32;
        let rays = if self.rays == 0 { 0 } else { prefix_with(stored, self.rays) };
        Self { rays, degree: self.degree.min(baked.settings.sh_degree) }
    }

    /// Number of coefficients; none without rays.
    pub fn coefficients(self) -> usize {
        if self.rays == 0 { 0 } else { coefficient_count(self.degree as usize) }
    }
}

/// What a frame computes of a baked scene: an extent for each cluster and each probe. No cluster reads coefficients that
/// its probes do not compute in the same frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FramePlan {
    clusters: Vec<ClusterExtent>,
    probes: Vec<ProbeExtent>,
}

impl FramePlan {
    /// Everything.
    pub fn full(baked: &BakedScene) -> Self {
        Self::new(baked, |_| ClusterExtent::ALL, |_| ProbeExtent::ALL)
    }

    /// A plan from what is wanted of each cluster and each probe (by index): as much of it as there is, and of the probes
    /// as much more as the clusters need.
    pub fn new(
        baked: &BakedScene,
        cluster: impl Fn(usize) -> ClusterExtent,
        probe: impl Fn(usize) -> ProbeExtent,
    ) -> Self {
        let mut plan = Self {
            clusters: vec![ClusterExtent::default(); baked.clusters.len()],
            probes: vec![ProbeExtent::default(); baked.probes.len()],
        };
        plan.fill(baked, cluster, probe);
        plan
    }

    /// [`new`](Self::new) in the memory of a plan for the same scene.
    pub(super) fn fill(
        &mut self,
        baked: &BakedScene,
        cluster: impl Fn(usize) -> ClusterExtent,
        probe: impl Fn(usize) -> ProbeExtent,
    ) {
        for (index, extent) in self.probes.iter_mut().enumerate() {
            *extent = probe(index).within(baked);
        }
        let fewest_rays = prefix_with(baked.relight_directions.len() as u32, 1);
        for (index, (extent, described)) in self.clusters.iter_mut().zip(&baked.clusters).enumerate() {
            *extent = cluster(index).within(baked, described);
            let Some(degree) = extent.degree(described) else { continue };
            for probe in baked.probes_of(described) {
                let probe = &mut self.probes[*probe as usize];
                probe.rays = probe.rays.max(fewest_rays);
                probe.degree = probe.degree.max(degree);
            }
        }
    }

    /// An extent for each cluster, in their order.
    pub fn clusters(&self) -> &[ClusterExtent] {
        &self.clusters
    }

    /// An extent for each probe, in their order.
    pub fn probes(&self) -> &[ProbeExtent] {
        &self.probes
    }

    /// The extents of the clusters, for those who choose what of a plan is computed.
    #[cfg(feature = "cpu")]
    pub(crate) fn clusters_mut(&mut self) -> &mut [ClusterExtent] {
        &mut self.clusters
    }

    /// Those of the probes.
    #[cfg(feature = "cpu")]
    pub(crate) fn probes_mut(&mut self) -> &mut [ProbeExtent] {
        &mut self.probes
    }

    /// Number of receivers that are computed.
    pub fn receivers(&self) -> u64 {
        receivers(&self.clusters)
    }

    /// Number of probes that are relit.
    pub fn relit_probes(&self) -> usize {
        self.probes.iter().filter(|probe| probe.rays > 0).count()
    }

    /// Number of coefficients that they get.
    pub fn coefficients(&self) -> usize {
        self.probes.iter().map(|probe| probe.coefficients()).sum()
    }

    /// Bytes of the transport matrices that are read: U and ΣVᵀ.
    pub fn matrix_bytes(&self, baked: &BakedScene) -> u64 {
        matrix_bytes_of_all(baked, &self.clusters)
    }
}

/// Number of receivers that clusters' extents compute.
pub(super) fn receivers(clusters: &[ClusterExtent]) -> u64 {
    clusters.iter().map(|extent| u64::from(extent.receivers)).sum()
}

/// Bytes of U and ΣVᵀ that the extents of all clusters read.
pub(super) fn matrix_bytes_of_all(baked: &BakedScene, clusters: &[ClusterExtent]) -> u64 {
    let bytes = |(cluster, extent): (&Cluster, &ClusterExtent)| matrix_bytes(cluster, *extent);
    baked.clusters.iter().zip(clusters).map(bytes).sum()
}

/// Which cluster a receiver belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ReceiverPlace {
    /// Index of the cluster.
    pub(crate) cluster: u32,
    /// Which of its receivers it is.
    pub(crate) index: u32,
}

impl ReceiverPlace {
    /// The place of a receiver.
    pub(crate) fn at(clusters: &[Cluster], receiver: u32) -> Self {
        let behind = clusters.partition_point(|cluster| cluster.first_receiver <= receiver);
        // Clusters without receivers begin where the next one does.
        let cluster = behind.saturating_sub(1);
        Self { cluster: cluster as u32, index: receiver - clusters[cluster].first_receiver }
    }

    /// Whether a frame of such extents computes the receiver.
    #[cfg(feature = "cpu")]
    pub(crate) fn is_computed(self, clusters: &[ClusterExtent]) -> bool {
        let extent = clusters[self.cluster as usize];
        self.index < extent.receivers || extent.fill > 0
    }
}

/// Bytes of U and ΣVᵀ that a cluster's extent reads.
pub(crate) fn matrix_bytes(cluster: &Cluster, extent: ClusterExtent) -> u64 {
    receiver_basis_bytes(cluster, extent) + signal_basis_bytes(cluster, extent)
}

/// Bytes of U that a cluster's extent reads.
pub(super) fn receiver_basis_bytes(cluster: &Cluster, extent: ClusterExtent) -> u64 {
    4 * leading(cluster.receiver_ranks, extent.rank).words(u64::from(extent.receivers))
}

/// Bytes of ΣVᵀ that a cluster's extent reads.
pub(super) fn signal_basis_bytes(cluster: &Cluster, extent: ClusterExtent) -> u64 {
    4 * leading(cluster.signal_ranks, extent.rank).words(u64::from(extent.columns))
}

/// The precisions of the leading singular values.
pub(crate) fn leading(ranks: Ranks, rank: u32) -> Ranks {
    let f16 = ranks.f16.min(rank);
    let snorm8 = ranks.snorm8.min(rank - f16);
    Ranks { f16, snorm8, snorm4: ranks.snorm4.min(rank - f16 - snorm8) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::synthetic::{SyntheticSize, synthetic_room};

    fn room() -> BakedScene {
        let size = SyntheticSize { varied: true, ..SyntheticSize::hybrid(2000) };
        let room = synthetic_room(SyntheticSize { rays: 60, probes: 19, sh_degree: 4, ..size });
        BakedScene::new(room).unwrap()
    }

    #[test]
    fn everything_is_all_there_is() {
        let baked = room();
        let plan = FramePlan::full(&baked);
        assert_eq!(plan.receivers(), baked.receiver_texels.len() as u64);
        assert!(plan.probes.iter().all(|probe| *probe == ProbeExtent { rays: 60, degree: 4 }));
        let words = baked.receiver_basis.len() + baked.signal_basis.len();
        assert_eq!(plan.matrix_bytes(&baked), 4 * words as u64);
    }

    #[test]
    fn clusters_without_receivers_ask_for_nothing() {
        let baked = room();
        let extent = ClusterExtent { receivers: 0, ..ClusterExtent::ALL };
        let plan = FramePlan::new(&baked, |_| extent, |_| ProbeExtent::default());
        assert_eq!(plan.clusters, vec![ClusterExtent::default(); baked.clusters.len()]);
        assert_eq!(plan.probes, vec![ProbeExtent::default(); baked.probes.len()]);
        assert_eq!(plan.matrix_bytes(&baked), 0);
    }

    #[test]
    fn leading_singular_values_keep_their_precisions() {
        let ranks = Ranks { f16: 2, snorm8: 3, snorm4: 4 };
        let parts = |rank| {
            let Ranks { f16, snorm8, snorm4 } = leading(ranks, rank);
            [f16, snorm8, snorm4]
        };
        assert_eq!([0, 1, 4, 6, 99].map(parts), [[0, 0, 0], [1, 0, 0], [2, 2, 0], [2, 3, 1], [2, 3, 4]]);
    }

    proptest! {
        /// The last column that a cluster reads belongs to a band that each of its probes computes.
        #[test]
        fn no_cluster_reads_what_its_probes_do_not_compute(
            wanted in prop::collection::vec((0u32..40, 0u32..600, 0u32..300), 8),
            probes in prop::collection::vec((0u32..80, 0u32..6), 19),
        ) {
            let baked = room();
            let cluster = |index: usize| {
                let (rank, columns, receivers) = wanted[index % wanted.len()];
                ClusterExtent { rank, columns, receivers, ..ClusterExtent::ALL }
            };
            let probe = |index: usize| ProbeExtent { rays: probes[index].0, degree: probes[index].1 };
            let plan = FramePlan::new(&baked, cluster, probe);
            for (cluster, extent) in baked.clusters.iter().zip(&plan.clusters) {
                prop_assert!(extent.rank <= cluster.rank() && extent.receivers <= cluster.receiver_count);
                prop_assert!(extent.columns as usize <= baked.column_count(cluster));
                let of_probes = extent.columns.saturating_sub(cluster.signal_count) as usize;
                for probe in baked.probes_of(cluster) {
                    let computed = cluster.probe_count as usize * plan.probes[*probe as usize].coefficients();
                    prop_assert!(computed >= of_probes || extent.rank == 0);
                }
            }
        }
    }
}
