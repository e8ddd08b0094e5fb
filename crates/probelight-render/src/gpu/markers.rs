//! Probes and light samples as things to look at.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;
use wgpu::util::DeviceExt;

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

/// Most markers: as many as WebGPU lets a shader bind (128 MiB). Of more the first are shown.
const MOST_MARKERS: usize = (128 << 20) / size_of::<MarkerRecord>();

impl Markers {
    /// Spheres at the probes.
    pub(super) fn probes(device: &wgpu::Device, baked: &BakedScene) -> Self {
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
    pub(super) fn light_samples(device: &wgpu::Device, baked: &BakedScene) -> Self {
        let surfels = (0..).zip(&baked.surfels);
        let of_surfel = |(number, surfel): (u32, &probelight_asset::Surfel)| {
            let first = surfel.first_sample as usize;
            let samples = baked.light_samples[first..first + surfel.sample_count as usize].iter();
            samples.map(move |sample| {
                let front = baked.scene.geometric_normal(sample.triangle as usize);
                let is_back = sample.is_back_face();
                MarkerRecord {
                    position: sample.position.to_array(),
                    signal: number,
                    normal: if is_back { -front } else { front }.to_array(),
                    degree: 0,
                }
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
        label: &str,
        mut records: Vec<MarkerRecord>,
        vertices: u32,
        radius: f32,
    ) -> Self {
        records.truncate(MOST_MARKERS);
        let count = records.len() as u32;
        if records.is_empty() {
            // Shaders cannot bind an empty array.
            records.push(MarkerRecord::default());
        }
        let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents: bytemuck::cast_slice(&records),
            usage: wgpu::BufferUsages::STORAGE,
        });
        Self { buffer, count, vertices, radius }
    }
}
