//! What a place in free space keeps of the light around it, and how irradiance is read from it.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

use probelight_math::glam::Vec3;
use probelight_math::sh::{Basis, band, cosine_lobe};
use serde::{Deserialize, Serialize};

/// Most rows of any basis.
pub const MAX_GRID_ROWS: usize = 26;

/// What a vertex of the grid stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GridBasis {
    /// Which directions or functions.
    pub kind: GridBasisKind,
    /// How each of the directions weighs light.
    pub lobe: GridLobe,
}

/// The directions or functions of a [`GridBasis`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GridBasisKind {
    /// Irradiance in spherical harmonics of bands 0 to 2 (Ramamoorthi and Hanrahan 2001).
    #[default]
    Sh2,
    /// Light from the six directions of the axes (\[SED\] §4).
    Axes6,
    /// From the axes and the corners of a cube.
    Axes14,
    /// From the axes, the corners and the edges of a cube.
    Axes26,
}

/// How a direction of a [`GridBasis`] weighs light; scaled so that π times the radiance comes of an even environment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GridLobe {
    /// By the angle, \[SED\] eq. 7: w = 1 − θ / (π/2).
    Angle,
    /// By the cosine, as a surface does.
    #[default]
    Cosine,
}

/// How irradiance is read from directions that weigh light by the cosine: of a row with the unit direction d, the share
/// `shares[row] · (a + b t + c t²)` counts, t being the cosine between d and the surface's normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CosineReading {
    /// a, b and c.
    pub polynomial: [f32; 3],
    /// One for each row.
    pub shares: [f32; MAX_GRID_ROWS],
}

/// ∫ (1 − θ / (π/2)) dω over the hemisphere: 2π − 4.
const ANGLE_LOBE: f32 = 2.0 * PI - 4.0;

impl GridBasis {
    /// Numbers per colour.
    pub const fn rows(self) -> usize {
        match self.kind {
            GridBasisKind::Sh2 => 9,
            GridBasisKind::Axes6 => 6,
            GridBasisKind::Axes14 => 14,
            GridBasisKind::Axes26 => 26,
        }
    }

    /// Which group of rows a row belongs to: those of a group are compressed together. Bands of spherical harmonics,
    /// each direction on its own (\[SED\] §4).
    pub const fn part_of(self, row: usize) -> usize {
        match self.kind {
            GridBasisKind::Sh2 => band(row),
            _ => row,
        }
    }

    /// What radiance 1 from a steradian around a unit direction adds to each row.
    pub fn received(self, direction: Vec3) -> [f32; MAX_GRID_ROWS] {
        let mut values = [0.0; MAX_GRID_ROWS];
        if self.kind == GridBasisKind::Sh2 {
            spherical_harmonics(direction, &mut values);
            values.iter_mut().take(9).enumerate().for_each(|(j, value)| *value *= cosine_lobe(band(j)));
            return values;
        }
        for (value, axis) in values.iter_mut().zip(self.axes()) {
            let cosine = axis.dot(direction).clamp(0.0, 1.0);
            *value = match self.lobe {
                GridLobe::Angle => PI / ANGLE_LOBE * (1.0 - cosine.acos() / FRAC_PI_2),
                GridLobe::Cosine => cosine,
            };
        }
        values
    }

    /// How directions that weigh light by the cosine are read; `None` for other bases.
    ///
    /// Six axes are read by `Σ n² S + n D`, S and D being half the sum and half the difference of opposite ones: exact for
    /// any light's odd part. More directions are the points of a quadrature of the sphere (McLaren 1963, Lebedev 1975),
    /// which projects what they hold onto bands 0 to 2: the reproducing kernel of these is 1 + 3 t + 5 P₂(t).
    pub fn cosine_reading(self) -> Option<CosineReading> {
        let (axis, corner, edge) = match (self.kind, self.lobe) {
            (GridBasisKind::Sh2, _) | (_, GridLobe::Angle) => return None,
            (GridBasisKind::Axes6, GridLobe::Cosine) => {
                return Some(CosineReading { polynomial: [0.0, 0.5, 0.5], shares: [1.0; MAX_GRID_ROWS] });
            }
            (GridBasisKind::Axes14, GridLobe::Cosine) => (1.0 / 15.0, 3.0 / 40.0, 0.0),
            (GridBasisKind::Axes26, GridLobe::Cosine) => (1.0 / 21.0, 9.0 / 280.0, 4.0 / 105.0),
        };
        let shares = std::array::from_fn(|row| match row {
            0..6 => axis,
            6..14 => corner,
            _ => edge,
        });
        Some(CosineReading { polynomial: [-1.5, 3.0, 7.5], shares })
    }

