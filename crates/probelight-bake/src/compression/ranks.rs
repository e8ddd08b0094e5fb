//! How many singular values a cluster keeps, and how precisely.

use probelight_asset::packed::{Precision, Ranks};

use crate::compression::factors::{Aim, Factors, RoundingNoise};

/// The ranks of U and ΣVᵀ beyond which more bytes are not worth it; what is within the target costs no less for being
/// better. Where the target must be met, the cheapest that meet it.
pub(crate) fn choose_ranks(factors: &Factors<'_>, noise: &RoundingNoise, aim: Aim) -> (Ranks, Ranks) {
    let most = factors.energies.len();
    let accepted = aim.error * aim.error * factors.counted();
    let in_half_floats = || {
        let of_component = |k| noise.of_u(k, Precision::F16) + noise.of_w(k, Precision::F16);
        let energy = |rank: usize| factors.tails[rank] + (0..rank).map(of_component).sum::<f64>();
        let rank = (0..=most).find(|rank| energy(*rank) <= accepted).unwrap_or(most);
        let ranks = Ranks { f16: rank as u32, ..Ranks::default() };
        (ranks, ranks)
    };
    if !aim.is_packed {
        return in_half_floats();
    }
    // What a singular value costs in four bits: a value for each receiver or column.
    let byte_price = aim.byte_price * accepted;
    let u_price = 0.5 * byte_price;
    let w_price = u_price * factors.w.ncols() as f64 / factors.u.nrows().max(1) as f64;
    let mut best = (0, 0, 0);
    let mut lowest_cost = (true, f64::INFINITY);
    for total in 0..=most {
        let energies_in_u = mixed_energies(total, |k, precision| noise.of_u(k, precision));
        let energies_in_w = mixed_energies(total, |k, precision| noise.of_w(k, precision));
        for (fine_u, of_u) in energies_in_u.iter().enumerate() {
            for (fine_w, of_w) in energies_in_w.iter().enumerate() {
                let energy = factors.tails[total] + of_u + of_w;
                let price = u_price * (total + fine_u) as f64 + w_price * (total + fine_w) as f64;
                let misses = aim.must_be_met && energy > accepted;
                let cost = (misses, energy.max(accepted) + price);
                if cost < lowest_cost {
                    lowest_cost = cost;
                    best = (total, fine_u, fine_w);
                }
            }
        }
    }
    if lowest_cost.0 {
        return in_half_floats();
    }
    let ranks = |fine: usize| Ranks { f16: 0, snorm8: fine as u32, snorm4: (best.0 - fine) as u32 };
    (ranks(best.1), ranks(best.2))
}

/// Energy of rounding `total` components if the first n have eight bits and the others four, for every n.
fn mixed_energies(total: usize, noise: impl Fn(usize, Precision) -> f64) -> Vec<f64> {
    let coarse = (0..total).map(|k| noise(k, Precision::Snorm4)).sum::<f64>();
    let mut energies = vec![coarse];
    energies.extend((0..total).scan(coarse, |energy, k| {
        *energy += noise(k, Precision::Snorm8) - noise(k, Precision::Snorm4);
        Some(*energy)
    }));
    energies
}
