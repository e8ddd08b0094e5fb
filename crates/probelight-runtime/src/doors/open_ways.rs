//! Ways of light as doors leave them.

use probelight_asset::BakedScene;
use probelight_asset::packed::EXPONENT_STEPS;

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
    /// Probes and clusters that have numbers of their own, or ever had, in their order.
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
            let rays = baked.rays_of(*probe as usize);
            self.relight_surfels[rays.clone()].copy_from_slice(&baked.relight_surfels[rays.clone()]);
            self.relight_gains[rays.clone()].copy_from_slice(&baked.relight_gains[rays]);
        }
        for cluster in &self.clusters {
            let cluster = &baked.clusters[*cluster as usize];
            let first = cluster.column_exponent_offset as usize;
            let columns = first..first + baked.column_count(cluster);
            self.column_exponents[columns.clone()].copy_from_slice(&baked.column_exponents[columns]);
        }
    }

    /// Lets a probe's ray see another surfel, whose light counts less.
    pub(super) fn divert(&mut self, baked: &BakedScene, probe: u32, ray: usize, surfel: u32, share: f32) {
        insert(&mut self.probes, probe);
        let at = baked.rays_of(probe as usize).start + ray;
        self.relight_surfels[at] = surfel;
        self.relight_gains[at] = (f32::from(self.relight_gains[at]) * share).round() as u8;
    }

    /// Leaves a share of what a cluster gathers by some of its columns.
    pub(super) fn dim(&mut self, baked: &BakedScene, cluster: u32, columns: &[usize], left: f32) {
        insert(&mut self.clusters, cluster);
        let first = baked.clusters[cluster as usize].column_exponent_offset as usize;
        // The largest exponent takes all but 10⁻⁹.
        let steps =
            (-left.max(f32::MIN_POSITIVE).log2() * f32::from(EXPONENT_STEPS)).round().min(255.0) as u8;
        for column in columns {
            let exponent = &mut self.column_exponents[first + column];
            *exponent = exponent.saturating_add(steps);
        }
    }
}

/// Into a sorted list without doubles.
fn insert(list: &mut Vec<u32>, number: u32) {
    if let Err(at) = list.binary_search(&number) {
        list.insert(at, number);
    }
}