    /// How much each row counts for the irradiance of a surface with a unit normal.
    ///
    /// With \[SED\]'s lobe, directions before the surface count by `max(0, n·d)`, those that weigh by the cosine as
    /// [`cosine_reading`](Self::cosine_reading) has it.
    pub fn read_weights(self, normal: Vec3) -> [f32; MAX_GRID_ROWS] {
        let mut values = [0.0; MAX_GRID_ROWS];
        if self.kind == GridBasisKind::Sh2 {
            spherical_harmonics(normal, &mut values);
        } else if let Some(CosineReading { polynomial: [a, b, c], shares }) = self.cosine_reading() {
            for ((value, axis), share) in values.iter_mut().zip(self.axes()).zip(shares) {
                let cosine = axis.dot(normal);
                *value = share * (a + cosine * (b + cosine * c));
            }
        } else {
            let mut sum = 0.0;
            for (value, axis) in values.iter_mut().zip(self.axes()) {
                *value = axis.dot(normal).max(0.0);
                sum += *value;
            }
            values.iter_mut().for_each(|value| *value /= sum);
        }
        values
    }

    /// Of each row, how it adds to the light vector: the directions of axes, those of band 1 of spherical harmonics.
    pub fn light_axes(self) -> [Vec3; MAX_GRID_ROWS] {
        let mut axes = [Vec3::ZERO; MAX_GRID_ROWS];
        match self.kind {
            GridBasisKind::Sh2 => axes[1..4].copy_from_slice(&[Vec3::Y, Vec3::Z, Vec3::X]),
            _ => axes.iter_mut().zip(self.axes()).for_each(|(axis, direction)| *axis = direction),
        }
        axes
    }

    /// Unit directions of the rows, without those of spherical harmonics.
    fn axes(self) -> impl Iterator<Item = Vec3> {
        const AXES: [[i8; 3]; 6] = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
        let corners = (0..8u8).map(|i| [0, 1, 2].map(|axis| 2 * (i >> axis & 1) as i8 - 1));
        let edges = (0..12u8).map(|i| {
            let (axis, signs) = (usize::from(i / 4), i % 4);
            let mut edge = [0; 3];
            edge[(axis + 1) % 3] = 2 * (signs & 1) as i8 - 1;
            edge[(axis + 2) % 3] = (signs & 2) as i8 - 1;
            edge
        });
        let all = AXES.into_iter().chain(corners).chain(edges);
        all.map(|d| Vec3::from(d.map(f32::from)).normalize()).take(self.rows())
    }
}

/// The functions of bands 0 to 2.
fn spherical_harmonics(direction: Vec3, values: &mut [f32; MAX_GRID_ROWS]) {
    static BASIS: LazyLock<Basis> = LazyLock::new(|| Basis::new(2));
    BASIS.evaluate(direction, values);
}

#[cfg(test)]
mod tests {
    use probelight_math::directions::spherical_fibonacci;

    use super::*;

    fn all() -> impl Iterator<Item = GridBasis> {
        use GridBasisKind::*;
        let kinds = [Sh2, Axes6, Axes14, Axes26].into_iter();
        kinds.flat_map(|kind| [GridLobe::Angle, GridLobe::Cosine].map(|lobe| GridBasis { kind, lobe }))
    }

