//! What of a frame's plan is computed: where the signals changed. First half of stages 2 and 3, where levels of detail let
//! what did not change wait; else everything in the plan is computed.
//!
//! Stage 1 lights only surfels that reflect light of clusters computed in the last frame, and measures how each block of
//! signals changed. From that follow the probes that are relit, then from both the clusters that are computed, and from
//! these the surfels of the next frame. When light has converged, nothing is left to do.

use probelight_asset::{BakedScene, Cluster, NONE};
use probelight_math::glam::Vec3;
use probelight_math::sh::Y00;
use rayon::prelude::*;

use super::ProbeRadiance;
use crate::frame::{
    Admission, BLOCK, ChangeTables, ChangeTerm, PROBES_SHARE, ProbeTurn, Thresholds, URGENCIES, Waiting,
    matrix_bytes, urgency,
};
use crate::{ClusterExtent, FramePlan, LodChanges, LodSettings, ProbeExtent};

/// What waits, and what is computed.
#[derive(Debug)]
pub(crate) struct ChooseWork {
    tables: ChangeTables,
    /// Largest change of each source in the present frame.
    changes: Vec<f32>,
    /// The last scalar signals, those of emitters and the sky, before the present frame.
    last_signals: Vec<Vec3>,
    probes: Vec<Waiting>,
    clusters: Vec<Waiting>,
    /// What of each probe and each cluster was last computed.
    held: FramePlan,
    /// What the present frame computes.
    work: FramePlan,
    /// Whether a cluster's receivers changed in the last frame.
    is_touched: Vec<bool>,
    /// Which blocks of surfels the present frame lights.
    is_dirty: Vec<bool>,
    /// Whether the next frame computes everything, whatever it may cost.
    is_forced: bool,
    /// Number of the present frame.
    frame: u32,
}

impl ChooseWork {
    /// Nothing was computed yet, so the first frame computes everything.
    pub(crate) fn new(baked: &BakedScene) -> Self {
        let tables = ChangeTables::new(baked);
        let nothing = FramePlan::new(baked, |_| ClusterExtent::default(), |_| ProbeExtent::default());
        Self {
            changes: vec![0.0; tables.sources(baked.probes.len())],
            last_signals: vec![Vec3::ZERO; baked.scalar_signals() - baked.first_emitter_signal()],
            probes: vec![Waiting::default(); baked.probes.len()],
            clusters: vec![Waiting::default(); baked.clusters.len()],
            held: nothing.clone(),
            work: nothing,
            is_touched: vec![true; baked.clusters.len()],
            is_dirty: vec![true; baked.surfels.len().div_ceil(BLOCK)],
            is_forced: true,
            frame: 0,
            tables,
        }
    }

    /// What the present frame computes.
    pub(crate) fn work(&self) -> &FramePlan {
        &self.work
    }

    /// What of each cluster is there to be read.
    pub(crate) fn held(&self) -> &[ClusterExtent] {
        self.held.clusters()
    }

    /// Whether the present frame changes a cluster's receivers, or those that they blend with.
    pub(crate) fn touched(&self) -> &[bool] {
        &self.is_touched
    }

    /// Makes the next frame compute all clusters and probes, whatever it may cost.
    pub(crate) fn forget(&mut self) {
        self.held.clusters_mut().fill(ClusterExtent::default());
        self.is_touched.fill(true);
        self.forget_probes();
        self.is_forced = true;
    }

    /// Makes the next frame relight all probes.
    pub(crate) fn forget_probes(&mut self) {
        self.held.probes_mut().fill(ProbeExtent::default());
    }

    /// The blocks of surfels that the present frame lights, and where the blocks' changes are noted: those that shine
    /// differently, and those that reflect what the last frame computed.
    pub(crate) fn begin(&mut self, shines_differently: impl Fn(usize) -> bool) -> (&[bool], &mut [f32]) {
        let Self { tables, is_dirty, is_touched, changes, .. } = self;
        changes.fill(0.0);
        let has_changed = |block: usize| {
            shines_differently(block)
                || tables.reflected.of(block).iter().any(|cluster| is_touched[*cluster as usize])
        };
        is_dirty.iter_mut().enumerate().for_each(|(block, is_dirty)| *is_dirty = has_changed(block));
        (is_dirty, &mut changes[..tables.blocks])
    }

    /// Notes how emitters' signals and those of the sky changed.
    pub(crate) fn note_emitters_and_sky(&mut self, baked: &BakedScene, signals: &[Vec3]) {
        let first = baked.first_emitter_signal();
        for ((number, signal), last) in (first..).zip(&signals[first..]).zip(&mut self.last_signals) {
            let change = &mut self.changes[number / BLOCK];
            *change = change.max((*signal - *last).abs().max_element());
            *last = *signal;
        }
    }

    /// Chooses the probes that are relit.
    pub(crate) fn choose_probes(
        &mut self,
        plan: &FramePlan,
        thresholds: &Thresholds,
        lod: &LodSettings,
        radiance: &ProbeRadiance,
    ) -> &FramePlan {
        self.frame = self.frame.wrapping_add(1);
        let turn = ProbeTurn { frame: self.frame, turns: lod.probe_turns };
        let Self { tables, changes, probes, held, work, .. } = self;
        let changed = changed(&changes[..tables.blocks]);
        let wanted = plan.probes().par_iter().zip(&thresholds.probes);
        let [held, work_probes] = [held.probes_mut(), work.probes_mut()];
        let states = probes.par_iter_mut().zip(held).zip(work_probes);
        states.zip(wanted).enumerate().for_each(|(probe, (((waiting, held), work), (wanted, threshold)))| {
            waiting.change += sum(tables.probe_terms.of(probe), changed);
            waiting.frames += 1;
            waiting.light = mean_radiance(radiance, probe);
            let threshold = PROBES_SHARE * threshold;
            let is_new = held != wanted;
            let urgency = urgency(waiting, is_new, threshold, lod.changes.longest_wait);
            let runs = urgency != NONE && (is_new || turn.is_of(probe as u32));
            *work = if runs { *wanted } else { ProbeExtent::default() };
            if runs {
                (*held, *waiting) = (*wanted, Waiting::default());
            }
        });
        work
    }

