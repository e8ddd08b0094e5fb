//! Settings that have names.

use super::lod::{LodChanges, LodLevel, LodSettings};

/// The one list of the presets: what each is for, what it is called.
macro_rules! presets {
    ($($(#[$documentation:meta])* $preset:ident = $name:literal,)*) => {
        /// Levels of detail that have a name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum LodPreset { $($(#[$documentation])* $preset,)* }

        impl LodPreset {
            /// All of them, from the least work to the most, then the published one.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$preset),*];

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$preset => $name,)* }
            }
        }
    };
}

presets! {
    /// The least work that still looks right: a sixteenth of all in a frame, the largest changes first; far away and behind the
    /// view, light follows by steps of some per cent.
    Low = "low",
    /// At most a quarter of the work in a frame; of what moves slowly, no more than a per cent waits where somebody looks
    /// closely.
    Medium = "medium",
    /// Less work where nobody sees it.
    High = "high",
    /// Everything.
    Exact = "exact",
    /// \[SED\] Table 1: fewer bands, relight rays and receivers from 20, 50 and 100 metres on, nothing else.
    Published = "published",
}

impl LodPreset {
    /// The preset of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// Its settings.
    pub fn settings(self) -> LodSettings {
        match self {
            Self::Low => {
                let levels =
                    [(0.0, None, 1.0), (4.0, Some(20), 2.0), (12.0, Some(16), 4.0), (30.0, Some(12), 8.0)];
                by_distance(0.02, 8, Some(1.0 / 16.0), levels)
            }
            Self::Medium => {
                let levels =
                    [(0.0, None, 1.0), (10.0, Some(20), 2.0), (25.0, Some(16), 4.0), (60.0, Some(12), 8.0)];
                by_distance(0.01, 4, Some(1.0 / 4.0), levels)
            }
            Self::High => {
                let levels =
                    [(0.0, None, 1.0), (20.0, None, 2.0), (50.0, Some(20), 4.0), (100.0, Some(16), 8.0)];
                by_distance(0.005, 2, None, levels)
            }
            Self::Exact => LodSettings::default(),
            Self::Published => published(),
        }
    }
}

/// Levels that begin at such distances in front, half as far beside and a quarter as far behind. Farther away larger
/// changes may wait, by so many times the threshold, and there are fewer singular values: the two knobs that save the most for
/// what they cost. Rays of lights and probes have as many turns, and a frame reads a share of the matrices.
fn by_distance(
    threshold: f32,
    turns: u32,
    matrix_share: Option<f32>,
    levels: [(f32, Option<u32>, f32); 4],
) -> LodSettings {
    let level = |(distance, rank, patience): (f32, Option<u32>, f32)| LodLevel {
        distance,
        beside: Some(distance / 2.0),
        behind: Some(distance / 4.0),
        rank,
        threshold: Some(threshold * patience),
        ..LodLevel::default()
    };
    LodSettings {
        levels: levels.into_iter().map(level).collect(),
        changes: LodChanges { threshold, matrix_share, ..LodChanges::default() },
        shadow_turns: turns,
        probe_turns: turns,
        ..LodSettings::default()
    }
}

/// \[SED\] Table 1. The numbers of rays are those of section 5.1 continued; a level's receivers are those of section 5.3.
fn published() -> LodSettings {
    let level = |(lightmap_level, (distance, degree, rays))| LodLevel {
        distance,
        degree: Some(degree),
        rays: Some(rays),
        lightmap_level,
        ..LodLevel::default()
    };
    let table = [(0.0, 7, 512), (20.0, 6, 256), (50.0, 4, 128), (100.0, 3, 64)];
    LodSettings { levels: (0..).zip(table).map(level).collect(), ..LodSettings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid_and_found_by_name() {
        for preset in LodPreset::ALL {
            preset.settings().check().unwrap();
            assert_eq!(LodPreset::by_name(preset.name()), Some(preset));
            let text = serde_json::to_string(&preset.settings()).unwrap();
            assert_eq!(serde_json::from_str::<LodSettings>(&text).unwrap(), preset.settings());
        }
        assert_eq!(LodPreset::by_name("highest"), None);
    }

    #[test]
    fn farther_levels_compute_no_more() {
        let no_more = |near: &LodLevel, far: &LodLevel| {
            let counts =
                |level: &LodLevel| [level.rank, level.degree, level.rays].map(|n| n.unwrap_or(u32::MAX));
            counts(near).iter().zip(counts(far)).all(|(near, far)| *near >= far)
                && near.lightmap_level <= far.lightmap_level
                && near.threshold <= far.threshold
        };
        for preset in LodPreset::ALL {
            assert!(preset.settings().levels.is_sorted_by(no_more), "{preset:?}");
        }
    }
}
