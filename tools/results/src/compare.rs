//! `results compare`: what changed between two measurements.

use std::collections::BTreeMap;

use crate::figures::{Bake, Errors, Figures};
use crate::tables::Table;

/// Errors may grow by this much before a row is marked, a share: 0.2 points.
const ERROR_ALLOWANCE: f64 = 0.002;

/// Bytes, times and memory may grow by this much before a row is marked.
const COST_ALLOWANCE: f64 = 1.01;

/// Both measurements side by side as Markdown; only what both hold.
pub(crate) fn comparison(before: &Figures, after: &Figures) -> String {
    format!("{}\n{}", errors(before, after).markdown(), costs(before, after).markdown())
}

/// The pairs that two maps have in common.
fn pairs<'a, T>(
    before: &'a BTreeMap<String, T>,
    after: &'a BTreeMap<String, T>,
) -> impl Iterator<Item = (&'a str, &'a T, &'a T)> {
    before.iter().filter_map(|(name, old)| Some((name.as_str(), old, after.get(name)?)))
}

fn errors(before: &Figures, after: &Figures) -> Table {
    let mut table = Table::new([
        "bake",
        "points",
        "relative RMSE, %:",
        "",
        "bias, %:",
        "median, %:",
        "95th, %:",
        "black, %:",
        "small triangles, %:",
    ]);
    for (bake, old, new) in pairs(&before.bakes, &after.bakes) {
        for (set, old, new) in pairs(&old.sets, &new.sets) {
            let change = |value: fn(&Errors) -> Option<f64>| shares(value(old), value(new));
            table.row([
                bake.into(),
                set.into(),
                change(|errors| Some(errors.relative_rmse)),
                mark(new.relative_rmse > old.relative_rmse + ERROR_ALLOWANCE),
                change(|errors| errors.mean_bias),
                change(|errors| errors.median_relative_error),
                change(|errors| errors.p95_relative_error),
                change(|errors| errors.black_share),
                change(|errors| errors.small_triangles?.relative_rmse),
            ]);
        }
        if let (Some(old), Some(new)) = (old.random_lights, new.random_lights) {
            table.row([
                bake.into(),
                "random lights, median".into(),
                shares(Some(old.median), Some(new.median)),
                mark(new.median > old.median + ERROR_ALLOWANCE),
                shares(old.mean_bias_size, new.mean_bias_size),
                String::new(),
                String::new(),
                String::new(),
                String::new(),
            ]);
        }
    }
    table
}

/// A figure of a bake that should be low.
type Cost = fn(&Bake) -> Option<f64>;

fn costs(before: &Figures, after: &Figures) -> Table {
    let mut table = Table::new(["bake", "figure", "before:", "after:", "ratio:", ""]);
    let costs: [(&str, Cost); 6] = [
        ("bytes per receiver", |bake| Some(bake.bytes_per_receiver)),
        ("file, MB", |bake| bake.file_bytes.map(|bytes| bytes as f64 * 1e-6)),
        ("bake, s", |bake| bake.seconds),
        ("memory, MiB", |bake| bake.peak_mib),
        ("frame, lights still, ms", |bake| bake.still_ms),
        ("frame, lights moving, ms", |bake| bake.moving_ms),
    ];
    for (bake, old, new) in pairs(&before.bakes, &after.bakes) {
        for (name, cost) in costs {
            let (Some(old), Some(new)) = (cost(old), cost(new)) else { continue };
            let cells = [format!("{old:.2}"), format!("{new:.2}"), format!("{:.2}", new / old)];
            let [old_cell, new_cell, ratio] = cells;
            table.row([
                bake.into(),
                name.into(),
                old_cell,
                new_cell,
                ratio,
                mark(new > old * COST_ALLOWANCE),
            ]);
        }
    }
    table
}

fn shares(before: Option<f64>, after: Option<f64>) -> String {
    let shown = |share: Option<f64>| share.map_or("–".into(), |share| format!("{:.2}", 100.0 * share));
    format!("{} → {}", shown(before), shown(after))
}

fn mark(is_worse: bool) -> String {
    if is_worse { "worse" } else { "" }.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(relative_rmse: f64, bytes_per_receiver: f64) -> Figures {
        let errors = Errors { relative_rmse, ..Errors::default() };
        let bake = Bake { bytes_per_receiver, sets: [("sun".into(), errors)].into(), ..Bake::default() };
        Figures { bakes: [("atrium".into(), bake)].into(), ..Figures::default() }
    }

    #[test]
    fn only_what_is_worse_is_marked() {
        let worse = |before: (f64, f64), after: (f64, f64)| {
            let text = comparison(&figures(before.0, before.1), &figures(after.0, after.1));
            text.matches("worse").count()
        };
        assert_eq!(worse((0.1, 60.0), (0.1, 60.0)), 0);
        assert_eq!(worse((0.1, 60.0), (0.1015, 60.5)), 0);
        assert_eq!(worse((0.1, 60.0), (0.103, 50.0)), 1);
        assert_eq!(worse((0.1, 60.0), (0.103, 61.0)), 2);
    }

    #[test]
    fn rows_hold_both_values() {
        let text = comparison(&figures(0.1, 60.0), &figures(0.12, 50.0));
        assert!(
            text.contains(&format!("| atrium | sun | 10.00 → 12.00 | worse |{}\n", " – → – |".repeat(5))),
            "{text}"
        );
        assert!(text.contains("| atrium | bytes per receiver | 60.00 | 50.00 | 0.83 |  |"), "{text}");
    }
}
