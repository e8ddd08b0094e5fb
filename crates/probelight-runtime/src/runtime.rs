//! The runtime: a baked scene, its present lighting and materials, and the stages of a frame.

use std::sync::Arc;
use std::time::{Duration, Instant};

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::Lighting;
use probelight_trace::Tracer;

use crate::cpu::{
    ClusterCoefficients, Dilation, ProbeRadiance, ReceiverIrradiance, ScalarSignals, SurfaceColors,
};
use crate::scene_state::SceneState;
use crate::{IrradianceLightmap, RuntimeError};

/// Lights a baked scene, frame by frame.
///
/// Work is divided among the threads of the rayon pool that calls; the result does not depend on their number.
/// After the first frame, [`step`](Self::step) allocates nothing.
pub struct Runtime {
    baked: Arc<BakedScene>,
    tracer: Tracer,
    state: SceneState,
    signals: ScalarSignals,
    probes: ProbeRadiance,
    coefficients: ClusterCoefficients,
    receivers: ReceiverIrradiance,
    dilation: Dilation,
    lightmap: IrradianceLightmap,
}

/// How long each stage of a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTimings {
    /// Radiance of the surfels, with shadow rays if lights changed.
    pub light_surfels: Duration,
    /// Projection to spherical harmonics.
    pub relight_probes: Duration,
    /// Coefficients of the clusters.
    pub project_clusters: Duration,
    /// Irradiance of the receivers.
    pub gather_receivers: Duration,
    /// Texels around the charts.
    pub dilate_lightmap: Duration,
}

impl FrameTimings {
    /// All stages together.
    pub fn total(&self) -> Duration {
        self.light_surfels
            + self.relight_probes
            + self.project_clusters
            + self.gather_receivers
            + self.dilate_lightmap
    }
}

/// How [`Runtime::converge`] ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Frames computed.
    pub steps: usize,
    /// Relative change of the receivers' irradiance in the last frame (root mean square). Bounces fade
    /// geometrically: where each keeps a share q of the one before, what is still missing is about
    /// `change · q / (1 − q)`.
    pub change: f64,
}

impl Runtime {
    /// Prepares a baked scene: builds the BVH for shadow rays, and all buffers. The lights are those of the
    /// scene's file, the sky is black, emissive surfaces shine.
    pub fn new(baked: Arc<BakedScene>) -> Self {
        Self {
            tracer: Tracer::new(Arc::clone(&baked.scene)),
            state: SceneState::new(&baked),
            signals: ScalarSignals::new(&baked),
            probes: ProbeRadiance::new(&baked),
            coefficients: ClusterCoefficients::new(&baked),
            receivers: ReceiverIrradiance::new(&baked),
            dilation: Dilation::new(&baked),
            lightmap: IrradianceLightmap::new(baked.lightmap.width, baked.lightmap.height),
            baked,
        }
    }

    /// The baked scene.
    pub fn baked(&self) -> &Arc<BakedScene> {
        &self.baked
    }

    /// The ray tracer of the scene.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// The light sources of the next frame.
    pub fn lighting(&self) -> &Lighting {
        &self.state.lighting
    }

    /// Changes the light sources. Shadow rays are traced again only if an analytic light changed.
    pub fn set_lighting(&mut self, lighting: Lighting) {
        self.state.set_lighting(lighting);
    }

    /// A material's present colours.
    pub fn surface_colors(&self, material: usize) -> Option<SurfaceColors> {
        self.state.colors.get(material).copied()
    }

