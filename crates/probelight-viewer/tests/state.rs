//! What actions do to a state: no window, no GPU.
#![allow(missing_docs, reason = "a test binary has no documentation")]

use probelight_math::glam::Vec3;
use probelight_render::gpu::{GpuView, Shading};
use probelight_scene::{Camera, Light, LightMotion, Material, Placement, Scene, Setup, Sky};
use probelight_viewer::state::document::standing;
use probelight_viewer::state::view_state::{Compare, ExposureMode};
use probelight_viewer::state::{Action, Document, Edit, Request, Selection, State};

fn camera(name: &str) -> Camera {
    Camera {
        name: name.into(),
        position: Vec3::new(0.0, 1.0, 8.0),
        target: Vec3::new(0.0, 1.0, 0.0),
        up: Vec3::Y,
        vertical_fov: 0.8,
        width: 640,
        height: 480,
    }
}

fn scene() -> Scene {
    let material = |name: &str| Material { name: name.into(), ..Material::default() };
    Scene { materials: vec![material("wall"), material("floor")], ..Scene::default() }
}

fn lamp() -> Light {
    Light::Point { position: Vec3::Y, intensity: Vec3::splat(2.0), range: None }
}

fn state() -> State {
    let mut setup = Setup { cameras: vec![camera("front"), camera("back")], ..Setup::default() };
    setup.lighting.lights.push(lamp());
    State::new(Document::new(&setup, "".as_ref(), &scene()), camera("front"), 20.0)
}

fn do_all(state: &mut State, actions: impl IntoIterator<Item = Action>) {
    for action in actions {
        assert_eq!(state.act(action), None);
    }
}

#[test]
fn edits_are_undone_and_done_again() {
    let mut state = state();
    let first = state.document.clone();
    let item = first.lights[0].item;
    do_all(&mut state, [Action::AddLamp, Action::Edit(Edit::SetSky(Sky::Uniform(Vec3::ONE)))]);
    let last = state.document.clone();
    assert_eq!((last.lights.len(), state.history.steps()), (2, 2));
    assert!(state.is_changed && matches!(state.selection, Selection::Light(new) if new != item));
    do_all(&mut state, [Action::Undo, Action::Undo]);
    assert_eq!(state.document, first);
    assert_eq!(state.selection, Selection::Nothing, "what was selected is gone");
    do_all(&mut state, [Action::Undo, Action::Redo, Action::Redo, Action::Redo]);
    assert_eq!(state.document, last);
    // What is undone is forgotten once something else is done.
    do_all(&mut state, [Action::Undo, Action::Edit(Edit::SetEmissiveScale(2.0)), Action::Redo]);
    assert_eq!((state.document.emissive_scale, &state.document.sky), (2.0, &Sky::default()));
}

#[test]
fn a_drag_is_one_step() {
    let mut state = state();
    let item = state.document.lights[0].item;
    let moved = |x: f32| {
        Action::Edit(Edit::SetLight(
            item,
            Light::Point { position: Vec3::X * x, intensity: Vec3::ONE, range: None },
        ))
    };
    do_all(&mut state, (1..50).map(|x| moved(x as f32)));
    do_all(&mut state, [Action::EndStep, moved(100.0)]);
    assert_eq!(state.history.steps(), 2);
    do_all(&mut state, [Action::Undo]);
    assert_eq!(state.document.lights[0].light.position(), Some(Vec3::X * 49.0));
    do_all(&mut state, [Action::Undo]);
    assert_eq!(state.document.lights[0].light, lamp());
}

#[test]
fn edits_of_what_is_not_there_change_nothing() {
    let mut state = state();
    let item = state.document.lights[0].item;
    do_all(&mut state, [Action::Select(Selection::Light(item)), Action::RemoveSelected]);
    let steps = state.history.steps();
    for edit in [
        Edit::RemoveLight(item),
        Edit::SetLight(item, lamp()),
        Edit::SetMotion(item, LightMotion::Flicker { strength: 1.0 }),
        Edit::CopyLight(item),
        Edit::RemoveCamera(9),
        Edit::PlaceObject(item, Placement::default()),
    ] {
        do_all(&mut state, [Action::Edit(edit)]);
    }
    do_all(&mut state, [Action::RemoveSelected, Action::CopySelected, Action::FocusSelected]);
    assert_eq!((state.document.lights.len(), state.history.steps()), (0, steps));
}

#[test]
fn objects_are_placed_with_all_of_their_path() {
    let mut state = state();
    let path = standing("ball.glb".into(), Placement::at(Vec3::X));
    do_all(&mut state, [Action::Edit(Edit::AddObject(path))]);
    let Selection::Object(item) = state.selection else { panic!("{:?}", state.selection) };
    do_all(
        &mut state,
        [
            Action::Edit(Edit::AddObjectKey(item, 2.0, Placement::at(Vec3::X * 3.0))),
            Action::Edit(Edit::PlaceObject(item, Placement::at(Vec3::Y))),
            Action::CopySelected,
        ],
    );
    let places = |n: usize, time| state.document.objects[n].placement(time).translation;
    assert_eq!([places(0, 0.0), places(0, 1.0)], [Vec3::Y, Vec3::Y + Vec3::X]);
    assert_eq!(places(1, 1.0) - places(0, 1.0), Vec3::X, "the copy lies beside it");
    assert!(state.document.moves() && state.document.end() == 2.0);
}

