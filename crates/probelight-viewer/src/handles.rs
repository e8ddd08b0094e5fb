//! Handles in the picture by which lights and objects are moved and turned with the mouse.

use eframe::egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2 as Vector};
use probelight_math::glam::{Quat, Vec2, Vec3};
use probelight_scene::{Camera, Light, Placement};

use crate::state::camera_rig::{axes, project};
use crate::state::document::{Document, Item, Selection};
use crate::state::view_state::ViewState;
use crate::state::{Action, Edit};

/// How near the mouse must be, points.
const REACH: f32 = 11.0;

/// Length of the arrows, as a share of the distance from the eye.
const ARROW: f32 = 0.12;

/// What a handle does when it is dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Effect {
    /// Moves the thing, in the plane of the view or along a unit vector.
    Move(Option<Vec3>),
    /// Lets a light shine to the handle, or from it, as seen from a point.
    Aim { from: Vec3, is_source: bool },
    /// Turns an object about its vertical.
    Turn { around: Vec3 },
}

/// Something that can be dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Handle {
    place: Vec3,
    effect: Effect,
    color: Color32,
}

impl Handle {
    /// Whether it can be told from what it moves: an arrow that one looks along would hide it.
    fn is_seen(&self, frame: &Frame, anchor: Vec3) -> bool {
        let Effect::Move(Some(_)) = self.effect else { return true };
        let ends = frame.project(anchor).zip(frame.project(self.place));
        ends.is_some_and(|((from, _), (to, _))| from.distance(to) > 2.0 * REACH)
    }
}

/// A handle that is held, and where it was taken: relative to its middle, points.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    selection: Selection,
    handle: Handle,
    /// From what it moves to the handle.
    lever: Vec3,
    offset: Vector,
}

/// The picture in the window.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Where the picture is, points.
    pub rect: Rect,
    /// What the camera sees fills it.
    pub camera: &'a Camera,
}

impl Frame<'_> {
    /// Where a point is in the window, and its distance along the view.
    pub fn project(&self, point: Vec3) -> Option<(Pos2, f32)> {
        let (pixel, depth) = project(self.camera, point)?;
        let scale = self.rect.height() / self.camera.height.max(1) as f32;
        Some((self.rect.min + Vector::new(pixel.x, pixel.y) * scale, depth))
    }

    /// The pixel of the camera's picture at a place in the window.
    pub fn pixel(&self, at: Pos2) -> Vec2 {
        let scale = self.camera.height.max(1) as f32 / self.rect.height().max(1.0);
        let offset = (at - self.rect.min) * scale;
        Vec2::new(offset.x, offset.y)
    }

    /// The point at a place in the window that is as far along the view as another.
    fn at_depth(&self, at: Pos2, depth: f32) -> Vec3 {
        let direction = self.camera.ray_direction(self.pixel(at));
        let [_, _, forward] = axes(self.camera);
        self.camera.position + direction * (depth / direction.dot(forward).max(1e-6))
    }

    /// The point on a line that is nearest to what is seen at a place in the window.
    fn on_line(&self, at: Pos2, origin: Vec3, along: Vec3) -> Option<Vec3> {
        let ray = self.camera.ray_direction(self.pixel(at));
        let between = origin - self.camera.position;
        let cosine = ray.dot(along);
        let sine_squared = 1.0 - cosine * cosine;
        // A line that one looks along cannot be moved along.
        (sine_squared > 1e-3)
            .then(|| origin + along * ((cosine * between.dot(ray) - between.dot(along)) / sine_squared))
    }
}

