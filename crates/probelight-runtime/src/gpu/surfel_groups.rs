//! Surfel groups, sorted so that all of a level can be computed at once.

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

use probelight_asset::BakedScene;

use super::device::GpuError;
use super::frame_buffers::FrameBuffers;
use super::kernel::{Kernel, whole};
use super::stage_shaders::{GROUP_LEVEL, GROUP_LEVELS};
use super::storage::Storage;

/// Invocations of a workgroup of `group_surfels`: `WORKGROUP` in its shader.
pub(super) const WORKGROUP: usize = 256;

/// Levels with more groups than this get a dispatch of their own; narrower ones share one workgroup.
const WIDE: usize = 4 * WORKGROUP;

/// One surfel group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct GroupRecord {
    /// Signal of the first patch.
    pub(super) first: u32,
    /// Signal of the second.
    pub(super) second: u32,
    /// Share of the first in the area.
    pub(super) first_weight: f32,
    /// Signal of the group.
    pub(super) signal: u32,
}

/// Which levels a dispatch computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Levels {
    /// First group of the first level.
    pub(super) first_group: u32,
    /// Number of levels whose ends count.
    pub(super) level_count: u32,
}

/// Radiance of all surfel groups.
#[derive(Debug)]
pub(super) struct SurfelGroups {
    wide: Kernel,
    narrow: Kernel,
    dispatches: Vec<Dispatch>,
    records: wgpu::Buffer,
}

#[derive(Debug)]
struct Dispatch {
    group: wgpu::BindGroup,
    /// `None`: narrow levels.
    wide_groups: Option<usize>,
}

impl SurfelGroups {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let device = storage.device;
        let (wide, narrow) =
            (Kernel::new(device, &GROUP_LEVEL, None), Kernel::new(device, &GROUP_LEVELS, None));
        let (records, ends) = sort_by_level(baked);
        let records = storage.array("surfel groups", &records)?;
        let mut dispatches = Vec::new();
        for levels in divide_levels(&ends) {
            let start = levels.start.checked_sub(1).map_or(0, |before| ends[before]);
            let is_wide = ends[levels.start] - start > WIDE;
            let level_ends: Vec<u32> = ends[levels.clone()].iter().map(|end| *end as u32).collect();
            let record = Levels { first_group: start as u32, level_count: levels.len() as u32 };
            let level_ends = storage.array("level ends", &level_ends)?;
            let record = storage.uniform("levels", &record);
            let resources = whole(&[&records, &level_ends, &record, &buffers.signals, &buffers.work.flags]);
            let kernel = if is_wide { &wide } else { &narrow };
            dispatches.push(Dispatch {
                group: kernel.bind(device, 0, &resources),
                wide_groups: is_wide.then(|| ends[levels.start] - start),
            });
        }
        Ok(Self { wide, narrow, dispatches, records })
    }

    /// What a frame reads, bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.records.size()
    }

    pub(super) fn run(&self, pass: &mut wgpu::ComputePass) {
        for dispatch in &self.dispatches {
            match dispatch.wide_groups {
                Some(groups) => self.wide.run(pass, &[&dispatch.group], groups.div_ceil(WORKGROUP)),
                None => self.narrow.run(pass, &[&dispatch.group], 1),
            }
        }
    }
}

/// The groups, those that need no other group first; and the index behind each level's last.
fn sort_by_level(baked: &BakedScene) -> (Vec<GroupRecord>, Vec<usize>) {
    let surfels = baked.surfels.len();
    let mut levels: Vec<usize> = Vec::with_capacity(baked.surfel_groups.len());
    for group in &baked.surfel_groups {
        let above = |child: u32| (child as usize).checked_sub(surfels).map_or(0, |group| levels[group] + 1);
        levels.push(above(group.children[0]).max(above(group.children[1])));
    }
    let mut order: Vec<usize> = (0..levels.len()).collect();
    order.sort_by_key(|group| levels[*group]);
    let record = |number: &usize| {
        let group = baked.surfel_groups[*number];
        let [first, second] = group.children;
        GroupRecord { first, second, first_weight: group.first_weight, signal: (surfels + number) as u32 }
    };
    let mut ends = Vec::new();
    for run in order.chunk_by(|a, b| levels[*a] == levels[*b]) {
        ends.push(ends.last().unwrap_or(&0) + run.len());
    }
    (order.iter().map(record).collect(), ends)
}

/// Ranges of levels that one dispatch computes: each wide level by itself, narrow neighbours together.
fn divide_levels(ends: &[usize]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    let mut was_narrow = false;
    for (level, end) in ends.iter().enumerate() {
        let is_narrow = end - start <= WIDE;
        match ranges.last_mut() {
            Some(last) if was_narrow && is_narrow => last.end = level + 1,
            _ => ranges.push(level..level + 1),
        }
        (start, was_narrow) = (*end, is_narrow);
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_levels_share_a_dispatch() {
        let ends = [5000, 7500, 8500, 9000, 11_000, 11_001];
        assert_eq!(divide_levels(&ends), [0..1, 1..2, 2..4, 4..5, 5..6]);
        assert!(divide_levels(&[]).is_empty());
    }
}
