//! Differences between images.

use probelight_math::color::{luminance, srgb_from_linear};
use probelight_math::glam::Vec3;

use crate::EvalError;

/// A picture of someone else's, linear Rec. 709, rows from the top.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: &'a [Vec3],
}

impl<'a> ImageView<'a> {
    /// Wraps `width × height` pixels.
    ///
    /// # Errors
    /// [`EvalError::Mismatch`] if there are no pixels, not `width × height` of them, or one is not finite.
    pub fn new(width: usize, height: usize, pixels: &'a [Vec3]) -> Result<Self, EvalError> {
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            let count = pixels.len();
            return Err(EvalError::mismatch(format!("{count} pixels in an image of {width} × {height}")));
        }
        if let Some(p) = pixels.iter().position(|pixel| !pixel.is_finite()) {
            let (x, y) = (p % width, p / width);
            return Err(EvalError::mismatch(format!("pixel ({x}, {y}) is not finite")));
        }
        Ok(Self { width, height, pixels })
    }

    pub(crate) fn check_same_size(&self, other: &Self) -> Result<(), EvalError> {
        if (self.width, self.height) == (other.width, other.height) {
            return Ok(());
        }
        Err(EvalError::mismatch(format!(
            "an image of {} × {} pixels and one of {} × {}",
            self.width, self.height, other.width, other.height
        )))
    }

    /// Luminance as a display would get it: sRGB-encoded, in [0, 1].
    fn encoded_luminance(&self) -> Vec<f64> {
        let encode = |pixel: &Vec3| f64::from(srgb_from_linear(luminance(*pixel).clamp(0.0, 1.0)));
        self.pixels.iter().map(encode).collect()
    }
}

/// Keeps dark pixels from dominating [`relative_mse`]; for pictures whose white is near 1.
const RELATIVE_MSE_FLOOR: f64 = 0.01;

/// Mean of (a − ref)² / (ref² + 0.01) over pixels and channels of linear images: for high dynamic range.
///
/// # Errors
/// [`EvalError::Mismatch`] if the sizes differ.
pub fn relative_mse(image: &ImageView, reference: &ImageView) -> Result<f64, EvalError> {
    image.check_same_size(reference)?;
    let sum: f64 = image
        .pixels
        .iter()
        .zip(reference.pixels)
        .flat_map(|(a, b)| a.to_array().into_iter().zip(b.to_array()))
        .map(|(a, b)| (f64::from(a), f64::from(b)))
        .map(|(a, b)| (a - b).powi(2) / (b * b + RELATIVE_MSE_FLOOR))
        .sum();
    Ok(sum / (3 * image.pixels.len()) as f64)
}

/// Pixels from the centre of SSIM's window to its border: 11 × 11 in all.
const WINDOW_RADIUS: usize = 5;

/// Standard deviation of the window's Gaussian, pixels.
const WINDOW_SIGMA: f64 = 1.5;

/// (K₁L)² and (K₂L)² for values in [0, L = 1].
const STABILIZERS: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// Mean structural similarity, at most 1, of the sRGB-encoded luminances clamped to [0, 1]: expose and tone
/// map first. Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to Structural
/// Similarity", IEEE TIP 13(4), 2004: Gaussian window, windows that lie inside the image.
///
/// # Errors
/// [`EvalError::Mismatch`] if the sizes differ or a side is shorter than the window's 11 pixels.
pub fn ssim(image: &ImageView, reference: &ImageView) -> Result<f64, EvalError> {
    image.check_same_size(reference)?;
    let (width, height) = (image.width, image.height);
    if width.min(height) <= 2 * WINDOW_RADIUS {
        let window = 2 * WINDOW_RADIUS + 1;
        return Err(EvalError::mismatch(format!("SSIM needs {window} × {window} pixels or more")));
    }
    let (a, b) = (image.encoded_luminance(), reference.encoded_luminance());
    let blurred = |f: &dyn Fn(f64, f64) -> f64| {
        let values: Vec<f64> = a.iter().zip(&b).map(|(a, b)| f(*a, *b)).collect();
        blur(&values, width, height)
    };
    let (mean_a, mean_b) = (blurred(&|a, _| a), blurred(&|_, b| b));
    let (aa, bb, ab) = (blurred(&|a, _| a * a), blurred(&|_, b| b * b), blurred(&|a, b| a * b));
    let similarity = |i: usize| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (variance_a, variance_b, covariance) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
        let [c1, c2] = STABILIZERS;
        (2.0 * ma * mb + c1) * (2.0 * covariance + c2)
            / ((ma * ma + mb * mb + c1) * (variance_a + variance_b + c2))
    };
    Ok((0..mean_a.len()).map(similarity).sum::<f64>() / mean_a.len() as f64)
}

