//! Moves receivers' values to lightmap texels.

use probelight_math::glam::Vec3;
use rayon::prelude::*;

/// Texels a task fills.
const TEXELS_PER_TASK: usize = 8192;

/// Which texel takes which receiver's value; sorted by texel, so that tasks own separate parts of the image.
#[derive(Clone, Debug, Default)]
pub(super) struct TexelCopies {
    copies: Vec<TexelCopy>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TexelCopy {
    texel: u32,
    receiver: u32,
}

impl TexelCopies {
    /// From pairs (texel, receiver) in any order.
    pub(super) fn new(pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut copies: Vec<TexelCopy> =
            pairs.map(|(texel, receiver)| TexelCopy { texel, receiver }).collect();
        copies.sort_unstable();
        Self { copies }
    }

    /// Copies `receivers` to `texels`; other texels stay as they are.
    pub(super) fn apply(&self, receivers: &[Vec3], texels: &mut [Vec3]) {
        texels.par_chunks_mut(TEXELS_PER_TASK).enumerate().for_each(|(task, texels)| {
            let first = task * TEXELS_PER_TASK;
            let before = |end: usize| self.copies.partition_point(|copy| (copy.texel as usize) < end);
            for copy in &self.copies[before(first)..before(first + texels.len())] {
                texels[copy.texel as usize - first] = receivers[copy.receiver as usize];
            }
        });
    }
}
