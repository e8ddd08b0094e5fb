// Last part of stage 2, where something may wait: the largest change of each band of the probes. A workgroup measures
// one probe.

@group(0) @binding(0) var<uniform> rules: WorkRules;
@group(0) @binding(1) var<storage, read> signals: array<f32>;
/// Those of the last frame.
@group(0) @binding(2) var<storage, read_write> last_signals: array<f32>;
/// What this frame computes.
@group(0) @binding(3) var<storage, read> probes: array<ProbeRecord>;
@group(0) @binding(4) var<storage, read_write> changes: array<f32>;

/// More bands than any probe has.
const MOST_BANDS: u32 = 12u;

/// Bits of the largest changes; those of positive numbers are in their order.
var<workgroup> largest: array<atomic<u32>, MOST_BANDS>;

@compute @workgroup_size(64)
fn measure_bands(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let probe = linear_workgroup(workgroup, workgroups);
    if probe >= arrayLength(&probes) {
        return;
    }
    let first = rules.scalar_signals + probe * rules.coefficients;
    for (var i = local; i < probes[probe].coefficients; i += 64u) {
        var change = 0.0;
        for (var at = 3u * (first + i); at < 3u * (first + i) + 3u; at++) {
            change = max(change, abs(signals[at] - last_signals[at]));
            last_signals[at] = signals[at];
        }
        // Band l starts at coefficient l².
        atomicMax(&largest[u32(sqrt(f32(i) + 0.5))], bitcast<u32>(change));
    }
    workgroupBarrier();
    if local < rules.bands {
        changes[rules.blocks + probe * rules.bands + local] = bitcast<f32>(atomicLoad(&largest[local]));
    }
}
