//! Stage 1: the scalar signals. The twin of `cpu::light_surfels`.
//!
//! Direct light and shading are kept from frame to frame as on the CPU. What is tiny, the signals of emitters and
//! of the sky, the CPU computes when it changes.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use probelight_math::color::linear_from_srgb;
use probelight_math::glam::Vec3;
use probelight_scene::{Lighting, Sky};

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, RGB_BYTES};
use super::kernel::{Kernel, whole};
use super::stage_shaders::{LIGHT_DIRECTLY, LIGHT_SURFELS, SHADE_SURFELS};
use super::storage::Storage;
use super::surfel_groups::SurfelGroups;
use super::surfel_shards::{SurfelShard, surfel_shards};
use crate::sky_signals::SkyProjection;
use crate::surface_colors::{SurfaceColors, emitter_radiance, has_emitter};

/// Invocations of a workgroup.
pub(super) const WORKGROUP: usize = 64;

/// What a material contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MaterialColors {
    /// Linear base colour factor.
    pub(super) base_color: [f32; 4],
    /// Radiance that surfels on it emit, W·m⁻²·sr⁻¹; zero where emitters carry it.
    pub(super) emission: [f32; 4],
}

/// Lights the surfels.
#[derive(Debug)]
pub(super) struct LightSurfels {
    light_directly: Kernel,
    shade_surfels: Kernel,
    light_surfels: Kernel,
    groups: SurfelGroups,
    shards: Vec<Shard>,
    materials: wgpu::Buffer,
    sky: SkyProjection,
    /// Whether emitters carry the emission of a material.
    has_emitter: Vec<bool>,
}

#[derive(Debug)]
struct Shard {
    data: SurfelShard,
    points: wgpu::BindGroup,
    shading: wgpu::BindGroup,
    feedback: wgpu::BindGroup,
}

impl LightSurfels {
    /// Prepares the stage. Shaders see lights and shadows by way of a bind group with the layout `visibility`.
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
        visibility: &wgpu::BindGroupLayout,
    ) -> Result<Self, GpuError> {
        let device = storage.device;
        let points = points_layout(device);
        let light_directly = Kernel::new(device, &LIGHT_DIRECTLY, Some(&[visibility, &points]));
        let shade_surfels = Kernel::new(device, &SHADE_SURFELS, None);
        let light_surfels = Kernel::new(device, &LIGHT_SURFELS, None);
        let decode: [f32; 256] = std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0));
        let decode = storage.uniform("linear from sRGB", &decode);
        let materials = vec![MaterialColors::default(); baked.scene.materials.len()];
        let materials = storage.array("materials", &materials)?;
        let bind = |data: SurfelShard| {
            let first_surfel = storage.uniform("first surfel", &(data.surfels.start as u32));
            let shading = [&decode, &materials, &data.first_bounces, &data.first_samples, &data.colors];
            let shading = [&shading[..], &[&data.direct, &data.bounces, &data.unbounced]].concat();
            let feedback = [&first_surfel, &data.first_bounces, &data.bounces, &data.unbounced];
            let feedback =
                [&feedback[..], &[&buffers.irradiance, &buffers.signals, &buffers.work.dirty]].concat();
            Shard {
                points: light_directly.bind(
                    device,
                    1,
                    &whole(&[&data.first_points, &data.points, &data.direct]),
                ),
                shading: shade_surfels.bind(device, 0, &whole(&shading)),
                feedback: light_surfels.bind(device, 0, &whole(&feedback)),
                data,
            }
        };
        let shards = surfel_shards(storage, baked)?.into_iter().map(bind).collect();
        let groups = SurfelGroups::new(storage, baked, buffers)?;
        let (has_emitter, sky) = (has_emitter(baked), SkyProjection::new(baked));
        Ok(Self { light_directly, shade_surfels, light_surfels, groups, shards, materials, sky, has_emitter })
    }

    /// Uploads the colours of materials and the signals of emitters.
    pub(super) fn set_colors(
        &self,
        queue: &wgpu::Queue,
        baked: &BakedScene,
        buffers: &FrameBuffers,
        lighting: &Lighting,
        colors: &[SurfaceColors],
    ) {
        let record = |(colors, has_emitter): (&SurfaceColors, &bool)| {
            let scale = if *has_emitter { 0.0 } else { lighting.emissive_scale };
            MaterialColors {
                base_color: colors.base_color.extend(1.0).to_array(),
                emission: (colors.emission * scale).extend(0.0).to_array(),
            }
        };
        let records: Vec<MaterialColors> = colors.iter().zip(&self.has_emitter).map(record).collect();
        queue.write_buffer(&self.materials, 0, bytemuck::cast_slice(&records));
        let emitters: Vec<[f32; 3]> = baked
            .emitters
            .iter()
            .map(|emitter| emitter_radiance(emitter, lighting, colors).to_array())
            .collect();
        let offset = RGB_BYTES * baked.first_emitter_signal() as u64;
        queue.write_buffer(&buffers.signals, offset, bytemuck::cast_slice(&emitters));
    }

    /// Uploads the sky's signals.
    pub(super) fn set_sky(&self, queue: &wgpu::Queue, baked: &BakedScene, buffers: &FrameBuffers, sky: &Sky) {
        let mut signals = vec![Vec3::ZERO; baked.sky_coefficients()];
        self.sky.project(sky, &mut signals);
        let offset = RGB_BYTES * baked.first_sky_signal() as u64;
        queue.write_buffer(&buffers.signals, offset, bytemuck::cast_slice(&signals));
    }

    /// Finds the direct light of all surfels. Needed when a light changed.
    pub(super) fn light_directly(&self, pass: &mut wgpu::ComputePass, visibility: &wgpu::BindGroup) {
        for shard in &self.shards {
            let workgroups = shard.data.surfels.len().div_ceil(WORKGROUP);
            self.light_directly.run(pass, &[visibility, &shard.points], workgroups);
        }
    }

    /// Evaluates what does not depend on feedback. Needed when a light or a colour changed.
    pub(super) fn shade(&self, pass: &mut wgpu::ComputePass) {
        for shard in &self.shards {
            let workgroups = shard.data.surfels.len().div_ceil(WORKGROUP);
            self.shade_surfels.run(pass, &[&shard.shading], workgroups);
        }
    }

    /// Evaluates the radiance of all surfels and groups with last frame's irradiance as feedback.
    pub(super) fn light_surfels(&self, pass: &mut wgpu::ComputePass) {
        for shard in &self.shards {
            let workgroups = shard.data.surfels.len().div_ceil(WORKGROUP);
            self.light_surfels.run(pass, &[&shard.feedback], workgroups);
        }
        self.groups.run(pass);
    }

    /// What a frame reads of surfels and groups, bytes.
    pub(super) fn feedback_bytes(&self) -> u64 {
        self.shards.iter().map(|shard| shard.data.feedback_bytes()).sum::<u64>() + self.groups.bytes()
    }

    /// What direct light and shading read and write, bytes.
    pub(super) fn shading_bytes(&self) -> u64 {
        self.shards.iter().map(|shard| shard.data.shading_bytes()).sum()
    }

    /// Numbers and direct light of each portion of the surfels.
    pub(super) fn direct(&self) -> impl Iterator<Item = (Range<usize>, &wgpu::Buffer)> {
        self.shards.iter().map(|shard| (shard.data.surfels.clone(), &shard.data.direct))
    }
}

/// Group 1 of `light_directly`: points to read, direct light to write.
fn points_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("points of direct light"),
        entries: &[entry(0, true), entry(1, true), entry(2, false)],
    })
}
