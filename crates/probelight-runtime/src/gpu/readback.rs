//! Copies from the GPU to the CPU: for pictures, tests and measurements, never within a frame.

use bytemuck::Pod;

use super::device::{GpuError, new_encoder};

/// What `buffer` (usage `COPY_SRC`) holds once all submitted work is done. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
pub fn read_buffer<T: Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, GpuError> {
    let staging = staging_buffer(device, buffer.size());
    let mut encoder = new_encoder(device);
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    queue.submit([encoder.finish()]);
    Ok(bytemuck::pod_collect_to_vec(&mapped(device, &staging)?))
}

/// The texels of level 0 of `texture` (usage `COPY_SRC`, 2D, uncompressed), row by row from the top, of the
/// first layer. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
pub fn read_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, GpuError> {
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let row = texture.width() * texel;
    let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = staging_buffer(device, u64::from(padded_row) * u64::from(texture.height()));
    let mut encoder = new_encoder(device);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &staging, layout },
        wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
    );
    queue.submit([encoder.finish()]);
    let padded = mapped(device, &staging)?;
    Ok(padded.chunks_exact(padded_row as usize).flat_map(|r| &r[..row as usize]).copied().collect())
}

fn staging_buffer(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

/// Waits until the GPU is done, then copies what a staging buffer holds.
fn mapped(device: &wgpu::Device, staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let lost = |reason: String| GpuError::Lost { reason };
    let (sender, receiver) = std::sync::mpsc::channel();
    staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // The receiver waits below until this was called.
        let _ = sender.send(result);
    });
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| lost(error.to_string()))?;
    let result = receiver.recv().map_err(|error| lost(error.to_string()))?;
    result.map_err(|error| lost(error.to_string()))?;
    Ok(staging.slice(..).get_mapped_range().to_vec())
}
