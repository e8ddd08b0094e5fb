//! Presets: one word for how much time and space a bake may take.

use super::{DEFAULT_MAX_RECEIVERS, RELIGHT_RAY_BUDGET};

/// How good a bake should be. What a preset sets gives way to what [`BakeOptions`](crate::BakeOptions) sets
/// itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// To look at a scene while it is being made: coarse and grainy, a fraction of the time.
    Preview,
    /// The defaults.
    #[default]
    Medium,
    /// To keep: finer and with less noise, about four times the work.
    High,
    /// For the last bake of all: about sixteen times the work.
    Production,
}

/// What a [`Quality`] stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Receivers that the default texel density does not exceed.
    pub max_receivers: u32,
    /// Gather rays per receiver; the paper's method takes twice as many.
    pub gather_rays: u32,
    /// Relative error of a cluster's compressed transport; the paper's method may lose 5/4 of it.
    pub max_cluster_error: f32,
    /// Most singular values per cluster; the paper's method has half of them.
    pub max_rank: u32,
    /// Gather rays of all receivers together up to which each gets more of them.
    pub gather_ray_budget: u64,
    /// The same for the relight rays of all probes.
    pub relight_ray_budget: u64,
    /// See [`BakeOptions::bytes_per_receiver`](crate::BakeOptions::bytes_per_receiver).
    pub bytes_per_receiver: f32,
    /// Receivers from which on that holds. Of fewer each may take more: twice as many of a quarter as many.
    pub full_budget_receivers: u32,
}

/// The defaults. An error of 0.016 is mostly the noise of the gather rays.
const MEDIUM: Preset = Preset {
    max_receivers: DEFAULT_MAX_RECEIVERS,
    gather_rays: 256,
    max_cluster_error: 0.016,
    max_rank: 64,
    gather_ray_budget: DEFAULT_MAX_RECEIVERS as u64 * 256,
    relight_ray_budget: RELIGHT_RAY_BUDGET,
    bytes_per_receiver: 44.0,
    full_budget_receivers: DEFAULT_MAX_RECEIVERS,
};

impl Quality {
    /// All presets, the cheapest first.
    pub const ALL: [Self; 4] = [Self::Preview, Self::Medium, Self::High, Self::Production];

    /// What the preset sets.
    pub const fn preset(self) -> Preset {
        match self {
            Self::Preview => Preset {
                max_receivers: 50_000,
                gather_rays: 64,
                max_cluster_error: 0.064,
                gather_ray_budget: 50_000 * 64,
                bytes_per_receiver: 24.0,
                ..MEDIUM
            },
            Self::Medium => MEDIUM,
            Self::High => Preset {
                max_receivers: 2 * MEDIUM.max_receivers,
                gather_rays: 2 * MEDIUM.gather_rays,
                max_cluster_error: 0.012,
                bytes_per_receiver: 60.0,
                gather_ray_budget: 4 * MEDIUM.gather_ray_budget,
                ..MEDIUM
            },
            Self::Production => Preset {
                max_receivers: 4 * MEDIUM.max_receivers,
                gather_rays: 4 * MEDIUM.gather_rays,
                max_cluster_error: 0.008,
                max_rank: 128,
                bytes_per_receiver: 80.0,
                gather_ray_budget: 16 * MEDIUM.gather_ray_budget,
                ..MEDIUM
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_preset_asks_for_more_than_the_one_before() {
        for pair in Quality::ALL.windows(2) {
            let [a, b] = [pair[0].preset(), pair[1].preset()];
            assert!(a.max_receivers < b.max_receivers && a.gather_rays < b.gather_rays);
            assert!(a.max_cluster_error > b.max_cluster_error && a.max_rank <= b.max_rank);
        }
        assert_eq!(Quality::default(), Quality::Medium);
    }
}
