//! Irradiance in free space, between the vertices of the grid (\[SED\] §4).

use std::f32::consts::FRAC_1_PI;

use probelight_asset::{BakedScene, GridBasis, GridBasisKind, MAX_GRID_ROWS};
use probelight_math::color::luminance;
use probelight_math::glam::{IVec3, UVec3, Vec3};
use probelight_math::sh::{band, cosine_lobe};

use crate::GridPlaces;

/// The grid of a baked scene with the light of a frame.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceGrid<'a> {
    baked: &'a BakedScene,
    places: &'a GridPlaces,
    /// Of all receivers.
    values: &'a [Vec3],
}

/// A vertex of the grid and its share of what lies between several.
pub(crate) type WeightedVertex = (u32, f32);

impl<'a> IrradianceGrid<'a> {
    /// From the places of the scene's grid, and the irradiance of all of its receivers, as both runtimes give it.
    pub fn new(baked: &'a BakedScene, places: &'a GridPlaces, receivers: &'a [Vec3]) -> Self {
        Self { baked, places, values: receivers }
    }

    /// Irradiance (W/m²) of a surface at a world position that faces along `normal` (unit), never negative. `None` if the
    /// scene was baked without a grid.
    pub fn irradiance(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        Some(self.light(position, normal)?.irradiance(normal))
    }

    /// Light around a point of a surface that faces along `normal` (unit). `None` if the scene was baked without a grid.
    pub fn light(&self, position: Vec3, normal: Vec3) -> Option<GridLight> {
        self.baked.has_grid().then(|| self.between(&self.vertices_lighting(position, normal)))
    }

    /// The vertices that light a point of a surface that faces along `normal` (unit); the weights sum to one. None has any
    /// without a grid, and where walls cut the point off from all of them.
    pub(crate) fn vertices_lighting(&self, position: Vec3, normal: Vec3) -> [WeightedVertex; 8] {
        if !self.baked.has_grid() {
            return NO_VERTICES;
        }
        let off_surface = position + normal * (OFF_SURFACE * self.baked.grid.spacing.min_element());
        let vertices = self.vertices_around(position).or_else(|| self.vertices_around(off_surface));
        vertices.or_else(|| self.nearest_if_outside(position)).unwrap_or(NO_VERTICES)
    }

    /// Light between some vertices.
    pub(crate) fn between(&self, vertices: &[WeightedVertex]) -> GridLight {
        let mut rows = [Vec3::ZERO; MAX_GRID_ROWS];
        for (vertex, weight) in vertices.iter().filter(|(_, weight)| *weight > 0.0) {
            for (row, receiver) in rows.iter_mut().zip(self.baked.vertex_receivers(*vertex)) {
                *row += *weight * self.values[*receiver as usize];
            }
        }
        GridLight { basis: self.baked.settings.grid_basis, rows }
    }

    /// The corners of a position's cell, as far as they light it: trilinear weights, and walls between.
    fn vertices_around(&self, position: Vec3) -> Option<[WeightedVertex; 8]> {
        let place = CellPlace::of(self.baked, position);
        let mut sight = self.sight(&place);
        let mut vertices = NO_VERTICES;
        for (i, corner) in corners().enumerate() {
            match self.places.vertex(place.cell + corner) {
                Some(vertex) => vertices[i] = (vertex, place.share(corner)),
                None => sight[i] = 0.0,
            }
        }
        let total: f32 = vertices.iter().zip(&sight).map(|((_, share), sight)| share * sight).sum();
        let seen: f32 = sight.iter().sum();
        for ((_, share), sight) in vertices.iter_mut().zip(sight) {
            *share = if total > SMALLEST_WEIGHT { *share * sight / total } else { sight / seen };
        }
        (seen > 0.0).then_some(vertices)
    }

