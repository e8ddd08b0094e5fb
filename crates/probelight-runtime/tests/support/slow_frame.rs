//! A frame in the plainest form: double precision, one value at a time, straight from the equations.

use std::sync::Arc;

use probelight_asset::{BakedScene, Cluster, GAIN_STEPS, LightSample, NONE};
use probelight_math::color::linear_from_srgb8;
use probelight_math::directions::{quadrature_weights, spherical_fibonacci};
use probelight_math::glam::{DVec3, Vec3};
use probelight_math::sh::{Basis, index};
use probelight_runtime::{ClusterExtent, FramePlan, SurfaceColors};
use probelight_scene::Lighting;
use probelight_trace::{Tracer, direct_irradiance};

/// What the stages of one frame leave behind.
#[derive(Clone)]
pub(crate) struct SlowFrame {
    /// Per scalar signal.
    pub(crate) signals: Vec<DVec3>,
    /// Per probe and coefficient.
    pub(crate) coefficients: Vec<Vec<DVec3>>,
    /// Per singular value.
    pub(crate) cluster_coefficients: Vec<DVec3>,
    /// Per receiver, before borders are blended.
    pub(crate) gathered: Vec<DVec3>,
    /// Per receiver.
    pub(crate) irradiance: Vec<DVec3>,
    /// Per texel.
    pub(crate) lightmap: Vec<DVec3>,
}

impl SlowFrame {
    /// Before the first frame.
    pub(crate) fn dark(baked: &BakedScene) -> Self {
        let dark = |count: usize| vec![DVec3::ZERO; count];
        Self {
            signals: dark(baked.scalar_signals()),
            coefficients: vec![dark(baked.coefficients()); baked.probes.len()],
            cluster_coefficients: dark(baked.row_scales.len()),
            gathered: dark(baked.receiver_texels.len()),
            irradiance: dark(baked.receiver_texels.len()),
            lightmap: dark((baked.lightmap.width * baked.lightmap.height) as usize),
        }
    }
}

/// One frame of what `plan` has, after `last`: the rest stays.
pub(crate) fn slow_frame(
    baked: &BakedScene,
    lighting: &Lighting,
    colors: &[SurfaceColors],
    plan: &FramePlan,
    last: &SlowFrame,
) -> SlowFrame {
    let mut frame = last.clone();
    frame.signals = signals(baked, lighting, colors, &last.lightmap);
    relight_probes(baked, lighting, plan, &mut frame);
    for (cluster, extent) in baked.clusters.iter().zip(plan.clusters()) {
        let columns = columns(baked, cluster, *extent, &frame);
        for row in 0..extent.rank as usize {
            let place = cluster.row_scale_offset as usize + row;
            let weight = if row < extent.solid as usize { 1.0 } else { f64::from(extent.fade) / 16.0 };
            frame.cluster_coefficients[place] = weight * cluster_coefficient(baked, cluster, &columns, row);
        }
        for receiver in 0..extent.receivers as usize {
            frame.gathered[cluster.first_receiver as usize + receiver] =
                gather(baked, cluster, *extent, receiver, &frame.cluster_coefficients);
        }
    }
    frame.irradiance = blend_borders(baked, &frame.gathered);
    for (texel, value) in baked.receiver_texels.iter().zip(&frame.irradiance) {
        frame.lightmap[*texel as usize] = *value;
    }
    for [to, from] in &baked.lightmap.dilation {
        frame.lightmap[*to as usize] = frame.lightmap[*from as usize];
    }
    frame
}

/// Irradiance that all of a cluster's receivers would have, given its signals and probes.
pub(crate) fn irradiance_of_cluster(baked: &BakedScene, cluster: &Cluster, frame: &SlowFrame) -> Vec<DVec3> {
    let extent = ClusterExtent {
        rank: cluster.rank(),
        columns: baked.column_count(cluster) as u32,
        receivers: cluster.receiver_count,
        ..ClusterExtent::ALL
    };
    let mut coefficients = frame.cluster_coefficients.clone();
    let columns = columns(baked, cluster, extent, frame);
    for row in 0..extent.rank as usize {
        coefficients[cluster.row_scale_offset as usize + row] =
            cluster_coefficient(baked, cluster, &columns, row);
    }
    let receivers = 0..cluster.receiver_count as usize;
    receivers.map(|receiver| gather(baked, cluster, extent, receiver, &coefficients)).collect()
}

