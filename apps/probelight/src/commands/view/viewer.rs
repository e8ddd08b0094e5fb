//! Where the viewer is, how the scene is lit and what is shown: everything that keys and mouse change.

use std::collections::HashSet;

use probelight_math::glam::{Quat, Vec2, Vec3};
use probelight_render::gpu::{GpuView, Shading, ViewOptions};
use probelight_scene::{Camera, Light, Lighting, ObjectPath, Placement};

use super::controls::{Action, Motion};

/// Camera and lights cross the scene in about so many seconds.
const SECONDS_ACROSS: f32 = 10.0;

/// Factor on the camera's speed while Shift is held.
const FAST: f32 = 4.0;

/// How fast lights turn and circle, radians per second.
const TURN_RATE: f32 = 0.5;

/// Radius of a lamp's circle, as a share of the scene's diagonal: it fits in a room.
const CIRCLE_PER_DIAGONAL: f32 = 0.05;

/// The view stays so far from straight up and straight down, radians.
const POLE_DISTANCE: f32 = 0.02;

/// Step of the exposure, powers of two.
const EXPOSURE_STEP: f32 = 0.5;

/// What one can change from the keyboard and with the mouse.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) camera: Camera,
    pub(super) lighting: Lighting,
    pub(super) options: ViewOptions,
    /// Exposure as a power of two.
    pub(super) ev: f32,
    /// How far the first light's circle is, radians; `None` while it stands still.
    circling: Option<f32>,
    /// Seconds since the beginning, for objects on their paths.
    time: f32,
    /// How far each object was moved off its path, metres, and turned, radians.
    shifts: Vec<(Vec3, f32)>,
    /// The object that keys move, instead of the first light.
    chosen: Option<usize>,
}

/// The state now, and at the beginning.
#[derive(Clone, Debug)]
pub(super) struct Viewer {
    pub(super) state: State,
    start: State,
    /// Where objects move.
    paths: Vec<ObjectPath>,
    /// Diagonal of the scene's box, metres.
    diagonal: f32,
}

impl Viewer {
    /// Begins at `camera` in a scene whose box has a diagonal of `diagonal` metres.
    pub(super) fn new(
        camera: Camera,
        lighting: Lighting,
        ev: f32,
        diagonal: f32,
        paths: Vec<ObjectPath>,
    ) -> Self {
        let state = State {
            camera,
            lighting,
            options: ViewOptions::default(),
            ev,
            circling: None,
            time: 0.0,
            shifts: vec![(Vec3::ZERO, 0.0); paths.len()],
            chosen: None,
        };
        Self { start: state.clone(), state, paths, diagonal }
    }

    /// Seconds since the beginning.
    pub(super) fn time(&self) -> f32 {
        self.state.time
    }

    /// Where the objects are. At the end of its path an object begins anew.
    pub(super) fn placements(&self) -> impl Iterator<Item = Placement> {
        self.paths.iter().zip(&self.state.shifts).map(|(path, (offset, angle))| {
            let end = path.end();
            let on_path = path.placement(if end > 0.0 { self.state.time % end } else { 0.0 });
            Placement {
                translation: on_path.translation + *offset,
                rotation: (Quat::from_rotation_y(*angle) * on_path.rotation).normalize(),
                ..on_path
            }
        })
    }

    /// Does what a pressed key asks for.
    pub(super) fn act(&mut self, action: Action) {
        let State { camera, options, ev, circling, chosen, shifts, .. } = &mut self.state;
        match action {
            Action::Show(view) => options.view = view,
            Action::ToggleIndirect => {
                options.view = if options.view == GpuView::Full { GpuView::Direct } else { GpuView::Full };
            }
            Action::ToggleShading => {
                options.shading = match options.shading {
                    Shading::Diffuse => Shading::Physical,
                    Shading::Physical => Shading::Diffuse,
                };
            }
            Action::ToggleCircling => *circling = if circling.is_some() { None } else { Some(0.0) },
            Action::ChooseNext => {
                *chosen = chosen.map_or(Some(0), |index| Some(index + 1)).filter(|next| *next < shifts.len());
            }
            Action::Brighter => *ev += EXPOSURE_STEP,
            Action::Darker => *ev -= EXPOSURE_STEP,
            Action::Reset => {
                // The window keeps its size.
                let (width, height) = (camera.width, camera.height);
                self.state = self.start.clone();
                self.resize(width, height);
            }
            Action::Quit => {}
        }
    }

