//! The window's content, driven by its labels and by mouse and keys: on a GPU, without a display.
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[path = "../../probelight-runtime/tests/support/gpu.rs"]
mod gpu;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupExisting};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use egui_kittest::{Harness, SnapshotOptions, try_image_snapshot_options};
use probelight_math::glam::Vec3;
use probelight_runtime::gpu::GpuDevice;
use probelight_runtime::{LodLevel, LodPreset};
use probelight_scene::{LightMotion, Setup, Sky};
use probelight_viewer::state::view_state::{BakeNumbers, Compare, ExposureMode, PageColors, TexelColors};
use probelight_viewer::state::{Action, Edit, Request, Selection};
use probelight_viewer::{Viewer, ViewerOptions};

/// Pixels of a panel that other drivers may draw otherwise.
const LARGEST_CHANGE: usize = 100;

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name)
}

fn baked() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../probelight-render/tests/data/cornell.plight")
}

/// The window at the smallest size at which nothing may be cut off.
fn window(gpu: &GpuDevice, options: ViewerOptions) -> Harness<'static, Viewer> {
    let setup = WgpuSetup::Existing(WgpuSetupExisting {
        instance: gpu.instance.clone(),
        adapter: gpu.adapter.clone(),
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    });
    let state = create_render_state(setup, Default::default());
    let (gpu, window) = (gpu.clone(), state.clone());
    Harness::builder()
        .with_size([1280.0, 720.0])
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_eframe(move |creation| {
            Viewer::new(&creation.egui_ctx, None, &window, &gpu, options).expect("the GPU holds a pixel")
        })
}

/// Goes on until something is so.
fn until(harness: &mut Harness<'_, Viewer>, what: &str, is_so: impl Fn(&Viewer) -> bool) {
    let start = Instant::now();
    while !is_so(harness.state()) {
        assert!(start.elapsed() < Duration::from_secs(240), "{what} takes too long: {:?}", messages(harness));
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn messages(harness: &Harness<'_, Viewer>) -> Vec<String> {
    harness.state().messages.texts().map(Into::into).collect()
}

fn opened(gpu: &GpuDevice, file: PathBuf) -> Harness<'static, Viewer> {
    let options = ViewerOptions {
        file: Some(file),
        setup: Some(asset("setups/cornell_lamp.json")),
        ball: Some(("ball.glb".into(), std::fs::read(asset("objects/ball.glb")).unwrap().into())),
        ..ViewerOptions::default()
    };
    let mut harness = window(gpu, options);
    until(&mut harness, "opening", |viewer| {
        viewer.live.is_some() && !viewer.state.document.lights.is_empty()
    });
    harness.state_mut().state.view.resolution = 0.25;
    harness.run_steps(3);
    harness
}

fn lamp_place(harness: &Harness<'_, Viewer>) -> Vec3 {
    harness.state().state.document.lights[0].light.position().unwrap()
}

fn click(harness: &mut Harness<'_, Viewer>, pos: Pos2) {
    harness.event(Event::PointerMoved(pos));
    harness.step();
    for pressed in [true, false] {
        let button = PointerButton::Primary;
        harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        harness.step();
    }
}

fn drag(harness: &mut Harness<'_, Viewer>, button: PointerButton, from: Pos2, to: Pos2) {
    let press = |pressed, pos| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
    harness.event(Event::PointerMoved(from));
    harness.step();
    harness.event(press(true, from));
    harness.step();
    for step in 1..=4 {
        harness.event(Event::PointerMoved(from + (to - from) * (step as f32 / 4.0)));
        harness.step();
    }
    harness.event(press(false, to));
    harness.step();
    harness.step();
}

#[test]
fn scenes_are_seen_at_once_and_baked_meanwhile() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let options = ViewerOptions { file: Some(asset("scenes/furnace.glb")), ..ViewerOptions::default() };
    let mut harness = window(gpu, options);
    until(&mut harness, "opening", |viewer| viewer.live.is_some());
    assert!(!harness.state().live.as_ref().unwrap().is_baked, "it is there before its bake");
    harness.state_mut().state.view.resolution = 0.25;
    harness.get_by_label("Bake").click();
    harness.run_steps(2);
    assert!(harness.query_by_label("cancel").is_some());
    until(&mut harness, "the bake", |viewer| viewer.live.as_ref().is_some_and(|live| live.is_baked));
    harness.run_steps(2);
    assert!(harness.query_by_label("save the bake…").is_some());
    // Another one, with numbers of its own.
    let grid = |viewer: &Viewer| viewer.live.as_ref().unwrap().baked.grid_vertices.len();
    let before = harness.state().live.as_ref().unwrap().baked.settings.gather_rays;
    assert!(grid(harness.state()) > 0 && before != 24);
    harness.state_mut().state.view.bake_numbers =
        BakeNumbers { gather_rays: Some(24), grid_vertices: Some(0), ..BakeNumbers::default() };
    harness.run_steps(2);
    harness.get_by_label("preview").click();
    until(&mut harness, "another bake", |viewer| grid(viewer) == 0);
    assert_eq!(harness.state().live.as_ref().unwrap().baked.settings.gather_rays, 24);
    // A bake that is cancelled leaves the scene as it is.
    harness.state_mut().act(Action::Request(Request::Bake(probelight_bake::Quality::Medium)));
    harness.state_mut().act(Action::Request(Request::CancelBake));
    until(&mut harness, "cancelling", |viewer| {
        viewer.messages.texts().any(|text| text.contains("cancelled"))
    });
    assert!(harness.state().live.as_ref().unwrap().is_baked);
}

