// How the signals are laid out: first the scalar ones, then the coefficients of all probes, RGB each.

struct SignalShape {
    scalar_signals: u32,
    /// Per probe.
    coefficients: u32,
    /// Per probe.
    rays: u32,
    probes: u32,
}
