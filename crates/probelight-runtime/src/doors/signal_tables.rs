//! Where light of a baked scene is evaluated, and where its clusters are, as rays find them.

use probelight_asset::{BakedScene, NONE, Surfel};
use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Tracer};

use crate::surfels_of_texels::surfels_of_texels;

/// Places of each cluster that rays start from.
const PLACES: usize = 8;

/// Where light of a baked scene is evaluated, as rays find it.
#[derive(Debug)]
pub(super) struct SignalTables {
    surfel_of_texel: Vec<u32>,
    /// The group that each surfel or group is a part of, or [`NONE`].
    pub(super) parents: Vec<u32>,
    /// Middle of each surfel and group, metres.
    pub(super) middles: Vec<Vec3>,
    /// The surfels that each probe sees, and [`NONE`] for the sky, sorted.
    pub(super) seen: Vec<Box<[u32]>>,
    /// Of each cluster.
    pub(super) places: Vec<Vec<Place>>,
}

/// A place of a cluster's receivers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// World position where rays start, off any surface, metres.
    pub(super) origin: Vec3,
    /// Unit normal of the surface; zero in free space.
    pub(super) normal: Vec3,
}

impl Place {
    pub(super) fn is_in_air(&self) -> bool {
        self.normal == Vec3::ZERO
    }

    /// How much light counts that comes from a unit direction: by its cosine, in free space all the same.
    pub(super) fn cosine(&self, direction: Vec3) -> f32 {
        if self.is_in_air() { 1.0 } else { direction.dot(self.normal) }
    }
}

impl SignalTables {
    pub(super) fn new(baked: &BakedScene, tracer: &Tracer) -> Self {
        let mut parents = vec![NONE; baked.first_emitter_signal()];
        let middle = |surfel: &Surfel| {
            let positions = baked.samples_of(surfel).iter().map(|sample| baked.place_of(sample).0);
            positions.sum::<Vec3>() / surfel.sample_count as f32
        };
        let mut middles: Vec<Vec3> = baked.surfels.iter().map(middle).collect();
        for (number, group) in (baked.surfels.len() as u32..).zip(&baked.surfel_groups) {
            let [first, second] = group.children.map(|child| child as usize);
            (parents[first], parents[second]) = (number, number);
            middles.push(middles[second].lerp(middles[first], group.first_weight));
        }
        let seen = |probe| {
            let mut surfels = baked.relight_surfels[baked.rays_of(probe)].to_vec();
            surfels.sort_unstable();
            surfels.dedup();
            surfels.into()
        };
        Self {
            surfel_of_texel: surfels_of_texels(baked),
            parents,
            middles,
            seen: (0..baked.probes.len()).map(seen).collect(),
            places: places(baked, tracer),
        }
    }

    /// Middles of a surfel, or of up to four parts of a group.
    pub(super) fn parts(&self, baked: &BakedScene, patch: u32) -> Vec<Vec3> {
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
    pub(super) fn surfel_of_hit(&self, baked: &BakedScene, hit: &Hit) -> u32 {
        let texel = baked.lightmap.texel(hit.triangle, hit.is_back_face, hit.barycentric);
        texel.and_then(|texel| self.surfel_of_texel.get(texel as usize)).copied().unwrap_or(NONE)
    }
}

/// Some places of each cluster, spread over its receivers.
fn places(baked: &BakedScene, tracer: &Tracer) -> Vec<Vec<Place>> {
    let (receivers, clusters) = (baked.receivers_of_texels(), baked.clusters_of_receivers());
    let mut places = vec![Vec::new(); baked.clusters.len()];
    for sample in &baked.light_samples {
        let receiver = receivers.get(baked.texel_of(sample) as usize);
        if let Some(cluster) = receiver.and_then(|receiver| clusters.get(*receiver as usize)) {
            let (position, normal) = baked.place_of(sample);
            let origin = tracer.off_surface(position, normal);
            places[*cluster as usize].push(Place { origin, normal });
        }
    }
    if baked.has_grid() {
        for vertex in baked.grid_vertex_places() {
            let rows = baked.vertex_receivers(vertex.vertex);
            let mut of_rows: Vec<u32> = rows.iter().map(|row| clusters[*row as usize]).collect();
            of_rows.sort_unstable();
            of_rows.dedup();
            let place = Place { origin: vertex.position, normal: Vec3::ZERO };
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
