// Last part of stage 1, where something may wait: the largest change of each block of scalar signals. A workgroup
// measures one block.

@group(0) @binding(0) var<uniform> rules: WorkRules;
@group(0) @binding(1) var<storage, read> signals: array<f32>;
/// Those of the last frame.
@group(0) @binding(2) var<storage, read_write> last_signals: array<f32>;
@group(0) @binding(3) var<storage, read> dirty: array<u32>;
@group(0) @binding(4) var<storage, read_write> flags: FrameFlags;
@group(0) @binding(5) var<storage, read_write> changes: array<f32>;

/// Bits of the largest change; those of positive numbers are in their order.
var<workgroup> largest: atomic<u32>;

@compute @workgroup_size(64)
fn measure_signals(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let block = linear_workgroup(workgroup, workgroups);
    if block >= rules.blocks {
        return;
    }
    let end = (block + 1u) * SOURCE_SIGNALS;
    let has_groups = end > rules.surfels && atomicLoad(&flags.any_dirty) != 0u;
    let number = block * SOURCE_SIGNALS + local;
    if (dirty[block] != 0u || has_groups || end > rules.first_emitter) && number < rules.scalar_signals {
        var change = 0.0;
        for (var at = 3u * number; at < 3u * number + 3u; at++) {
            change = max(change, abs(signals[at] - last_signals[at]));
            last_signals[at] = signals[at];
        }
        atomicMax(&largest, bitcast<u32>(change));
    }
    workgroupBarrier();
    if local == 0u {
        changes[block] = bitcast<f32>(atomicLoad(&largest));
    }
}
