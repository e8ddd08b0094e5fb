//! Direction sets whose every prefix is well distributed, and the quadrature weights of those prefixes.
//!
//! All probes share one set, so that one table of basis values serves them all and a lower level of
//! detail is a shorter prefix of the same rays.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::sh::{Basis, Y00, coefficient_count};

/// Point `i` of `count` on the spherical Fibonacci lattice (Keinert et al. 2015).
#[inline]
pub fn spherical_fibonacci(i: usize, count: usize) -> Vec3 {
    // f64: the golden-ratio multiple of a large index has no fractional bits left in f32.
    let golden_fraction = (i as f64 * 0.618_033_988_749_894_8).fract() as f32;
    let z = 1.0 - (2 * i + 1) as f32 / count as f32;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    (radius * Vec2::from_angle(TAU * golden_fraction)).extend(z)
}

/// `count` directions covering the sphere evenly, ordered so that every prefix does too.
///
/// The complete set is a spherical Fibonacci lattice. Its order is greedy: each next point is the one
/// with the least Coulomb energy `Σ 1/d` towards those already taken.
pub fn progressive_sphere(count: usize) -> Vec<Vec3> {
    let mut pool: Vec<Vec3> = (0..count).map(|i| spherical_fibonacci(i, count)).collect();
    let mut energy = vec![0f32; count];
    let mut ordered = Vec::with_capacity(count);
    while !pool.is_empty() {
        let mut best = 0;
        for candidate in 1..pool.len() {
            if energy[candidate] < energy[best] {
                best = candidate;
            }
        }
        let taken = pool.swap_remove(best);
        energy.swap_remove(best);
        for (direction, energy) in pool.iter().zip(&mut energy) {
            *energy += 1.0 / (*direction - taken).length();
        }
        ordered.push(taken);
    }
    ordered
}

/// Quadrature weights for `directions` (steradians; they sum to 4π): those nearest to the uniform `4π/N`
/// that integrate the bands `0 ..= exact_degree` exactly.
///
/// With `exact_degree` = 2·n the projection to degree n of radiance that is itself of degree n is exact.
/// The degree is lowered until the constraints are at most half as many as the directions, which keeps
/// the weights positive on well-distributed sets.
pub fn quadrature_weights(directions: &[Vec3], exact_degree: usize) -> Vec<f32> {
    let count = directions.len();
    let mut degree = exact_degree;
    while degree > 0 && 2 * coefficient_count(degree) > count {
        degree -= 1;
    }
    let basis = Basis::new(degree);
    let constraints = basis.len();
    let mut table = vec![0f32; count * constraints];
    for (direction, row) in directions.iter().zip(table.chunks_exact_mut(constraints)) {
        basis.evaluate(*direction, row);
    }
    let table: Vec<f64> = table.into_iter().map(f64::from).collect();

    let uniform = f64::from(4.0 * PI) / count as f64;
    // Minimum-norm correction c of the uniform weights: Yᵀ(u + c) = t, c = Y (YᵀY)⁻¹ (t − Yᵀu).
    let mut gram = vec![0f64; constraints * constraints];
    let mut residual = vec![0f64; constraints];
    residual[0] = 1.0 / f64::from(Y00);
    for row in table.chunks_exact(constraints) {
        for a in 0..constraints {
            residual[a] -= uniform * row[a];
            for b in 0..=a {
                gram[a * constraints + b] += row[a] * row[b];
            }
        }
    }
    let solution = solve_positive_definite(&mut gram, residual);
    table
        .chunks_exact(constraints)
        .map(|row| {
            let correction: f64 = row.iter().zip(&solution).map(|(y, s)| y * s).sum();
            (uniform + correction) as f32
        })
        .collect()
}

/// The table that projects radiance along `directions` to spherical-harmonics coefficients up to `degree`: basis
/// values times quadrature weight, all of the first direction, all of the second, …
///
/// The sum over directions of radiance times such a row is exact for radiance of that degree, where there are
/// directions enough ([`quadrature_weights`]).
pub fn weighted_basis(directions: &[Vec3], degree: usize) -> Vec<f32> {
    basis_table(directions, &quadrature_weights(directions, 2 * degree), degree)
}

/// Basis values up to `degree` times a weight for each direction: all of the first direction, all of the second, …
pub fn basis_table(directions: &[Vec3], weights: &[f32], degree: usize) -> Vec<f32> {
    let basis = Basis::new(degree);
    let mut table = vec![0.0; directions.len() * basis.len()];
    let rows = table.chunks_exact_mut(basis.len());
    for ((direction, weight), row) in directions.iter().zip(weights).zip(rows) {
        basis.evaluate(*direction, row);
        row.iter_mut().for_each(|value| *value *= weight);
    }
    table
}

