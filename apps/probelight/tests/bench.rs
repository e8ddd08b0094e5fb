//! `bench` as a user meets it, on whatever computes.

use std::process::{Command, Output};

use serde_json::Value;

fn bench(arguments: &str) -> Output {
    let arguments = format!("bench {arguments}");
    Command::new(env!("CARGO_BIN_EXE_probelight")).args(arguments.split_whitespace()).output().unwrap()
}

/// The figures of a run that must succeed.
fn figures(arguments: &str) -> Value {
    let output = bench(&format!("{arguments} --json --quiet"));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {message}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Whether every stage has a time, bytes and a ratio, and the frame is their sum.
fn is_complete(figures: &Value, stages: &[&str]) -> bool {
    let positive = |value: &Value| value.as_f64().is_some_and(|value| value > 0.0 && value.is_finite());
    let scene = &figures["scenes"][0];
    let measured = scene["stages"].as_array().unwrap();
    let is_measured =
        |stage: &Value| ["median_ms", "bytes", "of_copy"].iter().all(|key| positive(&stage[key]));
    let bytes: u64 = measured.iter().filter_map(|stage| stage["bytes"].as_u64()).sum();
    measured.iter().map(|stage| stage["name"].as_str().unwrap()).eq(stages.iter().copied())
        && measured.iter().chain([&scene["frame"]]).all(is_measured)
        && scene["frame"]["bytes"] == bytes
        && scene["receivers"].as_u64().is_some_and(|receivers| receivers >= 1000)
        && positive(&figures["copy_gb_per_s"])
}

const STAGES: [&str; 6] = [
    "light_surfels",
    "relight_probes",
    "project_clusters",
    "gather_receivers",
    "dilate_lightmap",
    "reduce_lightmap",
];

#[test]
fn stages_are_measured_on_the_cpu() {
    let mut figures = figures("--synthetic 1000 --frames 2 --backend cpu");
    assert!(is_complete(&figures, &STAGES[..5]), "{figures:#}");
    figures["scenes"][0]["stages"][2]["bytes"] = 0.into();
    assert!(!is_complete(&figures, &STAGES[..5]), "the check notices nothing");
}

#[test]
fn moving_lights_are_work() {
    let bytes = |figures: &Value| figures["scenes"][0]["stages"][0]["bytes"].as_u64().unwrap();
    let [still, moving] = ["", "--moving-lights"]
        .map(|flag| figures(&format!("--synthetic 1000 --frames 2 --backend cpu {flag}")));
    assert!(is_complete(&moving, &STAGES[..5]), "{moving:#}");
    assert!(bytes(&moving) > bytes(&still));
}

#[test]
fn stages_are_measured_on_a_gpu() {
    let first = bench("--synthetic 1000 --frames 1 --backend gpu");
    if !first.status.success() && String::from_utf8_lossy(&first.stderr).contains("no GPU was found") {
        assert!(std::env::var("CI").ok().as_deref() != Some("true"), "there is no GPU");
        return;
    }
    for method in ["hybrid", "paper"] {
        let arguments =
            format!("--synthetic 1000 --method {method} --frames 2 --backend gpu --moving-lights");
        let figures = figures(&arguments);
        assert!(is_complete(&figures, &STAGES), "{figures:#}");
    }
}

#[test]
fn figures_are_written_as_a_file_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bench.json");
    let output = bench(&format!("--synthetic 1000 2000 --frames 1 --backend cpu -o {}", file.display()));
    assert!(output.status.success());
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("gather_receivers") && table.contains("of copy"), "{table}");
    let figures: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    assert_eq!(figures["scenes"].as_array().unwrap().len(), 2);
}

#[test]
fn planning_is_measured_if_objects_move() {
    let planning = |objects: &str| {
        let figures = figures(&format!("--synthetic 20000 --frames 3 --backend cpu {objects}"));
        figures["scenes"][0]["planning_ms"].as_f64()
    };
    let [few, many] = ["1", "100000"].map(|n| planning(&format!("--objects {n}")).unwrap());
    assert!(0.0 < few && few < many, "{few} {many}");
    assert_eq!(planning(""), None);
}

#[test]
fn nothing_to_measure_is_an_error() {
    assert_eq!(bench("--backend cpu").status.code(), Some(2));
    assert_eq!(bench("--synthetic 10 --backend cpu").status.code(), Some(2));
    let missing = bench("--synthetic 1000 --adapter no-such-gpu");
    let message = String::from_utf8_lossy(&missing.stderr).into_owned();
    assert_eq!(missing.status.code(), Some(1));
    assert!(message.contains("no-such-gpu") || message.contains("no GPU was found"), "{message}");
}
