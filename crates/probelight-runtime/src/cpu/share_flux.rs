//! Shares the rays that a light sent out among the surfels.
//!
//! Where many rays arrive, each surfel has those that met it. Where few do, their number says little about a single
//! surfel; so patches divide their rays by what each part would get if nothing were in the way, unless what was counted
//! tells otherwise (a shadow, a surfel that the light is very near to). That is Haar shrinkage on the tree of patches:
//! whatever is kept of a difference, no flux gets lost.

use probelight_asset::SurfelGroup;
use rayon::prelude::*;

/// Variance of a count of well-stratified rays, as a multiple of the standard deviation that chance would have: only along
/// a patch's outline does it matter where the rays lie. And one ray may always fall on either side.
const VARIANCE_PER_DEVIATION: f32 = 0.5;
const LEAST_VARIANCE: f32 = 1.0;

/// Rays at patches: surfels, then groups.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchFlux {
    /// Rays that arrived, each weighed by what is left of its light.
    pub(super) counted: Vec<f32>,
    /// What would arrive if nothing were in the way, up to a common factor.
    pub(super) expected: Vec<f32>,
    /// What each patch gets of the rays.
    pub(super) shared: Vec<f32>,
    /// Patches that get a share though no ray met them.
    doubtful: Vec<Doubt>,
    /// Of each patch, what is said of the patch that it is part of.
    verdicts: Vec<Verdict>,
}

/// A patch of which it is asked whether it sees the light.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    patch: u32,
    /// The surfel that answers: that which expects most.
    surfel: u32,
    is_hidden: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Verdict {
    #[default]
    None,
    /// It belongs to a patch that is asked.
    Asked,
    /// It belongs to a patch that does not see the light.
    Hidden,
}

impl PatchFlux {
    /// Without any rays.
    pub(super) fn new(patches: usize) -> Self {
        let zeros = || vec![0.0; patches];
        Self {
            counted: zeros(),
            expected: zeros(),
            shared: zeros(),
            doubtful: Vec::with_capacity(patches),
            verdicts: vec![Verdict::None; patches],
        }
    }

    /// Finds what each surfel gets from what surfels counted and expect. Of patches that no ray met `sees` says whether
    /// one of their surfels sees the light: else what lies in the shadow of a wall would get light from beside it.
    ///
    /// Groups that get up to `largest` rays are asked as a whole.
    pub(super) fn share(&mut self, groups: &[SurfelGroup], largest: f32, sees: impl Fn(u32) -> bool + Sync) {
        let surfels = self.counted.len() - groups.len();
        for (number, group) in (surfels..).zip(groups) {
            let [a, b] = group.children.map(|child| child as usize);
            self.counted[number] = self.counted[a] + self.counted[b];
        }
        self.divide(groups);
        self.find_doubtful(groups, largest);
        self.doubtful.par_iter_mut().with_min_len(64).for_each(|doubt| doubt.is_hidden = !sees(doubt.surfel));
        for doubt in self.doubtful.iter().filter(|doubt| doubt.is_hidden) {
            self.verdicts[doubt.patch as usize] = Verdict::Hidden;
        }
        for (number, group) in (surfels..self.counted.len()).zip(groups).rev() {
            if self.verdicts[number] == Verdict::Hidden {
                group.children.iter().for_each(|child| self.verdicts[*child as usize] = Verdict::Hidden);
            }
        }
        for (expected, verdict) in self.expected.iter_mut().zip(&self.verdicts[..surfels]) {
            if *verdict == Verdict::Hidden {
                *expected = 0.0;
            }
        }
        self.divide(groups);
    }

    /// Divides what was counted, from large patches to small ones.
    fn divide(&mut self, groups: &[SurfelGroup]) {
        let Self { counted, expected, shared, .. } = self;
        let surfels = counted.len() - groups.len();
        for (number, group) in (surfels..).zip(groups) {
            let [a, b] = group.children.map(|child| child as usize);
            expected[number] = expected[a] + expected[b];
        }
        // Patches that are part of no other keep what they counted.
        shared.copy_from_slice(counted);
        for (number, group) in (surfels..counted.len()).zip(groups).rev() {
            let [a, b] = group.children.map(|child| child as usize);
            let flux = shared[number];
            let first = if flux > 0.0 {
                flux * first_share([counted[a], counted[b]], [expected[a], expected[b]])
            } else {
                0.0
            };
            shared[a] = first;
            shared[b] = flux - first;
        }
    }