/// Solves `A x = b` by Cholesky factorisation; the lower triangle of `a` (row-major) is overwritten.
fn solve_positive_definite(a: &mut [f64], mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let value = a[i * n + j] - dot;
            a[i * n + j] = if i == j { value.max(f64::MIN_POSITIVE).sqrt() } else { value / a[j * n + j] };
        }
    }
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| a[i * n + k] * b[k]).sum();
        b[i] = (b[i] - dot) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| a[k * n + i] * b[k]).sum();
        b[i] = (b[i] - dot) / a[i * n + i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Rng, sphere_from_square};

    /// Largest error of integrating any basis function up to `degree` with uniform weights.
    fn worst_quadrature_error(directions: &[Vec3], degree: usize) -> f32 {
        let basis = Basis::new(degree);
        let mut y = vec![0.0; basis.len()];
        let mut sums = vec![0f32; basis.len()];
        for d in directions {
            basis.evaluate(*d, &mut y);
            for (sum, y) in sums.iter_mut().zip(&y) {
                *sum += y * 4.0 * PI / directions.len() as f32;
            }
        }
        sums.iter().skip(1).fold(0f32, |worst, s| worst.max(s.abs()))
    }

    #[test]
    fn every_prefix_beats_random_points_by_far() {
        let directions = progressive_sphere(512);
        for prefix in [32, 64, 100, 128, 256, 512] {
            let ours = worst_quadrature_error(&directions[..prefix], 3);
            let mut rng = Rng::new(7, prefix as u64);
            let random: Vec<Vec3> = (0..prefix).map(|_| sphere_from_square(rng.next_vec2())).collect();
            let theirs = worst_quadrature_error(&random, 3);
            assert!(3.0 * ours < theirs, "prefix {prefix}: {ours} against {theirs}");
        }
    }

    #[test]
    fn progressive_set_is_the_whole_lattice() {
        let mut ordered: Vec<_> =
            progressive_sphere(97).iter().map(|d| d.to_array().map(f32::to_bits)).collect();
        let mut lattice: Vec<_> =
            (0..97).map(|i| spherical_fibonacci(i, 97).to_array().map(f32::to_bits)).collect();
        ordered.sort_unstable();
        lattice.sort_unstable();
        assert_eq!(ordered, lattice);
    }

    #[test]
    fn weights_integrate_their_bands_exactly_and_are_positive() {
        let directions = progressive_sphere(512);
        for (prefix, degree) in [(512, 14), (256, 10), (64, 4)] {
            let prefix = &directions[..prefix];
            let weights = quadrature_weights(prefix, degree);
            assert!(weights.iter().all(|w| *w > 0.0));
            let basis = Basis::new(degree);
            let mut y = vec![0.0; basis.len()];
            let mut sums = vec![0f64; basis.len()];
            for (d, w) in prefix.iter().zip(&weights) {
                basis.evaluate(*d, &mut y);
                for (sum, y) in sums.iter_mut().zip(&y) {
                    *sum += f64::from(*w) * f64::from(*y);
                }
            }
            assert!((sums[0] - 1.0 / f64::from(Y00)).abs() < 1e-5);
            for (j, sum) in sums.iter().enumerate().skip(1) {
                assert!(sum.abs() < 1e-5, "{} directions, Y_{j}: {sum}", prefix.len());
            }
        }
    }

    #[test]
    fn linear_radiance_projects_to_its_closed_form() {
        let directions = progressive_sphere(512);
        let mut coefficients = vec![0.0; coefficient_count(7)];
        let table = weighted_basis(&directions, 7);
        for (direction, row) in directions.iter().zip(table.chunks_exact(coefficients.len())) {
            let radiance = 1.0 + direction.x - 2.0 * direction.z;
            coefficients.iter_mut().zip(row).for_each(|(sum, y)| *sum += radiance * y);
        }
        // Y_0 = √(1/4π), and Y_1 = √(3/4π) (y, z, x), whose squares integrate to 1.
        let (constant, linear) = ((4.0 * PI).sqrt(), (4.0 * PI / 3.0).sqrt());
        let expected = [constant, 0.0, -2.0 * linear, linear];
        for (j, value) in coefficients.into_iter().enumerate() {
            let expected = expected.get(j).copied().unwrap_or(0.0);
            assert!((value - expected).abs() < 1e-4, "coefficient {j}: {value}, not {expected}");
        }
    }
}
