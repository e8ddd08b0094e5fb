//! The price of a byte at which a scene's matrices are as large as they may be.
//!
//! What light transport takes depends on the scene: in plain rooms twenty bytes a receiver are enough, between columns and
//! leaves a hundred are not. Some of the groups are compressed at several prices; from their sizes follows the price at
//! which all of them will take about what is allowed.

use probelight_trace::Progress;
use rayon::prelude::*;

use crate::BakeError;
use crate::group_worker::GroupWorker;
use crate::steps::for_each_in_parallel;

/// Prices that are tried, see [`BakeSettings::byte_price`](probelight_asset::BakeSettings::byte_price). At the first hardly
/// anything is saved any more, at the last hardly anything is left.
const PRICES: [f32; 4] = [0.16, 0.64, 2.56, 10.24];

/// One of so many groups is tried, and of many no more than the second number.
const GROUPS_PER_TRIAL: usize = 16;
const MOST_TRIALS: usize = 24;

/// The price at which U and ΣVᵀ of the texels' groups take `budget` bytes per receiver, about; the lowest where they take
/// fewer anyway.
pub(crate) fn price_within(
    budget: f32,
    worker: &GroupWorker<'_>,
    groups: &[Vec<u32>],
    progress: &dyn Progress,
) -> Result<f32, BakeError> {
    let of_texels = groups.partition_point(|group| worker.ground.texels().contains(&group[0]));
    let trials = (of_texels / GROUPS_PER_TRIAL).clamp(1, MOST_TRIALS);
    // From the middle of even stretches: neighbours in this order are neighbours in space.
    let tried: Vec<&Vec<u32>> =
        (0..trials.min(of_texels)).map(|i| &groups[(2 * i + 1) * of_texels / (2 * trials)]).collect();
    let receivers: usize = tried.iter().map(|group| group.len()).sum();
    let weigh = |group: &&Vec<u32>| worker.bytes_at(group, &PRICES);
    let sizes = for_each_in_parallel("weighing bytes", tried.par_iter(), progress, weigh)?;
    let per_receiver = |price: usize| {
        let bytes: u64 = sizes.iter().map(|sizes| sizes[price]).sum();
        bytes as f32 / receivers.max(1) as f32
    };
    Ok(interpolate(budget, std::array::from_fn(per_receiver)))
}

/// The price at which that many bytes are taken, from what is taken at each of [`PRICES`].
fn interpolate(budget: f32, bytes: [f32; PRICES.len()]) -> f32 {
    let Some(after) = bytes.iter().position(|bytes| *bytes <= budget) else {
        return PRICES[PRICES.len() - 1];
    };
    let Some(before) = after.checked_sub(1) else { return PRICES[0] };
    let part = (bytes[before] / budget).ln() / (bytes[before] / bytes[after].max(f32::MIN_POSITIVE)).ln();
    PRICES[before] * (PRICES[after] / PRICES[before]).powf(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_price_is_where_the_budget_is_met() {
        let bytes = [160.0, 80.0, 40.0, 20.0];
        assert_eq!(interpolate(200.0, bytes), PRICES[0], "nothing is saved for nothing");
        assert_eq!(interpolate(5.0, bytes), PRICES[3]);
        for (price, bytes_there) in PRICES.iter().zip(bytes).skip(1) {
            assert!((interpolate(bytes_there, bytes) / price - 1.0).abs() < 1e-5);
        }
        let between = interpolate(80.0 / 2f32.sqrt(), bytes);
        assert!((between / (PRICES[1] * PRICES[2]).sqrt() - 1.0).abs() < 1e-5, "{between}");
        assert_eq!(interpolate(5.0, [f32::NAN; 4]), PRICES[3]);
    }
}
