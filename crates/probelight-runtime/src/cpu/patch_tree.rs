//! The trees of patches above the surfels, cut into blocks that tasks work through side by side, or frames in turns.
//!
//! ```text
//!                   ┌───────┐
//!                   │  top  │            groups of more surfels than a block has
//!                   └┬──┬──┬┘
//!            ┌───────┘  │  └───────┐
//!        ┌───┴───┐  ┌───┴───┐  ┌───┴───┐
//!        │ block │  │ block │  │ block │     whole trees, each below a root
//!        └───────┘  └───────┘  └───────┘
//! ```
//!
//! Patches have *places*: block by block, in each its surfels, then its groups, parts before what is made of them; then the
//! top.

use probelight_asset::{NONE, SurfelGroup};

/// Most surfels of a tree that belongs to one block.
const SURFELS_PER_BLOCK: u32 = 1024;

/// Trees of patches in blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchTree {
    /// What each patch is made of: places, in blocks counted from the block's first; [`NONE`] twice for surfels.
    parts: Vec<[u32; 2]>,
    /// The surfel at each place, or [`NONE`].
    surfels: Vec<u32>,
    /// The place of each surfel, and its block.
    places: Vec<(u32, u32)>,
    /// Behind the last place of each block.
    ends: Vec<usize>,
    /// Places of what is part of nothing in its block.
    roots: Vec<usize>,
}

/// A block, or the top. Places in it are those in the block, or those in the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch<'a> {
    /// Its surfels, at its first places.
    pub(super) surfels: &'a [u32],
    /// Place of the first group.
    pub(super) first_group: usize,
    /// What each of its groups is made of, or [`NONE`] twice.
    groups: &'a [[u32; 2]],
}

impl PatchTree {
    /// From the number of surfels, which are the first patches, and the groups that follow them.
    pub(super) fn new(surfels: usize, groups: &[SurfelGroup]) -> Self {
        let patches = surfels + groups.len();
        let numbered = || (surfels..patches).zip(groups);
        let mut sizes = vec![1u32; patches];
        for (number, group) in numbered() {
            let [a, b] = group.children.map(|child| sizes[child as usize]);
            sizes[number] = a.saturating_add(b);
        }
        let is_top = |patch: usize| sizes[patch] > SURFELS_PER_BLOCK;
        let mut root_of: Vec<u32> = (0..patches as u32).collect();
        for (number, group) in numbered().rev().filter(|(number, _)| !is_top(*number)) {
            let root = root_of[number];
            group.children.iter().for_each(|child| root_of[*child as usize] = root);
        }
        let block_of = blocks_of_roots(&sizes, &root_of);
        let mut tree = Self { surfels: vec![NONE; patches], ..Self::default() };
        let places = tree.place(patches, surfels, |patch| {
            if is_top(patch) { NONE } else { block_of[root_of[patch] as usize] }
        });
        tree.parts = vec![[NONE; 2]; patches];
        for (number, group) in numbered() {
            let (place, block) = places[number];
            let children = group.children.map(|child| places[child as usize]);
            let first = if block == NONE { 0 } else { tree.start(block as usize) as u32 };
            if block == NONE || children.iter().all(|(_, of_child)| *of_child == block) {
                tree.parts[place as usize] = children.map(|(place, _)| place - first);
            }
        }
        let is_root = |patch: &usize| places[*patch].1 != NONE && root_of[*patch] as usize == *patch;
        tree.roots = (0..patches).filter(is_root).map(|patch| places[patch].0 as usize).collect();
        tree.places = places[..surfels].to_vec();
        tree
    }

    /// Gives all patches places, by the block of each. Returns place and block of every patch.
    fn place(&mut self, patches: usize, surfels: usize, block_of: impl Fn(usize) -> u32) -> Vec<(u32, u32)> {
        let mut order: Vec<(u32, usize)> = (0..patches).map(|patch| (block_of(patch), patch)).collect();
        order.sort_unstable();
        let mut places = vec![(0, NONE); patches];
        for (place, (block, patch)) in order.iter().enumerate() {
            places[*patch] = (place as u32, *block);
            if *patch < surfels {
                self.surfels[place] = *patch as u32;
            }
        }
        let in_blocks = order.partition_point(|(block, _)| *block != NONE);
        for block in order[..in_blocks].chunk_by(|a, b| a.0 == b.0) {
            self.ends.push(self.start(self.ends.len()) + block.len());
        }
        places
    }

