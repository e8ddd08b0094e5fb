//! Light around a place in free space, as the rows of the grid's vertices have it.

use std::f32::consts::FRAC_1_PI;

use probelight_asset::{GridBasis, GridBasisKind, GridLobe, MAX_GRID_ROWS};
use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use probelight_math::sh::{Y00, band, cosine_lobe};

/// Bands 0 to 2.
const SPHERICAL: GridBasis = GridBasis { kind: GridBasisKind::Sh2, lobe: GridLobe::Angle };

/// Factor of the functions of band 1: √(3 / 4π).
const BAND_1: f32 = 0.488_602_5;

/// Largest cosine of a lamp's half opening angle: a second band cannot tell smaller ones.
pub(crate) const SMALLEST_LAMP: f32 = 0.97;

/// How often what is even and what is the lamp are told apart, each by the other.
pub(crate) const LAMP_PASSES: u32 = 6;

/// Light around a place in free space.
#[derive(Clone, Copy, Debug)]
pub struct GridLight {
    basis: GridBasis,
    rows: [Vec3; MAX_GRID_ROWS],
    beyond: BeyondBands,
}

/// What three bands of spherical harmonics leave out of the irradiance by a lamp in light that is even.
///
/// As for [`GridLight::lamp`], bands 1 and 2 tell the lamp's direction, width and flux. It has a share of its flux in band
/// 4, by which all that is left out is scaled: nothing for a half-space of light, all for a small lamp.
#[derive(Clone, Copy, Debug, Default)]
struct BeyondBands {
    /// Unit vector towards the lamp.
    direction: Vec3,
    /// Its flux times the share, W/m².
    flux: Vec3,
}

impl BeyondBands {
    fn of(rows: &[Vec3; MAX_GRID_ROWS]) -> Self {
        // Integrals of the radiance: as it is, times its direction and, below, the second Legendre polynomial about one.
        let weights = |direction| SPHERICAL.read_weights(direction);
        let all = rows[0] * (4.0 * Y00);
        let linear = [rows[3], rows[1], rows[2]].map(|row| row * (2.0 * BAND_1));
        let direction = Vec3::from(linear.map(luminance)).normalize_or_zero();
        let along = (0..3).map(|axis| linear[axis] * direction[axis]).sum::<Vec3>().max(Vec3::ZERO);
        let second: f32 = rows
            .iter()
            .zip(weights(direction))
            .take(9)
            .skip(4)
            .map(|(row, weight)| luminance(*row) * weight)
            .sum();
        let cosine = (3.2 * second / luminance(along).max(f32::MIN_POSITIVE)).clamp(0.0, SMALLEST_LAMP);
        let flux = (2.0 * along / (1.0 + cosine)).min(all);
        Self { direction, flux: flux * share_of_band_4(cosine) }
    }

    /// Irradiance of a surface that faces along `normal`, W/m².
    fn irradiance(&self, normal: Vec3) -> Vec3 {
        let cosine = self.direction.dot(normal);
        let bands = 0.25 + 0.5 * cosine + (5.0 / 32.0) * (3.0 * cosine * cosine - 1.0);
        self.flux * (cosine.max(0.0) - bands)
    }
}

/// The fourth Legendre coefficient of a round lamp, given the cosine of its half opening angle, over that of a small one.
fn share_of_band_4(cosine: f32) -> f32 {
    let square = cosine * cosine;
    let third = 0.5 * cosine * (5.0 * square - 3.0);
    let fifth = 0.125 * cosine * ((63.0 * square - 70.0) * square + 15.0);
    (third - fifth) / (9.0 * (1.0 - cosine))
}

impl GridLight {
    pub(crate) fn new(basis: GridBasis, rows: [Vec3; MAX_GRID_ROWS]) -> Self {
        let beyond = match basis.kind {
            GridBasisKind::Sh2 => BeyondBands::of(&rows),
            _ => BeyondBands::default(),
        };
        Self { basis, rows, beyond }
    }

