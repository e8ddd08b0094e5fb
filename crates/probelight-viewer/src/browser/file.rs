//! Files that are dropped, chosen or downloaded.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::DroppedFile;
use js_sys::{Array, ArrayBuffer, Uint8Array};
use probelight_asset::BakedScene;
use probelight_scene::{AnimatedModel, Scene, Setup, parse_animated_gltf, parse_gltf};
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;

/// A file to be read: by its bytes, or by its address, as the page sees it. What reads it returns errors that name it.
#[derive(Clone, Debug)]
pub struct File {
    path: PathBuf,
    bytes: Option<Arc<[u8]>>,
}

impl From<PathBuf> for File {
    fn from(address: PathBuf) -> Self {
        Self { path: address, bytes: None }
    }
}

impl File {
    /// One that is in memory.
    pub fn in_memory(name: &str, bytes: Arc<[u8]>) -> Self {
        Self { path: name.into(), bytes: Some(bytes) }
    }

    /// One that was dropped into the page.
    pub fn dropped(file: &DroppedFile) -> Option<Self> {
        Some(Self::in_memory(&file.name, Arc::clone(file.bytes.as_ref()?)))
    }

    /// Its address, or only its name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads a setup.
    pub(crate) async fn setup(&self) -> Result<Setup, String> {
        let bytes = self.bytes().await?;
        let text = std::str::from_utf8(&bytes).map_err(|error| self.broken(&error))?;
        Setup::parse(text, &self.path).map_err(|error| error.to_string())
    }

    /// Reads a baked file.
    pub(crate) async fn bake(&self) -> Result<BakedScene, String> {
        BakedScene::from_bytes(&self.bytes().await?).map_err(|error| self.broken(&error))
    }

    /// Reads a scene that is one file.
    pub(crate) async fn scene(&self) -> Result<Scene, String> {
        parse_gltf(&self.bytes().await?, &self.path).map_err(|error| error.to_string())
    }

    /// Reads a model for objects that is one file.
    pub(crate) async fn model(&self) -> Result<AnimatedModel, String> {
        parse_animated_gltf(&self.bytes().await?, &self.path).map_err(|error| error.to_string())
    }

    fn broken(&self, error: &dyn std::error::Error) -> String {
        format!("{}: {error}", self.path.display())
    }

    async fn bytes(&self) -> Result<Arc<[u8]>, String> {
        match &self.bytes {
            Some(bytes) => Ok(Arc::clone(bytes)),
            None => {
                let address = self.path.to_string_lossy();
                download(&address).await.map_err(|reason| format!("{address} cannot be downloaded: {reason}"))
            }
        }
    }
}

async fn download(address: &str) -> Result<Arc<[u8]>, String> {
    let window = web_sys::window().ok_or("there is no page")?;
    let response = JsFuture::from(window.fetch_with_str(address)).await.map_err(|error| said(&error))?;
    let response: web_sys::Response = response.dyn_into().map_err(|error| said(&error))?;
    if !response.ok() {
        return Err(format!("the server says {}", response.status()));
    }
    let buffer = response.array_buffer().map_err(|error| said(&error))?;
    let buffer = JsFuture::from(buffer).await.map_err(|error| said(&error))?;
    Ok(bytes_of(&buffer))
}

/// The bytes of an `ArrayBuffer`.
pub(super) fn bytes_of(buffer: &JsValue) -> Arc<[u8]> {
    Uint8Array::new(buffer.unchecked_ref::<ArrayBuffer>()).to_vec().into()
}

/// What the browser says about an error.
pub(super) fn said(error: &JsValue) -> String {
    match error.dyn_ref::<js_sys::Error>() {
        Some(error) => error.message().into(),
        None => format!("{error:?}"),
    }
}

/// Gives a file to the browser, which keeps it where downloads are.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    offer(&name, bytes).map_err(|error| format!("{name} cannot be saved: {}", said(&error)))
}

fn offer(name: &str, bytes: &[u8]) -> Result<(), JsValue> {
    let document = web_sys::window().and_then(|window| window.document()).ok_or("there is no page")?;
    let blob = web_sys::Blob::new_with_u8_array_sequence(&Array::of1(&Uint8Array::from(bytes)))?;
    let address = web_sys::Url::create_object_url_with_blob(&blob)?;
    let link: web_sys::HtmlAnchorElement = document.create_element("a")?.unchecked_into();
    link.set_href(&address);
    link.set_download(name);
    link.click();
    web_sys::Url::revoke_object_url(&address)
}
