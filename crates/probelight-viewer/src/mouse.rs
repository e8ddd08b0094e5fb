//! The mouse in the picture, and keys that are held.

use eframe::egui::{
    Context, Event, InputState, Key, KeyboardShortcut, PointerButton, Response, Vec2 as Vector,
};
use probelight_math::glam::{Vec2, Vec3};

use crate::handles::{self, Frame, Held};
use crate::scene::live_scene::LiveScene;
use crate::scene::pick::{Picked, pick};
use crate::state::camera_rig::{axes, dolly, fly, look, orbit, pan};
use crate::state::keys::{Binding, bindings};
use crate::state::{Action, Request, Selection, State};

/// The camera crosses the scene in about so many seconds.
const SECONDS_ACROSS: f32 = 10.0;

/// Factor on the camera's speed while Shift is held.
const FAST: f32 = 4.0;

/// What the mouse holds.
#[derive(Clone, Copy, Debug, Default)]
pub enum Grip {
    /// Nothing.
    #[default]
    Nothing,
    /// A handle.
    Handle(Held),
    /// The divider between two pictures.
    Divider,
    /// The camera.
    Camera(PointerButton),
}

/// What the mouse does in the picture.
pub fn mouse(
    grip: &mut Grip,
    response: &Response,
    frame: &Frame,
    state: &State,
    live: Option<&LiveScene>,
    is_divided: bool,
) -> Vec<Action> {
    let mut actions = Vec::new();
    let mut view = state.view.clone();
    let points = response.drag_delta();
    let pixels =
        Vec2::new(points.x, points.y) * state.view.camera.height as f32 / frame.rect.height().max(1.0);
    for button in [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle] {
        if response.drag_started_by(button) {
            *grip = take(button, response, frame, state, live, is_divided);
            if let Grip::Handle(held) = grip {
                actions.push(Action::Select(held.selection()));
            }
        }
    }
    match *grip {
        Grip::Nothing => {}
        Grip::Handle(held) => {
            if let Some(at) = response.interact_pointer_pos()
                && points != Vector::ZERO
            {
                actions.extend(held.drag(frame, &state.document, &state.view, at));
            }
        }
        Grip::Divider => {
            if let Some(at) = response.interact_pointer_pos() {
                view.divider = ((at.x - frame.rect.min.x) / frame.rect.width()).clamp(0.02, 0.98);
            }
        }
        Grip::Camera(PointerButton::Primary) => orbit(&mut view.camera, pixels),
        Grip::Camera(PointerButton::Secondary) => look(&mut view.camera, pixels),
        Grip::Camera(_) => pan(&mut view.camera, pixels),
    }
    if response.drag_stopped() {
        *grip = Grip::Nothing;
        actions.push(Action::EndStep);
    }
    wheel(response, *grip, state.diagonal, &mut view.speed, &mut view.camera);
    if let Some(at) = response.interact_pointer_pos() {
        let pixel = frame.pixel(at).to_array();
        if response.double_clicked() {
            actions.push(Action::Request(Request::FocusOn(pixel)));
        } else if response.clicked() {
            actions.push(click(response, frame, state, pixel));
        }
    }
    if view != state.view {
        actions.push(Action::View(Box::new(view)));
    }
    actions
}

/// What a click chooses: a light, or what is seen there.
fn click(response: &Response, frame: &Frame, state: &State, pixel: [f32; 2]) -> Action {
    let at = response.interact_pointer_pos().unwrap_or_default();
    match handles::take(frame, &state.document, &state.view, Selection::Nothing, at) {
        Some(held) if state.view.overlays.lights => Action::Select(held.selection()),
        _ => Action::Request(Request::Pick(pixel)),
    }
}

