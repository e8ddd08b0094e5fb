//! A frame in the plainest form: double precision, one value at a time, straight from the equations.

use probelight_asset::{BakedScene, NONE};
use probelight_math::color::linear_from_srgb8;
use probelight_math::directions::quadrature_weights;
use probelight_math::glam::{DVec3, Vec3};
use probelight_math::sh::{Basis, index};
use probelight_runtime::cpu::SurfaceColors;
use probelight_scene::Lighting;
use probelight_trace::{Tracer, direct_irradiance};

/// What the stages of one frame leave behind.
#[derive(Default)]
pub(crate) struct SlowFrame {
    /// Per relight point.
    pub(crate) radiance: Vec<DVec3>,
    /// Per probe and coefficient.
    pub(crate) coefficients: Vec<Vec<DVec3>>,
    /// Per singular value.
    pub(crate) cluster_coefficients: Vec<DVec3>,
    /// Per receiver.
    pub(crate) irradiance: Vec<DVec3>,
    /// Per texel.
    pub(crate) lightmap: Vec<DVec3>,
}

/// One frame with `feedback` as last frame's lightmap.
pub(crate) fn slow_frame(
    baked: &BakedScene,
    lighting: &Lighting,
    colors: &[SurfaceColors],
    feedback: &[DVec3],
) -> SlowFrame {
    let mut frame = SlowFrame::default();
    let tracer = Tracer::new(baked.scene.clone().into());
    for point in 0..baked.relight_points.len() {
        frame.radiance.push(radiance(baked, &tracer, lighting, colors, feedback, point));
    }
    frame.coefficients = coefficients(baked, &frame.radiance);
    for cluster in &baked.clusters {
        for row in 0..cluster.rank as usize {
            frame.cluster_coefficients.push(cluster_coefficient(baked, cluster, &frame.coefficients, row));
        }
        for receiver in 0..cluster.receiver_count as usize {
            let mut sum = DVec3::ZERO;
            for k in 0..cluster.rank as usize {
                let at =
                    cluster.receiver_basis_offset as usize + k * cluster.receiver_count as usize + receiver;
                let b = frame.cluster_coefficients[cluster.row_scale_offset as usize + k];
                sum += baked.receiver_basis[at].to_f64() * b;
            }
            frame.irradiance.push(sum);
        }
    }
    frame.lightmap = vec![DVec3::ZERO; (baked.lightmap.width * baked.lightmap.height) as usize];
    for (texel, value) in baked.receiver_texels.iter().zip(&frame.irradiance) {
        frame.lightmap[*texel as usize] = *value;
    }
    for [to, from] in &baked.lightmap.dilation {
        frame.lightmap[*to as usize] = frame.lightmap[*from as usize];
    }
    frame
}

fn radiance(
    baked: &BakedScene,
    tracer: &Tracer,
    lighting: &Lighting,
    colors: &[SurfaceColors],
    feedback: &[DVec3],
    index: usize,
) -> DVec3 {
    let point = &baked.relight_points[index];
    if point.triangle == NONE {
        let ray = index % baked.relight_directions.len();
        return lighting.sky.radiance(baked.relight_directions[ray]).as_dvec3();
    }
    let triangle = point.triangle as usize;
    let is_front = point.base_color_and_side[3] == 0;
    let normal = baked.scene.geometric_normal(triangle) * if is_front { 1.0 } else { -1.0 };
    let mut arriving = DVec3::ZERO;
    if point.texel != NONE {
        arriving += feedback[point.texel as usize].max(DVec3::ZERO);
    }
    arriving += direct_irradiance(tracer, &lighting.lights, point.position, normal).as_dvec3();
    let colors = &colors[baked.scene.triangle_material[triangle] as usize];
    let decode = |[r, g, b, _]: [u8; 4]| linear_from_srgb8([r, g, b]);
    let albedo = (colors.base_color * decode(point.base_color_and_side)).as_dvec3();
    let emitted = if is_front { lighting.emissive_scale * colors.emission } else { Vec3::ZERO };
    (emitted * decode(point.emission_texel)).as_dvec3() + albedo / std::f64::consts::PI * arriving
}

fn coefficients(baked: &BakedScene, radiance: &[DVec3]) -> Vec<Vec<DVec3>> {
    let basis = Basis::new(baked.settings.sh_degree as usize);
    let weights = quadrature_weights(&baked.relight_directions, 2 * basis.degree());
    let mut y = vec![0.0; basis.len()];
    let mut coefficients = Vec::new();
    for radiance in radiance.chunks(baked.relight_directions.len()) {
        let mut probe = vec![DVec3::ZERO; basis.len()];
        for ((direction, weight), radiance) in baked.relight_directions.iter().zip(&weights).zip(radiance) {
            basis.evaluate(*direction, &mut y);
            for (sum, y) in probe.iter_mut().zip(&y) {
                *sum += f64::from(*weight) * f64::from(*y) * *radiance;
            }
        }
        coefficients.push(probe);
    }
    coefficients
}

fn cluster_coefficient(
    baked: &BakedScene,
    cluster: &probelight_asset::Cluster,
    coefficients: &[Vec<DVec3>],
    row: usize,
) -> DVec3 {
    let probe_count = cluster.probe_count as usize;
    let row_start = cluster.signal_basis_offset as usize + row * baked.column_count(cluster);
    let mut sum = DVec3::ZERO;
    for l in 0..=baked.settings.sh_degree as usize {
        for p in 0..probe_count {
            let probe = baked.cluster_probes[cluster.first_probe as usize + p] as usize;
            for m in -(l as isize)..=l as isize {
                let column = probe_count * l * l + p * (2 * l + 1) + (l as isize + m) as usize;
                let value = baked.signal_basis[row_start + column].to_f64();
                sum += value * coefficients[probe][index(l, m)];
            }
        }
    }
    sum * f64::from(baked.row_scales[cluster.row_scale_offset as usize + row])
}
