//! Rays through the tree.

use probelight_math::glam::{Vec2, Vec3};
use wide::f32x8;

use super::triangle_packet::{PacketHits, PacketRay};
use super::{LEAF, WIDTH, WideBvh, WideNode};

/// Widens boxes to the far side by two units in the last place, so that rounding lets no ray slip past one
/// (Ize 2013, "Robust BVH ray traversal").
const ROBUST_FAR: f32 = 1.0 + 2.0 * f32::EPSILON;

/// Subtrees a ray may still have to visit before the stack moves to the heap: more than a well-built tree of
/// millions of triangles needs.
const STACK_SIZE: usize = 96;

/// A ray to be traced: direction in any length, distances in its multiples, not below 0.
pub(crate) struct Query {
    ray: PacketRay,
    origin: [f32x8; 3],
    inverse_direction: [f32x8; 3],
    /// For each axis, which of a box's six borders the ray meets first and last.
    near: [usize; 3],
    far: [usize; 3],
    max_distance: f32,
}

/// The nearest triangle along a ray.
#[derive(Clone, Copy)]
pub(crate) struct TriangleHit {
    pub(crate) distance: f32,
    pub(crate) triangle: u32,
    /// Weights of the second and third corner.
    pub(crate) barycentric: Vec2,
}

impl Query {
    #[inline]
    pub(crate) fn new(origin: Vec3, direction: Vec3, max_distance: f32) -> Self {
        let inverse = direction.to_array().map(finite_inverse);
        let is_negative = inverse.map(|component| component < 0.0);
        let [near, far] = [false, true].map(|is_far| {
            std::array::from_fn(|axis| if is_negative[axis] == is_far { axis } else { axis + 3 })
        });
        Self {
            ray: PacketRay::new(origin, direction),
            origin: origin.to_array().map(f32x8::splat),
            inverse_direction: inverse.map(f32x8::splat),
            near,
            far,
            max_distance,
        }
    }

    /// Distances at which the ray enters a node's boxes, and a bit for each that it enters at all before
    /// `max_distance`.
    #[inline(always)]
    fn enter(&self, node: &WideNode, max_distance: f32) -> ([f32; WIDTH], u32) {
        let [nx, ny, nz] = std::array::from_fn(|a| self.reach(node, self.near[a], a));
        let [fx, fy, fz] = std::array::from_fn(|a| self.reach(node, self.far[a], a));
        let entry = nx.fast_max(ny).fast_max(nz.fast_max(f32x8::ZERO));
        let exit = fx.fast_min(fy).fast_min(fz) * f32x8::splat(ROBUST_FAR);
        let is_met = entry.simd_le(exit.fast_min(f32x8::splat(max_distance)));
        (entry.to_array(), is_met.to_bitmask())
    }

    /// Distance to one of the planes that bound a node's boxes.
    #[inline(always)]
    fn reach(&self, node: &WideNode, border: usize, axis: usize) -> f32x8 {
        (node.borders[border] - self.origin[axis]) * self.inverse_direction[axis]
    }
}

/// 1/x without infinity, whose product with 0 would be no number.
#[inline]
fn finite_inverse(x: f32) -> f32 {
    const SMALLEST: f32 = 1e-18;
    1.0 / if x.abs() < SMALLEST { SMALLEST.copysign(x) } else { x }
}

impl WideBvh {
    /// The nearest hit that `is_solid` accepts.
    #[inline]
    pub(crate) fn closest_hit(
        &self,
        query: &Query,
        is_solid: impl Fn(u32, Vec2) -> bool,
    ) -> Option<TriangleHit> {
        let mut nearest = None;
        let mut max_distance = query.max_distance;
        let mut stack = Stack::new();
        let mut next = Some(0);
        while let Some(child) = next.or_else(|| stack.pop_nearer_than(max_distance)) {
            next = if child & LEAF == 0 {
                let (entries, met) = query.enter(&self.nodes[child as usize], max_distance);
                stack.push_all_but_nearest(&self.nodes[child as usize], &entries, met)
            } else {
                let packet = &self.packets[(child & !LEAF) as usize];
                let mut hits = packet.intersect(&query.ray, max_distance);
                while let Some(lane) = hits.take_nearest() {
                    let (triangle, barycentric) = (packet.triangles[lane], hits.barycentric(lane));
                    if is_solid(triangle, barycentric) {
                        max_distance = hits.distances[lane];
                        nearest = Some(TriangleHit { distance: max_distance, triangle, barycentric });
                        break;
                    }
                }
                None
            };
        }
        nearest
    }

