//! Buffers that shaders read and write.

use bytemuck::NoUninit;
use wgpu::BufferUsages;

use super::device::GpuError;

/// Empty buffers are made this long, bytes, because shaders cannot bind empty arrays: as long as the longest record.
/// All others are as long as their content, so that shaders know its end.
const PLACEHOLDER: u64 = 64;

/// Makes buffers on a device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storage<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) queue: &'a wgpu::Queue,
    /// Most bytes of a buffer.
    pub(super) limit: u64,
}

impl<'a> Storage<'a> {
    /// With buffers as long as the device lets shaders bind.
    pub(super) fn new(device: &'a wgpu::Device, queue: &'a wgpu::Queue) -> Self {
        let limits = device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        Self { device, queue, limit }
    }

    /// A storage buffer of zeros.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if a shader could not bind it.
    pub(super) fn zeros(&self, content: &'static str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        if bytes > self.limit {
            return Err(GpuError::TooLarge { content, bytes, limit: self.limit });
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        Ok(self.buffer(content, bytes, usage))
    }

    /// A storage buffer with the given content.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if a shader could not bind it.
    pub(super) fn array<T: NoUninit>(
        &self,
        content: &'static str,
        values: &[T],
    ) -> Result<wgpu::Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let buffer = self.zeros(content, bytes.len() as u64)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// A uniform buffer with the given content.
    pub(super) fn uniform<T: NoUninit>(&self, content: &'static str, value: &T) -> wgpu::Buffer {
        let bytes = bytemuck::bytes_of(value);
        let buffer = self.buffer(content, bytes.len() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    fn buffer(&self, content: &str, bytes: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(content),
            size: if bytes == 0 { PLACEHOLDER } else { bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT) },
            usage,
            mapped_at_creation: false,
        })
    }
}
