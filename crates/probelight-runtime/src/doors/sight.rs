//! What probes and clusters see in the direction of a door.

use std::collections::HashMap;
use std::ops::Range;

use probelight_asset::{BakedScene, Cluster, NONE};
use probelight_math::directions::spherical_fibonacci;
use probelight_math::glam::{Vec2, Vec3};
use probelight_math::sampling::{
    cosine_hemisphere_from_square, hash_pair, sobol_owen, unit_from_bits, world_from_tangent,
};
use probelight_trace::{Hit, Ray, Tracer};
use rayon::prelude::*;

use super::Shut;
use super::open_ways::{OpenWays, rays_of};
use super::ray_box::PlacedBox;
use crate::surfels_of_texels::surfels_of_texels;

/// Places of each cluster that rays start from.
const PLACES: usize = 8;

/// Rays of a place into the room around the door, and all around.
const RAYS_TO_DOOR: usize = 24;
const RAYS_AROUND: usize = 24;

/// Rays that are asked, one after the other, to stand for what a door reflects.
const STAND_INS: u32 = 24;

/// Where light of a baked scene is evaluated, as rays find it.
#[derive(Debug)]
pub(super) struct SignalTables {
    surfel_of_texel: Vec<u32>,
    /// The group that each surfel or group is a part of, or [`NONE`].
    parents: Vec<u32>,
    /// Middle of each surfel and group, metres.
    pub(super) middles: Vec<Vec3>,
    /// The surfels that each probe sees, and [`NONE`] for the sky, sorted.
    seen: Vec<Box<[u32]>>,
    /// Of each cluster.
    pub(super) places: Vec<Vec<Place>>,
}

/// A place of a cluster's receivers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) position: Vec3,
    /// Unit normal of the surface; zero in free space.
    normal: Vec3,
}

impl SignalTables {
    pub(super) fn new(baked: &BakedScene) -> Self {
        let mut parents = vec![NONE; baked.first_emitter_signal()];
        let mean = |points: &mut dyn ExactSizeIterator<Item = Vec3>| {
            let count = points.len().max(1) as f32;
            points.sum::<Vec3>() / count
        };
        let middle =
            |surfel| mean(&mut baked.samples_of(surfel).iter().map(|sample| baked.place_of(sample).0));
        let mut middles: Vec<Vec3> = baked.surfels.iter().map(middle).collect();
        for (number, group) in (baked.surfels.len() as u32..).zip(&baked.surfel_groups) {
            let [first, second] = group.children.map(|child| child as usize);
            (parents[first], parents[second]) = (number, number);
            middles.push(middles[second].lerp(middles[first], group.first_weight));
        }
        let seen = (0..baked.probes.len() as u32).map(|probe| {
            let mut surfels = baked.relight_surfels[rays_of(baked, probe)].to_vec();
            surfels.sort_unstable();
            surfels.dedup();
            surfels.into()
        });
        let seen = seen.collect();
        Self { surfel_of_texel: surfels_of_texels(baked), parents, middles, seen, places: places(baked) }
    }

    /// Middles of a surfel, or of up to four parts of a group.
    fn parts(&self, baked: &BakedScene, patch: u32) -> Vec<Vec3> {
        let mut parts = vec![patch];
        for _ in 0..2 {
            let halves = |part: &u32| match (*part as usize).checked_sub(baked.surfels.len()) {
                Some(group) => baked.surfel_groups.get(group).map_or(vec![], |group| group.children.to_vec()),
                None => vec![*part],
            };
            parts = parts.iter().flat_map(halves).collect();
        }
        parts.iter().filter_map(|part| self.middles.get(*part as usize)).copied().collect()
    }

    /// The surfel that a hit lies on, or [`NONE`].
    fn surfel_of_hit(&self, baked: &BakedScene, hit: &Hit) -> u32 {
        let texel = baked.lightmap.texel(hit.triangle, hit.is_back_face, hit.barycentric);
        texel.and_then(|texel| self.surfel_of_texel.get(texel as usize)).copied().unwrap_or(NONE)
    }
}

