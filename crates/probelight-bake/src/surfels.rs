//! Surfels: the patches of surface whose radiance stands for all light that leaves the scene's surfaces.
//!
//! Receivers are halved, again and again, by position and normal, until what is left is a surfel: as wide as
//! asked for, of one chart. The halving also gives the larger patches, which serve receivers far away.

use probelight_asset::{LightSample, NONE, Surfel, SurfelGroup};
use probelight_math::color::srgb8_from_linear;
use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::Scene;
use probelight_trace::{Hit, Tracer};

use crate::atlas::Atlas;
use crate::partition::{KdRule, by_air_space, centroid};
use crate::receivers::{Receiver, Receivers};

/// A surfel's width that a unit difference of normals counts as: faces at right angles part.
const WIDTHS_PER_NORMAL: f32 = 1.5;

/// The surfels of a scene and the groups above them, in the asset's numbering.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfelTree {
    pub(crate) light_samples: Vec<LightSample>,
    pub(crate) surfels: Vec<Surfel>,
    pub(crate) groups: Vec<SurfelGroup>,
    /// Receivers in each surfel, then in each group: their areas, since all texels are equally large.
    pub(crate) sizes: Vec<u32>,
    /// Number of surfels in each patch.
    surfel_counts: Vec<u32>,
    /// The group that each surfel, then each group is part of, or [`NONE`] for the root of an air space.
    pub(crate) parents: Vec<u32>,
    /// Surfel of each lightmap texel that a lookup in a chart may touch, else [`NONE`].
    surfel_of_texel: Vec<u32>,
}

impl SurfelTree {
    /// Surfels about `size` metres wide, with at most `samples` light samples each.
    pub(crate) fn build(
        scene: &Scene,
        atlas: &Atlas,
        receivers: &Receivers,
        size: f32,
        samples: usize,
    ) -> Self {
        let builder = Builder {
            scene,
            receivers: &receivers.receivers,
            rule: KdRule { meters_per_normal: WIDTHS_PER_NORMAL * size, by_outlook: false },
            size,
            samples,
        };
        let mut tree = Self {
            surfel_of_texel: vec![NONE; atlas.width as usize * atlas.height as usize],
            ..Self::default()
        };
        let mut group_sizes = Vec::new();
        for group in by_air_space(&receivers.receivers) {
            builder.add_patch(group, &mut tree, &mut group_sizes);
        }
        for [texel, source] in &receivers.dilation {
            tree.surfel_of_texel[*texel as usize] = tree.surfel_of_texel[*source as usize];
        }
        tree.number_groups(group_sizes);
        tree
    }

    /// One surfel for each relight ray that hits a surface, as the paper has it; and the surfel of each ray.
    pub(crate) fn of_relight_hits(
        tracer: &Tracer,
        atlas: &Atlas,
        probes: &[Vec3],
        directions: &[Vec3],
        hits: &[Option<Hit>],
    ) -> (Self, Vec<u32>) {
        let mut tree = Self::default();
        let of_ray = hits
            .iter()
            .enumerate()
            .map(|(i, hit)| {
                let Some(hit) = hit else { return NONE };
                let (probe, direction) = (probes[i / directions.len()], directions[i % directions.len()]);
                let first_sample = tree.light_samples.len() as u32;
                tree.light_samples.push(light_sample_at(tracer, atlas, hit, probe + direction * hit.distance));
                tree.surfels.push(Surfel { first_sample, sample_count: 1 });
                first_sample
            })
            .collect();
        (tree, of_ray)
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
        let texel = atlas.texel_of_hit(hit);
        self.surfel_of_texel.get(texel as usize).copied().unwrap_or(NONE)
    }

    /// Replaces the builder's numbers of groups by the asset's, now that the surfels are counted.
    fn number_groups(&mut self, group_sizes: Vec<u32>) {
        let surfels = self.surfels.len() as u32;
        for group in &mut self.groups {
            group.children = group.children.map(|child| Patch::decode(child).number(surfels));
        }
        self.sizes.extend(group_sizes);
        self.parents = vec![NONE; self.patches()];
        self.surfel_counts = vec![1; self.surfels.len()];
        for group in &self.groups {
            let [a, b] = group.children.map(|child| self.surfel_counts[child as usize]);
            self.surfel_counts.push(a + b);
        }
        for (g, group) in (surfels..).zip(&self.groups) {
            for child in group.children {
                self.parents[child as usize] = g;
            }
        }
    }
}

