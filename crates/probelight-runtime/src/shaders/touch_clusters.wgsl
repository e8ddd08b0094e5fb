// Third part of stage 3, where something may wait: the clusters whose receivers change, because they are computed or blend
// with one that is.

@group(0) @binding(0) var<storage, read> starts: array<u32>;
/// Of each cluster, the others whose light its receivers blend with.
@group(0) @binding(1) var<storage, read> neighbors: array<u32>;
/// What this frame computes.
@group(0) @binding(2) var<storage, read> extents: array<ClusterExtent>;
@group(0) @binding(3) var<storage, read_write> touched: array<u32>;
@group(0) @binding(4) var<storage, read_write> flags: FrameFlags;

@compute @workgroup_size(64)
fn touch_clusters(@builtin(global_invocation_id) id: vec3u) {
    let cluster = id.x;
    if cluster == 0u {
        flags.is_quiet = 1u;
    }
    if cluster >= arrayLength(&extents) {
        return;
    }
    var is_touched = extents[cluster].receivers > 0u;
    for (var i = starts[cluster]; i < starts[cluster + 1u]; i++) {
        is_touched = is_touched || extents[neighbors[i]].receivers > 0u;
    }
    touched[cluster] = select(0u, 1u, is_touched);
    if is_touched {
        atomicStore(&flags.any_touched, 1u);
    }
}
