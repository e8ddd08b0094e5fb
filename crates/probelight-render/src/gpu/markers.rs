//! Probes and light samples as things to look at.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use probelight_runtime::gpu::GpuError;
use probelight_runtime::gpu::filled_buffer::{filled_buffer, largest_buffer};

/// `Marker` in `markers.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct MarkerRecord {
    pub(super) position: [f32; 3], //  0
    pub(super) signal: u32,        //        12
    pub(super) normal: [f32; 3],   //   16
    pub(super) degree: u32,        //        28
}

/// `SLICES` and `STACKS` in `markers.wgsl`.
pub(super) const SLICES: u32 = 20;
pub(super) const STACKS: u32 = 10;

/// Markers of one kind.
#[derive(Debug)]
pub(super) struct Markers {
    pub(super) buffer: wgpu::Buffer,
    pub(super) count: u32,
    pub(super) vertices: u32,
    /// Metres.
    pub(super) radius: f32,
}

impl Markers {
    /// Spheres at the probes.
    pub(super) fn probes(device: &wgpu::Device, baked: &BakedScene) -> Result<Self, GpuError> {
        let first = baked.scalar_signals();
        let record = |(number, probe): (usize, &probelight_asset::Probe)| MarkerRecord {
            position: probe.position.to_array(),
            signal: (first + number * baked.coefficients()) as u32,
            degree: baked.settings.sh_degree.min(2),
            ..MarkerRecord::default()
        };
        let records = baked.probes.iter().enumerate().map(record).collect();
        // A sixteenth of the distance between neighbours: large enough to see, small enough to see past.
        Self::new(device, "probes", records, SLICES * STACKS * 6, baked.settings.probe_spacing / 16.0)
    }

    /// Discs at the light samples.
    pub(super) fn light_samples(device: &wgpu::Device, baked: &BakedScene) -> Result<Self, GpuError> {
        let surfels = (0..).zip(&baked.surfels);
        let of_surfel = |(number, surfel): (u32, &probelight_asset::Surfel)| {
            baked.samples_of(surfel).iter().map(move |sample| {
                let (position, normal) = baked.place_of(sample);
                MarkerRecord { position: position.into(), signal: number, normal: normal.into(), degree: 0 }
            })
        };
        let records: Vec<_> = surfels.flat_map(of_surfel).collect();
        // About half of the distance between a surfel's samples, so that they stay apart.
        let samples_per_surfel = records.len() as f32 / baked.surfels.len().max(1) as f32;
        let radius = 0.25 * baked.settings.surfel_size / samples_per_surfel.max(1.0).sqrt();
        Self::new(device, "light samples", records, SLICES * 3, radius)
    }

    fn new(
        device: &wgpu::Device,
        label: &'static str,
        mut records: Vec<MarkerRecord>,
        vertices: u32,
        radius: f32,
    ) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE;
        // Of more than shaders can bind the first are shown.
        let most = largest_buffer(&device.limits(), usage) / size_of::<MarkerRecord>() as u64;
        records.truncate(usize::try_from(most).unwrap_or(usize::MAX));
        let buffer = filled_buffer(device, label, bytemuck::cast_slice(&records), usage)?;
        Ok(Self { buffer, count: records.len() as u32, vertices, radius })
    }
}
