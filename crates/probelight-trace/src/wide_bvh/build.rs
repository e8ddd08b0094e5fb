//! From obvhs' binary tree to wide nodes.

use obvhs::BvhBuildParams;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::PlocBuilder;
use obvhs::triangle::Triangle;
use probelight_math::glam::Vec3;
use wide::f32x8;

use super::triangle_packet::{LANES, TrianglePacket};
use super::{LEAF, WIDTH, WideBvh, WideNode};

/// The slow, good build: a bake traces many millions of rays per scene. Leaves hold what one packet holds.
/// Splitting large triangles beforehand gained nothing on a scene of even triangles and cost 4 to 14 % where
/// some are large, because every copy is tested again.
const PARAMETERS: BvhBuildParams =
    BvhBuildParams { pre_split: false, max_prims_per_leaf: LANES as u32, ..BvhBuildParams::slow_build() };

impl WideBvh {
    /// Builds the tree over triangles with the given corners.
    pub(crate) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let prepared: Vec<Triangle> = triangles
            .iter()
            .map(|corners| {
                let [v0, v1, v2] = corners.map(Into::into);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let binary = binary_tree(&prepared);
        Folding { binary, triangles, bvh: Self { nodes: Vec::new(), packets: Vec::new() } }.run()
    }
}

/// What obvhs' `build_bvh2_from_tris` does, without its clock, which browsers do not have.
fn binary_tree(triangles: &[Triangle]) -> Bvh2 {
    let mut tree = PlocBuilder::with_capacity(triangles.len()).build(
        PARAMETERS.ploc_search_distance,
        triangles,
        (0..triangles.len() as u32).collect(),
        PARAMETERS.sort_precision,
        PARAMETERS.search_depth_threshold,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    let share = PARAMETERS.reinsertion_batch_ratio;
    optimizer.run(&mut tree, share, None);
    collapse(&mut tree, PARAMETERS.max_prims_per_leaf, PARAMETERS.collapse_traversal_cost);
    optimizer.run(&mut tree, share * PARAMETERS.post_collapse_reinsertion_batch_ratio_multiplier, None);
    tree
}

/// The work in progress.
struct Folding<'a> {
    binary: Bvh2,
    triangles: &'a [[Vec3; 3]],
    bvh: WideBvh,
}

impl Folding<'_> {
    /// Makes wide nodes depth first, so that a ray finds a child near its parent in memory.
    fn run(mut self) -> WideBvh {
        // Binary nodes that still need a wide one, with the place where its index must be noted.
        let mut pending: Vec<(Bvh2Node, Option<(usize, usize)>)> = Vec::new();
        match self.binary.nodes.first() {
            Some(root) => pending.push((*root, None)),
            None => self.bvh.nodes.push(WideNode { borders: borders(&[]), children: [0; WIDTH] }),
        }
        while let Some((binary, parent)) = pending.pop() {
            let index = self.bvh.nodes.len();
            if let Some((node, place)) = parent {
                self.bvh.nodes[node].children[place] = index as u32;
            }
            let members = self.open(binary);
            let mut children = [0; WIDTH];
            for (place, member) in members.iter().enumerate() {
                if member.is_leaf() {
                    children[place] = self.add_packet(member);
                } else {
                    pending.push((*member, Some((index, place))));
                }
            }
            self.bvh.nodes.push(WideNode { borders: borders(&members), children });
        }
        self.bvh
    }

    /// Up to eight descendants that together cover `node`: the largest box is opened first.
    fn open(&self, node: Bvh2Node) -> Vec<Bvh2Node> {
        let mut members = vec![node];
        while members.len() < WIDTH {
            let largest = (0..members.len())
                .filter(|member| !members[*member].is_leaf())
                .max_by(|a, b| members[*a].aabb().half_area().total_cmp(&members[*b].aabb().half_area()));
            let Some(largest) = largest else { break };
            let first = members.swap_remove(largest).first_index as usize;
            members.extend_from_slice(&self.binary.nodes[first..first + 2]);
        }
        members
    }

    fn add_packet(&mut self, leaf: &Bvh2Node) -> u32 {
        let first = leaf.first_index as usize;
        let members = &self.binary.primitive_indices[first..first + leaf.prim_count as usize];
        self.bvh.packets.push(TrianglePacket::new(members, self.triangles));
        LEAF | (self.bvh.packets.len() - 1) as u32
    }
}

/// The boxes of a node's members; those of empty places are inside out, so that no ray meets them.
fn borders(members: &[Bvh2Node]) -> [f32x8; 6] {
    std::array::from_fn(|border| {
        let axis = border % 3;
        let is_lower = border < 3;
        let mut lanes = [if is_lower { f32::INFINITY } else { f32::NEG_INFINITY }; WIDTH];
        for (lane, member) in lanes.iter_mut().zip(members) {
            let corners = member.aabb();
            *lane = if is_lower { corners.min[axis] } else { corners.max[axis] };
        }
        f32x8::new(lanes)
    })
}
