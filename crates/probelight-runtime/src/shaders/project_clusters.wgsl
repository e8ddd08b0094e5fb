// Stage 3: each cluster's coefficients, b = (ΣVᵀ)·s of its signals ([SED] §3.3).
//
// A workgroup computes one cluster. Its scaled signals, up to TILE of them at a time, wait in workgroup memory in
// quads (four reds, four greens, four blues), so that a quad of matrix values needs three dot products. LANES
// neighbouring invocations share a row of the matrix and read neighbouring words.

const WORKGROUP: u32 = 256u;
/// Invocations that share a row.
const LANES: u32 = 8u;
/// Rows computed together.
const ROWS: u32 = WORKGROUP / LANES;
/// Columns in workgroup memory.
const TILE: u32 = 1024u;

@group(0) @binding(0) var<uniform> shape: SignalShape;
@group(0) @binding(1) var<storage, read> clusters: array<ClusterRecord>;
@group(0) @binding(2) var<storage, read> cluster_inputs: array<u32>;
/// Four exponents e to a word; a column's factor is 2^(−e/8).
@group(0) @binding(3) var<storage, read> column_exponents: array<u32>;
@group(0) @binding(4) var<storage, read> row_scales: array<f32>;
@group(0) @binding(5) var<storage, read> basis: array<u32>;
/// Scalar signals, then the probes' coefficients.
@group(0) @binding(6) var<storage, read> signals: array<f32>;
@group(0) @binding(7) var<storage, read_write> coefficients: array<f32>;

var<workgroup> columns: array<array<vec4f, 3>, TILE / 4u>;
var<workgroup> partial: array<array<f32, 3>, WORKGROUP>;

/// Number of the signal in a column. Behind the scalar signals come the probes' coefficients, band by band.
fn signal_of_column(cluster: ClusterRecord, column: u32) -> u32 {
    if column < cluster.signal_count {
        return cluster_inputs[cluster.first_input + column];
    }
    let behind = column - cluster.signal_count;
    // The half keeps rounding away from whole numbers.
    let band = u32(sqrt(f32(behind / cluster.probe_count) + 0.5));
    let within = behind - cluster.probe_count * band * band;
    let order = within % (2u * band + 1u);
    let probe = cluster_inputs[cluster.first_input + cluster.signal_count + within / (2u * band + 1u)];
    return shape.scalar_signals + probe * shape.coefficients + band * band + order;
}

/// 2^(−e/8), with the whole power of two exact.
fn column_factor(exponent: u32) -> f32 {
    return bitcast<f32>((127u - (exponent >> 3u)) << 23u) * exp2(f32(exponent & 7u) * -0.125);
}

/// The scaled signals of four columns, zero behind the last.
fn load_columns(cluster: ClusterRecord, quad: u32, count: u32) -> array<vec4f, 3> {
    let exponents = column_exponents[cluster.exponent_offset + quad];
    var loaded = array<vec4f, 3>();
    for (var i = 0u; i < 4u; i++) {
        if 4u * quad + i < count {
            let at = 3u * signal_of_column(cluster, 4u * quad + i);
            let factor = column_factor((exponents >> (8u * i)) & 255u);
            loaded[0][i] = factor * signals[at];
            loaded[1][i] = factor * signals[at + 1u];
            loaded[2][i] = factor * signals[at + 2u];
        }
    }
    return loaded;
}

@compute @workgroup_size(256)
fn project_clusters(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = linear_workgroup(workgroup, workgroups);
    if number >= arrayLength(&clusters) {
        return;
    }
    let cluster = clusters[number];
    let rank = rank(cluster);
    let count = cluster.signal_count + cluster.probe_count * shape.coefficients;
    let lane = local % LANES;
    for (var first_row = 0u; first_row < rank; first_row += ROWS) {
        let row = first_row + local / LANES;
        let encoding = row_encoding(cluster, row);
        let words = line_words(encoding, count);
        let start = cluster.signal_basis_offset + line_start(cluster, row, count);
        var sums = vec3f(0.0);
        for (var tile = 0u; tile < count; tile += TILE) {
            let quads = (min(TILE, count - tile) + 3u) / 4u;
            // One tile is enough for most clusters, and stays for all their rows.
            if first_row == 0u || count > TILE {
                workgroupBarrier();
                for (var quad = local; quad < quads; quad += WORKGROUP) {
                    columns[quad] = load_columns(cluster, tile / 4u + quad, count);
                }
                workgroupBarrier();
            }
            if row < rank {
                for (var quad = lane; quad < quads; quad += LANES) {
                    let values = basis_quad(encoding, start, words, tile / 4u + quad);
                    sums.x += dot(values, columns[quad][0]);
                    sums.y += dot(values, columns[quad][1]);
                    sums.z += dot(values, columns[quad][2]);
                }
            }
        }
        workgroupBarrier();
        partial[local] = array<f32, 3>(sums.x, sums.y, sums.z);
        workgroupBarrier();
        let rows = min(ROWS, rank - first_row);
        if local < 3u * rows {
            var sum = 0.0;
            for (var i = 0u; i < LANES; i++) {
                sum += partial[local / 3u * LANES + i][local % 3u];
            }
            let target_row = cluster.first_row + first_row + local / 3u;
            coefficients[3u * target_row + local % 3u] = sum * row_scales[target_row];
        }
    }
}
