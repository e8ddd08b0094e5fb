//! Objects that move through a scene: those of the setup and of `--object`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail, ensure};
use clap::Args;
use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::{ObjectId, Objects, RuntimeError};
use probelight_scene::{
    AnimatedModel, Keyframe, Object, ObjectPath, Placement, Scene, Setup, load_animated_gltf,
};

use crate::console::Console;
use crate::input;

/// Flags for objects that are not the setup's.
#[derive(Args)]
pub(crate) struct ObjectFlags {
    /// A glTF file as an object in free space: its origin, size and turn about +Y in degrees (repeatable)
    #[arg(long = "object", value_name = "FILE@X,Y,Z[,SCALE[,YAW]]", value_parser = parse_object)]
    pub(crate) objects: Vec<ObjectPath>,

    /// The same as a door: as a box around it would, it opens and shuts ways for light (repeatable)
    #[arg(long = "door", value_name = "FILE@X,Y,Z[,SCALE[,YAW]]", value_parser = parse_object)]
    pub(crate) doors: Vec<ObjectPath>,
}

impl ObjectFlags {
    /// All of them.
    pub(crate) fn paths(&self) -> Vec<ObjectPath> {
        let doors = self.doors.iter().map(|door| ObjectPath { is_door: true, ..door.clone() });
        self.objects.iter().cloned().chain(doors).collect()
    }
}

/// How objects of pictures act on what is around them.
#[derive(Args)]
pub(crate) struct InfluenceFlags {
    /// Objects cast shadows of lamps only: they neither hide nor reflect the soft light around them
    #[arg(long)]
    pub(crate) no_soft_shadows: bool,
}

/// The objects of a picture, and where they are when.
pub(crate) struct Movers {
    movers: Vec<Mover>,
}

struct Mover {
    path: ObjectPath,
    model: Arc<AnimatedModel>,
    clip: Option<usize>,
}

impl Movers {
    /// Reads the models of a setup's objects, whose files lie beside it, and of others.
    pub(crate) fn load(
        setup: &Setup,
        setup_file: Option<&Path>,
        others: &[ObjectPath],
        console: &Console,
    ) -> anyhow::Result<Self> {
        let folder = setup_file.and_then(Path::parent).unwrap_or(Path::new(""));
        let beside = setup.objects.iter().map(|path| (folder.join(&path.file), path));
        let named = others.iter().map(|path| (path.file.clone(), path));
        let mut models: Vec<(PathBuf, Arc<AnimatedModel>)> = Vec::new();
        let mut movers = Vec::new();
        for (file, path) in beside.chain(named) {
            let known = models.iter().find(|(known, _)| *known == file).map(|(_, model)| Arc::clone(model));
            let model = match known {
                Some(model) => model,
                None => {
                    let model = load_animated_gltf(&file)
                        .with_context(|| format!("the object {} cannot be used", file.display()))?;
                    input::warn_of(model.rest(), &file, console);
                    let model = Arc::new(model);
                    models.push((file.clone(), Arc::clone(&model)));
                    model
                }
            };
            let clip = path.clip.as_deref().map(|name| clip_of(&model, name, &file)).transpose()?;
            movers.push(Mover { path: path.clone(), model, clip });
        }
        Ok(Self { movers })
    }

    /// Says so if the objects will not get what light they could.
    pub(crate) fn note_missing_grid(&self, baked: &BakedScene, console: &Console) {
        if !self.movers.is_empty() && !baked.has_grid() {
            console.warn(
                "the scene was baked without a grid (--grid 0): objects get no light but that of lamps",
            );
        }
    }

    /// The objects as they are at a time, seconds.
    pub(crate) fn at(&self, time: f32) -> anyhow::Result<Vec<Object>> {
        let object = |mover: &Mover| mover.path.object(mover.shape(time), mover.path.placement(time));
        Ok(self.movers.iter().map(object).collect::<Result<_, _>>()?)
    }

    /// What a path tracer traces: the scene with the setup's colours and the objects as they are at the beginning.
    pub(crate) fn traced_scene(&self, setup: &Setup, scene: Arc<Scene>) -> anyhow::Result<Arc<Scene>> {
        let scene = if setup.materials.is_empty() { scene } else { Arc::new(input::colored(setup, &scene)) };
        let objects = self.at(0.0)?;
        Ok(if objects.is_empty() { scene } else { Arc::new(scene.with_objects(&objects)) })
    }

