//! Deterministic sample sequences and the maps from the unit square to directions and triangles.

use std::f32::consts::{PI, TAU};

use glam::{Mat3, Vec2, Vec3};

/// Mixes one 32-bit value into another well enough to seed a sequence (PCG output permutation,
/// O'Neill 2014).
#[inline]
pub fn hash_u32(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Combines two 32-bit values into a hash of both.
#[inline]
pub fn hash_pair(a: u32, b: u32) -> u32 {
    hash_u32(a ^ hash_u32(b).rotate_left(16))
}

/// Maps 32 random bits to `[0, 1)`.
#[inline]
pub fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A small, fast random number generator (PCG-32, O'Neill 2014). The same seed and stream give the
/// same numbers on every platform.
#[derive(Clone, Debug)]
pub struct Rng {
    state: u64,
    increment: u64,
}

impl Rng {
    /// A generator for `seed`, on its own `stream` (for example a pixel or receiver index).
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Self { state: 0, increment: (stream << 1) | 1 };
        rng.next_u32();
        rng.state = rng.state.wrapping_add(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        rng.next_u32();
        rng.next_u32();
        rng
    }

    /// The next 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(self.increment);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// A number in `[0, 1)`.
    #[inline]
    pub fn next_f32(&mut self) -> f32 {
        unit_from_bits(self.next_u32())
    }

    /// A point in the unit square.
    #[inline]
    pub fn next_vec2(&mut self) -> Vec2 {
        Vec2::new(self.next_f32(), self.next_f32())
    }
}

/// Scrambles the bits of a base-2 sequence's sample as Owen's nested uniform scrambling does, by a
/// hash in reversed-bit space (Laine and Karras 2011, constants of Vegdahl 2021).
#[inline]
fn owen_scramble(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// The second dimension of Sobol's sequence.
#[inline]
fn sobol_second_dimension(index: u32) -> u32 {
    let mut direction = 1u32 << 31;
    let mut rest = index;
    let mut bits = 0;
    while rest != 0 {
        if rest & 1 == 1 {
            bits ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    bits
}

/// Sample `index` of an Owen-scrambled Sobol (0,2)-sequence: every power-of-two prefix is stratified in
/// all elementary intervals; different seeds give independent sequences.
#[inline]
pub fn sobol_owen(index: u32, seed: u32) -> Vec2 {
    // Scrambling the index too keeps each aligned block of the sequence together but in random order,
    // which makes sequences with different seeds independent.
    let shuffled = owen_scramble(index, hash_pair(seed, 0));
    let x = owen_scramble(shuffled.reverse_bits(), hash_pair(seed, 1));
    let y = owen_scramble(sobol_second_dimension(shuffled), hash_pair(seed, 2));
    Vec2::new(unit_from_bits(x), unit_from_bits(y))
}

/// An orthonormal frame whose third column is the unit vector `normal` (Duff et al. 2017). Multiplying a
/// local direction (z along the normal) by it gives the world direction.
#[inline]
pub fn world_from_tangent(normal: Vec3) -> Mat3 {
    let sign = 1f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    Mat3::from_cols(
        Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
        normal,
    )
}

/// Maps the unit square to the disk, area preserving and with low distortion (Shirley and Chiu 1997).
#[inline]
pub fn disk_from_square(u: Vec2) -> Vec2 {
    let offset = 2.0 * u - Vec2::ONE;
    if offset == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if offset.x.abs() > offset.y.abs() {
        (offset.x, PI / 4.0 * (offset.y / offset.x))
    } else {
        (offset.y, PI / 2.0 - PI / 4.0 * (offset.x / offset.y))
    };
    radius * Vec2::from_angle(angle)
}

/// Maps the unit square to the hemisphere around +Z with density `cosθ/π`.
#[inline]
pub fn cosine_hemisphere_from_square(u: Vec2) -> Vec3 {
    let disk = disk_from_square(u);
    disk.extend((1.0 - disk.length_squared()).max(0.0).sqrt())
}

/// Maps the unit square to the unit sphere with uniform density.
#[inline]
pub fn sphere_from_square(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    (radius * Vec2::from_angle(TAU * u.y)).extend(z)
}

/// Chooses an entry of a table of running sums, with the probability of its share in the last sum, by `u` in [0, 1).
/// Returns the entry's index and what is left of `u` within it, which is uniform again.
///
/// # Panics
/// If the table is empty.
#[inline]
pub fn choose_by_running_sum(sums: &[f32], u: f32) -> (usize, f32) {
    let last = sums.len() - 1;
    let at = u * sums[last];
    let chosen = sums.partition_point(|sum| *sum <= at).min(last);
    let low = if chosen == 0 { 0.0 } else { sums[chosen - 1] };
    let rest = (at - low) / (sums[chosen] - low).max(f32::MIN_POSITIVE);
    (chosen, rest.clamp(0.0, 1.0))
}

/// Maps the unit square to barycentric coordinates `(v, w)` of the second and third corner of a triangle
/// with uniform density (Heitz 2019).
#[inline]
pub fn triangle_from_square(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let v = u.x * 0.5;
        Vec2::new(v, u.y - v)
    } else {
        let w = u.y * 0.5;
        Vec2::new(u.x - w, w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sobol_prefixes_are_stratified_in_every_elementary_interval() {
        for seed in 0..8 {
            for log_count in [4u32, 6, 8] {
                let points: Vec<Vec2> = (0..1u32 << log_count).map(|i| sobol_owen(i, seed)).collect();
                for log_columns in 0..=log_count {
                    let (columns, rows) = (1 << log_columns, 1 << (log_count - log_columns));
                    let mut seen = vec![false; columns * rows];
                    for p in &points {
                        let cell = (p.x * columns as f32) as usize + columns * (p.y * rows as f32) as usize;
                        assert!(!seen[cell], "two of {} points share a cell", points.len());
                        seen[cell] = true;
                    }
                }
            }
        }
    }

    #[test]
    fn random_points_are_not_stratified() {
        // Negative control of the test above: independent points must fail the same property.
        let mut rng = Rng::new(1, 2);
        let mut seen = [false; 256];
        let collided = (0..256).any(|_| {
            let p = rng.next_vec2();
            std::mem::replace(&mut seen[(p.x * 16.0) as usize + 16 * (p.y * 16.0) as usize], true)
        });
        assert!(collided);
    }

    #[test]
    fn tangent_frames_are_right_handed_and_orthonormal() {
        for i in 0..500 {
            let normal = sphere_from_square(sobol_owen(i, 3));
            let frame = world_from_tangent(normal);
            assert!((frame * frame.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-5));
            assert!((frame.determinant() - 1.0).abs() < 1e-5);
            assert!((frame * Vec3::Z).abs_diff_eq(normal, 1e-6));
        }
        assert!(world_from_tangent(-Vec3::Z).is_finite());
    }

    #[test]
    fn cosine_hemisphere_has_mean_cosine_two_thirds() {
        let count = 4096;
        let mean =
            (0..count).map(|i| cosine_hemisphere_from_square(sobol_owen(i, 9)).z).sum::<f32>() / count as f32;
        assert!((mean - 2.0 / 3.0).abs() < 1e-3, "{mean}");
    }

    #[test]
    fn entries_are_chosen_by_their_share_and_the_rest_is_uniform() {
        // Shares 1/8, 0, 3/8 and 1/2.
        let sums = [0.5, 0.5, 2.0, 4.0];
        let expected = [(0.0, 0, 0.0), (0.0625, 0, 0.5), (0.125, 2, 0.0), (0.3125, 2, 0.5), (0.75, 3, 0.5)];
        for (u, entry, rest) in expected {
            assert_eq!(choose_by_running_sum(&sums, u), (entry, rest), "{u}");
        }
        assert_eq!(choose_by_running_sum(&sums, 1.0), (3, 1.0));
    }

    #[test]
    fn triangle_samples_average_to_the_centroid_and_stay_inside() {
        let count = 4096;
        let mut sum = Vec2::ZERO;
        for i in 0..count {
            let b = triangle_from_square(sobol_owen(i, 5));
            assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0 + 1e-6);
            sum += b;
        }
        assert!((sum / count as f32).abs_diff_eq(Vec2::splat(1.0 / 3.0), 1e-3));
    }
}
