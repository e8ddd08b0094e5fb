//! Clusters that blend into each other.
//!
//! Each cluster approximates its own transport, so where two meet the irradiance would jump. A cluster therefore
//! also serves the receivers just beyond its border, and a receiver near a border takes the weighted sum of what
//! the clusters there say. The weights fall linearly across the border and sum to 1 at every receiver; they are
//! multiplied into the rows of the clusters' matrices, so that a runtime only adds.

use std::collections::{BTreeMap, HashMap};

use crate::receivers::Receiver;

/// Receivers that a cluster serves, and how much of each is its own to say.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlendedGroup {
    /// Receivers (indices): the group's own, then those of its neighbours.
    pub(crate) receivers: Vec<u32>,
    /// Number of its own.
    pub(crate) own: usize,
    /// Per receiver the group's share in its irradiance, above 0 and up to 1.
    pub(crate) weights: Vec<f32>,
}

/// Lets groups reach over their borders, by `reach` texels of a lightmap of the given width. Borders between charts
/// and air spaces stay as they are.
pub(crate) fn blend_groups(
    receivers: &[Receiver],
    lightmap_width: u32,
    groups: &[Vec<u32>],
    reach: u32,
) -> Vec<BlendedGroup> {
    let neighbourhood = Neighbourhood::new(receivers, lightmap_width, groups, reach);
    let alone = |group: &Vec<u32>| BlendedGroup {
        receivers: group.clone(),
        own: group.len(),
        weights: vec![1.0; group.len()],
    };
    let mut blended: Vec<BlendedGroup> = groups.iter().map(alone).collect();
    for (g, group) in groups.iter().enumerate() {
        for (place, receiver) in group.iter().enumerate() {
            for (other, share) in neighbourhood.shares_of_others(*receiver) {
                blended[g].weights[place] -= share;
                blended[other as usize].receivers.push(*receiver);
                blended[other as usize].weights.push(share);
            }
        }
    }
    blended
}

/// Who is near whom in the lightmap.
struct Neighbourhood<'a> {
    receivers: &'a [Receiver],
    /// Group of each receiver.
    group_of: Vec<u32>,
    receiver_of_texel: HashMap<u32, u32>,
    lightmap_width: u32,
    /// How far groups reach over their borders, texels.
    reach: u32,
}

impl<'a> Neighbourhood<'a> {
    fn new(receivers: &'a [Receiver], lightmap_width: u32, groups: &[Vec<u32>], reach: u32) -> Self {
        let mut group_of = vec![0; receivers.len()];
        for (number, group) in (0..).zip(groups) {
            group.iter().for_each(|receiver| group_of[*receiver as usize] = number);
        }
        let receiver_of_texel = receivers.iter().map(|receiver| receiver.texel).zip(0..).collect();
        Self { receivers, group_of, receiver_of_texel, lightmap_width, reach }
    }

    /// Shares of other groups than its own in a receiver's irradiance, by group.
    fn shares_of_others(&self, receiver: u32) -> Vec<(u32, f32)> {
        let distances = self.distances_to_groups(receiver);
        let Some(nearest) = distances.values().copied().reduce(f32::min) else { return Vec::new() };
        // Borders run half a texel from the receivers beside them. Weights fall from 1 at `half_width` before the
        // border of a group to 0 as far behind it.
        let half_width = self.reach as f32 + 0.5;
        let weight = |depth: f32| (0.5 + 0.5 * depth / half_width).clamp(0.0, 1.0);
        let total = weight(nearest - 0.5) + distances.values().map(|d| weight(0.5 - d)).sum::<f32>();
        let share = |(group, distance)| (group, weight(0.5 - distance) / total);
        distances.into_iter().map(share).filter(|(_, share)| *share > 0.0).collect()
    }

