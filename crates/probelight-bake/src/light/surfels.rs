//! Surfels: the patches of surface whose radiance stands for all light that leaves the scene's surfaces.
//!
//! Receivers are halved, again and again, by position and normal, until what is left is a surfel: as wide as
//! asked for, of one chart. The halving also gives the larger patches, which serve receivers far away.

use probelight_asset::{LightSample, NONE, Surfel, SurfelGroup};
use probelight_trace::Hit;

use crate::ground::atlas::Atlas;
use crate::ground::sample_point::SurfacePoint;

/// The surfels of a scene and the groups above them, in the asset's numbering.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfelTree {
    pub(crate) light_samples: Vec<LightSample>,
    pub(crate) surfels: Vec<Surfel>,
    /// Points of each surfel for equal parts of its exposed area, at which random lights are evaluated.
    pub(crate) lit_points: Vec<SurfacePoint>,
    /// First of each surfel's points, and the end of the last one's.
    pub(crate) first_lit_points: Vec<u32>,
    pub(crate) groups: Vec<SurfelGroup>,
    /// Exposed areas of the surfels, then of the groups, up to a common factor.
    pub(crate) sizes: Vec<u32>,
    /// Number of surfels in each patch.
    pub(crate) surfel_counts: Vec<u32>,
    /// The group that each surfel, then each group is part of, or [`NONE`] for those in none.
    pub(crate) parents: Vec<u32>,
    /// Surfel of each lightmap texel that a lookup in a chart may touch, else [`NONE`].
    pub(crate) surfel_of_texel: Vec<u32>,
}

impl SurfelTree {
    /// The points of a surfel at which random lights are evaluated; at least one.
    pub(crate) fn lit_points_of(&self, surfel: usize) -> &[SurfacePoint] {
        &self.lit_points[self.first_lit_points[surfel] as usize..self.first_lit_points[surfel + 1] as usize]
    }

    /// Number of surfels and groups.
    pub(crate) fn patches(&self) -> usize {
        self.surfels.len() + self.groups.len()
    }

    /// The two patches that a patch is made of, unless it is a surfel.
    pub(crate) fn children(&self, patch: u32) -> Option<[u32; 2]> {
        Some(self.groups.get((patch as usize).checked_sub(self.surfels.len())?)?.children)
    }

    /// Surfels in a patch; 1 for signals that are no patches.
    pub(crate) fn surfels_in(&self, signal: u32) -> u32 {
        self.surfel_counts.get(signal as usize).copied().unwrap_or(1)
    }

    /// The surfel at a hit, or [`NONE`].
    pub(crate) fn surfel_of_hit(&self, atlas: &Atlas, hit: &Hit) -> u32 {
        self.surfel_of_texel(atlas.texel_of_hit(hit))
    }

