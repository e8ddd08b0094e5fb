//! How different two pictures look when one flips to the other.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020; constants are the paper's. Two pipelines meet in the end:
//!
//! ```text
//!  colour    opponent colours ─► blur as the eye does ─► L*a*b* ─► Hunt ─► HyAB distance ─► 0 … 1 ─┐
//!                                                                                                   ├─► c^(1 − f)
//!  features  luminance ─► edges and points ─► difference of their strengths ─► 0 … 1 ───────────────┘
//! ```

use probelight_math::glam::{DMat3, DVec3, Vec3};

use crate::EvalError;
use crate::image_metrics::ImageView;

/// Pixels per degree of vision: a 0.7 m wide screen of 3840 pixels, looked at from 0.7 m.
const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_26;

/// Exponent of colour differences.
const COLOR_EXPONENT: f64 = 0.7;
/// Share of the largest colour difference that is mapped to [`KNEE_VALUE`]; larger ones share the rest.
const KNEE: f64 = 0.4;
const KNEE_VALUE: f64 = 0.95;
/// Width of the features that are looked for, degrees.
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f64 = 0.5;

/// Mean FLIP difference, 0 (same) to 1, of linear images as a display shows them: channels are limited to 0 … 1,
/// so expose and tone map first. Seen at 67 pixels per degree.
///
/// # Errors
/// [`EvalError::Mismatch`] if the sizes differ.
pub fn flip(image: &ImageView, reference: &ImageView) -> Result<f64, EvalError> {
    image.check_same_size(reference)?;
    let colors = [image, reference].map(perceived_colors);
    let features = [image, reference].map(features);
    let largest = largest_color_difference();
    let difference = |i: usize| {
        let color = color_difference(colors[0][i], colors[1][i], largest);
        let [edge, point] = [0, 1].map(|kind| (features[0][i][kind] - features[1][i][kind]).abs());
        let feature = (edge.max(point) / 2f64.sqrt()).powf(FEATURE_EXPONENT);
        color.powf(1.0 - feature)
    };
    let count = colors[0].len();
    Ok((0..count).map(difference).sum::<f64>() / count as f64)
}

/// The colours that the eye tells apart from its distance: blurred, in Hunt-adjusted L*a*b*.
fn perceived_colors(image: &ImageView) -> Vec<DVec3> {
    let opponent: Vec<DVec3> = image.pixels.iter().map(|p| opponent_from_linear(displayed(*p))).collect();
    let plane = |channel: usize| opponent.iter().map(|color| color[channel]).collect::<Vec<f64>>();
    let [achromatic, red_green, blue_yellow] = [0, 1, 2].map(|channel| {
        // Sensitivity to contrast, as a sum of one or two Gaussians (weight, width).
        let gaussians = [vec![(1.0, 0.0047)], vec![(1.0, 0.0053)], vec![(34.1, 0.04), (13.5, 0.025)]];
        blurred(&plane(channel), image, &gaussians[channel])
    });
    let color = |i: usize| {
        let linear = linear_from_opponent(DVec3::new(achromatic[i], red_green[i], blue_yellow[i]));
        hunt(lab_from_linear(linear.clamp(DVec3::ZERO, DVec3::ONE)))
    };
    (0..opponent.len()).map(color).collect()
}

fn displayed(pixel: Vec3) -> DVec3 {
    pixel.clamp(Vec3::ZERO, Vec3::ONE).as_dvec3()
}

/// Blurs a plane with normalised Gaussians g(x) = w √(π/b) exp(−π² x²/b), x in degrees. Each is separable.
fn blurred(plane: &[f64], image: &ImageView, gaussians: &[(f64, f64)]) -> Vec<f64> {
    use std::f64::consts::PI;
    // The radius of the widest Gaussian of all channels, so that all see the same window.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    let mut sum = vec![0.0; plane.len()];
    let mut total = 0.0;
    for (weight, width) in gaussians {
        let value = |x: i64| (-PI * PI * (x as f64 / PIXELS_PER_DEGREE).powi(2) / width).exp();
        let kernel: Vec<f64> = (-radius..=radius).map(value).collect();
        // In two dimensions the factor √(π/b) is there once, as the paper's code has it.
        let factor = weight * (PI / width).sqrt();
        let rows = convolved(plane, image, &kernel, false);
        for (sum, value) in sum.iter_mut().zip(convolved(&rows, image, &kernel, true)) {
            *sum += factor * value;
        }
        total += factor * kernel.iter().sum::<f64>().powi(2);
    }
    sum.iter().map(|value| value / total).collect()
}

/// One-dimensional convolution along rows or columns; the image goes on with its border's values.
fn convolved(plane: &[f64], image: &ImageView, kernel: &[f64], is_vertical: bool) -> Vec<f64> {
    let (width, height) = (image.width as i64, image.height as i64);
    let radius = kernel.len() as i64 / 2;
    let at = |x: i64, y: i64| plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize];
    let value = |x: i64, y: i64| {
        let tap = |(k, weight): (i64, &f64)| {
            let shift = k - radius;
            weight * if is_vertical { at(x, y + shift) } else { at(x + shift, y) }
        };
        (0..).zip(kernel).map(tap).sum()
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect()
}

