//! Random numbers of one path.

use probelight_math::glam::Vec2;
use probelight_math::sampling::{Rng, hash_pair, sobol_owen};

/// Pairs of dimensions that are stratified over the samples of one pixel or point: the pixel position, and
/// emitter and direction at the first three vertices. Later ones matter little and get plain random numbers.
const STRATIFIED_PAIRS: u32 = 7;

/// Folds a user's seed and the index of a pixel or point into the seed of its sample sequences.
pub(super) fn sequence_seed(seed: u64, index: u64) -> u32 {
    let fold = |value: u64| hash_pair(value as u32, (value >> 32) as u32);
    hash_pair(fold(seed), fold(index))
}

/// The numbers that steer one path: sample `index` of a sequence of Owen-scrambled Sobol points per pair of
/// dimensions, padded by independent scrambles.
pub(super) struct Sampler {
    index: u32,
    seed: u32,
    next_pair: u32,
    rng: Rng,
}

impl Sampler {
    pub(super) fn new(index: u32, seed: u32) -> Self {
        Self { index, seed, next_pair: 0, rng: Rng::new(u64::from(seed), u64::from(index)) }
    }

    /// A point in the unit square.
    #[inline]
    pub(super) fn next_pair(&mut self) -> Vec2 {
        if self.next_pair == STRATIFIED_PAIRS {
            return self.rng.next_vec2();
        }
        self.next_pair += 1;
        sobol_owen(self.index, hash_pair(self.seed, self.next_pair))
    }

    /// A number in `[0, 1)` that is not stratified.
    #[inline]
    pub(super) fn next_unstratified(&mut self) -> f32 {
        self.rng.next_f32()
    }
}
