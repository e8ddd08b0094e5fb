//! Walls between the grid's vertices: which corners of a cell light which part of it.
//!
//! A corner lights what free ways lead to from where it measures, within the cell and a little around it. So a wall of
//! any thinness stops it, and a column that light passes on both sides does not. Where corners light some parts of a
//! cell and not others, planes of its triangles divide it.

use std::collections::HashMap;

use probelight_asset::{CELL_PLANES, GridBlock, GridCell, GridLayout, NONE, places_of};
use probelight_math::glam::{UVec3, Vec3, Vec4};
use probelight_scene::Scene;
use probelight_trace::{Progress, Ray, Tracer};
use rayon::prelude::*;

use crate::BakeError;
use crate::air::box_overlaps_triangle;
use crate::ground::grid::{Grid, PLACES_PER_BLOCK, mask_of, places_by_block};
use crate::steps::for_each_in_parallel;

/// Places along each edge of a cell that ways lead by.
const PLACES_PER_EDGE: usize = 3;

/// These, and those around the cell by which ways may bend.
const PLACES_ALONG: usize = PLACES_PER_EDGE + 2;

/// How far places are moved along each axis, in steps between them: walls that divide cells evenly pass beside them.
const ASIDE: Vec3 = Vec3::new(0.017, -0.011, 0.023);

/// How far ways overlap at places, as a share of a step: so that none slips through a wall just there.
const OVERLAP: f32 = 1e-3;

/// How far witnesses lie off the triangles, in spacings.
const OFF_TRIANGLES: f32 = 1e-3;

/// Triangles of a cell that are looked at.
const MAX_TRIANGLES: usize = 48;

/// Places that are tried for sight of a witness, nearest first.
const PLACES_TRIED: usize = 40;

/// Cosine between the normals of planes that count as one, and their distance in spacings.
const SAME_PLANE: (f32, f32) = (0.9999, 1e-4);

/// The walls of a grid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    pub(crate) blocks: Vec<GridBlock>,
    pub(crate) cells: Vec<GridCell>,
    pub(crate) planes: Vec<Vec4>,
}

/// How a cell is divided.
#[derive(Clone, Debug, PartialEq)]
struct Division {
    planes: Vec<Vec4>,
    /// The corners that light each part, see [`GridCell::corners`].
    corners: [u8; 1 << CELL_PLANES],
}

/// A place in a cell, and the corners that light it.
#[derive(Clone, Copy, Debug)]
struct Witness {
    position: Vec3,
    corners: u8,
    /// Whether corners of coarser cells light it, and none of these.
    is_open: bool,
}

/// Finds the walls in the cells of a grid.
pub(crate) fn find_walls(tracer: &Tracer, grid: &Grid, progress: &dyn Progress) -> Result<Walls, BakeError> {
    if grid.vertices.is_empty() {
        return Ok(Walls::default());
    }
    let mut walls = Walls::default();
    let mut numbers = HashMap::<[u32; 4], u32>::new();
    for level in 0..grid.layout.levels {
        let found = divide_cells(tracer, grid, level, progress)?;
        for block in found.chunks(PLACES_PER_BLOCK) {
            walls.blocks.push(GridBlock::new(mask_of(block), walls.cells.len() as u32, level));
            for division in block.iter().flatten() {
                let mut cell = GridCell { planes: [NONE; CELL_PLANES], corners: division.corners };
                for (number, plane) in cell.planes.iter_mut().zip(&division.planes) {
                    *number = *numbers.entry(plane.to_array().map(f32::to_bits)).or_insert_with(|| {
                        walls.planes.push(*plane);
                        walls.planes.len() as u32 - 1
                    });
                }
                walls.cells.push(cell);
            }
        }
    }
    Ok(if walls.cells.is_empty() { Walls::default() } else { walls })
}

/// How walls divide the cells of a level, block by block.
fn divide_cells(
    tracer: &Tracer,
    grid: &Grid,
    level: u32,
    progress: &dyn Progress,
) -> Result<Vec<Option<Division>>, BakeError> {
    let layout = grid.layout.at_level(level);
    let cells: Vec<UVec3> = places_by_block(&layout).collect();
    let triangles = triangles_of_cells(tracer.scene(), &layout);
    let look = |(cell, triangles): (&UVec3, &Vec<u32>)| {
        if triangles.is_empty() || !grid.layout.is_read(&grid.blocks, level, *cell) {
            return None;
        }
        let corners = corner_places(grid, level, *cell);
        if corners.iter().all(Option::is_none) {
            return None;
        }
        let (min, coarser) = (layout.position(*cell), coarser_places(grid, level, *cell));
        Cell { tracer, min, size: layout.spacing, corners, coarser }.divide(triangles)
    };
    let cells = cells.par_iter().zip(&triangles);
    for_each_in_parallel("finding walls in the grid", cells, progress, look)
}