/// Some places of each cluster, spread over its receivers.
fn places(baked: &BakedScene) -> Vec<Vec<Place>> {
    let (receivers, clusters) = (baked.receivers_of_texels(), baked.clusters_of_receivers());
    let mut places = vec![Vec::new(); baked.clusters.len()];
    for sample in &baked.light_samples {
        let receiver = receivers.get(baked.texel_of(sample) as usize);
        if let Some(cluster) = receiver.and_then(|receiver| clusters.get(*receiver as usize)) {
            let (position, normal) = baked.place_of(sample);
            places[*cluster as usize].push(Place { position, normal });
        }
    }
    if baked.has_grid() {
        for vertex in baked.grid_vertex_places() {
            let rows = baked.vertex_receivers(vertex.vertex);
            let mut of_rows: Vec<u32> = rows.iter().map(|row| clusters[*row as usize]).collect();
            of_rows.sort_unstable();
            of_rows.dedup();
            let place = Place { position: vertex.position, normal: Vec3::ZERO };
            of_rows.iter().for_each(|cluster| places[*cluster as usize].push(place));
        }
    }
    for places in &mut places {
        let all = std::mem::take(places);
        let count = all.len().min(PLACES);
        places.extend((0..count).map(|i| all[(2 * i + 1) * all.len() / (2 * count)]));
    }
    places
}

/// What is seen of a scene without doors in the direction of one, by all who see it.
#[derive(Debug)]
pub(super) struct DoorSight {
    /// A ball that the door may move in.
    center: Vec3,
    radius: f32,
    probes: Vec<ProbeSight>,
    pub(super) clusters: Vec<ClusterSight>,
}

/// The rays of a probe that reach the room around a door.
#[derive(Debug)]
struct ProbeSight {
    probe: u32,
    /// Numbers of the rays, and how far they go, metres.
    rays: Vec<(u32, f32)>,
}

/// How light gets to a cluster.
#[derive(Debug)]
pub(super) struct ClusterSight {
    pub(super) cluster: u32,
    /// Those by the room around a door.
    ways: Vec<Way>,
    /// What carries their light, way by way.
    carriers: Vec<Carrier>,
    /// How much light of each carrier came by all ways.
    pub(super) totals: Vec<f32>,
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

/// What brings light to a cluster: the column of a scalar signal, then the probes, last the sky.
type Carrier = u32;

impl DoorSight {
    /// Traces rays into the room around a door, and from there to what is behind it.
    pub(super) fn around(
        baked: &BakedScene,
        tracer: &Tracer,
        tables: &SignalTables,
        door: &PlacedBox,
    ) -> Self {
        // A door that turns about its edge, or slides by its own width, stays in there.
        let (center, radius) = (door.center(), door.diagonal());
        let far = 2.0 * tracer.scene().bounds().diagonal() + radius;
        let region = Region { tracer, center, radius, far };
        let probes = (0..baked.probes.len() as u32).into_par_iter();
        let probes = probes.filter_map(|probe| ProbeSight::of(baked, &region, probe)).collect();
        let clusters = (0..baked.clusters.len() as u32).into_par_iter();
        let clusters = clusters.filter_map(|cluster| ClusterSight::of(baked, tables, &region, cluster));
        Self { center, radius, probes, clusters: clusters.collect() }
    }

    /// Whether a door is where its rays went.
    pub(super) fn covers(&self, door: &PlacedBox) -> bool {
        self.center.distance(door.center()) + 0.5 * door.diagonal() <= self.radius
    }

    /// Takes away what a door shuts where it is now.
    pub(super) fn shut(&self, baked: &BakedScene, door: Shut, ways: &mut OpenWays) {
        for sight in &self.probes {
            sight.shut(baked, door, ways);
        }
        for sight in &self.clusters {
            sight.shut(baked, &door.shape, ways);
        }
    }
}

/// The room around a door.
struct Region<'a> {
    tracer: &'a Tracer,
    center: Vec3,
    radius: f32,
    /// How far rays go that meet nothing, metres.
    far: f32,
}

impl Region<'_> {
    /// How far a ray from a place (off any surface) goes, with what it meets.
    fn trace(&self, origin: Vec3, direction: Vec3) -> (f32, Option<Hit>) {
        let hit = self.tracer.closest_hit(&Ray::new(origin, direction));
        (hit.as_ref().map_or(self.far, |hit| hit.distance), hit)
    }

    /// Whether a ray in a unit direction enters it within a distance.
    fn is_entered(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let offset = self.center - origin;
        let along = offset.dot(direction).clamp(0.0, distance);
        (offset - along * direction).length_squared() < self.radius * self.radius
    }

    /// Whether the way from one place to another leads through it.
    fn is_between(&self, from: Vec3, to: Vec3) -> bool {
        let distance = from.distance(to);
        self.is_entered(from, (to - from) / distance.max(f32::MIN_POSITIVE), distance)
    }

    /// Cosine of half the angle that it fills as seen from a place; −1 from within.
    fn cosine_from(&self, origin: Vec3) -> f32 {
        let squared = self.center.distance_squared(origin);
        let sine_squared = self.radius * self.radius / squared.max(f32::MIN_POSITIVE);
        if sine_squared >= 1.0 { -1.0 } else { (1.0 - sine_squared).sqrt() }
    }
}

