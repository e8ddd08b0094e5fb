//! What a setup file holds: what one may change, undo and save.

use std::path::{Path, PathBuf};

use probelight_runtime::SurfaceColors;
use probelight_scene::{
    Bounds, Camera, Keyframe, Light, LightMotion, LightTrack, Lighting, MaterialColors, ObjectPath,
    Placement, Scene, Setup, Sky,
};

/// A light or an object, as long as it exists; never given twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Item(pub u64);

/// What panels and handles are about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selection {
    /// Nothing.
    #[default]
    Nothing,
    /// A light.
    Light(Item),
    /// An object.
    Object(Item),
    /// A material of the scene, by its index.
    Material(usize),
}

/// A light and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct LightEntry {
    /// Its handle.
    pub item: Item,
    /// For people.
    pub name: String,
    /// Where it is while it stands still.
    pub light: Light,
    /// How it moves from there.
    pub motion: LightMotion,
}

/// An object that moves through the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectEntry {
    /// Its handle.
    pub item: Item,
    /// Its file, found from anywhere, and its way.
    pub path: ObjectPath,
}

impl LightEntry {
    fn track(&self) -> LightTrack {
        LightTrack { name: self.name.clone(), motion: self.motion.clone() }
    }
}

impl ObjectEntry {
    /// For people: the file's name.
    pub fn name(&self) -> String {
        self.path.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Where it is at a time, seconds. At the end of its path it begins anew.
    pub fn placement(&self, time: f32) -> Placement {
        let end = self.path.end();
        self.path.placement(if end > 0.0 { time % end } else { 0.0 })
    }
}

/// What is lit, by what.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// What the setup is called.
    pub name: String,
    /// File name of the scene it was written for.
    pub scene: String,
    /// The lights.
    pub lights: Vec<LightEntry>,
    /// The sky.
    pub sky: Sky,
    /// Factor on all emission.
    pub emissive_scale: f32,
    /// Present colours of all materials.
    pub materials: Vec<SurfaceColors>,
    /// What moves.
    pub objects: Vec<ObjectEntry>,
    /// Places to look from.
    pub cameras: Vec<Camera>,
    eval_bounds: Option<Bounds>,
    next_item: u64,
}

impl Document {
    /// A setup of a scene. Files of objects are looked for in `folder`.
    pub fn new(setup: &Setup, folder: &Path, scene: &Scene) -> Self {
        let mut document = Self {
            name: setup.name.clone(),
            scene: setup.scene.clone(),
            lights: Vec::new(),
            sky: setup.lighting.sky,
            emissive_scale: setup.lighting.emissive_scale,
            materials: SurfaceColors::changed(scene, &setup.materials),
            objects: Vec::new(),
            cameras: setup.cameras.clone(),
            eval_bounds: setup.eval_bounds,
            next_item: 0,
        };
        for (i, light) in setup.lighting.lights.iter().enumerate() {
            let LightTrack { name, motion } = setup.light_tracks.get(i).cloned().unwrap_or_default();
            document.add_light(light.clone(), motion);
            if let Some(entry) = document.lights.last_mut().filter(|_| !name.is_empty()) {
                entry.name = name;
            }
        }
        for object in &setup.objects {
            document.add_object(ObjectPath { file: folder.join(&object.file), ..object.clone() });
        }
        document
    }

    /// The setup that a file in `folder` would hold: colours that are not the scene's, files of objects by how one finds
    /// them from there.
    pub fn setup(&self, folder: &Path, scene: &Scene) -> Setup {
        let relative = |file: &PathBuf| file.strip_prefix(folder).unwrap_or(file).to_path_buf();
        let object =
            |entry: &ObjectEntry| ObjectPath { file: relative(&entry.path.file), ..entry.path.clone() };
        Setup {
            name: self.name.clone(),
            scene: self.scene.clone(),
            lighting: Lighting {
                lights: self.lights.iter().map(|entry| entry.light.clone()).collect(),
                sky: self.sky,
                emissive_scale: self.emissive_scale,
            },
            light_tracks: self.lights.iter().map(LightEntry::track).collect(),
            cameras: self.cameras.clone(),
            eval_bounds: self.eval_bounds,
            objects: self.objects.iter().map(object).collect(),
            materials: self.changed_materials(scene),
        }
    }

