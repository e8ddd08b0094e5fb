//! `demo` as a user meets it: pictures first, the slow truth last.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

#[test]
fn pictures_are_announced_as_they_appear_and_stay_after_ctrl_c() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut demo = Command::new(env!("CARGO_BIN_EXE_probelight"))
        .args(["demo", "--scene", "cornell", "--backend", "cpu", "-o"])
        .arg(&out)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let said = BufReader::new(demo.stderr.take().unwrap()).lines().map(Result::unwrap);
    let said: Vec<String> = said.take_while(|line| !line.starts_with("path tracing")).collect();
    for number in 1..=4 {
        let picture = out.join(format!("cornell-{number}.png"));
        assert!(said.iter().any(|line| line.contains(&*picture.to_string_lossy())), "{number}: {said:?}");
        assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    }
    assert!(!out.join("cornell.png").exists(), "the contact sheet needs the truth");
    assert!(Command::new("kill").args(["-INT", &demo.id().to_string()]).status().unwrap().success());
    assert_eq!(demo.wait().unwrap().code(), Some(130));
    assert!(out.join("cornell-1.png").exists() && !out.join("cornell.png").exists());
}