    /// Finds the largest patches that get no more than `largest`, or are surfels, though no ray met them.
    fn find_doubtful(&mut self, groups: &[SurfelGroup], largest: f32) {
        let Self { counted, expected, shared, doubtful, verdicts } = self;
        let surfels = counted.len() - groups.len();
        doubtful.clear();
        verdicts.fill(Verdict::None);
        for (number, group) in (surfels..counted.len()).zip(groups).rev() {
            for child in group.children.map(|child| child as usize) {
                if verdicts[number] == Verdict::Asked {
                    verdicts[child] = Verdict::Asked;
                } else if counted[child] == 0.0
                    && shared[child] > 0.0
                    && (shared[child] <= largest || child < surfels)
                {
                    verdicts[child] = Verdict::Asked;
                    let mut surfel = child;
                    while surfel >= surfels {
                        let [a, b] = groups[surfel - surfels].children.map(|child| child as usize);
                        surfel = if expected[a] >= expected[b] { a } else { b };
                    }
                    doubtful.push(Doubt { patch: child as u32, surfel: surfel as u32, is_hidden: false });
                }
            }
        }
    }
}

/// Share of the first of two patches, given what each counted and expects. A difference from what was expected is noise up
/// to its standard deviation, and light from twice that on.
#[inline]
fn first_share(counted: [f32; 2], expected: [f32; 2]) -> f32 {
    let [rays, both] = [counted, expected].map(|of_patches| of_patches.iter().sum::<f32>());
    let share = if both > 0.0 { expected[0] / both } else { 0.5 };
    if rays == 0.0 {
        return share;
    }
    let difference = counted[0] - rays * share;
    let by_chance = (rays * share * (1.0 - share)).sqrt();
    let deviation = (VARIANCE_PER_DEVIATION * by_chance + LEAST_VARIANCE).sqrt();
    let t = (difference.abs() / deviation - 1.0).clamp(0.0, 1.0);
    (share + t * t * (3.0 - 2.0 * t) * difference / rays).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four surfels in three groups: (0 1) (2 3).
    const GROUPS: [SurfelGroup; 3] = [
        SurfelGroup { children: [0, 1], first_weight: 0.5 },
        SurfelGroup { children: [2, 3], first_weight: 0.5 },
        SurfelGroup { children: [4, 5], first_weight: 0.5 },
    ];

    fn shares(counted: [f32; 4], expected: [f32; 4], sees: impl Fn(u32) -> bool + Sync) -> [f32; 4] {
        let mut flux = PatchFlux::new(7);
        flux.counted[..4].copy_from_slice(&counted);
        flux.expected[..4].copy_from_slice(&expected);
        flux.share(&GROUPS, 0.5, sees);
        std::array::from_fn(|surfel| flux.shared[surfel])
    }

    #[test]
    fn many_rays_stay_where_they_fell_and_none_gets_lost() {
        let counted = [900.0, 100.0, 0.0, 350.0];
        let found = shares(counted, [1.0; 4], |_| true);
        for (found, counted) in found.iter().zip(counted) {
            assert!((found - counted).abs() < 1e-3, "{found} for {counted}");
        }
    }

    #[test]
    fn few_rays_are_divided_by_what_is_expected() {
        let found = shares([1.0, 0.0, 1.0, 0.0], [1.0, 3.0, 2.0, 2.0], |_| true);
        for (found, expected) in found.iter().zip([0.25, 0.75, 0.5, 0.5]) {
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
        }
    }

    #[test]
    fn what_does_not_see_the_light_gets_nothing_of_its_neighbors() {
        let hidden = |surfel: u32| surfel != 1;
        let found = shares([1.0, 0.0, 1.0, 0.0], [1.0, 3.0, 2.0, 2.0], hidden);
        assert_eq!(found[1], 0.0);
        assert!((found.iter().sum::<f32>() - 2.0).abs() < 1e-6, "{found:?}");
        // A group that is asked as a whole: its surfel that expects most answers.
        let far = [30.0, 30.0, 0.0, 0.0];
        let found = shares(far, [1.0, 1.0, 2e-3, 1e-3], |surfel| surfel != 2);
        assert!(found[2..] == [0.0; 2] && (found[0] - 30.0).abs() < 1e-4, "{found:?}");
        let found = shares(far, [1.0, 1.0, 2e-3, 1e-3], |_| true);
        assert!(found[2] > 0.0 && found[3] > 0.0, "the far ones would get something: {found:?}");
    }

    #[test]
    fn flux_is_kept_whatever_is_counted_expected_and_seen() {
        let mut rng = probelight_math::sampling::Rng::new(3, 4);
        for _ in 0..1000 {
            let mut draw = |scale: f32| [0; 4].map(|_| (scale * (rng.next_f32() - 0.3)).max(0.0).floor());
            let (counted, expected) = (draw(9.0), draw(20.0));
            let hidden = draw(2.0);
            let found = shares(counted, expected, |surfel| hidden[surfel as usize] == 0.0);
            assert!(found.iter().all(|flux| *flux >= 0.0));
            let difference = found.iter().sum::<f32>() - counted.iter().sum::<f32>();
            assert!(difference.abs() < 1e-4, "{found:?} of {counted:?}");
        }
    }
}