/// The triangles that pass through each cell or close by, in the order of blocks.
fn triangles_of_cells(scene: &Scene, layout: &GridLayout) -> Vec<Vec<u32>> {
    let mut cells = vec![Vec::new(); layout.blocks().element_product() as usize * PLACES_PER_BLOCK];
    let reach = 0.5 + 0.5 / PLACES_PER_EDGE as f32;
    for triangle in 0..scene.triangles.len() {
        let corners = scene.corners(triangle).map(|corner| (corner - layout.origin) / layout.spacing);
        let (low, high) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        let low = (low - reach - 0.5).ceil().max(Vec3::ZERO).as_uvec3();
        let high = (high + reach - 0.5)
            .floor()
            .max(Vec3::ZERO)
            .as_uvec3()
            .min(layout.counts.max(UVec3::splat(2)) - 2);
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    let cell = UVec3::new(x, y, z);
                    if box_overlaps_triangle(cell.as_vec3() + 0.5, Vec3::splat(reach), corners) {
                        let (block, bit) = layout.place(cell);
                        cells[PLACES_PER_BLOCK * block + bit as usize].push(triangle as u32);
                    }
                }
            }
        }
    }
    cells
}

/// Where the corners of a cell of a level measure.
fn corner_places(grid: &Grid, level: u32, cell: UVec3) -> [Option<Vec3>; 8] {
    std::array::from_fn(|i| {
        let corner = (cell + UVec3::new(i as u32 & 1, i as u32 >> 1 & 1, i as u32 >> 2)) << level;
        if corner.cmpge(grid.layout.counts).any() {
            return None;
        }
        let (block, bit) = grid.layout.place(corner);
        Some(grid.vertices[grid.blocks[block].number(bit)? as usize].position)
    })
}

/// Where the corners of the coarser cells around a cell measure, if coarser blocks have some of its own.
fn coarser_places(grid: &Grid, level: u32, cell: UVec3) -> Vec<Vec3> {
    let is_coarser = |corner: UVec3| {
        let place = (cell + corner) << level;
        place.cmplt(grid.layout.counts).all() && !grid.layout.is_covered(&grid.blocks, place, level)
    };
    if !places_of(UVec3::splat(2)).any(is_coarser) {
        return Vec::new();
    }
    let coarser = level + 1..grid.layout.levels;
    coarser.flat_map(|coarser| corner_places(grid, coarser, cell >> (coarser - level))).flatten().collect()
}

/// A cell of the grid.
struct Cell<'a> {
    tracer: &'a Tracer,
    min: Vec3,
    size: Vec3,
    corners: [Option<Vec3>; 8],
    /// Where corners of coarser cells measure that light what none of these does.
    coarser: Vec<Vec3>,
}

