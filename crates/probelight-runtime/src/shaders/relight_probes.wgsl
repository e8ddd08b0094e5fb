// Stage 2: the probes' radiance as spherical-harmonics coefficients ([SED] eq. 2).
//
// All probes share their directions, so the projection is one matrix product λ = L·(w·Y). A workgroup multiplies
// the rays of PROBES probes with up to PANEL coefficients of the table. An invocation sums one coefficient over a
// part of the rays; the parts are added up at the end.

const WORKGROUP: u32 = 256u;
/// Probes of a workgroup, so that each value of the table is read once for all of them.
const PROBES: u32 = 2u;
/// Most coefficients of a workgroup.
const PANEL: u32 = 64u;
/// Rays whose radiance is in workgroup memory: one for each invocation.
const TILE: u32 = WORKGROUP;

@group(0) @binding(0) var<uniform> shape: SignalShape;
/// The surfel that each ray meets, or NONE for the sky; a probe's rays in a row.
@group(0) @binding(1) var<storage, read> relight_surfels: array<u32>;
/// Radiance of the sky along each direction.
@group(0) @binding(2) var<storage, read> sky: array<f32>;
/// Weighted basis values, a direction's in a row.
@group(0) @binding(3) var<storage, read> weighted_basis: array<f32>;
/// Scalar signals, then the probes' coefficients.
@group(0) @binding(4) var<storage, read_write> signals: array<f32>;

/// Radiance of a tile of rays, and in the end the sums of each invocation.
var<workgroup> shared_rows: array<array<vec3f, WORKGROUP>, PROBES>;

fn look(probe: u32, ray: u32) -> vec3f {
    if probe >= shape.probes || ray >= shape.rays {
        return vec3f(0.0);
    }
    let surfel = relight_surfels[probe * shape.rays + ray];
    if surfel == NONE {
        return vec3f(sky[3u * ray], sky[3u * ray + 1u], sky[3u * ray + 2u]);
    }
    return vec3f(signals[3u * surfel], signals[3u * surfel + 1u], signals[3u * surfel + 2u]);
}

@compute @workgroup_size(256)
fn relight_probes(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let panels = (shape.coefficients + PANEL - 1u) / PANEL;
    let task = linear_workgroup(workgroup, workgroups);
    let first_probe = task / panels * PROBES;
    let first_coefficient = task % panels * PANEL;
    let width = min(PANEL, shape.coefficients - min(first_coefficient, shape.coefficients));
    let parts = WORKGROUP / max(width, 1u);
    let coefficient = first_coefficient + local % max(width, 1u);
    let part = local / max(width, 1u);
    var sums = array<vec3f, PROBES>();
    for (var tile = 0u; tile < shape.rays; tile += TILE) {
        for (var probe = 0u; probe < PROBES; probe++) {
            shared_rows[probe][local] = look(first_probe + probe, tile + local);
        }
        workgroupBarrier();
        if part < parts {
            for (var ray = part; ray < min(TILE, shape.rays - tile); ray += parts) {
                let basis = weighted_basis[(tile + ray) * shape.coefficients + coefficient];
                for (var probe = 0u; probe < PROBES; probe++) {
                    sums[probe] += basis * shared_rows[probe][ray];
                }
            }
        }
        workgroupBarrier();
    }
    for (var probe = 0u; probe < PROBES; probe++) {
        shared_rows[probe][local] = sums[probe];
    }
    workgroupBarrier();
    for (var probe = 0u; probe < PROBES; probe++) {
        if local < width && first_probe + probe < shape.probes {
            var sum = vec3f(0.0);
            for (var i = local; i < width * parts; i += width) {
                sum += shared_rows[probe][i];
            }
            let at = 3u * (shape.scalar_signals + (first_probe + probe) * shape.coefficients + coefficient);
            signals[at] = sum.x;
            signals[at + 1u] = sum.y;
            signals[at + 2u] = sum.z;
        }
    }
}
