//! Work on the page's only thread, between two pictures.

use std::future::Future;

use js_sys::{Function, Promise};
use wasm_bindgen::JsValue;
use wasm_bindgen_futures::JsFuture;

/// Does some work as soon as the page has time.
pub fn spawn<F: Future<Output = ()> + 'static>(work: impl FnOnce() -> F + 'static) {
    wasm_bindgen_futures::spawn_local(work());
}

/// Lets the page show a picture and hear the mouse between two steps of work.
pub async fn breathe() {
    let wait = |resolve: Function, _reject: Function| {
        if let Some(window) = web_sys::window() {
            // Without a timer the work ends here.
            let _ = window.set_timeout_with_callback_and_timeout_and_arguments_0(&resolve, 0);
        }
    };
    let _: Result<JsValue, JsValue> = JsFuture::from(Promise::new(&mut { wait })).await;
}
