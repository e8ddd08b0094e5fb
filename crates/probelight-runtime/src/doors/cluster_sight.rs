//! How light gets to a cluster by the room around a door.

use std::f32::consts::{PI, TAU};
use std::ops::Range;

use probelight_asset::BakedScene;
use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};

use super::carriers::{Carrier, Carriers, columns_of};
use super::open_ways::OpenWays;
use super::ray_box::PlacedBox;
use super::region::Region;
use super::signal_tables::{Place, SignalTables};

/// Rays of a place into the room around the door, and all around.
const RAYS_TO_DOOR: usize = 24;
const RAYS_AROUND: usize = 24;

/// How light gets to a cluster.
#[derive(Debug)]
pub(super) struct ClusterSight {
    cluster: u32,
    /// Those by the room around a door.
    ways: Vec<Way>,
    /// What carries their light, way by way.
    carriers: Vec<Carrier>,
    /// How much light of each carrier came by all ways.
    totals: Vec<f32>,
    /// Where the cluster's receivers are, metres.
    middle: Vec3,
    /// Carriers that no ray found, and where their light comes from, metres.
    unseen: Vec<(Carrier, Vec3)>,
}

/// A straight way of light to a cluster.
#[derive(Clone, Debug)]
struct Way {
    receiver: Vec3,
    source: Vec3,
    /// Solid angle times cosine.
    weight: f32,
    carriers: Range<u32>,
}

impl ClusterSight {
    /// `None` if the cluster sees nothing of the region.
    pub(super) fn of(
        baked: &BakedScene,
        tables: &SignalTables,
        region: &Region<'_>,
        number: u32,
    ) -> Option<Self> {
        let carriers = Carriers::of(baked, tables, &baked.clusters[number as usize]);
        let places = &tables.places[number as usize];
        let middle = places.iter().map(|place| place.position).sum::<Vec3>() / places.len().max(1) as f32;
        let mut sight = Self {
            cluster: number,
            ways: Vec::new(),
            carriers: Vec::new(),
            totals: vec![0.0; carriers.count()],
            middle,
            unseen: Vec::new(),
        };
        for (index, place) in (0..).zip(places) {
            sight.look_at_region(&carriers, region, place, hash_pair(number, index));
        }
        if sight.ways.is_empty() {
            return None;
        }
        for (index, place) in (0..).zip(places) {
            sight.look_around(&carriers, region, place, hash_pair(number, index));
        }
        let unseen = |sight: &Self| {
            let unseen = (0..).zip(&sight.totals).filter(|(_, total)| **total == 0.0);
            unseen.map(|(carrier, _)| carrier).collect::<Vec<Carrier>>()
        };
        for carrier in unseen(&sight) {
            sight.look_for(&carriers, region, places, carrier);
        }
        let source = |carrier| Some((carrier, carriers.source(carrier)?));
        sight.unseen = unseen(&sight).into_iter().filter_map(source).collect();
        Some(sight)
    }

    /// Looks for a patch that no ray met by chance, if its light could come by the region.
    fn look_for(&mut self, carriers: &Carriers<'_>, region: &Region<'_>, places: &[Place], carrier: Carrier) {
        let Some(signal) = carriers.signals.get(carrier as usize) else { return };
        let points = carriers.tables.parts(carriers.baked, *signal);
        let origin = |place: &Place| region.tracer.off_surface(place.position, place.normal);
        let pairs = places.iter().flat_map(|place| points.iter().map(move |point| (place, *point)));
        if !pairs.clone().any(|(place, point)| region.is_between(origin(place), point)) {
            return;
        }
        for (place, point) in pairs {
            let (origin, squared) = (origin(place), place.position.distance_squared(point));
            let direction = (point - origin).normalize_or_zero();
            let cosine = if place.normal == Vec3::ZERO { 1.0 } else { direction.dot(place.normal) };
            // Middles of patches lie on a surface, or close to it.
            let end = origin.lerp(point, 0.98);
            if cosine > 0.0 && squared > 0.0 && region.tracer.is_visible(origin, end) {
                let (weight, first) = (cosine / squared, self.carriers.len() as u32);
                self.totals[carrier as usize] += weight;
                self.carriers.push(carrier);
                self.ways.push(Way { receiver: origin, source: point, weight, carriers: first..first + 1 });
            }
        }
    }

    /// Rays through the region, evenly over the angle that it fills.
    fn look_at_region(&mut self, carriers: &Carriers<'_>, region: &Region<'_>, place: &Place, seed: u32) {
        let origin = region.tracer.off_surface(place.position, place.normal);
        let cosine = region.cosine_from(origin);
        let axis = (region.center - origin).normalize_or(Vec3::Y);
        let solid_angle = TAU * (1.0 - cosine);
        for ray in 0..RAYS_TO_DOOR as u32 {
            let u = sobol_owen(ray, seed);
            let direction = world_from_tangent(axis) * in_cone(cosine, u);
            self.follow(carriers, region, place, direction, solid_angle / RAYS_TO_DOOR as f32);
        }
    }

