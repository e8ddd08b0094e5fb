//! What is seen of a scene in the direction of a door.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_trace::Tracer;
use rayon::prelude::*;

use super::Shut;
use super::cluster_sight::ClusterSight;
use super::open_ways::OpenWays;
use super::probe_sight::ProbeSight;
use super::ray_box::PlacedBox;
use super::region::Region;
use super::signal_tables::SignalTables;

/// What is seen of a scene without doors in the direction of one, by all who see it.
#[derive(Debug)]
pub(super) struct DoorSight {
    /// A ball that the door may move in.
    center: Vec3,
    radius: f32,
    probes: Vec<ProbeSight>,
    clusters: Vec<ClusterSight>,
}

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