    /// Changes the size of the picture, pixels.
    pub(super) fn resize(&mut self, width: u32, height: u32) {
        self.state.camera.width = width;
        self.state.camera.height = height;
    }

    /// Turns the camera by as much as the mouse moved, pixels to the right and down.
    pub(super) fn look(&mut self, pixels: Vec2) {
        let camera = &mut self.state.camera;
        let [right, up, forward] = axes(camera);
        let angles = -pixels * camera.vertical_fov / camera.height.max(1) as f32;
        let height = forward.angle_between(up);
        let pitch = angles.y.clamp(
            (height - std::f32::consts::PI + POLE_DISTANCE).min(0.0),
            (height - POLE_DISTANCE).max(0.0),
        );
        let turned = Quat::from_axis_angle(up, angles.x) * Quat::from_axis_angle(right, pitch) * forward;
        camera.target = camera.position + turned.normalize();
    }

    /// Moves what is moving by the time since the last frame.
    pub(super) fn advance(&mut self, held: &HashSet<Motion>, seconds: f32) {
        let State { camera, lighting, circling, time, shifts, chosen, .. } = &mut self.state;
        let [right, up, forward] = axes(camera);
        let balance = |more, less| f32::from(held.contains(&more)) - f32::from(held.contains(&less));
        let step = self.diagonal / SECONDS_ACROSS * seconds;
        let fly = right * balance(Motion::Right, Motion::Left)
            + up * balance(Motion::Up, Motion::Down)
            + forward * balance(Motion::Forward, Motion::Back);
        let fly = fly * step * if held.contains(&Motion::Fast) { FAST } else { 1.0 };
        camera.position += fly;
        camera.target += fly;

        *time += if self.paths.is_empty() { 0.0 } else { seconds };
        let mut push = Vec3::new(
            balance(Motion::LightRight, Motion::LightLeft),
            balance(Motion::LightUp, Motion::LightDown),
            balance(Motion::LightForward, Motion::LightBack),
        );
        let mut turn = Vec2::new(
            balance(Motion::LightTurnsRight, Motion::LightTurnsLeft),
            balance(Motion::LightTurnsUp, Motion::LightTurnsDown),
        );
        let level = up.cross(right);
        let along = |push: Vec3| (right * push.x + up * push.y + level * push.z) * step;
        if let Some((offset, angle)) = chosen.and_then(|index| shifts.get_mut(index)) {
            *offset += along(push);
            *angle -= turn.x * TURN_RATE * seconds;
            (push, turn) = (Vec3::ZERO, Vec2::ZERO);
        }
        let Some(light) = lighting.lights.first_mut() else { return };
        if matches!(light, Light::Directional { .. }) {
            turn += Vec2::new(push.x, push.z + push.y);
            push = Vec3::ZERO;
        }
        turn_light(light, turn * TURN_RATE * seconds, [right, up]);
        move_light(light, along(push));
        if let Some(angle) = circling {
            let step = TURN_RATE * seconds;
            *angle += step;
            let circle = CIRCLE_PER_DIAGONAL * self.diagonal * Vec3::new(angle.cos(), 0.0, angle.sin());
            move_light(light, circle * step);
            if matches!(light, Light::Directional { .. }) {
                turn_light(light, Vec2::X * step, [right, Vec3::Y]);
            }
        }
    }
}

/// Unit vectors to the right, up and forward; up is the camera's own, along which it flies.
fn axes(camera: &Camera) -> [Vec3; 3] {
    let forward = (camera.target - camera.position).normalize_or(-Vec3::Z);
    let up = camera.up.normalize_or(Vec3::Y);
    [forward.cross(up).normalize_or(Vec3::X), up, forward]
}

/// Moves a light that is somewhere.
fn move_light(light: &mut Light, offset: Vec3) {
    if let Light::Point { position, .. } | Light::Spot { position, .. } = light {
        *position += offset;
    }
}

/// Turns a light that shines somewhere, by radians to the right and up.
fn turn_light(light: &mut Light, angles: Vec2, [right, up]: [Vec3; 2]) {
    if let Light::Directional { direction, .. } | Light::Spot { direction, .. } = light
        && angles != Vec2::ZERO
    {
        let turn = Quat::from_axis_angle(up, -angles.x) * Quat::from_axis_angle(right, angles.y);
        *direction = (turn * *direction).normalize();
    }
}

