//! Bevy's asset loader for baked files.

use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, Handle, LoadContext};
use bevy::image::Image;
use bevy::mesh::Mesh;
use bevy::pbr::StandardMaterial;
use bevy::reflect::TypePath;
use probelight_asset::{BakedScene, DecodeError};

use crate::scene::{AssetSink, ProbelightScene};

/// Loads `.plight` files as [`ProbelightScene`]s. Meshes, materials and images are labelled assets: `Surface3`,
/// `Material3`, `Texture3` (`Texture3Linear` for what is no colour), each with the number that it has in the file.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct ProbelightLoader;

/// Why a baked file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The asset source has no bytes.
    #[error("the baked file cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// They are no baked file, or a damaged one.
    #[error(transparent)]
    Decode(#[from] DecodeError),
}

impl AssetLoader for ProbelightLoader {
    type Asset = ProbelightScene;
    type Settings = ();
    type Error = LoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<ProbelightScene, LoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let baked = BakedScene::from_bytes(&bytes)?;
        drop(bytes);
        Ok(ProbelightScene::with_assets(Arc::new(baked), context))
    }

    fn extensions(&self) -> &[&str] {
        &["plight"]
    }
}

impl AssetSink for LoadContext<'_> {
    fn mesh(&mut self, label: String, mesh: Mesh) -> Handle<Mesh> {
        self.add_labeled_asset(label, mesh)
    }

    fn material(&mut self, label: String, material: StandardMaterial) -> Handle<StandardMaterial> {
        self.add_labeled_asset(label, material)
    }

    fn image(&mut self, label: String, image: Image) -> Handle<Image> {
        self.add_labeled_asset(label, image)
    }
}