#[test]
fn everything_is_done_by_mouse() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    // Panels: add, change, remove.
    harness.get_by_label("+ spot").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.document.lights.len(), 2);
    assert!(harness.query_by_label("outer cone").is_some(), "what is new is selected and shown");
    harness.get_by_label("remove").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.document.lights.len(), 1);
    harness.get_by_label("+ ball").click();
    harness.run_steps(3);
    assert_eq!(harness.state().live.as_ref().unwrap().placed_objects().count(), 1);
    for tab in ["Detail", "Bake", "Picked", "View"] {
        harness.get_by_label(tab).click();
        harness.run_steps(2);
    }
    harness.get_by_label("stops").click();
    harness.get_by_label("without GI").click();
    harness.run_steps(2);
    assert_eq!(harness.state().state.view.compare, Compare::WithoutIndirect);
    // The picture: a place is picked, the camera goes around, nearer, and to a side.
    let middle = pos2(600.0, 300.0);
    harness.hover_at(middle);
    harness.run_steps(1);
    let camera = harness.state().state.view.camera.clone();
    let off_divider = pos2(450.0, 420.0);
    drag(&mut harness, PointerButton::Secondary, off_divider, off_divider + eframe::egui::vec2(60.0, 10.0));
    let looked = harness.state().state.view.camera.clone();
    assert!(looked.position == camera.position && looked.target != camera.target);
    drag(&mut harness, PointerButton::Middle, off_divider, off_divider + eframe::egui::vec2(0.0, 30.0));
    let panned = harness.state().state.view.camera.clone();
    assert!(panned.position != looked.position);
    assert!(messages(&harness).iter().all(|text| !text.contains("GPU")), "{:?}", messages(&harness));
}

