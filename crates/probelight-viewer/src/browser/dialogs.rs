//! Asks for files by the browser's own dialog.

use std::sync::mpsc::{Receiver, Sender, channel};

use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;

use super::file::{File, bytes_of};
use crate::scene::loader::Purpose;
use crate::viewer::{DialogPurpose, Viewer};

/// Files that were chosen.
pub struct Dialogs {
    sender: Sender<(Purpose, File)>,
    chosen: Receiver<(Purpose, File)>,
}

impl Dialogs {
    /// Nothing is asked.
    pub fn new() -> Self {
        let (sender, chosen) = channel();
        Self { sender, chosen }
    }
}

impl Default for Dialogs {
    fn default() -> Self {
        Self::new()
    }
}

impl Viewer {
    /// Asks for a file, or offers what is to be saved under its own name.
    pub(crate) fn choose(&mut self, purpose: DialogPurpose) {
        let asked = match purpose {
            DialogPurpose::Open => self.ask(Purpose::Open, ".plight,.glb,.json"),
            DialogPurpose::Object => self.ask(Purpose::Object, ".glb"),
            DialogPurpose::SaveSetup => return self.save_setup(self.name_with("json").as_ref()),
            DialogPurpose::SaveBake => Err("pages do not save baked files".into()),
        };
        if let Err(error) = asked {
            self.messages.error(super::file::said(&error));
        }
    }

    fn ask(&self, purpose: Purpose, accepted: &str) -> Result<(), JsValue> {
        let document = web_sys::window().and_then(|window| window.document()).ok_or("there is no page")?;
        let input: web_sys::HtmlInputElement = document.create_element("input")?.unchecked_into();
        input.set_type("file");
        input.set_accept(accepted);
        let (sender, context, source) = (self.dialogs.sender.clone(), self.context.clone(), input.clone());
        let read = Closure::once_into_js(move || {
            super::spawn(move || async move {
                let Some(file) = source.files().and_then(|files| files.get(0)) else { return };
                // What cannot be read is not there: the browser has said so.
                let Ok(buffer) = JsFuture::from(file.array_buffer()).await else { return };
                let _ = sender.send((purpose, File::in_memory(&file.name(), bytes_of(&buffer))));
                context.request_repaint();
            });
        });
        input.set_onchange(Some(read.unchecked_ref()));
        input.click();
        Ok(())
    }

    /// Takes what was chosen.
    pub(crate) fn show_dialogs(&mut self) {
        while let Ok((purpose, file)) = self.dialogs.chosen.try_recv() {
            self.loader.read(file, purpose, &self.gpu);
        }
    }

    /// Browsers have ways of their own to keep a picture of a page.
    pub(crate) fn screenshot(&mut self) {
        self.messages.error("pages save no pictures: use what your browser or system has for that");
    }
}
