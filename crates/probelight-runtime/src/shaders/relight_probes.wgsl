// Stage 2: the probes' radiance as spherical-harmonics coefficients ([SED] eq. 2).
//
// All probes share their directions, so the projection is one matrix product λ = L·(w·Y). A workgroup multiplies
// the rays of four probes with a panel of the table. An invocation sums four coefficients of all four probes over a
// part of the rays: 48 products for 16 numbers read. The parts are added up at the end.
//
// Tables are as wide as what is stored; a frame computes the leading rays and coefficients of each probe's extent. Shorter
// prefixes of the rays have quadrature weights of their own.

const WORKGROUP: u32 = 256u;
/// A gain of one: `GAIN_STEPS` of the asset.
const GAIN_STEPS: f32 = 128.0;
/// Probes of a workgroup.
const PROBES: u32 = 4u;
/// Most quads of coefficients of a workgroup.
const PANEL: u32 = 16u;

@group(0) @binding(0) var<uniform> shape: SignalShape;
/// The surfel that each ray meets, or NONE for the sky; a probe's rays in a row.
@group(0) @binding(1) var<storage, read> relight_surfels: array<u32>;
/// How much the light of each of these rays counts: a byte each, four in a word.
@group(0) @binding(2) var<storage, read> relight_gains: array<u32>;
/// Radiance of the sky along each direction.
@group(0) @binding(3) var<storage, read> sky: array<f32>;
/// Weighted basis values in quads, a direction's in a row.
@group(0) @binding(4) var<storage, read> weighted_basis: array<vec4f>;
/// Scalar signals, then the probes' coefficients.
@group(0) @binding(5) var<storage, read_write> signals: array<f32>;
@group(0) @binding(6) var<storage, read> probes: array<ProbeRecord>;
/// For each prefix of the rays, by which factor their weights differ from those in the table.
@group(0) @binding(7) var<storage, read> ray_weights: array<f32>;

/// Red, green and blue: of the four probes along each ray of a tile, then of four coefficients by each invocation.
var<workgroup> tile: array<array<vec4f, 3>, WORKGROUP>;

/// The extent of a probe, empty behind the last.
fn extent(probe: u32) -> ProbeRecord {
    if probe >= shape.probes {
        return ProbeRecord();
    }
    return probes[probe];
}

fn look(probe: u32, extent: ProbeRecord, ray: u32) -> vec3f {
    if ray >= extent.rays {
        return vec3f(0.0);
    }
    let at = probe * shape.rays + ray;
    let byte = extractBits(relight_gains[at / 4u], at % 4u * 8u, 8u);
    let gain = f32(byte) / GAIN_STEPS * ray_weights[extent.first_weight + ray];
    let surfel = relight_surfels[at];
    if surfel == NONE {
        return gain * vec3f(sky[3u * ray], sky[3u * ray + 1u], sky[3u * ray + 2u]);
    }
    return gain * vec3f(signals[3u * surfel], signals[3u * surfel + 1u], signals[3u * surfel + 2u]);
}

/// Products of four coefficients with the radiance of each of four probes.
fn outer_product(basis: vec4f, radiance: vec4f) -> mat4x4f {
    return mat4x4f(basis * radiance.x, basis * radiance.y, basis * radiance.z, basis * radiance.w);
}

/// Adds up what the invocations summed for one probe, and stores the coefficients.
fn store_coefficients(
    probe: u32,
    extent: ProbeRecord,
    sums: array<vec4f, 3>,
    first_quad: u32,
    quads: u32,
    local: u32,
) {
    workgroupBarrier();
    tile[local] = sums;
    workgroupBarrier();
    if extent.rays == 0u || local >= 3u * quads {
        return;
    }
    let quad = local % quads;
    let channel = local / quads;
    var sum = vec4f(0.0);
    for (var i = quad; i < WORKGROUP / quads * quads; i += quads) {
        sum += tile[i][channel];
    }
    let first = 4u * (first_quad + quad);
    let at = 3u * (shape.scalar_signals + probe * shape.coefficients + first) + channel;
    for (var i = 0u; i < 4u && first + i < extent.coefficients; i++) {
        signals[at + 3u * i] = sum[i];
    }
}

@compute @workgroup_size(256)
fn relight_probes(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) workgroups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let stored_quads = (shape.coefficients + 3u) / 4u;
    let panels = (stored_quads + PANEL - 1u) / PANEL;
    let number = linear_workgroup(workgroup, workgroups);
    let first_probe = number / panels * PROBES;
    let first_quad = number % panels * PANEL;
    let extent_a = extent(first_probe);
    let extent_b = extent(first_probe + 1u);
    let extent_c = extent(first_probe + 2u);
    let extent_d = extent(first_probe + 3u);
    let rays = max(max(extent_a.rays, extent_b.rays), max(extent_c.rays, extent_d.rays));
    let coefficients = max(
        max(extent_a.coefficients, extent_b.coefficients),
        max(extent_c.coefficients, extent_d.coefficients),
    );
    if 4u * first_quad >= coefficients {
        return;
    }
    let quads = min(PANEL, (coefficients + 3u) / 4u - first_quad);
    let parts = WORKGROUP / quads;
    let quad = first_quad + local % quads;
    var red = mat4x4f();
    var green = mat4x4f();
    var blue = mat4x4f();
    for (var first_ray = 0u; first_ray < rays; first_ray += WORKGROUP) {
        let ray = first_ray + local;
        let a = look(first_probe, extent_a, ray);
        let b = look(first_probe + 1u, extent_b, ray);
        let c = look(first_probe + 2u, extent_c, ray);
        let d = look(first_probe + 3u, extent_d, ray);
        workgroupBarrier();
        tile[local] = array<vec4f, 3>(
            vec4f(a.x, b.x, c.x, d.x),
            vec4f(a.y, b.y, c.y, d.y),
            vec4f(a.z, b.z, c.z, d.z),
        );
        workgroupBarrier();
        if local < parts * quads {
            for (var i = local / quads; i < min(WORKGROUP, rays - first_ray); i += parts) {
                let basis = weighted_basis[(first_ray + i) * stored_quads + quad];
                red += outer_product(basis, tile[i][0]);
                green += outer_product(basis, tile[i][1]);
                blue += outer_product(basis, tile[i][2]);
            }
        }
    }
    let sums_a = array<vec4f, 3>(red[0], green[0], blue[0]);
    let sums_b = array<vec4f, 3>(red[1], green[1], blue[1]);
    let sums_c = array<vec4f, 3>(red[2], green[2], blue[2]);
    let sums_d = array<vec4f, 3>(red[3], green[3], blue[3]);
    store_coefficients(first_probe, extent_a, sums_a, first_quad, quads, local);
    store_coefficients(first_probe + 1u, extent_b, sums_b, first_quad, quads, local);
    store_coefficients(first_probe + 2u, extent_c, sums_c, first_quad, quads, local);
    store_coefficients(first_probe + 3u, extent_d, sums_d, first_quad, quads, local);
}