    /// Distance to the nearest receiver of each other group within reach, in the same chart and air space; texels.
    fn distances_to_groups(&self, receiver: u32) -> BTreeMap<u32, f32> {
        let here = &self.receivers[receiver as usize];
        let (x, y) = (here.texel % self.lightmap_width, here.texel / self.lightmap_width);
        let mut distances = BTreeMap::new();
        for (dx, dy) in square(self.reach as i32) {
            let (Some(x), Some(y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
            let texel = y * self.lightmap_width + x;
            let Some(other) = self.receiver_of_texel.get(&texel).filter(|_| x < self.lightmap_width) else {
                continue;
            };
            let (there, group) = (&self.receivers[*other as usize], self.group_of[*other as usize]);
            let is_near = there.chart == here.chart && there.air_space() == here.air_space();
            if is_near && group != self.group_of[receiver as usize] {
                let distance = f32::hypot(dx as f32, dy as f32);
                let nearest = distances.entry(group).or_insert(distance);
                *nearest = nearest.min(distance);
            }
        }
        distances
    }
}

/// All pairs of numbers from `-reach` to `reach`.
fn square(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Vec3;

    use super::*;
    use crate::receivers::Outlook;

    const SIDE: u32 = 20;

    /// A square of receivers in four groups, of which the first meets the second at x = 10.
    fn square() -> (Vec<Receiver>, Vec<Vec<u32>>) {
        let receivers = (0..SIDE * SIDE).map(|texel| Receiver { texel, ..Receiver::default() }).collect();
        let quarter = |i: &u32| u32::from(i % SIDE >= SIDE / 2) + 2 * u32::from(i / SIDE >= SIDE / 2);
        let groups = (0..4).map(|g| (0..SIDE * SIDE).filter(|i| quarter(i) == g).collect()).collect();
        (receivers, groups)
    }

    /// A group's weight at a receiver.
    fn weight(group: &BlendedGroup, receiver: u32) -> f32 {
        group.receivers.iter().position(|r| *r == receiver).map_or(0.0, |place| group.weights[place])
    }

    #[test]
    fn weights_sum_to_one_and_fall_across_borders() {
        let (receivers, groups) = square();
        let blended = blend_groups(&receivers, SIDE, &groups, 2);
        for receiver in 0..SIDE * SIDE {
            let sum: f32 = blended.iter().map(|group| weight(group, receiver)).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum} at {receiver}");
        }
        let row: Vec<f32> = (6..14).map(|x| weight(&blended[0], 3 * SIDE + x)).collect();
        for (weight, expected) in row.iter().zip([1.0, 1.0, 0.8, 0.6, 0.4, 0.2, 0.0, 0.0]) {
            assert!((weight - expected).abs() < 1e-6, "{row:?}");
        }
        // All four meet in the middle.
        assert!(blended.iter().all(|group| weight(group, 10 * SIDE + 10) > 0.1));
    }

    #[test]
    fn groups_keep_their_own_receivers_first() {
        let (receivers, groups) = square();
        for (blended, group) in blend_groups(&receivers, SIDE, &groups, 1).iter().zip(&groups) {
            assert_eq!(blended.receivers[..blended.own], group[..]);
            assert!(blended.receivers[blended.own..].iter().all(|receiver| !group.contains(receiver)));
            assert_eq!(
                blended.receivers.len(),
                group.len() + 20 + 1,
                "a row of ten on two sides, and the corner"
            );
        }
    }

    #[test]
    fn nothing_blends_without_reach_or_across_charts_and_air_spaces() {
        let (receivers, groups) = square();
        let is_alone = |receivers: &[Receiver], reach| {
            blend_groups(receivers, SIDE, &groups, reach)
                .iter()
                .all(|group| group.own == group.receivers.len() && group.weights.iter().all(|w| *w == 1.0))
        };
        assert!(is_alone(&receivers, 0) && !is_alone(&receivers, 1));
        let apart = |part: &dyn Fn(&mut Receiver, u32)| {
            let mut receivers = receivers.clone();
            for receiver in &mut receivers {
                let quarter = groups.iter().position(|group| group.contains(&receiver.texel));
                part(receiver, quarter.unwrap() as u32);
            }
            receivers
        };
        assert!(is_alone(&apart(&|receiver, quarter| receiver.chart = quarter), 1));
        let outlook = |air_space| Some(Outlook { probe: 0, position: Vec3::ZERO, air_space });
        assert!(is_alone(&apart(&|receiver, quarter| receiver.outlook = outlook(quarter)), 1));
    }
}
