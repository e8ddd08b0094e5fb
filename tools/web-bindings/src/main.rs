//! `web-bindings MODULE.wasm FOLDER`: writes MODULE_bg.wasm and MODULE.js with its types, as pages load them.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(Into::into).collect();
    let [module, folder] = &arguments[..] else {
        anyhow::bail!("usage: web-bindings MODULE.wasm FOLDER");
    };
    ensure!(module.is_file(), "{} is not there: build it first", module.display());
    Bindgen::new()
        .input_path(module)
        .web(true)?
        .typescript(true)
        .omit_default_module_path(false)
        .remove_name_section(true)
        .remove_producers_section(true)
        .generate(folder)
        .with_context(|| format!("no bindings of {}", module.display()))
}
