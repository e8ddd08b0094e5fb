//! The program as a user meets it: exit codes, messages, files.

mod workplace;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use workplace::{Workplace, text};

fn is_png(path: &Path) -> bool {
    fs::read(path).unwrap().starts_with(b"\x89PNG")
}

#[test]
fn bake_info_render_and_eval_work_together() {
    let place = Workplace::new();
    place.bake();
    assert_eq!(place.names(), ["cornell.glb", "cornell.plight", "points.csv", "setup.json"]);

    let info = place.json("info cornell.plight");
    assert_eq!(info["triangles"], 32);
    assert_eq!(info["settings"]["gather_rays"], 64);
    assert_eq!((&info["settings"]["method"], &info["emitters"]), (&"hybrid".into(), &1.into()));
    let matrices = &info["matrices"];
    let bytes = &matrices["bytes_per_receiver"];
    let parts =
        ["receiver_basis", "signal_basis", "signals", "metadata"].map(|part| bytes[part].as_f64().unwrap());
    assert!((parts.iter().sum::<f64>() - info["matrix_bytes_per_receiver"].as_f64().unwrap()).abs() < 1e-6);
    for histogram in ["error_histogram", "rank_histogram"] {
        let bins = matrices[histogram].as_array().unwrap();
        let shares: f64 = bins.iter().map(|bin| bin["share"].as_f64().unwrap()).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{histogram}");
    }
    let shown = place.succeed("info cornell.plight --error-map errors.png");
    for part in ["receivers by error", "receivers by rank", "bytes per receiver", "hybrid", "teal"] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    assert!(is_png(&place.path("errors.png")));

    let render = place.json("render cornell.plight --setup setup.json --camera front --samples 2 -o a.png");
    assert_eq!((&render["width"], &render["height"]), (&48.into(), &32.into()));
    assert!(render["exposure_ev"].is_number() && is_png(&place.path("a.png")));

    place.succeed("reference cornell.glb --setup setup.json --points points.csv -o ref.csv --samples 256");
    let eval = place.json("eval cornell.plight --setup setup.json --points ref.csv --predictions ours.csv");
    assert_eq!((&eval["surface_points"], &eval["free_space_points"]), (&3.into(), &1.into()));
    assert!(eval["relative_rmse"].as_f64().unwrap() < 0.5, "{eval}");
    assert!(eval["compared"].as_str().unwrap().contains("E_sky"));
    let predictions = fs::read_to_string(place.path("ours.csv")).unwrap();
    let lines: Vec<&str> = predictions.lines().collect();
    assert_eq!((lines[0], lines.len()), ("E_r,E_g,E_b", 5));
    assert!(!predictions.contains("NaN"), "{predictions}");
    assert!(
        place.succeed("eval cornell.plight --setup setup.json --points ref.csv").contains("relative RMSE")
    );
    let eval = place.json("eval cornell.plight --setup setup.json --points ref.csv --floor=256");
    let floor = &eval["floor"];
    assert_eq!(floor["compared"], 3);
    for error in ["floor", "above_floor"] {
        assert!(floor[error].as_f64().unwrap() < 0.5, "{floor}");
    }
    let shown = place.succeed("eval cornell.plight --setup setup.json --floor=32 --points ref.csv");
    assert!(shown.contains("above the floor"), "{shown}");
    // A table may have points of the air alone.
    let table = fs::read_to_string(place.path("ref.csv")).unwrap();
    let kind = table.lines().next().unwrap().split(',').position(|name| name == "kind").unwrap();
    let rows = table.lines().filter(|row| matches!(row.split(',').nth(kind), Some("kind" | "1")));
    fs::write(place.path("air.csv"), rows.collect::<Vec<_>>().join("\n")).unwrap();
    let air = place.json("eval cornell.plight --setup setup.json --points air.csv");
    assert_eq!((&air["surface_points"], &air["free_space_points"]), (&0.into(), &1.into()));
    assert!(air["free_space"]["relative_rmse"].is_number() && air["relative_rmse"].is_null(), "{air}");
    let shown = place.succeed("eval cornell.plight --setup setup.json --points air.csv");
    assert!(shown.contains("E_sky") && shown.contains("in free space"), "{shown}");
}

