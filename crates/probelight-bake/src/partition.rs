//! Grouping receivers into clusters: a kd-tree over position and normal (\[SED\] §3.3).

use std::collections::BTreeMap;

use probelight_math::glam::Vec3;

use crate::receivers::Receiver;

/// Splits receivers by position and by the direction they face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KdRule {
    /// Metres that a unit difference of normals counts as.
    pub(crate) meters_per_normal: f32,
}

impl KdRule {
    /// Coordinate of a receiver along one of the six axes, metres.
    fn coordinate(self, receiver: &Receiver, axis: usize) -> f32 {
        if axis < 3 { receiver.position[axis] } else { receiver.normal[axis - 3] * self.meters_per_normal }
    }

    /// Halves a group at the median of its widest axis; ties go by texel, so the result does not depend on
    /// the input order.
    pub(crate) fn split(self, receivers: &[Receiver], mut group: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
        let extent = |axis| {
            let (low, high) = group.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), r| {
                let value = self.coordinate(&receivers[*r as usize], axis);
                (low.min(value), high.max(value))
            });
            high - low
        };
        let axis = (0..6).max_by(|a, b| extent(*a).total_cmp(&extent(*b)).then(b.cmp(a))).unwrap_or(0);
        group.sort_unstable_by(|a, b| {
            let value = |r: &u32| self.coordinate(&receivers[*r as usize], axis);
            value(a).total_cmp(&value(b)).then(a.cmp(b))
        });
        let upper = group.split_off(group.len() / 2);
        (group, upper)
    }

    /// Groups of at most `largest` receivers, never mixing air spaces.
    pub(crate) fn partition(
        self,
        receivers: &[Receiver],
        air_spaces: &[u32],
        largest: usize,
    ) -> Vec<Vec<u32>> {
        let mut by_space: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (receiver, space) in air_spaces.iter().enumerate() {
            by_space.entry(*space).or_default().push(receiver as u32);
        }
        let mut pending: Vec<Vec<u32>> = by_space.into_values().rev().collect();
        let mut groups = Vec::new();
        while let Some(group) = pending.pop() {
            if group.len() <= largest {
                groups.push(group);
            } else {
                let (lower, upper) = self.split(receivers, group);
                pending.push(upper);
                pending.push(lower);
            }
        }
        groups
    }
}

/// Mean position of a group, metres.
pub(crate) fn centroid(receivers: &[Receiver], group: &[u32]) -> Vec3 {
    let sum: Vec3 = group.iter().map(|r| receivers[*r as usize].position).sum();
    sum / group.len().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receivers() -> Vec<Receiver> {
        (0..1000u32)
            .map(|i| Receiver {
                texel: i,
                position: Vec3::new((i % 50) as f32 * 0.1, (i / 50) as f32 * 0.1, 0.0),
                normal: if i % 2 == 0 { Vec3::Z } else { Vec3::NEG_Z },
            })
            .collect()
    }

    #[test]
    fn groups_cover_every_receiver_once_and_respect_size_and_air_space() {
        let receivers = receivers();
        let spaces: Vec<u32> = receivers.iter().map(|r| u32::from(r.position.x > 3.0)).collect();
        let groups = KdRule { meters_per_normal: 1.0 }.partition(&receivers, &spaces, 100);
        let mut seen: Vec<u32> = groups.iter().flatten().copied().collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..1000).collect::<Vec<_>>());
        for group in &groups {
            assert!(group.len() <= 100);
            assert!(group.iter().all(|r| spaces[*r as usize] == spaces[group[0] as usize]));
        }
    }

    #[test]
    fn opposite_normals_are_separated_where_they_outweigh_the_distance() {
        let receivers = receivers();
        let split = |meters_per_normal| {
            let (lower, _) = KdRule { meters_per_normal }.split(&receivers, (0..1000).collect());
            lower.iter().all(|r| receivers[*r as usize].normal == receivers[lower[0] as usize].normal)
        };
        assert!(split(100.0));
        assert!(!split(0.01));
    }
}