/// A surfel or group while the number of surfels is not known yet.
#[derive(Clone, Copy)]
enum Patch {
    Surfel(u32),
    Group(u32),
}

impl Patch {
    const GROUP_BIT: u32 = 1 << 31;

    fn encode(self) -> u32 {
        match self {
            Self::Surfel(s) => s,
            Self::Group(g) => g | Self::GROUP_BIT,
        }
    }

    fn decode(code: u32) -> Self {
        if code & Self::GROUP_BIT == 0 { Self::Surfel(code) } else { Self::Group(code & !Self::GROUP_BIT) }
    }

    fn number(self, surfels: u32) -> u32 {
        match self {
            Self::Surfel(s) => s,
            Self::Group(g) => surfels + g,
        }
    }
}

struct Builder<'a> {
    scene: &'a Scene,
    receivers: &'a [Receiver],
    rule: KdRule,
    size: f32,
    samples: usize,
}

impl Builder<'_> {
    /// Adds the patch of a group of receivers, smaller patches first.
    fn add_patch(&self, group: Vec<u32>, tree: &mut SurfelTree, group_sizes: &mut Vec<u32>) -> Patch {
        let size = group.len() as u32;
        let (first, second) = if self.rule.extent(self.receivers, &group) > self.size {
            self.rule.split(self.receivers, group)
        } else {
            match self.split_by_chart(group) {
                Ok(halves) => halves,
                Err(group) => return self.add_surfel(&group, tree),
            }
        };
        let first_weight = first.len() as f32 / size as f32;
        let children = [first, second].map(|half| self.add_patch(half, tree, group_sizes).encode());
        tree.groups.push(SurfelGroup { children, first_weight });
        group_sizes.push(size);
        Patch::Group(tree.groups.len() as u32 - 1)
    }

    /// Parts the first chart of a group from the others; gives the group back if it has only one.
    fn split_by_chart(&self, group: Vec<u32>) -> Result<(Vec<u32>, Vec<u32>), Vec<u32>> {
        let chart = |r: &u32| self.receivers[*r as usize].chart;
        let first = chart(&group[0]);
        if group.iter().all(|r| chart(r) == first) {
            return Err(group);
        }
        Ok(group.into_iter().partition(|r| chart(r) == first))
    }

    fn add_surfel(&self, group: &[u32], tree: &mut SurfelTree) -> Patch {
        let surfel = tree.surfels.len() as u32;
        let first_sample = tree.light_samples.len() as u32;
        self.add_samples(group.to_vec(), self.samples, tree);
        let sample_count = tree.light_samples.len() as u32 - first_sample;
        tree.surfels.push(Surfel { first_sample, sample_count });
        tree.sizes.push(group.len() as u32);
        for receiver in group {
            tree.surfel_of_texel[self.receivers[*receiver as usize].texel as usize] = surfel;
        }
        Patch::Surfel(surfel)
    }

    /// Divides a surfel's receivers into as many parts as it may have samples, and adds one for each.
    fn add_samples(&self, group: Vec<u32>, most: usize, tree: &mut SurfelTree) {
        if most <= 1 || group.len() == 1 {
            tree.light_samples.push(self.light_sample(&group));
            return;
        }
        let (first, second) = self.rule.split(self.receivers, group);
        self.add_samples(first, most / 2, tree);
        self.add_samples(second, most - most / 2, tree);
    }

    /// The sample of a part: at its middle receiver, with the mean of the textures.
    fn light_sample(&self, part: &[u32]) -> LightSample {
        let middle = centroid(self.receivers, part);
        let distance = |r: &u32| self.receivers[*r as usize].position.distance_squared(middle);
        let nearest = part.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        let at = &self.receivers[nearest.copied().unwrap_or(part[0]) as usize];
        let mean = |texel: &dyn Fn(usize, Vec2) -> Vec3| {
            let values = part.iter().map(|r| &self.receivers[*r as usize]);
            values.map(|r| texel(r.triangle as usize, r.barycentric)).sum::<Vec3>() / part.len() as f32
        };
        sample_with_texels(
            at.position,
            at.triangle,
            at.texel,
            at.is_back_face,
            mean(&|triangle, at| self.scene.base_color_texel(triangle, at).truncate()),
            mean(&|triangle, at| self.scene.emission_texel(triangle, at)),
        )
    }
}