/// Draws lights and the handles of what is selected.
pub fn paint(painter: &Painter, frame: &Frame, document: &Document, view: &ViewState, selection: Selection) {
    for entry in &document.lights {
        let light = entry.motion.at(&entry.light, view.time);
        let is_selected = selection == Selection::Light(entry.item);
        let Some((at, _)) = light.position().and_then(|place| frame.project(place)) else { continue };
        if !frame.rect.contains(at) {
            continue;
        }
        let color =
            if is_selected { Color32::from_rgb(255, 200, 60) } else { Color32::from_rgb(230, 230, 200) };
        painter.circle(at, 5.0, Color32::from_black_alpha(120), Stroke::new(2.0, color));
        for spoke in 0..8 {
            let direction = Vector::angled(spoke as f32 * std::f32::consts::FRAC_PI_4);
            painter.line_segment([at + direction * 7.0, at + direction * 10.0], Stroke::new(1.5, color));
        }
    }
    let Some(anchor) = anchor(document, view, selection) else { return };
    for handle in handles(document, view, selection, anchor) {
        if !handle.is_seen(frame, anchor) {
            continue;
        }
        let (Some((from, _)), Some((to, _))) = (frame.project(anchor), frame.project(handle.place)) else {
            continue;
        };
        if from != to {
            painter.line_segment([from, to], Stroke::new(2.0, handle.color));
        }
        painter.circle(to, 5.0, handle.color, Stroke::new(1.0, Color32::BLACK));
    }
    if let Selection::Light(item) = selection
        && let Some(entry) = document.light(item)
    {
        paint_cone(painter, frame, &entry.motion.at(&entry.light, view.time), anchor);
    }
}

/// The rim of a spot's cone.
fn paint_cone(painter: &Painter, frame: &Frame, light: &Light, anchor: Vec3) {
    let Light::Spot { direction, outer_angle, .. } = light else { return };
    let length = 2.0 * ARROW * frame.camera.position.distance(anchor);
    let side = direction.any_orthonormal_vector();
    let angle = outer_angle.min(1.5);
    let rim = |step: usize| {
        let around = Quat::from_axis_angle(*direction, step as f32 * std::f32::consts::TAU / 32.0);
        anchor + length * (*direction * angle.cos() + around * side * angle.sin())
    };
    let stroke = Stroke::new(1.0, Color32::from_rgb(255, 200, 60));
    for step in 0..32 {
        if let (Some((a, _)), Some((b, _))) = (frame.project(rim(step)), frame.project(rim(step + 1))) {
            painter.line_segment([a, b], stroke);
            if step % 8 == 0
                && let Some((apex, _)) = frame.project(anchor)
            {
                painter.line_segment([apex, a], stroke);
            }
        }
    }
}

/// The handle or light at a place of the window.
pub fn take(
    frame: &Frame,
    document: &Document,
    view: &ViewState,
    selection: Selection,
    at: Pos2,
) -> Option<Held> {
    let held = |(selection, handle): (Selection, Handle)| {
        let anchor = anchor(document, view, selection)?;
        let lever = handle.place - anchor;
        if !handle.is_seen(frame, anchor) {
            return None;
        }
        let offset = frame.project(handle.place)?.0 - at;
        Some(Held { selection, handle, lever, offset })
    };
    let nearest = |candidates: Vec<(Selection, Handle)>| {
        candidates
            .into_iter()
            .filter_map(held)
            .filter(|held| held.offset.length() < REACH)
            .min_by(|a, b| a.offset.length().total_cmp(&b.offset.length()))
    };
    let own = anchor(document, view, selection)
        .map(|anchor| handles(document, view, selection, anchor))
        .unwrap_or_default();
    nearest(own.into_iter().map(|handle| (selection, handle)).collect()).or_else(|| {
        let lights = document.lights.iter().filter_map(|entry| {
            let place = entry.motion.at(&entry.light, view.time).position()?;
            let handle = Handle { place, effect: Effect::Move(None), color: Color32::WHITE };
            Some((Selection::Light(entry.item), handle))
        });
        nearest(lights.collect())
    })
}

/// An object that is taken at a place of it.
pub fn take_object(
    frame: &Frame,
    document: &Document,
    view: &ViewState,
    item: Item,
    at: Pos2,
) -> Option<Held> {
    let place = document.object(item)?.placement(view.time).translation;
    let handle = Handle { place, effect: Effect::Move(None), color: Color32::WHITE };
    let offset = frame.project(place)?.0 - at;
    Some(Held { selection: Selection::Object(item), handle, lever: Vec3::ZERO, offset })
}

impl Held {
    /// What it belongs to.
    pub fn selection(&self) -> Selection {
        self.selection
    }

