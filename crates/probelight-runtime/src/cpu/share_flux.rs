//! Shares the rays that a light sent out among the surfels.
//!
//! Where many rays arrive, each surfel has those that met it. Where few do, their number says little about a single
//! surfel; so patches divide their rays by what each part would get if nothing were in the way, unless what was counted
//! tells otherwise (a shadow, a surfel that the light is very near to). That is Haar shrinkage on the tree of patches:
//! whatever is kept of a difference, no flux gets lost.
//!
//! What lies below large groups is divided in blocks, side by side, or in the turns of some frames.

use probelight_asset::NONE;

use super::patch_tree::{Branch, PatchTree};
use super::stretches::{Stretches, for_each_stretch};
use crate::shadow_turns::ShadowTurn;

/// Variance of a count of well-stratified rays, as a multiple of the standard deviation that chance would have: only along
/// a patch's outline does it matter where the rays lie. And one ray may always fall on either side.
const VARIANCE_PER_DEVIATION: f32 = 0.5;
const LEAST_VARIANCE: f32 = 1.0;

/// Rays at patches, by their places in a [`PatchTree`].
#[derive(Clone, Debug, Default)]
pub(super) struct PatchFlux {
    /// Rays that arrived, each weighed by what is left of its light.
    counted: Vec<f32>,
    /// What would arrive if nothing were in the way, up to a common factor.
    expected: Vec<f32>,
    /// What each patch gets of the rays.
    shared: Vec<f32>,
    verdicts: Vec<Verdict>,
    /// What each surfel expects before it is asked, by its number.
    of_surfels: Vec<f32>,
}

/// Some of them.
struct Patches<'a> {
    counted: &'a mut [f32],
    expected: &'a mut [f32],
    shared: &'a mut [f32],
    verdicts: &'a mut [Verdict],
}

impl Stretches for Patches<'_> {
    fn split_at(self, middle: usize) -> (Self, Self) {
        let (counted, counted_behind) = self.counted.split_at_mut(middle);
        let (expected, expected_behind) = self.expected.split_at_mut(middle);
        let (shared, shared_behind) = self.shared.split_at_mut(middle);
        let (verdicts, verdicts_behind) = self.verdicts.split_at_mut(middle);
        let behind = Self {
            counted: counted_behind,
            expected: expected_behind,
            shared: shared_behind,
            verdicts: verdicts_behind,
        };
        (Self { counted, expected, shared, verdicts }, behind)
    }
}

/// Whether a patch sees the light that gets a share of it though no ray met it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Verdict {
    #[default]
    None,
    /// It was asked, or what it is part of: it does.
    Sees,
    Hidden,
}

/// What is asked of patches that no ray met.
pub(super) struct Questions<S> {
    /// Groups that get up to so many rays are asked as a whole.
    pub(super) largest: f32,
    /// Whether a surfel sees the light.
    pub(super) sees: S,
}