#[test]
fn lights_are_dragged_and_places_picked_in_the_picture() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let item = harness.state().state.document.lights[0].item;
    harness.state_mut().act(Action::Select(Selection::Light(item)));
    harness.run_steps(4);
    let at = |harness: &Harness<'_, Viewer>| {
        let camera = &harness.state().state.view.camera;
        let (pixel, _) = probelight_viewer::state::camera_rig::project(camera, lamp_place(harness)).unwrap();
        let rect = harness.state().picture_rect();
        rect.min + eframe::egui::vec2(pixel.x, pixel.y) * (rect.height() / camera.height as f32)
    };
    let before = lamp_place(&harness);
    let from = at(&harness);
    drag(&mut harness, PointerButton::Primary, from, from + eframe::egui::vec2(30.0, 12.0));
    assert!(lamp_place(&harness).distance(before) > 0.05);
    assert!((at(&harness) - from - eframe::egui::vec2(30.0, 12.0)).length() < 2.0, "it is under the mouse");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert_eq!(lamp_place(&harness), before, "a drag is one step");
    // Keys that are pressed within one slow frame count as often, and in the order, as they were.
    let keys = [
        (Key::L, Modifiers::NONE),
        (Key::L, Modifiers::NONE),
        (Key::Z, Modifiers::COMMAND),
        (Key::Z, Modifiers::COMMAND),
        (Key::Z, Modifiers::COMMAND | Modifiers::SHIFT),
    ];
    let press =
        |(key, modifiers)| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    harness.input_mut().events.extend(keys.map(press));
    harness.step();
    assert_eq!(harness.state().state.document.lights.len(), 2);
    harness.state_mut().act(Action::Undo);
    harness.run_steps(2);
    // A click on the floor says what is there, and later what arrives there.
    let rect = harness.state().picture_rect();
    let floor = rect.center() + eframe::egui::vec2(-0.21, 0.44) * rect.height();
    click(&mut harness, floor);
    harness.run_steps(3);
    until(&mut harness, "the path tracer", |viewer| viewer.picked_reference().is_some());
    let (ours, traced) = harness.state().picked_reference().unwrap();
    assert!(
        ours.is_finite() && (ours / traced - 1.0).abs() < 0.3,
        "{ours} by the lightmap, {traced} by the path tracer"
    );
}

#[test]
fn the_picture_follows_the_light_and_rests_when_nothing_changes() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    until(&mut harness, "settling", |viewer| !viewer.is_busy());
    harness.run_steps(120);
    let picture = |harness: &Harness<'_, Viewer>| harness.state().read_picture().unwrap().pixels;
    let lit = picture(&harness);
    harness.run_steps(3);
    assert_eq!(picture(&harness), lit, "it rests");
    let draws = harness.state().draws();
    harness.run_steps(5);
    assert_eq!(harness.state().draws(), draws, "and nothing is drawn");
    let figures = harness.state().figures();
    assert!(figures["receivers"].as_u64() > Some(0), "{figures}");
    assert_eq!(figures["pending_clusters"], 0, "{figures}");
    harness.state_mut().act(Action::Edit(Edit::SetSky(Sky::Uniform(Vec3::splat(0.5)))));
    harness.step();
    assert_ne!(picture(&harness), lit, "a change is seen in the next frame");
    let item = harness.state().state.document.lights[0].item;
    let circle = LightMotion::Circle { radius: 0.4, period: 2.0 };
    harness.state_mut().act(Action::Edit(Edit::SetMotion(item, circle)));
    harness.state_mut().state.view.is_playing = true;
    harness.run_steps(2);
    let first = picture(&harness);
    harness.run_steps(2);
    assert_ne!(picture(&harness), first, "what moves by itself goes on");
}

#[test]
fn the_lightmap_is_shown_in_all_its_colors() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    harness.state_mut().state.view.panels.lightmap = true;
    until(&mut harness, "reading the lightmap", |viewer| viewer.lightmap_colors().is_some());
    let mut pages = Vec::new();
    for colors in PageColors::all().filter(|colors| *colors != PageColors::Texels(TexelColors::Levels)) {
        harness.state_mut().state.view.page_colors = colors;
        harness.run_steps(2);
        until(&mut harness, "the page", |viewer| !viewer.is_busy());
        harness.run_steps(2);
        let page = harness.state().lightmap_colors().unwrap().to_vec();
        assert!(page.iter().any(|color| *color != page[0]), "{} is of one colour", colors.name());
        assert!(!pages.contains(&page), "{} is another page", colors.name());
        pages.push(page);
    }
    harness.state_mut().state.view.panels.lightmap = false;
    harness.run_steps(2);
    assert!(harness.state().lightmap_colors().is_none(), "what is shut costs nothing");
}

