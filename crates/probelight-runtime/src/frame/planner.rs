//! From levels of detail to a plan.

use probelight_asset::{BakedScene, Cluster};
use probelight_math::glam::Vec3;
use probelight_math::sh::coefficient_count;
use probelight_scene::Bounds;

use super::input::{Budget, FrameInput, View};
use super::lod::{LodLevel, LodSettings};
use super::plan::{ClusterExtent, FramePlan, ProbeExtent};

/// Levels of the lightmap that receivers are sorted by.
const LIGHTMAP_LEVELS: usize = 4;

/// Makes plans for a baked scene.
#[derive(Clone, Debug)]
pub struct Planner {
    /// Of each cluster, how many receivers each level of the lightmap has.
    receivers: Vec<[u32; LIGHTMAP_LEVELS]>,
}

impl Planner {
    /// Counts the receivers of each level of the lightmap.
    pub fn new(baked: &BakedScene) -> Self {
        let width = baked.lightmap.width;
        let level = |texel: u32| ((texel % width) | (texel / width)).trailing_zeros() as usize;
        let receivers = |cluster: &Cluster| {
            let texels = baked.texels(cluster);
            std::array::from_fn(|n| texels.iter().take_while(|texel| level(**texel) >= n).count() as u32)
        };
        Self { receivers: baked.clusters.iter().map(receivers).collect() }
    }

    /// Fills `plan`, which is one for the same scene.
    ///
    /// A cluster has the level at the distance of its box from the view, a probe the level at that distance less its support
    /// radius: near receivers may draw on it.
    pub fn plan(&self, baked: &BakedScene, settings: &LodSettings, input: &FrameInput, plan: &mut FramePlan) {
        let lightmap_clusters = baked.lightmap_clusters();
        for coarser in 0..settings.levels.len().max(1) {
            let cluster = |index: usize| {
                if index >= lightmap_clusters {
                    return grid_extent(baked, index, input);
                }
                let level = settings.level(distance(&baked.clusters[index].bounds, input), coarser);
                self.cluster_extent(baked, index, &level)
            };
            let probe = |index: usize| {
                let probe = &baked.probes[index];
                let from_view = |view: View| (view.position - probe.position).length() - probe.support_radius;
                probe_extent(&settings.level(input.view.map_or(0.0, from_view), coarser))
            };
            plan.fill(baked, cluster, probe);
            let fits = match input.budget {
                Some(Budget::MatrixBytes(bytes)) => plan.matrix_bytes(baked) <= bytes,
                None => true,
            };
            if fits {
                return;
            }
        }
    }

    fn cluster_extent(&self, baked: &BakedScene, index: usize, level: &LodLevel) -> ClusterExtent {
        let cluster = &baked.clusters[index];
        let degree = level.degree.unwrap_or(u32::MAX).min(baked.settings.sh_degree);
        let of_probes = cluster.probe_count * coefficient_count(degree as usize) as u32;
        let lightmap_level = (level.lightmap_level as usize).min(LIGHTMAP_LEVELS - 1);
        ClusterExtent {
            rank: level.rank.unwrap_or(u32::MAX),
            columns: cluster.signal_count + of_probes,
            receivers: self.receivers[index][lightmap_level],
        }
    }
}

/// All of a cluster of the grid if something moves in the cells around its vertices.
fn grid_extent(baked: &BakedScene, index: usize, input: &FrameInput) -> ClusterExtent {
    let bounds = baked.clusters[index].bounds;
    // Vertices measure up to half a spacing from their place, and light all cells around it.
    let reach = 1.5 * baked.grid.spacing;
    let reached = Bounds { min: bounds.min - reach, max: bounds.max + reach };
    let is_active = input.whole_grid || input.active_boxes.iter().any(|active| touch(active, &reached));
    if is_active { ClusterExtent::ALL } else { ClusterExtent::default() }
}

fn probe_extent(level: &LodLevel) -> ProbeExtent {
    ProbeExtent {
        // A level does not leave probes out.
        rays: level.rays.unwrap_or(u32::MAX).max(1),
        degree: level.degree.unwrap_or(u32::MAX),
    }
}

/// Distance of a cluster's box from the view, metres; 0 where something moves.
fn distance(bounds: &Bounds, input: &FrameInput) -> f32 {
    let is_active = input.active_boxes.iter().any(|active| touch(active, bounds));
    input.view.filter(|_| !is_active).map_or(0.0, |view| bounds.distance(view.position))
}