fn take(
    button: PointerButton,
    response: &Response,
    frame: &Frame,
    state: &State,
    live: Option<&LiveScene>,
    is_divided: bool,
) -> Grip {
    // Where the button went down, not where the mouse has moved since.
    let at =
        response.interact_pointer_pos().unwrap_or_default() - response.total_drag_delta().unwrap_or_default();
    if button != PointerButton::Primary {
        return Grip::Camera(button);
    }
    let divider = frame.rect.min.x + state.view.divider * frame.rect.width();
    if is_divided && (at.x - divider).abs() < 6.0 {
        return Grip::Divider;
    }
    if state.view.overlays.lights
        && let Some(held) = handles::take(frame, &state.document, &state.view, state.selection, at)
    {
        return Grip::Handle(held);
    }
    let object = live.filter(|_| !state.document.objects.is_empty()).and_then(|live| {
        match pick(live, &state.view.camera, frame.pixel(at)) {
            Picked::Object(item, _) => handles::take_object(frame, &state.document, &state.view, item, at),
            Picked::Nothing | Picked::Surface(_) => None,
        }
    });
    object.map_or(Grip::Camera(button), Grip::Handle)
}

fn wheel(
    response: &Response,
    grip: Grip,
    diagonal: f32,
    speed: &mut f32,
    camera: &mut probelight_scene::Camera,
) {
    if !response.hovered() && !response.dragged() {
        return;
    }
    let turned = response.ctx.input(|input| input.smooth_scroll_delta.y);
    if turned == 0.0 {
        return;
    }
    if matches!(grip, Grip::Camera(PointerButton::Secondary)) {
        *speed = (*speed * (turned * 0.005).exp()).clamp(0.05, 20.0);
    } else {
        dolly(camera, (-turned * 0.003).exp(), diagonal);
    }
}

/// What keys do once, when nobody writes text.
pub fn pressed(context: &Context) -> Vec<Action> {
    if context.text_edit_focused() {
        return Vec::new();
    }
    let bindings = bindings();
    context.input_mut(|input| {
        // In a slow frame several keys may have been pressed, and one of them twice.
        let mut actions = Vec::new();
        input.events.retain(|event| {
            let Event::Key { key, modifiers, pressed: true, .. } = event else { return true };
            let is_meant = |binding: &&Binding| {
                let KeyboardShortcut { modifiers: wanted, logical_key } = binding.shortcut;
                *key == logical_key && modifiers.matches_logically(wanted)
            };
            let meant = bindings.iter().find(is_meant);
            actions.extend(meant.map(|binding| binding.action.clone()));
            meant.is_none()
        });
        actions
    })
}

/// What keys do while they are held, in some seconds. Nothing while somebody writes text.
pub fn held(context: &Context, state: &State, seconds: f32) -> Vec<Action> {
    if context.text_edit_focused() {
        return Vec::new();
    }
    let (flight, push) = context.input(|input| (flight(input), push(input)));
    // Arrows belong to what has the keyboard's focus, such as a slider.
    let push = if context.egui_wants_keyboard_input() { Vec3::ZERO } else { push };
    let step = state.diagonal / SECONDS_ACROSS * seconds * state.view.speed;
    let mut actions = Vec::new();
    if flight != Vec3::ZERO {
        let mut view = state.view.clone();
        let [right, up, forward] = axes(&view.camera);
        fly(&mut view.camera, (right * flight.x + up * flight.y + forward * flight.z) * step);
        actions.push(Action::View(Box::new(view)));
    }
    if push != Vec3::ZERO {
        actions.push(Action::Nudge(push * step));
    }
    actions
}

/// Whether a key is held that moves something.
pub fn is_moving(input: &InputState) -> bool {
    flight(input) != Vec3::ZERO || push(input) != Vec3::ZERO
}

fn balance(input: &InputState, more: Key, less: Key) -> f32 {
    f32::from(u8::from(input.key_down(more))) - f32::from(u8::from(input.key_down(less)))
}

/// Right, up, forward.
fn flight(input: &InputState) -> Vec3 {
    if input.modifiers.command {
        return Vec3::ZERO;
    }
    let fast = if input.modifiers.shift { FAST } else { 1.0 };
    Vec3::new(balance(input, Key::D, Key::A), balance(input, Key::E, Key::Q), balance(input, Key::W, Key::S))
        * fast
}

/// Right, up, forward.
fn push(input: &InputState) -> Vec3 {
    Vec3::new(
        balance(input, Key::ArrowRight, Key::ArrowLeft),
        balance(input, Key::PageUp, Key::PageDown),
        balance(input, Key::ArrowUp, Key::ArrowDown),
    )
}