/// Irradiance of one of a cluster's receivers.
fn gather(
    baked: &BakedScene,
    cluster: &Cluster,
    extent: ClusterExtent,
    receiver: usize,
    coefficients: &[DVec3],
) -> DVec3 {
    let basis = &baked.receiver_basis[cluster.receiver_basis_offset as usize..];
    let value = |k: usize| {
        let line = &basis[cluster.receiver_ranks.line_start(k, cluster.receiver_count as usize)..];
        f64::from(cluster.receiver_ranks.precision(k).unpack(line, receiver))
    };
    let rows = &coefficients[cluster.row_scale_offset as usize..][..extent.rank as usize];
    rows.iter().enumerate().map(|(k, b)| value(k) * *b).sum()
}

/// A receiver's own cluster counts twice, each of its records once, whenever they were computed.
fn blend_borders(baked: &BakedScene, gathered: &[DVec3]) -> Vec<DVec3> {
    let mut sums: Vec<(DVec3, f64)> = gathered.iter().map(|own| (2.0 * own, 2.0)).collect();
    for blend in &baked.border_blends() {
        let [neighbor, beyond] = [blend.neighbor, blend.beyond].map(|i| gathered[i as usize]);
        let own = gathered[blend.receiver as usize];
        let steepest = 0.25 * neighbor.abs();
        let continued = neighbor + (neighbor - beyond).max(-steepest).min(steepest);
        let (sum, weight) = &mut sums[blend.receiver as usize];
        *sum += continued.max(neighbor.min(beyond).min(own)).min(neighbor.max(beyond).max(own));
        *weight += 1.0;
    }
    sums.into_iter().map(|(sum, weight)| sum / weight).collect()
}

fn signals(
    baked: &BakedScene,
    lighting: &Lighting,
    colors: &[SurfaceColors],
    feedback: &[DVec3],
) -> Vec<DVec3> {
    let tracer = Tracer::new(Arc::clone(&baked.scene));
    let mut signals = Vec::new();
    for surfel in &baked.surfels {
        let samples = baked.samples_of(surfel);
        let share = 1.0 / samples.len() as f64;
        let direct = |sample: &LightSample| {
            let (position, normal) = baked.place_of(sample);
            direct_irradiance(&tracer, &lighting.lights, position, normal).as_dvec3()
        };
        let direct = share * samples.iter().map(direct).sum::<DVec3>();
        let total: DVec3 =
            samples.iter().map(|sample| radiance(baked, lighting, colors, feedback, direct, sample)).sum();
        signals.push(share * total);
    }
    for group in &baked.surfel_groups {
        let weight = f64::from(group.first_weight);
        let [first, second] = group.children.map(|child| signals[child as usize]);
        signals.push(weight * first + (1.0 - weight) * second);
    }
    for emitter in &baked.emitters {
        let emission = lighting.emissive_scale * colors[emitter.material as usize].emission;
        signals.push((emission * emitter.mean_texel).as_dvec3());
    }
    if let Some(degree) = baked.settings.sky_degree {
        let directions: Vec<Vec3> = (0..1024).map(|i| spherical_fibonacci(i, 1024)).collect();
        let radiance: Vec<DVec3> = directions.iter().map(|d| lighting.sky.radiance(*d).as_dvec3()).collect();
        signals.extend(project(degree as usize, 2 * degree as usize, &directions, &radiance));
    }
    signals
}

fn radiance(
    baked: &BakedScene,
    lighting: &Lighting,
    colors: &[SurfaceColors],
    feedback: &[DVec3],
    direct: DVec3,
    sample: &LightSample,
) -> DVec3 {
    let triangle = sample.triangle() as usize;
    let bounced = feedback.get(baked.texel_of(sample) as usize).copied().unwrap_or(DVec3::ZERO);
    let arriving = direct + bounced.max(DVec3::ZERO);
    let material = baked.scene.triangle_material[triangle];
    let has_emitter = baked.emitters.iter().any(|emitter| emitter.material == material);
    let colors = &colors[material as usize];
    let albedo = (colors.base_color * linear_from_srgb8(sample.base_color())).as_dvec3();
    let shines = !sample.is_back_face() && !has_emitter;
    let emitted = if shines { lighting.emissive_scale * colors.emission } else { Vec3::ZERO };
    let emitted = emitted * baked.scene.emission_texel(triangle, sample.barycentric());
    emitted.as_dvec3() + albedo / std::f64::consts::PI * arriving
}

