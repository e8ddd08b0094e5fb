//! The table by which radiance along the relight rays becomes spherical-harmonics coefficients, for all rays and for fewer.

use probelight_asset::BakedParts;
use probelight_math::directions::{basis_table, quadrature_weights};

/// Prefixes of the rays: all of them, and each half as long as the one before.
const PREFIXES: u32 = 4;

/// Basis values with the quadrature weights of all rays, and by which factors those of shorter prefixes differ.
#[derive(Debug)]
pub(crate) struct RelightTable {
    /// Coefficients of a probe.
    pub(crate) coefficients: usize,
    /// Weighted basis values: all of the first ray, all of the second, …
    pub(crate) basis: Vec<f32>,
    /// A factor for each ray of each prefix, the longest prefix first. Those of all rays are one.
    pub(crate) weights: Vec<f32>,
}

impl RelightTable {
    /// Tabulates the basis for a scene's relight directions. The quadrature is exact for radiance within the probes'
    /// own bands, where the number of rays allows.
    pub(crate) fn new(baked: &BakedParts) -> Self {
        let (directions, degree) = (&baked.relight_directions, baked.settings.sh_degree as usize);
        let weights_of = |rays: usize| quadrature_weights(&directions[..rays], 2 * degree);
        let of_all = if directions.is_empty() { Vec::new() } else { weights_of(directions.len()) };
        let mut weights = vec![1.0; directions.len()];
        for rays in prefixes(directions.len() as u32).skip(1) {
            let ratio = |(weight, of_all): (f32, &f32)| if *of_all == 0.0 { 0.0 } else { weight / of_all };
            weights.extend(weights_of(rays as usize).into_iter().zip(&of_all).map(ratio));
        }
        Self { coefficients: baked.coefficients(), basis: basis_table(directions, &of_all, degree), weights }
    }

    /// Rays of a probe.
    #[cfg(any(feature = "cpu", test))]
    pub(crate) fn rays(&self) -> usize {
        self.basis.len() / self.coefficients
    }

    /// The factors of a prefix of so many rays.
    #[cfg(any(feature = "cpu", test))]
    pub(crate) fn weights_of(&self, rays: u32) -> &[f32] {
        &self.weights[first_weight(self.rays() as u32, rays) as usize..][..rays as usize]
    }
}

/// Where in [`RelightTable::weights`] those of the prefix with so many of the stored rays start.
pub(crate) fn first_weight(stored: u32, rays: u32) -> u32 {
    prefixes(stored).take_while(|longer| *longer != rays).sum()
}

/// Lengths of the prefixes of so many rays, the longest first; none without rays.
fn prefixes(rays: u32) -> impl Iterator<Item = u32> {
    (0..PREFIXES).map(move |halvings| rays.div_ceil(1 << halvings)).filter(|rays| *rays > 0)
}

/// The shortest prefix of so many rays that has `wanted`; all of them if there are not so many.
pub(super) fn prefix_with(rays: u32, wanted: u32) -> u32 {
    prefixes(rays).filter(|prefix| *prefix >= wanted).last().unwrap_or(rays)
}

#[cfg(test)]
mod tests {
    use probelight_math::directions::progressive_sphere;

    use super::*;

    #[test]
    fn wishes_are_rounded_up_to_prefixes() {
        let found = |rays, wanted: &[u32]| wanted.iter().map(|w| prefix_with(rays, *w)).collect::<Vec<_>>();
        assert_eq!(found(512, &[0, 1, 64, 65, 300, 512, u32::MAX]), [64, 64, 64, 128, 512, 512, 512]);
        assert_eq!(found(61, &[8, 9, 31, 32]), [8, 16, 31, 61]);
        assert_eq!(found(1, &[0, 1, 2]), [1, 1, 1]);
        assert_eq!(found(0, &[0, 1]), [0, 0]);
    }

    #[test]
    fn each_prefix_has_the_weights_of_its_own_quadrature() {
        let mut baked = BakedParts { relight_directions: progressive_sphere(61), ..BakedParts::default() };
        baked.settings.sh_degree = 3;
        let table = RelightTable::new(&baked);
        assert_eq!(table.weights.len(), 61 + 31 + 16 + 8);
        assert_eq!(table.weights[..61], [1.0; 61]);
        let of_all = quadrature_weights(&baked.relight_directions, 6);
        for rays in [31, 16, 8] {
            let own = quadrature_weights(&baked.relight_directions[..rays], 6);
            let found = table.weights_of(rays as u32);
            for ((found, of_all), own) in found.iter().zip(&of_all).zip(own) {
                assert!((found * of_all - own).abs() <= 1e-6 * own.abs(), "{rays} rays");
            }
        }
    }
}
