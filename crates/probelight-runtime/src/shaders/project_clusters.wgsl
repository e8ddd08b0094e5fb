// Stage 3: each cluster's coefficients, b = (ΣVᵀ)·s of its signals ([SED] §3.3).
//
// A workgroup computes one cluster. Its scaled signals, up to TILE of them at a time, wait in workgroup memory in
// quads (four reds, four greens, four blues). LANES neighbouring invocations share four rows of the matrix and read
// neighbouring words: a quad of signals and four of matrix values make 48 products. In the end the lanes' sums are
// added up.
//
// A row has as many words as its stored columns need; a frame computes the leading rows and columns of the extent.

const WORKGROUP: u32 = 128u;
/// Invocations that share four rows.
const LANES: u32 = 16u;
/// Groups of four rows computed together.
const GROUPS: u32 = WORKGROUP / LANES;
/// Columns in workgroup memory.
const TILE: u32 = 1024u;
/// Steps of an exponent that halve a column's factor: `EXPONENT_STEPS` of the asset.
const EXPONENT_STEPS: u32 = 8u;

@group(0) @binding(0) var<storage, read> clusters: array<ClusterRecord>;
/// Number of the signal in each column.
@group(0) @binding(1) var<storage, read> column_signals: array<u32>;
/// Four exponents e to a word; a column's factor is 2^(−e/8).
@group(0) @binding(2) var<storage, read> column_exponents: array<u32>;
@group(0) @binding(3) var<storage, read> row_scales: array<f32>;
@group(0) @binding(4) var<storage, read> basis: array<u32>;
/// Scalar signals, then the probes' coefficients.
@group(0) @binding(5) var<storage, read> signals: array<f32>;
@group(0) @binding(6) var<storage, read_write> coefficients: array<f32>;
/// Of all clusters.
@group(0) @binding(7) var<storage, read> extents: array<ClusterExtent>;

/// Red, green and blue: of four columns each, then of four rows by each invocation.
var<workgroup> quads: array<array<vec4f, 3>, TILE / 4u>;

/// 2^(−e/8), with the whole power of two exact.
fn column_factor(exponent: u32) -> f32 {
    let halvings = bitcast<f32>((127u - exponent / EXPONENT_STEPS) << 23u);
    return halvings * exp2(f32(exponent % EXPONENT_STEPS) * (-1.0 / f32(EXPONENT_STEPS)));
}

/// The scaled signal of a column, zero behind the last that counts.
fn load_column(cluster: ClusterRecord, columns: u32, column: u32, exponent: u32) -> vec3f {
    if column >= columns {
        return vec3f(0.0);
    }
    let at = 3u * column_signals[cluster.first_column + column];
    return column_factor(exponent) * vec3f(signals[at], signals[at + 1u], signals[at + 2u]);
}

/// Four neighbouring columns: their reds, greens and blues.
fn load_quad(cluster: ClusterRecord, columns: u32, quad: u32) -> array<vec4f, 3> {
    let exponents = column_exponents[cluster.exponent_offset + quad];
    let a = load_column(cluster, columns, 4u * quad, exponents & 255u);
    let b = load_column(cluster, columns, 4u * quad + 1u, (exponents >> 8u) & 255u);
    let c = load_column(cluster, columns, 4u * quad + 2u, (exponents >> 16u) & 255u);
    let d = load_column(cluster, columns, 4u * quad + 3u, exponents >> 24u);
    return array<vec4f, 3>(
        vec4f(a.x, b.x, c.x, d.x),
        vec4f(a.y, b.y, c.y, d.y),
        vec4f(a.z, b.z, c.z, d.z),
    );
}

/// Four rows of one encoding; behind a section's last row, that row again.
struct RowGroup {
    encoding: u32,
    /// First row.
    first: u32,
    /// First words of the rows.
    starts: vec4u,
}

/// Number of groups of a section of rows.
fn group_count(rows: u32) -> u32 {
    return (rows + 3u) / 4u;
}

fn row_group(cluster: ClusterRecord, number: u32) -> RowGroup {
    let snorm8 = group_count(cluster.signal_ranks.f16);
    let snorm4 = snorm8 + group_count(cluster.signal_ranks.snorm8);
    var encoding = F16;
    var first = 4u * number;
    var end = cluster.signal_ranks.f16;
    if number >= snorm4 {
        encoding = SNORM4;
        first = 4u * (number - snorm4) + cluster.signal_ranks.f16 + cluster.signal_ranks.snorm8;
        end = rank(cluster.signal_ranks);
    } else if number >= snorm8 {
        encoding = SNORM8;
        first = 4u * (number - snorm8) + cluster.signal_ranks.f16;
        end = cluster.signal_ranks.f16 + cluster.signal_ranks.snorm8;
    }
    let stride = cluster.column_count;
    let words = line_words(encoding, stride);
    let start = cluster.signal_basis_offset + line_start(cluster.signal_ranks, first, stride);
    let ahead = min(vec4u(0u, 1u, 2u, 3u), vec4u(max(end, first + 1u) - 1u - first));
    return RowGroup(encoding, first, start + ahead * words);
}

