//! A baked scene as a Bevy asset.

use std::sync::Arc;

use bevy::asset::{Asset, Assets, Handle};
use bevy::image::Image;
use bevy::mesh::Mesh;
use bevy::pbr::StandardMaterial;
use bevy::reflect::TypePath;
use probelight_asset::BakedScene;

use crate::materials::MaterialMaker;
use crate::meshes::surface_mesh;

/// A baked scene with what Bevy needs to draw it: from a `.plight` file, or [new](Self::new) from a bake.
///
/// Its materials are shared by all that show it. Change their colour or emission in `Assets<StandardMaterial>`, and the light
/// follows.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct ProbelightScene {
    /// What the runtime knows.
    pub baked: Arc<BakedScene>,
    /// What is drawn: one part for each material that has triangles.
    pub parts: Vec<ScenePart>,
    /// Materials in the order of the baked scene's.
    pub materials: Vec<Handle<StandardMaterial>>,
}

/// All triangles of one material.
#[derive(Clone, Debug)]
pub struct ScenePart {
    /// In the scene's space, metres; `UV_0` for the material's textures and `UV_1` for the lightmap.
    pub mesh: Handle<Mesh>,
    /// Index into [`ProbelightScene::materials`].
    pub material: usize,
}

impl ProbelightScene {
    /// Makes meshes, materials and images of a baked scene.
    pub fn new(
        baked: Arc<BakedScene>,
        meshes: &mut Assets<Mesh>,
        materials: &mut Assets<StandardMaterial>,
        images: &mut Assets<Image>,
    ) -> Self {
        Self::with_assets(baked, &mut Collections { meshes, materials, images })
    }

    pub(crate) fn with_assets(baked: Arc<BakedScene>, sink: &mut impl AssetSink) -> Self {
        let scene = &*baked.scene;
        let mut maker = MaterialMaker::new(scene);
        let materials: Vec<_> = (0..scene.materials.len())
            .map(|index| {
                let material = maker.make(index, sink);
                sink.material(format!("Material{index}"), material)
            })
            .collect();
        let parts = (0..scene.materials.len())
            .filter_map(|material| {
                let mesh = surface_mesh(&baked, material)?;
                Some(ScenePart { mesh: sink.mesh(format!("Surface{material}"), mesh), material })
            })
            .collect();
        Self { baked, parts, materials }
    }
}

/// Where the assets of a scene go.
pub(crate) trait AssetSink {
    fn mesh(&mut self, label: String, mesh: Mesh) -> Handle<Mesh>;
    fn material(&mut self, label: String, material: StandardMaterial) -> Handle<StandardMaterial>;
    fn image(&mut self, label: String, image: Image) -> Handle<Image>;
}

struct Collections<'a> {
    meshes: &'a mut Assets<Mesh>,
    materials: &'a mut Assets<StandardMaterial>,
    images: &'a mut Assets<Image>,
}

impl AssetSink for Collections<'_> {
    fn mesh(&mut self, _: String, mesh: Mesh) -> Handle<Mesh> {
        self.meshes.add(mesh)
    }

    fn material(&mut self, _: String, material: StandardMaterial) -> Handle<StandardMaterial> {
        self.materials.add(material)
    }

    fn image(&mut self, _: String, image: Image) -> Handle<Image> {
        self.images.add(image)
    }
}