    /// Irradiance (W/m²) of a surface that faces along `normal` (unit), never negative.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        (self.read(&self.basis.read_weights(normal)) + self.beyond.irradiance(normal)).max(Vec3::ZERO)
    }

    /// The same as what is stored has it.
    fn linear_irradiance(&self, normal: Vec3) -> Vec3 {
        self.read(&self.basis.read_weights(normal)).max(Vec3::ZERO)
    }

    /// Radiance (W·m⁻²·sr⁻¹) from a unit direction, as coarse as the basis has it, never negative.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let mut weights = self.basis.read_weights(direction);
        match self.basis.kind {
            // What the cosine of irradiance took from each band is given back.
            GridBasisKind::Sh2 => {
                weights.iter_mut().take(9).enumerate().for_each(|(row, w)| *w /= cosine_lobe(band(row)));
            }
            _ => weights.iter_mut().for_each(|weight| *weight *= FRAC_1_PI),
        }
        self.read(&weights).max(Vec3::ZERO)
    }

    /// Where most of the light comes from (\[SED\] figure 4): a unit vector, or zero where no side is brighter than another.
    pub fn light_vector(&self) -> Vec3 {
        let axes = self.basis.light_axes();
        let sum: Vec3 = self.rows.iter().zip(axes).map(|(row, axis)| axis * luminance(*row)).sum();
        sum.normalize_or_zero()
    }

    /// The light that a surface which faces along `normal` (unit) sees, as a lamp in light that is even.
    ///
    /// A lamp of half opening angle α has a share (1 + cos α) / 2 of its flux along its direction, and cos α (1 + cos α) / 2 in
    /// the second Legendre polynomial about it; even light has none of either. What lies behind the surface is left out: it
    /// is taken for even light of its own, of which a hemisphere has none of the second.
    pub fn lamp(&self, normal: Vec3) -> Lamp {
        let along = [Vec3::X, Vec3::Y, Vec3::Z]
            .map(|axis| [self.linear_irradiance(axis), self.linear_irradiance(-axis)]);
        // The sum over six axes weighs all directions nearly alike: ∫ L (|x| + |y| + |z|), exactly in two bands.
        let all: Vec3 = along.iter().flatten().sum::<Vec3>() / 1.5;
        let behind = self.linear_irradiance(-normal);
        // An even hemisphere could be taken for a wide lamp, too: so all of the light is even at first.
        let mut even = (0.5 * all - behind).max(Vec3::ZERO);
        let mut lamp = Lamp { direction: normal, cosine: 0.0, flux: Vec3::ZERO };
        for _ in 0..LAMP_PASSES {
            let component = |axis: usize| along[axis][0] - along[axis][1] + (behind - even) * normal[axis];
            let vector = [0, 1, 2].map(component);
            let direction = Vec3::from(vector.map(luminance)).normalize_or(normal);
            let flux = (0..3).map(|axis| vector[axis] * direction[axis]).sum::<Vec3>().max(Vec3::ZERO);
            let across = self.linear_irradiance(direction) + self.linear_irradiance(-direction) - 0.5 * all;
            let cosine =
                (1.6 * luminance(across) / luminance(flux).max(f32::MIN_POSITIVE)).clamp(0.0, SMALLEST_LAMP);
            lamp = Lamp { direction, cosine, flux: 2.0 * flux / (1.0 + cosine) };
            even = (0.5 * (all - lamp.flux) - behind).max(Vec3::ZERO);
        }
        lamp
    }

    fn read(&self, weights: &[f32; MAX_GRID_ROWS]) -> Vec3 {
        self.rows.iter().zip(weights).map(|(row, weight)| *row * *weight).sum()
    }
}

/// A round light source far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Unit vector towards it; zero without one.
    pub direction: Vec3,
    /// Cosine of its half opening angle.
    pub cosine: f32,
    /// Integral of its radiance, W/m²: irradiance of a surface that faces it, but for its width.
    pub flux: Vec3,
}

