//! Copies from the GPU to the CPU: for pictures, tests and measurements, never within a frame.
//!
//! What is `async` goes on when the device has answered. In browsers it does so by itself; elsewhere somebody must
//! [poll](wgpu::Device::poll) it meanwhile, as the functions that wait do.

use std::future::poll_fn;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Poll, Waker};

use bytemuck::Pod;

#[cfg(feature = "blocking")]
use super::device::wait_for;
use super::device::{GpuError, new_encoder};

/// What `buffer` (usage `COPY_SRC`) holds once all submitted work is done. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
#[cfg(feature = "blocking")]
pub fn read_buffer<T: Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, GpuError> {
    wait_for(device, read_buffer_async(device, queue, buffer))
}

/// What `buffer` (usage `COPY_SRC`) holds once all work is done that was submitted before.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
pub async fn read_buffer_async<T: Pod>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<T>, GpuError> {
    let staging = staging_buffer(device, buffer.size());
    let mut encoder = new_encoder(device);
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
    queue.submit([encoder.finish()]);
    Ok(bytemuck::pod_collect_to_vec(&mapped(&staging).await?))
}

/// The texels of level 0 of `texture` (usage `COPY_SRC`, 2D, uncompressed), row by row from the top, of the
/// first layer. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
#[cfg(feature = "blocking")]
pub fn read_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, GpuError> {
    wait_for(device, read_texture_async(device, queue, texture))
}

/// The texels of level 0 of `texture` (usage `COPY_SRC`, 2D, uncompressed), row by row from the top, of the
/// first layer, once all work is done that was submitted before.
///
/// # Errors
/// [`GpuError::Lost`] if the GPU does not answer.
pub async fn read_texture_async(
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
    let padded = mapped(&staging).await?;
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

/// What a device says about a mapping, and who is to hear it.
#[derive(Default)]
struct Answer {
    said: Option<Result<(), wgpu::BufferAsyncError>>,
    listener: Option<Waker>,
}

/// What a staging buffer holds, once the GPU is done with it.
async fn mapped(staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let answer = Arc::new(Mutex::new(Answer::default()));
    let heard = Arc::clone(&answer);
    staging.slice(..).map_async(wgpu::MapMode::Read, move |said| {
        let mut answer = heard.lock().unwrap_or_else(PoisonError::into_inner);
        answer.said = Some(said);
        let listener = answer.listener.take();
        // Whoever wakes up may ask at once.
        drop(answer);
        listener.into_iter().for_each(Waker::wake);
    });
    let said = poll_fn(|context| {
        let mut answer = answer.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(said) = answer.said.take() {
            return Poll::Ready(said);
        }
        answer.listener = Some(context.waker().clone());
        Poll::Pending
    });
    said.await.map_err(|error| GpuError::Lost { reason: error.to_string() })?;
    Ok(staging.slice(..).get_mapped_range().to_vec())
}
