//! Stage 2: the probes' coefficients. The twin of `cpu::relight_probes`.

use probelight_asset::BakedScene;
use probelight_scene::Sky;

use super::device::GpuError;
use super::frame_buffers::{FrameBuffers, RGB_BYTES};
use super::kernel::{Kernel, whole};
use super::stage_shaders::RELIGHT_PROBES;
use super::storage::Storage;
#[cfg(feature = "cpu")]
use super::storage::write_words;
#[cfg(feature = "cpu")]
use crate::Ways;
use crate::frame::RelightTable;

/// Probes of a workgroup: `PROBES` in its shader.
pub(super) const PROBES: usize = 4;

/// Quads of coefficients of a workgroup: `PANEL` in its shader.
pub(super) const PANEL: usize = 16;

/// Projects the radiance around probes to spherical harmonics.
#[derive(Debug)]
pub(super) struct RelightProbes {
    kernel: Kernel,
    group: wgpu::BindGroup,
    #[cfg(feature = "cpu")]
    surfels: wgpu::Buffer,
    #[cfg(feature = "cpu")]
    gains: wgpu::Buffer,
    sky: wgpu::Buffer,
    workgroups: usize,
}

impl RelightProbes {
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
    ) -> Result<Self, GpuError> {
        let kernel = Kernel::new(storage.device, &RELIGHT_PROBES, None);
        let surfels = storage.array("surfels of relight rays", &baked.relight_surfels)?;
        let gains = storage.array("gains of relight rays", &baked.relight_gains)?;
        let sky =
            storage.zeros("sky along relight rays", RGB_BYTES * baked.relight_directions.len() as u64)?;
        let table = RelightTable::new(baked);
        let basis = storage.array("weighted basis", &basis_in_quads(&table))?;
        let weights = storage.array("weights of relight rays", &table.weights)?;
        let rays = [&buffers.shape, &surfels, &gains, &sky, &basis, &buffers.signals];
        let resources = whole(&[&rays[..], &[&buffers.extents.probes, &weights]].concat());
        let group = kernel.bind(storage.device, 0, &resources);
        let has_rays = usize::from(!baked.relight_directions.is_empty());
        let workgroups =
            has_rays * baked.probes.len().div_ceil(PROBES) * baked.coefficients().div_ceil(4 * PANEL);
        Ok(Self {
            kernel,
            group,
            #[cfg(feature = "cpu")]
            surfels,
            #[cfg(feature = "cpu")]
            gains,
            sky,
            workgroups,
        })
    }

    /// Lets the rays of some probes see what doors leave them.
    #[cfg(feature = "cpu")]
    pub(super) fn set_rays(&self, queue: &wgpu::Queue, baked: &BakedScene, ways: Ways<'_>, probes: &[u32]) {
        for probe in probes {
            let rays = baked.rays_of(*probe as usize);
            let surfels = &ways.relight_surfels[rays.clone()];
            write_words(queue, &self.surfels, 4 * rays.start as u64, bytemuck::cast_slice(surfels));
            // Four gains in a word, of which the first and the last may belong to neighbours.
            let (start, end) = (rays.start / 4 * 4, rays.end.next_multiple_of(4));
            let gains = &ways.relight_gains[start..end.min(ways.relight_gains.len())];
            write_words(queue, &self.gains, start as u64, gains);
        }
    }

    /// Uploads the sky along the relight rays, unless it has signals of its own.
    pub(super) fn set_sky(&self, queue: &wgpu::Queue, baked: &BakedScene, sky: &Sky) {
        if baked.settings.sky_degree.is_none() {
            let radiance: Vec<[f32; 3]> = baked
                .relight_directions
                .iter()
                .map(|direction| sky.radiance(*direction).to_array())
                .collect();
            queue.write_buffer(&self.sky, 0, bytemuck::cast_slice(&radiance));
        }
    }

    pub(super) fn relight_probes(&self, pass: &mut wgpu::ComputePass) {
        self.kernel.run(pass, &[&self.group], self.workgroups);
    }
}

/// The table that all probes share, with zeros that fill each direction's last quad.
fn basis_in_quads(table: &RelightTable) -> Vec<f32> {
    let coefficients = table.coefficients;
    let padding = vec![0.0; coefficients.next_multiple_of(4) - coefficients];
    let rows = table.basis.chunks_exact(coefficients);
    rows.flat_map(|row| row.iter().chain(&padding)).copied().collect()
}