fn touch(a: &Bounds, b: &Bounds) -> bool {
    let overlap = |a: Vec3, b: Vec3| a.cmple(b).all();
    overlap(a.min, b.max) && overlap(b.min, a.max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{SyntheticSize, synthetic_room};

    /// A row of clusters ten metres apart, each with a probe of its own, and with receivers in the order of a bake.
    fn row() -> BakedScene {
        let size =
            SyntheticSize { probes: 8, probes_per_cluster: 1, rays: 64, ..SyntheticSize::hybrid(2000) };
        let mut baked = synthetic_room(size);
        for (cluster, x) in baked.clusters.iter_mut().zip((0u8..).map(|i| 10.0 * f32::from(i))) {
            cluster.bounds = Bounds { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x + 1.0, 1.0, 1.0) };
            baked.probes[baked.cluster_probes[cluster.first_probe as usize] as usize].position.x = x;
            let width = baked.lightmap.width;
            let level = |texel: &u32| std::cmp::Reverse(((texel % width) | (texel / width)).trailing_zeros());
            let first = cluster.first_receiver as usize;
            baked.receiver_texels[first..first + cluster.receiver_count as usize].sort_by_key(level);
        }
        BakedScene::new(baked).unwrap()
    }

    fn settings() -> LodSettings {
        let middle =
            LodLevel { distance: 15.0, rank: Some(8), degree: Some(3), rays: Some(32), lightmap_level: 0 };
        let far =
            LodLevel { distance: 35.0, rank: Some(4), degree: Some(1), rays: Some(9), lightmap_level: 1 };
        LodSettings { levels: vec![LodLevel::default(), middle, far] }
    }

    fn plan(baked: &BakedScene, settings: &LodSettings, input: &FrameInput) -> FramePlan {
        let mut plan = FramePlan::full(baked);
        Planner::new(baked).plan(baked, settings, input, &mut plan);
        plan
    }

    const AT_THE_FIRST: FrameInput<'static> = FrameInput {
        view: Some(View { position: Vec3::ZERO }),
        active_boxes: &[],
        whole_grid: false,
        budget: None,
    };

    fn ranks(plan: &FramePlan) -> Vec<u32> {
        plan.clusters().iter().map(|extent| extent.rank).collect()
    }

    #[test]
    fn the_default_settings_and_any_settings_without_a_view_compute_everything() {
        let baked = row();
        let full = FramePlan::full(&baked);
        assert_eq!(plan(&baked, &LodSettings::default(), &AT_THE_FIRST), full);
        assert_eq!(plan(&baked, &settings(), &FrameInput::default()), full);
        assert_ne!(plan(&baked, &settings(), &AT_THE_FIRST), full);
    }

    #[test]
    fn far_clusters_and_probes_compute_less() {
        let baked = row();
        let plan = plan(&baked, &settings(), &AT_THE_FIRST);
        assert_eq!(ranks(&plan), [24, 24, 8, 8, 4, 4, 4, 4]);
        let (near, middle, far) = (plan.clusters()[0], plan.clusters()[2], plan.clusters()[7]);
        assert_eq!([near.columns, middle.columns, far.columns], [256 + 64, 256 + 16, 256 + 4]);
        assert_eq!([near.receivers, middle.receivers], [256, 256]);
        assert!(far.receivers < 256);
        let probe = |rays, degree| ProbeExtent { rays, degree };
        let expected = [probe(64, 7), probe(64, 7), probe(32, 3), probe(32, 3), probe(16, 1)];
        assert_eq!(plan.probes()[..5], expected);
    }

    #[test]
    fn where_something_moves_everything_is_computed() {
        let baked = row();
        let moving = [Bounds { min: Vec3::new(60.5, 0.5, 0.5), max: Vec3::splat(70.0) }];
        let found = plan(&baked, &settings(), &FrameInput { active_boxes: &moving, ..AT_THE_FIRST });
        assert_eq!(ranks(&found), [24, 24, 8, 8, 4, 4, 24, 24]);
        // Its probe too, though it is far.
        assert_eq!(found.probes()[6].degree, 7);
    }

    #[test]
    fn a_budget_makes_the_frame_coarser_until_it_fits() {
        let baked = row();
        let bytes = plan(&baked, &settings(), &AT_THE_FIRST).matrix_bytes(&baked);
        let within = |bytes| {
            let budget = Some(Budget::MatrixBytes(bytes));
            ranks(&plan(&baked, &settings(), &FrameInput { budget, ..AT_THE_FIRST }))
        };
        assert_eq!(within(bytes), [24, 24, 8, 8, 4, 4, 4, 4]);
        assert_eq!(within(bytes - 1), [8, 8, 4, 4, 4, 4, 4, 4]);
        assert_eq!(within(0), [4; 8]);
    }

    #[test]
    fn receivers_of_a_lightmap_level_lie_on_its_texels() {
        let baked = row();
        let (width, count) = (baked.lightmap.width, baked.clusters[0].receiver_count as usize);
        let planner = Planner::new(&baked);
        for (n, receivers) in planner.receivers[0].into_iter().enumerate() {
            let on_level =
                |texel: &&u32| [**texel % width, **texel / width].iter().all(|x| x.is_multiple_of(1 << n));
            let expected = baked.receiver_texels[..count].iter().filter(on_level).count();
            assert_eq!(receivers as usize, expected, "level {n}");
        }
    }
}