impl ProbeSight {
    fn of(baked: &BakedScene, region: &Region<'_>, probe: u32) -> Option<Self> {
        let origin = baked.probes[probe as usize].position;
        let ray = |(number, direction): (u32, &Vec3)| {
            // Most rays point elsewhere.
            let distance = region
                .is_entered(origin, *direction, region.far)
                .then(|| region.trace(origin, *direction).0)?;
            region.is_entered(origin, *direction, distance).then_some((number, distance))
        };
        let rays: Vec<_> = (0..).zip(&baked.relight_directions).filter_map(ray).collect();
        (!rays.is_empty()).then_some(Self { probe, rays })
    }

    /// Lets rays that meet the door see what it reflects. A matt door shows a mean of all that lies on its side; each of its
    /// rays takes one sample of that, which is what the probe sees by another of its rays.
    fn shut(&self, baked: &BakedScene, door: Shut, ways: &mut OpenWays) {
        let origin = baked.probes[self.probe as usize].position;
        let seen = &baked.relight_surfels[rays_of(baked, self.probe)];
        for (ray, distance) in &self.rays {
            let end = origin + *distance * baked.relight_directions[*ray as usize];
            let Some((_, face)) = door.shape.entry(origin, end) else { continue };
            let stand_in = |attempt: u32| {
                let bits = hash_pair(hash_pair(*ray, self.probe), attempt);
                let other = bits as usize % seen.len();
                let cosine = baked.relight_directions[other].dot(face);
                let is_chosen = unit_from_bits(hash_pair(bits, 1)) < cosine && seen[other] != NONE;
                is_chosen.then_some(seen[other])
            };
            let (surfel, share) = match (0..STAND_INS).find_map(stand_in) {
                Some(surfel) => (surfel, door.albedo),
                None => (seen[*ray as usize], 0.0),
            };
            ways.divert(baked, self.probe, *ray as usize, surfel, share);
        }
    }
}

/// What carries light to a cluster.
struct Carriers<'a> {
    baked: &'a BakedScene,
    tables: &'a SignalTables,
    signals: &'a [u32],
    probes: &'a [u32],
    column_of_signal: HashMap<u32, u32>,
}

impl<'a> Carriers<'a> {
    fn of(baked: &'a BakedScene, tables: &'a SignalTables, cluster: &'a Cluster) -> Self {
        let signals =
            &baked.cluster_signals[cluster.first_signal as usize..][..cluster.signal_count as usize];
        let probes = &baked.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize];
        let column_of_signal = signals.iter().copied().zip(0..).collect();
        Self { baked, tables, signals, probes, column_of_signal }
    }

    fn count(&self) -> usize {
        self.signals.len() + self.probes.len() + 1
    }

    /// Calls back with each carrier of the light that comes from where a ray ends.
    fn of_hit(&self, hit: Option<&Hit>, found: &mut impl FnMut(Carrier)) {
        let Some(hit) = hit else {
            if self.baked.settings.sky_degree.is_some() {
                found(self.count() as u32 - 1);
            } else {
                self.of_probes(NONE, found);
            }
            return;
        };
        let material = self.baked.scene.triangle_material[hit.triangle as usize];
        let (first_emitter, first_sky) = (self.baked.first_emitter_signal(), self.baked.first_sky_signal());
        for (column, signal) in (0..).zip(self.signals) {
            let is_emitter = (first_emitter..first_sky).contains(&(*signal as usize));
            if is_emitter && self.baked.emitters[*signal as usize - first_emitter].material == material {
                found(column);
            }
        }
        let surfel = self.tables.surfel_of_hit(self.baked, hit);
        if surfel == NONE {
            return;
        }
        let patches = std::iter::successors(Some(surfel), |patch| {
            Some(self.tables.parents[*patch as usize]).filter(|parent| *parent != NONE)
        });
        if let Some(column) = patches.into_iter().find_map(|patch| self.column_of_signal.get(&patch)) {
            found(*column);
        }
        self.of_probes(surfel, found);
    }

    fn of_probes(&self, surfel: u32, found: &mut impl FnMut(Carrier)) {
        for (carrier, probe) in (self.signals.len() as u32..).zip(self.probes) {
            if self.tables.seen[*probe as usize].binary_search(&surfel).is_ok() {
                found(carrier);
            }
        }
    }

    /// Where the probe is that a carrier is, if it is one.
    fn probe(&self, carrier: Carrier) -> Option<Vec3> {
        let probe = self.probes.get((carrier as usize).checked_sub(self.signals.len())?)?;
        Some(self.baked.probes[*probe as usize].position)
    }

    /// Where the light of a carrier comes from, if that is one place.
    fn source(&self, carrier: Carrier) -> Option<Vec3> {
        let patch =
            self.signals.get(carrier as usize).and_then(|signal| self.tables.middles.get(*signal as usize));
        patch.copied().or_else(|| self.probe(carrier))
    }
}

