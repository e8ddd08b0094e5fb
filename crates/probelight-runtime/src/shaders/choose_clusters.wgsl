// First part of stage 3, where something may wait: how urgent each cluster is, and how much work there is of each urgency.

@group(0) @binding(0) var<uniform> rules: WorkRules;
@group(0) @binding(1) var<storage, read> wishes: array<ClusterWish>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> terms: array<ChangeTerm>;
@group(0) @binding(4) var<storage, read> changes: array<f32>;
/// What of each cluster was last computed.
@group(0) @binding(5) var<storage, read> held: array<ClusterExtent>;
@group(0) @binding(6) var<storage, read_write> states: array<Waiting>;
/// Words of work of each urgency.
@group(0) @binding(7) var<storage, read_write> words: array<atomic<u32>, URGENCIES>;

@compute @workgroup_size(64)
fn choose_clusters(@builtin(global_invocation_id) id: vec3u) {
    let cluster = id.x;
    if cluster >= arrayLength(&wishes) {
        return;
    }
    let wish = wishes[cluster];
    var waiting = states[cluster];
    for (var i = starts[cluster]; i < starts[cluster + 1u]; i++) {
        waiting.change += terms[i].weight * changes[terms[i].source];
    }
    waiting.frames += 1u;
    let last = held[cluster];
    let wanted = wish.wanted;
    let is_new = last.rank != wanted.rank || last.columns != wanted.columns || last.receivers != wanted.receivers
        || last.solid != wanted.solid || last.fade != wanted.fade || last.fill != wanted.fill;
    waiting.urgency = NONE;
    if wanted.receivers > 0u {
        waiting.urgency = urgency(waiting, is_new, wish.threshold, rules.longest_wait);
    }
    states[cluster] = waiting;
    if waiting.urgency != NONE {
        atomicAdd(&words[waiting.urgency], wish.words);
    }
}
