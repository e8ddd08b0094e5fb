//! Jumps of the irradiance where clusters meet.
//!
//! Each cluster approximates its own transport, so neighbouring texels of two clusters may differ by more than
//! the light does. In a row of six texels, a b c | d e f, the jump is the largest step between c and d or beside
//! them that the slopes at both ends, `½ ((b − a) + (f − e))`, do not explain, relative to the mean of c and d: a
//! jump that is spread over three steps counts as a third. The same figure inside clusters tells how much of it is
//! noise and curvature.

use probelight_asset::{BakedScene, NONE};
use probelight_math::color::luminance;
use probelight_math::glam::Vec3;
use serde::Serialize;

use crate::percentile::percentile;

/// This share of the mean luminance is added to the denominators, so that the dark does not dominate.
const DARK_TEXEL_SHARE: f32 = 0.02;

/// Relative jumps between neighbouring texels; `None` where there is no row to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BorderJumps {
    /// Rows of six texels across a border between two clusters.
    pub rows: usize,
    /// Median jump at the borders.
    pub median: Option<f64>,
    /// 99th percentile at the borders.
    pub p99: Option<f64>,
    /// Median of the same inside clusters.
    pub median_inside: Option<f64>,
    /// 99th percentile inside clusters.
    pub p99_inside: Option<f64>,
}

impl BorderJumps {
    /// Measures a lightmap: one irradiance (W/m²) per texel, row by row.
    ///
    /// # Panics
    /// If the lightmap is not as large as the baked one.
    pub fn measure(baked: &BakedScene, lightmap: &[Vec3]) -> Self {
        let size = [baked.lightmap.width as usize, baked.lightmap.height as usize];
        assert_eq!(lightmap.len(), size[0] * size[1], "the lightmap is another one");
        let mut cluster_of_texel = vec![NONE; lightmap.len()];
        for (number, cluster) in (0..).zip(&baked.clusters) {
            for texel in baked.texels(cluster) {
                cluster_of_texel[*texel as usize] = number;
            }
        }
        let luminances: Vec<f32> = lightmap.iter().map(|irradiance| luminance(*irradiance)).collect();
        Self::of_grid(size, &cluster_of_texel, &luminances)
    }

    /// Measures a grid of `[width, height]` values, each of a cluster or [`NONE`].
    fn of_grid([width, height]: [usize; 2], clusters: &[u32], values: &[f32]) -> Self {
        let lit = || clusters.iter().zip(values).filter(|(cluster, _)| **cluster != NONE);
        let mean = lit().map(|(_, value)| f64::from(*value)).sum::<f64>() / lit().count().max(1) as f64;
        let dark = DARK_TEXEL_SHARE * mean as f32;
        let (mut at_borders, mut inside) = (Vec::new(), Vec::new());
        for (step, columns, rows) in
            [(1, width.saturating_sub(5), height), (width, width, height.saturating_sub(5))]
        {
            for texel in (0..rows).flat_map(|y| (0..columns).map(move |x| y * width + x)) {
                let row: [usize; 6] = std::array::from_fn(|i| texel + i * step);
                let crossed = row.map(|texel| clusters[texel]);
                let (before, behind) = crossed.split_at(3);
                let is_one = |side: &[u32]| side[0] != NONE && side.iter().all(|c| *c == side[0]);
                if !is_one(before) || !is_one(behind) {
                    continue;
                }
                let [a, b, c, d, e, f] = row.map(|texel| values[texel]);
                let slope = 0.5 * ((b - a) + (f - e));
                let jump =
                    [c - b, d - c, e - d].iter().fold(0f32, |most, step| most.max((step - slope).abs()));
                let relative = jump / (0.5 * (c + d).abs() + dark).max(f32::MIN_POSITIVE);
                if before == behind { inside.push(relative) } else { at_borders.push(relative) }
            }
        }
        at_borders.sort_by(f32::total_cmp);
        inside.sort_by(f32::total_cmp);
        Self {
            rows: at_borders.len(),
            median: percentile(&at_borders, 0.5),
            p99: percentile(&at_borders, 0.99),
            median_inside: percentile(&inside, 0.5),
            p99_inside: percentile(&inside, 0.99),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 30];

    /// A slope across two clusters that meet at x = 20, the second of which is brighter by `offset`.
    fn slope_with_offset(offset: f32) -> BorderJumps {
        let x_of = |texel: usize| texel % SIZE[0];
        let texels = 0..SIZE[0] * SIZE[1];
        let clusters: Vec<u32> = texels.clone().map(|texel| u32::from(x_of(texel) >= 20)).collect();
        let value = |texel| 1.0 + 0.01 * x_of(texel) as f32 + if x_of(texel) >= 20 { offset } else { 0.0 };
        BorderJumps::of_grid(SIZE, &clusters, &texels.map(value).collect::<Vec<f32>>())
    }

    #[test]
    fn a_slope_is_no_jump_and_an_offset_is() {
        let smooth = slope_with_offset(0.0);
        assert_eq!(smooth.rows, SIZE[1]);
        assert!(smooth.p99.unwrap() < 1e-5 && smooth.p99_inside.unwrap() < 1e-5);
        let offset = slope_with_offset(0.1);
        let expected = 0.1 / (1.0 + 0.195 + 0.05 + 0.02 * 1.245);
        assert!((offset.median.unwrap() - expected).abs() < 1e-3, "{offset:?} {expected}");
        assert!(offset.p99_inside.unwrap() < 1e-5);
    }

    #[test]
    fn a_jump_over_three_steps_counts_as_a_third() {
        let clusters = [0, 0, 0, 1, 1, 1];
        let jump = |values: &[f32]| BorderJumps::of_grid([6, 1], &clusters, values).median.unwrap();
        let (at_once, spread) =
            (jump(&[1.0, 1.0, 1.0, 1.3, 1.3, 1.3]), jump(&[1.0, 1.0, 1.1, 1.2, 1.3, 1.3]));
        assert!((at_once / spread - 3.0).abs() < 1e-4, "{at_once} {spread}");
    }

    #[test]
    fn texels_without_receivers_part_what_lies_around_them() {
        let mut clusters = vec![0; SIZE[0] * SIZE[1]];
        for row in clusters.chunks_mut(SIZE[0]) {
            row[20..].fill(1);
            row[20] = NONE;
        }
        let jumps = BorderJumps::of_grid(SIZE, &clusters, &vec![1.0; clusters.len()]);
        assert_eq!((jumps.rows, jumps.p99, jumps.p99_inside), (0, None, Some(0.0)));
    }
}
