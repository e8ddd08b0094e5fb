//! What moves through a scene, by handles.

use std::sync::Arc;

use probelight_scene::{Bounds, Object, Placement, Scene};

use crate::RuntimeError;

/// The handle of an object in one runtime; never given twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ObjectId(u64);

/// The objects of a scene, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    ids: Vec<ObjectId>,
    objects: Vec<Object>,
    bounds: Vec<Bounds>,
    next: u64,
    /// Whether anything changed since the last frame.
    stale: bool,
}

impl Objects {
    /// Adds an object.
    pub fn insert(&mut self, object: Object) -> ObjectId {
        let id = ObjectId(self.next);
        self.next += 1;
        self.ids.push(id);
        self.bounds.push(object.bounds());
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
            self.bounds[index] = self.objects[index].bounds();
            self.stale = true;
        }
        Ok(())
    }

    /// Gives an object another shape, such as the next pose of an animation.
    ///
    /// # Errors
    /// [`RuntimeError::UnknownObject`].
    pub fn reshape(&mut self, id: ObjectId, model: Arc<Scene>) -> Result<(), RuntimeError> {
        let index = self.index(id)?;
        let placement = *self.objects[index].placement();
        self.objects[index] = Object::new(model, placement).map_err(RuntimeError::Object)?;
        self.bounds[index] = self.objects[index].bounds();
        self.stale = true;
        Ok(())
    }

    /// An object, if there is one of this handle.
    pub fn get(&self, id: ObjectId) -> Option<&Object> {
        self.index(id).ok().map(|index| &self.objects[index])
    }

    /// All of them.
    pub fn as_slice(&self) -> &[Object] {
        &self.objects
    }

    /// The smallest world box around each, metres.
    pub fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    /// Whether anything changed since this was last asked.
    pub(crate) fn take_stale(&mut self) -> bool {
        std::mem::take(&mut self.stale)
    }

    fn index(&self, id: ObjectId) -> Result<usize, RuntimeError> {
        // Handles grow from one object to the next.
        self.ids.binary_search_by_key(&id.0, |other| other.0).map_err(|_| RuntimeError::UnknownObject)
    }
}
