//! Which patches of surface a cluster takes light from: fine ones where it matters, coarse ones elsewhere.
//!
//! A patch stands for its surfels by their mean radiance. What that costs depends on how much of the patch the
//! receivers see and on how much the radiance varies within it; the [light ensemble](crate::light::ensemble)
//! tells. So a patch is taken whole if that product is negligible against the light that arrives, and divided
//! otherwise. What is negligible, each part of the cluster judges by its own light, under each lighting.
//!
//! The ensemble knows no torch that lights a single surfel, nor a sconce on its wall. So surfels also count as if each shone on
//! its own: then a patch may be taken whole if the receivers see all of its surfels alike.

use std::collections::{BTreeMap, HashMap};
use std::f32::consts::PI;

use probelight_asset::NONE;

use crate::compression::metric::lighting_weights;
use crate::light::ensemble::LightEnsemble;
use crate::light::surfels::SurfelTree;

/// Parts of a cluster whose mean view decides.
pub(crate) const WITNESSES: usize = 32;

/// Lightings whose energy at a witness is below this share of the mean count less. It is tiny, so that a room to which
/// a thousandth of the light finds its way keeps its own: no patch may reach round the corner.
const DIM_SHARE: f32 = 1e-6;

/// How much of the light of a patch reaches the witnesses, steradians.
#[derive(Clone, Copy, Debug)]
struct Views {
    sums: [f32; WITNESSES],
    /// Sums of the squares of what of each surfel does.
    squares: [f32; WITNESSES],
}

impl Views {
    const NONE: Self = Self { sums: [0.0; WITNESSES], squares: [0.0; WITNESSES] };

    /// Of a surfel.
    fn of_surfel(sums: [f32; WITNESSES]) -> Self {
        Self { sums, squares: sums.map(|sum| sum * sum) }
    }

    fn add(&mut self, part: &Self) {
        self.sums.iter_mut().zip(part.sums).for_each(|(sum, of_part)| *sum += of_part);
        self.squares.iter_mut().zip(part.squares).for_each(|(sum, of_part)| *sum += of_part);
    }
}

/// The patches that a cluster uses, and where each surfel's light goes.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchChoice {
    /// Numbers of the chosen patches, ascending.
    pub(crate) patches: Vec<u32>,
    /// Column of each seen surfel, and what its light is as a share of the patch's.
    columns: HashMap<u32, (u32, f32)>,
}

impl PatchChoice {
    /// Chooses patches for surfels that receivers see. `witnesses` holds for each part of the cluster the
    /// surfels it sees and how much of their light arrives (steradians); `seen` are all surfels that any
    /// receiver sees. An error of √`tolerance` of the arriving light is accepted for each patch, of which a share of
    /// `unforeseen` may come from surfels that shine independently of each other.
    pub(crate) fn new(
        tree: &SurfelTree,
        ensemble: &LightEnsemble,
        witnesses: &[Vec<(u32, f32)>],
        seen: &[u32],
        tolerance: f32,
        unforeseen: f32,
    ) -> Self {
        let (views, squares) = views_of_patches(tree, witnesses, seen);
        let judge = Judge::new(ensemble, witnesses, &squares, unforeseen);
        let accepted = tolerance * judge.arriving;
        let mut choice = Self::default();
        let mut pending: Vec<u32> =
            views.keys().copied().filter(|patch| tree.parents[*patch as usize] == NONE).collect();
        let mut chosen = Vec::new();
        while let Some(patch) = pending.pop() {
            let Some(view) = views.get(&patch) else { continue };
            match tree.children(patch) {
                Some(children) if judge.error(tree, patch, view) > accepted => pending.extend(children),
                _ => chosen.push(patch),
            }
        }
        chosen.sort_unstable();
        choice.patches = chosen;
        choice.assign_surfels(tree, ensemble, seen);
        choice
    }

    /// The column that a surfel's light comes from, and its share: how bright the surfel is against the patch.
    pub(crate) fn column(&self, surfel: u32) -> Option<(usize, f32)> {
        self.columns.get(&surfel).map(|(column, share)| (*column as usize, *share))
    }

    /// Finds the chosen patch of each seen surfel. The parts of a patch that are seen are often brighter than
    /// those that are not; the share under the ensemble's lightings takes this into account.
    fn assign_surfels(&mut self, tree: &SurfelTree, ensemble: &LightEnsemble, seen: &[u32]) {
        for surfel in seen {
            let mut patch = *surfel;
            while patch != NONE {
                if let Ok(column) = self.patches.binary_search(&patch) {
                    let share = share_of_patch(ensemble, *surfel, patch);
                    self.columns.insert(*surfel, (column as u32, share));
                    break;
                }
                patch = tree.parents[patch as usize];
            }
        }
    }
}

