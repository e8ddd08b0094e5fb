//! Real orthonormal spherical harmonics of any degree.
//!
//! Basis function `j = l² + l + m` is `N_lm · P_l^|m|(z) · (cos mφ or sin |m|φ)`, without the
//! Condon–Shortley phase, so that `Y_1` is proportional to `(y, z, x)`. Evaluation uses the recurrence of
//! the normalised associated Legendre polynomials divided by `(1 − z²)^{m/2}` together with the powers of
//! `(x + iy)`: no trigonometry and no pole.

use std::f32::consts::PI;

use glam::Vec3;

/// Number of coefficients of degree `degree`: `(degree + 1)²`.
#[inline]
pub const fn coefficient_count(degree: usize) -> usize {
    (degree + 1) * (degree + 1)
}

/// Index of band `l`, order `m` (−l ≤ m ≤ l): `l² + l + m`.
#[inline]
pub const fn index(l: usize, m: isize) -> usize {
    ((l * l + l) as isize + m) as usize
}

/// The band `l` of coefficient index `j`.
#[inline]
pub const fn band(j: usize) -> usize {
    j.isqrt()
}

/// `Y_0`, the constant basis function: `1/√(4π)`.
pub const Y00: f32 = 0.282_094_79;

/// Recurrence constants of one degree, computed once and used for every evaluation.
#[derive(Clone, Debug)]
pub struct Basis {
    degree: usize,
    /// `P_m^m` without its `(1 − z²)^{m/2}`, times √2 for m > 0; indexed by m.
    diagonal: Vec<f32>,
    /// `(a, b)` of `P_l^m = a (z P_{l−1}^m − b P_{l−2}^m)`; indexed by `l (l+1)/2 + m`.
    recurrence: Vec<(f32, f32)>,
}

/// Directions evaluated together, so that the compiler fills vector registers with them.
pub const LANES: usize = 16;

impl Basis {
    /// Constants for the bands `0 ..= degree`.
    pub fn new(degree: usize) -> Self {
        let mut diagonal = vec![(1.0 / (4.0 * std::f64::consts::PI)).sqrt()];
        for m in 1..=degree {
            diagonal.push(diagonal[m - 1] * ((2 * m + 1) as f64 / (2 * m) as f64).sqrt());
        }
        let mut recurrence = Vec::new();
        for l in 0..=degree {
            for m in 0..=l {
                let (l, m) = (l as f64, m as f64);
                if m < l {
                    let a = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
                    let b = (((l - 1.0).powi(2) - m * m) / (4.0 * (l - 1.0).powi(2) - 1.0)).max(0.0).sqrt();
                    recurrence.push((a as f32, b as f32));
                } else {
                    recurrence.push((0.0, 0.0));
                }
            }
        }
        let diagonal = diagonal
            .iter()
            .enumerate()
            .map(|(m, d)| if m == 0 { *d as f32 } else { (d * 2f64.sqrt()) as f32 })
            .collect();
        Self { degree, diagonal, recurrence }
    }

    /// The highest band.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of basis functions.
    pub fn len(&self) -> usize {
        coefficient_count(self.degree)
    }

    /// Never true: there is always the constant band.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Evaluates all basis functions for the unit vector `direction`; `values` has [`Self::len`] entries.
    pub fn evaluate(&self, direction: Vec3, values: &mut [f32]) {
        self.recur([direction.x], [direction.y], [direction.z], |j, [value]| values[j] = value);
    }

    /// Evaluates all basis functions for [`LANES`] unit vectors at once; `values[j][lane]`.
    pub fn evaluate_lanes(
        &self,
        x: [f32; LANES],
        y: [f32; LANES],
        z: [f32; LANES],
        values: &mut [[f32; LANES]],
    ) {
        self.recur(x, y, z, |j, value| values[j] = value);
    }

    /// Runs the recurrence order by order and hands each finished basis value to `emit`.
    #[inline(always)]
    fn recur<const N: usize>(
        &self,
        x: [f32; N],
        y: [f32; N],
        z: [f32; N],
        mut emit: impl FnMut(usize, [f32; N]),
    ) {
        let (mut cosine, mut sine) = ([1f32; N], [0f32; N]);
        for m in 0..=self.degree {
            let mut previous = [0f32; N];
            let mut current = [self.diagonal[m]; N];
            for l in m..=self.degree {
                if l > m {
                    let (a, b) = self.recurrence[l * (l + 1) / 2 + m];
                    let mut next = [0f32; N];
                    for i in 0..N {
                        next[i] = a * (z[i] * current[i] - b * previous[i]);
                    }
                    (previous, current) = (current, next);
                }
                let mut value = [0f32; N];
                for i in 0..N {
                    value[i] = current[i] * cosine[i];
                }
                emit(index(l, m as isize), value);
                if m > 0 {
                    for i in 0..N {
                        value[i] = current[i] * sine[i];
                    }
                    emit(index(l, -(m as isize)), value);
                }
            }
            for i in 0..N {
                (cosine[i], sine[i]) = (x[i] * cosine[i] - y[i] * sine[i], x[i] * sine[i] + y[i] * cosine[i]);
            }
        }
    }
}

