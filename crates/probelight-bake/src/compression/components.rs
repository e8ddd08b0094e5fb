//! Principal components in a metric, and what truncation loses of the light.

use faer::{Mat, Scale, Side};

use crate::compression::factors::RowEnergy;
use crate::compression::metric::SignalMetric;

/// The principal components of a matrix in a metric.
pub(crate) struct Components {
    /// Orthonormal columns: the leading eigenvectors of `A M Aᵀ`.
    pub(crate) u: Mat<f32>,
    /// Their eigenvalues, descending.
    pub(crate) energies: Vec<f64>,
    /// Energy that is lost if only the first k are kept, for every k.
    pub(crate) tails: Vec<f64>,
    /// Energy of each of its rows.
    pub(crate) rows: Vec<RowEnergy>,
}

impl Components {
    /// Decomposes A. Where the metric knows the light, the noise of the gather rays does not count as lost
    /// energy. A matrix that does not decompose (it holds no finite numbers) has no components.
    pub(crate) fn of(a: &Mat<f32>, halves: &[Mat<f32>; 2], metric: &SignalMetric, most: usize) -> Self {
        let gram = metric.gram(a);
        let total: f64 = (0..gram.nrows()).map(|r| gram[(r, r)]).sum();
        let Some((u, energies)) = leading_eigenvectors(&gram, most) else {
            return Self {
                u: Mat::zeros(a.nrows(), 0),
                energies: Vec::new(),
                tails: vec![0.0],
                rows: vec![RowEnergy::default(); a.nrows()],
            };
        };
        let (noise, noise_free) = if metric.knows_the_light() {
            let noise = noise_of_rows(halves, metric);
            let tails = noise_free_tails(halves, metric, &noise, energies.len());
            (noise, tails)
        } else {
            (vec![0.0; a.nrows()], None)
        };
        let mut tails = tails_of(total, energies.iter().copied());
        // Components of one half of the rays never find all light of the other. What all rays lose, noise
        // included, is a limit to that.
        for (tail, noise_free) in tails.iter_mut().zip(noise_free.iter().flatten()) {
            *tail = tail.min(*noise_free);
        }
        // The mean of both halves has half of their noise.
        let row = |(r, noise): (usize, &f64)| {
            let all = gram[(r, r)];
            RowEnergy { all, noise: 0.5 * noise, counted: all }
        };
        let rows = noise.iter().enumerate().map(row).collect();
        let u = Mat::from_fn(u.nrows(), u.ncols(), |r, k| u[(r, k)] as f32);
        Self { u, energies, tails, rows }
    }
}

/// Eigenvectors of the largest eigenvalues as columns, and these, descending.
fn leading_eigenvectors(gram: &Mat<f64>, most: usize) -> Option<(Mat<f64>, Vec<f64>)> {
    let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
    // Ascending, as faer has them.
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let last = gram.nrows() - 1;
    let total: f64 = values.iter().sum();
    // Below this the Gram matrix holds rounding errors.
    let kept = (0..most).take_while(|k| values[last - k] > 1e-12 * total).count();
    let u = Mat::from_fn(gram.nrows(), kept, |r, k| vectors[(r, last - k)]);
    Some((u, (0..kept).map(|k| values[last - k]).collect()))
}

/// What is left of an energy after taking the first k shares, for every k.
fn tails_of(total: f64, shares: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut tails = vec![total];
    tails.extend(shares.scan(total, |rest, share| {
        *rest -= share;
        Some(*rest)
    }));
    tails
}

/// The energy of the light that the first k components lose, without the noise of the gather rays.
///
/// Components found in one half of the rays are tried on the other. What they miss there is light that is lost
/// and noise; how much noise there is, the difference of the halves tells.
fn noise_free_tails(
    halves: &[Mat<f32>; 2],
    metric: &SignalMetric,
    noise: &[f64],
    count: usize,
) -> Option<Vec<f64>> {
    let [found, tested] = halves.each_ref().map(|half| metric.gram(half));
    let mut tails = tails_on_other_half(&leading_eigenvectors(&found, count)?.0, &tested, noise);
    tails.resize(count + 1, tails.last().copied().unwrap_or(0.0));
    Some(tails.into_iter().map(|tail| tail.max(0.0)).collect())
}

/// Energy of the noise that each row of a half has.
fn noise_of_rows(halves: &[Mat<f32>; 2], metric: &SignalMetric) -> Vec<f64> {
    metric.row_energies(&((&halves[0] - &halves[1]) * Scale(0.5f32.sqrt())))
}

/// Energy that the first k of some components `u` lose of a half of the rays, less the rows' noise, for every k. No row
/// has more noise than energy, though its other half may say so: light that a few rays found in one half only would
/// else outweigh that of all other rows.
fn tails_on_other_half(u: &Mat<f64>, tested: &Mat<f64>, noise: &[f64]) -> Vec<f64> {
    let receivers = tested.nrows();
    let noise = |r: usize| noise[r].min(tested[(r, r)]);
    let rotated = tested * u;
    let share = |k: usize| -> f64 {
        (0..receivers).map(|r| u[(r, k)] * rotated[(r, k)] - u[(r, k)] * u[(r, k)] * noise(r)).sum()
    };
    let total: f64 = (0..receivers).map(|r| tested[(r, r)] - noise(r)).sum();
    tails_of(total, (0..u.ncols()).map(share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compression::tests::{COLUMNS, low_rank_rows};
    use probelight_math::sampling::Rng;

    #[test]
    fn noise_between_the_halves_is_not_counted_as_lost_light() {
        let (count, columns) = (64, 64);
        let mut rng = Rng::new(8, 9);
        let mut noisy =
            || Mat::from_fn(count, columns, |r, c| 1.0 + (r * c) as f32 / 500.0 + 0.2 * rng.next_f32());
        let halves = [noisy(), noisy()];
        let metric = SignalMetric::independent(vec![1.0; columns]);
        let tails = noise_free_tails(&halves, &metric, &noise_of_rows(&halves, &metric), 8).unwrap();
        let a = (&halves[0] + &halves[1]) * Scale(0.5);
        let counted = Components::of(&a, &halves, &metric, 8).tails;
        // Two components hold all but the noise, of which their own estimate has 2 / 64 in each half.
        assert!(tails[2] < 0.1 * counted[2], "{} of {}", tails[2], counted[2]);
        // Light that is in both halves counts in full.
        assert!((tails[0] / counted[0] - 1.0).abs() < 0.01 && tails[1] > 2.0 * tails[2]);
    }

    #[test]
    fn light_counts_though_a_bright_row_is_in_one_half_only() {
        // As where a few rays of one half find a small bright patch that those of the other miss.
        let rows = low_rank_rows(64, 12);
        let even = Mat::from_fn(64, COLUMNS, |r, c| rows[r * COLUMNS + c]);
        let uneven = Mat::from_fn(64, COLUMNS, |r, c| if r == 5 { 40.0 } else { even[(r, c)] });
        let metric = SignalMetric::independent(vec![1.0; COLUMNS]);
        for halves in [[uneven.clone(), even.clone()], [even.clone(), uneven]] {
            let tails = noise_free_tails(&halves, &metric, &noise_of_rows(&halves, &metric), 8).unwrap();
            let light: f64 = metric.row_energies(&even).iter().sum();
            assert!(tails[0] > 0.9 * light, "{} of {light}: the cluster would be black", tails[0]);
        }
    }
}
