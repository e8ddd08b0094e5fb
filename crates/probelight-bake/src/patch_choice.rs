//! Which patches of surface a cluster takes light from: fine ones where it matters, coarse ones elsewhere.
//!
//! A patch stands for its surfels by their mean radiance. What that costs depends on how much of the patch the
//! receivers see and on how much the radiance varies within it; the [light ensemble](crate::light_ensemble)
//! tells. So a patch is taken whole if that product is negligible against the light that arrives, and divided
//! otherwise.

use std::collections::{BTreeMap, HashMap};

use probelight_asset::NONE;

use crate::light_ensemble::LightEnsemble;
use crate::metric::lighting_weights;
use crate::surfels::SurfelTree;

/// Receivers of a cluster whose view decides.
pub(crate) const WITNESSES: usize = 32;

/// How much of the light of each patch reaches the witnesses, steradians.
type Views = [f32; WITNESSES];

/// The patches that a cluster uses, and where each surfel's light goes.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchChoice {
    /// Numbers of the chosen patches, ascending.
    pub(crate) patches: Vec<u32>,
    /// Column of each seen surfel, and what its light is as a share of the patch's.
    columns: HashMap<u32, (u32, f32)>,
}

impl PatchChoice {
    /// Chooses patches for surfels that receivers see. `witnesses` holds for some receivers, evenly chosen, the
    /// surfels they see and how much of their light arrives (steradians); `seen` are all surfels that any
    /// receiver sees. An error of √`tolerance` of the arriving light is accepted for each patch.
    pub(crate) fn new(
        tree: &SurfelTree,
        ensemble: &LightEnsemble,
        witnesses: &[Vec<(u32, f32)>],
        seen: &[u32],
        tolerance: f32,
    ) -> Self {
        let views = views_of_patches(tree, witnesses, seen);
        let judge = Judge::new(ensemble, witnesses);
        let accepted = tolerance * judge.arriving;
        let mut choice = Self::default();
        let mut pending: Vec<u32> =
            views.keys().copied().filter(|patch| tree.parents[*patch as usize] == NONE).collect();
        let mut chosen = Vec::new();
        while let Some(patch) = pending.pop() {
            let Some(view) = views.get(&patch) else { continue };
            let view = view.iter().map(|w| w * w).sum::<f32>() / witnesses.len().max(1) as f32;
            match tree.children(patch) {
                Some(children) if view * judge.variance(tree, patch) > accepted => pending.extend(children),
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
    /// those that are not; the share that is best under the ensemble's lightings takes this into account.
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

/// The lightings as a cluster sees them.
struct Judge<'a> {
    ensemble: &'a LightEnsemble,
    /// How much each lighting counts.
    weights: Vec<f32>,
    /// Weighted energy of the light that arrives by way of surfels.
    arriving: f32,
}

impl<'a> Judge<'a> {
    fn new(ensemble: &'a LightEnsemble, witnesses: &[Vec<(u32, f32)>]) -> Self {
        let mut energies = vec![0.0; ensemble.count];
        let mut arriving = vec![0.0; ensemble.count];
        for witness in witnesses {
            arriving.fill(0.0);
            for (surfel, weight) in witness {
                for (sum, radiance) in arriving.iter_mut().zip(ensemble.scalar(*surfel as usize)) {
                    *sum += weight * radiance;
                }
            }
            energies.iter_mut().zip(&arriving).for_each(|(energy, e)| *energy += e * e);
        }
        energies.iter_mut().for_each(|energy| *energy /= witnesses.len().max(1) as f32);
        let weights = lighting_weights(&energies, ensemble.weights());
        let arriving = energies.iter().zip(&weights).map(|(e, w)| e * w).sum();
        Self { ensemble, weights, arriving }
    }

    /// Weighted variance of the radiance within a patch.
    fn variance(&self, tree: &SurfelTree, patch: u32) -> f32 {
        let Some(group) = (patch as usize).checked_sub(tree.surfels.len()) else { return 0.0 };
        let means = self.ensemble.scalar(patch as usize);
        let squares = self.ensemble.square(group);
        let variances = squares.iter().zip(means).map(|(square, mean)| (square - mean * mean).max(0.0));
        variances.zip(&self.weights).map(|(variance, weight)| variance * weight).sum()
    }
}

/// The views of all patches that contain a seen surfel.
fn views_of_patches(
    tree: &SurfelTree,
    witnesses: &[Vec<(u32, f32)>],
    seen: &[u32],
) -> HashMap<u32, Views> {
    let mut pending: BTreeMap<u32, Views> = seen.iter().map(|surfel| (*surfel, [0.0; WITNESSES])).collect();
    for (w, witness) in witnesses.iter().enumerate() {
        for (surfel, weight) in witness {
            pending.entry(*surfel).or_insert([0.0; WITNESSES])[w] += weight;
        }
    }
    // Children have smaller numbers than their group, so a patch is complete when it is the smallest.
    let mut views = HashMap::new();
    while let Some((patch, view)) = pending.pop_first() {
        let parent = tree.parents[patch as usize];
        if parent != NONE {
            let sum = pending.entry(parent).or_insert([0.0; WITNESSES]);
            sum.iter_mut().zip(view).for_each(|(sum, w)| *sum += w);
        }
        views.insert(patch, view);
    }
    views
}
