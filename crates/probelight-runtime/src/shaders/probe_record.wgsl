// How much of a probe a frame computes.

/// What a frame computes of a probe.
struct ProbeRecord {
    /// Leading rays; with none, nothing is computed.
    rays: u32,
    /// Leading coefficients.
    coefficients: u32,
    /// First of the weights of so many rays.
    first_weight: u32,
}
