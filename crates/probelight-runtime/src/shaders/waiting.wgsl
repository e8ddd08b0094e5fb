// What waits of clusters and probes, and when it is computed; the twin of `frame::waiting`.

/// Levels of urgency; four for each doubling of the change.
const URGENCIES: u32 = 64u;
/// Steps of a doubling, as a power of two.
const URGENCY_STEP_BITS: u32 = 2u;
/// Share of the largest change that may wait below which nothing is computed however long it waits.
const NEXT_TO_NOTHING: f32 = 0.015625;
/// Neighbouring probes that have their turn together.
const PROBES_A_TURN: u32 = 8u;
/// What probes may leave waiting, as a share of what clusters may.
const PROBES_SHARE: f32 = 0.25;

struct Waiting {
    /// Bound of what its light changed since it was last computed.
    change: f32,
    /// Its light when it was last computed.
    light: f32,
    /// Frames since then.
    frames: u32,
    /// How urgent it is in this frame, or NONE.
    urgency: u32,
}

/// How much a source's change counts.
struct ChangeTerm {
    source: u32,
    weight: f32,
}

/// The rules of a frame, and how many there are of everything.
struct WorkRules {
    /// Frames after which even a small change is computed.
    longest_wait: u32,
    /// Most words of matrices.
    most_words: u32,
    /// Surfels, which are the first signals.
    surfels: u32,
    /// First signal that is neither a surfel's nor a group's.
    first_emitter: u32,
    scalar_signals: u32,
    /// Sources of scalar signals; those of the probes' bands follow.
    blocks: u32,
    /// Bands of a probe.
    bands: u32,
    /// Coefficients of a probe.
    coefficients: u32,
    /// Whose turn it is of the probes, and how many frames they have for their turns.
    probe_turn: u32,
    probe_turns: u32,
}

/// Whether it is a probe's turn to be relit.
fn is_turn_of(probe: u32, rules: WorkRules) -> bool {
    return (probe / PROBES_A_TURN + rules.probe_turn) % rules.probe_turns == 0u;
}

fn urgency(waiting: Waiting, is_new: bool, threshold: f32, longest_wait: u32) -> u32 {
    let allowed = threshold * waiting.light;
    let is_overdue = waiting.frames >= longest_wait && waiting.change > NEXT_TO_NOTHING * allowed;
    if is_new || threshold == 0.0 || is_overdue {
        return URGENCIES - 1u;
    }
    if waiting.change <= allowed {
        return NONE;
    }
    if allowed <= 0.0 {
        return URGENCIES - 2u;
    }
    let steps = (bitcast<u32>(waiting.change / allowed) >> (23u - URGENCY_STEP_BITS)) - (127u << URGENCY_STEP_BITS);
    return min(steps, URGENCIES - 2u);
}