#[test]
fn objects_are_seen_and_move() {
    let place = Workplace::new();
    place.bake();
    let render = |arguments: &str| {
        place.succeed(&format!(
            "render cornell.plight --setup setup.json --camera front --samples 2 {arguments}"
        ))
    };
    render("-o without.png");
    let object = "--object cornell.glb@2,1,1,0.3,20";
    render(&format!("{object} -o with.png"));
    render(&format!("{object} --no-soft-shadows -o hard.png"));
    let picture = |name: &str| fs::read(place.path(name)).unwrap();
    assert_ne!(picture("with.png"), picture("without.png"));
    assert_ne!(picture("with.png"), picture("hard.png"));

    let mut setup: serde_json::Value = serde_json::from_slice(&picture("setup.json")).unwrap();
    let key = |time: f32, x: f32| serde_json::json!({"time": time, "position": [x, 1, 1], "scale": 0.3});
    setup["objects"] = serde_json::json!([{"file": "cornell.glb", "path": [key(0.0, 1.0), key(1.0, 4.0)]}]);
    fs::write(place.path("moving.json"), setup.to_string()).unwrap();
    let moving = "render cornell.plight --setup moving.json --camera front --samples 2";
    place.succeed(&format!("{moving} --animate 1 --fps 2 -o frames"));
    assert_ne!(picture("frames/frame_0000.png"), picture("frames/frame_0001.png"));
    place.succeed(&format!("{moving} -o first.png"));
    assert_eq!(picture("frames/frame_0000.png"), picture("first.png"));
    place.succeed("reference cornell.glb --setup moving.json --camera front --samples 2 -o truth.png");
    // Lights move, too.
    setup["objects"] = serde_json::json!([]);
    setup["lights"] = serde_json::json!([{
        "type": "point", "position": [1, 4, 2], "intensity": [9, 9, 9],
        "motion": {"type": "keyframes", "keyframes": [{"time": 0}, {"time": 1, "position": [4, 1, 2]}]}
    }]);
    fs::write(place.path("lamp.json"), setup.to_string()).unwrap();
    let moving = "render cornell.plight --setup lamp.json --camera front --samples 2";
    place.succeed(&format!("{moving} --animate 1 --fps 2 -o lit"));
    assert_ne!(picture("lit/frame_0000.png"), picture("lit/frame_0001.png"));
    place.succeed(&format!("{moving} -o still.png"));
    assert_eq!(picture("lit/frame_0000.png"), picture("still.png"));

    place.succeed("bake cornell.glb -o bare.plight --receivers 300 --rays 32 --relight-rays 32 --grid 0");
    let bare = place.run(&format!("render bare.plight --setup setup.json --samples 1 {object} -o bare.png"));
    assert!(text(&bare.stderr).contains("without a grid"), "{}", text(&bare.stderr));
}

#[test]
fn the_methods_qualities_and_errors_that_are_asked_for_are_baked() {
    let place = Workplace::new();
    let settings = |arguments: &str| {
        place.succeed(&format!(
            "bake cornell.glb -o a.plight --receivers 300 --relight-rays 32 --grid 0 {arguments}"
        ));
        place.json("info a.plight")["settings"].clone()
    };
    let preview = settings("--quality preview");
    // Four times the preset's 64, because receivers are few.
    assert_eq!((&preview["gather_rays"], &preview["storage"]), (&256.into(), &"packed".into()));
    let high = settings("--quality high --rays 32 --error 0.25 --near-radius 2 --surfel-size 1.5");
    assert_eq!((&high["gather_rays"], &high["max_cluster_error"]), (&32.into(), &0.25.into()));
    assert_eq!((&high["near_radius"], &high["surfel_size"]), (&2.0.into(), &1.5.into()));
    let paper = settings("--rays 32 --method paper");
    assert_eq!((&paper["metric"], &paper["storage"]), (&"band".into(), &"f16".into()));
    let mixed = settings("--rays 32 --method paper --metric radiance --storage packed");
    assert_eq!((&mixed["metric"], &mixed["storage"]), (&"radiance".into(), &"packed".into()));
}

