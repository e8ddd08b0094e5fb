//! Clusters in portions whose matrices shaders can bind.
//!
//! WebGPU guarantees bindings of 128 MiB, and the matrices of large scenes are longer. A shard holds neighbouring
//! clusters, whole ones, with all that belongs to them; its offsets count from its own start.

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

use probelight_asset::packed::Ranks;
use probelight_asset::{BakedScene, Cluster, NONE};

use super::device::GpuError;
use super::frame_buffers::RGB_BYTES;
use super::storage::Storage;
#[cfg(feature = "cpu")]
use super::storage::write_words;

/// Receivers of a workgroup of `gather_receivers`: `BLOCK` in its shader.
pub(super) const GATHER_BLOCK: u32 = 256;

/// Where a cluster's parts lie in the buffers of its shard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ClusterRecord {
    /// Index among all clusters.
    pub(super) number: u32,
    /// First receiver, among all receivers.
    pub(super) first_receiver: u32,
    /// First of its texels in the shard's.
    pub(super) first_texel: u32,
    /// Number of receivers.
    pub(super) receiver_count: u32,
    /// First column of ΣVᵀ in the shard's numbers of signals.
    pub(super) first_column: u32,
    /// Number of columns.
    pub(super) column_count: u32,
    /// Singular values by the precision that U has them with.
    pub(super) receiver_ranks: Ranks,
    /// By that of ΣVᵀ.
    pub(super) signal_ranks: Ranks,
    /// First word of U.
    pub(super) receiver_basis_offset: u32,
    /// First word of ΣVᵀ.
    pub(super) signal_basis_offset: u32,
    /// First row scale, and first row of b.
    pub(super) first_row: u32,
    /// First word of the column exponents.
    pub(super) exponent_offset: u32,
}

/// What one workgroup of `gather_receivers` computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GatherTask {
    /// Index of the cluster in its shard.
    pub(super) cluster: u32,
    /// First receiver, counted within the cluster.
    pub(super) first: u32,
}

/// Some clusters in the memory of a GPU.
#[derive(Debug)]
pub(super) struct ClusterShard {
    pub(super) cluster_count: usize,
    pub(super) task_count: usize,
    /// Singular values.
    pub(super) row_count: usize,
    /// Which these are among all.
    pub(super) rows: Range<usize>,
    /// Which clusters these are among all.
    #[cfg(feature = "cpu")]
    numbers: Range<usize>,
    /// First word of each cluster's column exponents.
    #[cfg(feature = "cpu")]
    exponent_offsets: Vec<u32>,
    pub(super) clusters: wgpu::Buffer,
    /// Number of the signal in each column, among all signals.
    pub(super) column_signals: wgpu::Buffer,
    pub(super) exponents: wgpu::Buffer,
    pub(super) row_scales: wgpu::Buffer,
    pub(super) signal_basis: wgpu::Buffer,
    pub(super) receiver_basis: wgpu::Buffer,
    pub(super) receiver_texels: wgpu::Buffer,
    pub(super) tasks: wgpu::Buffer,
    /// The clusters' coefficients b: three `f32` for each singular value.
    pub(super) coefficients: wgpu::Buffer,
}

/// All shards of a scene.
///
/// # Errors
/// [`GpuError::TooLarge`] if a single cluster does not fit in a binding.
pub(super) fn cluster_shards(storage: &Storage, baked: &BakedScene) -> Result<Vec<ClusterShard>, GpuError> {
    divide(&baked.clusters, storage.limit, |cluster| largest_part(baked, cluster))
        .into_iter()
        .map(|range| ClusterShard::new(storage, baked, range))
        .collect()
}

/// Divides items into neighbouring ranges, each of at most `limit` bytes if more than one item long.
pub(super) fn divide<T>(items: &[T], limit: u64, bytes: impl Fn(&T) -> u64) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let (mut start, mut used) = (0, 0);
    for (index, item) in items.iter().enumerate() {
        let needed = bytes(item);
        if index > start && used + needed > limit {
            ranges.push(start..index);
            (start, used) = (index, 0);
        }
        used += needed;
    }
    if start < items.len() {
        ranges.push(start..items.len());
    }
    ranges
}

/// Bytes of the longest of a cluster's parts; sums of these bound the sums of each part.
fn largest_part(baked: &BakedScene, cluster: &Cluster) -> u64 {
    let columns = baked.column_count(cluster) as u64;
    let words = [
        cluster.receiver_basis_words(),
        cluster.signal_ranks.words(columns),
        columns,
        u64::from(cluster.receiver_count),
        size_of::<ClusterRecord>() as u64 / 4,
        3 * u64::from(cluster.rank()),
    ];
    4 * words.into_iter().max().unwrap_or(0)
}

/// The arrays of a shard, as they will lie on the GPU.
#[derive(Default)]
struct ShardArrays<'a> {
    clusters: Vec<ClusterRecord>,
    tasks: Vec<GatherTask>,
    column_signals: Vec<u32>,
    exponents: Vec<u8>,
    row_scales: &'a [f32],
    signal_basis: &'a [u32],
    receiver_basis: &'a [u32],
    receiver_texels: Vec<u32>,
}

impl<'a> ShardArrays<'a> {
    fn new(baked: &'a BakedScene, range: Range<usize>) -> Self {
        let first = &baked.clusters[range.start];
        let next = baked.clusters.get(range.end);
        let mut arrays = Self {
            row_scales: part(&baked.row_scales, first, next, |c| c.row_scale_offset),
            signal_basis: part(&baked.signal_basis, first, next, |c| c.signal_basis_offset),
            receiver_basis: part(&baked.receiver_basis, first, next, |c| c.receiver_basis_offset),
            ..Self::default()
        };
        for (number, cluster) in range.clone().zip(&baked.clusters[range]) {
            arrays.push(baked, first, number as u32, cluster);
        }
        arrays
    }