impl PatchFlux {
    /// Without any rays.
    pub(super) fn new(tree: &PatchTree, surfels: usize) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        let [counted, expected, shared] = [(); 3].map(|()| zeros(tree.len()));
        let verdicts = vec![Verdict::None; tree.len()];
        Self { counted, expected, shared, verdicts, of_surfels: zeros(surfels) }
    }

    /// Takes in rays: the surfel that each met, and what is left of its light.
    pub(super) fn count(&mut self, tree: &PatchTree, rays: impl Iterator<Item = (u32, f32)>) {
        self.counted.fill(0.0);
        for (surfel, left) in rays {
            self.counted[tree.place_of(surfel as usize).0] += left;
        }
    }

    /// What each surfel expects, by number, to be set before light is shared.
    pub(super) fn of_surfels_mut(&mut self) -> &mut [f32] {
        &mut self.of_surfels
    }

    /// Rays that a surfel gets.
    pub(super) fn shared(&self, tree: &PatchTree, surfel: usize) -> f32 {
        self.shared[tree.place_of(surfel).0]
    }

    fn all(&mut self) -> Patches<'_> {
        let Self { counted, expected, shared, verdicts, .. } = self;
        Patches { counted, expected, shared, verdicts }
    }

    /// Finds what the surfels get whose blocks have their turn, from what surfels counted and what each expects. Patches that
    /// no ray met are asked whether they see the light: else what lies in the shadow of a wall would get light from beside it.
    ///
    /// `seen` keeps, for each root, the share of what it expects that is not hidden, as it was found in its turn.
    pub(super) fn share(
        &mut self,
        tree: &PatchTree,
        turn: ShadowTurn,
        seen: &mut [f32],
        questions: &Questions<impl Fn(u32) -> bool + Sync>,
    ) {
        self.begin(tree);
        divide_top(tree, &mut self.all());
        question(tree.top(), &mut self.all(), questions, |place| tree.parts_at(place), tree.surfels());
        let has_turn = |root: usize| turn.has(tree.block_at(root));
        for (root, seen) in tree.roots().iter().zip(&mut *seen).filter(|(root, _)| has_turn(**root)) {
            *seen = self.expected[*root];
        }
        for_each_block(tree, self.all(), &|block, mut patches| {
            if turn.has(block) {
                let branch = tree.block(block);
                divide(branch, &mut patches);
                question(branch, &mut patches, questions, |place| branch.parts_at(place), branch.surfels);
                hide(branch, &mut patches);
            }
        });
        for (root, seen) in tree.roots().iter().zip(seen) {
            let expected = &mut self.expected[*root];
            if has_turn(*root) {
                *seen = if *seen > 0.0 { *expected / *seen } else { 1.0 };
            } else {
                *expected *= *seen;
            }
        }
        divide_top(tree, &mut self.all());
        for_each_block(tree, self.all(), &|block, mut patches| {
            if turn.has(block) {
                divide(tree.block(block), &mut patches);
            }
        });
    }

    /// Sums up what the blocks' surfels counted and expect. Nobody was asked yet.
    fn begin(&mut self, tree: &PatchTree) {
        let Self { counted, expected, shared, verdicts, of_surfels } = self;
        verdicts.fill(Verdict::None);
        for_each_block(tree, Patches { counted, expected, shared, verdicts }, &|block, patches| {
            let branch = tree.block(block);
            for (expected, surfel) in patches.expected.iter_mut().zip(branch.surfels) {
                *expected = of_surfels[*surfel as usize];
            }
            sum_up(branch, patches.counted);
            sum_up(branch, patches.expected);
        });
    }
}

