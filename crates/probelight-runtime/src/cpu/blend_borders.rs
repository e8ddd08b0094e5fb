//! Second half of stage 4: receivers beside the borders between clusters.

use std::ops::Range;

use probelight_asset::packed::STEEPEST_SLOPE;
use probelight_asset::{BorderBlend, Cluster};
use probelight_math::glam::Vec3;

use super::stretches::{CLUSTERS_PER_TASK, for_each_stretch};
use crate::ClusterExtent;
use crate::frame::{BORDER_SLOT, BorderRecord, ReceiverPlace, border_records};

/// The light of the receivers beside borders, as it was gathered and as it is blended.
#[derive(Clone, Debug)]
pub(super) struct BlendBorders {
    receivers: Vec<BorderReceiver>,
    records: Vec<BorderRecord>,
    /// Of each of these receivers, as gathered.
    unblended: Vec<Vec3>,
    blended: Vec<Blended>,
    /// Of each cluster the first of these receivers, and how many there are of all.
    first_slots: Vec<u32>,
    /// Of each cluster the first of all receivers.
    first_receivers: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Blended {
    light: Vec3,
    /// Whether the present frame blended it.
    is_fresh: bool,
}

#[derive(Clone, Debug)]
struct BorderReceiver {
    receiver: u32,
    place: ReceiverPlace,
    records: Range<usize>,
}

impl BlendBorders {
    /// Prepares for the borders' blends, sorted by receiver.
    pub(super) fn new(clusters: &[Cluster], blends: &[BorderBlend]) -> Self {
        let mut records = Vec::new();
        let receiver = |(receiver, its): (u32, Vec<BorderRecord>)| {
            let first = records.len();
            records.extend(its);
            BorderReceiver {
                receiver,
                place: ReceiverPlace::at(clusters, receiver),
                records: first..records.len(),
            }
        };
        let receivers: Vec<_> = border_records(clusters, blends).into_iter().map(receiver).collect();
        let first_slot = |cluster: usize| {
            receivers.partition_point(|border| (border.place.cluster as usize) < cluster) as u32
        };
        Self {
            first_slots: (0..=clusters.len()).map(first_slot).collect(),
            first_receivers: clusters.iter().map(|cluster| cluster.first_receiver).collect(),
            unblended: vec![Vec3::ZERO; receivers.len()],
            blended: vec![Blended::default(); receivers.len()],
            receivers,
            records,
        }
    }

    /// The receivers beside borders, in ascending order.
    pub(super) fn receivers(&self) -> impl Iterator<Item = u32> {
        self.receivers.iter().map(|border| border.receiver)
    }

    /// Forgets all light.
    pub(super) fn clear(&mut self) {
        self.unblended.fill(Vec3::ZERO);
    }