/// Spherical-harmonics coefficients of radiance along directions, with a quadrature that is exact to `exact_degree`.
fn project(degree: usize, exact_degree: usize, directions: &[Vec3], radiance: &[DVec3]) -> Vec<DVec3> {
    let basis = Basis::new(degree);
    let weights = quadrature_weights(directions, exact_degree);
    let mut y = vec![0.0; basis.len()];
    let mut sums = vec![DVec3::ZERO; basis.len()];
    for ((direction, weight), radiance) in directions.iter().zip(&weights).zip(radiance) {
        basis.evaluate(*direction, &mut y);
        for (sum, y) in sums.iter_mut().zip(&y) {
            *sum += f64::from(*weight) * f64::from(*y) * *radiance;
        }
    }
    sums
}

fn relight_probes(baked: &BakedScene, lighting: &Lighting, plan: &FramePlan, frame: &mut SlowFrame) {
    let stored = baked.relight_directions.len();
    for (probe, extent) in plan.probes().iter().enumerate().filter(|(_, extent)| extent.rays > 0) {
        let directions = &baked.relight_directions[..extent.rays as usize];
        let bring = |(ray, direction): (usize, &Vec3)| {
            let ray = probe * stored + ray;
            let surfel = baked.relight_surfels[ray];
            let radiance = if surfel != NONE {
                frame.signals[surfel as usize]
            } else if baked.settings.sky_degree.is_none() {
                lighting.sky.radiance(*direction).as_dvec3()
            } else {
                DVec3::ZERO
            };
            radiance * f64::from(baked.relight_gains[ray]) / f64::from(GAIN_STEPS)
        };
        let radiance: Vec<DVec3> = directions.iter().enumerate().map(bring).collect();
        let exact_degree = 2 * baked.settings.sh_degree as usize;
        let found = project(extent.degree as usize, exact_degree, directions, &radiance);
        frame.coefficients[probe][..found.len()].copy_from_slice(&found);
    }
}

/// A cluster's input; zeros from the first column on that does not count.
fn columns(baked: &BakedScene, cluster: &Cluster, extent: ClusterExtent, frame: &SlowFrame) -> Vec<DVec3> {
    let probe_count = cluster.probe_count as usize;
    let signal_count = cluster.signal_count as usize;
    let mut columns = vec![DVec3::ZERO; baked.column_count(cluster)];
    let numbers = &baked.cluster_signals[cluster.first_signal as usize..];
    for (column, number) in columns[..signal_count].iter_mut().zip(numbers) {
        *column = frame.signals[*number as usize];
    }
    for l in 0..=baked.settings.sh_degree as usize {
        for p in 0..probe_count {
            let probe = baked.cluster_probes[cluster.first_probe as usize + p] as usize;
            for m in -(l as isize)..=l as isize {
                let column = signal_count + probe_count * l * l + p * (2 * l + 1) + (l as isize + m) as usize;
                columns[column] = frame.coefficients[probe][index(l, m)];
            }
        }
    }
    columns[extent.columns as usize..].fill(DVec3::ZERO);
    columns
}

fn cluster_coefficient(baked: &BakedScene, cluster: &Cluster, columns: &[DVec3], row: usize) -> DVec3 {
    let basis = &baked.signal_basis[cluster.signal_basis_offset as usize..];
    let line = &basis[cluster.signal_ranks.line_start(row, columns.len())..];
    let exponents = &baked.column_exponents[cluster.column_exponent_offset as usize..];
    let mut sum = DVec3::ZERO;
    for (c, column) in columns.iter().enumerate() {
        let value = f64::from(cluster.signal_ranks.precision(row).unpack(line, c));
        sum += value * (f64::from(exponents[c]) / -8.0).exp2() * *column;
    }
    sum * f64::from(baked.row_scales[cluster.row_scale_offset as usize + row])
}
