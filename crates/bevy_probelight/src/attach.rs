//! Scenes whose meshes are there already, spawned from a glTF file by Bevy's own loader, say: which mesh is which part of
//! the baked scene.

use bevy::asset::{AssetId, Handle};
use bevy::camera::visibility::Visibility;
use bevy::ecs::prelude::*;
use bevy::image::Image;
use bevy::log::warn;
use bevy::math::Affine3A;
use bevy::mesh::Mesh;
use bevy::mesh::UvChannel;
use bevy::pbr::StandardMaterial;
use bevy::transform::components::Transform;
use probelight_asset::BakedScene;

use crate::fit::{Fit, PlacedMesh};

/// Beside a [`Probelight`](crate::Probelight): nothing is spawned; the meshes at or below the entity get the scene's
/// lightmap.
///
/// They are those of the glTF file that was baked, as Bevy's own loader spawns them:
///
/// ```ignore
/// commands.spawn((
///     WorldAssetRoot(assets.load("atrium.glb#Scene0")),
///     Probelight(assets.load("atrium.plight")),
///     ProbelightAttach,
/// ));
/// ```
///
/// Names, transforms, materials and whatever else is on the entities stay. Each mesh is replaced by a copy, whose second
/// texture coordinates are the lightmap's, and comes back when the scene is removed. Only meshes of the file with triangles
/// where they were when it was baked are lit; for others there is a warning, and they are in
/// [`ProbelightInstance::unmatched`](crate::ProbelightInstance::unmatched). Movers and shadow casters below the entity are
/// left alone. A lit mesh that moves later keeps its light.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform, Visibility)]
pub struct ProbelightAttach;

/// On a mesh with a place in a lightmap: what it had before.
#[derive(Component, Clone, Debug)]
pub(crate) struct Attached {
    pub(crate) scene: Entity,
    pub(crate) lightmap: AssetId<Image>,
    /// Among the source instances of the baked scene.
    pub(crate) primitive: usize,
    /// Among the baked scene's.
    pub(crate) material: usize,
    /// Whether backs are triangles of their own.
    pub(crate) has_backs: bool,
    pub(crate) own_mesh: Handle<Mesh>,
    pub(crate) lit_mesh: Handle<Mesh>,
}

/// On a scene that is attached: what may be parts of it.
#[derive(Component, Clone, Debug)]
pub(crate) struct Primitives {
    /// Of each source instance.
    triangles: Vec<Vec<u32>>,
    /// The mesh of each source instance.
    pub(crate) taken_by: Vec<Option<Entity>>,
    /// How far a point may be from its place, metres.
    within: f32,
}

impl Primitives {
    /// The source instances of a baked scene; warns if it has none.
    pub(crate) fn of(baked: &BakedScene) -> Self {
        let sources = &baked.scene.sources;
        let mut triangles = vec![Vec::new(); sources.instances.len()];
        for (triangle, source) in (0..).zip(&sources.triangles) {
            triangles[source.instance as usize].push(triangle);
        }
        if sources.triangles.is_empty() {
            warn!(
                "a baked scene does not know the objects of its file, so no mesh is lit by it: bake it anew"
            );
        }
        let taken_by = vec![None; triangles.len()];
        Self { triangles, taken_by, within: 1e-4 * baked.scene.bounds().diagonal() }
    }

    /// Those that no mesh has yet, and that may be this one: by its number in the file, if that is known.
    fn free(&self, baked: &BakedScene, number: Option<[u32; 2]>) -> impl Iterator<Item = usize> {
        let is_meant = move |(primitive, taken): &(usize, &Option<Entity>)| {
            let source = &baked.scene.sources.instances[*primitive];
            taken.is_none() && number.is_none_or(|number| number == [source.mesh, source.primitive])
        };
        self.taken_by.iter().enumerate().filter(is_meant).map(|(primitive, _)| primitive)
    }
}

/// Why a mesh is not lit.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub(crate) enum Unlit {
    #[error("it moves with a skeleton")]
    Skinned,
    #[error("its material reads the second texture coordinates, where the lightmap's have to be")]
    SecondCoordinates,
    #[error(
        "its triangles are not where they were when the file was baked: it was moved, or is another mesh"
    )]
    Elsewhere,
}

/// A mesh of the user's as it is.
pub(crate) struct OwnMesh<'a> {
    pub(crate) mesh: &'a Mesh,
    /// Numbers of mesh and primitive in the file, if it comes from one.
    pub(crate) number: Option<[u32; 2]>,
    pub(crate) material: Option<&'a StandardMaterial>,
    pub(crate) scene_from_mesh: Affine3A,
    pub(crate) is_skinned: bool,
}

/// What a mesh becomes.
pub(crate) struct LitMesh {
    pub(crate) primitive: usize,
    pub(crate) material: usize,
    pub(crate) mesh: Mesh,
    pub(crate) has_backs: bool,
}

impl OwnMesh<'_> {
    /// Finds the mesh among those of a scene that are free.
    pub(crate) fn lit(&self, baked: &BakedScene, primitives: &Primitives) -> Result<LitMesh, Unlit> {
        if self.is_skinned {
            return Err(Unlit::Skinned);
        }
        if self.material.is_some_and(uses_second_coordinates) {
            return Err(Unlit::SecondCoordinates);
        }
        let placed = PlacedMesh::new(self.mesh, &self.scene_from_mesh).ok_or(Unlit::Elsewhere)?;
        // Far from the world's origin, transforms are less exact.
        let within = primitives.within + 4.0 * f32::EPSILON * self.scene_from_mesh.translation.length();
        let fit_of = |primitive: usize| {
            let fit = Fit::new(&placed, baked, &primitives.triangles[primitive], within)?;
            Some((primitive, fit))
        };
        let mut free = primitives.free(baked, self.number);
        let (primitive, fit) = free.find_map(fit_of).ok_or(Unlit::Elsewhere)?;
        let first = primitives.triangles[primitive].first().ok_or(Unlit::Elsewhere)?;
        let material = baked.scene.triangle_material[*first as usize] as usize;
        let has_backs = self.material.is_some_and(shows_backs) && fit.has_backs(baked);
        Ok(LitMesh { primitive, material, mesh: fit.lit_mesh(&placed, baked, has_backs), has_backs })
    }
}

/// Numbers of mesh and primitive in a glTF file, by the label that Bevy's loader gives.
pub(crate) fn number_in_file(mesh: &Handle<Mesh>) -> Option<[u32; 2]> {
    let (mesh, primitive) = mesh.path()?.label()?.strip_prefix("Mesh")?.split_once("/Primitive")?;
    Some([mesh.parse().ok()?, primitive.parse().ok()?])
}

/// Whether backs are drawn with the material.
pub(crate) fn shows_backs(material: &StandardMaterial) -> bool {
    material.cull_mode.is_none()
}

/// Whether a texture of the material is read where the lightmap is.
fn uses_second_coordinates(material: &StandardMaterial) -> bool {
    let slots = [
        (&material.base_color_channel, &material.base_color_texture),
        (&material.emissive_channel, &material.emissive_texture),
        (&material.metallic_roughness_channel, &material.metallic_roughness_texture),
        (&material.normal_map_channel, &material.normal_map_texture),
        (&material.occlusion_channel, &material.occlusion_texture),
    ];
    slots.iter().any(|(channel, texture)| matches!(channel, UvChannel::Uv1) && texture.is_some())
}