    /// The surfel that a lightmap texel belongs to, or [`NONE`].
    pub(crate) fn surfel_of_texel(&self, texel: u32) -> u32 {
        self.surfel_of_texel.get(texel as usize).copied().unwrap_or(NONE)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use probelight_math::glam::Vec3;

    use super::*;
    use crate::light::surfel_builder::by_side;
    use crate::partition::by_air_space;
    use crate::small_scene::SmallScene;

    /// Texels of the receivers of each surfel.
    fn receivers_by_surfel(scene: &SmallScene) -> Vec<Vec<usize>> {
        let tree = &scene.light.sources.surfels;
        let mut members = vec![Vec::new(); tree.surfels.len()];
        for (r, receiver) in scene.ground.receivers.receivers.iter().enumerate() {
            let surfel = tree.surfel_of_texel[receiver.texel as usize];
            members[surfel as usize].push(r);
        }
        members
    }

    #[test]
    fn surfels_divide_the_receivers_and_are_small_and_of_one_chart() {
        let scene = SmallScene::load("cornell.glb");
        let tree = &scene.light.sources.surfels;
        let size = scene.ground.settings.surfel_size;
        let members = receivers_by_surfel(&scene);
        for (surfel, members) in members.iter().enumerate() {
            let points = members.iter().flat_map(|r| scene.ground.points.of(*r as u32));
            assert_eq!(tree.sizes[surfel], points.map(|point| u32::from(point.exposure)).sum::<u32>());
            let receiver = |r: &usize| &scene.ground.receivers.receivers[*r];
            let charts: BTreeSet<u32> = members.iter().map(|r| receiver(r).chart).collect();
            assert_eq!(charts.len(), 1, "surfel {surfel}");
            let (first, last) = (receiver(&members[0]), members.iter().map(receiver));
            for other in last {
                let extent = (other.position - first.position).abs().max_element();
                assert!(extent <= size && other.normal.dot(first.normal) > 0.0, "surfel {surfel}");
            }
        }
        let total: usize = members.iter().map(Vec::len).sum();
        assert_eq!(total, scene.ground.texels().len());
        assert!(members.len() * 2 < total, "{} surfels of {total} receivers", members.len());
    }

    #[test]
    fn groups_weigh_their_parts_by_area_and_keep_to_their_side_and_air_space() {
        let scene = SmallScene::load("rooms.glb");
        let tree = &scene.light.sources.surfels;
        assert_eq!(tree.sizes.len(), tree.patches());
        for (g, group) in tree.groups.iter().enumerate() {
            let [first, second] = group.children.map(|child| tree.sizes[child as usize]);
            let number = tree.surfels.len() + g;
            assert_eq!(first + second, tree.sizes[number]);
            let share = first as f32 / (first + second) as f32;
            assert!((group.first_weight - share).abs() < 1e-6);
            assert!(group.children.iter().all(|child| (*child as usize) < number));
            assert!(group.children.iter().all(|child| tree.parents[*child as usize] as usize == number));
            let [a, b] = group.children.map(|child| tree.surfels_in(child));
            assert_eq!(a + b, tree.surfels_in(number as u32));
        }
        let sides = by_air_space(&scene.ground.sites, scene.ground.texels())
            .into_iter()
            .flat_map(|group| by_side(&scene.ground.sites, group));
        let roots = tree.parents.iter().filter(|parent| **parent == NONE).count();
        assert_eq!(roots, sides.count());
    }

    #[test]
    fn light_samples_lie_on_texels_of_their_surfel() {
        let scene = SmallScene::load("cornell.glb");
        let tree = &scene.light.sources.surfels;
        let most = scene.ground.settings.samples_per_surfel;
        let mut strays = 0;
        for ((s, surfel), members) in tree.surfels.iter().enumerate().zip(receivers_by_surfel(&scene)) {
            let points: usize = members.iter().map(|r| scene.ground.points.of(*r as u32).len()).sum();
            let count = surfel.sample_count;
            let most = most.min(members.len() as u32);
            assert!(count <= most && 2 * count >= most.min(points as u32));
            let samples = &tree.light_samples[surfel.first_sample as usize..][..surfel.sample_count as usize];
            let surfel_of = |sample: &LightSample| {
                let face = scene.ground.atlas.face_of(sample.triangle(), sample.is_back_face());
                let position = scene.ground.atlas.faces[face as usize].position(sample.barycentric());
                tree.surfel_of_texel(scene.ground.atlas.texel_at(position))
            };
            strays += samples.iter().filter(|sample| surfel_of(sample) != s as u32).count();
        }
        // Slivers of charts, which reach into a texel by next to nothing: many in a scene as coarse as this.
        assert!(strays * 10 < tree.light_samples.len(), "{strays} of {}", tree.light_samples.len());
        let used: u32 = tree.surfels.iter().map(|surfel| surfel.sample_count).sum();
        assert_eq!(used as usize, tree.light_samples.len());
    }

    #[test]
    fn light_samples_leave_out_what_lies_hidden_beside_exposed_surface() {
        // The lamp's panel hangs five millimetres below the ceiling.
        let scene = SmallScene::load("cornell_empty.glb");
        let tree = &scene.light.sources.surfels;
        let position = |sample: &LightSample| {
            scene.ground.tracer.scene().position(sample.triangle() as usize, sample.barycentric())
        };
        let on_ceiling = |sample: &&LightSample| position(sample).y > 5.487;
        let samples_within = |margin: f32| {
            let distance = |sample: &LightSample| {
                let offset =
                    (position(sample) - Vec3::new(2.78, 0.0, 2.8)).abs() - Vec3::new(0.65, 0.0, 0.53);
                offset.x.max(offset.z)
            };
            let ceiling = tree.light_samples.iter().filter(on_ceiling);
            ceiling.filter(|sample| distance(sample) < margin).count()
        };
        assert_eq!(samples_within(-0.1), 0, "above the panel");
        // Negative control: there are samples around it.
        assert!(samples_within(0.4) > 8, "{}", samples_within(0.4));
    }

    #[test]
    fn every_gather_ray_inside_a_closed_room_ends_on_a_surfel() {
        let scene = SmallScene::load("furnace.glb");
        for receiver in scene.ground.texels().step_by(20) {
            for ray in scene.gather(receiver, 32) {
                let hit = ray.hit.expect("the room is closed");
                let surfel = scene.light.sources.surfels.surfel_of_hit(&scene.ground.atlas, &hit);
                assert!((surfel as usize) < scene.light.sources.surfels.surfels.len());
            }
        }
    }
}
