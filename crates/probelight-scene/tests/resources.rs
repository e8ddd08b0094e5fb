//! Files that a scene refers to: where they may lie, and how large they may be.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use std::fs;
use std::path::Path;

use glb::Glb;
use probelight_scene::load_gltf;
use serde_json::json;
use tempfile::TempDir;

/// `secret.bin`, which is a buffer that would do, and beside it a folder `scene` with `parts/data.bin`, which is too.
fn folders() -> TempDir {
    let outer = tempfile::tempdir().unwrap();
    fs::create_dir_all(outer.path().join("scene/parts")).unwrap();
    for place in ["secret.bin", "scene/parts/data.bin"] {
        fs::write(outer.path().join(place), Glb::triangle().binary).unwrap();
    }
    outer
}

/// What becomes of a scene whose buffer has this URI: the error, or nothing.
fn error_with_uri(outer: &Path, uri: &str) -> String {
    let mut json = Glb::triangle().json;
    json["buffers"] = json!([{"byteLength": 42, "uri": uri}]);
    let path = outer.join("scene/scene.gltf");
    fs::write(&path, json.to_string()).unwrap();
    load_gltf(&path).err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn uris_stay_in_the_folder_of_the_scene() {
    let outer = folders();
    let secret = outer.path().join("secret.bin");
    for uri in ["parts/data.bin", "parts/../parts/./data.bin", "parts%2Fdata.bin", "parts\\data.bin"] {
        assert_eq!(error_with_uri(outer.path(), uri), "", "{uri}");
    }
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "..%2fsecret.bin",
        "parts/../../secret.bin",
        "..\\secret.bin",
        "parts/../../scene/parts/data.bin",
        &secret.display().to_string(),
        &secret.display().to_string().replace('/', "%2F"),
    ] {
        let error = error_with_uri(outer.path(), uri);
        assert!(
            error.contains("buffers[0]") && error.contains("leaves the scene's folder"),
            "{uri}: {error}"
        );
    }
    for uri in [format!("file://{}", secret.display()), "C:secret.bin".into()] {
        let error = error_with_uri(outer.path(), &uri);
        assert!(error.contains("is not a relative path"), "{uri}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn links_in_the_folder_are_followed() {
    let outer = folders();
    std::os::unix::fs::symlink("../secret.bin", outer.path().join("scene/link.bin")).unwrap();
    assert_eq!(error_with_uri(outer.path(), "link.bin"), "");
}

/// A file that claims `bytes` and holds none: a hole, which costs nothing on the disk.
fn hole(path: &Path, bytes: u64) {
    fs::File::create(path).unwrap().set_len(bytes).unwrap();
}

#[test]
fn files_that_are_too_large_are_refused_before_they_are_read() {
    let outer = folders();
    hole(&outer.path().join("scene/huge.bin"), 1 << 40);
    assert!(error_with_uri(outer.path(), "huge.bin").contains("holds 1099511627776 bytes; at most"));

    let path = outer.path().join("huge.glb");
    hole(&path, 1 << 40);
    assert!(load_gltf(&path).unwrap_err().to_string().contains("holds 1099511627776 bytes; at most"));

    hole(&outer.path().join("scene/huge.png"), 1 << 31);
    let mut glb = Glb::triangle();
    glb.json["images"] = json!([{"uri": "huge.png"}]);
    glb.json["textures"] = json!([{"source": 0}]);
    glb.json["materials"] = json!([{"emissiveTexture": {"index": 0}}]);
    let path = outer.path().join("scene/scene.glb");
    fs::write(&path, glb.bytes()).unwrap();
    let error = load_gltf(&path).unwrap_err().to_string();
    assert!(error.contains("images[0]") && error.contains("holds 2147483648 bytes; at most"), "{error}");
}
