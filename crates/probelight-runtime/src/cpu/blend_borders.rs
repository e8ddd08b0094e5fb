//! Second half of stage 4: receivers beside the borders between clusters.

use std::ops::Range;

use probelight_asset::packed::STEEPEST_SLOPE;
use probelight_asset::{BorderBlend, Cluster};
use probelight_math::glam::Vec3;
use rayon::prelude::*;

use super::scatter::Scatter;
use crate::ClusterExtent;
use crate::frame::ReceiverPlace;

/// The blended irradiance of the receivers beside borders.
#[derive(Clone, Debug)]
pub(super) struct BlendBorders {
    records: Vec<BorderBlend>,
    /// Which of them are those of each receiver beside a border.
    ranges: Vec<Range<usize>>,
    /// Where that receiver is.
    places: Vec<ReceiverPlace>,
    blended: Vec<Vec3>,
    copies: Scatter,
}

impl BlendBorders {
    /// Prepares for the borders' records, sorted by receiver.
    pub(super) fn new(clusters: &[Cluster], records: Vec<BorderBlend>) -> Self {
        let mut end = 0;
        let range = |records: &[BorderBlend]| {
            end += records.len();
            end - records.len()..end
        };
        let ranges: Vec<_> = BorderBlend::by_receiver(&records).map(range).collect();
        let receivers: Vec<u32> =
            BorderBlend::by_receiver(&records).map(|records| records[0].receiver).collect();
        Self {
            places: ReceiverPlace::of(clusters, &receivers),
            blended: vec![Vec3::ZERO; ranges.len()],
            copies: Scatter::new(receivers.into_iter().zip(0..)),
            ranges,
            records,
        }
    }

    /// Blends the irradiance, W/m², of the receivers that a frame of such extents computes; others were blended when they were computed.
    pub(super) fn blend_borders(&mut self, clusters: &[ClusterExtent], irradiance: &mut [Vec3]) {
        let (gathered, records) = (&*irradiance, &self.records);
        let receivers = self.ranges.par_iter().zip(&self.places);
        self.blended.par_iter_mut().zip(receivers).for_each(|(value, (range, place))| {
            let records = &records[range.clone()];
            *value = if place.is_computed(clusters) {
                blend(gathered, records)
            } else {
                gathered[records[0].receiver as usize]
            };
        });
        self.copies.copy(&self.blended, irradiance);
    }
}

/// The irradiance of the receiver of some records: the mean of what its own cluster says, counted twice, and what
/// its neighbours' clusters would say, continued to it. What is continued stays between the three values that it is
/// made of and meets, so that nothing beside the edge of a shadow is brighter than all around.
fn blend(gathered: &[Vec3], records: &[BorderBlend]) -> Vec3 {
    let own = gathered[records[0].receiver as usize];
    let continued = |record: &BorderBlend| {
        let [neighbor, beyond] = [record.neighbor, record.beyond].map(|i| gathered[i as usize]);
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
        BlendBorders::new(&clusters, border_blends.collect()).blend_borders(&extents, &mut irradiance);
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
    fn what_was_not_computed_is_not_blended_again() {
        let row = [3.0, 3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0];
        let first =
            |cluster| ClusterExtent { receivers: if cluster == 0 { 9 } else { 0 }, ..ClusterExtent::ALL };
        assert_eq!(blended_where(&row, first), [3.0, 3.0, 3.0, 4.0, 6.0, 6.0, 6.0, 6.0]);
        let three = |_| ClusterExtent { receivers: 3, ..ClusterExtent::ALL };
        assert_eq!(blended_where(&row, three), [3.0, 3.0, 3.0, 3.0, 5.0, 6.0, 6.0, 6.0]);
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