/// Works on the patches of all blocks, side by side.
fn for_each_block<'a>(tree: &PatchTree, patches: Patches<'a>, work: &(impl Fn(usize, Patches<'a>) + Sync)) {
    for_each_stretch(0..tree.blocks(), 1, patches, &|block| tree.start(block), work);
}

/// Gives groups the sum of what their parts have.
fn sum_up(branch: Branch<'_>, values: &mut [f32]) {
    for (group, [a, b]) in branch.groups() {
        values[group] = values[a] + values[b];
    }
}

/// Divides what the top's groups counted, down to the roots of blocks. What is part of nothing keeps what it counted.
fn divide_top(tree: &PatchTree, patches: &mut Patches<'_>) {
    let top = tree.top();
    sum_up(top, patches.counted);
    sum_up(top, patches.expected);
    let groups = top.first_group..patches.shared.len();
    for place in tree.roots().iter().copied().chain(groups) {
        patches.shared[place] = patches.counted[place];
    }
    divide(top, patches);
}

/// Divides what groups get among their parts, from large ones to small ones.
fn divide(branch: Branch<'_>, patches: &mut Patches<'_>) {
    let Patches { counted, expected, shared, .. } = patches;
    for (group, [a, b]) in branch.groups().rev() {
        let flux = shared[group];
        let first = if flux > 0.0 {
            flux * first_share([counted[a], counted[b]], [expected[a], expected[b]])
        } else {
            0.0
        };
        shared[a] = first;
        shared[b] = flux - first;
    }
}

/// Asks the largest patches that get no more than the questions' rays, or are surfels, though no ray met them: of each the
/// surfel that expects most. `parts` and `surfels` are those of all that the branch's groups are made of.
fn question(
    branch: Branch<'_>,
    patches: &mut Patches<'_>,
    questions: &Questions<impl Fn(u32) -> bool>,
    parts: impl Fn(usize) -> Option<[usize; 2]>,
    surfels: &[u32],
) {
    let Patches { counted, expected, shared, verdicts } = patches;
    let is_surfel = |place: usize| surfels.get(place).is_some_and(|surfel| *surfel != NONE);
    for (group, its_parts) in branch.groups().rev() {
        let said = verdicts[group];
        for part in its_parts {
            if said != Verdict::None {
                verdicts[part] = said;
            } else if counted[part] == 0.0
                && shared[part] > 0.0
                && (shared[part] <= questions.largest || is_surfel(part))
            {
                let mut brightest = part;
                while let Some([a, b]) = parts(brightest) {
                    brightest = if expected[a] >= expected[b] { a } else { b };
                }
                let sees = !is_surfel(brightest) || (questions.sees)(surfels[brightest]);
                verdicts[part] = if sees { Verdict::Sees } else { Verdict::Hidden };
            }
        }
    }
}

/// Takes what they expect from the surfels of a block that do not see the light.
fn hide(branch: Branch<'_>, patches: &mut Patches<'_>) {
    let Patches { expected, verdicts, .. } = patches;
    for (expected, verdict) in expected.iter_mut().zip(&**verdicts).take(branch.surfels.len()) {
        if *verdict == Verdict::Hidden {
            *expected = 0.0;
        }
    }
    sum_up(branch, expected);
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
    use probelight_asset::SurfelGroup;

    /// Four surfels in three groups: (0 1) (2 3).
    const GROUPS: [SurfelGroup; 3] = [
        SurfelGroup { children: [0, 1], first_weight: 0.5 },
        SurfelGroup { children: [2, 3], first_weight: 0.5 },
        SurfelGroup { children: [4, 5], first_weight: 0.5 },
    ];

    fn shares(counted: [f32; 4], expected: [f32; 4], sees: impl Fn(u32) -> bool + Sync) -> [f32; 4] {
        let tree = PatchTree::new(4, &GROUPS);
        let mut flux = PatchFlux::new(&tree, 4);
        flux.count(&tree, (0..).zip(counted));
        flux.of_surfels_mut().copy_from_slice(&expected);
        flux.share(&tree, ShadowTurn::ALL, &mut [1.0], &Questions { largest: 0.5, sees });
        std::array::from_fn(|surfel| flux.shared(&tree, surfel))
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

    /// A tree of many blocks, as few rays as make every choice matter: blocks in turns end where all at once do.
    #[test]
    fn blocks_that_had_their_turns_have_what_all_have_at_once() {
        let surfels = 1 << 13;
        let group = |number: u32| SurfelGroup { children: [2 * number, 2 * number + 1], first_weight: 0.5 };
        let groups: Vec<SurfelGroup> = (0..surfels - 1).map(group).collect();
        let tree = PatchTree::new(surfels as usize, &groups);
        assert!(tree.blocks() >= 8 && tree.top().groups().count() > 3);
        let mut rng = probelight_math::sampling::Rng::new(5, 6);
        let counted: Vec<f32> = (0..surfels).map(|_| (3.0 * rng.next_f32() - 1.5).max(0.0).floor()).collect();
        let questions = Questions { largest: 0.5, sees: |surfel: u32| !surfel.is_multiple_of(5) };
        let mut flux = PatchFlux::new(&tree, surfels as usize);
        (0..).zip(flux.of_surfels_mut()).for_each(|(surfel, value)| *value = 1.0 + (surfel % 7) as f32);
        let mut seen = vec![1.0; tree.roots().len()];
        let mut share = |turn, turns| {
            flux.count(&tree, (0..).zip(counted.iter().copied()));
            flux.share(&tree, ShadowTurn { turn, turns }, &mut seen, &questions);
            let of = |surfel: u32| flux.shared(&tree, surfel as usize);
            (0..surfels).map(of).collect::<Vec<f32>>()
        };
        let at_once = share(0, 1);
        let mut in_turns = vec![f32::NAN; surfels as usize];
        for turn in 0..4 {
            let found = share(turn, 4);
            let has_turn = |surfel: &usize| tree.place_of(*surfel).1 % 4 == turn;
            for surfel in (0..surfels as usize).filter(has_turn) {
                in_turns[surfel] = found[surfel];
            }
        }
        for (at_once, in_turns) in at_once.iter().zip(&in_turns) {
            assert!((at_once - in_turns).abs() < 1e-3, "{in_turns} in turns, {at_once} at once");
        }
        let total: f32 = counted.iter().sum();
        assert!((at_once.iter().sum::<f32>() / total - 1.0).abs() < 1e-4);
    }
}
