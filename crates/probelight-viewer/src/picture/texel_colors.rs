//! What the colours of clusters stand for.

use probelight_asset::ERROR_STEPS;
use probelight_math::glam::Vec3;
use probelight_render::gpu::GpuRenderer;
use probelight_scene::Camera;

use crate::scene::live_scene::LiveScene;
use crate::state::camera_rig::axes;
use crate::state::view_state::TexelColors;

/// What red stands for: singular values, share of the error that was wanted, probes.
const HIGHEST_RANK: f32 = 32.0;
const LARGEST_ERROR: f32 = 3.0;
const MOST_PROBES: f32 = 64.0;

/// The colour of a receiver, given its cluster's number and its own.
pub type TexelColor<'a> = Box<dyn Fn(u32, u32) -> Vec3 + 'a>;

/// The colours of a view.
pub fn texel_color<'a>(live: &'a LiveScene, camera: &Camera, colors: TexelColors) -> TexelColor<'a> {
    let (baked, lod) = (&live.baked, live.runtime.lod());
    let extents = live.runtime.plan().clusters();
    match colors {
        TexelColors::Clusters => Box::new(|cluster, _| GpuRenderer::color_of_number(cluster)),
        TexelColors::Ranks => {
            Box::new(|cluster, _| heat(extents[cluster as usize].rank as f32 / HIGHEST_RANK))
        }
        TexelColors::Levels => Box::new(|cluster, _| {
            let (all, computed) =
                (baked.clusters[cluster as usize].receiver_count, extents[cluster as usize].receivers);
            // A level has about a quarter of the receivers of the one before.
            let level = (all.max(1) as f32 / computed.max(1) as f32).log2() * 0.5;
            if computed == 0 { Vec3::splat(0.05) } else { heat(1.0 - level / 3.0) }
        }),
        TexelColors::Zones => {
            let ([_, _, forward], from) = (axes(camera), camera.position);
            Box::new(move |cluster, _| {
                let bounds = baked.clusters[cluster as usize].bounds;
                let towards = (bounds.min.midpoint(bounds.max) - from).normalize_or_zero();
                // In front green, beside yellow, behind red.
                let [front, beside, behind] = lod.zones.weights(towards.dot(forward));
                front * Vec3::new(0.1, 0.7, 0.2)
                    + beside * Vec3::new(0.8, 0.6, 0.1)
                    + behind * Vec3::new(0.7, 0.1, 0.1)
            })
        }
        TexelColors::Errors => Box::new(|_, receiver| {
            let error = baked.receiver_errors.get(receiver as usize).copied().unwrap_or_default();
            heat(f32::from(error) / ERROR_STEPS / LARGEST_ERROR)
        }),
        TexelColors::Probes => {
            Box::new(|cluster, _| heat(baked.clusters[cluster as usize].probe_count as f32 / MOST_PROBES))
        }
    }
}

/// Gives the renderer the colours of a view.
pub fn apply(live: &LiveScene, camera: &Camera, colors: TexelColors) {
    live.renderer.set_texel_colors(texel_color(live, camera, colors));
}

/// From blue at 0 over green to red at 1.
pub fn heat(share: f32) -> Vec3 {
    let turn = (1.0 - share.clamp(0.0, 1.0)) * 0.66;
    let channel = |shift: f32| (((turn + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    Vec3::new(channel(1.0), channel(2.0 / 3.0), channel(1.0 / 3.0))
}