    /// Changes the base colour factor of a material (linear RGB; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_base_color(&mut self, material: usize, base_color: Vec3) -> Result<(), RuntimeError> {
        self.state.set_base_color(material, base_color)
    }

    /// Changes the radiance that the front faces of a material emit (W·m⁻²·sr⁻¹; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_emission(&mut self, material: usize, radiance: Vec3) -> Result<(), RuntimeError> {
        self.state.set_emission(material, radiance)
    }

    /// Computes one frame, which adds one bounce to the lightmap.
    pub fn step(&mut self) -> FrameTimings {
        let baked = &*self.baked;
        let mut timings = FrameTimings::default();
        timed(&mut timings.light_surfels, || {
            let stale = self.state.take_stale();
            let SceneState { lighting, colors, .. } = &self.state;
            if stale.direct {
                self.signals.trace_direct(baked, &self.tracer, &lighting.lights);
            }
            if stale.direct || stale.shading {
                self.signals.shade(baked, lighting, colors);
            }
            if stale.sky {
                self.signals.project_sky(baked, &lighting.sky);
                self.probes.see_sky(baked, &lighting.sky);
            }
            self.signals.light_surfels(baked, &self.lightmap);
        });
        let surfels = &self.signals.values()[..baked.surfels.len()];
        timed(&mut timings.relight_probes, || self.probes.relight_probes(baked, surfels));
        timed(&mut timings.project_clusters, || {
            self.coefficients.project_clusters(baked, self.signals.values(), &self.probes);
        });
        timed(&mut timings.gather_receivers, || {
            self.receivers.gather_receivers(baked, self.coefficients.values(), &mut self.lightmap);
        });
        timed(&mut timings.dilate_lightmap, || {
            self.dilation.dilate_lightmap(self.receivers.values(), &mut self.lightmap);
        });
        timings
    }

    /// Computes frames until the relative change of the lightmap is at most `tolerance`, at most `max_steps`.
    pub fn converge(&mut self, tolerance: f64, max_steps: usize) -> Convergence {
        let mut previous = self.receivers.values().to_vec();
        let mut convergence = Convergence { steps: 0, change: f64::INFINITY };
        while convergence.steps < max_steps && convergence.change > tolerance {
            self.step();
            convergence.steps += 1;
            convergence.change = relative_change(&previous, self.receivers.values());
            previous.copy_from_slice(self.receivers.values());
        }
        convergence
    }

    /// Forgets all bounced light: the next step starts from darkness.
    pub fn reset(&mut self) {
        self.receivers.clear();
        self.lightmap.texels.fill(Vec3::ZERO);
    }

    /// The lightmap of the last frame.
    pub fn irradiance(&self) -> &IrradianceLightmap {
        &self.lightmap
    }

    /// Irradiance (W/m²) of the surface at a world position, on its side towards `normal` (unit): what arrives
    /// by way of the signals. `None` if there is no such surface within a thousandth of the scene's diagonal.
    /// Sides without light of their own, such as the insides of solids, are dark.
    pub fn irradiance_at(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        self.lightmap.irradiance_at(&self.tracer, &self.baked.lightmap, position, normal)
    }

    /// Scalar signals of the last frame.
    pub fn signals(&self) -> &ScalarSignals {
        &self.signals
    }

    /// Radiance of the surfels in the last frame, W·m⁻²·sr⁻¹.
    pub fn surfel_radiance(&self) -> &[Vec3] {
        &self.signals.values()[..self.baked.surfels.len()]
    }

    /// Probe coefficients λ of the last frame.
    pub fn probe_radiance(&self) -> &ProbeRadiance {
        &self.probes
    }

    /// Cluster coefficients b of the last frame.
    pub fn cluster_coefficients(&self) -> &ClusterCoefficients {
        &self.coefficients
    }

    /// Irradiance of the receivers in the last frame, W/m², in the order of `receiver_texels`.
    pub fn receiver_irradiance(&self) -> &[Vec3] {
        self.receivers.values()
    }
}

fn timed(duration: &mut Duration, stage: impl FnOnce()) {
    let start = Instant::now();
    stage();
    *duration = start.elapsed();
}

/// Root-mean-square difference relative to the root mean square of `now`; 0 if both are dark.
pub(crate) fn relative_change(before: &[Vec3], now: &[Vec3]) -> f64 {
    let (mut difference, mut total) = (0.0, 0.0);
    for (before, now) in before.iter().zip(now) {
        difference += (*now - *before).as_dvec3().length_squared();
        total += now.as_dvec3().length_squared();
    }
    if difference == 0.0 { 0.0 } else { (difference / total).sqrt() }
}
