//! All that panels, keys, arguments and tests can ask for. What needs a window, a file or a GPU is a [`Request`], which
//! [`State`] hands on.

use std::path::PathBuf;

use probelight_math::glam::Vec3;
use probelight_render::gpu::GpuView;
use probelight_scene::{Camera, Light, Placement};

use super::camera_rig;
use super::document::{Document, Selection};
use super::edit::Edit;
use super::history::History;
use super::view_state::ViewState;
use crate::platform::Quality;

/// What somebody asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// A change to the document, to be undone if wanted.
    Edit(Edit),
    /// The mouse was let go: what follows is another step.
    EndStep,
    /// Back a step.
    Undo,
    /// Forward a step.
    Redo,
    /// What panels and handles are about.
    Select(Selection),
    /// Nothing is selected.
    Deselect,
    /// Another view of the same; its camera's size is left as it is.
    View(Box<ViewState>),
    /// What the picture shows.
    Show(GpuView),
    /// With and without indirect light.
    ToggleIndirect,
    /// The next comparison.
    NextComparison,
    /// Diffuse surfaces, or glTF's materials.
    ToggleShading,
    /// Whether time goes on.
    TogglePlaying,
    /// Exposure, powers of two.
    Brighten(f32),
    /// Automatic exposure, or as it is now.
    ToggleExposure,
    /// The list of keys.
    ToggleHelp,
    /// All panels, or none.
    TogglePanels,
    /// A lamp in front of the camera.
    AddLamp,
    /// Another one like what is selected.
    CopySelected,
    /// Removes what is selected.
    RemoveSelected,
    /// Looks at what is selected.
    FocusSelected,
    /// Looks at a place from near.
    Focus(Vec3),
    /// Moves what is selected: metres to the right, up and forward, as the camera sees it.
    Nudge(Vec3),
    /// Looks from a camera of the document.
    LookFrom(usize),
    /// Looks from the first camera.
    Home,
    /// Keeps this place as a camera.
    KeepCamera,
    /// Something outside of the state.
    Request(Request),
}

/// What needs a window, a file or a GPU.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Asks for a file to open.
    ChooseFile,
    /// Opens a scene, a baked file, a setup, or an object.
    Open(PathBuf),
    /// Asks for the file of an object.
    ChooseObject,
    /// A ball in front of the camera.
    AddBall,
    /// Saves the setup where it came from.
    Save,
    /// Asks where to save the setup.
    SaveAs,
    /// Saves the setup there.
    SaveTo(PathBuf),
    /// Asks where to save the baked file.
    SaveBake,
    /// Bakes the scene anew.
    Bake(Quality),
    /// Stops the bake.
    CancelBake,
    /// Finds out what is at a pixel of the picture.
    Pick([f32; 2]),
    /// As [`Pick`](Self::Pick), and looks at it.
    FocusOn([f32; 2]),
    /// Saves the picture.
    Screenshot,
    /// Saves all pictures from now on, or no more.
    ToggleRecording,
    /// Copies text.
    CopyText(String),
    /// Ends.
    Quit,
}

/// All that one sees.
#[derive(Clone, Debug)]
pub struct State {
    /// What is lit, by what.
    pub document: Document,
    /// What is shown of it.
    pub view: ViewState,
    /// What panels and handles are about.
    pub selection: Selection,
    /// Undo and redo.
    pub history: History,
    /// Diagonal of the scene's box, metres.
    pub diagonal: f32,
    /// Changed since it was saved.
    pub is_changed: bool,
    /// Exposure of the last picture, as a power of two.
    pub shown_ev: f32,
}

impl State {
    /// A document as it is at the beginning, in a scene whose box has a diagonal of so many metres.
    pub fn new(document: Document, camera: Camera, diagonal: f32) -> Self {
        Self {
            document,
            view: ViewState::new(camera),
            selection: Selection::Nothing,
            history: History::default(),
            diagonal,
            is_changed: false,
            shown_ev: 0.0,
        }
    }

    /// Does what is asked for; returns what others have to do.
    pub fn act(&mut self, action: Action) -> Option<Request> {
        match action {
            Action::Request(request) => return Some(request),
            Action::Edit(edit) => self.edit(edit),
            Action::EndStep => self.history.close(),
            Action::Undo | Action::Redo => self.step(action == Action::Undo),
            Action::Select(wanted) => self.selection = wanted,
            Action::Deselect => self.selection = Selection::Nothing,
            Action::AddLamp => {
                let position = self.place_ahead();
                let intensity = Vec3::splat(self.lamp_strength());
                self.edit(Edit::AddLight(Light::Point { position, intensity, range: None }));
            }
            Action::CopySelected => self.copy_selected(),
            Action::RemoveSelected => match self.selection {
                Selection::Light(item) => self.edit(Edit::RemoveLight(item)),
                Selection::Object(item) => self.edit(Edit::RemoveObject(item)),
                Selection::Nothing | Selection::Material(_) => {}
            },
            Action::FocusSelected => {
                if let Some(place) = self.selected_place() {
                    self.focus(place);
                }
            }
            Action::Focus(place) => self.focus(place),
            Action::Nudge(offset) => self.nudge(offset),
            Action::LookFrom(camera) => self.look_from(camera),
            Action::Home => self.look_from(0),
            Action::KeepCamera => self.keep_camera(),
            of_view => self.view.act(of_view, self.shown_ev),
        }
        None
    }