/// Sums of four rows: red, green, blue.
struct Sums {
    red: vec4f,
    green: vec4f,
    blue: vec4f,
}

/// Adds the products of four rows with every LANES-th of the columns in workgroup memory.
fn add_products(sums: Sums, encoding: u32, starts: vec4u, words: u32, tile: u32, end: u32, lane: u32) -> Sums {
    var added = sums;
    for (var i = lane; i < end; i += LANES) {
        let quad = tile / 4u + i;
        let a = basis_quad(encoding, starts.x, words, quad);
        let b = basis_quad(encoding, starts.y, words, quad);
        let c = basis_quad(encoding, starts.z, words, quad);
        let d = basis_quad(encoding, starts.w, words, quad);
        let columns = quads[i];
        added.red += vec4f(dot(a, columns[0]), dot(b, columns[0]), dot(c, columns[0]), dot(d, columns[0]));
        added.green += vec4f(dot(a, columns[1]), dot(b, columns[1]), dot(c, columns[1]), dot(d, columns[1]));
        added.blue += vec4f(dot(a, columns[2]), dot(b, columns[2]), dot(c, columns[2]), dot(d, columns[2]));
    }
    return added;
}

@compute @workgroup_size(128)
fn project_clusters(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups);
    if number >= arrayLength(&clusters) {
        return;
    }
    var cluster = clusters[number];
    let extent = extents[cluster.number];
    cluster.signal_ranks = leading(cluster.signal_ranks, extent.rank);
    let ranks = cluster.signal_ranks;
    let stride = cluster.column_count;
    let groups = group_count(ranks.f16) + group_count(ranks.snorm8) + group_count(ranks.snorm4);
    let lane = local % LANES;
    for (var first_group = 0u; first_group < groups; first_group += GROUPS) {
        let is_group = first_group + local / LANES < groups;
        let group = row_group(cluster, first_group + local / LANES);
        var sums = Sums();
        for (var tile = 0u; tile < extent.columns; tile += TILE) {
            let quad_count = (min(TILE, extent.columns - tile) + 3u) / 4u;
            workgroupBarrier();
            for (var quad = local; quad < quad_count; quad += WORKGROUP) {
                quads[quad] = load_quad(cluster, extent.columns, tile / 4u + quad);
            }
            workgroupBarrier();
            let end = select(0u, quad_count, is_group);
            // Each loop decodes one encoding and nothing else.
            if group.encoding == F16 {
                sums = add_products(sums, F16, group.starts, line_words(F16, stride), tile, end, lane);
            } else if group.encoding == SNORM8 {
                sums = add_products(sums, SNORM8, group.starts, line_words(SNORM8, stride), tile, end, lane);
            } else {
                sums = add_products(sums, SNORM4, group.starts, line_words(SNORM4, stride), tile, end, lane);
            }
        }
        workgroupBarrier();
        quads[local] = array<vec4f, 3>(sums.red, sums.green, sums.blue);
        workgroupBarrier();
        store_coefficients(cluster, extent, first_group, local);
    }
}

/// Adds up what the invocations summed: three channels of four rows for each group.
fn store_coefficients(cluster: ClusterRecord, extent: ClusterExtent, first_group: u32, local: u32) {
    let slot = local / 12u;
    let channel = local % 3u;
    let ahead = local / 3u % 4u;
    if slot >= GROUPS {
        return;
    }
    let group = row_group(cluster, first_group + slot);
    let row = group.first + ahead;
    // Rows that only fill a group are not stored: their section ends before them.
    if row >= rank(cluster.signal_ranks) || row_encoding(cluster.signal_ranks, row) != group.encoding {
        return;
    }
    var sum = 0.0;
    for (var i = 0u; i < LANES; i++) {
        sum += quads[slot * LANES + i][channel][ahead];
    }
    let b_row = cluster.first_row + row;
    let weight = select(f32(extent.fade) / f32(FADE_STEPS), 1.0, row < extent.solid);
    coefficients[3u * b_row + channel] = sum * (row_scales[b_row] * weight);
}