    /// Blends the irradiance, W/m², of the receivers beside borders of the clusters that a frame of such extents computes;
    /// those of all touched clusters (by number) are among these.
    pub(super) fn blend_borders(
        &mut self,
        clusters: &[ClusterExtent],
        irradiance: &mut [Vec3],
        is_touched: &(impl Fn(u32) -> bool + Sync),
    ) {
        let Self { receivers, records, unblended, blended, first_slots, first_receivers } = self;
        let all = 0..clusters.len();
        let slot = |cluster: usize| first_slots[cluster] as usize;
        for_each_stretch(all.clone(), CLUSTERS_PER_TASK, &mut unblended[..], &slot, &|cluster, unblended| {
            let its = receivers[slot(cluster)..slot(cluster + 1)].iter();
            if clusters[cluster].receivers > 0 {
                for (light, border) in
                    unblended.iter_mut().zip(its).filter(|(_, it)| it.place.is_computed(clusters))
                {
                    *light = irradiance[border.receiver as usize];
                }
            }
        });
        let light = |source: u32| match source & BORDER_SLOT {
            0 => irradiance[source as usize],
            _ => unblended[(source ^ BORDER_SLOT) as usize],
        };
        let runs = |cluster: u32| clusters[cluster as usize].receivers > 0;
        for_each_stretch(all.clone(), CLUSTERS_PER_TASK, &mut blended[..], &slot, &|cluster, blended| {
            if !is_touched(cluster as u32) {
                return;
            }
            let its = slot(cluster)..slot(cluster + 1);
            for ((value, border), own) in blended.iter_mut().zip(&receivers[its.clone()]).zip(&unblended[its])
            {
                let records = &records[border.records.clone()];
                value.is_fresh = runs(cluster as u32) || records.iter().any(|record| runs(record.across));
                if value.is_fresh {
                    value.light = blend(*own, records, light);
                }
            }
        });
        let count = irradiance.len();
        let first = |cluster: usize| first_receivers.get(cluster).map_or(count, |first| *first as usize);
        for_each_stretch(all, CLUSTERS_PER_TASK, irradiance, &first, &|cluster, irradiance| {
            if is_touched(cluster as u32) {
                let its = slot(cluster)..slot(cluster + 1);
                let fresh = receivers[its.clone()].iter().zip(&blended[its]).filter(|(_, it)| it.is_fresh);
                for (border, value) in fresh {
                    irradiance[border.place.index as usize] = value.light;
                }
            }
        });
    }
}

/// The irradiance of a receiver with some records: the mean of what its own cluster says, counted twice, and what
/// its neighbours' clusters would say, continued to it. What is continued stays between the three values that it is
/// made of and meets, so that nothing beside the edge of a shadow is brighter than all around.
fn blend(own: Vec3, records: &[BorderRecord], light: impl Fn(u32) -> Vec3) -> Vec3 {
    let continued = |record: &BorderRecord| {
        let [neighbor, beyond] = [record.neighbor, record.beyond].map(&light);
        let steepest = STEEPEST_SLOPE * neighbor.abs();
        let continued = neighbor + (neighbor - beyond).clamp(-steepest, steepest);
        continued.max(neighbor.min(beyond).min(own)).min(neighbor.max(beyond).max(own))
    };
    let sum: Vec3 = records.iter().map(continued).sum();
    (2.0 * own + sum) / (records.len() + 2) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Irradiance along a row of receivers, blended where clusters of four meet.
    fn blended(row: &[f32]) -> Vec<f32> {
        blended_where(row, |_| ClusterExtent::ALL)
    }

    /// [`blended`] as far as clusters are computed.
    fn blended_where(row: &[f32], extent: impl Fn(usize) -> ClusterExtent) -> Vec<f32> {
        let cluster = |first: usize| Cluster {
            first_receiver: first as u32,
            receiver_count: (row.len() - first).min(4) as u32,
            ..Cluster::default()
        };
        let clusters: Vec<Cluster> = (0..row.len()).step_by(4).map(cluster).collect();
        let extents: Vec<ClusterExtent> = (0..clusters.len()).map(extent).collect();
        let border_blends = (0..row.len() as u32).filter_map(|receiver| match receiver % 4 {
            3 if receiver + 2 < row.len() as u32 => {
                Some(BorderBlend { receiver, neighbor: receiver + 1, beyond: receiver + 2 })
            }
            0 if receiver >= 2 => {
                Some(BorderBlend { receiver, neighbor: receiver - 1, beyond: receiver - 2 })
            }
            _ => None,
        });
        let mut irradiance: Vec<Vec3> = row.iter().map(|value| Vec3::splat(*value)).collect();
        let mut borders = BlendBorders::new(&clusters, &border_blends.collect::<Vec<_>>());
        // What is not computed has kept what was gathered for it before.
        let all = vec![ClusterExtent::ALL; clusters.len()];
        borders.blend_borders(&all, &mut irradiance.clone(), &|_| true);
        borders.blend_borders(&extents, &mut irradiance, &|_| true);
        irradiance.iter().map(|value| value.x).collect()
    }

    #[test]
    fn slopes_stay_and_jumps_become_three_steps() {
        let slope: Vec<f32> = (0..12).map(|x| 5.0 + 0.5 * x as f32).collect();
        for (blended, value) in blended(&slope).iter().zip(&slope) {
            assert!((blended - value).abs() < 1e-5);
        }
        let jump = blended(&[3.0, 3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0]);
        assert_eq!(jump, [3.0, 3.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0]);
    }

    #[test]
    fn only_borders_of_what_is_computed_are_blended_again() {
        let row = [3.0, 3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0, 9.0, 9.0, 9.0, 9.0];
        let only = |computed| {
            move |cluster| ClusterExtent {
                receivers: if cluster == computed { 9 } else { 0 },
                ..ClusterExtent::ALL
            }
        };
        // Both sides of a border, even if one alone is computed; others keep what they have.
        assert_eq!(
            blended_where(&row, only(0)),
            [3.0, 3.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0, 9.0, 9.0, 9.0, 9.0]
        );
        assert_eq!(
            blended_where(&row, only(2)),
            [3.0, 3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 7.0, 8.0, 9.0, 9.0, 9.0]
        );
    }

    #[test]
    fn shadow_edges_are_not_continued() {
        let row = blended(&[1.0, 1.0, 1.0, 1.0, 8.0, 90.0, 90.0, 90.0]);
        // Not 8 − 82.
        assert!((row[3] - (2.0 + 6.0) / 3.0).abs() < 1e-5, "{row:?}");
    }

    #[test]
    fn nothing_beside_a_shadow_gets_brighter_than_all_around() {
        let row = blended(&[4.0, 4.0, 4.0, 4.0, 4.0, 0.0, 0.0, 0.0]);
        assert_eq!(row[..5], [4.0; 5]);
        // Negative control: light that goes on rising is continued.
        assert!(blended(&[4.0, 4.0, 4.0, 5.0, 4.0, 3.5, 0.0, 0.0])[3] > (2.0 * 5.0 + 4.0) / 3.0);
    }
}
