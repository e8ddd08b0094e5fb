// What is wanted of clusters.

struct ClusterWish {
    wanted: ClusterExtent,
    /// Words of matrices that this takes.
    words: u32,
    /// The largest change that may wait, as a share of the light.
    threshold: f32,
}
