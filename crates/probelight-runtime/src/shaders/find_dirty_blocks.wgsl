// First part of stage 1, where something may wait: the blocks of surfels that reflect what the last frame computed.

@group(0) @binding(0) var<uniform> rules: WorkRules;
/// Where each block's clusters begin, and where the last one's end.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
/// The clusters whose light the blocks' surfels reflect.
@group(0) @binding(2) var<storage, read> reflected: array<u32>;
/// Whether a cluster's receivers changed in the last frame.
@group(0) @binding(3) var<storage, read> touched: array<u32>;
@group(0) @binding(4) var<storage, read_write> flags: FrameFlags;
@group(0) @binding(5) var<storage, read_write> dirty: array<u32>;

@compute @workgroup_size(64)
fn find_dirty_blocks(@builtin(global_invocation_id) id: vec3u) {
    let block = id.x;
    if block >= arrayLength(&dirty) {
        return;
    }
    var is_dirty = flags.is_quiet == 0u;
    for (var i = starts[block]; i < starts[block + 1u] && !is_dirty; i++) {
        is_dirty = touched[reflected[i]] != 0u;
    }
    // Blocks behind the last surfel hold nothing to light.
    is_dirty = is_dirty && block * SOURCE_SIGNALS < rules.surfels;
    dirty[block] = select(0u, 1u, is_dirty);
    if is_dirty {
        atomicStore(&flags.any_dirty, 1u);
    }
}
