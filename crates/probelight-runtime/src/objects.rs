//! What moves through a scene, by handles.

use std::sync::Arc;

use probelight_scene::{Bounds, Object, Placement, Scene};

use crate::object_spheres::fit_spheres;
use crate::{ObjectSphere, RuntimeError};

/// The handle of an object in one runtime; never given twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ObjectId(u64);

/// The objects of a scene, in the order in which they came.
#[derive(Clone, Debug)]
pub struct Objects {
    ids: Vec<ObjectId>,
    objects: Vec<Object>,
    bounds: Vec<Bounds>,
    /// Of each object, those of its model.
    model_spheres: Vec<Arc<[ObjectSphere]>>,
    /// Of all objects, in their places; renewed by each frame.
    spheres: Vec<ObjectSphere>,
    next: u64,
    influence: bool,
    /// Whether anything changed since the last frame.
    stale: bool,
}

impl Default for Objects {
    /// None.
    fn default() -> Self {
        Self {
            ids: Vec::new(),
            objects: Vec::new(),
            bounds: Vec::new(),
            model_spheres: Vec::new(),
            spheres: Vec::new(),
            next: 0,
            influence: true,
            stale: false,
        }
    }
}

impl Objects {
    /// Adds an object.
    pub fn insert(&mut self, object: Object) -> ObjectId {
        let id = ObjectId(self.next);
        self.next += 1;
        self.ids.push(id);
        let spheres = self.spheres_of(&object);
        self.bounds.push(reached_bounds(&object, &spheres));
        self.model_spheres.push(spheres);
        self.objects.push(object);
        self.stale = true;
        id
    }

    /// Takes an object out of the scene.
    ///
    /// # Errors
    /// [`RuntimeError::UnknownObject`].
    pub fn remove(&mut self, id: ObjectId) -> Result<Object, RuntimeError> {
        let index = self.index(id)?;
        self.stale = true;
        self.ids.remove(index);
        self.bounds.remove(index);
        self.model_spheres.remove(index);
        Ok(self.objects.remove(index))
    }

    /// Moves an object.
    ///
    /// # Errors
    /// [`RuntimeError::UnknownObject`], or [`RuntimeError::Object`] if it cannot be there; then it stays where it is.
    pub fn place(&mut self, id: ObjectId, placement: Placement) -> Result<(), RuntimeError> {
        let index = self.index(id)?;
        if *self.objects[index].placement() != placement {
            self.objects[index].place(placement).map_err(RuntimeError::Object)?;
            self.bounds[index] = reached_bounds(&self.objects[index], &self.model_spheres[index]);
            self.stale = true;
        }
        Ok(())
    }

    /// Gives an object another shape, such as the next pose of an animation.
    ///
    /// # Errors
    /// [`RuntimeError::UnknownObject`], or [`RuntimeError::Object`] if it is none; then it keeps the one that it has.
    pub fn reshape(&mut self, id: ObjectId, model: Arc<Scene>) -> Result<(), RuntimeError> {
        let index = self.index(id)?;
        let mut object = self.objects[index].clone();
        object.reshape(model).map_err(RuntimeError::Object)?;
        self.model_spheres[index] = self.spheres_of(&object);
        self.objects[index] = object;
        self.bounds[index] = reached_bounds(&self.objects[index], &self.model_spheres[index]);
        self.stale = true;
        Ok(())
    }

    /// Whether objects darken and colour the soft light around them, as [`ObjectInfluence`](crate::ObjectInfluence) has it.
    /// They do unless they are told otherwise; shadows of analytic lights are not affected.
    pub fn set_influence(&mut self, influence: bool) {
        self.stale |= self.influence != influence;
        self.influence = influence;
    }

    /// An object, if there is one of this handle.
    pub fn get(&self, id: ObjectId) -> Option<&Object> {
        self.index(id).ok().map(|index| &self.objects[index])
    }

    /// All of them.
    pub fn as_slice(&self) -> &[Object] {
        &self.objects
    }

    /// A world box around each and all that it [darkens](ObjectSphere), metres.
    pub(crate) fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    /// Spheres in place of the objects of the last frame, world space.
    pub fn spheres(&self) -> &[ObjectSphere] {
        &self.spheres
    }

    /// Whether anything changed since this was last asked. Then the spheres are put to their places.
    pub(crate) fn take_stale(&mut self) -> bool {
        let stale = std::mem::take(&mut self.stale);
        if stale {
            self.spheres.clear();
            let models = if self.influence { &self.model_spheres[..] } else { &[] };
            for ((number, object), spheres) in (0..).zip(&self.objects).zip(models) {
                self.spheres.extend(spheres.iter().map(|sphere| sphere.placed(object.placement(), number)));
            }
        }
        stale
    }

    /// Those that shut ways for light, with their handles and the spheres of their models.
    #[cfg(feature = "cpu")]
    pub(crate) fn doors(&self) -> impl Iterator<Item = (ObjectId, &Object, &[ObjectSphere])> {
        let all = self.ids.iter().zip(&self.objects).zip(&self.model_spheres);
        all.filter(|((_, object), _)| object.is_door())
            .map(|((id, object), spheres)| (*id, object, &**spheres))
    }

    fn spheres_of(&self, object: &Object) -> Arc<[ObjectSphere]> {
        let is_same = |other: &Object| {
            Arc::ptr_eq(object.model(), other.model()) && object.is_door() == other.is_door()
        };
        let same = self.objects.iter().position(is_same);
        let known = same.and_then(|index| self.model_spheres.get(index));
        // What a door hides is missing in the light already.
        let hides = if object.is_door() { 0.0 } else { 1.0 };
        let fit = || {
            let spheres = fit_spheres(object.model()).into_iter();
            spheres.map(|sphere| ObjectSphere { hides, ..sphere }).collect()
        };
        known.map_or_else(fit, Arc::clone)
    }

    fn index(&self, id: ObjectId) -> Result<usize, RuntimeError> {
        // Handles grow from one object to the next.
        self.ids.binary_search_by_key(&id.0, |other| other.0).map_err(|_| RuntimeError::UnknownObject)
    }
}

fn reached_bounds(object: &Object, spheres: &[ObjectSphere]) -> Bounds {
    let bounds = object.bounds();
    let reach = spheres.iter().map(|sphere| sphere.reach).fold(0.0, f32::max) * object.placement().scale;
    Bounds { min: bounds.min - reach, max: bounds.max + reach }
}
