//! How bright the picture is: for automatic exposure and the histogram. Measured on a small picture, some frames late.

use half::f16;
use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use probelight_render::gpu::{PictureTarget, ViewOptions};
use probelight_render::{Exposure, Image, ToneMap};
use probelight_runtime::gpu::readback::read_texture_async;
use probelight_runtime::gpu::{GpuDevice, GpuError};
use probelight_scene::Camera;

use crate::scene::live_scene::LiveScene;
use crate::scene::pending::{Pending, take_ready};

/// Width of the small picture, pixels.
const WIDTH: u32 = 160;

/// Stops of the histogram, below and above a radiance of 1.
pub const STOPS: std::ops::Range<i32> = -16..16;

/// What the meter says.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Exposure that suits the picture, as a power of two.
    pub ev: f32,
    /// Number of pixels by their radiance, half a stop each.
    pub histogram: Vec<u32>,
    /// Share of pixels that are no number, or negative.
    pub broken: f32,
}

/// Measures now and then.
pub struct Meter {
    pending: Option<Pending<Result<Vec<u8>, GpuError>>>,
    size: (u32, u32),
    /// What it said last.
    pub reading: Option<Reading>,
}

impl Meter {
    /// Has said nothing yet.
    pub fn new() -> Self {
        Self { pending: None, size: (0, 0), reading: None }
    }

    /// Draws a small picture to be measured, unless one is on its way.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn measure(
        &mut self,
        live: &mut LiveScene,
        camera: &Camera,
        options: ViewOptions,
    ) -> Result<(), GpuError> {
        if self.pending.is_some() {
            return Ok(());
        }
        let GpuDevice { device, queue, .. } = live.gpu.clone();
        let height = (WIDTH * camera.height / camera.width.max(1)).clamp(1, WIDTH);
        let small = Camera { width: WIDTH, height, ..camera.clone() };
        let target = PictureTarget::new(&device, WIDTH, height)?;
        live.draw(&target, &small, options);
        let read = async move { read_texture_async(&device, &queue, target.texture()).await };
        self.size = (WIDTH, height);
        self.pending = Some(Pending::new(read));
        Ok(())
    }

    /// Whether something is on its way.
    pub fn is_measuring(&self) -> bool {
        self.pending.is_some()
    }

    /// Takes what has arrived. Returns whether there was something.
    pub fn update(&mut self) -> bool {
        let Some(Ok(bytes)) = take_ready(&mut self.pending) else { return false };
        let half = |texel: &[u8], c: usize| f16::from_le_bytes([texel[2 * c], texel[2 * c + 1]]).to_f32();
        let pixels =
            bytes.chunks_exact(8).map(|texel| Vec3::from([0, 1, 2].map(|c| half(texel, c)))).collect();
        self.reading = Some(read(Image { width: self.size.0, height: self.size.1, pixels }));
        true
    }
}

impl Default for Meter {
    fn default() -> Self {
        Self::new()
    }
}

fn read(image: Image) -> Reading {
    let mut histogram = vec![0; 2 * STOPS.len()];
    let mut broken = 0;
    for pixel in &image.pixels {
        if !pixel.is_finite() || pixel.min_element() < 0.0 {
            broken += 1;
            continue;
        }
        let stop = 2.0 * (luminance(*pixel).log2() - STOPS.start as f32);
        if stop >= 0.0 {
            histogram[(stop as usize).min(2 * STOPS.len() - 1)] += 1;
        }
    }
    let ev = ToneMap::new(Exposure::Automatic, &image).ev();
    Reading { ev, histogram, broken: broken as f32 / image.pixels.len().max(1) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_counted_by_their_stop() {
        let mut image = Image::filled(10, 1, Vec3::splat(4.0));
        image.pixels[0] = Vec3::NAN;
        image.pixels[1] = Vec3::new(-1.0, 1.0, 1.0);
        image.pixels[2] = Vec3::ZERO;
        let reading = read(image);
        assert_eq!(reading.histogram[2 * (2 - STOPS.start) as usize], 7);
        assert_eq!(reading.histogram.iter().sum::<u32>(), 7);
        assert_eq!(reading.broken, 0.2);
    }
}