#[test]
fn render_takes_a_scene_and_says_that_it_bakes() {
    let place = Workplace::new();
    let output = place
        .run("render cornell.glb --setup setup.json --size 16x12 --samples 1 --output indirect -o a.exr");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("baking it in memory with quick settings"));
    assert!(output.stdout.is_empty());
    let image = probelight_render::Image::read_exr(&place.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (16, 12));
    assert!(image.pixels.iter().any(|pixel| pixel.max_element() > 0.0));
}

#[test]
fn a_gpu_draws_the_same_picture_and_others() {
    let place = Workplace::new();
    place.bake();
    let on_gpu = |arguments: &str| {
        place.run(&format!("render cornell.plight --setup setup.json --backend gpu {arguments}"))
    };
    let first = on_gpu("-o gpu.exr");
    if text(&first.stderr).contains("no GPU was found") {
        assert!(std::env::var("CI").ok().as_deref() != Some("true"), "there is no GPU");
        return;
    }
    assert!(first.status.success(), "{}", text(&first.stderr));
    place.succeed("render cornell.plight --setup setup.json --backend cpu -o cpu.exr");
    let mean = |name: &str| {
        let image = probelight_render::Image::read_exr(&place.path(name)).unwrap();
        image.pixels.iter().map(|pixel| pixel.element_sum()).sum::<f32>() / image.pixels.len() as f32
    };
    let (gpu, cpu) = (mean("gpu.exr"), mean("cpu.exr"));
    assert!((gpu - cpu).abs() < 0.02 * cpu, "{gpu} on the GPU, {cpu} on the CPU");
    for (view, has_exposure) in [("normals", false), ("probes", true), ("full --shading physical", true)] {
        let output = on_gpu(&format!("--view {view} -o view.png --json"));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(report["backend"].as_str().unwrap().starts_with("GPU"));
        assert_eq!(report["exposure_ev"].is_number(), has_exposure, "{view}");
        assert!(is_png(&place.path("view.png")));
    }
}

#[test]
fn reference_pictures_and_points_keep_their_formats() {
    let place = Workplace::new();
    place.succeed("reference cornell.glb --setup setup.json --camera front --samples 1 --size 8x6 -o a.png");
    assert!(is_png(&place.path("a.png")));
    let report =
        place.json("reference cornell.glb --setup setup.json --points points.csv --samples 16 -o ref.csv");
    assert_eq!(report["count"], 4);
    let table = fs::read_to_string(place.path("ref.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(header.starts_with("position_x,position_y,position_z,normal_x,normal_y,normal_z,kind,E_delta_r"));
    for column in
        ["E_area_g", "E_sky_b", "E_direct_r", "E_indirect_r", "se_area_r", "se_sky_r", "se_indirect_b"]
    {
        assert!(header.split(',').any(|name| name == column), "{column}");
    }
}

#[test]
fn quiet_commands_print_nothing_and_results_do_not_depend_on_threads() {
    let place = Workplace::new();
    let settings = "--receivers 300 --rays 32 --relight-rays 32 --grid 400 --quiet";
    for (threads, name) in [(1, "one.plight"), (3, "three.plight")] {
        let output = place.run(&format!("bake cornell.glb -o {name} --threads {threads} {settings}"));
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    }
    assert_eq!(fs::read(place.path("one.plight")).unwrap(), fs::read(place.path("three.plight")).unwrap());
    place.succeed(&format!("bake cornell.glb -o seed.plight --seed 5 {settings}"));
    assert_ne!(fs::read(place.path("one.plight")).unwrap(), fs::read(place.path("seed.plight")).unwrap());
}

#[test]
fn warnings_are_lines_of_their_own_that_say_what_to_do() {
    let workplace = Workplace::new();
    // Two triangles of glTF's default material, which is white.
    let corners =
        "AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAQAAAAAAAAAAAAAAAQAAAAEAAAAAAAAAAAAAAAEAAAAAA";
    let white = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 6}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 72}}],
        "buffers": [{{"byteLength": 72, "uri": "data:;base64,{corners}"}}]}}"#
    );
    fs::write(workplace.path("white.gltf"), white).unwrap();
    let warnings = |scene: &str, flags: &str| -> Vec<String> {
        let output =
            workplace.run(&format!("bake {scene} -o out.plight --receivers 50 --rays 16 --grid 0 {flags}"));
        let lines = text(&output.stderr);
        assert!(output.status.success(), "{lines}");
        lines.lines().filter(|line| line.starts_with("warning:")).map(str::to_owned).collect()
    };
    let first = &warnings("white.gltf", "")[0];
    assert!(first.starts_with("warning: white.gltf: materials that reflect more than 95 %"), "{first}");
    assert!(first.contains("lower their base colour"), "{first}");
    assert!(warnings("white.gltf", "--quiet").is_empty());
    assert!(warnings("cornell.glb", "").is_empty());
}

