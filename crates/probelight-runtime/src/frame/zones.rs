//! Zones around a view: what is in front of it, beside it and behind it ([SED] section 5.1, figure 8).

use serde::{Deserialize, Serialize};

/// Which directions from a view count as in front, beside and behind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LodZones {
    /// Cosine of the angle with the view direction above which something is in front.
    pub front: f32,
    /// Cosine below which something is behind.
    pub behind: f32,
    /// Width of the bands, as a difference of cosines, in which one zone's distances become the next one's: when the view
    /// turns, levels come and go by and by. With 0 zones are as published, with a sharp border.
    pub band: f32,
}

impl Default for LodZones {
    /// In front is what a picture of 100 degrees shows, and a margin, for those who turn.
    fn default() -> Self {
        Self { front: 0.4, behind: -0.4, band: 0.3 }
    }
}

impl LodZones {
    /// Whether the numbers are zones.
    pub(super) fn are_zones(&self) -> bool {
        let cosines = -1.0..=1.0;
        cosines.contains(&self.front)
            && cosines.contains(&self.behind)
            && self.behind <= self.front
            && (0.0..=1.0).contains(&self.band)
    }

    /// How much of something in such a direction is in front, beside and behind; together 1.
    pub fn weights(&self, cosine: f32) -> [f32; 3] {
        let front = self.above(self.front, cosine);
        let not_behind = self.above(self.behind, cosine).max(front);
        [front, not_behind - front, 1.0 - not_behind]
    }

    /// From 0 below a border to 1 above it.
    fn above(&self, border: f32, cosine: f32) -> f32 {
        if self.band > 0.0 {
            ((cosine - border) / self.band + 0.5).clamp(0.0, 1.0)
        } else {
            f32::from(u8::from(cosine >= border))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_shares_that_change_by_and_by() {
        for band in [0.0, 0.3, 1.0] {
            let zones = LodZones { band, ..LodZones::default() };
            let steps = (-1000..=1000).map(|i| zones.weights(i as f32 / 1000.0));
            let mut last = [0.0, 0.0, 1.0];
            for weights in steps {
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)));
                let jump = weights.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(band == 0.0 || jump < 0.01, "{jump}");
                last = weights;
            }
            assert_eq!(last, [1.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn sharp_zones_end_at_their_cosines() {
        let zones = LodZones { front: 0.5, behind: -0.5, band: 0.0 };
        let weights = [0.5, 0.49, -0.5, -0.51].map(|cosine| zones.weights(cosine));
        assert_eq!(weights, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