impl Cell<'_> {
    /// How the triangles divide it; `None` if all of it is lit by the same corners, all that there are.
    fn divide(&self, triangles: &[u32]) -> Option<Division> {
        let mut witnesses = self.places_and_corners();
        let places = witnesses.clone();
        witnesses.retain(|witness| self.contains(witness.position));
        let stride = triangles.len().div_ceil(MAX_TRIANGLES);
        let mut planes = Vec::<Vec4>::new();
        for triangle in triangles.iter().step_by(stride) {
            let corners = self.tracer.scene().corners(*triangle as usize);
            let normal = self.tracer.front_normal(*triangle);
            let points = points_inside(&clip(corners, self.min, self.min + self.size));
            if points.is_empty() {
                continue;
            }
            add_plane(&mut planes, normal, corners[0], self.size.max_element());
            for side in [normal, -normal] {
                let off = side * (OFF_TRIANGLES * self.size.max_element());
                witnesses.extend(points.iter().map(|point| self.witness(*point + off, &places)));
            }
        }
        // Nothing leads to the insides of solids, where nothing is to be lit.
        witnesses.retain(|witness| witness.corners != 0 || witness.is_open);
        let all = (0..8).fold(0, |all, i| all | u8::from(self.corners[i].is_some()) << i);
        witnesses.iter().any(|witness| witness.corners != all).then(|| divide(&witnesses, &planes))
    }

    fn contains(&self, position: Vec3) -> bool {
        position.cmpge(self.min).all() && position.cmple(self.min + self.size).all()
    }

    /// The places that ways lead by, and the corners that light them.
    fn places_and_corners(&self) -> Vec<Witness> {
        let at = |i: usize| {
            let steps = [i % PLACES_ALONG, i / PLACES_ALONG % PLACES_ALONG, i / PLACES_ALONG / PLACES_ALONG];
            let steps = Vec3::from_array(steps.map(|step| step as f32 - 0.5));
            self.min + (steps + ASIDE) / PLACES_PER_EDGE as f32 * self.size
        };
        let places: Vec<Vec3> = (0..PLACES_ALONG.pow(3)).map(at).collect();
        let regions = self.regions(&places);
        let mut corners = vec![0u8; places.len()];
        for (c, corner) in self.corners.iter().enumerate() {
            let Some(corner) = corner else { continue };
            for (place, region) in places.iter().zip(&regions) {
                if corners[*region] >> c & 1 == 0 && self.tracer.is_visible(*corner, *place) {
                    corners[*region] |= 1 << c;
                }
            }
        }
        let mut is_open = vec![false; places.len()];
        for (place, region) in places.iter().zip(&regions) {
            is_open[*region] = is_open[*region] || (corners[*region] == 0 && self.sees_coarser(*place));
        }
        let witness = |(position, region): (&Vec3, &usize)| Witness {
            position: *position,
            corners: corners[*region],
            is_open: is_open[*region],
        };
        places.iter().zip(&regions).map(witness).collect()
    }

    /// For each place the first one of those that ways connect it with.
    fn regions(&self, places: &[Vec3]) -> Vec<usize> {
        let mut regions: Vec<usize> = (0..places.len()).collect();
        for from in 0..places.len() {
            for to in next_places(from) {
                let (a, b) = (regions[from], regions[to]);
                if a != b && self.is_free(places[from], places[to]) {
                    let (first, other) = (a.min(b), a.max(b));
                    regions.iter_mut().filter(|region| **region == other).for_each(|region| *region = first);
                }
            }
        }
        regions
    }

    fn sees_coarser(&self, position: Vec3) -> bool {
        self.coarser.iter().any(|corner| self.tracer.is_visible(*corner, position))
    }

    fn is_free(&self, from: Vec3, to: Vec3) -> bool {
        let direction = to - from;
        let ray = Ray { origin: from - OVERLAP * direction, direction, max_distance: 1.0 + 2.0 * OVERLAP };
        !self.tracer.is_occluded(&ray)
    }

    /// A point lit by what lights the nearest place that it sees, or by the corners that it sees itself.
    fn witness(&self, position: Vec3, places: &[Witness]) -> Witness {
        let mut nearest: Vec<(f32, &Witness)> =
            places.iter().map(|place| (place.position.distance_squared(position), place)).collect();
        nearest.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let seen = nearest
            .iter()
            .take(PLACES_TRIED)
            .find(|(_, place)| self.tracer.is_visible(position, place.position));
        if let Some((_, place)) = seen {
            return Witness { position, ..**place };
        }
        let sees =
            |corner: &Option<Vec3>| corner.is_some_and(|corner| self.tracer.is_visible(position, corner));
        let corners = (0..8).fold(0, |all, i| all | u8::from(sees(&self.corners[i])) << i);
        Witness { position, corners, is_open: corners == 0 && self.sees_coarser(position) }
    }
}

/// Neighbours of a place with higher numbers.
fn next_places(from: usize) -> impl Iterator<Item = usize> {
    let along = |number: usize, axis: u32| (number / PLACES_ALONG.pow(axis) % PLACES_ALONG) as i32;
    (14..27i32).filter_map(move |step| {
        let step = [step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1];
        let to = [0, 1, 2].map(|axis| along(from, axis as u32) + step[axis]);
        let edge = PLACES_ALONG as i32;
        to.iter().all(|at| (0..edge).contains(at)).then(|| (to[0] + edge * (to[1] + edge * to[2])) as usize)
    })
}

