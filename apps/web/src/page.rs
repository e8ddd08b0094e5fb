//! What the page calls.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use eframe::egui::Ui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupExisting};
use eframe::{App, CreationContext, Frame, WebOptions, WebRunner};
use js_sys::Reflect;
use probelight_runtime::gpu::GpuDevice;
use probelight_viewer::browser::File;
use probelight_viewer::state::Action;
use probelight_viewer::{Viewer, ViewerOptions};
use serde_json::{Value, json};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};
use web_sys::HtmlCanvasElement;

/// What "+ ball" adds.
const BALL: &[u8] = include_bytes!("../../../assets/objects/ball.glb");

/// Pages narrower than this, in CSS pixels, begin without panels.
const NARROW: f64 = 900.0;

/// A viewer that is running.
#[wasm_bindgen]
pub struct Page {
    runner: WebRunner,
    told: Rc<RefCell<Value>>,
}

/// Shows the viewer on a canvas. `options` are those of the page's address: `scene`, `setup`, `camera`, `exposure`,
/// `resolution`, each a string or absent.
///
/// # Errors
/// If there is no GPU, or it refuses.
#[wasm_bindgen]
pub async fn start(canvas: HtmlCanvasElement, options: JsValue) -> Result<Page, JsError> {
    let options = viewer_options(&options)?;
    let gpu = GpuDevice::open_async(None).await?;
    let setup = WgpuSetup::Existing(WgpuSetupExisting {
        instance: gpu.instance.clone(),
        adapter: gpu.adapter.clone(),
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    });
    let wgpu_options = WgpuConfiguration { wgpu_setup: setup, ..WgpuConfiguration::default() };
    let told = Rc::new(RefCell::new(Value::Null));
    let shared = Rc::clone(&told);
    let make = move |creation: &CreationContext<'_>| {
        let state = creation.wgpu_render_state.as_ref().ok_or("the page has no GPU")?;
        let mut viewer = Viewer::new(&creation.egui_ctx, creation.storage, state, &gpu, options)?;
        if page_width().is_some_and(|width| width < NARROW) {
            viewer.act(Action::TogglePanels);
        }
        Ok(Box::new(Content { viewer, told: shared }) as Box<dyn App>)
    };
    let runner = WebRunner::new();
    let web_options = WebOptions { wgpu_options, ..WebOptions::default() };
    runner.start(canvas, web_options, Box::new(make)).await.map_err(|error| refused(&error))?;
    Ok(Page { runner, told })
}

#[wasm_bindgen]
impl Page {
    /// What the last frame was, as JSON: for whoever measures or tests.
    pub fn stats(&self) -> String {
        self.told.borrow().to_string()
    }

    /// The setup as the page has it now, or nothing as long as no scene is open.
    pub fn setup(&self) -> Option<String> {
        Some(self.runner.app_mut::<Content>()?.viewer.setup()?.to_json())
    }

    /// Opens a scene or a setup by its bytes; the name says which it is.
    pub fn open(&self, name: &str, bytes: &[u8]) {
        if let Some(mut content) = self.runner.app_mut::<Content>() {
            content.viewer.open(File::in_memory(name, Arc::from(bytes)));
        }
    }

    /// The picture as it is shown, without what lies over it.
    ///
    /// # Errors
    /// If the GPU was lost.
    pub async fn picture(&self) -> Result<Picture, JsError> {
        let read = self.runner.app_mut::<Content>().map(|content| content.viewer.read_picture_async());
        let picture = read.ok_or_else(|| JsError::new("the page has stopped"))?.await?;
        let (width, height) = (picture.width, picture.height);
        Ok(Picture { width, height, pixels: picture.pixels.into_flattened() })
    }
}

/// Pixels for whoever tests.
#[wasm_bindgen(getter_with_clone)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue as screens have them, rows from the top.
    pub pixels: Vec<u8>,
}

/// The viewer, and what is told of it.
struct Content {
    viewer: Viewer,
    told: Rc<RefCell<Value>>,
}

impl App for Content {
    fn ui(&mut self, ui: &mut Ui, frame: &mut Frame) {
        self.viewer.ui(ui, frame);
        *self.told.borrow_mut() = tell(&self.viewer);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.viewer.save(storage);
    }

    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }
}

/// What the last frame was.
fn tell(viewer: &Viewer) -> Value {
    let rect = viewer.picture_rect();
    let place = |at: eframe::egui::Pos2| json!([at.x, at.y]);
    json!({
        "scene": viewer.state.document.scene,
        "is_open": viewer.live.is_some(),
        "is_busy": viewer.is_busy(),
        "pictures": viewer.draws(),
        "messages": viewer.messages.texts().collect::<Vec<_>>(),
        "ev": viewer.state.shown_ev,
        "picture": [rect.min.x, rect.min.y, rect.width(), rect.height()],
        "lights": viewer.places_of_lights().map(place).collect::<Vec<_>>(),
        "objects": viewer.places_of_objects().map(place).collect::<Vec<_>>(),
        "times": viewer.figures(),
    })
}

/// What the page's address asks for.
fn viewer_options(options: &JsValue) -> Result<ViewerOptions, JsError> {
    let text = |name: &str| {
        let value = Reflect::get(options, &name.into()).ok()?.as_string()?;
        (!value.is_empty()).then_some(value)
    };
    let number = |name: &str| {
        let parse =
            |text: String| text.parse().map_err(|_| JsError::new(&format!("{name}={text} is no number")));
        text(name).map(parse).transpose()
    };
    let resolution: Option<f32> = number("resolution")?;
    Ok(ViewerOptions {
        file: text("scene").map(Into::into),
        setup: text("setup").map(Into::into),
        camera: text("camera"),
        exposure: number("exposure")?,
        resolution: resolution.map(|share| share.clamp(0.1, 1.0)),
        objects: Vec::new(),
        ball: Some(("ball.glb".into(), Arc::from(BALL))),
        ..ViewerOptions::default()
    })
}

/// Width of the page, CSS pixels.
fn page_width() -> Option<f64> {
    web_sys::window()?.inner_width().ok()?.as_f64()
}

fn refused(error: &JsValue) -> JsError {
    let text = error.as_string().unwrap_or_else(|| format!("{error:?}"));
    JsError::new(&format!("the page cannot start: {text}"))
}
