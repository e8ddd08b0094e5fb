//! Surfels with their light samples, in portions that shaders can bind.
//!
//! Many samples of a surfel reflect the light of the same receiver. Sorted by receiver they form bounces, which
//! a frame reads instead of the samples:
//!
//! ```text
//!  surfel    │        0        │     1     │
//!  bounces   │  0  │ 1 │   2   │   3   │ 4 │     reflectance and receiver, read every frame
//!  samples   │0 1 2│ 3 │4 5 6 7│8 9 10 │11 │     read when lights or colours change
//! ```

use bytemuck::{Pod, Zeroable};
use std::ops::Range;

use probelight_asset::{BakedScene, LightSample, NONE};
use probelight_math::glam::Vec3;

use super::cluster_shards::divide;
use super::device::GpuError;
use super::frame_buffers::RGB_BYTES;
use super::storage::Storage;

/// Where a light sample is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SamplePlace {
    /// World position on the surface, metres.
    pub(super) position: [f32; 3],
    /// Fills the record.
    pub(super) padding_a: f32,
    /// Unit geometric normal of the sample's side.
    pub(super) normal: [f32; 3],
    /// Fills the record.
    pub(super) padding_b: f32,
}

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
    /// Numbers of their samples before these were sorted: where each sample of the buffers comes from.
    pub(super) sample_order: Vec<u32>,
    pub(super) first_bounces: wgpu::Buffer,
    pub(super) first_samples: wgpu::Buffer,
    pub(super) places: wgpu::Buffer,
    pub(super) colors: wgpu::Buffer,
    /// Irradiance of the analytic lights at each sample: three `f32`, W/m².
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
    let receivers = baked.receivers_of_texels();
    // The places of the samples are the longest array.
    divide(&baked.surfels, storage.limit, |surfel| {
        u64::from(surfel.sample_count) * size_of::<SamplePlace>() as u64
    })
    .into_iter()
    .map(|surfels| SurfelShard::new(storage, baked, &receivers, surfels))
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
            let texel = baked.light_samples[sample as usize].texel;
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
        let samples = self.places.size() + self.colors.size() + 2 * self.direct.size();
        samples + self.first_samples.size() + self.feedback_bytes()
    }

    fn new(
        storage: &Storage,
        baked: &BakedScene,
        receivers: &[u32],
        surfels: Range<usize>,
    ) -> Result<Self, GpuError> {
        let arrays = ShardArrays::new(baked, receivers, surfels.clone());
        let samples = || arrays.sample_order.iter().map(|sample| &baked.light_samples[*sample as usize]);
        let normals: Vec<Vec3> =
            (0..baked.scene.triangles.len()).map(|triangle| baked.scene.geometric_normal(triangle)).collect();
        let places: Vec<SamplePlace> = samples().map(|sample| place(sample, &normals)).collect();
        let colors: Vec<SampleColors> = samples().map(|sample| colors(sample, baked)).collect();
        Ok(Self {
            first_bounces: storage.array("first bounces of surfels", &arrays.first_bounces)?,
            first_samples: storage.array("first samples of bounces", &arrays.first_samples)?,
            places: storage.array("light samples", &places)?,
            colors: storage.array("colours of light samples", &colors)?,
            direct: storage.zeros("direct light", RGB_BYTES * places.len() as u64)?,
            bounces: storage.array("bounces", &arrays.bounces)?,
            unbounced: storage.zeros("surfels without feedback", RGB_BYTES * surfels.len() as u64)?,
            surfels,
            sample_order: arrays.sample_order,
        })
    }
}

fn place(sample: &LightSample, normals: &[Vec3]) -> SamplePlace {
    let front = normals[sample.triangle as usize];
    let normal = if sample.is_back_face() { -front } else { front };
    SamplePlace { position: sample.position.to_array(), normal: normal.to_array(), ..SamplePlace::default() }
}

fn colors(sample: &LightSample, baked: &BakedScene) -> SampleColors {
    let codes = |[red, green, blue, _]: [u8; 4]| u32::from_le_bytes([red, green, blue, 0]);
    SampleColors {
        base_color: codes(sample.base_color_and_side),
        emission: if sample.is_back_face() { 0 } else { codes(sample.emission_texel) },
        material: baked.scene.triangle_material[sample.triangle as usize],
    }
}