/// How bright a surfel is against its patch: the mean over the lightings, none of which counts much more than the
/// others for being bright. (The factor of least squares would lose energy where the two vary independently.)
fn share_of_patch(ensemble: &LightEnsemble, surfel: u32, patch: u32) -> f32 {
    if surfel == patch {
        return 1.0;
    }
    let (part, whole) = (ensemble.scalar(surfel as usize), ensemble.scalar(patch as usize));
    let mean = whole.iter().sum::<f32>() / whole.len().max(1) as f32;
    let (mut of_part, mut of_whole) = (0.0, 0.0);
    for ((part, whole), prior) in part.iter().zip(whole).zip(ensemble.weights()) {
        let weight = prior / (whole + mean).max(f32::MIN_POSITIVE);
        of_part += weight * part;
        of_whole += weight * whole;
    }
    if of_whole > 0.0 { of_part / of_whole } else { 1.0 }
}

/// The lightings as a cluster's witnesses see them.
struct Judge<'a> {
    ensemble: &'a LightEnsemble,
    /// How much each lighting counts, witness by witness.
    weights: Vec<f32>,
    /// Whether any lighting sends light here. Where none does, all surfels may be bright or dark.
    is_reached: bool,
    /// Weighted energy of the light that arrives by way of surfels.
    arriving: f32,
    /// Mean square of the radiance of surfels that shine independently, witness by witness.
    unforeseen: Vec<f32>,
}

impl<'a> Judge<'a> {
    /// `squares` are those of how much each witness sees of each surfel, summed.
    fn new(
        ensemble: &'a LightEnsemble,
        witnesses: &[Vec<(u32, f32)>],
        squares: &[f32; WITNESSES],
        unforeseen_share: f32,
    ) -> Self {
        let count = ensemble.count;
        let mut weights = Vec::with_capacity(witnesses.len() * count);
        let (mut arriving, mut unforeseen) = (0.0, Vec::with_capacity(witnesses.len()));
        for (witness, squares) in witnesses.iter().zip(squares) {
            let mut energies = vec![0.0; count];
            for (surfel, weight) in witness {
                for (sum, radiance) in energies.iter_mut().zip(ensemble.scalar(*surfel as usize)) {
                    *sum += weight * radiance;
                }
            }
            energies.iter_mut().for_each(|energy| *energy *= *energy);
            if energies.iter().all(|energy| *energy == 0.0) {
                // A witness without any light has no say.
                weights.extend(energies);
                unforeseen.push(0.0);
                continue;
            }
            let of_witness = lighting_weights(&energies, ensemble.weights(), DIM_SHARE);
            let energy = energies.iter().zip(&of_witness).map(|(e, w)| e * w).sum::<f32>();
            unforeseen.push(unforeseen_share * energy / squares.max(f32::MIN_POSITIVE));
            arriving += energy;
            weights.extend(of_witness);
        }
        let is_reached = arriving > 0.0;
        let arriving = if is_reached { arriving } else { PI * PI };
        Self { ensemble, weights, is_reached, arriving, unforeseen }
    }

    /// Weighted energy that taking a patch's mean may change, for the witnesses' views of it.
    fn error(&self, tree: &SurfelTree, patch: u32, view: &Views) -> f32 {
        if !self.is_reached {
            return view.sums.iter().map(|w| w * w).sum();
        }
        let Some(group) = (patch as usize).checked_sub(tree.surfels.len()) else { return 0.0 };
        let variances: Vec<f32> = self.ensemble.variances(group).collect();
        let of_witness = |(weights, view): (&[f32], &f32)| {
            view * view
                * variances.iter().zip(weights).map(|(variance, weight)| variance * weight).sum::<f32>()
        };
        let foreseen: f32 =
            self.weights.chunks_exact(self.ensemble.count).zip(&view.sums).map(of_witness).sum();
        // Of independent surfels that are seen alike, the mean is all that counts.
        let surfels = tree.surfels_in(patch) as f32;
        let unevenness =
            view.squares.iter().zip(view.sums).map(|(squares, sum)| squares - sum * sum / surfels);
        let unforeseen: f32 =
            unevenness.zip(&self.unforeseen).map(|(uneven, energy)| uneven.max(0.0) * energy).sum();
        foreseen + unforeseen
    }
}

