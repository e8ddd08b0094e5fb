//! What cannot be done is refused: with the right exit code, a message that says why, and nothing left behind.

#[expect(dead_code, reason = "other tests use the rest")]
mod workplace;

use std::fs;
#[cfg(all(target_os = "linux", feature = "window"))]
use std::process::Command;

use workplace::{Workplace, text};

/// (arguments, exit code, what standard error must say)
const BAD_INVOCATIONS: &[(&str, i32, &str)] = &[
    ("frobnicate", 2, "unrecognized subcommand"),
    ("bake cornell.glb", 2, "--out"),
    ("render cornell.glb --object cornell.glb -o a.png", 2, "expected FILE@X,Y,Z"),
    ("render cornell.glb --object cornell.glb@1,2 -o a.png", 2, "three to five numbers"),
    ("render cornell.glb --object cornell.glb@1,2,3,-1 -o a.png", 2, "its scale is -1"),
    ("render cornell.glb --animate 0 -o a", 2, "a number above zero"),
    (
        "reference cornell.glb --object none.glb@1,2,3 --camera front --setup setup.json -o a.png",
        1,
        "none.glb",
    ),
    ("bake cornell.glb -o a.plight --receivers many", 2, "invalid value"),
    ("bake cornell.glb -o a.plight --receivers 5 --texel-density 2", 2, "cannot be used with"),
    ("bake cornell.glb -o a.plight --threads 0", 2, "invalid value"),
    ("bake cornell.glb -o a.plight --sh-degree 99", 1, "0 to 11"),
    ("bake cornell.glb -o a.plight --texel-density -1", 2, ""),
    ("bake cornell.glb -o a.plight --error 0", 1, "must be positive"),
    ("bake cornell.glb -o a.plight --quality best", 2, "production"),
    ("bake cornell.glb -o a.plight --method magic", 2, "hybrid"),
    ("bake none.glb -o a.plight", 1, "none.glb"),
    ("bake setup.json -o a.plight", 1, "setup.json"),
    ("bake cornell.glb -o none/a.plight", 1, "the folder none does not exist"),
    ("bake cornell.glb -o .", 1, "is a folder"),
    ("bake cornell.glb -o cornell.glb", 1, "also an input"),
    ("bake cornell.glb -o setup.json/a.plight", 1, "not a folder"),
    ("web site cornell.plight --page none", 1, "tools/build-web.sh"),
    ("info cornell.glb", 1, "cornell.glb"),
    ("info none.plight", 1, "none.plight"),
    ("info none.plight --error-map a.exr", 1, "must end in .png"),
    ("info none.plight --error-map none/a.png", 1, "the folder none does not exist"),
    ("render cornell.glb -o a.jpg", 1, ".png"),
    ("render cornell.glb -o a.png --setup setup.json --camera side", 1, "front"),
    ("render cornell.glb -o a.png --setup none.json", 1, "none.json"),
    ("render cornell.glb -o a.png --setup points.csv", 1, "points.csv"),
    ("render cornell.glb -o a.png --size 0x9", 2, "pixels"),
    ("render cornell.glb -o a.png --exposure nan", 2, "expected a number"),
    ("render cornell.glb -o a.png --samples 0", 2, "0"),
    ("render cornell.glb -o a.png --view sky", 2, "lightmap-texels"),
    ("render cornell.glb -o a.png --backend cpu --view probes", 1, "--backend gpu"),
    ("render cornell.glb -o a.png --backend cpu --shading physical", 1, "--backend gpu"),
    ("render cornell.glb -o a.png --adapter no-such-gpu", 1, "GPU"),
    ("reference cornell.glb --setup setup.json -o a.png", 2, "--camera"),
    (
        "reference cornell.glb --setup setup.json --camera front --points points.csv -o a.png",
        2,
        "cannot be used",
    ),
    ("reference cornell.glb --setup setup.json --points points.csv -o a.png", 1, ".csv"),
    ("reference cornell.glb --setup setup.json --points setup.json -o a.csv", 1, "setup.json"),
    ("eval none.plight --setup setup.json --points points.csv", 1, ""),
    ("eval cornell.glb --setup setup.json --points none.csv", 1, "none.csv"),
    ("demo --scene palace", 2, "atrium"),
    ("demo --scene cornell -o setup.json", 1, "setup.json"),
    ("completions tcsh2", 2, "bash"),
];

#[test]
fn bad_invocations_say_what_is_wrong_and_leave_nothing_behind() {
    let place = Workplace::new();
    let before = place.names();
    for (arguments, code, message) in BAD_INVOCATIONS {
        let output = place.run(arguments);
        let shown = text(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{arguments}: {shown}");
        assert!(shown.contains(message), "{arguments}: {shown}");
        assert!(!shown.contains("panicked") && !shown.contains("backtrace"), "{arguments}: {shown}");
        assert!(output.stdout.is_empty(), "{arguments}");
        assert_eq!(place.names(), before, "{arguments}");
    }
}

#[test]
fn a_cut_off_baked_file_is_refused() {
    let place = Workplace::new();
    place.bake();
    let bytes = fs::read(place.path("cornell.plight")).unwrap();
    fs::write(place.path("cut.plight"), &bytes[..bytes.len() / 2]).unwrap();
    for command in ["info cut.plight", "render cut.plight -o a.png"] {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(1), "{command}");
        assert!(text(&output.stderr).contains("cut.plight"), "{command}: {}", text(&output.stderr));
    }
}

/// Elsewhere there is always a display.
#[cfg(all(target_os = "linux", feature = "window"))]
#[test]
fn without_a_display_view_names_another_command_before_it_bakes() {
    let place = Workplace::new();
    let output = Command::new(env!("CARGO_BIN_EXE_probelight"))
        .args(["view", "cornell.glb", "--setup", "setup.json"])
        .current_dir(&place.folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: no display: use `probelight render`"), "{said}");
}