impl Lamp {
    /// Irradiance of a surface that faces along `normal` (unit), W/m².
    pub(crate) fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.flux * (0.5 * (1.0 + self.cosine) * normal.dot(self.direction).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use probelight_asset::GridLobe;
    use probelight_math::directions::spherical_fibonacci;

    use super::*;

    /// What a vertex would hold of an environment.
    fn light_of(basis: GridBasis, radiance: impl Fn(Vec3) -> f32) -> GridLight {
        let count = 20_000;
        let mut rows = [Vec3::ZERO; MAX_GRID_ROWS];
        for direction in (0..count).map(|i| spherical_fibonacci(i, count)) {
            let power = radiance(direction) * 4.0 * PI / count as f32;
            for (row, received) in rows.iter_mut().zip(basis.received(direction)) {
                *row += Vec3::splat(power * received);
            }
        }
        GridLight::new(basis, rows)
    }

    fn bases() -> impl Iterator<Item = GridBasis> {
        use GridBasisKind::{Axes6, Axes14, Axes26, Sh2};
        let kinds = [Sh2, Axes6, Axes14, Axes26].into_iter();
        kinds.flat_map(|kind| [GridLobe::Angle, GridLobe::Cosine].map(|lobe| GridBasis { kind, lobe }))
    }

    #[test]
    fn the_light_vector_points_into_the_lit_half_of_space() {
        let side = Vec3::new(0.3, 0.8, -0.5).normalize();
        for basis in bases() {
            let light = light_of(basis, |direction| if direction.dot(side) > 0.0 { 1.0 } else { 0.2 });
            assert!(light.light_vector().dot(side) > 0.99, "{basis:?}: {}", light.light_vector());
            let other = light_of(basis, |direction| if direction.dot(side) > 0.0 { 0.2 } else { 1.0 });
            assert!(other.light_vector().dot(side) < -0.99, "{basis:?}: {}", other.light_vector());
        }
    }

    #[test]
    fn a_lamp_over_a_bright_floor_is_found_again() {
        let (towards, cosine) = (Vec3::new(0.6, 0.8, 0.0), 0.9f32);
        let radiance = |direction: Vec3| {
            let lamp = if direction.dot(towards) > cosine { 5.0 } else { 0.0 };
            lamp + if direction.y > 0.0 { 0.3 } else { 0.7 }
        };
        let lamp = light_of(SPHERICAL, radiance).lamp(Vec3::Y);
        assert!(lamp.direction.dot(towards) > 0.99, "{lamp:?}");
        let flux = 5.0 * 2.0 * PI * (1.0 - cosine);
        assert!((lamp.flux.x / flux - 1.0).abs() < 0.1, "{lamp:?}, not {flux}");
        assert!((lamp.cosine - cosine).abs() < 0.1, "{lamp:?}");
    }

    #[test]
    fn a_lamp_is_read_better_than_three_bands_have_it() {
        let towards = Vec3::new(0.48, 0.64, -0.6);
        let (cosine, linear, whole) = (0.96f32, 0.05, 0.02);
        let count = 20_000;
        let radiance = |direction: Vec3| {
            if direction.dot(towards) > cosine { 30.0 } else { 0.3 + 0.1 * direction.y }
        };
        let light = light_of(SPHERICAL, radiance);
        let mut sums = [0.0f32; 3];
        for normal in (0..200).map(|i| spherical_fibonacci(i, 200)) {
            let lit = |i| {
                let direction = spherical_fibonacci(i, count);
                radiance(direction) * direction.dot(normal).max(0.0) * 4.0 * PI / count as f32
            };
            let truth: f32 = (0..count).map(lit).sum();
            sums[0] += truth.powi(2);
            sums[1] += (light.linear_irradiance(normal).x - truth).powi(2);
            sums[2] += (light.irradiance(normal).x - truth).powi(2);
        }
        let [linear_error, error] = [sums[1], sums[2]].map(|sum| (sum / sums[0]).sqrt());
        assert!(linear_error > linear, "{cosine}: {linear_error}");
        assert!(error < whole, "{cosine}: {error}");
    }

    #[test]
    fn even_light_has_no_lamp() {
        for basis in bases() {
            let light = light_of(basis, |_| 2.0);
            let (lamp, all) = (light.lamp(Vec3::Y), light.irradiance(Vec3::Y).x);
            assert!((all / (2.0 * PI) - 1.0).abs() < 0.02, "{basis:?}: {all}");
            assert!(lamp.flux.x < 0.05 * all, "{basis:?}: {lamp:?}");
            assert!((light.radiance(Vec3::X).x / 2.0 - 1.0).abs() < 0.02, "{basis:?}");
        }
    }
}