/// Zonal coefficients of the clamped cosine lobe `max(0, cosθ)` per band (Ramamoorthi and Hanrahan 2001):
/// irradiance is `Σ_lm A_l λ_lm Y_lm(n)`.
pub fn cosine_lobe(l: usize) -> f32 {
    match l {
        0 => PI,
        1 => 2.0 * PI / 3.0,
        l if l % 2 == 1 => 0.0,
        l => {
            let half = (l / 2) as f64;
            let sign = if (l / 2) % 2 == 0 { -1.0 } else { 1.0 };
            // l! / (2^l ((l/2)!)²) built as a product, so that it neither overflows nor loses digits.
            let ratio: f64 = (1..=l / 2).map(|k| (half + k as f64) / (4.0 * k as f64)).product();
            let l = l as f64;
            (2.0 * std::f64::consts::PI * sign / ((l + 2.0) * (l - 1.0)) * ratio) as f32
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::spherical_fibonacci;

    #[test]
    fn first_bands_match_their_closed_forms() {
        let d = Vec3::new(0.36, -0.48, 0.8);
        let mut y = [0.0; 9];
        Basis::new(2).evaluate(d, &mut y);
        let c = |k: f32| (k / PI).sqrt();
        let expected = [
            0.5 * c(1.0),
            0.5 * c(3.0) * d.y,
            0.5 * c(3.0) * d.z,
            0.5 * c(3.0) * d.x,
            0.5 * c(15.0) * d.x * d.y,
            0.5 * c(15.0) * d.y * d.z,
            0.25 * c(5.0) * (3.0 * d.z * d.z - 1.0),
            0.5 * c(15.0) * d.x * d.z,
            0.25 * c(15.0) * (d.x * d.x - d.y * d.y),
        ];
        for (j, (a, b)) in y.iter().zip(expected).enumerate() {
            assert!((a - b).abs() < 1e-6, "Y_{j}: {a} instead of {b}");
        }
    }

    #[test]
    fn basis_is_orthonormal_up_to_degree_eleven() {
        let basis = Basis::new(11);
        let count = 60_000;
        let n = basis.len();
        let mut gram = vec![0f64; n * n];
        let mut y = vec![0.0; n];
        for i in 0..count {
            basis.evaluate(spherical_fibonacci(i, count), &mut y);
            for a in 0..n {
                for b in a..n {
                    gram[a * n + b] += f64::from(y[a]) * f64::from(y[b]);
                }
            }
        }
        let weight = 4.0 * std::f64::consts::PI / count as f64;
        for a in 0..n {
            for b in a..n {
                let expected = if a == b { 1.0 } else { 0.0 };
                let got = gram[a * n + b] * weight;
                assert!((got - expected).abs() < 2e-3, "<Y_{a}, Y_{b}> = {got}");
            }
        }
    }

    #[test]
    fn lanes_equal_single_evaluations() {
        let basis = Basis::new(7);
        let directions: Vec<Vec3> = (0..LANES).map(|i| spherical_fibonacci(i, LANES)).collect();
        let mut lanes = vec![[0.0; LANES]; 64];
        let axis = |k: usize| std::array::from_fn(|i| directions[i][k]);
        basis.evaluate_lanes(axis(0), axis(1), axis(2), &mut lanes);
        let mut single = [0.0; 64];
        for (i, d) in directions.iter().enumerate() {
            basis.evaluate(*d, &mut single);
            for j in 0..64 {
                assert_eq!(lanes[j][i], single[j]);
            }
        }
    }

    #[test]
    fn cosine_lobe_convolves_to_the_clamped_cosine() {
        // Irradiance from a unit-radiance disk light filling the upper half space, at tilt 60°, is
        // π (1 + cos 60°) / 2.
        let degree = 40;
        let basis = Basis::new(degree);
        let count = 40_000;
        let mut lambda = vec![0f64; basis.len()];
        let mut y = vec![0.0; basis.len()];
        for i in 0..count {
            let d = spherical_fibonacci(i, count);
            if d.z > 0.0 {
                basis.evaluate(d, &mut y);
                for (sum, y) in lambda.iter_mut().zip(&y) {
                    *sum += f64::from(*y) * 4.0 * std::f64::consts::PI / count as f64;
                }
            }
        }
        let normal = Vec3::new((60f32).to_radians().sin(), 0.0, 0.5);
        basis.evaluate(normal, &mut y);
        let irradiance: f64 =
            (0..basis.len()).map(|j| f64::from(cosine_lobe(band(j)) * y[j]) * lambda[j]).sum();
        assert!((irradiance - std::f64::consts::PI * 0.75).abs() < 2e-3, "{irradiance}");
    }

    #[test]
    fn band_inverts_index() {
        for l in 0..12 {
            for m in -(l as isize)..=l as isize {
                assert_eq!(band(index(l, m)), l);
            }
        }
    }
}