    /// How far walls let each corner light the position, from 0 to 1. The walls of the position's own cell do so sharply;
    /// those of the next cells fade in over half of it, so that nothing jumps where a wall ends.
    fn sight(&self, place: &CellPlace) -> [f32; 8] {
        let is_lower = place.within.cmplt(Vec3::splat(0.5));
        // From the middle of the cell to the next one along each axis.
        let nearness = (2.0 * (place.within - 0.5)).abs();
        let mut sight = [1.0; 8];
        for step in corners() {
            let way = IVec3::select(is_lower, -step.as_ivec3(), step.as_ivec3());
            let low = place.cell.as_ivec3() + way;
            if low.cmplt(IVec3::ZERO).any() || low.cmpge(self.baked.grid.counts.as_ivec3()).any() {
                continue;
            }
            let Some(cell) = self.places.cell(low.as_uvec3()) else { continue };
            let share = Vec3::select(step.cmpeq(UVec3::ONE), nearness, Vec3::ONE).element_product();
            let lighting = self.baked.corners_lighting(&self.baked.grid_cells[cell as usize], place.position);
            let blocked = corners_from_next(!lighting, way);
            let hidden = sight.iter_mut().enumerate().filter(|(corner, _)| blocked >> corner & 1 == 1);
            hidden.for_each(|(_, sight)| *sight *= 1.0 - share);
        }
        sight
    }

    /// Outside the grid, and where a cell has no vertices, the nearest ones to the cell's corners.
    fn nearest_if_outside(&self, position: Vec3) -> Option<[WeightedVertex; 8]> {
        let place = CellPlace::of(self.baked, position);
        let is_empty = corners().all(|corner| self.places.vertex(place.cell + corner).is_none());
        let corner = |i: u32| {
            let corner = corner(i);
            (self.places.nearest_vertex(place.cell + corner), place.share(corner))
        };
        (is_empty || place.position != position).then(|| std::array::from_fn(|i| corner(i as u32)))
    }
}

/// Light around a place in free space.
#[derive(Clone, Copy, Debug)]
pub struct GridLight {
    basis: GridBasis,
    rows: [Vec3; MAX_GRID_ROWS],
}

impl GridLight {
    /// Irradiance (W/m²) of a surface that faces along `normal` (unit), never negative.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.read(&self.basis.read_weights(normal))
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
        self.read(&weights)
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
        let along = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [self.irradiance(axis), self.irradiance(-axis)]);
        // The sum over six axes weighs all directions nearly alike: ∫ L (|x| + |y| + |z|), exactly in two bands.
        let all: Vec3 = along.iter().flatten().sum::<Vec3>() / 1.5;
        let behind = self.irradiance(-normal);
        // An even hemisphere could be taken for a wide lamp, too: so all of the light is even at first.
        let mut even = (0.5 * all - behind).max(Vec3::ZERO);
        let mut lamp = Lamp { direction: normal, cosine: 0.0, flux: Vec3::ZERO };
        for _ in 0..LAMP_PASSES {
            let component = |axis: usize| along[axis][0] - along[axis][1] + (behind - even) * normal[axis];
            let vector = [0, 1, 2].map(component);
            let direction = Vec3::from(vector.map(luminance)).normalize_or(normal);
            let flux = (0..3).map(|axis| vector[axis] * direction[axis]).sum::<Vec3>().max(Vec3::ZERO);
            let across = self.irradiance(direction) + self.irradiance(-direction) - 0.5 * all;
            let cosine =
                (1.6 * luminance(across) / luminance(flux).max(f32::MIN_POSITIVE)).clamp(0.0, SMALLEST_LAMP);
            lamp = Lamp { direction, cosine, flux: 2.0 * flux / (1.0 + cosine) };
            even = (0.5 * (all - lamp.flux) - behind).max(Vec3::ZERO);
        }
        lamp
    }

    fn read(&self, weights: &[f32; MAX_GRID_ROWS]) -> Vec3 {
        self.rows.iter().zip(weights).map(|(row, weight)| *row * *weight).sum::<Vec3>().max(Vec3::ZERO)
    }
}

/// A round light source far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Unit vector towards it; zero without one.
    pub direction: Vec3,
    /// Cosine of its half opening angle.
    pub cosine: f32,
    /// Irradiance of a surface that faces it, W/m², but for its width: the integral of its radiance.
    pub flux: Vec3,
}

/// Largest cosine of a lamp's half opening angle: a second band cannot tell smaller ones.
pub(crate) const SMALLEST_LAMP: f32 = 0.97;