#[test]
fn views_keep_the_windows_size_and_toggles_come_back() {
    let mut state = state();
    let before = state.view.clone();
    let mut other = state.view.clone();
    (other.camera.width, other.camera.height, other.divider) = (1, 1, 0.25);
    do_all(&mut state, [Action::View(Box::new(other))]);
    assert_eq!((state.view.camera.width, state.view.divider), (640, 0.25));
    state.view.divider = before.divider;
    let toggles = [
        Action::ToggleIndirect,
        Action::ToggleShading,
        Action::TogglePlaying,
        Action::TogglePanels,
        Action::ToggleHelp,
    ];
    for toggle in toggles {
        do_all(&mut state, [toggle.clone()]);
        assert_ne!(state.view, before, "{toggle:?}");
        do_all(&mut state, [toggle]);
        assert_eq!(state.view, before);
    }
    do_all(&mut state, [Action::Show(GpuView::Probes), Action::NextComparison]);
    assert_eq!((state.view.options.view, state.view.compare), (GpuView::Probes, Compare::WithoutIndirect));
    assert_eq!(state.view.options.shading, Shading::Diffuse);
    state.shown_ev = 2.0;
    do_all(&mut state, [Action::Brighten(0.5)]);
    assert_eq!(state.view.exposure, ExposureMode::Fixed(2.5), "from what is shown");
    do_all(&mut state, [Action::ToggleExposure, Action::ToggleExposure]);
    assert_eq!(state.view.exposure, ExposureMode::Fixed(2.0));
    assert_eq!(state.act(Action::Request(Request::Save)), Some(Request::Save));
}

#[test]
fn cameras_are_kept_and_found() {
    let mut state = state();
    do_all(&mut state, [Action::KeepCamera, Action::KeepCamera]);
    let names: Vec<_> = state.document.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["front", "back", "view 1", "view 2"]);
    do_all(&mut state, [Action::Focus(Vec3::new(5.0, 0.0, 0.0))]);
    assert_eq!(state.view.camera.target, Vec3::new(5.0, 0.0, 0.0));
    assert!(state.view.camera.position.distance(state.view.camera.target) < 4.0);
    do_all(&mut state, [Action::Home]);
    assert_eq!(state.view.camera, camera("front"));
}

#[test]
fn what_is_selected_is_nudged_as_the_camera_sees_it() {
    let mut state = state();
    let item = state.document.lights[0].item;
    do_all(&mut state, [Action::Nudge(Vec3::ONE)]);
    assert_eq!(state.document.lights[0].light, lamp(), "nothing is selected");
    do_all(&mut state, [Action::Select(Selection::Light(item)), Action::Nudge(Vec3::new(1.0, 2.0, 3.0))]);
    let moved = state.document.lights[0].light.position().unwrap();
    assert!(moved.abs_diff_eq(Vec3::new(1.0, 3.0, -3.0), 1e-5), "{moved}");
    do_all(&mut state, [Action::AddLamp]);
    assert_eq!(state.document.lights[1].light.strength(), Vec3::splat(2.0), "as bright as the others");
}

#[test]
fn setups_hold_all_that_was_changed() {
    let mut state = state();
    let mut colors = state.document.materials[1];
    colors.base_color = Vec3::new(0.5, 0.25, 0.0);
    let folder = std::path::Path::new("/somewhere");
    let circle = LightMotion::Circle { radius: 2.0, period: 5.0 };
    let lamp = state.document.lights[0].item;
    do_all(
        &mut state,
        [
            Action::Edit(Edit::SetMotion(lamp, circle)),
            Action::Edit(Edit::SetMaterial(1, colors)),
            Action::Edit(Edit::AddObject(standing("/somewhere/ball.glb".into(), Placement::at(Vec3::X)))),
            Action::KeepCamera,
        ],
    );
    let setup = state.document.setup(folder, &scene());
    assert_eq!(setup.objects[0].file, std::path::Path::new("ball.glb"), "found beside the setup");
    assert_eq!(setup.materials.len(), 1);
    assert_eq!((setup.materials[0].name.as_str(), setup.materials[0].emission), ("floor", None));
    let read = Setup::parse(&setup.to_json(), "s.json".as_ref()).unwrap();
    let again = Document::new(&read, folder, &scene());
    assert_eq!(again.materials, state.document.materials);
    assert_eq!(again.objects[0].path.file, state.document.objects[0].path.file);
    assert_eq!(again.lighting(0.0), state.document.lighting(0.0));
    assert_eq!(again.lighting(1.3), state.document.lighting(1.3), "lights move on");
    assert_eq!(again.lights[0].name, state.document.lights[0].name);
    assert_eq!(again.cameras.len(), 3);
}
