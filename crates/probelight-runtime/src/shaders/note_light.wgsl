// Last part of stage 3, where something may wait: how bright the clusters are that were computed.

@group(0) @binding(0) var<storage, read> clusters: array<ClusterRecord>;
/// Of each of the shard's rows of b, the root mean square of the irradiance that 1 there brings.
@group(0) @binding(1) var<storage, read> row_strengths: array<f32>;
@group(0) @binding(2) var<storage, read> coefficients: array<f32>;
@group(0) @binding(3) var<storage, read> extents: array<ClusterExtent>;
@group(0) @binding(4) var<storage, read_write> states: array<Waiting>;

@compute @workgroup_size(64)
fn note_light(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&clusters) {
        return;
    }
    let number = clusters[id.x].number;
    if extents[number].receivers == 0u {
        return;
    }
    var square = 0.0;
    let first = clusters[id.x].first_row;
    for (var row = first; row < first + extents[number].rank; row++) {
        let b = vec3f(coefficients[3u * row], coefficients[3u * row + 1u], coefficients[3u * row + 2u]);
        square += dot(b, b) * row_strengths[row] * row_strengths[row];
    }
    states[number].light = sqrt(square / 3.0);
}
