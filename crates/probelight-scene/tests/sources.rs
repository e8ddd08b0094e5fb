//! Triangles know the objects of the file that they come from.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use glb::{Glb, U8};
use probelight_scene::{Scene, SourceInstance, SourceTriangle, Sources};
use serde_json::json;

#[test]
fn triangles_know_the_object_they_come_from() {
    let mut glb = Glb::triangle();
    let list = glb.push_accessor(U8, "SCALAR", 9, &[0, 0, 1, 0, 1, 2, 2, 1, 0]);
    glb.json["meshes"] = json!([
        {"name": "unused", "primitives": []},
        {"name": "leaf", "primitives": [
            {"attributes": {"POSITION": 0}, "mode": 0},
            {"attributes": {"POSITION": 0}, "indices": list},
            {"attributes": {"POSITION": 0}, "mode": 5}
        ]}
    ]);
    glb.json["nodes"] = json!([{"children": [2, 1]}, {"mesh": 1, "name": "near"}, {"mesh": 1}]);
    let sources = glb.load().unwrap().sources;
    let instance = |node, node_name: &str, primitive| SourceInstance {
        node,
        node_name: node_name.into(),
        copy: 0,
        mesh: 1,
        mesh_name: "leaf".into(),
        primitive,
    };
    let instances = [instance(2, "", 1), instance(2, "", 2), instance(1, "near", 1), instance(1, "near", 2)];
    assert_eq!(sources.instances, instances);
    // The first triangle of the list has no area.
    let triangles = [(0, 1), (0, 2), (1, 0), (2, 1), (2, 2), (3, 0)];
    let triangles = triangles.map(|(instance, triangle)| SourceTriangle { instance, triangle });
    assert_eq!(sources.triangles, triangles);
}

#[test]
fn tables_of_sources_that_do_not_fit_are_refused() {
    let scene = Glb::triangle().load().unwrap();
    let error_after = |change: fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        scene.validate().err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(error_after(|scene| scene.sources = Sources::default()), "");
    assert!(error_after(|s| s.sources.instances.clear()).contains("instance that does not exist"));
    assert!(
        error_after(|s| s.sources.triangles.push(SourceTriangle::default())).contains("2 source triangles")
    );
}
