//! How receivers that a level of the lightmap leaves out get their light from those that it has.
//!
//! A receiver lies in a square of computed texels, 2ⁿ wide. It mixes those of the four corners that belong to its cluster
//! as a bilinear lookup would; without any, it takes the nearest receiver of its cluster. So no light gets from one cluster
//! to another, and even light stays even.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BakedScene, Cluster};

use super::planner::{LIGHTMAP_LEVELS, leading_receivers};

/// Parts of a weight: those of a byte.
const FILL_STEPS: u32 = 255;

/// What one receiver is mixed from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct FillRecord {
    /// Four receivers of its cluster, counted within that: two to a word.
    pub(crate) sources: [u32; 2],
    /// Their weights, a byte each, together 255.
    pub(crate) weights: u32,
}

/// A record for each receiver of the lightmap: all of level 1, all of level 2, … as far as levels are used.
#[derive(Clone, Debug, Default)]
pub(crate) struct FillTables {
    pub(crate) records: Vec<FillRecord>,
    receivers: usize,
}

impl FillTables {
    /// For levels up to `coarsest` of the lightmap.
    pub(crate) fn new(baked: &BakedScene, coarsest: u32) -> Self {
        let receivers = baked.receiver_texels.len();
        let levels = 1..=(coarsest as usize).min(LIGHTMAP_LEVELS - 1);
        let mut records = Vec::with_capacity(levels.clone().count() * receivers);
        for level in levels {
            let clusters = baked.clusters[..baked.lightmap_clusters()].iter();
            clusters.for_each(|cluster| records.extend(records_of(baked, cluster, level)));
        }
        Self { records, receivers }
    }

    /// Levels that there are records for.
    pub(crate) fn levels(&self) -> usize {
        self.records.len() / self.receivers.max(1)
    }

    /// The records of a cluster at level n of the lightmap.
    #[cfg(feature = "cpu")]
    pub(crate) fn of(&self, cluster: &Cluster, level: u32) -> &[FillRecord] {
        let first = (level as usize - 1) * self.receivers + cluster.first_receiver as usize;
        &self.records[first..first + cluster.receiver_count as usize]
    }
}

/// Where a receiver lies, and its number within its cluster.
type Place = ([u32; 2], u32);

fn records_of(baked: &BakedScene, cluster: &Cluster, level: usize) -> Vec<FillRecord> {
    let width = baked.lightmap.width;
    let place = |texel: &u32| [texel % width, texel / width];
    let texels = baked.texels(cluster);
    // Sources are numbers of sixteen bits.
    let leading = (leading_receivers(baked, cluster)[level] as usize).min(1 << 16);
    let mut computed: Vec<Place> = texels[..leading].iter().map(place).zip(0..).collect();
    computed.sort_unstable();
    texels.iter().map(|texel| record(place(texel), &computed, 1 << level)).collect()
}

/// The record of a texel between computed ones, `step` apart, sorted by their place.
fn record([x, y]: [u32; 2], computed: &[Place], step: u32) -> FillRecord {
    let [left, top] = [x, y].map(|c| c / step * step);
    let [right_share, lower_share] = [x - left, y - top].map(|c| c as f32 / step as f32);
    let corners = [(0, 0), (step, 0), (0, step), (step, step)];
    let share = |first: bool, share: f32| if first { 1.0 - share } else { share };
    let mut found = corners.map(|(right, down)| {
        let place = [left + right, top + down];
        let source = computed.binary_search_by_key(&place, |(place, _)| *place).ok();
        let weight = share(right == 0, right_share) * share(down == 0, lower_share);
        source.map_or((0, 0.0), |index| (computed[index].1, weight))
    });
    let sum: f32 = found.iter().map(|(_, weight)| weight).sum();
    if sum <= 0.0 {
        let distance = |([a, b], _): &&Place| a.abs_diff(x).pow(2) + b.abs_diff(y).pow(2);
        let nearest = computed.iter().min_by_key(distance).map_or(0, |(_, number)| *number);
        found = [(nearest, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
    } else {
        found.iter_mut().for_each(|(_, weight)| *weight /= sum);
    }
    let mut steps = found.map(|(_, weight)| (weight * FILL_STEPS as f32).round() as u32);
    // What rounding lost or won goes to the largest, which is at least a quarter.
    let largest = (0..4).max_by_key(|corner| steps[*corner]).unwrap_or(0);
    let others = steps.iter().sum::<u32>() - steps[largest];
    steps[largest] = FILL_STEPS - others;
    let [a, b, c, d] = found.map(|(number, _)| number);
    FillRecord {
        sources: [a | b << 16, c | d << 16],
        weights: steps[0] | steps[1] << 8 | steps[2] << 16 | steps[3] << 24,
    }
}

impl FillRecord {
    /// Sources with their weights.
    #[cfg(any(feature = "cpu", test))]
    pub(crate) fn parts(self) -> [(usize, f32); 4] {
        let [ab, cd] = self.sources;
        let sources = [ab & 0xffff, ab >> 16, cd & 0xffff, cd >> 16];
        let weights = self.weights.to_le_bytes().map(|steps| f32::from(steps) / FILL_STEPS as f32);
        std::array::from_fn(|i| (sources[i] as usize, weights[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light at a texel.
    fn light([x, y]: [u32; 2]) -> f32 {
        3.0 + 0.5 * x as f32 + 0.25 * y as f32
    }

    fn filled(at: [u32; 2], computed: &[Place], step: u32) -> f32 {
        let mut by_number = computed.to_vec();
        by_number.sort_unstable_by_key(|(_, number)| *number);
        let parts = record(at, computed, step).parts().into_iter().filter(|(_, weight)| *weight > 0.0);
        parts.map(|(number, weight)| weight * light(by_number[number].0)).sum()
    }

    /// Every fourth texel of a square of 16, numbered from the end.
    fn square() -> Vec<Place> {
        let mut places: Vec<Place> = (0..16).map(|i| ([i % 4 * 4, i / 4 * 4], 15 - i)).collect();
        places.sort_unstable();
        places
    }

    #[test]
    fn gradients_are_continued_between_computed_texels() {
        for at in (0..12 * 12).map(|i| [i % 12, i / 12]) {
            let found = filled(at, &square(), 4);
            assert!((found - light(at)).abs() < 0.03, "{at:?}: {found}, not {}", light(at));
        }
        // Negative control: the nearest alone would not do.
        assert!((light([4, 4]) - light([6, 6])).abs() > 1.0);
    }

    #[test]
    fn where_a_cluster_ends_the_rest_is_mixed() {
        let weights = |at, computed: &[Place]| {
            record(at, computed, 4).parts().map(|(_, weight)| weight).iter().sum::<f32>()
        };
        for at in (0..20 * 20).map(|i| [i % 20, i / 20]) {
            assert!((weights(at, &square()) - 1.0).abs() < 1e-6, "even light stays even at {at:?}");
        }
        assert_eq!(filled([15, 15], &square(), 4), light([12, 12]));
        let one = [([8, 0], 0)];
        assert_eq!(filled([1, 9], &one, 4), light([8, 0]), "the nearest where no corner is the cluster's");
    }
}