    /// Number of patches.
    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.ends.len()
    }

    /// The first place of a block; behind the last one, of the top.
    pub(super) fn start(&self, block: usize) -> usize {
        block.checked_sub(1).map_or(0, |before| self.ends[before])
    }

    /// A block.
    pub(super) fn block(&self, block: usize) -> Branch<'_> {
        let (first, end) = (self.start(block), self.start(block + 1));
        let surfels = self.surfels[first..end].partition_point(|surfel| *surfel != NONE);
        Branch {
            surfels: &self.surfels[first..][..surfels],
            first_group: surfels,
            groups: &self.parts[first + surfels..end],
        }
    }

    /// The groups above all blocks.
    pub(super) fn top(&self) -> Branch<'_> {
        let first_group = self.start(self.blocks());
        Branch { surfels: &[], first_group, groups: &self.parts[first_group..] }
    }

    /// Places of what is part of nothing in its block.
    pub(super) fn roots(&self) -> &[usize] {
        &self.roots
    }

    /// The block of a place; of the top it is one behind the last.
    pub(super) fn block_at(&self, place: usize) -> usize {
        self.ends.partition_point(|end| *end <= place)
    }

    /// Place and block of a surfel.
    pub(super) fn place_of(&self, surfel: usize) -> (usize, usize) {
        let (place, block) = self.places[surfel];
        (place as usize, block as usize)
    }

    /// What the patch at a place is made of, as places.
    pub(super) fn parts_at(&self, place: usize) -> Option<[usize; 2]> {
        let parts = self.parts[place];
        let block = self.block_at(place);
        let first = if block < self.blocks() { self.start(block) } else { 0 };
        (parts[0] != NONE).then(|| parts.map(|part| first + part as usize))
    }

    /// The surfel at each place, or [`NONE`].
    pub(super) fn surfels(&self) -> &[u32] {
        &self.surfels
    }
}

impl Branch<'_> {
    /// Places of its groups and of what they are made of, parts before what is made of them.
    pub(super) fn groups(&self) -> impl DoubleEndedIterator<Item = (usize, [usize; 2])> {
        let numbered = self.groups.iter().enumerate().filter(|(_, parts)| parts[0] != NONE);
        numbered.map(|(number, parts)| (self.first_group + number, parts.map(|part| part as usize)))
    }

    /// What the patch at a place is made of.
    pub(super) fn parts_at(&self, place: usize) -> Option<[usize; 2]> {
        let parts = self.groups[place.checked_sub(self.first_group)?];
        (parts[0] != NONE).then(|| parts.map(|part| part as usize))
    }
}

/// The block of each root: as many in a row as make about a block.
fn blocks_of_roots(sizes: &[u32], root_of: &[u32]) -> Vec<u32> {
    let mut blocks = vec![NONE; sizes.len()];
    let (mut block, mut filled) = (0, 0);
    for root in (0..sizes.len()).filter(|patch| root_of[*patch] as usize == *patch) {
        if sizes[root] > SURFELS_PER_BLOCK {
            continue;
        }
        if filled + sizes[root] > SURFELS_PER_BLOCK && filled > 0 {
            (block, filled) = (block + 1, 0);
        }
        blocks[root] = block;
        filled += sizes[root];
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A balanced tree above `surfels` (a power of two).
    fn balanced(surfels: u32) -> Vec<SurfelGroup> {
        (0..surfels - 1)
            .map(|group| SurfelGroup { children: [2 * group, 2 * group + 1], first_weight: 0.5 })
            .collect()
    }

    #[test]
    fn blocks_are_whole_trees_below_the_top() {
        let (large, alone) = (4 * SURFELS_PER_BLOCK, 3);
        // Three surfels without a group come last.
        let shifted = |child: u32| if child < large { child } else { child + alone };
        let groups: Vec<SurfelGroup> = balanced(large)
            .into_iter()
            .map(|group| SurfelGroup { children: group.children.map(shifted), ..group })
            .collect();
        let surfels = (large + alone) as usize;
        let tree = PatchTree::new(surfels, &groups);
        assert_eq!((tree.blocks(), tree.top().groups().count(), tree.len()), (5, 3, surfels + groups.len()));
        assert_eq!(tree.roots().len(), 4 + 3);
        for block in 0..tree.blocks() {
            let are_before = |(place, parts): (usize, [usize; 2])| parts.iter().all(|part| *part < place);
            assert!(tree.block(block).groups().all(are_before));
        }
        for surfel in 0..surfels {
            let (place, block) = tree.place_of(surfel);
            assert_eq!((tree.surfels()[place], tree.block_at(place)), (surfel as u32, block));
        }
        // From the top all surfels of the large tree are reached.
        let mut reached = 0;
        let mut left = vec![tree.len() - 1];
        while let Some(place) = left.pop() {
            match tree.parts_at(place) {
                Some(parts) => left.extend(parts),
                None => reached += 1,
            }
        }
        assert_eq!(reached, large);
    }

    #[test]
    fn groups_that_share_their_parts_do_no_harm() {
        let twice = [
            SurfelGroup { children: [0, 1], first_weight: 0.5 },
            SurfelGroup { children: [0, 2], first_weight: 0.5 },
        ];
        let tree = PatchTree::new(3, &twice);
        assert_eq!(tree.len(), 5);
        (0..5).for_each(|place| {
            tree.parts_at(place);
        });
        assert_eq!(PatchTree::new(0, &[]).blocks(), 0);
    }
}
