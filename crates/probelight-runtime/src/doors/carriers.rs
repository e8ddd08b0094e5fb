//! What brings light to a cluster.

use std::collections::HashMap;
use std::ops::Range;

use probelight_asset::{BakedScene, Cluster, NONE};
use probelight_math::glam::Vec3;
use probelight_trace::Hit;

use super::signal_tables::SignalTables;

/// What brings light to a cluster: the column of a scalar signal, then the probes, last the sky.
pub(super) type Carrier = u32;

/// What carries light to a cluster.
pub(super) struct Carriers<'a> {
    pub(super) baked: &'a BakedScene,
    pub(super) tables: &'a SignalTables,
    pub(super) signals: &'a [u32],
    probes: &'a [u32],
    column_of_signal: HashMap<u32, u32>,
}

impl<'a> Carriers<'a> {
    pub(super) fn of(baked: &'a BakedScene, tables: &'a SignalTables, cluster: &'a Cluster) -> Self {
        let signals =
            &baked.cluster_signals[cluster.first_signal as usize..][..cluster.signal_count as usize];
        let probes = &baked.cluster_probes[cluster.first_probe as usize..][..cluster.probe_count as usize];
        let column_of_signal = signals.iter().copied().zip(0..).collect();
        Self { baked, tables, signals, probes, column_of_signal }
    }

    pub(super) fn count(&self) -> usize {
        self.signals.len() + self.probes.len() + 1
    }

    /// Calls back with each carrier of the light that comes from where a ray ends.
    pub(super) fn of_hit(&self, hit: Option<&Hit>, found: &mut impl FnMut(Carrier)) {
        let Some(hit) = hit else {
            if self.baked.settings.sky_degree.is_some() {
                found(self.count() as u32 - 1);
            } else {
                self.of_probes(NONE, found);
            }
            return;
        };
        let material = self.baked.scene.triangle_material[hit.triangle as usize];
        let (first_emitter, first_sky) = (self.baked.first_emitter_signal(), self.baked.first_sky_signal());
        for (column, signal) in (0..).zip(self.signals) {
            let is_emitter = (first_emitter..first_sky).contains(&(*signal as usize));
            if is_emitter && self.baked.emitters[*signal as usize - first_emitter].material == material {
                found(column);
            }
        }
        let surfel = self.tables.surfel_of_hit(self.baked, hit);
        if surfel == NONE {
            return;
        }
        let patches = std::iter::successors(Some(surfel), |patch| {
            Some(self.tables.parents[*patch as usize]).filter(|parent| *parent != NONE)
        });
        if let Some(column) = patches.into_iter().find_map(|patch| self.column_of_signal.get(&patch)) {
            found(*column);
        }
        self.of_probes(surfel, found);
    }

    fn of_probes(&self, surfel: u32, found: &mut impl FnMut(Carrier)) {
        for (carrier, probe) in (self.signals.len() as u32..).zip(self.probes) {
            if self.tables.seen[*probe as usize].binary_search(&surfel).is_ok() {
                found(carrier);
            }
        }
    }

    /// Where the probe is that a carrier is, if it is one.
    pub(super) fn probe(&self, carrier: Carrier) -> Option<Vec3> {
        let probe = self.probes.get((carrier as usize).checked_sub(self.signals.len())?)?;
        Some(self.baked.probes[*probe as usize].position)
    }

    /// Where the light of a carrier comes from, if that is one place.
    pub(super) fn source(&self, carrier: Carrier) -> Option<Vec3> {
        let patch =
            self.signals.get(carrier as usize).and_then(|signal| self.tables.middles.get(*signal as usize));
        patch.copied().or_else(|| self.probe(carrier))
    }
}

/// The columns of ΣVᵀ that belong to a carrier.
pub(super) fn columns_of(baked: &BakedScene, cluster: &Cluster, carrier: Carrier) -> Vec<Range<usize>> {
    let (carrier, signals, probes) =
        (carrier as usize, cluster.signal_count as usize, cluster.probe_count as usize);
    if carrier < signals {
        return std::iter::once(carrier..carrier + 1).collect();
    }
    let probe = carrier - signals;
    if probe < probes {
        let band = |l: usize| {
            let first = signals + probes * l * l + probe * (2 * l + 1);
            first..first + 2 * l + 1
        };
        return (0..=baked.settings.sh_degree as usize).map(band).collect();
    }
    let numbers = &baked.cluster_signals[cluster.first_signal as usize..][..signals];
    let is_sky = |column: &usize| numbers[*column] as usize >= baked.first_sky_signal();
    (0..signals).filter(is_sky).map(|column| column..column + 1).collect()
}
