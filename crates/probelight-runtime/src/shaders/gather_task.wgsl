// Receivers that one workgroup computes.

struct GatherTask {
    cluster: u32,
    /// First receiver, counted within the cluster; a multiple of BLOCK.
    first: u32,
}
