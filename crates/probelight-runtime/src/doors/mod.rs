//! Doors: objects that open and close ways for light.
//!
//! Transport is baked for the scene without its objects. What is behind a door sees less when the door shuts, and probes
//! see the door. Both are found again without another bake:
//!
//! | what a door cuts | how it is found | what a frame takes instead |
//! | --- | --- | --- |
//! | relight rays of probes | a probe's rays against the door's box | a surfel on the door's side of the probe, times the door's albedo |
//! | light that clusters gather | rays from each cluster's receivers, those through the door weighed against all that carry the same signal | a factor for each column of ΣVᵀ, in its exponent |
//!
//! [`DoorSight`] traces rays once, when a door comes; [`DoorSight::shut`] asks which of them the door crosses where it is now,
//! without tracing anything. The changed numbers are [`OpenWays`], which stand in for those of the baked scene.

mod carriers;
mod cluster_sight;
mod open_ways;
mod probe_sight;
mod ray_box;
mod region;
mod sight;
mod signal_tables;

use open_ways::OpenWays;
pub use open_ways::Ways;

use probelight_asset::BakedScene;
use probelight_math::color::luminance;
use probelight_scene::Placement;
use probelight_trace::Tracer;

use self::ray_box::PlacedBox;
use self::sight::DoorSight;
use self::signal_tables::SignalTables;
use crate::{ObjectId, Objects};

/// The doors of a scene, and what they leave of the ways that light takes.
#[derive(Debug)]
pub(crate) struct Doors {
    tables: SignalTables,
    /// Where each door was last, and what is seen in its direction.
    sights: Vec<(ObjectId, Placement, DoorSight)>,
    ways: OpenWays,
}

/// A door where it is now.
#[derive(Clone, Copy, Debug)]
struct Shut {
    shape: PlacedBox,
    /// Mean luminance of its diffuse albedo.
    albedo: f32,
}

impl Doors {
    /// For a scene without doors yet.
    pub(crate) fn new(baked: &BakedScene, tracer: &Tracer) -> Self {
        Self { tables: SignalTables::new(baked, tracer), sights: Vec::new(), ways: OpenWays::new(baked) }
    }

    /// The ways that they leave.
    pub(crate) fn ways(&self) -> Ways<'_> {
        self.ways.ways()
    }

    /// Probes and clusters whose ways are not those of the baked scene, or ever were not.
    #[cfg(feature = "gpu")]
    pub(crate) fn changed(&self) -> (&[u32], &[u32]) {
        (&self.ways.probes, &self.ways.clusters)
    }

    /// Follows the doors among the objects; returns whether any way opened or shut. The first time that a door is seen, or if
    /// it went far away from there, rays are traced all around it.
    pub(crate) fn follow(&mut self, baked: &BakedScene, tracer: &Tracer, objects: &Objects) -> bool {
        let before = self.sights.iter().map(|(id, placement, _)| (*id, *placement));
        if before.eq(objects.doors().map(|(id, door, _)| (id, *door.placement()))) {
            return false;
        }
        self.ways.reset(baked);
        let mut sights = std::mem::take(&mut self.sights);
        for (id, door, spheres) in objects.doors() {
            let shape = PlacedBox::of(door);
            let known = sights.iter().position(|(known, _, sight)| *known == id && sight.covers(&shape));
            let sight = match known {
                Some(index) => sights.swap_remove(index).2,
                None => DoorSight::around(baked, tracer, &self.tables, &shape),
            };
            let count = spheres.len().max(1) as f32;
            let albedo = spheres.iter().map(|sphere| luminance(sphere.albedo)).sum::<f32>() / count;
            sight.shut(baked, Shut { shape, albedo }, &mut self.ways);
            self.sights.push((id, *door.placement(), sight));
        }
        true
    }
}
