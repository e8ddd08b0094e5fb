//! Reference images.

use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::Camera;
use rayon::prelude::*;

use super::PathTracer;
use super::integrator::DirectionChoice;
use super::sampler::{Sampler, sequence_seed};
use crate::{Cancelled, Progress, Ray};

impl PathTracer {
    /// Linear radiance (W·m⁻²·sr⁻¹) of every pixel, rows from the top: the mean over the pixel's square of
    /// `samples_per_pixel` paths. The result depends on `seed` but not on the number of threads.
    ///
    /// # Errors
    /// [`Cancelled`] if `progress` asks to stop.
    pub fn render(
        &self,
        camera: &Camera,
        samples_per_pixel: u32,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec3>, Cancelled> {
        progress.begin("tracing paths", u64::from(camera.height));
        let mut pixels = vec![Vec3::ZERO; camera.width as usize * camera.height as usize];
        pixels.par_chunks_mut(camera.width.max(1) as usize).enumerate().try_for_each(|(y, row)| {
            if progress.is_cancelled() {
                return Err(Cancelled);
            }
            for (x, pixel) in row.iter_mut().enumerate() {
                let index = y as u64 * u64::from(camera.width) + x as u64;
                let corner = Vec2::new(x as f32, y as f32);
                *pixel = self.pixel(camera, corner, samples_per_pixel.max(1), sequence_seed(seed, index));
            }
            progress.advance(1);
            Ok(())
        })?;
        Ok(pixels)
    }

    fn pixel(&self, camera: &Camera, corner: Vec2, samples: u32, seed: u32) -> Vec3 {
        let sum: Vec3 = (0..samples)
            .map(|index| {
                let mut sampler = Sampler::new(index, seed);
                let direction = camera.ray_direction(corner + sampler.next_pair());
                let ray = Ray::new(camera.position, direction);
                let arriving = self.arriving_radiance(&ray, DirectionChoice::Given, &mut sampler);
                arriving.emitted + arriving.sky + arriving.reflected
            })
            .sum();
        sum / samples as f32
    }
}
