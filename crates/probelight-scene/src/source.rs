//! Where a scene's triangles come from, so that engines find their own objects again.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use crate::SceneError;

/// The objects of the input file, and which of them each triangle of a [`Scene`](crate::Scene) belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// One entry per node and primitive of its mesh, in the order in which they were flattened.
    pub instances: Vec<SourceInstance>,
    /// One entry per triangle of the scene; empty for a scene that was not read from a file.
    pub triangles: Vec<SourceTriangle>,
}

/// A primitive as one node of a glTF file shows it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct SourceInstance {
    /// Index of the node in the file.
    pub node: u32,
    /// Name of the node, or empty.
    pub node_name: String,
    /// Which of the node's copies it is (`EXT_mesh_gpu_instancing`); 0 for nodes without.
    pub copy: u32,
    /// Index of the mesh in the file.
    pub mesh: u32,
    /// Name of the mesh, or empty.
    pub mesh_name: String,
    /// Index of the primitive in the mesh.
    pub primitive: u32,
}

/// The triangle of the input file that a triangle is, or is a piece of.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct SourceTriangle {
    /// Index into [`Sources::instances`].
    pub instance: u32,
    /// Which of the primitive's triangles: `n` has the indices `3n..3n + 3` of a list, and starts at index `n` of a
    /// strip. Triangles without area count too, though the scene leaves them out.
    pub triangle: u32,
}

impl Sources {
    /// Checks that the table fits a scene of so many triangles.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if there is neither an entry for each triangle nor none at all, or an entry names an
    /// instance that does not exist.
    pub fn validate(&self, triangles: usize) -> Result<(), SceneError> {
        let fail = |reason: String| Err(SceneError::Invalid { reason });
        if !self.triangles.is_empty() && self.triangles.len() != triangles {
            return fail(format!("{} source triangles for {triangles} triangles", self.triangles.len()));
        }
        match self.triangles.iter().position(|source| source.instance as usize >= self.instances.len()) {
            Some(t) => fail(format!("triangle {t} comes from a source instance that does not exist")),
            None => Ok(()),
        }
    }
}