    /// Puts the objects into a scene as they are at the beginning; returns their handles.
    pub(crate) fn enter(&self, objects: &mut Objects) -> anyhow::Result<Vec<ObjectId>> {
        Ok(self.at(0.0)?.into_iter().map(|object| objects.insert(object)).collect())
    }

    /// Moves the objects of some handles to where they are at a time, seconds, and into their poses.
    pub(crate) fn place(
        &self,
        ids: &[ObjectId],
        objects: &mut Objects,
        time: f32,
    ) -> Result<(), RuntimeError> {
        self.pose(ids, objects, time)?;
        let mut movers = ids.iter().zip(&self.movers);
        movers.try_for_each(|(id, mover)| objects.place(*id, mover.path.placement(time)))
    }

    /// Puts the objects that play a clip into their poses.
    pub(crate) fn pose(
        &self,
        ids: &[ObjectId],
        objects: &mut Objects,
        time: f32,
    ) -> Result<(), RuntimeError> {
        let mut animated = ids.iter().zip(&self.movers).filter(|(_, mover)| mover.clip.is_some());
        animated.try_for_each(|(id, mover)| objects.reshape(*id, mover.shape(time)))
    }
}

impl Mover {
    fn shape(&self, time: f32) -> Arc<Scene> {
        match self.clip {
            Some(clip) => Arc::new(self.model.pose(Some(clip), time)),
            None => Arc::clone(self.model.rest()),
        }
    }
}

/// The clip of a name, which must be there.
fn clip_of(model: &AnimatedModel, name: &str, file: &Path) -> anyhow::Result<usize> {
    model.clip(name).with_context(|| {
        let known: Vec<&str> = model.clips().collect();
        let known =
            if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
        format!("{} has no clip {name:?}: {known}", file.display())
    })
}

/// Parses `FILE@X,Y,Z[,SCALE[,YAW]]`.
fn parse_object(text: &str) -> anyhow::Result<ObjectPath> {
    let (file, place) =
        text.rsplit_once('@').context("expected FILE@X,Y,Z[,SCALE[,YAW]], for example chair.glb@1,0,2.5")?;
    ensure!(!file.is_empty(), "a file is missing before the @");
    let numbers = place.split(',').map(|number| number.trim().parse::<f32>());
    let numbers =
        numbers.collect::<Result<Vec<_>, _>>().with_context(|| format!("{place:?}: not only numbers"))?;
    let (position, scale, yaw) = match numbers[..] {
        [x, y, z] => (Vec3::new(x, y, z), 1.0, 0.0),
        [x, y, z, scale] => (Vec3::new(x, y, z), scale, 0.0),
        [x, y, z, scale, yaw] => (Vec3::new(x, y, z), scale, yaw),
        _ => bail!("{place:?}: three to five numbers expected, X,Y,Z[,SCALE[,YAW]]"),
    };
    let placement = Placement::upright(position, yaw.to_radians(), scale);
    placement.validate()?;
    Ok(ObjectPath {
        file: file.into(),
        keyframes: vec![Keyframe { time: 0.0, placement }],
        clip: None,
        is_door: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_a_file_and_a_place() {
        let object = parse_object("a@b/chair.glb@1,-2.5,3").unwrap();
        assert_eq!(object.file, Path::new("a@b/chair.glb"));
        assert_eq!(object.placement(7.0), Placement::at(Vec3::new(1.0, -2.5, 3.0)));
        let turned = parse_object("c.glb@0,0,0,2,90").unwrap().placement(0.0);
        assert_eq!(turned.scale, 2.0);
        assert!(turned.direction(Vec3::X).abs_diff_eq(Vec3::NEG_Z, 1e-6));
        for wrong in [
            "c.glb",
            "@1,2,3",
            "c.glb@1,2",
            "c.glb@1,2,x",
            "c.glb@1,2,3,0",
            "c.glb@1,2,3,1,0,9",
            "c.glb@1,2,inf",
        ] {
            assert!(parse_object(wrong).is_err(), "{wrong}");
        }
    }
}