impl ClusterSight {
    /// `None` if the cluster sees nothing of the region.
    fn of(baked: &BakedScene, tables: &SignalTables, region: &Region<'_>, number: u32) -> Option<Self> {
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
        let solid_angle = std::f32::consts::TAU * (1.0 - cosine);
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
                (direction, 2.0 * std::f32::consts::TAU / RAYS_AROUND as f32)
            } else {
                let u = sobol_owen(ray as u32, hash_pair(seed, 1));
                let local = cosine_hemisphere_from_square(u);
                let direction = world_from_tangent(place.normal) * local;
                let along = direction.dot(place.normal).max(1e-3);
                (direction, std::f32::consts::PI / (along * RAYS_AROUND as f32))
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
    fn shut(&self, baked: &BakedScene, door: &PlacedBox, ways: &mut OpenWays) {
        let cluster = &baked.clusters[self.cluster as usize];
        let probes = &baked.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize];
        let probe_of = |carrier: Carrier| {
            let probe = probes.get((carrier as usize).checked_sub(cluster.signal_count as usize)?)?;
            Some(baked.probes[*probe as usize].position)
        };
        let (mut totals, mut lost) = (self.totals.clone(), vec![0.0; self.totals.len()]);
        for way in &self.ways {
            let is_shut = door.crosses(way.receiver, way.source);
            for carrier in &self.carriers[way.carriers.start as usize..way.carriers.end as usize] {
                if probe_of(*carrier).is_some_and(|probe| door.crosses(probe, way.source)) {
                    totals[*carrier as usize] -= way.weight;
                    lost[*carrier as usize] += f32::MIN_POSITIVE;
                } else if is_shut {
                    lost[*carrier as usize] += way.weight;
                }
            }
        }
        for (carrier, source) in &self.unseen {
            if door.crosses(self.middle, *source) {
                lost[*carrier as usize] = f32::INFINITY;
            }
        }
        for (carrier, (lost, total)) in
            (0..).zip(lost.iter().zip(&totals)).filter(|(_, (lost, _))| **lost > 0.0)
        {
            // Sums and differences of the same numbers leave some rounding.
            let total = if *total > 1e-4 * self.totals[carrier as usize] { *total } else { 0.0 };
            let left = if total > 0.0 { (1.0 - lost / total).max(0.0) } else { 0.0 };
            for columns in columns_of(baked, cluster, carrier) {
                ways.dim(baked, self.cluster, columns, left);
            }
        }
    }
}

/// The columns of ΣVᵀ that belong to a carrier.
fn columns_of(baked: &BakedScene, cluster: &Cluster, carrier: Carrier) -> Vec<Range<usize>> {
    let (carrier, signals, probes) =
        (carrier as usize, cluster.signal_count as usize, cluster.probe_count as usize);
    if carrier < signals {
        return vec![carrier..carrier + 1];
    }
    let probe = carrier - signals;
    if probe < probes {
        let band = |l: usize| {
            let first = signals + probes * l * l + probe * (2 * l + 1);
            first..first + 2 * l + 1
        };
        return (0..=baked.settings.sh_degree as usize).map(band).collect();
    }
    let numbers = &baked.cluster_signals[cluster.first_signal as usize..][..signals];
    let is_sky = |column: &usize| numbers[*column] as usize >= baked.first_sky_signal();
    (0..signals).filter(is_sky).map(|column| column..column + 1).collect()
}

/// A unit direction within a cone around +Z, evenly by solid angle.
fn in_cone(cosine: f32, u: Vec2) -> Vec3 {
    let z = 1.0 - u.x * (1.0 - cosine);
    let across = (1.0 - z * z).max(0.0).sqrt();
    let around = std::f32::consts::TAU * u.y;
    Vec3::new(across * around.cos(), across * around.sin(), z)
}
