//! From levels of detail to a plan.

use probelight_asset::{BakedScene, Cluster, Probe};
use probelight_math::sh::coefficient_count;
use probelight_scene::Bounds;

use super::box_tree::BoxTree;
use super::grid_reach::grid_reach;
use super::input::{Budget, FrameInput};
use super::lod::{LodLevel, LodSettings};
use super::plan::{ClusterExtent, FADE_STEPS, FramePlan, ProbeExtent};
use super::sight::Sight;

/// Levels of the lightmap that receivers are sorted by.
pub(super) const LIGHTMAP_LEVELS: usize = 4;

/// The largest changes that may wait, as shares of the light of each cluster and each probe.
#[derive(Clone, Debug, Default)]
pub(crate) struct Thresholds {
    pub(crate) clusters: Vec<f32>,
    pub(crate) probes: Vec<f32>,
}

/// Makes plans for a baked scene.
#[derive(Clone, Debug)]
pub struct Planner {
    /// Of each cluster, how many receivers each level of the lightmap has.
    receivers: Vec<[u32; LIGHTMAP_LEVELS]>,
    /// What of the clusters boxes may touch.
    reached: BoxTree,
    /// Whether something moves there in the present frame.
    is_active: Vec<bool>,
    /// Where the lightmap's clusters lie as seen in the present frame.
    sights: Vec<Sight>,
    thresholds: Thresholds,
}

impl Planner {
    /// Counts the receivers of each level of the lightmap.
    pub fn new(baked: &BakedScene) -> Self {
        Self {
            receivers: baked.clusters.iter().map(|cluster| leading_receivers(baked, cluster)).collect(),
            reached: BoxTree::new(reached_bounds(baked)),
            is_active: vec![false; baked.clusters.len()],
            sights: vec![Sight::NEAR; baked.lightmap_clusters()],
            thresholds: Thresholds {
                clusters: vec![0.0; baked.clusters.len()],
                probes: vec![0.0; baked.probes.len()],
            },
        }
    }

