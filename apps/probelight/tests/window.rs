//! The window of `view` on a display, used by keys and mouse.
#![cfg(all(target_os = "linux", feature = "window"))]

use std::path::Path;
use std::process::Command;

/// The script says what it does, and whether it is skipped.
#[test]
fn the_window_works_by_keys_and_mouse() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let output = Command::new(root.join("tools/check-window.sh"))
        .env("PROBELIGHT", env!("CARGO_BIN_EXE_probelight"))
        .output()
        .expect("bash is there");
    let said = [&output.stdout[..], &output.stderr].map(String::from_utf8_lossy).concat();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("the window works") || said.contains("SKIPPED"), "{said}");
}
