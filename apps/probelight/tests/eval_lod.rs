//! `eval-lod` as a user meets it.

#[expect(dead_code, reason = "other tests use the rest")]
mod workplace;

use serde_json::Value;
use workplace::{Workplace, text};

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {row:#}"))
}

#[test]
fn levels_of_detail_are_compared_with_none() {
    let place = Workplace::new();
    place.bake();
    let lod = r#"{"levels": [{}, {"distance": 0.5, "rank": 1}]}"#;
    std::fs::write(place.path("coarse.json"), lod).unwrap();
    let arguments = "eval-lod cornell.plight --setup setup.json --size 48x32 --quiet";
    let report = place.json(&format!("{arguments} --frames 3 --lod exact coarse.json --pictures out"));
    let rows = report["rows"].as_array().unwrap();
    let [exact, coarse] = [&rows[0], &rows[1]];
    assert_eq!([&exact["lod"], &coarse["lod"], &exact["camera"]], ["exact", "coarse.json", "front"]);
    assert_eq!(number(exact, "ssim"), 1.0);
    assert_eq!(number(exact, "bytes"), number(exact, "bytes_all"));
    assert!(number(coarse, "bytes") < number(exact, "bytes"), "{coarse:#}");
    assert!(number(coarse, "ssim") < 1.0 && number(coarse, "flip") > 0.0, "{coarse:#}");
    for row in rows {
        let ratio = number(row, "ms_all") / number(row, "ms");
        assert!((number(row, "speedup") - ratio).abs() < 1e-9 && ratio > 0.0);
    }
    assert!(place.path("out/front-coarse.json-difference.png").exists());
    // Light that stands still is at rest where changes may wait.
    let still = place.json(&format!("{arguments} --lod medium --light still --frames 40"));
    let row = &still["rows"][0];
    assert!(number(row, "receivers") < 0.5 * number(row, "receivers_all"), "{row:#}");
    let table = place.succeed(&format!("{arguments} --frames 3 --lod low --hold-ssim 0.9"));
    assert!(table.contains("low@") && table.contains("SSIM"), "{table}");
}

/// A camera goes past those of a setup, under two setups, each with a reference.
#[test]
fn setups_have_references_and_cameras_a_way() {
    let place = Workplace::new();
    place.bake();
    let setup: Value = serde_json::from_slice(&std::fs::read(place.path("setup.json")).unwrap()).unwrap();
    let mut walk = setup.clone();
    let mut second = walk["cameras"][0].clone();
    second["name"] = "second".into();
    second["position"][0] = (second["position"][0].as_f64().unwrap() + 0.5).into();
    walk["cameras"].as_array_mut().unwrap().push(second);
    std::fs::write(place.path("walk.json"), walk.to_string()).unwrap();
    place.succeed("reference cornell.glb --setup setup.json --sample 40 --samples 64 -o ref.csv");
    let arguments =
        "eval-lod cornell.plight --size 48x32 --quiet --frames 4 --lod exact --camera-path walk.json";
    let report = place.json(&format!("{arguments} --setup setup.json walk.json --points ref.csv ref.csv"));
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_eq!(row["camera"], "walk");
        assert_eq!([number(row, "step"), number(row, "rmse")], [0.0, number(row, "rmse_all")]);
        assert_eq!(number(row, "probes"), number(row, "probes_all"));
        assert_eq!(number(row, "coefficients"), number(row, "coefficients_all"));
        assert!(number(row, "largest_change") > 0.0, "lights move: {row:#}");
        assert!(row["stages_ms"]["gather_receivers"].as_f64().unwrap() > 0.0);
    }
    let output = place.run(&format!("{arguments} --setup setup.json walk.json --points ref.csv"));
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("one table for each --setup: there are 1 for 2"));
}

#[test]
fn wrong_levels_of_detail_say_what_to_do() {
    let place = Workplace::new();
    let output = place.run("eval-lod cornell.plight --lod mediun");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("low, medium, high, exact, published"));
}
