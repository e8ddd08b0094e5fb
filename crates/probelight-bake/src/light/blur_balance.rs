//! Keeps light from being blurred into the open.
//!
//! A probe's spherical harmonics spread the light of each place over the directions around it. Where those lead to
//! no surface, past the edge of a roof or out of a window, nobody asks for it and it would be lost. How much of the
//! blur around a direction lies on surfaces is the probe's *coverage*. Light that is measured is raised by its inverse
//! square root, and so is light that is read: then a place gives to all others about as much as it has, and
//! surfaces that are equally bright everywhere are read as just that. (The first step of Sinkhorn 1967.)

use std::ops::RangeInclusive;

use probelight_asset::{GAIN_STEPS, NONE};
use probelight_math::directions::weighted_basis;
use probelight_math::glam::Vec3;
use probelight_math::sh::Basis;
use rayon::prelude::*;

use crate::light::ensemble::add_scaled;

/// Where less of the blur lies on surfaces, hardly anything is known of them; twice as much are the ripples of
/// truncated bands.
const COVERAGE: RangeInclusive<f32> = 0.25..=2.0;

/// How much of a blur lies on surfaces, limited to what can be divided by.
pub(crate) fn limited(coverage: f32) -> f32 {
    coverage.clamp(*COVERAGE.start(), *COVERAGE.end())
}

/// What raises the light of surfaces that probes measure, and how it is read.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlurBalance {
    /// Of each relight ray, in parts of [`GAIN_STEPS`].
    pub(crate) gains: Vec<u8>,
    /// What each probe measures if all surfaces have radiance 1: coefficients, probe by probe.
    pub(crate) coverage: Vec<f32>,
}

impl BlurBalance {
    /// For probes whose relight rays meet the given surfels, or [`NONE`]; a probe's rays in a row.
    pub(crate) fn of(relight_surfels: &[u32], directions: &[Vec3], sh_degree: usize) -> Self {
        let basis = Basis::new(sh_degree);
        let weighted = weighted_basis(directions, sh_degree);
        let mut plain = vec![0.0; weighted.len()];
        for (values, direction) in plain.chunks_exact_mut(basis.len()).zip(directions) {
            basis.evaluate(*direction, values);
        }
        let one = f32::from(GAIN_STEPS);
        let of_probe = |surfels: &[u32]| {
            let measured = |gains: &[u8]| {
                let mut sums = vec![0.0; basis.len()];
                let rays = surfels.iter().zip(gains).zip(weighted.chunks_exact(basis.len()));
                for ((_, gain), row) in rays.filter(|((surfel, _), _)| **surfel != NONE) {
                    add_scaled(&mut sums, f32::from(*gain) / one, row);
                }
                sums
            };
            let even = measured(&vec![GAIN_STEPS; surfels.len()]);
            let gain = |(surfel, row): (&u32, &[f32])| {
                if *surfel == NONE {
                    return GAIN_STEPS;
                }
                let coverage: f32 = row.iter().zip(&even).map(|(y, sum)| y * sum).sum();
                (one / limited(coverage).sqrt()).round() as u8
            };
            let gains: Vec<u8> = surfels.iter().zip(plain.chunks_exact(basis.len())).map(gain).collect();
            let coverage = measured(&gains);
            (gains, coverage)
        };
        let rays = directions.len().max(1);
        let probes: Vec<(Vec<u8>, Vec<f32>)> = relight_surfels.par_chunks(rays).map(of_probe).collect();
        let (gains, coverage): (Vec<_>, Vec<_>) = probes.into_iter().unzip();
        Self { gains: gains.concat(), coverage: coverage.concat() }
    }

    /// Light that is read as it was measured, whatever lies beside it: \[SED\]'s.
    pub(crate) fn none(relight_rays: usize) -> Self {
        Self { gains: vec![GAIN_STEPS; relight_rays], coverage: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use probelight_math::directions::progressive_sphere;
    use probelight_math::sh::Y00;

    use super::*;

    const DEGREE: usize = 7;

    /// A probe above the plain: all that lies below the horizon is surface.
    fn plain(directions: &[Vec3]) -> Vec<u32> {
        directions.iter().map(|d| if d.y < 0.0 { 0 } else { NONE }).collect()
    }

    /// Light that all directions to surfaces read, if the given rays bring a radiance of 1; as a share of what these
    /// measure.
    fn share_read(
        balance: &BlurBalance,
        directions: &[Vec3],
        surfels: &[u32],
        lit: impl Fn(Vec3) -> bool,
    ) -> f32 {
        let basis = Basis::new(DEGREE);
        let weighted = weighted_basis(directions, DEGREE);
        // Band 0 is the same everywhere, so that the first values are the weights.
        let weight = |ray: usize| weighted[ray * basis.len()] / Y00;
        let to_surface = || (0..directions.len()).filter(|ray| surfels[*ray] != NONE);
        let (mut measured, mut coefficients) = (0.0, vec![0.0; basis.len()]);
        for ray in to_surface().filter(|ray| lit(directions[*ray])) {
            measured += weight(ray);
            let gain = f32::from(balance.gains[ray]) / f32::from(GAIN_STEPS);
            let row = &weighted[ray * basis.len()..][..basis.len()];
            add_scaled(&mut coefficients, gain, row);
        }
        let mut values = vec![0.0; basis.len()];
        let read = to_surface().map(|ray| {
            basis.evaluate(directions[ray], &mut values);
            let dot = |other: &[f32]| values.iter().zip(other).map(|(y, v)| y * v).sum::<f32>();
            let coverage = if balance.coverage.is_empty() { 1.0 } else { limited(dot(&balance.coverage)) };
            weight(ray) * dot(&coefficients) / coverage
        });
        read.sum::<f32>() / measured
    }

    #[test]
    fn nothing_is_raised_where_surfaces_are_all_around() {
        let directions = progressive_sphere(512);
        let balance = BlurBalance::of(&[3; 1024], &directions, DEGREE);
        assert_eq!(balance.gains, [GAIN_STEPS; 1024]);
        for (j, value) in balance.coverage.iter().enumerate() {
            let expected = if j % 64 == 0 { 1.0 / Y00 } else { 0.0 };
            assert!((value - expected).abs() < 1e-4, "{j}: {value}");
        }
    }

    #[test]
    fn light_beside_the_open_is_not_lost() {
        let directions = progressive_sphere(1024);
        let surfels = plain(&directions);
        let at_the_edge = |d: Vec3| d.y > -0.15;
        let balance = BlurBalance::of(&surfels, &directions, DEGREE);
        let kept = share_read(&balance, &directions, &surfels, at_the_edge);
        assert!((kept - 1.0).abs() < 0.1, "{kept}");
        // Light in the middle keeps its energy, too.
        let kept = share_read(&balance, &directions, &surfels, |d| d.y < -0.8);
        assert!((kept - 1.0).abs() < 0.04, "{kept}");
        // Light that is the same everywhere is read as it is.
        let kept = share_read(&balance, &directions, &surfels, |_| true);
        assert!((kept - 1.0).abs() < 1e-3, "{kept}");
        // Negative control: as the paper has it, the open takes nearly half of what is beside it.
        let kept = share_read(&BlurBalance::none(1024), &directions, &surfels, at_the_edge);
        assert!(kept < 0.75, "{kept}");
    }
}
