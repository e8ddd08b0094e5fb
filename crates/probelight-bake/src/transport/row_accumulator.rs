//! Sums over directions: the rows of a place.

use probelight_math::glam::Vec3;
use probelight_math::sh::{Basis, LANES};

use crate::light::blur_balance::limited;

/// Sums weighted basis values per probe, evaluating [`LANES`] directions at a time.
pub(crate) struct RowAccumulator<'a> {
    basis: &'a Basis,
    /// Sums of each row, probe by probe.
    sums: Vec<f32>,
    rows: usize,
    pending: Vec<PendingDirections>,
    values: Vec<[f32; LANES]>,
    /// Probe-major coefficients of what each value is divided by; none for one.
    coverage: &'a [f32],
}

#[derive(Clone)]
struct PendingDirections {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    weight: [f32; LANES],
    /// What each row takes of them.
    factors: Vec<[f32; LANES]>,
    count: usize,
}

impl<'a> RowAccumulator<'a> {
    pub(crate) fn new(basis: &'a Basis, probes: usize, rows: usize, coverage: &'a [f32]) -> Self {
        let none = PendingDirections {
            x: [0.0; LANES],
            y: [0.0; LANES],
            z: [0.0; LANES],
            weight: [0.0; LANES],
            factors: vec![[0.0; LANES]; rows],
            count: 0,
        };
        Self {
            basis,
            sums: vec![0.0; rows * probes * basis.len()],
            rows,
            pending: vec![none; probes],
            values: vec![[0.0; LANES]; basis.len()],
            coverage,
        }
    }

    /// Adds a direction, of which each row takes its factor.
    pub(crate) fn add(&mut self, probe: usize, direction: Vec3, weight: f32, factors: &[f32]) {
        let pending = &mut self.pending[probe];
        let lane = pending.count;
        (pending.x[lane], pending.y[lane], pending.z[lane]) = direction.into();
        pending.weight[lane] = weight;
        pending.factors.iter_mut().zip(factors).for_each(|(lanes, factor)| lanes[lane] = *factor);
        pending.count += 1;
        if pending.count == LANES {
            self.flush(probe);
        }
    }

    fn flush(&mut self, probe: usize) {
        let PendingDirections { x, y, z, mut weight, .. } = self.pending[probe];
        self.basis.evaluate_lanes(x, y, z, &mut self.values);
        self.balance(probe, &mut weight);
        let pending = &mut self.pending[probe];
        let length = self.sums.len() / self.rows;
        let rows = self.sums.chunks_exact_mut(length);
        for (row, factors) in rows.zip(&pending.factors) {
            let weights: [f32; LANES] = std::array::from_fn(|lane| weight[lane] * factors[lane]);
            let sums = &mut row[probe * self.basis.len()..][..self.basis.len()];
            for (sum, values) in sums.iter_mut().zip(&self.values) {
                let products: [f32; LANES] = std::array::from_fn(|lane| values[lane] * weights[lane]);
                *sum += products.iter().sum::<f32>();
            }
        }
        pending.weight = [0.0; LANES];
        pending.count = 0;
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

    /// The sums of all directions.
    pub(crate) fn finish(mut self) -> FinishedRows<'a> {
        for probe in 0..self.pending.len() {
            self.flush(probe);
        }
        FinishedRows { basis: self.basis, sums: self.sums, rows: self.rows }
    }
}

/// A row of values that are stored row by row.
pub(crate) fn nth_row(values: &[f32], row: usize, rows: usize) -> &[f32] {
    let length = values.len() / rows;
    &values[row * length..][..length]
}

/// What a [`RowAccumulator`] came to.
pub(crate) struct FinishedRows<'a> {
    basis: &'a Basis,
    sums: Vec<f32>,
    rows: usize,
}

impl FinishedRows<'_> {
    /// Appends a row in band-major column order.
    pub(crate) fn append(&self, row: usize, columns: &mut Vec<f32>) {
        let sums_of_row = nth_row(&self.sums, row, self.rows);
        for l in 0..=self.basis.degree() {
            for sums in sums_of_row.chunks_exact(self.basis.len()) {
                columns.extend_from_slice(&sums[l * l..(l + 1) * (l + 1)]);
            }
        }
    }
}