    fn push(&mut self, baked: &BakedScene, first: &Cluster, number: u32, cluster: &Cluster) {
        let index = self.clusters.len() as u32;
        let texels = baked.texels(cluster);
        self.receiver_texels.extend(texels);
        self.receiver_texels
            .resize(self.receiver_texels.len() + cluster.receiver_count as usize - texels.len(), NONE);
        self.clusters.push(ClusterRecord {
            number,
            first_receiver: cluster.first_receiver,
            first_texel: cluster.first_receiver - first.first_receiver,
            receiver_count: cluster.receiver_count,
            first_column: self.column_signals.len() as u32,
            column_count: baked.column_count(cluster) as u32,
            receiver_ranks: cluster.receiver_ranks,
            signal_ranks: cluster.signal_ranks,
            receiver_basis_offset: (cluster.receiver_basis_offset - first.receiver_basis_offset) as u32,
            signal_basis_offset: (cluster.signal_basis_offset - first.signal_basis_offset) as u32,
            first_row: (cluster.row_scale_offset - first.row_scale_offset) as u32,
            exponent_offset: (self.exponents.len() / 4) as u32,
        });
        self.push_column_signals(baked, cluster);
        let exponents = &baked.column_exponents[cluster.column_exponent_offset as usize..];
        self.exponents.extend(&exponents[..baked.column_count(cluster)]);
        self.exponents.resize(self.exponents.len().next_multiple_of(4), 0);
        let blocks = (0..cluster.receiver_count).step_by(GATHER_BLOCK as usize);
        self.tasks.extend(blocks.map(|first| GatherTask { cluster: index, first }));
    }

    /// The scalar signals, then the coefficients of the probes band by band, as in [`Cluster`].
    fn push_column_signals(&mut self, baked: &BakedScene, cluster: &Cluster) {
        self.column_signals.extend(baked.signals_of(cluster));
        for band in 0..=baked.settings.sh_degree as usize {
            for probe in baked.probes_of(cluster) {
                let first = baked.scalar_signals() + *probe as usize * baked.coefficients() + band * band;
                self.column_signals.extend(first as u32..(first + 2 * band + 1) as u32);
            }
        }
    }
}

/// The part of an array that belongs to the clusters from `first` to before `next`.
fn part<'a, T>(
    array: &'a [T],
    first: &Cluster,
    next: Option<&Cluster>,
    start: impl Fn(&Cluster) -> u64,
) -> &'a [T] {
    &array[start(first) as usize..next.map_or(array.len(), |next| start(next) as usize)]
}

impl ClusterShard {
    fn new(storage: &Storage, baked: &BakedScene, range: Range<usize>) -> Result<Self, GpuError> {
        let arrays = ShardArrays::new(baked, range.clone());
        let first_row = baked.clusters[range.start].row_scale_offset as usize;
        Ok(Self {
            rows: first_row..first_row + arrays.row_scales.len(),
            #[cfg(feature = "cpu")]
            numbers: range,
            #[cfg(feature = "cpu")]
            exponent_offsets: arrays.clusters.iter().map(|cluster| cluster.exponent_offset).collect(),
            cluster_count: arrays.clusters.len(),
            task_count: arrays.tasks.len(),
            row_count: arrays.row_scales.len(),
            clusters: storage.array("clusters", &arrays.clusters)?,
            column_signals: storage.array("signals of clusters", &arrays.column_signals)?,
            exponents: storage.array("column exponents", &arrays.exponents)?,
            row_scales: storage.array("row scales", arrays.row_scales)?,
            signal_basis: storage.array("matrices ΣVᵀ", arrays.signal_basis)?,
            receiver_basis: storage.array("matrices U", arrays.receiver_basis)?,
            receiver_texels: storage.array("receivers' texels", &arrays.receiver_texels)?,
            tasks: storage.array("gather tasks", &arrays.tasks)?,
            coefficients: storage.zeros("coefficients", RGB_BYTES * arrays.row_scales.len() as u64)?,
        })
    }

    /// Renews the column exponents of some clusters, as far as they are of the shard.
    #[cfg(feature = "cpu")]
    pub(super) fn set_exponents(
        &self,
        queue: &wgpu::Queue,
        baked: &BakedScene,
        exponents: &[u8],
        clusters: &[u32],
    ) {
        for number in clusters.iter().map(|number| *number as usize) {
            if let Some(offset) =
                number.checked_sub(self.numbers.start).and_then(|index| self.exponent_offsets.get(index))
            {
                let cluster = &baked.clusters[number];
                let its =
                    &exponents[cluster.column_exponent_offset as usize..][..baked.column_count(cluster)];
                write_words(queue, &self.exponents, 4 * u64::from(*offset), its);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_hold_all_items_in_order_within_the_limit() {
        let sizes = [5u64, 5, 1, 9, 10, 11, 2];
        let ranges = divide(&sizes, 10, |size| *size);
        assert_eq!(ranges, [0..2, 2..4, 4..5, 5..6, 6..7]);
        assert_eq!(divide(&sizes, 100, |size| *size), vec![0..sizes.len()]);
        assert!(divide(&[] as &[u64], 10, |size| *size).is_empty());
    }
}