/// A triangle's part in a box (Sutherland–Hodgman).
fn clip(corners: [Vec3; 3], min: Vec3, max: Vec3) -> Vec<Vec3> {
    let mut polygon = corners.to_vec();
    for axis in 0..3 {
        for (sign, limit) in [(1.0, min[axis]), (-1.0, -max[axis])] {
            let inside = |point: Vec3| sign * point[axis] - limit;
            let mut clipped = Vec::with_capacity(polygon.len() + 1);
            for (i, point) in polygon.iter().enumerate() {
                let next = polygon[(i + 1) % polygon.len()];
                let (a, b) = (inside(*point), inside(next));
                if a >= 0.0 {
                    clipped.push(*point);
                }
                if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
                    clipped.push(point.lerp(next, a / (a - b)));
                }
            }
            polygon = clipped;
        }
    }
    polygon
}

/// Points in a polygon: its middle, and between that and each corner.
fn points_inside(polygon: &[Vec3]) -> Vec<Vec3> {
    let Some(count) = (polygon.len() >= 3).then_some(polygon.len() as f32) else { return Vec::new() };
    let middle = polygon.iter().sum::<Vec3>() / count;
    let between = polygon.iter().flat_map(|corner| [0.5, 0.95].map(|share| middle.lerp(*corner, share)));
    std::iter::once(middle).chain(between).collect()
}

/// Adds a triangle's plane if it is new. Planes face up the first axis that they do not lie along.
fn add_plane(planes: &mut Vec<Vec4>, normal: Vec3, point: Vec3, spacing: f32) {
    let (cosine, distance) = SAME_PLANE;
    let is_same = |plane: &Vec4| {
        plane.truncate().dot(normal).abs() > cosine
            && (plane.truncate().dot(point) + plane.w).abs() < distance * spacing
    };
    if !planes.iter().any(is_same) {
        let first = normal.to_array().into_iter().find(|v| v.abs() > 1e-3).unwrap_or(1.0);
        let normal = normal * first.signum();
        planes.push(normal.extend(-normal.dot(point)));
    }
}

/// Divides a cell by those planes that best tell apart what different corners light.
fn divide(witnesses: &[Witness], planes: &[Vec4]) -> Division {
    let mut sets: Vec<u8> = witnesses.iter().map(|witness| witness.corners).collect();
    sets.sort_unstable();
    sets.dedup();
    let set_of: Vec<usize> =
        witnesses.iter().map(|witness| sets.partition_point(|set| *set < witness.corners)).collect();
    let count = |parts: &[usize]| {
        let mut counts = vec![vec![0u32; sets.len()]; 1 << CELL_PLANES];
        parts.iter().zip(&set_of).for_each(|(part, set)| counts[*part][*set] += 1);
        counts
    };
    let mut parts = vec![0usize; witnesses.len()];
    let mut chosen = Vec::new();
    while chosen.len() < CELL_PLANES {
        let divided_by = |plane: &Vec4| -> Vec<usize> {
            let is_in_front = |witness: &Witness| witness.position.extend(1.0).dot(*plane) > 0.0;
            let part = |(part, witness)| part | usize::from(is_in_front(witness)) << chosen.len();
            parts.iter().zip(witnesses).map(part).collect()
        };
        let rated = planes.iter().map(|plane| {
            let parts = divided_by(plane);
            (disorder(&count(&parts)), parts, plane)
        });
        let Some((rest, divided, plane)) = rated.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if rest >= disorder(&count(&parts)) {
            break;
        }
        parts = divided;
        chosen.push(*plane);
    }
    let counts = count(&parts);
    let most = |part: usize| (0..sets.len()).max_by_key(|set| counts[part][*set]);
    let known = |part: usize| most(part).filter(|set| counts[part][*set] > 0).map(|set| sets[set]);
    let corners = std::array::from_fn(|part| known(part).unwrap_or_else(|| between(part, known)));
    Division { planes: chosen, corners }
}

/// The corners that light a part without witnesses, as there is one between the two planes of a thin wall where that has
/// ended: those that light all lit parts across one plane from it.
fn between(part: usize, known: impl Fn(usize) -> Option<u8>) -> u8 {
    let beside =
        (0..CELL_PLANES).filter_map(|plane| known(part ^ 1 << plane)).filter(|corners| *corners != 0);
    match beside.fold(u8::MAX, |all, corners| all & corners) {
        0 => u8::MAX,
        corners => corners,
    }
}

/// Gini impurity: of the witnesses of each part, how many a random other one contradicts on average.
fn disorder(counts: &[Vec<u32>]) -> f64 {
    let of_part = |counts: &Vec<u32>| {
        let total = f64::from(counts.iter().sum::<u32>());
        let squares: f64 = counts.iter().map(|count| f64::from(*count).powi(2)).sum();
        if total > 0.0 { total - squares / total } else { 0.0 }
    };
    counts.iter().map(of_part).sum()
}