fn light_sample_at(tracer: &Tracer, atlas: &Atlas, hit: &Hit, position: Vec3) -> LightSample {
    let scene = tracer.scene();
    let triangle = hit.triangle as usize;
    let base_color = scene.base_color_texel(triangle, hit.barycentric).truncate();
    let emission = scene.emission_texel(triangle, hit.barycentric);
    let texel = atlas.texel_of_hit(hit);
    sample_with_texels(position, hit.triangle, texel, hit.is_back_face, base_color, emission)
}

fn sample_with_texels(
    position: Vec3,
    triangle: u32,
    texel: u32,
    is_back_face: bool,
    base_color: Vec3,
    emission: Vec3,
) -> LightSample {
    let [r, g, b] = srgb8_from_linear(base_color);
    let [er, eg, eb] = srgb8_from_linear(emission);
    LightSample {
        position,
        triangle,
        texel,
        base_color_and_side: [r, g, b, u8::from(is_back_face)],
        emission_texel: [er, eg, eb, 0],
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::small_scene::SmallScene;

    /// Texels of the receivers of each surfel.
    fn receivers_by_surfel(scene: &SmallScene) -> Vec<Vec<usize>> {
        let tree = &scene.light.surfels;
        let mut members = vec![Vec::new(); tree.surfels.len()];
        for (r, receiver) in scene.receivers.receivers.iter().enumerate() {
            let surfel = tree.surfel_of_texel[receiver.texel as usize];
            members[surfel as usize].push(r);
        }
        members
    }

    #[test]
    fn surfels_divide_the_receivers_and_are_small_and_of_one_chart() {
        let scene = SmallScene::load("cornell.glb");
        let tree = &scene.light.surfels;
        let size = scene.resolved.settings.surfel_size;
        let members = receivers_by_surfel(&scene);
        for (surfel, members) in members.iter().enumerate() {
            assert_eq!(tree.sizes[surfel] as usize, members.len());
            let receiver = |r: &usize| &scene.receivers.receivers[*r];
            let charts: BTreeSet<u32> = members.iter().map(|r| receiver(r).chart).collect();
            assert_eq!(charts.len(), 1, "surfel {surfel}");
            let (first, last) = (receiver(&members[0]), members.iter().map(receiver));
            for other in last {
                let extent = (other.position - first.position).abs().max_element();
                assert!(extent <= size && other.normal.dot(first.normal) > 0.0, "surfel {surfel}");
            }
        }
        let total: usize = members.iter().map(Vec::len).sum();
        assert_eq!(total, scene.receivers.receivers.len());
        assert!(members.len() * 2 < total, "{} surfels of {total} receivers", members.len());
    }

    #[test]
    fn groups_weigh_their_parts_by_area_and_lead_to_one_root_for_each_air_space() {
        let scene = SmallScene::load("rooms.glb");
        let tree = &scene.light.surfels;
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
        let roots = tree.parents.iter().filter(|parent| **parent == NONE).count();
        assert_eq!(roots, by_air_space(&scene.receivers.receivers).len());
    }

    #[test]
    fn light_samples_lie_on_texels_of_their_surfel() {
        let scene = SmallScene::load("cornell.glb");
        let tree = &scene.light.surfels;
        let most = scene.resolved.settings.samples_per_surfel;
        for (s, surfel) in tree.surfels.iter().enumerate() {
            assert_eq!(surfel.sample_count, most.min(tree.sizes[s]));
            let samples = &tree.light_samples[surfel.first_sample as usize..][..surfel.sample_count as usize];
            let texels: BTreeSet<u32> = samples.iter().map(|sample| sample.texel).collect();
            assert_eq!(texels.len(), samples.len(), "samples of surfel {s} share a texel");
            assert!(texels.iter().all(|texel| tree.surfel_of_texel[*texel as usize] == s as u32));
        }
        let used: u32 = tree.surfels.iter().map(|surfel| surfel.sample_count).sum();
        assert_eq!(used as usize, tree.light_samples.len());
    }

    #[test]
    fn every_gather_ray_inside_a_closed_room_ends_on_a_surfel() {
        let scene = SmallScene::load("furnace.glb");
        for receiver in scene.receivers.receivers.iter().step_by(20) {
            for ray in crate::gather::gather_rays(&scene.tracer, receiver, 32, 0) {
                let hit = ray.hit.expect("the room is closed");
                let surfel = scene.light.surfels.surfel_of_hit(&scene.atlas, &hit);
                assert!((surfel as usize) < scene.light.surfels.surfels.len());
            }
        }
    }
}
