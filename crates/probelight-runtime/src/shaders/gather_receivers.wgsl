// Stage 4: irradiance at every receiver, E = U·b ([SED] eq. 6), and its way into the lightmap; beside the borders between
// clusters, blend_borders has the last word.
//
// A workgroup computes up to BLOCK receivers of one cluster, an invocation four of them: a quad of each column of
// U. The results go by way of workgroup memory, so that neighbouring invocations write neighbouring numbers.
//
// A column has as many words as the stored receivers need; a frame computes the leading receivers and columns of the
// extent.

const WORKGROUP: u32 = 64u;
/// Receivers of a workgroup.
const BLOCK: u32 = 4u * WORKGROUP;

@group(0) @binding(0) var<storage, read> clusters: array<ClusterRecord>;
@group(0) @binding(1) var<storage, read> tasks: array<GatherTask>;
@group(0) @binding(2) var<storage, read> basis: array<u32>;
@group(0) @binding(3) var<storage, read> coefficients: array<f32>;
/// Lightmap texel of each of the shard's receivers; NONE for those of the grid.
@group(0) @binding(4) var<storage, read> receiver_texels: array<u32>;
/// Irradiance of all receivers, W/m².
@group(0) @binding(5) var<storage, read_write> irradiance: array<f32>;
@group(0) @binding(6) var lightmap: texture_storage_2d<rgba16float, write>;
/// Of all clusters.
@group(0) @binding(7) var<storage, read> extents: array<ClusterExtent>;

var<workgroup> rows: array<vec3f, WORKGROUP>;
var<workgroup> results: array<array<f32, 3>, BLOCK>;

/// Three channels of four receivers.
struct Sums {
    red: vec4f,
    green: vec4f,
    blue: vec4f,
}

/// Adds one column, or a quad of it, times b.
fn add_column(sums: Sums, values: vec4f, b: vec3f) -> Sums {
    return Sums(sums.red + values * b.x, sums.green + values * b.y, sums.blue + values * b.z);
}

/// Adds columns `first` to `end` of U, all of one encoding, to the sums of a quad; b is in `rows`, from row `tile` on.
fn add_columns(sums: Sums, cluster: ClusterRecord, encoding: u32, first: u32, end: u32, tile: u32, quad: u32) -> Sums {
    var added = sums;
    let words = line_words(encoding, cluster.receiver_count);
    var line = cluster.receiver_basis_offset + line_start(cluster.receiver_ranks, first, cluster.receiver_count);
    var row = first;
    // Four at a time, so that their loads are under way together.
    for (; row + 4u <= end; row += 4u) {
        let u = basis_quad(encoding, line, words, quad);
        let v = basis_quad(encoding, line + words, words, quad);
        let w = basis_quad(encoding, line + 2u * words, words, quad);
        let x = basis_quad(encoding, line + 3u * words, words, quad);
        added = add_column(added, u, rows[row - tile]);
        added = add_column(added, v, rows[row - tile + 1u]);
        added = add_column(added, w, rows[row - tile + 2u]);
        added = add_column(added, x, rows[row - tile + 3u]);
        line += 4u * words;
    }
    for (; row < end; row++) {
        added = add_column(added, basis_quad(encoding, line, words, quad), rows[row - tile]);
        line += words;
    }
    return added;
}

@compute @workgroup_size(64)
fn gather_receivers(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups);
    if number >= arrayLength(&tasks) {
        return;
    }
    let first = tasks[number].first;
    let cluster = clusters[tasks[number].cluster];
    let extent = extents[cluster.number];
    if first >= extent.receivers {
        return;
    }
    let quad = first / 4u + local;
    let ranks = leading(cluster.receiver_ranks, extent.rank);
    let rank = rank(ranks);
    var sums = Sums();
    for (var tile = 0u; tile < rank; tile += WORKGROUP) {
        let end = min(tile + WORKGROUP, rank);
        workgroupBarrier();
        if tile + local < end {
            let at = 3u * (cluster.first_row + tile + local);
            rows[local] = vec3f(coefficients[at], coefficients[at + 1u], coefficients[at + 2u]);
        }
        workgroupBarrier();
        if 4u * quad < extent.receivers {
            let snorm8 = clamp(ranks.f16, tile, end);
            let snorm4 = clamp(ranks.f16 + ranks.snorm8, tile, end);
            sums = add_columns(sums, cluster, F16, tile, snorm8, tile, quad);
            sums = add_columns(sums, cluster, SNORM8, snorm8, snorm4, tile, quad);
            sums = add_columns(sums, cluster, SNORM4, snorm4, end, tile, quad);
        }
    }
    for (var i = 0u; i < 4u; i++) {
        results[4u * local + i] = array<f32, 3>(sums.red[i], sums.green[i], sums.blue[i]);
    }
    workgroupBarrier();
    let receivers = min(BLOCK, extent.receivers - first);
    for (var i = local; i < 3u * receivers; i += WORKGROUP) {
        irradiance[3u * (cluster.first_receiver + first) + i] = results[i / 3u][i % 3u];
    }
    for (var i = local; i < receivers; i += WORKGROUP) {
        let texel = receiver_texels[cluster.first_texel + first + i];
        let value = vec3f(results[i][0], results[i][1], results[i][2]);
        if texel != NONE {
            store_texel(texel, value);
        }
    }
}