    fn changed_materials(&self, scene: &Scene) -> Vec<MaterialColors> {
        let materials = SurfaceColors::of(scene).into_iter().zip(&self.materials).zip(&scene.materials);
        let changed = materials.filter(|((was, is), _)| was != *is);
        changed
            .map(|((was, is), material)| MaterialColors {
                name: material.name.clone(),
                base_color: (was.base_color != is.base_color).then_some(is.base_color),
                emission: (was.emission != is.emission).then_some(is.emission),
            })
            .collect()
    }

    /// All light at a time, seconds.
    pub fn lighting(&self, time: f32) -> Lighting {
        Lighting {
            lights: self.lights.iter().map(|entry| entry.motion.at(&entry.light, time)).collect(),
            sky: self.sky,
            emissive_scale: self.emissive_scale,
        }
    }

    /// Whether anything moves by itself.
    pub fn moves(&self) -> bool {
        self.lights.iter().any(|entry| entry.motion != LightMotion::Still)
            || self.objects.iter().any(|entry| entry.path.end() > 0.0 || entry.path.clip.is_some())
    }

    /// When the last keyframe is, seconds; 0 if nothing moves along keyframes.
    pub fn end(&self) -> f32 {
        let lights = self.lights.iter().map(|entry| entry.motion.end());
        lights.chain(self.objects.iter().map(|entry| entry.path.end())).fold(0.0, f32::max)
    }

    /// A light.
    pub fn light(&self, item: Item) -> Option<&LightEntry> {
        self.lights.iter().find(|entry| entry.item == item)
    }

    /// An object.
    pub fn object(&self, item: Item) -> Option<&ObjectEntry> {
        self.objects.iter().find(|entry| entry.item == item)
    }

    /// Whether what is selected is still there.
    pub fn has(&self, selection: Selection) -> bool {
        match selection {
            Selection::Nothing => true,
            Selection::Light(item) => self.light(item).is_some(),
            Selection::Object(item) => self.object(item).is_some(),
            Selection::Material(material) => material < self.materials.len(),
        }
    }

    pub(super) fn light_mut(&mut self, item: Item) -> Option<&mut LightEntry> {
        self.lights.iter_mut().find(|entry| entry.item == item)
    }

    pub(super) fn object_mut(&mut self, item: Item) -> Option<&mut ObjectEntry> {
        self.objects.iter_mut().find(|entry| entry.item == item)
    }

    pub(super) fn add_light(&mut self, light: Light, motion: LightMotion) -> Item {
        let item = self.new_item();
        let kind = kind_of(&light);
        let numbers =
            self.lights.iter().filter_map(|entry| entry.name.strip_prefix(kind)?.trim().parse().ok());
        let number = numbers.max().unwrap_or(0u32) + 1;
        self.lights.push(LightEntry { item, name: format!("{kind} {number}"), light, motion });
        item
    }

    pub(super) fn add_object(&mut self, path: ObjectPath) -> Item {
        let item = self.new_item();
        self.objects.push(ObjectEntry { item, path });
        item
    }

    fn new_item(&mut self) -> Item {
        self.next_item += 1;
        Item(self.next_item)
    }
}

/// What a kind of light is called.
pub fn kind_of(light: &Light) -> &'static str {
    match light {
        Light::Point { .. } => "Lamp",
        Light::Spot { .. } => "Spot",
        Light::Directional { .. } => "Sun",
    }
}

/// A path that stays where it begins.
pub fn standing(file: PathBuf, placement: Placement) -> ObjectPath {
    ObjectPath { file, keyframes: vec![Keyframe { time: 0.0, placement }], clip: None, is_door: false }
}