    /// What dragging it to a place of the window changes.
    pub fn drag(&self, frame: &Frame, document: &Document, view: &ViewState, at: Pos2) -> Option<Action> {
        let at = at + self.offset;
        let anchor = anchor(document, view, self.selection)?;
        let place = match self.handle.effect {
            Effect::Move(Some(along)) => frame.on_line(at, self.handle.place, along)?,
            _ => frame.at_depth(at, frame.project(self.handle.place)?.1),
        };
        match self.handle.effect {
            Effect::Move(_) => self.move_by(document, place - self.lever - anchor),
            Effect::Aim { from, is_source } => {
                let direction = (place - from).try_normalize()?;
                self.aim(document, if is_source { -direction } else { direction })
            }
            Effect::Turn { around } => self.turn(document, place - around),
        }
    }

    fn move_by(&self, document: &Document, offset: Vec3) -> Option<Action> {
        match self.selection {
            Selection::Light(item) => {
                let mut light = document.light(item)?.light.clone();
                if let Light::Point { position, .. } | Light::Spot { position, .. } = &mut light {
                    *position += offset;
                }
                Some(Action::Edit(Edit::SetLight(item, light)))
            }
            Selection::Object(item) => {
                let entry = document.object(item)?;
                let placement = entry.placement(0.0);
                let moved = Placement { translation: placement.translation + offset, ..placement };
                Some(Action::Edit(Edit::PlaceObject(item, moved)))
            }
            Selection::Nothing | Selection::Material(_) => None,
        }
    }

    fn aim(&self, document: &Document, towards: Vec3) -> Option<Action> {
        let Selection::Light(item) = self.selection else { return None };
        let mut light = document.light(item)?.light.clone();
        if let Light::Spot { direction, .. } | Light::Directional { direction, .. } = &mut light {
            *direction = towards;
        }
        Some(Action::Edit(Edit::SetLight(item, light)))
    }

    fn turn(&self, document: &Document, towards: Vec3) -> Option<Action> {
        let Selection::Object(item) = self.selection else { return None };
        let placement = document.object(item)?.placement(0.0);
        let rotation = Quat::from_rotation_y(towards.x.atan2(towards.z));
        Some(Action::Edit(Edit::PlaceObject(item, Placement { rotation, ..placement })))
    }
}

/// Where the handles of what is selected begin.
fn anchor(document: &Document, view: &ViewState, selection: Selection) -> Option<Vec3> {
    match selection {
        Selection::Light(item) => {
            let entry = document.light(item)?;
            let light = entry.motion.at(&entry.light, view.time);
            // A sun has its handle where the camera looks.
            Some(light.position().unwrap_or(view.camera.target))
        }
        Selection::Object(item) => Some(document.object(item)?.placement(view.time).translation),
        Selection::Nothing | Selection::Material(_) => None,
    }
}

fn handles(document: &Document, view: &ViewState, selection: Selection, anchor: Vec3) -> Vec<Handle> {
    let length = arrow_length(&view.camera, anchor);
    let arrow = |along: Vec3, color| Handle {
        place: anchor + along * length,
        effect: Effect::Move(Some(along)),
        color,
    };
    let arrows = [
        arrow(Vec3::X, Color32::from_rgb(225, 70, 60)),
        arrow(Vec3::Y, Color32::from_rgb(100, 190, 60)),
        arrow(Vec3::Z, Color32::from_rgb(70, 120, 230)),
    ];
    let yellow = Color32::from_rgb(255, 200, 60);
    let middle = Handle { place: anchor, effect: Effect::Move(None), color: yellow };
    match selection {
        Selection::Light(item) => {
            let Some(entry) = document.light(item) else { return Vec::new() };
            let light = entry.motion.at(&entry.light, view.time);
            let Some(direction) = light.direction() else { return [&[middle][..], &arrows].concat() };
            let is_source = light.position().is_none();
            let reach = if is_source { -3.0 } else { 2.0 } * length;
            let aim = Handle {
                place: anchor + direction * reach,
                effect: Effect::Aim { from: anchor, is_source },
                color: yellow,
            };
            if is_source { vec![aim] } else { [&[middle, aim][..], &arrows].concat() }
        }
        Selection::Object(item) => {
            let Some(entry) = document.object(item) else { return Vec::new() };
            let front = (entry.placement(view.time).rotation * Vec3::Z).normalize_or(Vec3::Z);
            let level = Vec3::new(front.x, 0.0, front.z).normalize_or(Vec3::Z);
            let turn = Handle {
                place: anchor + level * length * 1.6,
                effect: Effect::Turn { around: anchor },
                color: yellow,
            };
            [&[middle, turn][..], &arrows].concat()
        }
        Selection::Nothing | Selection::Material(_) => Vec::new(),
    }
}

