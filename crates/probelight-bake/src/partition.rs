//! Grouping sites into clusters: a kd-tree over position, normal and outlook (\[SED\] §3.3).
//!
//! The outlook, the nearest probe that a site sees, tells apart neighbours that see different things:
//! the two sides of a thin wall, or a roof and the ceiling below it.

use std::collections::BTreeMap;
use std::ops::Range;

use probelight_math::glam::Vec3;

use crate::ground::site::Site;

/// Axes of the tree: three each of position, normal and outlook.
const AXES: usize = 9;

/// Splits sites by position, by the direction they face, and by outlook.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KdRule {
    /// Metres that a unit difference of normals counts as.
    pub(crate) meters_per_normal: f32,
    /// Whether outlooks count.
    pub(crate) by_outlook: bool,
}

impl KdRule {
    /// Coordinate of a site along one of the axes, metres.
    fn coordinate(self, site: &Site, axis: usize) -> f32 {
        match axis / 3 {
            0 => site.position[axis],
            1 => site.normal[axis - 3] * self.meters_per_normal,
            _ => site.outlook.map_or(site.position, |outlook| outlook.position)[axis - 6],
        }
    }

    /// Extent of a group along each axis, metres.
    fn extents(self, sites: &[Site], group: &[u32]) -> [f32; AXES] {
        std::array::from_fn(|axis| {
            if axis >= 6 && !self.by_outlook {
                return 0.0;
            }
            let (low, high) = group.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), r| {
                let value = self.coordinate(&sites[*r as usize], axis);
                (low.min(value), high.max(value))
            });
            high - low
        })
    }

    /// The largest extent of a group along any axis, metres.
    pub(crate) fn extent(self, sites: &[Site], group: &[u32]) -> f32 {
        self.extents(sites, group).into_iter().fold(0.0, f32::max)
    }

    /// Halves a group at the median of its widest axis; ties go by texel, so the result does not depend on
    /// the input order.
    pub(crate) fn split(self, sites: &[Site], mut group: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
        let extents = self.extents(sites, &group);
        let axis = (0..AXES).max_by(|a, b| extents[*a].total_cmp(&extents[*b]).then(b.cmp(a))).unwrap_or(0);
        let half = group.len() / 2;
        group.select_nth_unstable_by(half, |a, b| {
            let value = |r: &u32| self.coordinate(&sites[*r as usize], axis);
            value(a).total_cmp(&value(b)).then(a.cmp(b))
        });
        let mut upper = group.split_off(half);
        group.sort_unstable();
        upper.sort_unstable();
        (group, upper)
    }

    /// Groups of at most `largest` of some sites, never mixing rooms.
    pub(crate) fn partition(self, sites: &[Site], numbers: Range<u32>, largest: usize) -> Vec<Vec<u32>> {
        let mut pending: Vec<Vec<u32>> = by_room(sites, numbers).into_iter().rev().collect();
        let mut groups = Vec::new();
        while let Some(group) = pending.pop() {
            if group.len() <= largest {
                groups.push(group);
            } else {
                let (lower, upper) = self.split(sites, group);
                pending.push(upper);
                pending.push(lower);
            }
        }
        groups
    }
}

/// Some sites, those of each room together; no room is part of two air spaces.
pub(crate) fn by_room(sites: &[Site], numbers: Range<u32>) -> Vec<Vec<u32>> {
    group_by(sites, numbers, Site::room)
}

/// Some sites, those of each air space together.
pub(crate) fn by_air_space(sites: &[Site], numbers: Range<u32>) -> Vec<Vec<u32>> {
    group_by(sites, numbers, Site::air_space)
}

/// Some sites, those with the same key together.
fn group_by(sites: &[Site], numbers: Range<u32>, key: fn(&Site) -> Option<u32>) -> Vec<Vec<u32>> {
    let mut groups: BTreeMap<Option<u32>, Vec<u32>> = BTreeMap::new();
    for number in numbers {
        groups.entry(key(&sites[number as usize])).or_default().push(number);
    }
    groups.into_values().collect()
}

/// Mean position of a group, metres.
pub(crate) fn centroid(sites: &[Site], group: &[u32]) -> Vec3 {
    let sum: Vec3 = group.iter().map(|r| sites[*r as usize].position).sum();
    sum / group.len().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::site::Outlook;

    fn sites() -> Vec<Site> {
        (0..1000u32)
            .map(|i| Site {
                seed: i,
                position: Vec3::new((i % 50) as f32 * 0.1, (i / 50) as f32 * 0.1, 0.0),
                normal: if i % 2 == 0 { Vec3::Z } else { Vec3::NEG_Z },
                ..Site::default()
            })
            .collect()
    }

    #[test]
    fn groups_cover_every_site_once_and_respect_size_and_room() {
        let mut sites = sites();
        for site in &mut sites {
            let room = u32::from(site.position.x > 3.0);
            site.outlook = Some(Outlook { probe: 0, position: Vec3::ZERO, air_space: 0, room });
        }
        let groups = KdRule { meters_per_normal: 1.0, by_outlook: true }.partition(&sites, 0..1000, 100);
        let mut seen: Vec<u32> = groups.iter().flatten().copied().collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..1000).collect::<Vec<_>>());
        for group in &groups {
            assert!(group.len() <= 100);
            let outlook = |r: u32| sites[r as usize].outlook;
            assert!(group.iter().all(|r| outlook(*r) == outlook(group[0])));
        }
    }

    #[test]
    fn opposite_normals_are_separated_where_they_outweigh_the_distance() {
        let sites = sites();
        let split = |meters_per_normal| {
            let (lower, _) =
                KdRule { meters_per_normal, by_outlook: true }.split(&sites, (0..1000).collect());
            lower.iter().all(|r| sites[*r as usize].normal == sites[lower[0] as usize].normal)
        };
        assert!(split(100.0));
        assert!(!split(0.01));
    }

    #[test]
    fn outlooks_count_only_where_asked_for() {
        let mut sites = sites();
        for site in &mut sites {
            let position = if site.seed.is_multiple_of(3) { Vec3::ZERO } else { Vec3::Z * 500.0 };
            site.outlook = Some(Outlook { probe: 0, position, air_space: 0, room: 0 });
            site.normal = Vec3::Z;
        }
        let group: Vec<u32> = (0..1000).collect();
        let rule = |by_outlook| KdRule { meters_per_normal: 1.0, by_outlook };
        assert_eq!(rule(true).extent(&sites, &group), 500.0);
        assert!((rule(false).extent(&sites, &group) - 4.9).abs() < 1e-4);
        let near = |by_outlook: bool| {
            let (lower, _) = rule(by_outlook).split(&sites, group.clone());
            lower.iter().filter(|r| sites[**r as usize].seed.is_multiple_of(3)).count()
        };
        assert_eq!(near(true), 334, "all that look from nearby are on one side");
        assert!(near(false) < 200);
    }
}
