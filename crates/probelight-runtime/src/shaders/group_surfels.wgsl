// Stage 1, every frame in which a surfel is lit: radiance of the surfel groups, from small to large.
//
// The groups are sorted by level: a group needs nothing of its own level or above. `group_level` computes a wide
// level with many workgroups; `group_levels` all narrow levels above the wide ones, one after the other, with one
// workgroup, because a dispatch costs more than a narrow level.

struct GroupRecord {
    /// Signals of the two smaller patches.
    first: u32,
    second: u32,
    /// Share of the first in the area.
    first_weight: f32,
    /// Signal of the group.
    signal: u32,
}

struct Levels {
    /// First group of the first level.
    first_group: u32,
    /// Number of levels whose ends count.
    level_count: u32,
}

@group(0) @binding(0) var<storage, read> groups: array<GroupRecord>;
/// Index behind the last group of each level.
@group(0) @binding(1) var<storage, read> level_ends: array<u32>;
@group(0) @binding(2) var<uniform> levels: Levels;
@group(0) @binding(3) var<storage, read_write> signals: array<f32>;
@group(0) @binding(4) var<storage, read_write> flags: FrameFlags;

const WORKGROUP: u32 = 256u;

fn mix_patches(number: u32) {
    let group = groups[number];
    for (var channel = 0u; channel < 3u; channel++) {
        signals[3u * group.signal + channel] = group.first_weight * signals[3u * group.first + channel]
            + (1.0 - group.first_weight) * signals[3u * group.second + channel];
    }
}

@compute @workgroup_size(256)
fn group_level(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = levels.first_group + linear_workgroup(workgroup, workgroups) * WORKGROUP + local;
    if number < level_ends[0] && atomicLoad(&flags.any_dirty) != 0u {
        mix_patches(number);
    }
}

@compute @workgroup_size(256)
fn group_levels(@builtin(local_invocation_index) local: u32) {
    // Not a return: barriers are for all invocations, and browsers want to see that.
    let is_dirty = atomicLoad(&flags.any_dirty) != 0u;
    var first = levels.first_group;
    for (var level = 0u; level < levels.level_count; level++) {
        let end = level_ends[level];
        for (var number = first + local; is_dirty && number < end; number += WORKGROUP) {
            mix_patches(number);
        }
        first = end;
        storageBarrier();
    }
}
