//! The bounding volume hierarchy: eight children a node, four triangles a leaf, both tested at once.
//!
//! obvhs builds a binary tree (PLOC with reinsertion), which is folded here into wide nodes
//! of uncompressed boxes. Why not obvhs' own compressed wide tree: its eight-bit boxes save memory, which
//! matters on a GPU, but unpacking them and testing triangles one by one costs a CPU a third of its speed
//! (see `tools/embree-bench`).

mod build;
mod traverse;
mod triangle_packet;

use wide::f32x8;

pub(crate) use traverse::Query;
use triangle_packet::TrianglePacket;

/// Children per node.
const WIDTH: usize = 8;

/// Children with this bit set are leaves; the rest is the index of their packet.
const LEAF: u32 = 1 << 31;

/// A tree over triangles.
pub(crate) struct WideBvh {
    /// The first is the root.
    nodes: Vec<WideNode>,
    /// The leaves.
    packets: Vec<TrianglePacket>,
}

/// Eight boxes and what is in them. Empty places have boxes that no ray meets.
#[derive(Clone)]
#[repr(C, align(64))]
struct WideNode {
    /// Box borders: the lower x, y, z, then the upper x, y, z.
    borders: [f32x8; 6],
    /// Index of a node, or [`LEAF`] and the index of a packet.
    children: [u32; WIDTH],
}