#[cfg(test)]
mod tests {
    use probelight_scene::{Keyframe, Setup};

    use super::*;

    const DIAGONAL: f32 = 20.0;

    fn lamp() -> Light {
        Light::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity: Vec3::ONE, range: None }
    }

    fn sun() -> Light {
        Light::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance: Vec3::ONE }
    }

    fn viewer(lights: Vec<Light>) -> Viewer {
        let camera = Camera {
            name: "test".into(),
            position: Vec3::ZERO,
            target: -5.0 * Vec3::Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            width: 640,
            height: 480,
        };
        let lighting = Lighting { lights, ..Setup::default().lighting };
        Viewer::new(camera, lighting, 0.0, DIAGONAL, Vec::new())
    }

    fn after(viewer: &Viewer, held: &[Motion], seconds: f32) -> State {
        let mut viewer = viewer.clone();
        viewer.advance(&held.iter().copied().collect(), seconds);
        viewer.state
    }

    fn position(light: &Light) -> Vec3 {
        let (Light::Point { position, .. } | Light::Spot { position, .. }) = light else { unreachable!() };
        *position
    }

    fn direction(light: &Light) -> Vec3 {
        let (Light::Directional { direction, .. } | Light::Spot { direction, .. }) = light else {
            unreachable!()
        };
        *direction
    }

    #[test]
    fn held_keys_fly_along_the_view() {
        let viewer = viewer(vec![lamp()]);
        let speed = DIAGONAL / SECONDS_ACROSS;
        let forward = after(&viewer, &[Motion::Forward], 0.5);
        assert!(forward.camera.position.abs_diff_eq(Vec3::new(0.0, 0.0, -0.5 * speed), 1e-5));
        assert!((forward.camera.target - forward.camera.position).abs_diff_eq(-5.0 * Vec3::Z, 1e-5));
        let fast = after(&viewer, &[Motion::Right, Motion::Fast], 0.5);
        assert!(fast.camera.position.abs_diff_eq(Vec3::X * (0.5 * speed * FAST), 1e-5));
        assert_eq!(after(&viewer, &[Motion::Left, Motion::Right], 0.5), viewer.state);
        assert_eq!(after(&viewer, &[], 0.5), viewer.state);
    }

    #[test]
    fn a_mouse_across_the_picture_turns_by_the_field_of_view_and_never_over_the_pole() {
        let mut viewer = viewer(Vec::new());
        viewer.look(Vec2::new(480.0, 0.0));
        let camera = &viewer.state.camera;
        let forward = camera.target - camera.position;
        assert!(forward.abs_diff_eq(Vec3::new(1f32.sin(), 0.0, -1f32.cos()), 1e-5), "{forward}");
        for sign in [1.0, -1.0] {
            for _ in 0..20 {
                viewer.look(Vec2::new(0.0, sign * 300.0));
            }
            let [_, up, forward] = axes(&viewer.state.camera);
            let from_pole = forward.angle_between(-sign * up);
            assert!((from_pole - POLE_DISTANCE).abs() < 1e-3, "{from_pole}");
        }
    }

    #[test]
    fn lamps_move_and_suns_turn() {
        let moved = after(&viewer(vec![lamp(), sun()]), &[Motion::LightUp, Motion::LightLeft], 0.5);
        let offset = position(&moved.lighting.lights[0]) - position(&lamp());
        assert!(offset.abs_diff_eq(Vec3::new(-1.0, 1.0, 0.0), 1e-5), "{offset}");
        assert_eq!(moved.lighting.lights[1], sun(), "only the first light moves");

        let turned = after(&viewer(vec![sun()]), &[Motion::LightRight], 0.5);
        let turned = direction(&turned.lighting.lights[0]);
        assert!((turned.angle_between(direction(&sun())) - 0.6 * 0.25).abs() < 1e-3, "{turned}");
        assert!(turned.is_normalized() && (turned.y - -0.8).abs() < 1e-6, "as high as before: {turned}");
        assert_eq!(after(&viewer(Vec::new()), &[Motion::LightUp], 0.5), viewer(Vec::new()).state);
    }

    #[test]
    fn spots_move_and_turn() {
        let spot = Light::Spot {
            position: Vec3::ONE,
            direction: -Vec3::Z,
            intensity: Vec3::ONE,
            inner_angle: 0.2,
            outer_angle: 0.4,
            range: None,
        };
        let held = [Motion::LightForward, Motion::LightTurnsUp];
        let state = after(&viewer(vec![spot]), &held, 1.0);
        let light = &state.lighting.lights[0];
        assert!(position(light).abs_diff_eq(Vec3::ONE - 2.0 * Vec3::Z, 1e-5));
        assert!(direction(light).abs_diff_eq(Vec3::new(0.0, 0.5f32.sin(), -0.5f32.cos()), 1e-5));
    }

    #[test]
    fn chosen_objects_move_instead_of_the_light_and_paths_begin_anew() {
        let mut viewer = viewer(vec![lamp()]);
        let key = |time: f32| Keyframe { time, placement: Placement::at(Vec3::X * time) };
        let [still, moving] = [vec![key(0.0)], vec![key(0.0), key(4.0)]].map(|keyframes| ObjectPath {
            file: "a.glb".into(),
            keyframes,
            clip: None,
        });
        viewer = Viewer::new(viewer.state.camera, viewer.state.lighting, 0.0, DIAGONAL, vec![still, moving]);
        let at = |viewer: &Viewer| viewer.placements().map(|p| p.translation).collect::<Vec<_>>();
        viewer.advance(&HashSet::new(), 5.0);
        assert_eq!(at(&viewer), [Vec3::ZERO, Vec3::X]);
        viewer.act(Action::ChooseNext);
        viewer.advance(&HashSet::from([Motion::LightUp]), 0.5);
        assert!(at(&viewer)[0].abs_diff_eq(Vec3::Y, 1e-5) && at(&viewer)[1].y == 0.0);
        assert_eq!(viewer.state.lighting.lights[0], lamp());
        viewer.act(Action::ChooseNext);
        viewer.act(Action::ChooseNext);
        viewer.advance(&HashSet::from([Motion::LightUp]), 0.5);
        assert!(at(&viewer)[0].abs_diff_eq(Vec3::Y, 1e-5) && viewer.state.lighting.lights[0] != lamp());
    }

    #[test]
    fn circling_lights_come_back_and_stop() {
        for light in [lamp(), sun()] {
            let mut viewer = viewer(vec![light.clone()]);
            viewer.act(Action::ToggleCircling);
            let (steps, still) = (1000, HashSet::new());
            let step = std::f32::consts::TAU / TURN_RATE / steps as f32;
            let mut farthest = 0.0f32;
            for _ in 0..steps {
                viewer.advance(&still, step);
                let now = &viewer.state.lighting.lights[0];
                farthest = farthest.max(match now {
                    Light::Directional { direction: now, .. } => now.distance(direction(&light)),
                    _ => position(now).distance(position(&light)),
                });
            }
            assert!(farthest > 0.5, "{farthest}");
            let back = viewer.state.lighting.lights[0].clone();
            match back {
                Light::Directional { direction: back, .. } => {
                    assert!(back.abs_diff_eq(direction(&light), 1e-3));
                }
                back => assert!(position(&back).abs_diff_eq(position(&light), 0.05)),
            }
            viewer.act(Action::ToggleCircling);
            let stopped = viewer.state.clone();
            viewer.advance(&still, 1.0);
            assert_eq!(viewer.state, stopped);
        }
    }

    #[test]
    fn keys_choose_what_is_shown_and_reset_keeps_the_window() {
        let mut viewer = viewer(vec![lamp()]);
        let start = viewer.state.clone();
        viewer.act(Action::ToggleIndirect);
        assert_eq!(viewer.state.options.view, GpuView::Direct);
        viewer.act(Action::ToggleIndirect);
        assert_eq!(viewer.state, start);
        viewer.act(Action::Show(GpuView::Probes));
        viewer.act(Action::ToggleShading);
        viewer.act(Action::Brighter);
        viewer.act(Action::Brighter);
        viewer.act(Action::Darker);
        let State { options, ev, .. } = &viewer.state;
        assert_eq!((options.view, options.shading, *ev), (GpuView::Probes, Shading::Physical, EXPOSURE_STEP));
        viewer.resize(99, 33);
        viewer.act(Action::Reset);
        let camera = Camera { width: 99, height: 33, ..start.camera.clone() };
        assert_eq!(viewer.state, State { camera, ..start });
    }
}