/// How often what is even and what is the lamp are told apart, each by the other.
pub(crate) const LAMP_PASSES: u32 = 6;

const NO_VERTICES: [WeightedVertex; 8] = [(0, 0.0); 8];

/// A point that nothing lights is looked at so many spacings off its surface, too: it may just lie in a wall.
pub(crate) const OFF_SURFACE: f32 = 0.02;

/// Where so little weight is left, the corners that light a place count the same.
pub(crate) const SMALLEST_WEIGHT: f32 = 1e-4;

/// Corners of a cell, x first.
fn corners() -> impl Iterator<Item = UVec3> {
    (0..8).map(corner)
}

fn corner(i: u32) -> UVec3 {
    UVec3::new(i & 1, i >> 1 & 1, i >> 2)
}

/// The corners of a cell, a bit each, that are those of a cell `way` next to it; of those, the bits that are set there.
fn corners_from_next(next: u8, way: IVec3) -> u8 {
    // Of each axis, the corners on its lower side, and how far the upper ones' bits lie from theirs.
    let axes = [(0x55, 1), (0x33, 2), (0x0F, 4)];
    axes.into_iter().zip(way.to_array()).fold(next, |bits, ((lower, shift), way)| match way.signum() {
        1 => (bits & lower) << shift,
        -1 => (bits & !lower) >> shift,
        _ => bits,
    })
}

/// Where a position lies between the vertices of a grid.
struct CellPlace {
    /// The position, or the nearest one within the grid.
    position: Vec3,
    /// The lowest corner of the cell that it lies in.
    cell: UVec3,
    /// Where in it, from 0 to 1.
    within: Vec3,
}

impl CellPlace {
    fn of(baked: &BakedScene, position: Vec3) -> Self {
        let grid = &baked.grid;
        // `max` before `min` turns NaN into the first vertex.
        let position = position.max(grid.origin).min(grid.position(grid.counts - 1));
        let last = (grid.counts - 1).as_vec3();
        let at = ((position - grid.origin) / grid.spacing).min(last);
        let cell = at.floor().min(last - 1.0).max(Vec3::ZERO);
        Self { position, cell: cell.as_uvec3(), within: at - cell }
    }

    /// Trilinear weight of a corner.
    fn share(&self, corner: UVec3) -> f32 {
        Vec3::select(corner.cmpeq(UVec3::ONE), self.within, 1.0 - self.within).element_product()
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use probelight_asset::GridLobe;
    use probelight_math::directions::spherical_fibonacci;

    use super::*;

    const SPHERICAL: GridBasis = GridBasis { kind: GridBasisKind::Sh2, lobe: GridLobe::Angle };

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
        GridLight { basis, rows }
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
    fn even_light_has_no_lamp() {
        for basis in bases() {
            let light = light_of(basis, |_| 2.0);
            let (lamp, all) = (light.lamp(Vec3::Y), light.irradiance(Vec3::Y).x);
            assert!((all / (2.0 * PI) - 1.0).abs() < 0.02, "{basis:?}: {all}");
            assert!(lamp.flux.x < 0.05 * all, "{basis:?}: {lamp:?}");
            assert!((light.radiance(Vec3::X).x / 2.0 - 1.0).abs() < 0.02, "{basis:?}");
        }
    }

    #[test]
    fn corners_of_the_next_cell_are_those_on_the_shared_side() {
        let bit = |x: i32, y: i32, z: i32| 1u8 << (x + 2 * y + 4 * z);
        for (way, next, own) in [
            (IVec3::ZERO, bit(1, 0, 1), bit(1, 0, 1)),
            (IVec3::X, bit(0, 1, 1), bit(1, 1, 1)),
            (IVec3::X, bit(1, 1, 1), 0),
            (IVec3::NEG_Y, bit(1, 1, 0), bit(1, 0, 0)),
            (IVec3::new(1, -1, 1), bit(0, 1, 0), bit(1, 0, 1)),
            (IVec3::NEG_Z, bit(0, 0, 0), 0),
        ] {
            assert_eq!(corners_from_next(next, way), own, "{way} {next:08b}");
        }
    }
}
