//! Which patches of surface a cluster takes light from: fine ones where it matters, coarse ones elsewhere.
//!
//! A patch stands for its surfels by their mean radiance. What that costs depends on how much of the patch the
//! receivers see and on how much the radiance varies within it; the [light ensemble](crate::light_ensemble)
//! tells. So a patch is taken whole if that product is negligible against the light that arrives, and divided
//! otherwise.

use std::collections::{BTreeMap, HashMap};

use probelight_asset::NONE;

use crate::light_ensemble::LightEnsemble;
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
    column_of_surfel: HashMap<u32, u32>,
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
        let accepted = tolerance * arriving_energy(ensemble, witnesses);
        let mut choice = Self::default();
        let mut pending: Vec<u32> =
            views.keys().copied().filter(|patch| tree.parents[*patch as usize] == NONE).collect();
        let mut chosen = Vec::new();
        while let Some(patch) = pending.pop() {
            let Some(view) = views.get(&patch) else { continue };
            let energy = view.iter().map(|w| w * w).sum::<f32>() / witnesses.len().max(1) as f32;
            match tree.children(patch) {
                Some(children) if energy * ensemble.spread(patch) > accepted => pending.extend(children),
                _ => chosen.push(patch),
            }
        }
        chosen.sort_unstable();
        choice.patches = chosen;
        choice.assign_surfels(tree, seen);
        choice
    }

    /// Column of a surfel's light.
    pub(crate) fn column(&self, surfel: u32) -> Option<usize> {
        self.column_of_surfel.get(&surfel).map(|column| *column as usize)
    }

    fn assign_surfels(&mut self, tree: &SurfelTree, seen: &[u32]) {
        for surfel in seen {
            let mut patch = *surfel;
            while patch != NONE {
                if let Ok(column) = self.patches.binary_search(&patch) {
                    self.column_of_surfel.insert(*surfel, column as u32);
                    break;
                }
                patch = tree.parents[patch as usize];
            }
        }
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

/// Mean square over witnesses and lightings of the light that arrives by way of surfels.
fn arriving_energy(ensemble: &LightEnsemble, witnesses: &[Vec<(u32, f32)>]) -> f32 {
    let mut total = 0.0;
    let mut arriving = vec![0.0; ensemble.count];
    for witness in witnesses {
        arriving.fill(0.0);
        for (surfel, weight) in witness {
            for (sum, radiance) in arriving.iter_mut().zip(ensemble.scalar(*surfel as usize)) {
                *sum += weight * radiance;
            }
        }
        total += arriving.iter().map(|e| e * e).sum::<f32>();
    }
    total / (witnesses.len() * ensemble.count).max(1) as f32
}