    /// Rays in all other directions.
    fn look_around(&mut self, carriers: &Carriers<'_>, region: &Region<'_>, place: &Place, seed: u32) {
        let origin = region.tracer.off_surface(place.position, place.normal);
        let cosine = region.cosine_from(origin);
        let axis = (region.center - origin).normalize_or(Vec3::Y);
        for ray in 0..RAYS_AROUND {
            let (direction, solid_angle) = if place.normal == Vec3::ZERO {
                let direction = spherical_fibonacci(ray, RAYS_AROUND);
                (direction, 2.0 * TAU / RAYS_AROUND as f32)
            } else {
                let u = sobol_owen(ray as u32, hash_pair(seed, 1));
                let local = cosine_hemisphere_from_square(u);
                let direction = world_from_tangent(place.normal) * local;
                let along = direction.dot(place.normal).max(1e-3);
                (direction, PI / (along * RAYS_AROUND as f32))
            };
            if direction.dot(axis) < cosine {
                self.follow(carriers, region, place, direction, solid_angle);
            }
        }
    }

    /// Notes what a ray finds, and by which way.
    fn follow(
        &mut self,
        carriers: &Carriers<'_>,
        region: &Region<'_>,
        place: &Place,
        direction: Vec3,
        solid_angle: f32,
    ) {
        let cosine = if place.normal == Vec3::ZERO { 1.0 } else { direction.dot(place.normal) };
        if cosine <= 0.0 {
            return;
        }
        let origin = region.tracer.off_surface(place.position, place.normal);
        let (distance, hit) = region.trace(origin, direction);
        let (weight, first) = (cosine * solid_angle, self.carriers.len() as u32);
        carriers.of_hit(hit.as_ref(), &mut |carrier| {
            self.totals[carrier as usize] += weight;
            self.carriers.push(carrier);
        });
        let last = self.carriers.len() as u32;
        let source = origin + distance * direction;
        // A door may also come between a probe and what it shows to the cluster.
        let comes_between = |carrier: &Carrier| {
            carriers.probe(*carrier).is_some_and(|probe| region.is_between(probe, source))
        };
        if region.is_entered(origin, direction, distance)
            || self.carriers[first as usize..].iter().any(comes_between)
        {
            self.ways.push(Way { receiver: origin, source, weight, carriers: first..last });
        } else {
            self.carriers.truncate(first as usize);
        }
    }

    /// Takes away what came by ways that the door crosses. What a probe does not see any more, it does not show either: it
    /// counts by the rest of what the cluster saw by it.
    pub(super) fn shut(&self, baked: &BakedScene, door: &PlacedBox, ways: &mut OpenWays) {
        let cluster = &baked.clusters[self.cluster as usize];
        let probes = &baked.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize];
        let probe_of = |carrier: Carrier| {
            let probe = probes.get((carrier as usize).checked_sub(cluster.signal_count as usize)?)?;
            Some(baked.probes[*probe as usize].position)
        };
        let (mut lost, mut unshown) = (vec![0.0; self.totals.len()], vec![0.0; self.totals.len()]);
        for way in &self.ways {
            let is_shut = door.crosses(way.receiver, way.source);
            for carrier in &self.carriers[way.carriers.start as usize..way.carriers.end as usize] {
                if probe_of(*carrier).is_some_and(|probe| door.crosses(probe, way.source)) {
                    unshown[*carrier as usize] += way.weight;
                } else if is_shut {
                    lost[*carrier as usize] += way.weight;
                }
            }
        }
        let mut dim = |carrier: Carrier, left: f32| {
            for columns in columns_of(baked, cluster, carrier) {
                ways.dim(baked, self.cluster, columns, left);
            }
        };
        let amounts = self.totals.iter().zip(lost).zip(unshown);
        for (carrier, ((total, lost), unshown)) in
            (0..).zip(amounts).filter(|(_, ((total, ..), _))| **total > 0.0)
        {
            let shown = total - unshown;
            // Rounding may leave a little of nothing.
            let left = if shown > 1e-4 * total { (1.0 - lost / shown).max(0.0) } else { 0.0 };
            if left < 1.0 {
                dim(carrier, left);
            }
        }
        for (carrier, _) in self.unseen.iter().filter(|(_, source)| door.crosses(self.middle, *source)) {
            dim(*carrier, 0.0);
        }
    }
}

/// A unit direction within a cone around +Z, evenly by solid angle.
fn in_cone(cosine: f32, u: Vec2) -> Vec3 {
    let z = 1.0 - u.x * (1.0 - cosine);
    let across = (1.0 - z * z).max(0.0).sqrt();
    let around = TAU * u.y;
    Vec3::new(across * around.cos(), across * around.sin(), z)
}