fn arrow_length(camera: &Camera, anchor: Vec3) -> f32 {
    ARROW * camera.position.distance(anchor)
}

#[cfg(test)]
mod tests {
    use probelight_scene::{Scene, Setup};

    use super::*;

    fn camera() -> Camera {
        Camera {
            name: "test".into(),
            position: Vec3::new(0.0, 0.0, 10.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            vertical_fov: 1.0,
            width: 800,
            height: 600,
        }
    }

    fn document(light: Light) -> (Document, Selection) {
        let mut setup = Setup::default();
        setup.lighting.lights.push(light);
        let document = Document::new(&setup, "".as_ref(), &Scene::default());
        let selection = Selection::Light(document.lights[0].item);
        (document, selection)
    }

    /// The light after a handle was dragged by so many points; `None` if there is no handle.
    fn dragged(light: Light, from: Vec3, by: Vector) -> Option<Light> {
        let (document, selection) = document(light);
        let view = ViewState::new(camera());
        // Two pixels are a point.
        let frame = Frame {
            rect: Rect::from_min_size(Pos2::new(50.0, 20.0), Vector::new(400.0, 300.0)),
            camera: &view.camera,
        };
        let at = frame.project(from)?.0 + Vector::new(3.0, -2.0);
        let held = take(&frame, &document, &view, selection, at)?;
        match held.drag(&frame, &document, &view, at + by)? {
            Action::Edit(Edit::SetLight(_, light)) => Some(light),
            other => panic!("{other:?}"),
        }
    }

    fn lamp(position: Vec3) -> Light {
        Light::Point { position, intensity: Vec3::ONE, range: None }
    }

    #[test]
    fn lamps_stay_under_the_mouse() {
        let place = Vec3::new(1.0, 0.5, 2.0);
        let moved = dragged(lamp(place), place, Vector::new(40.0, 0.0)).unwrap().position().unwrap();
        let camera = camera();
        let pixel = |point| project(&camera, point).unwrap().0;
        assert!((pixel(moved) - pixel(place) - Vec2::new(80.0, 0.0)).length() < 0.1);
        assert!((moved.z - place.z).abs() < 1e-4, "in the plane of the view");
        let clicked = dragged(lamp(place), place, Vector::ZERO).unwrap().position().unwrap();
        assert!(clicked.abs_diff_eq(place, 1e-5), "a click moves nothing: {clicked}");
    }

    #[test]
    fn arrows_move_along_their_axis_only() {
        let place = Vec3::new(1.0, 0.5, 2.0);
        let arrow = place + Vec3::Y * arrow_length(&camera(), place);
        let moved = dragged(lamp(place), arrow, Vector::new(25.0, -30.0)).unwrap().position().unwrap();
        assert!(moved.y > place.y + 0.3 && (moved - place).with_y(0.0).length() < 1e-4, "{moved}");
        let still = dragged(lamp(place), arrow, Vector::ZERO).unwrap().position().unwrap();
        assert!(still.distance(place) < 1e-3, "{still}");
    }

    #[test]
    fn suns_shine_from_their_handle() {
        let direction = Vec3::new(0.6, -0.8, 0.0);
        let sun = Light::Directional { direction, irradiance: Vec3::ONE };
        let tail = -direction * 3.0 * arrow_length(&camera(), Vec3::ZERO);
        let lower = dragged(sun.clone(), tail, Vector::new(0.0, 20.0)).unwrap().direction().unwrap();
        assert!(lower.y > direction.y && lower.x > 0.6 && lower.is_normalized(), "{lower}");
        assert!(dragged(sun, Vec3::splat(1.5), Vector::ZERO).is_none(), "there is nothing");
    }
}
