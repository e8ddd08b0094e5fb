//! How light gets to a cluster by the room around a door.

use std::f32::consts::{PI, TAU};
use std::ops::Range;

use probelight_asset::BakedScene;
use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{cosine_hemisphere_from_square, hash_pair, sobol_owen, world_from_tangent};

use super::carriers::{Carrier, CarrierSearch, Carriers};
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
        let search = CarrierSearch::new(baked, tables, &baked.clusters[number as usize]);
        let places = &tables.places[number as usize];
        let middle = places.iter().map(|place| place.origin).sum::<Vec3>() / places.len().max(1) as f32;
        let mut sight = Self {
            cluster: number,
            ways: Vec::new(),
            carriers: Vec::new(),
            totals: vec![0.0; search.carriers.count()],
            middle,
            unseen: Vec::new(),
        };
        for (index, place) in (0..).zip(places) {
            sight.look_at_region(&search, region, place, hash_pair(number, index));
        }
        if sight.ways.is_empty() {
            return None;
        }
        for (index, place) in (0..).zip(places) {
            sight.look_around(&search, region, place, hash_pair(number, index));
        }
        let unseen = |sight: &Self| {
            let unseen = (0..).zip(&sight.totals).filter(|(_, total)| **total == 0.0);
            unseen.map(|(carrier, _)| carrier).collect::<Vec<Carrier>>()
        };
        for carrier in unseen(&sight) {
            sight.look_for(&search, region, places, carrier);
        }
        let source = |carrier| Some((carrier, search.source(carrier)?));
        sight.unseen = unseen(&sight).into_iter().filter_map(source).collect();
        Some(sight)
    }

    /// Looks for a patch that no ray met by chance, if its light could come by the region.
    fn look_for(
        &mut self,
        search: &CarrierSearch<'_>,
        region: &Region<'_>,
        places: &[Place],
        carrier: Carrier,
    ) {
        let points = search.parts(carrier);
        let pairs = places.iter().flat_map(|place| points.iter().map(move |point| (place, *point)));
        if !pairs.clone().any(|(place, point)| region.is_between(place.origin, point)) {
            return;
        }
        for (place, point) in pairs {
            let offset = point - place.origin;
            let (squared, cosine) = (offset.length_squared(), place.cosine(offset.normalize_or_zero()));
            // Middles of patches lie on a surface, or close to it.
            let end = place.origin.lerp(point, 0.98);
            if cosine > 0.0 && squared > 0.0 && region.tracer.is_visible(place.origin, end) {
                let (weight, first) = (cosine / squared, self.carriers.len() as u32);
                self.totals[carrier as usize] += weight;
                self.carriers.push(carrier);
                let (receiver, carriers) = (place.origin, first..first + 1);
                self.ways.push(Way { receiver, source: point, weight, carriers });
            }
        }
    }

    /// Rays through the region, evenly over the angle that it fills.
    fn look_at_region(&mut self, search: &CarrierSearch<'_>, region: &Region<'_>, place: &Place, seed: u32) {
        let (axis, cosine) = region.cone_from(place.origin);
        let solid_angle = TAU * (1.0 - cosine) / RAYS_TO_DOOR as f32;
        for ray in 0..RAYS_TO_DOOR as u32 {
            let direction = world_from_tangent(axis) * in_cone(cosine, sobol_owen(ray, seed));
            self.follow(search, region, place, direction, solid_angle);
        }
    }

    /// Rays in all other directions.
    fn look_around(&mut self, search: &CarrierSearch<'_>, region: &Region<'_>, place: &Place, seed: u32) {
        let (axis, cosine) = region.cone_from(place.origin);
        for ray in 0..RAYS_AROUND {
            let (direction, solid_angle) = if place.is_in_air() {
                (spherical_fibonacci(ray, RAYS_AROUND), 2.0 * TAU / RAYS_AROUND as f32)
            } else {
                let u = sobol_owen(ray as u32, hash_pair(seed, 1));
                let direction = world_from_tangent(place.normal) * cosine_hemisphere_from_square(u);
                let along = place.cosine(direction).max(1e-3);
                (direction, PI / (along * RAYS_AROUND as f32))
            };
            if direction.dot(axis) < cosine {
                self.follow(search, region, place, direction, solid_angle);
            }
        }
    }

    /// Notes what a ray finds, and by which way.
    fn follow(
        &mut self,
        search: &CarrierSearch<'_>,
        region: &Region<'_>,
        place: &Place,
        direction: Vec3,
        solid_angle: f32,
    ) {
        let weight = place.cosine(direction) * solid_angle;
        if weight <= 0.0 {
            return;
        }
        let (distance, hit) = region.trace(place.origin, direction);
        let first = self.carriers.len() as u32;
        search.of_hit(hit.as_ref(), &mut |carrier| {
            self.totals[carrier as usize] += weight;
            self.carriers.push(carrier);
        });
        let last = self.carriers.len() as u32;
        let source = place.origin + distance * direction;
        // A door may also come between a probe and what it shows to the cluster.
        let comes_between = |carrier: &Carrier| {
            search.carriers.probe(*carrier).is_some_and(|probe| region.is_between(probe, source))
        };
        if region.is_entered(place.origin, direction, distance)
            || self.carriers[first as usize..].iter().any(comes_between)
        {
            self.ways.push(Way { receiver: place.origin, source, weight, carriers: first..last });
        } else {
            self.carriers.truncate(first as usize);
        }
    }

    /// Takes away what came by ways that the door crosses. What a probe does not see any more, it does not show either: it
    /// counts by the rest of what the cluster saw by it.
    pub(super) fn shut(&self, baked: &BakedScene, door: &PlacedBox, ways: &mut OpenWays) {
        let carriers = Carriers::of(baked, &baked.clusters[self.cluster as usize]);
        let (mut lost, mut unshown) = (vec![0.0; self.totals.len()], vec![0.0; self.totals.len()]);
        for way in &self.ways {
            let is_shut = door.crosses(way.receiver, way.source);
            for carrier in &self.carriers[way.carriers.start as usize..way.carriers.end as usize] {
                if carriers.probe(*carrier).is_some_and(|probe| door.crosses(probe, way.source)) {
                    unshown[*carrier as usize] += way.weight;
                } else if is_shut {
                    lost[*carrier as usize] += way.weight;
                }
            }
        }
        let mut dim = |carrier: Carrier, left: f32| {
            ways.dim(baked, self.cluster, &carriers.columns(carrier), left);
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
