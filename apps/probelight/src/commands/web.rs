//! `probelight web DIR FILE`

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use probelight_asset::{BakedScene, write_atomically};
use probelight_scene::Setup;

use crate::console::Console;
use crate::output;

const EXAMPLES: &str = "\
Examples:
  probelight web site room.plight
  probelight web site room.plight --setup night.json --camera door

Any server of static files can hand the folder out; to look at it on this computer:
  python3 -m http.server --directory site        then http://localhost:8000
The page needs a browser with WebGPU. It is built once, by `tools/build-web.sh` in the folder of
Probelight's sources.";

/// Where `tools/build-web.sh` puts the page.
const BUILT_PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../web/dist");

/// The file that a server hands out for the folder, written last: until then an older page stays in use.
const INDEX: &str = "index.html";

/// Flags of `web`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// Folder for the page; created if missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Lights, sky, cameras and objects [default: those of the glTF file that was baked]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    /// Name of the camera to begin at [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Folder of the built page [default: apps/web/dist of Probelight's sources]
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,
}

/// Files of a page, by their names.
type Files = BTreeMap<String, Vec<u8>>;

/// Writes the page with a scene.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    // All that can go wrong with what is read does so before anything is written.
    let mut files = built_page(flags.page.as_deref().unwrap_or(BUILT_PAGE.as_ref()))?;
    let index = files.remove(INDEX).unwrap_or_default();
    let index = String::from_utf8(index).context("the page's index.html is no text")?;
    add_scene(&mut files, flags)?;
    let filled = fill(&index, "scene", "scene.plight")
        .and_then(|index| fill(&index, "setup", if flags.setup.is_some() { "setup.json" } else { "" }))
        .and_then(|index| fill(&index, "camera", flags.camera.as_deref().unwrap_or_default()))
        .context("the page is not one of this version: build it again by tools/build-web.sh")?;

    output::create_folder(&flags.folder)?;
    for (name, bytes) in files.iter().chain([(&INDEX.to_owned(), &filled.into_bytes())]) {
        let path = flags.folder.join(name);
        write_atomically(&path, |out| out.write_all(bytes))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    console.note(format!("wrote {}: a page for any server of static files", flags.folder.display()));
    Ok(())
}

/// The page without a scene.
fn built_page(folder: &Path) -> anyhow::Result<Files> {
    ensure!(
        folder.join(INDEX).is_file(),
        "there is no built page in {}: run tools/build-web.sh in the folder of Probelight's sources, or name a built \
         page by --page",
        folder.display()
    );
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry?;
        Ok((entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path())?))
    };
    let files: std::io::Result<Files> =
        std::fs::read_dir(folder).and_then(|entries| entries.map(read).collect());
    files.with_context(|| format!("cannot read {}", folder.display()))
}

/// The baked file, the setup and its objects; objects get names beside the page.
fn add_scene(files: &mut Files, flags: &Flags) -> anyhow::Result<()> {
    let baked = BakedScene::read(&flags.file)?;
    let mut setup = match &flags.setup {
        Some(path) => Setup::load(path)?,
        None => Setup::from_scene(&baked.scene),
    };
    if flags.camera.is_some() {
        setup.camera(flags.camera.as_deref())?;
    }
    files.insert("scene.plight".into(), read(&flags.file)?);
    let Some(path) = &flags.setup else { return Ok(()) };
    let folder = path.parent().unwrap_or("".as_ref());
    for object in &mut setup.objects {
        let name = object.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = read(&folder.join(&object.file))?;
        if files.get(&name).is_some_and(|other| *other != bytes) {
            bail!("two files of the page would be called {name}: rename the object's");
        }
        object.file = PathBuf::from(&name);
        files.insert(name, bytes);
    }
    files.insert("setup.json".into(), setup.to_json().into_bytes());
    Ok(())
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// The page with one of its empty data attributes filled in.
fn fill(index: &str, name: &str, value: &str) -> Option<String> {
    let empty = format!("data-{name}=\"\"");
    let value = value.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;");
    index.contains(&empty).then(|| index.replacen(&empty, &format!("data-{name}=\"{value}\""), 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_all_that_is_filled_in() {
        let index = include_str!("../../../web/static/index.html");
        let filled = fill(index, "scene", "scene.plight").unwrap();
        assert!(filled.contains(r#"data-scene="scene.plight""#));
        assert_eq!(fill(&filled, "scene", "other.plight"), None);
        let named = fill(&filled, "camera", "<\"door\" & window>").unwrap();
        assert!(named.contains(r#"data-camera="&lt;&quot;door&quot; &amp; window>""#));
        assert!(fill(index, "setup", "setup.json").is_some());
    }
}
