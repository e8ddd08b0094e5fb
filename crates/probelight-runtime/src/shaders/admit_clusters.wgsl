// Second part of stage 3, where something may wait: the clusters that are computed, the most urgent first.

@group(0) @binding(0) var<uniform> rules: WorkRules;
@group(0) @binding(1) var<storage, read> wishes: array<ClusterWish>;
@group(0) @binding(2) var<storage, read_write> held: array<ClusterExtent>;
@group(0) @binding(3) var<storage, read_write> states: array<Waiting>;
/// Words of work of each urgency.
@group(0) @binding(4) var<storage, read> words: array<u32, URGENCIES>;
/// What this frame computes.
@group(0) @binding(5) var<storage, read_write> extents: array<ClusterExtent>;

/// Which of what is urgent runs.
struct Admission {
    /// All of a higher urgency run.
    cutoff: u32,
    /// Of this urgency, so many words of work.
    words_left: u32,
    /// Of so many.
    words_there: u32,
}

fn admission() -> Admission {
    var left = rules.most_words;
    for (var cutoff = URGENCIES; cutoff > 0u; cutoff--) {
        let there = words[cutoff - 1u];
        if there > left {
            return Admission(cutoff - 1u, left, there);
        }
        left -= there;
    }
    return Admission(0u, 1u, 1u);
}

/// A number that looks random, from two.
fn scatter(index: u32, frames: u32) -> u32 {
    let mixed = ((index * 0x9e3779b9u) ^ (frames * 0x85ebca6bu)) * 0xc2b2ae35u;
    return mixed ^ (mixed >> 15u);
}

@compute @workgroup_size(64)
fn admit_clusters(@builtin(global_invocation_id) id: vec3u) {
    let cluster = id.x;
    if cluster >= arrayLength(&wishes) {
        return;
    }
    let wish = wishes[cluster];
    let waiting = states[cluster];
    let admission = admission();
    let is_lucky = scatter(cluster, waiting.frames) % admission.words_there < admission.words_left;
    let runs = waiting.urgency != NONE
        && (waiting.urgency > admission.cutoff || (waiting.urgency == admission.cutoff && is_lucky));
    if runs {
        extents[cluster] = wish.wanted;
    } else {
        extents[cluster] = ClusterExtent();
    }
    if runs || wish.wanted.receivers == 0u {
        held[cluster] = wish.wanted;
        states[cluster].change = 0.0;
        states[cluster].frames = 0u;
    }
}