#[test]
fn resume_without_an_interrupted_bake_starts_anew() {
    let place = Workplace::new();
    let output = place
        .run("bake cornell.glb -o a.plight --receivers 300 --rays 32 --relight-rays 32 --grid 0 --resume");
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("no interrupted bake to resume"));
    assert!(!place.path("a.plight.partial").exists());
}

#[test]
fn the_help_of_bake_states_the_defaults() {
    let place = Workplace::new();
    place.succeed("bake cornell.glb -o cornell.plight --receivers 40 --grid 0 --quiet");
    let settings = &place.json("info cornell.plight")["settings"];
    // Lines are wrapped anywhere.
    let help = place.succeed("bake --help").split_whitespace().collect::<Vec<_>>().join(" ");
    for (flag, field) in [
        ("--samples-per-surfel <N>", "samples_per_surfel"),
        ("--probes-per-cluster <P>", "probes_per_cluster"),
        ("--receivers-per-cluster <R>", "receivers_per_cluster"),
        ("--seed <S>", "seed"),
    ] {
        let (_, entry) = help.split_once(flag).unwrap_or_else(|| panic!("{flag} is not in the help"));
        let (_, stated) = entry.split_once("[default: ").unwrap();
        // What follows a semicolon is for the other method.
        let (stated, _) = stated.split_once([']', ';']).unwrap();
        assert_eq!(stated, settings[field].to_string(), "{flag}");
    }
    // So few probes have as many relight rays, and bands, as the defaults may grow to.
    let rays = &settings["relight_rays"];
    assert!(help.contains(&format!("up to {rays} where there are few probes")), "{help}");
    assert!(help.contains(&format!("{} with {rays} relight rays", settings["sh_degree"])), "{help}");
}

#[test]
fn help_completions_and_manual_pages_are_there() {
    let place = Workplace::new();
    for command in ["demo", "bake", "info", "render", "reference", "eval", "completions", "man"] {
        assert!(place.succeed(&format!("{command} --help")).contains("Examples:"), "{command}");
    }
    assert!(place.succeed("--help").contains("A first tour"));
    assert!(place.succeed("--version").starts_with("probelight "));
    assert!(place.succeed("completions bash").contains("--texel-density"));
    place.succeed("man pages");
    assert!(fs::read_to_string(place.path("pages/probelight-bake.1")).unwrap().contains("receivers"));
}

/// Ctrl-C in the middle of a bake that would take minutes.
#[cfg(unix)]
#[test]
fn an_interrupted_bake_ends_with_130_and_leaves_no_half_file() {
    let place = Workplace::new();
    // With nothing to resume it says so just before it bakes.
    let arguments = "bake cornell.glb -o a.plight --receivers 200000 --rays 65536 --resume";
    let mut child = Command::new(env!("CARGO_BIN_EXE_probelight"))
        .args(arguments.split_whitespace())
        .current_dir(&place.folder)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // It heeds signals from its start on.
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut first = String::new();
    said.read_line(&mut first).unwrap();
    assert!(!first.is_empty());
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signal.success());
    std::io::copy(&mut said, &mut std::io::sink()).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!place.path("a.plight").exists());
    let left = place.names();
    assert!(left.iter().all(|name| !name.starts_with(".probelight")), "{left:?}");
}
