//! Ways of light as doors leave them.

use probelight_asset::packed::EXPONENT_STEPS;
use probelight_asset::{BakedScene, Cluster};

/// The ways that light takes: numbers of a baked scene that doors change.
#[derive(Clone, Copy, Debug)]
pub struct Ways<'a> {
    /// See [`relight_surfels`](probelight_asset::BakedParts::relight_surfels).
    pub relight_surfels: &'a [u32],
    /// See [`relight_gains`](probelight_asset::BakedParts::relight_gains).
    pub relight_gains: &'a [u8],
    /// See [`column_exponents`](probelight_asset::BakedParts::column_exponents).
    pub column_exponents: &'a [u8],
}

impl<'a> From<&'a BakedScene> for Ways<'a> {
    /// All are open.
    fn from(baked: &'a BakedScene) -> Self {
        Self {
            relight_surfels: &baked.relight_surfels,
            relight_gains: &baked.relight_gains,
            column_exponents: &baked.column_exponents,
        }
    }
}

/// What stands in for the ways of a baked scene while doors shut some of them.
#[derive(Clone, Debug)]
pub(crate) struct OpenWays {
    relight_surfels: Vec<u32>,
    relight_gains: Vec<u8>,
    column_exponents: Vec<u8>,
    /// Probes and clusters with numbers of their own, those of the last frame too, in their order.
    pub(crate) probes: Vec<u32>,
    pub(crate) clusters: Vec<u32>,
}

impl OpenWays {
    /// As it was baked.
    pub(super) fn new(baked: &BakedScene) -> Self {
        Self {
            relight_surfels: baked.relight_surfels.clone(),
            relight_gains: baked.relight_gains.clone(),
            column_exponents: baked.column_exponents.clone(),
            probes: Vec::new(),
            clusters: Vec::new(),
        }
    }

    /// The numbers themselves.
    pub(crate) fn ways(&self) -> Ways<'_> {
        Ways {
            relight_surfels: &self.relight_surfels,
            relight_gains: &self.relight_gains,
            column_exponents: &self.column_exponents,
        }
    }

    /// Opens all ways; what was shut stays on the lists.
    pub(super) fn reset(&mut self, baked: &BakedScene) {
        for probe in &self.probes {
            let rays = rays_of(baked, *probe);
            self.relight_surfels[rays.clone()].copy_from_slice(&baked.relight_surfels[rays.clone()]);
            self.relight_gains[rays.clone()].copy_from_slice(&baked.relight_gains[rays]);
        }
        for cluster in &self.clusters {
            let columns = columns_of(baked, &baked.clusters[*cluster as usize]);
            self.column_exponents[columns.clone()].copy_from_slice(&baked.column_exponents[columns]);
        }
    }

    /// Lets a probe's ray see another surfel, whose light counts less.
    pub(super) fn divert(&mut self, baked: &BakedScene, probe: u32, ray: usize, surfel: u32, share: f32) {
        insert(&mut self.probes, probe);
        let at = rays_of(baked, probe).start + ray;
        self.relight_surfels[at] = surfel;
        self.relight_gains[at] = (f32::from(self.relight_gains[at]) * share).round() as u8;
    }

    /// Leaves a share of what a cluster gathers by some of its columns.
    pub(super) fn dim(
        &mut self,
        baked: &BakedScene,
        cluster: u32,
        columns: std::ops::Range<usize>,
        left: f32,
    ) {
        insert(&mut self.clusters, cluster);
        let first = baked.clusters[cluster as usize].column_exponent_offset as usize;
        // The largest exponent takes all but 10⁻⁹.
        let steps =
            (-left.max(f32::MIN_POSITIVE).log2() * f32::from(EXPONENT_STEPS)).round().min(255.0) as u8;
        for exponent in &mut self.column_exponents[first + columns.start..first + columns.end] {
            *exponent = exponent.saturating_add(steps);
        }
    }
}

/// Where a probe's rays lie among all.
pub(crate) fn rays_of(baked: &BakedScene, probe: u32) -> std::ops::Range<usize> {
    let rays = baked.relight_directions.len();
    probe as usize * rays..(probe as usize + 1) * rays
}

/// Where a cluster's columns lie among all.
fn columns_of(baked: &BakedScene, cluster: &Cluster) -> std::ops::Range<usize> {
    let first = cluster.column_exponent_offset as usize;
    first..first + baked.column_count(cluster)
}

/// Into a sorted list without doubles.
fn insert(list: &mut Vec<u32>, number: u32) {
    if let Err(at) = list.binary_search(&number) {
        list.insert(at, number);
    }
}