    /// What may wait in the last frame that was planned.
    pub(crate) fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    /// Fills `plan`, which is one for the same scene. Allocates nothing.
    ///
    /// A cluster has the level of its box as seen from the view, a probe that of the ball around it in which receivers draw
    /// on it. What boxes touch counts as near.
    pub fn plan(
        &mut self,
        baked: &BakedScene,
        settings: &LodSettings,
        input: &FrameInput,
        plan: &mut FramePlan,
    ) {
        self.look(baked, input);
        self.fill_thresholds(baked, settings, input);
        for coarser in 0..settings.levels.len().max(1) {
            let cluster = |index: usize| match self.sights.get(index) {
                Some(sight) => {
                    // What a budget takes away does not fade.
                    let fade = if coarser == 0 { settings.fade(*sight) } else { (FADE_STEPS, u32::MAX) };
                    self.cluster_extent(baked, index, &settings.level(*sight, coarser), fade)
                }
                None if input.whole_grid || self.is_active[index] => ClusterExtent::ALL,
                None => ClusterExtent::default(),
            };
            let probe = |index: usize| {
                probe_extent(&settings.level(sight_of_probe(&baked.probes[index], settings, input), coarser))
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

    /// Finds out where the clusters are, and where something moves.
    fn look(&mut self, baked: &BakedScene, input: &FrameInput) {
        let Self { reached, is_active, sights, .. } = self;
        is_active.fill(false);
        for active in input.active_boxes {
            reached.visit_touched(active, &mut |index| is_active[index] = true);
        }
        for ((sight, is_active), cluster) in sights.iter_mut().zip(is_active).zip(&baked.clusters) {
            let view = input.view.filter(|_| !*is_active);
            *sight = view.map_or(Sight::NEAR, |view| Sight::of_box(view, &cluster.bounds));
        }
    }

    fn fill_thresholds(&mut self, baked: &BakedScene, settings: &LodSettings, input: &FrameInput) {
        let at = |sight: Sight| settings.threshold(&settings.level(sight, 0));
        let Thresholds { clusters, probes } = &mut self.thresholds;
        // Those of the grid have no level.
        clusters.fill(settings.changes.threshold);
        clusters.iter_mut().zip(&self.sights).for_each(|(threshold, sight)| *threshold = at(*sight));
        for (threshold, probe) in probes.iter_mut().zip(&baked.probes) {
            *threshold = at(sight_of_probe(probe, settings, input));
        }
    }

    /// The extent of a cluster at a level, and how much it has of the singular values that the next level has not.
    fn cluster_extent(
        &self,
        baked: &BakedScene,
        index: usize,
        level: &LodLevel,
        (fade, solid): (u32, u32),
    ) -> ClusterExtent {
        let cluster = &baked.clusters[index];
        let degree = level.degree.unwrap_or(u32::MAX).min(baked.settings.sh_degree);
        let of_probes = cluster.probe_count * coefficient_count(degree as usize) as u32;
        let lightmap_level = (level.lightmap_level as usize).min(LIGHTMAP_LEVELS - 1);
        ClusterExtent {
            rank: level.rank.unwrap_or(u32::MAX),
            columns: cluster.signal_count + of_probes,
            receivers: self.receivers[index][lightmap_level],
            solid,
            fade,
            fill: lightmap_level as u32,
        }
    }
}

/// How many of a cluster's receivers each level of the lightmap has: those that lead. A level without any takes those of the
/// next finer one.
pub(super) fn leading_receivers(baked: &BakedScene, cluster: &Cluster) -> [u32; LIGHTMAP_LEVELS] {
    let width = baked.lightmap.width;
    let level = |texel: u32| ((texel % width) | (texel / width)).trailing_zeros() as usize;
    let texels = baked.texels(cluster);
    let mut counts =
        std::array::from_fn(|n| texels.iter().take_while(|texel| level(**texel) >= n).count() as u32);
    for n in 1..LIGHTMAP_LEVELS {
        if counts[n] == 0 {
            counts[n] = counts[n - 1];
        }
    }
    counts
}

/// What boxes must touch to make each cluster active: its own box, or all places that a cluster of the grid lights.
fn reached_bounds(baked: &BakedScene) -> impl Iterator<Item = Bounds> {
    let of_lightmap = baked.clusters.iter().take(baked.lightmap_clusters()).map(|cluster| cluster.bounds);
    of_lightmap.chain(grid_reach(baked))
}

/// Where the receivers lie that draw on a probe.
fn sight_of_probe(probe: &Probe, settings: &LodSettings, input: &FrameInput) -> Sight {
    let radius = settings.support_shift * probe.support_radius;
    input.view.map_or(Sight::NEAR, |view| Sight::of_ball(view, probe.position, radius))
}

fn probe_extent(level: &LodLevel) -> ProbeExtent {
    ProbeExtent {
        // A level does not leave probes out.
        rays: level.rays.unwrap_or(u32::MAX).max(1),
        degree: level.degree.unwrap_or(u32::MAX),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;
    use crate::synthetic::{SyntheticSize, synthetic_room};
    use probelight_math::glam::Vec3;
    use proptest::prelude::*;

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
        let middle = LodLevel {
            distance: 15.0,
            rank: Some(8),
            degree: Some(3),
            rays: Some(32),
            ..LodLevel::default()
        };
        let far = LodLevel {
            distance: 35.0,
            rank: Some(4),
            degree: Some(1),
            rays: Some(9),
            lightmap_level: 1,
            ..LodLevel::default()
        };
        LodSettings { levels: vec![LodLevel::default(), middle, far], ..LodSettings::default() }
    }

    fn plan(baked: &BakedScene, settings: &LodSettings, input: &FrameInput) -> FramePlan {
        let mut plan = FramePlan::full(baked);
        Planner::new(baked).plan(baked, settings, input, &mut plan);
        plan
    }

    const AT_THE_FIRST: FrameInput<'static> = FrameInput {
        view: Some(View { position: Vec3::ZERO, direction: Vec3::ZERO }),
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

    /// Levels that begin nearer beside and behind the view.
    fn by_zones() -> LodSettings {
        let mut settings = settings();
        for level in &mut settings.levels[1..] {
            (level.beside, level.behind) = (Some(level.distance / 2.0), Some(level.distance / 4.0));
        }
        settings
    }

    fn looking(position: Vec3, direction: Vec3) -> FrameInput<'static> {
        FrameInput { view: Some(View { position, direction }), ..FrameInput::default() }
    }

    #[test]
    fn singular_values_come_and_go_by_and_by() {
        let baked = row();
        let settings = settings();
        // What a cluster has of each of its singular values, in all.
        let kept = |x: f32| {
            let plan = plan(&baked, &settings, &looking(Vec3::new(-x, 0.5, 0.5), Vec3::ZERO));
            let extent = plan.clusters()[0];
            assert!(extent.solid <= extent.rank && extent.fade <= FADE_STEPS);
            f64::from(extent.solid)
                + f64::from((extent.rank - extent.solid) * extent.fade) / f64::from(FADE_STEPS)
        };
        let walk: Vec<f64> = (0..4000).map(|step| kept(step as f32 * 0.01)).collect();
        assert_eq!((walk[0], walk[3999]), (24.0, 4.0));
        let steps = walk.windows(2).map(|pair| pair[0] - pair[1]);
        assert!(
            steps.clone().all(|step| (0.0..=16.0 / 16.0).contains(&step)),
            "{:?}",
            steps.fold(0.0, f64::max)
        );
        // Negative control: without a band they pop.
        let sharp = LodSettings { fade: 0.0, ..settings.clone() };
        let rank = |x: f32| plan(&baked, &sharp, &looking(Vec3::new(-x, 0.5, 0.5), Vec3::ZERO)).clusters()[0];
        assert_eq!([rank(14.9), rank(15.1)].map(|extent| [extent.rank, extent.solid]), [[24, 24], [8, 8]]);
    }

    #[test]
    fn less_is_computed_behind_the_view() {
        let baked = row();
        // The middle of the row, so that directions are mirror images.
        let middle = Vec3::new(35.5, 0.5, 0.5);
        let found = |direction| ranks(&plan(&baked, &by_zones(), &looking(middle, direction)));
        assert_eq!(found(Vec3::X), [4, 4, 4, 8, 24, 24, 8, 8]);
        assert_eq!(found(-Vec3::X), [8, 8, 24, 24, 8, 4, 4, 4]);
        assert_eq!(found(Vec3::Y), [4, 4, 8, 24, 24, 8, 4, 4]);
        assert_eq!(found(Vec3::ZERO), [8, 8, 24, 24, 24, 24, 8, 8], "without a direction all is in front");
    }

    #[test]
    fn the_support_radius_brings_probes_nearer() {
        let baked = row();
        let degrees = |support_shift| {
            let settings = LodSettings { support_shift, ..settings() };
            let plan = plan(&baked, &settings, &looking(Vec3::X * -14.5, Vec3::ZERO));
            plan.probes().iter().map(|probe| probe.degree).collect::<Vec<_>>()
        };
        assert_eq!(degrees(0.0)[..3], [7, 3, 3]);
        // 14.5 m to the first; the second is 24.5 m away, the third 34.5 m, each with receivers within a metre.
        assert_eq!(degrees(10.0)[..3], [7, 7, 3]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

        /// Whatever the camera and the levels, each column that a cluster reads is a coefficient that its probe computes.
        #[test]
        fn no_camera_makes_clusters_read_what_probes_do_not_compute(
            position in (-20.0f32..100.0, -30.0f32..30.0, -30.0f32..30.0),
            direction in (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0),
            levels in prop::collection::vec((0.0f32..60.0, 0.1f32..1.0, 0u32..26, 0u32..8, 0u32..65, 0u32..4), 1..5),
            support_shift in 0.0f32..3.0,
        ) {
            let baked = row();
            let mut levels: Vec<LodLevel> = levels
                .into_iter()
                .map(|(distance, nearer, rank, degree, rays, lightmap_level)| LodLevel {
                    distance,
                    beside: Some(distance * nearer),
                    behind: Some(0.0),
                    rank: Some(rank),
                    degree: Some(degree),
                    rays: Some(rays),
                    lightmap_level,
                    threshold: None,
                })
                .collect();
            levels.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            // Beside the view they must ascend, too.
            let mut last = 0.0f32;
            for level in &mut levels {
                last = last.max(level.beside.unwrap_or(0.0));
                level.beside = Some(last);
            }
            let settings = LodSettings { levels, support_shift, ..LodSettings::default() };
            settings.check().unwrap();
            let direction = Vec3::from(direction).normalize_or_zero();
            let plan = plan(&baked, &settings, &looking(position.into(), direction));
            for (cluster, extent) in baked.clusters.iter().zip(plan.clusters()) {
                let columns_of_probes = extent.columns.saturating_sub(cluster.signal_count);
                for probe in baked.probes_of(cluster) {
                    let computed = plan.probes()[*probe as usize].coefficients() as u32;
                    prop_assert!(
                        extent.rank == 0 || columns_of_probes <= cluster.probe_count * computed,
                        "{extent:?} of a probe with {computed}"
                    );
                }
            }
        }
    }
}