#[test]
fn a_similarity_is_held_whenever_nothing_moves() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let scale = |harness: &mut Harness<'_, Viewer>, similarity: f32| {
        let view = &mut harness.state_mut().state.view;
        view.lod.levels =
            vec![LodLevel::default(), LodLevel { distance: 4.0, rank: Some(1), ..LodLevel::default() }];
        view.lod.fade = 0.0;
        view.hold_similarity = Some(similarity);
        harness.run_steps(2);
        until(harness, "the search", |viewer| viewer.held_scale().is_some() && !viewer.is_busy());
        harness.state().held_scale().unwrap()
    };
    let loose = scale(&mut harness, 0.5);
    harness.state_mut().state.view.hold_similarity = None;
    harness.run_steps(2);
    assert!(harness.state().held_scale().is_none());
    let strict = scale(&mut harness, 0.999);
    assert!(loose < strict, "levels begin at {loose} of their distances, or {strict}");
    let held = harness.state().live.as_ref().unwrap().runtime.lod().levels[1].distance;
    assert!((held / (4.0 * strict) - 1.0).abs() < 1e-3, "{held} m at {strict}");
}

#[test]
fn broken_files_leave_the_scene_as_it_is() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in
        [("broken.glb", "broken.glb"), ("broken.plight", "broken.plight"), ("broken.json", "broken.json")]
    {
        let file = folder.path().join(name);
        std::fs::write(&file, b"nothing of use").unwrap();
        harness.state_mut().act(Action::Request(Request::Open(file)));
        until(&mut harness, name, |viewer| !viewer.is_reading());
        assert!(messages(&harness).iter().any(|text| text.contains(expected)), "{:?}", messages(&harness));
        assert!(harness.state().live.is_some() && harness.state().state.document.lights.len() == 1);
    }
}

#[test]
fn changes_are_kept_when_the_gpu_is_lost() {
    if gpu::gpu_or_skip().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let setup = folder.path().join("setup.json");
    std::fs::copy(asset("setups/cornell_lamp.json"), &setup).unwrap();
    let kept = folder.path().join("cornell.rescued.json");
    let options = ViewerOptions { file: Some(baked()), setup: Some(setup), ..ViewerOptions::default() };
    for is_changed in [false, true] {
        // The other tests need theirs.
        let gpu = GpuDevice::open(std::env::var("PROBELIGHT_ADAPTER").ok().as_deref()).unwrap();
        let mut harness = window(&gpu, options.clone());
        until(&mut harness, "opening", |viewer| !viewer.state.document.lights.is_empty());
        if is_changed {
            harness.state_mut().act(Action::AddLamp);
        }
        // The device says so as soon as it has nothing to do any more.
        gpu.device.poll(eframe::wgpu::PollType::wait_indefinitely()).unwrap();
        gpu.device.destroy();
        harness.run_steps(2);
        assert_eq!(kept.exists(), is_changed);
    }
    assert_eq!(Setup::load(&kept).unwrap().lighting.lights.len(), 2);
}

#[test]
fn setups_are_saved_and_opened_again() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("evening.json");
    harness.get_by_label("+ ball").click();
    harness.run_steps(2);
    harness.state_mut().act(Action::AddLamp);
    harness.state_mut().act(Action::Request(Request::SaveTo(file.clone())));
    assert!(folder.path().join("ball.glb").exists(), "a setup brings its ball along");
    let saved = harness.state().state.document.lighting(0.0);
    harness.state_mut().act(Action::Undo);
    harness.state_mut().act(Action::Request(Request::Open(file)));
    until(&mut harness, "opening the setup", |viewer| !viewer.is_reading());
    harness.run_steps(3);
    assert_eq!(harness.state().state.document.lighting(0.0), saved);
    until(&mut harness, "the ball", |viewer| viewer.live.as_ref().unwrap().placed_objects().count() == 1);
}