    /// Whether `is_solid` accepts any hit.
    #[inline]
    pub(crate) fn is_occluded(&self, query: &Query, is_solid: impl Fn(u32, Vec2) -> bool) -> bool {
        let mut stack = Stack::new();
        let mut next = Some(0);
        while let Some(child) = next.or_else(|| stack.pop()) {
            next = if child & LEAF == 0 {
                let (entries, met) = query.enter(&self.nodes[child as usize], query.max_distance);
                stack.push_all_but_nearest(&self.nodes[child as usize], &entries, met)
            } else {
                let packet = &self.packets[(child & !LEAF) as usize];
                let mut hits = packet.intersect(&query.ray, query.max_distance);
                while let Some(lane) = hits.take_nearest() {
                    if is_solid(packet.triangles[lane], hits.barycentric(lane)) {
                        return true;
                    }
                }
                None
            };
        }
        false
    }
}

impl PacketHits {
    /// The hit lane with the least distance, which then counts as hit no more.
    #[inline(always)]
    fn take_nearest(&mut self) -> Option<usize> {
        let mut nearest: Option<usize> = None;
        let mut rest = self.lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            if nearest.is_none_or(|other| self.distances[lane] < self.distances[other]) {
                nearest = Some(lane);
            }
        }
        if let Some(lane) = nearest {
            self.lanes &= !(1 << lane);
        }
        nearest
    }
}

/// Subtrees still to visit, with the distance at which the ray enters them.
struct Stack {
    entries: [(f32, u32); STACK_SIZE],
    length: usize,
    overflow: Vec<(f32, u32)>,
}

impl Stack {
    #[inline(always)]
    fn new() -> Self {
        Self { entries: [(0.0, 0); STACK_SIZE], length: 0, overflow: Vec::new() }
    }

    #[inline(always)]
    fn push(&mut self, entry: (f32, u32)) {
        if let Some(place) = self.entries.get_mut(self.length) {
            *place = entry;
            self.length += 1;
        } else {
            self.overflow.push(entry);
        }
    }

    #[inline(always)]
    fn pop_entry(&mut self) -> Option<(f32, u32)> {
        if self.length == STACK_SIZE
            && let Some(entry) = self.overflow.pop()
        {
            return Some(entry);
        }
        self.length = self.length.checked_sub(1)?;
        self.entries.get(self.length).copied()
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<u32> {
        self.pop_entry().map(|(_, child)| child)
    }

    /// The next subtree that begins before `max_distance`.
    #[inline(always)]
    fn pop_nearer_than(&mut self, max_distance: f32) -> Option<u32> {
        while let Some((entry, child)) = self.pop_entry() {
            if entry <= max_distance {
                return Some(child);
            }
        }
        None
    }

    /// Puts the met children of a node on the stack, but for the nearest, which is returned.
    #[inline(always)]
    fn push_all_but_nearest(&mut self, node: &WideNode, entries: &[f32; WIDTH], met: u32) -> Option<u32> {
        if met == 0 {
            return None;
        }
        let child = |met: u32| {
            let place = met.trailing_zeros() as usize % WIDTH;
            (entries[place], node.children[place])
        };
        let mut nearest = child(met);
        let mut rest = met & (met - 1);
        while rest != 0 {
            let other = child(rest);
            rest &= rest - 1;
            if other.0 < nearest.0 {
                self.push(nearest);
                nearest = other;
            } else {
                self.push(other);
            }
        }
        Some(nearest.1)
    }
}