    /// Irradiance that a basis gives for a normal, under some radiance.
    fn irradiance(basis: GridBasis, normal: Vec3, radiance: impl Fn(Vec3) -> f32) -> f32 {
        let count = 20_000;
        let mut rows = [0.0; MAX_GRID_ROWS];
        for i in 0..count {
            let direction = spherical_fibonacci(i, count);
            let weight = 4.0 * PI / count as f32 * radiance(direction);
            rows.iter_mut().zip(basis.received(direction)).for_each(|(row, value)| *row += weight * value);
        }
        rows.iter().zip(basis.read_weights(normal)).map(|(row, weight)| row * weight).sum()
    }

    #[test]
    fn an_even_environment_gives_pi_times_its_radiance() {
        for basis in all() {
            for i in 0..20 {
                let found = irradiance(basis, spherical_fibonacci(i, 20), |_| 2.0);
                assert!((found / (2.0 * PI) - 1.0).abs() < 2e-3, "{basis:?}: {found}");
            }
        }
    }

    #[test]
    fn light_from_one_side_is_brightest_there_and_finer_bases_come_nearer() {
        // A hemisphere of radiance 1 seen by a tilted surface: π (1 + cosθ) / 2.
        let error = |basis: GridBasis| -> f32 {
            let squared = |i| {
                let normal = spherical_fibonacci(i, 40);
                let exact = PI * 0.5 * (1.0 + normal.dot(Vec3::Y));
                (irradiance(basis, normal, |d| f32::from(d.y > 0.0)) - exact).powi(2)
            };
            ((0..40).map(squared).sum::<f32>() / 40.0).sqrt() / (0.5 * PI)
        };
        let of = |kind, lobe| error(GridBasis { kind, lobe });
        // Exact in its bands: half a sphere has nothing even but band 0.
        assert!(of(GridBasisKind::Sh2, GridLobe::Cosine) < 2e-3);
        assert!(of(GridBasisKind::Axes6, GridLobe::Cosine) < 2e-3);
        let paper = of(GridBasisKind::Axes6, GridLobe::Angle);
        assert!(paper > 0.05 && paper < 0.3, "{paper}");
        assert!(of(GridBasisKind::Axes26, GridLobe::Cosine) < 2e-3);
        assert!(of(GridBasisKind::Axes26, GridLobe::Angle) > 0.05);
    }

    #[test]
    fn more_directions_read_a_lamp_better() {
        let towards = Vec3::new(0.48, 0.64, -0.6);
        let lamp = |direction: Vec3| f32::from(direction.dot(towards) > 0.9);
        let exact = |normal: Vec3| -> f32 {
            let lit = |i| {
                let direction = spherical_fibonacci(i, 20_000);
                lamp(direction) * direction.dot(normal).max(0.0)
            };
            (0..20_000).map(lit).sum::<f32>() * 4.0 * PI / 20_000.0
        };
        let error = |kind| -> f32 {
            let basis = GridBasis { kind, lobe: GridLobe::Cosine };
            let normals = (0..40).map(|i| spherical_fibonacci(i, 40));
            normals
                .map(|normal| (irradiance(basis, normal, lamp) - exact(normal)).powi(2))
                .sum::<f32>()
                .sqrt()
        };
        let [six, fourteen, many, harmonics] =
            [GridBasisKind::Axes6, GridBasisKind::Axes14, GridBasisKind::Axes26, GridBasisKind::Sh2]
                .map(error);
        assert!(fourteen < 0.9 * six && many < fourteen, "{six}, {fourteen}, {many}");
        assert!((many / harmonics - 1.0).abs() < 0.1, "as the bands have it: {many}, {harmonics}");
    }

    #[test]
    fn spherical_harmonics_are_those_of_the_probes() {
        let basis = Basis::new(2);
        for i in 0..30 {
            let direction = spherical_fibonacci(i, 30);
            let mut expected = [0.0; 9];
            basis.evaluate(direction, &mut expected);
            let found = GridBasis::default().read_weights(direction);
            assert!((0..9).all(|j| (expected[j] - found[j]).abs() < 1e-6));
        }
    }

    #[test]
    fn rows_of_a_part_lie_together() {
        for basis in all() {
            let parts: Vec<usize> = (0..basis.rows()).map(|row| basis.part_of(row)).collect();
            assert!(parts.is_sorted(), "{basis:?}");
        }
    }
}