#[test]
fn levels_say_what_they_save() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let lod = &mut harness.state_mut().state.view.lod;
    *lod = LodPreset::Low.settings();
    lod.levels[1].rank = Some(2);
    harness.get_by_label("Detail").click();
    harness.run_steps(3);
    let mut saved = |level: usize| {
        harness.get_all_by_label("rank").nth(level).unwrap().hover();
        let text = |harness: &Harness<'_, Viewer>| {
            harness
                .query_by_label_contains("saves ")
                .map(|tip| tip.accesskit_node().value().unwrap_or_default())
        };
        let deadline = Instant::now() + Duration::from_secs(30);
        loop {
            harness.step();
            if let Some(text) = text(&harness) {
                harness.event(Event::PointerGone);
                harness.run_steps(3);
                return text.split(' ').nth(1).unwrap().parse::<f32>().unwrap();
            }
            assert!(Instant::now() < deadline, "nothing is said of level {level}");
        }
    };
    assert!(saved(1) > 0.0, "all of the box is some metres away");
    assert_eq!(saved(0), 0.0, "nothing is so near");
}

/// The panels are the pictures in `tests/snapshots`. After a wanted change: `UPDATE_SNAPSHOTS=1 cargo test`, and look at them.
#[test]
fn panels_look_as_they_did() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let view = &mut harness.state_mut().state.view;
    (view.panels.timing, view.lod) = (false, LodPreset::Low.settings());
    // New lights are as bright as the exposure needs.
    view.exposure = ExposureMode::Fixed(0.0);
    harness.run_steps(2);
    harness.get_by_label("+ spot").click();
    harness.get_by_label("Detail").click();
    harness.run_steps(3);
    // The numbers of frames are those of light at rest.
    until(&mut harness, "settling", |viewer| !viewer.is_busy());
    harness.run_steps(2);
    let options = SnapshotOptions::new().failed_pixel_count_threshold(LARGEST_CHANGE);
    let panels = [("lights", 0..300), ("detail", 988..1280)];
    let looks = |harness: &mut Harness<'_, Viewer>, options: &SnapshotOptions| {
        let window = harness.render().expect("the GPU draws panels");
        panels.clone().map(|(name, columns)| {
            let size = (columns.len() as u32, window.height());
            let panel = image::imageops::crop_imm(&window, columns.start, 0, size.0, size.1).to_image();
            try_image_snapshot_options(&panel, name, options)
        })
    };
    for found in looks(&mut harness, &options) {
        assert!(found.is_ok(), "{}", found.unwrap_err());
    }
    // Negative control: another number in each panel is seen.
    let copies = tempfile::tempdir().unwrap();
    for (name, _) in &panels {
        let file = format!("{name}.png");
        std::fs::copy(Path::new("tests/snapshots").join(&file), copies.path().join(file)).unwrap();
    }
    let item = harness.state().state.document.lights[1].item;
    harness.state_mut().act(Action::Edit(Edit::RemoveLight(item)));
    harness.state_mut().state.view.lod.levels.pop();
    harness.run_steps(3);
    let elsewhere = options.output_path(copies.path());
    if std::env::var_os("UPDATE_SNAPSHOTS").is_none() {
        assert!(looks(&mut harness, &elsewhere).iter().all(Result::is_err));
    }
}

#[test]
fn no_panel_is_cut_off() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut harness = opened(gpu, baked());
    let item = harness.state().state.document.lights[0].item;
    harness.state_mut().act(Action::Select(Selection::Light(item)));
    harness.run_steps(2);
    for tab in ["View", "Detail", "Bake", "Picked"] {
        harness.get_by_label(tab).click();
        harness.run_steps(2);
        let window = eframe::egui::Rect::from_min_size(Pos2::ZERO, eframe::egui::vec2(1280.0, 720.0));
        let wide =
            |rect: eframe::egui::Rect| rect.min.x < window.min.x - 0.5 || rect.max.x > window.max.x + 0.5;
        let cut: Vec<_> = harness
            .root()
            .children_recursive()
            .filter(|node| node.accesskit_node().bounding_box().is_some() && wide(node.rect()))
            .map(|node| format!("{:?} {:?}", node.accesskit_node().label(), node.rect()))
            .collect();
        assert!(cut.is_empty(), "{tab}: {cut:?}");
    }
}
