//! A row's sums over directions.

use probelight_math::glam::Vec3;
use probelight_math::sh::{Basis, LANES};

use crate::light::blur_balance::limited;

/// Sums weighted basis values per probe, evaluating [`LANES`] directions at a time.
pub(crate) struct RowAccumulator<'a> {
    basis: &'a Basis,
    /// Probe-major sums.
    sums: Vec<f32>,
    pending: Vec<PendingDirections>,
    values: Vec<[f32; LANES]>,
    /// Probe-major coefficients of what each value is divided by; none for one.
    coverage: &'a [f32],
}

#[derive(Clone, Copy, Default)]
struct PendingDirections {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    weight: [f32; LANES],
    count: usize,
}

impl<'a> RowAccumulator<'a> {
    pub(crate) fn new(basis: &'a Basis, probes: usize, coverage: &'a [f32]) -> Self {
        Self {
            basis,
            sums: vec![0.0; probes * basis.len()],
            pending: vec![PendingDirections::default(); probes],
            values: vec![[0.0; LANES]; basis.len()],
            coverage,
        }
    }

    pub(crate) fn add(&mut self, probe: usize, direction: Vec3, weight: f32) {
        let pending = &mut self.pending[probe];
        let lane = pending.count;
        (pending.x[lane], pending.y[lane], pending.z[lane]) = direction.into();
        pending.weight[lane] = weight;
        pending.count += 1;
        if pending.count == LANES {
            self.flush(probe);
        }
    }

    fn flush(&mut self, probe: usize) {
        let mut pending = std::mem::take(&mut self.pending[probe]);
        self.basis.evaluate_lanes(pending.x, pending.y, pending.z, &mut self.values);
        self.balance(probe, &mut pending.weight);
        let sums = &mut self.sums[probe * self.basis.len()..][..self.basis.len()];
        for (sum, values) in sums.iter_mut().zip(&self.values) {
            let products: [f32; LANES] = std::array::from_fn(|lane| values[lane] * pending.weight[lane]);
            *sum += products.iter().sum::<f32>();
        }
    }

    /// Raises the weights where part of the blur around their directions is on no surface.
    fn balance(&self, probe: usize, weights: &mut [f32; LANES]) {
        let first = probe * self.basis.len();
        let Some(coverage) = self.coverage.get(first..first + self.basis.len()) else { return };
        let mut sums = [0.0; LANES];
        for (coverage, values) in coverage.iter().zip(&self.values) {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += coverage * value);
        }
        weights.iter_mut().zip(sums).for_each(|(weight, sum)| *weight /= limited(sum));
    }

    /// Appends the row in band-major column order.
    pub(crate) fn finish(mut self, row: &mut Vec<f32>) {
        for probe in 0..self.pending.len() {
            self.flush(probe);
        }
        for l in 0..=self.basis.degree() {
            for sums in self.sums.chunks_exact(self.basis.len()) {
                row.extend_from_slice(&sums[l * l..(l + 1) * (l + 1)]);
            }
        }
    }
}