    /// Chooses the clusters that are computed, given how the probes' bands changed.
    pub(crate) fn choose_clusters(
        &mut self,
        baked: &BakedScene,
        plan: &FramePlan,
        thresholds: &Thresholds,
        rules: &LodChanges,
        band_changes: &[f32],
    ) -> &FramePlan {
        self.changes[self.tables.blocks..].copy_from_slice(band_changes);
        self.find_urgencies(plan, thresholds, rules);
        let words = |index: usize| (matrix_bytes(&baked.clusters[index], plan.clusters()[index]) / 4) as u32;
        let mut words_of = [0u32; URGENCIES];
        for (index, waiting) in self.clusters.iter().enumerate().filter(|(_, it)| it.urgency != NONE) {
            let of_urgency = &mut words_of[waiting.urgency as usize];
            *of_urgency = of_urgency.saturating_add(words(index));
        }
        let most = rules.most_words(baked, std::mem::take(&mut self.is_forced));
        let admission = Admission::new(&words_of, most);
        let Self { clusters, held, work, .. } = self;
        let states = work.clusters_mut().iter_mut().zip(held.clusters_mut()).zip(clusters);
        for ((index, ((work, held), waiting)), wanted) in (0..).zip(states).zip(plan.clusters()) {
            let runs = waiting.urgency != NONE && admission.admits(waiting.urgency, index, waiting.frames);
            *work = if runs { *wanted } else { ClusterExtent::default() };
            if runs || wanted.receivers == 0 {
                *held = *wanted;
                (waiting.change, waiting.frames) = (0.0, 0);
            }
        }
        self.touch();
        &self.work
    }

    fn find_urgencies(&mut self, plan: &FramePlan, thresholds: &Thresholds, rules: &LodChanges) {
        let Self { tables, changes, clusters, held, .. } = self;
        let changed = changed(changes);
        let wanted = plan.clusters().par_iter().zip(&thresholds.clusters).zip(held.clusters());
        let states = clusters.par_iter_mut().zip(wanted).enumerate();
        states.for_each(|(cluster, (waiting, ((wanted, threshold), held)))| {
            waiting.change += sum(tables.cluster_terms.of(cluster), changed);
            waiting.frames += 1;
            waiting.urgency = if wanted.receivers > 0 {
                urgency(waiting, held != wanted, *threshold, rules.longest_wait)
            } else {
                NONE
            };
        });
    }

    /// Marks the clusters whose receivers the frame changes.
    fn touch(&mut self) {
        let Self { tables, work, is_touched, .. } = self;
        let runs = |cluster: usize| work.clusters()[cluster].receivers > 0;
        for (cluster, is_touched) in is_touched.iter_mut().enumerate() {
            let mut neighbors = tables.neighbors.of(cluster).iter();
            *is_touched = runs(cluster) || neighbors.any(|neighbor| runs(*neighbor as usize));
        }
    }

    /// Number of clusters that wait to be computed, given what of their light may.
    pub(crate) fn pending_clusters(&self, thresholds: &Thresholds) -> usize {
        let clusters = self.clusters.iter().zip(&thresholds.clusters);
        clusters.filter(|(waiting, threshold)| waiting.is_pending(**threshold)).count()
    }

    /// Notes how bright the clusters are that were computed, given all coefficients b.
    pub(crate) fn note_light(&mut self, baked: &BakedScene, coefficients: &[[f32; 3]]) {
        let Self { tables, work, clusters, .. } = self;
        let computed = baked.clusters.iter().zip(work.clusters()).zip(clusters);
        for ((cluster, extent), waiting) in computed.filter(|((_, extent), _)| extent.receivers > 0) {
            waiting.light = light_of(cluster, *extent, coefficients, &tables.row_strengths);
        }
    }
}

/// The changes of sources, if there are any.
fn changed(changes: &[f32]) -> Option<&[f32]> {
    changes.iter().any(|change| *change > 0.0).then_some(changes)
}

/// Change of what reads some sources.
fn sum(terms: &[ChangeTerm], changes: Option<&[f32]>) -> f32 {
    changes.map_or(0.0, |changes| terms.iter().map(|term| term.weight * changes[term.source as usize]).sum())
}

/// Root mean square of a cluster's irradiance, W/m².
fn light_of(cluster: &Cluster, extent: ClusterExtent, b: &[[f32; 3]], row_strengths: &[f32]) -> f32 {
    let first = cluster.row_scale_offset as usize;
    let rows = first..first + extent.rank as usize;
    let square = |(b, strength): (&[f32; 3], &f32)| (Vec3::from(*b) * *strength).length_squared();
    (b[rows.clone()].iter().zip(&row_strengths[rows]).map(square).sum::<f32>() / 3.0).sqrt()
}

/// Mean radiance around a probe, of its brightest channel, W·m⁻²·sr⁻¹.
fn mean_radiance(radiance: &ProbeRadiance, probe: usize) -> f32 {
    let mean = |channel| radiance.coefficients(probe, channel)[0] * Y00;
    [0, 1, 2].map(mean).into_iter().fold(0.0, f32::max)
}