/// The views of all patches that contain a seen surfel, and the squares of those of all surfels, summed.
fn views_of_patches(
    tree: &SurfelTree,
    witnesses: &[Vec<(u32, f32)>],
    seen: &[u32],
) -> (HashMap<u32, Views>, [f32; WITNESSES]) {
    let mut of_surfels: BTreeMap<u32, [f32; WITNESSES]> =
        seen.iter().map(|surfel| (*surfel, [0.0; WITNESSES])).collect();
    for (w, witness) in witnesses.iter().enumerate() {
        for (surfel, weight) in witness {
            of_surfels.entry(*surfel).or_insert([0.0; WITNESSES])[w] += weight;
        }
    }
    let mut pending: BTreeMap<u32, Views> =
        of_surfels.into_iter().map(|(surfel, sums)| (surfel, Views::of_surfel(sums))).collect();
    let mut all = Views::NONE;
    pending.values().for_each(|view| all.add(view));
    // Children have smaller numbers than their group, so a patch is complete when it is the smallest.
    let mut views = HashMap::new();
    while let Some((patch, view)) = pending.pop_first() {
        let parent = tree.parents[patch as usize];
        if parent != NONE {
            pending.entry(parent).or_insert(Views::NONE).add(&view);
        }
        views.insert(patch, view);
    }
    (views, all.squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::small_scene::SmallScene;

    /// What some receivers of a scene see, and all surfels seen.
    fn views(scene: &SmallScene) -> (Vec<Vec<(u32, f32)>>, Vec<u32>) {
        let witness = |receiver| {
            let hits = scene.gather(receiver, 64).into_iter().filter_map(|ray| ray.hit);
            let surfel = |hit| scene.light.sources.surfels.surfel_of_hit(&scene.ground.atlas, &hit);
            hits.map(|hit| (surfel(hit), 0.05)).filter(|(surfel, _)| *surfel != NONE).collect()
        };
        let receivers = scene.ground.texels();
        let witnesses: Vec<Vec<(u32, f32)>> = receivers.step_by(7).take(WITNESSES).map(witness).collect();
        let mut seen: Vec<u32> = witnesses.iter().flatten().map(|(surfel, _)| *surfel).collect();
        seen.sort_unstable();
        seen.dedup();
        (witnesses, seen)
    }

    fn choose(scene: &SmallScene, tolerance: f32) -> PatchChoice {
        let (witnesses, seen) = views(scene);
        let ensemble = scene.light.ensemble.as_ref().unwrap();
        PatchChoice::new(&scene.light.sources.surfels, ensemble, &witnesses, &seen, tolerance, 0.25)
    }

    #[test]
    fn without_tolerance_every_seen_surfel_is_a_column_of_its_own() {
        let scene = SmallScene::load("cornell.glb");
        let (_, seen) = views(&scene);
        let choice = choose(&scene, 0.0);
        assert_eq!(choice.patches, seen);
        for (column, surfel) in seen.iter().enumerate() {
            assert_eq!(choice.column(*surfel), Some((column, 1.0)));
        }
    }

    #[test]
    fn with_any_tolerance_only_the_roots_are_left() {
        let scene = SmallScene::load("cornell.glb");
        let tree = &scene.light.sources.surfels;
        let choice = choose(&scene, f32::INFINITY);
        assert!(!choice.patches.is_empty());
        assert!(choice.patches.iter().all(|patch| tree.parents[*patch as usize] == NONE));
    }

    /// The surfels of a patch.
    fn surfels_of(tree: &SurfelTree, patch: u32) -> Vec<u32> {
        tree.children(patch).map_or(vec![patch], |children| {
            children.into_iter().flat_map(|child| surfels_of(tree, child)).collect()
        })
    }

    #[test]
    fn patches_that_are_seen_unevenly_err_by_light_that_no_lighting_has() {
        let scene = SmallScene::load("cornell.glb");
        let (tree, ensemble) = (&scene.light.sources.surfels, scene.light.ensemble.as_ref().unwrap());
        let patch = tree.surfels.len() as u32;
        let surfels = surfels_of(tree, patch);
        let count = surfels.len() as f32;
        assert!(count >= 2.0 && count == tree.surfels_in(patch) as f32);
        let share = 0.3;
        // How much a share of unforeseen light adds to the patch's error, in shares of what arrives.
        let added = |weight: &dyn Fn(usize) -> f32| {
            let witness: Vec<(u32, f32)> =
                surfels.iter().enumerate().map(|(i, surfel)| (*surfel, weight(i))).collect();
            let (views, squares) = views_of_patches(tree, std::slice::from_ref(&witness), &surfels);
            let [with, without] = [share, 0.0].map(|share| {
                let judge = Judge::new(ensemble, std::slice::from_ref(&witness), &squares, share);
                judge.error(tree, patch, &views[&patch]) / judge.arriving
            });
            with - without
        };
        assert!(added(&|_| 0.01).abs() < 1e-4, "all are seen alike: {}", added(&|_| 0.01));
        // Where one of them is all that is seen, none of its own light is in the mean of the others.
        let alone = added(&|i| if i == 0 { 0.01 } else { 0.0 });
        assert!((alone / (share * (1.0 - 1.0 / count)) - 1.0).abs() < 1e-3, "{alone}");
    }

    #[test]
    fn smaller_tolerances_take_more_patches_and_each_seen_surfel_has_exactly_one() {
        let scene = SmallScene::load("cornell.glb");
        let (_, seen) = views(&scene);
        let tree = &scene.light.sources.surfels;
        let choices = [1e-2, 1e-4, 1e-6].map(|tolerance| choose(&scene, tolerance));
        assert!(choices.is_sorted_by(|a, b| a.patches.len() < b.patches.len()));
        for surfel in seen {
            for choice in &choices {
                let (column, share) = choice.column(surfel).expect("every seen surfel has a column");
                assert!(share.is_finite() && share >= 0.0);
                let mut above = vec![surfel];
                while let Some(parent) =
                    above.last().map(|p| tree.parents[*p as usize]).filter(|p| *p != NONE)
                {
                    above.push(parent);
                }
                let chosen: Vec<&u32> = above.iter().filter(|p| choice.patches.contains(p)).collect();
                assert_eq!(chosen, [&choice.patches[column]]);
            }
        }
        assert_eq!(choices[0].column(u32::MAX - 1), None);
    }
}