/// Gaussian-weighted means over all windows that lie inside the image, rows first.
fn blur(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    let kernel = gaussian();
    let (inner_width, inner_height) = (width - 2 * WINDOW_RADIUS, height - 2 * WINDOW_RADIUS);
    let mut rows = Vec::with_capacity(inner_width * height);
    for row in values.chunks_exact(width) {
        rows.extend(
            row.windows(kernel.len()).map(|w| w.iter().zip(&kernel).map(|(v, k)| v * k).sum::<f64>()),
        );
    }
    let column = |i: usize| kernel.iter().enumerate().map(|(k, g)| g * rows[i + k * inner_width]).sum();
    (0..inner_width * inner_height).map(column).collect()
}

fn gaussian() -> [f64; 2 * WINDOW_RADIUS + 1] {
    let weight = |i: usize| (-0.5 * ((i as f64 - WINDOW_RADIUS as f64) / WINDOW_SIGMA).powi(2)).exp();
    let weights = std::array::from_fn(weight);
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use probelight_math::color::linear_from_srgb;

    /// A 20 × 16 image of encoded grey values.
    fn pixels(encoded: impl Fn(usize, usize) -> f32) -> Vec<Vec3> {
        let grey = |i: usize| Vec3::splat(linear_from_srgb(encoded(i % 20, i / 20)));
        (0..20 * 16).map(grey).collect()
    }

    fn view(pixels: &[Vec3]) -> ImageView<'_> {
        ImageView::new(20, 16, pixels).unwrap()
    }

    #[test]
    fn an_image_is_like_itself_and_unlike_its_negative() {
        let board = |x: usize, y: usize| if (x / 3 + y / 2).is_multiple_of(2) { 0.2 } else { 0.8 };
        let (image, negative) = (pixels(board), pixels(|x, y| 1.0 - board(x, y)));
        assert!((ssim(&view(&image), &view(&image)).unwrap() - 1.0).abs() < 1e-12);
        assert!(ssim(&view(&image), &view(&negative)).unwrap() < -0.5);
        assert_eq!(relative_mse(&view(&image), &view(&image)).unwrap(), 0.0);
        assert!(relative_mse(&view(&image), &view(&negative)).unwrap() > 0.5);
    }

    #[test]
    fn ssim_of_constant_images_is_the_luminance_term() {
        let (a, b) = (pixels(|_, _| 0.3), pixels(|_, _| 0.6));
        let expected = (2.0 * 0.3 * 0.6 + 1e-4) / (0.3 * 0.3 + 0.6 * 0.6 + 1e-4);
        let value = ssim(&view(&a), &view(&b)).unwrap();
        assert!((value - expected).abs() < 1e-5, "{value} instead of {expected}");
    }

    #[test]
    fn ssim_falls_as_noise_grows() {
        let noisy = |amplitude: f32| {
            pixels(move |x, y| 0.5 + amplitude * ((x * 7 + y * 13) % 11) as f32 / 11.0 + 0.01 * x as f32)
        };
        let clean = noisy(0.0);
        let [weak, strong] =
            [0.02, 0.2].map(|amplitude| ssim(&view(&noisy(amplitude)), &view(&clean)).unwrap());
        assert!(1.0 > weak && weak > strong + 0.1, "{weak} {strong}");
    }

    #[test]
    fn relative_mse_agrees_with_its_closed_form() {
        let (a, b) = ([Vec3::new(3.0, 2.0, 1.0)], [Vec3::new(1.0, 2.0, 0.0)]);
        let (a, b) = (ImageView::new(1, 1, &a).unwrap(), ImageView::new(1, 1, &b).unwrap());
        let value = relative_mse(&a, &b).unwrap();
        assert!((value - (4.0 / 1.01 + 1.0 / 0.01) / 3.0).abs() < 1e-9, "{value}");
    }

    #[test]
    fn images_that_do_not_fit_are_refused() {
        let image = pixels(|_, _| 0.5);
        let small = &image[..100];
        assert!(ImageView::new(20, 15, &image).is_err());
        assert!(ImageView::new(0, 0, &[]).is_err());
        assert!(ImageView::new(1, 1, &[Vec3::NAN]).is_err());
        let small = ImageView::new(10, 10, small).unwrap();
        assert!(ssim(&small, &view(&image)).is_err() && relative_mse(&view(&image), &small).is_err());
        assert!(ssim(&small, &small).unwrap_err().to_string().contains("11 × 11"));
    }
}
