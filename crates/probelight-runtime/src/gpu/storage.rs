//! Buffers that shaders read and write.

use bytemuck::NoUninit;
use wgpu::BufferUsages;

use super::device::GpuError;
use super::filled_buffer::largest_buffer;

/// Empty buffers are made this long, bytes, because shaders cannot bind empty arrays: as long as the longest record.
/// All others are as long as their content, so that shaders know its end.
const PLACEHOLDER: u64 = 64;

/// Buffers are written in pieces of this many bytes.
const WORD: usize = wgpu::COPY_BUFFER_ALIGNMENT as usize;

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
        Self { device, queue, limit: largest_buffer(&device.limits(), BufferUsages::STORAGE) }
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

    /// A storage buffer with the given content, and zeros up to a whole word.
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
        write_words(self.queue, &buffer, 0, bytes);
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

/// Writes bytes to a place at a whole word, and zeros up to the next one.
pub(super) fn write_words(queue: &wgpu::Queue, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
    // Only whole words can be written.
    let (words, rest) = bytes.as_chunks::<WORD>();
    queue.write_buffer(buffer, offset, words.as_flattened());
    if !rest.is_empty() {
        let mut last = [0; WORD];
        last[..rest.len()].copy_from_slice(rest);
        queue.write_buffer(buffer, offset + (words.len() * WORD) as u64, &last);
    }
}
