//! Surfels with their light samples, in portions that shaders can bind.
//!
//! Where direct light is looked up, [`lit_points`](super::lit_points) says. Many samples of a surfel reflect the light of
//! the same receiver. Sorted by receiver they form bounces, which a frame reads instead of the samples:
//!
//! ```text
//!  surfel    │        0        │     1     │
//!  bounces   │  0  │ 1 │   2   │   3   │ 4 │     reflectance and receiver, read every frame
//!  samples   │0 1 2│ 3 │4 5 6 7│8 9 10 │11 │     read when lights or colours change
//! ```

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

use probelight_asset::{BakedScene, LightSample, NONE};
use probelight_math::color::srgb8_from_linear;

use super::cluster_shards::divide;
use super::device::GpuError;
use super::frame_buffers::RGB_BYTES;
use super::lit_points::{LitPoint, LitPoints};
use super::storage::Storage;

/// A light sample's textures and material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SampleColors {
    /// Base colour texture, sRGB-encoded, red in the lowest byte.
    pub(super) base_color: u32,
    /// Emissive texture, sRGB-encoded; zero on back faces, which do not shine.
    pub(super) emission: u32,
    /// Index of the material.
    pub(super) material: u32,
}

/// What a surfel reflects of one receiver's light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Bounce {
    /// Sum of the samples' ρ/π, divided by the number of the surfel's samples.
    pub(super) reflectance: [f32; 3],
    /// The receiver, or [`NONE`].
    pub(super) receiver: u32,
}

/// Some surfels in the memory of a GPU.
#[derive(Debug)]
pub(super) struct SurfelShard {
    /// Numbers of the surfels.
    pub(super) surfels: Range<usize>,
    pub(super) first_bounces: wgpu::Buffer,
    pub(super) first_samples: wgpu::Buffer,
    /// First point of each surfel at which its direct light is looked up, and the end of the last one's.
    pub(super) first_points: wgpu::Buffer,
    pub(super) points: wgpu::Buffer,
    pub(super) colors: wgpu::Buffer,
    /// Irradiance of the analytic lights on each surfel: three `f32`, W/m².
    pub(super) direct: wgpu::Buffer,
    pub(super) bounces: wgpu::Buffer,
    /// Mean radiance of each surfel without feedback: three `f32`, W·m⁻²·sr⁻¹.
    pub(super) unbounced: wgpu::Buffer,
}

/// All shards of a scene.
///
/// # Errors
/// [`GpuError::TooLarge`] if a single surfel does not fit in a binding.
pub(super) fn surfel_shards(storage: &Storage, baked: &BakedScene) -> Result<Vec<SurfelShard>, GpuError> {
    let (receivers, points) = (baked.receivers_of_texels(), LitPoints::new(baked));
    let longest_array = |surfel: &usize| {
        let samples = u64::from(baked.surfels[*surfel].sample_count) * size_of::<Bounce>() as u64;
        samples.max(points.of(*surfel..*surfel + 1).len() as u64 * size_of::<LitPoint>() as u64)
    };
    let surfels: Vec<usize> = (0..baked.surfels.len()).collect();
    divide(&surfels, storage.limit, longest_array)
        .into_iter()
        .map(|surfels| SurfelShard::new(storage, baked, &receivers, &points, surfels))
        .collect()
}

/// The arrays of a shard, as they will lie on the GPU.
#[derive(Default)]
struct ShardArrays {
    sample_order: Vec<u32>,
    first_bounces: Vec<u32>,
    first_samples: Vec<u32>,
    bounces: Vec<Bounce>,
}

impl ShardArrays {
    fn new(baked: &BakedScene, receivers: &[u32], surfels: Range<usize>) -> Self {
        let mut arrays = Self::default();
        let receiver = |sample: u32| {
            let texel = baked.texel_of(&baked.light_samples[sample as usize]);
            receivers.get(texel as usize).copied().unwrap_or(NONE)
        };
        for surfel in &baked.surfels[surfels] {
            arrays.first_bounces.push(arrays.bounces.len() as u32);
            let mut samples: Vec<u32> =
                (surfel.first_sample..surfel.first_sample + surfel.sample_count).collect();
            samples.sort_by_key(|sample| receiver(*sample));
            for run in samples.chunk_by(|a, b| receiver(*a) == receiver(*b)) {
                arrays.first_samples.push(arrays.sample_order.len() as u32);
                arrays.bounces.push(Bounce { receiver: receiver(run[0]), ..Bounce::default() });
                arrays.sample_order.extend(run);
            }
        }
        arrays.first_bounces.push(arrays.bounces.len() as u32);
        arrays.first_samples.push(arrays.sample_order.len() as u32);
        arrays
    }
}

impl SurfelShard {
    /// What a frame reads of the shard, bytes.
    pub(super) fn feedback_bytes(&self) -> u64 {
        self.first_bounces.size() + self.bounces.size() + self.unbounced.size()
    }

    /// What direct light and shading read and write of the shard, bytes. Direct light is written, then read.
    pub(super) fn shading_bytes(&self) -> u64 {
        let points = self.first_points.size() + self.points.size() + 2 * self.direct.size();
        points + self.colors.size() + self.first_samples.size() + self.feedback_bytes()
    }

    fn new(
        storage: &Storage,
        baked: &BakedScene,
        receivers: &[u32],
        points: &LitPoints,
        surfels: Range<usize>,
    ) -> Result<Self, GpuError> {
        let arrays = ShardArrays::new(baked, receivers, surfels.clone());
        let samples = arrays.sample_order.iter().map(|sample| &baked.light_samples[*sample as usize]);
        let colors: Vec<SampleColors> = samples.map(|sample| colors(sample, baked)).collect();
        Ok(Self {
            first_bounces: storage.array("first bounces of surfels", &arrays.first_bounces)?,
            first_samples: storage.array("first samples of bounces", &arrays.first_samples)?,
            first_points: storage.array("first points of surfels", &points.firsts(surfels.clone()))?,
            points: storage.array("points of direct light", points.of(surfels.clone()))?,
            colors: storage.array("colours of light samples", &colors)?,
            direct: storage.zeros("direct light", RGB_BYTES * surfels.len() as u64)?,
            bounces: storage.array("bounces", &arrays.bounces)?,
            unbounced: storage.zeros("surfels without feedback", RGB_BYTES * surfels.len() as u64)?,
            surfels,
        })
    }
}

fn colors(sample: &LightSample, baked: &BakedScene) -> SampleColors {
    let codes = |[red, green, blue]: [u8; 3]| u32::from_le_bytes([red, green, blue, 0]);
    let triangle = sample.triangle() as usize;
    let material = baked.scene.triangle_material[triangle];
    let emission = baked.scene.emission_texel(triangle, sample.barycentric());
    SampleColors {
        base_color: codes(sample.base_color()),
        emission: if sample.is_back_face() { 0 } else { codes(srgb8_from_linear(emission)) },
        material,
    }
}
