//! What brings light to a cluster.

use std::collections::HashMap;

use probelight_asset::{BakedScene, Cluster, NONE};
use probelight_math::glam::Vec3;
use probelight_trace::Hit;

use super::signal_tables::SignalTables;

/// What brings light to a cluster: the column of a scalar signal, then the probes, last the sky.
pub(super) type Carrier = u32;

/// All that brings light to a cluster.
pub(super) struct Carriers<'a> {
    baked: &'a BakedScene,
    signals: &'a [u32],
    probes: &'a [u32],
}

impl<'a> Carriers<'a> {
    pub(super) fn of(baked: &'a BakedScene, cluster: &Cluster) -> Self {
        Self { baked, signals: baked.signals_of(cluster), probes: baked.probes_of(cluster) }
    }

    pub(super) fn count(&self) -> usize {
        self.signals.len() + self.probes.len() + 1
    }

    /// The number of the scalar signal that a carrier is, if it is one.
    pub(super) fn signal(&self, carrier: Carrier) -> Option<u32> {
        self.signals.get(carrier as usize).copied()
    }

    /// Where the probe is that a carrier is, if it is one.
    pub(super) fn probe(&self, carrier: Carrier) -> Option<Vec3> {
        let probe = self.probes.get((carrier as usize).checked_sub(self.signals.len())?)?;
        Some(self.baked.probes[*probe as usize].position)
    }

    /// The columns of ΣVᵀ that belong to a carrier, in the order of [`Cluster`].
    pub(super) fn columns(&self, carrier: Carrier) -> Vec<usize> {
        let (carrier, signals, probes) = (carrier as usize, self.signals.len(), self.probes.len());
        if carrier < signals {
            return vec![carrier];
        }
        let probe = carrier - signals;
        if probe < probes {
            let band = |l: usize| {
                let first = signals + probes * l * l + probe * (2 * l + 1);
                first..first + 2 * l + 1
            };
            return (0..=self.baked.settings.sh_degree as usize).flat_map(band).collect();
        }
        let is_sky = |column: &usize| self.signals[*column] as usize >= self.baked.first_sky_signal();
        (0..signals).filter(is_sky).collect()
    }
}

/// Finds a cluster's carriers of light by where it comes from.
pub(super) struct CarrierSearch<'a> {
    pub(super) carriers: Carriers<'a>,
    tables: &'a SignalTables,
    column_of_signal: HashMap<u32, u32>,
}

impl<'a> CarrierSearch<'a> {
    pub(super) fn new(baked: &'a BakedScene, tables: &'a SignalTables, cluster: &Cluster) -> Self {
        let carriers = Carriers::of(baked, cluster);
        let column_of_signal = carriers.signals.iter().copied().zip(0..).collect();
        Self { carriers, tables, column_of_signal }
    }

    /// Calls back with each carrier of the light that comes from where a ray ends.
    pub(super) fn of_hit(&self, hit: Option<&Hit>, found: &mut impl FnMut(Carrier)) {
        let Some(hit) = hit else {
            if self.carriers.baked.settings.sky_degree.is_some() {
                found(self.carriers.count() as u32 - 1);
            } else {
                self.of_probes(NONE, found);
            }
            return;
        };
        let material = self.carriers.baked.scene.triangle_material[hit.triangle as usize];
        let (first_emitter, first_sky) =
            (self.carriers.baked.first_emitter_signal(), self.carriers.baked.first_sky_signal());
        for (column, signal) in (0..).zip(self.carriers.signals) {
            let is_emitter = (first_emitter..first_sky).contains(&(*signal as usize));
            if is_emitter
                && self.carriers.baked.emitters[*signal as usize - first_emitter].material == material
            {
                found(column);
            }
        }
        let surfel = self.tables.surfel_of_hit(self.carriers.baked, hit);
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
        for (carrier, probe) in (self.carriers.signals.len() as u32..).zip(self.carriers.probes) {
            if self.tables.seen[*probe as usize].binary_search(&surfel).is_ok() {
                found(carrier);
            }
        }
    }

    /// Where the light of a carrier comes from, if that is one place.
    pub(super) fn source(&self, carrier: Carrier) -> Option<Vec3> {
        let middle = |signal| self.tables.middles.get(signal as usize).copied();
        self.carriers.signal(carrier).and_then(middle).or_else(|| self.carriers.probe(carrier))
    }

    /// Middles of the patch that a carrier is, or of its parts; none if it is something else.
    pub(super) fn parts(&self, carrier: Carrier) -> Vec<Vec3> {
        let parts = |signal| self.tables.parts(self.carriers.baked, signal);
        self.carriers.signal(carrier).map_or_else(Vec::new, parts)
    }
}
