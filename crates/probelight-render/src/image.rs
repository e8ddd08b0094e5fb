//! Linear pictures.

use probelight_math::glam::Vec3;

/// Linear Rec. 709 pixels, rows from the top. Usually radiance in W·m⁻²·sr⁻¹.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// `width × height` pixels.
    pub pixels: Vec<Vec3>,
}

impl Image {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, pixel: Vec3) -> Self {
        Self { width, height, pixels: vec![pixel; width as usize * height as usize] }
    }

    /// The pixel in column `x` of row `y`, counted from the top left.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> Vec3 {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The picture at a whole fraction of its size: means over squares of `factor × factor` pixels. Rows and
    /// columns left over are cut off.
    pub fn reduced(&self, factor: u32) -> Self {
        let factor = factor.max(1);
        let (width, height) = (self.width / factor, self.height / factor);
        let mean = |x: u32, y: u32| {
            let square = (0..factor).flat_map(|dy| (0..factor).map(move |dx| (dx, dy)));
            let sum: Vec3 = square.map(|(dx, dy)| self.pixel(x * factor + dx, y * factor + dy)).sum();
            sum / (factor * factor) as f32
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y));
        Self { width, height, pixels: pixels.collect() }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn gradient() -> Image {
        let mut image = Image::filled(7, 5, Vec3::ZERO);
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = Vec3::new(i as f32 * 0.37, 1e5 / (i as f32 + 1.0), -(i as f32));
        }
        image
    }

    #[test]
    fn reducing_takes_means_of_squares() {
        let half = gradient().reduced(2);
        assert_eq!((half.width, half.height, half.pixels.len()), (3, 2, 6));
        let image = gradient();
        let square = [(4, 2), (5, 2), (4, 3), (5, 3)].map(|(x, y)| image.pixel(x, y));
        assert!(half.pixel(2, 1).abs_diff_eq(square.iter().sum::<Vec3>() / 4.0, 1e-3));
        assert_eq!(gradient().reduced(1), gradient());
    }
}