/// Strength of edges and of points at each pixel.
fn features(image: &ImageView) -> Vec<[f64; 2]> {
    let luminance: Vec<f64> =
        image.pixels.iter().map(|p| (opponent_from_linear(displayed(*p)).x + 16.0) / 116.0).collect();
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let kernel = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        (-radius..=radius).map(|x| value(x as f64) * gaussian(x as f64)).collect()
    };
    let smooth = kernel(&|_| 1.0);
    let slope = balanced(&kernel(&|x| -x), &smooth);
    let curvature = balanced(&kernel(&|x| x * x / (deviation * deviation) - 1.0), &smooth);
    let strength = |derivative: &[f64]| -> Vec<f64> {
        let along = |is_vertical| {
            let derived = convolved(&luminance, image, derivative, is_vertical);
            convolved(&derived, image, &smooth, !is_vertical)
        };
        along(false).iter().zip(along(true)).map(|(x, y)| x.hypot(y)).collect()
    };
    strength(&slope).into_iter().zip(strength(&curvature)).map(|(edge, point)| [edge, point]).collect()
}

/// A derivative's kernel whose product with `smooth` has positive weights that add up to 1 and negative ones
/// that add up to −1.
fn balanced(derivative: &[f64], smooth: &[f64]) -> Vec<f64> {
    let across: f64 = smooth.iter().sum();
    let sum = |keep: fn(&f64) -> bool| derivative.iter().copied().filter(keep).sum::<f64>().abs() * across;
    let (positive, negative) = (sum(|v| *v > 0.0), sum(|v| *v < 0.0));
    derivative.iter().map(|v| if *v > 0.0 { v / positive } else { v / negative }).collect()
}

/// 0 … 1 for two perceived colours.
fn color_difference(a: DVec3, b: DVec3, largest: f64) -> f64 {
    let difference = hyab(a, b).powf(COLOR_EXPONENT);
    let knee = KNEE * largest;
    if difference < knee {
        difference * KNEE_VALUE / knee
    } else {
        KNEE_VALUE + (difference - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    }
}

/// That of the display's green and blue.
fn largest_color_difference() -> f64 {
    let [green, blue] = [DVec3::Y, DVec3::Z].map(|color| hunt(lab_from_linear(color)));
    hyab(green, blue).powf(COLOR_EXPONENT)
}

fn hyab(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// Colours look less colourful in the dark.
fn hunt(lab: DVec3) -> DVec3 {
    DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// CIE XYZ, relative to the white of D65, from linear Rec. 709.
fn relative_xyz_from_linear() -> DMat3 {
    let xyz_from_linear = DMat3::from_cols_array_2d(&[
        [10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0],
        [8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0],
        [4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0],
    ]);
    let white = xyz_from_linear * DVec3::ONE;
    DMat3::from_diagonal(white.recip()) * xyz_from_linear
}

/// YCxCz, linear opponent colours.
fn opponent_from_linear(linear: DVec3) -> DVec3 {
    let xyz = relative_xyz_from_linear() * linear;
    DVec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

fn linear_from_opponent(opponent: DVec3) -> DVec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let xyz = DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    relative_xyz_from_linear().inverse() * xyz
}

/// CIE 1976 L*a*b*.
fn lab_from_linear(linear: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let f = DVec3::from((relative_xyz_from_linear() * linear).to_array().map(root));
    DVec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 64;
    const HEIGHT: usize = 48;

    /// Stripes, a chessboard and a ramp.
    fn pattern(s: f64) -> Vec<Vec3> {
        let pixel = |x: usize, y: usize| {
            let (u, v) = (x as f64, y as f64);
            let stripes = 0.5 + 0.5 * (0.31 * u + 0.05 * s * v).sin();
            let board = ((x / 8 + y / 8) % 2) as f64 * 0.8 + 0.1 * s;
            let ramp = u / WIDTH as f64 * (v / HEIGHT as f64).powf(s);
            DVec3::new(stripes, board, ramp).clamp(DVec3::ZERO, DVec3::ONE).as_vec3()
        };
        (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
    }

    fn measured(image: &[Vec3], reference: &[Vec3]) -> f64 {
        let [image, reference] = [image, reference].map(|p| ImageView::new(WIDTH, HEIGHT, p).unwrap());
        flip(&image, &reference).unwrap()
    }

    #[test]
    fn agrees_with_the_authors_program() {
        // Means by the authors' flip-evaluator 1.7 of the same pictures.
        let mut spot = pattern(1.0);
        for y in 20..28 {
            spot[y * WIDTH + 30..y * WIDTH + 34].fill(Vec3::new(1.0, 1.0, 0.0));
        }
        let black = vec![Vec3::ZERO; WIDTH * HEIGHT];
        let white = vec![Vec3::ONE; WIDTH * HEIGHT];
        for (image, reference, expected) in [
            (&pattern(1.0), &pattern(2.0), 0.675_306),
            (&spot, &pattern(1.0), 0.036_848),
            (&white, &black, 0.967_365),
        ] {
            let found = measured(image, reference);
            assert!((found - expected).abs() < 2e-4, "{found}, not {expected}");
        }
    }

    #[test]
    fn same_pictures_do_not_differ_and_sizes_must_agree() {
        let picture = pattern(1.0);
        assert_eq!(measured(&picture, &picture), 0.0);
        let image = ImageView::new(WIDTH, HEIGHT, &picture).unwrap();
        let other = ImageView::new(HEIGHT, WIDTH, &picture).unwrap();
        assert!(flip(&image, &other).is_err());
    }
}
