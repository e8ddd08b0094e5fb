//! Buffers with content, checked against what a device can hold.

use wgpu::BufferUsages;
use wgpu::util::DeviceExt;

use super::device::GpuError;

/// Shaders cannot bind empty arrays, and vertex buffers cannot be empty: those without content hold so many zeros.
const LEAST: usize = 64;

/// Most bytes of a buffer with some uses.
pub fn largest_buffer(limits: &wgpu::Limits, usage: BufferUsages) -> u64 {
    let bound = |usage_bit, limit| if usage.contains(usage_bit) { limit } else { u64::MAX };
    limits
        .max_buffer_size
        .min(bound(BufferUsages::STORAGE, limits.max_storage_buffer_binding_size))
        .min(bound(BufferUsages::UNIFORM, limits.max_uniform_buffer_binding_size))
}

/// A buffer that holds `bytes`, which are called `content` where they are too many.
///
/// # Errors
/// [`GpuError::TooLarge`] if the device cannot hold so many, or its shaders cannot bind them.
pub fn filled_buffer(
    device: &wgpu::Device,
    content: &'static str,
    bytes: &[u8],
    usage: BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    check_size(&device.limits(), content, bytes.len() as u64, usage)?;
    let contents = if bytes.is_empty() { &[0; LEAST] } else { bytes };
    let descriptor = wgpu::util::BufferInitDescriptor { label: Some(content), contents, usage };
    Ok(device.create_buffer_init(&descriptor))
}

/// Whether a device with some limits can hold so many bytes for some uses.
///
/// # Errors
/// [`GpuError::TooLarge`] if not.
pub fn check_size(
    limits: &wgpu::Limits,
    content: &'static str,
    bytes: u64,
    usage: BufferUsages,
) -> Result<(), GpuError> {
    let limit = largest_buffer(limits, usage);
    if bytes > limit { Err(GpuError::TooLarge { content, bytes, limit }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_use_has_its_limit() {
        let limits = wgpu::Limits {
            max_buffer_size: 1000,
            max_storage_buffer_binding_size: 100,
            max_uniform_buffer_binding_size: 10,
            ..wgpu::Limits::default()
        };
        let fits = |bytes, usage| check_size(&limits, "content", bytes, usage).is_ok();
        for (usage, limit) in [
            (BufferUsages::VERTEX, 1000),
            (BufferUsages::VERTEX | BufferUsages::STORAGE, 100),
            (BufferUsages::UNIFORM | BufferUsages::COPY_DST, 10),
        ] {
            assert!(fits(limit, usage) && !fits(limit + 1, usage), "{usage:?}");
        }
    }

    #[test]
    fn what_is_too_large_is_named() {
        let faces = 2_800_000 * 48;
        let error = check_size(&wgpu::Limits::default(), "lightmap faces", faces, BufferUsages::STORAGE);
        let message = error.unwrap_err().to_string();
        assert!(message.contains("lightmap faces") && message.contains("134400000"), "{message}");
    }
}