    /// Another document in place of this one, as a step.
    pub fn replace_document(&mut self, document: Document) {
        self.history.note(&self.document, None, "open another setup");
        self.document = document;
        self.selection = Selection::Nothing;
        self.is_changed = true;
    }

    /// A place in front of the camera, where new things appear.
    pub fn place_ahead(&self) -> Vec3 {
        let camera = &self.view.camera;
        let [_, _, forward] = camera_rig::axes(camera);
        let distance = camera.position.distance(camera.target).min(0.25 * self.diagonal);
        camera.position + forward * distance
    }

    /// Where the selected thing is.
    pub fn selected_place(&self) -> Option<Vec3> {
        match self.selection {
            Selection::Light(item) => {
                let entry = self.document.light(item)?;
                entry.motion.at(&entry.light, self.view.time).position()
            }
            Selection::Object(item) => {
                Some(self.document.object(item)?.placement(self.view.time).translation)
            }
            Selection::Nothing | Selection::Material(_) => None,
        }
    }

    fn edit(&mut self, edit: Edit) {
        let (key, description) = (edit.key(), edit.description());
        let before = self.document.clone();
        edit.apply(&mut self.document, &mut self.selection);
        if self.document != before {
            self.history.note(&before, key, description);
            self.is_changed = true;
        }
    }

    fn step(&mut self, back: bool) {
        let Self { document, history, .. } = self;
        let has_stepped = if back { history.undo(document) } else { history.redo(document) };
        self.is_changed |= has_stepped;
        if !self.document.has(self.selection) {
            self.selection = Selection::Nothing;
        }
    }

    fn keep_camera(&mut self) {
        let taken = |name: &str| self.document.cameras.iter().any(|camera| camera.name == name);
        let names = (1..).map(|number| format!("view {number}"));
        let name = names.into_iter().find(|name| !taken(name)).unwrap_or_default();
        self.edit(Edit::SetCamera(Camera { name, ..self.view.camera.clone() }));
    }

    fn copy_selected(&mut self) {
        match self.selection {
            Selection::Light(item) => self.edit(Edit::CopyLight(item)),
            Selection::Object(item) => {
                if let Some(entry) = self.document.object(item).cloned() {
                    let mut beside = entry.placement(0.0);
                    beside.translation += Vec3::X * 0.05 * self.diagonal;
                    self.edit(Edit::AddObject(entry.path));
                    if let Selection::Object(copy) = self.selection {
                        // It was added in one step, of which this is a part.
                        Edit::PlaceObject(copy, beside).apply(&mut self.document, &mut self.selection);
                    }
                }
            }
            Selection::Nothing | Selection::Material(_) => {}
        }
    }

    fn focus(&mut self, place: Vec3) {
        let distance = self.view.camera.position.distance(place).min(0.15 * self.diagonal);
        camera_rig::focus(&mut self.view.camera, place, distance.max(0.01 * self.diagonal));
    }

    fn nudge(&mut self, offset: Vec3) {
        let [right, up, _] = camera_rig::axes(&self.view.camera);
        let offset = right * offset.x + up * offset.y + up.cross(right) * offset.z;
        match self.selection {
            Selection::Light(item) => {
                let Some(mut light) = self.document.light(item).map(|entry| entry.light.clone()) else {
                    return;
                };
                move_light(&mut light, offset, self.diagonal);
                self.edit(Edit::SetLight(item, light));
            }
            Selection::Object(item) => {
                let Some(placement) = self.document.object(item).map(|entry| entry.placement(0.0)) else {
                    return;
                };
                let moved = Placement { translation: placement.translation + offset, ..placement };
                self.edit(Edit::PlaceObject(item, moved));
            }
            Selection::Nothing | Selection::Material(_) => {}
        }
    }

    fn look_from(&mut self, camera: usize) {
        if let Some(camera) = self.document.cameras.get(camera) {
            let Camera { width, height, .. } = self.view.camera;
            self.view.camera = Camera { width, height, ..camera.clone() };
        }
    }

    /// Intensity of a new lamp, W/sr: as bright as the mean of those there are, or such that it shows at the present
    /// exposure.
    fn lamp_strength(&self) -> f32 {
        let lamps: Vec<f32> = self
            .document
            .lights
            .iter()
            .filter(|entry| entry.light.position().is_some())
            .map(|entry| entry.light.strength().max_element())
            .collect();
        match lamps.len() {
            0 => (0.05 * self.diagonal).powi(2) * (-self.shown_ev).exp2() * 4.0,
            count => lamps.iter().sum::<f32>() / count as f32,
        }
    }
}

/// Moves a light that is somewhere, turns one that is not: a scene's diagonal is half a turn.
fn move_light(light: &mut Light, offset: Vec3, diagonal: f32) {
    match light {
        Light::Point { position, .. } | Light::Spot { position, .. } => *position += offset,
        Light::Directional { .. } => {
            let Some(direction) = light.direction() else { return };
            let turned = direction - offset * std::f32::consts::PI / diagonal.max(f32::MIN_POSITIVE);
            if let (Some(turned), Light::Directional { direction, .. }) = (turned.try_normalize(), light) {
                *direction = turned;
            }
        }
    }
}
