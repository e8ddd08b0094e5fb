// First part of stage 2, where something may wait: the probes that are relit.

@group(0) @binding(0) var<uniform> rules: WorkRules;
/// What is wanted of each probe, with the largest change that may wait.
@group(0) @binding(1) var<storage, read> wishes: array<ProbeWish>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> terms: array<ChangeTerm>;
@group(0) @binding(4) var<storage, read> changes: array<f32>;
@group(0) @binding(5) var<storage, read> signals: array<f32>;
@group(0) @binding(6) var<storage, read_write> states: array<ProbeState>;
/// What this frame computes.
@group(0) @binding(7) var<storage, read_write> probes: array<ProbeRecord>;

struct ProbeWish {
    wanted: ProbeRecord,
    threshold: f32,
}

struct ProbeState {
    /// What was last computed.
    held: ProbeRecord,
    waiting: Waiting,
}

/// First basis function, which is constant.
const Y00: f32 = 0.28209479;

@compute @workgroup_size(64)
fn choose_probes(@builtin(global_invocation_id) id: vec3u) {
    let probe = id.x;
    if probe >= arrayLength(&wishes) {
        return;
    }
    let wish = wishes[probe];
    let state = states[probe];
    var waiting = state.waiting;
    for (var i = starts[probe]; i < starts[probe + 1u]; i++) {
        waiting.change += terms[i].weight * changes[terms[i].source];
    }
    waiting.frames += 1u;
    let at = 3u * (rules.scalar_signals + probe * rules.coefficients);
    waiting.light = max(max(max(signals[at], signals[at + 1u]), signals[at + 2u]) * Y00, 0.0);
    let held = state.held;
    let is_new = held.rays != wish.wanted.rays || held.coefficients != wish.wanted.coefficients;
    let has_changed = urgency(waiting, is_new, PROBES_SHARE * wish.threshold, rules.longest_wait) != NONE;
    if has_changed && (is_new || is_turn_of(probe, rules)) {
        probes[probe] = wish.wanted;
        states[probe] = ProbeState(wish.wanted, Waiting());
    } else {
        probes[probe] = ProbeRecord();
        states[probe].waiting = waiting;
    }
}
