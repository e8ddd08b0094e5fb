// What was lit in a frame.

/// What the kernels of a frame tell each other; zero makes a frame light everything.
struct FrameFlags {
    /// Whether surfels shine as in the last frame, but for what they reflect.
    is_quiet: u32,
    /// Whether any surfel is lit.
    any_dirty: atomic<u32>,
    /// Whether the light of any receiver changes.
    any_touched: atomic<u32>,
}
