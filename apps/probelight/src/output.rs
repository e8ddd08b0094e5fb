//! Output files, checked before long work starts.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use probelight_asset::write_atomically;
use probelight_eval::{EvalError, ImageView};
use probelight_render::{DisplayImage, Exposure, Image, ToneMap};

/// Fails now if writing `output` at the end would: its folder is missing or not writable, it is no ordinary
/// file, or it is one of the inputs.
pub(crate) fn check(output: &Path, inputs: &[&Path]) -> anyhow::Result<()> {
    let shown = output.display();
    ensure!(!output.is_dir(), "{shown} is a folder; name a file to write");
    if output.exists() {
        ensure!(output.is_file(), "{shown} is not an ordinary file, so it cannot be replaced");
    }
    ensure!(output.file_name().is_some(), "{shown} does not name a file");
    for input in inputs {
        ensure!(!is_same_file(output, input), "{shown} is also an input; choose another output file");
    }
    check_folder(folder_of(output))
}

/// Fails if no file can be created in `folder`.
fn check_folder(folder: &Path) -> anyhow::Result<()> {
    let shown = folder.display();
    ensure!(folder.exists(), "the folder {shown} does not exist; create it first");
    ensure!(folder.is_dir(), "{shown} is not a folder");
    tempfile::tempfile_in(folder).with_context(|| format!("cannot write in the folder {shown}"))?;
    Ok(())
}

/// Creates a folder with its parents if it is not there, and checks that files can be created in it.
pub(crate) fn create_folder(folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    check_folder(folder)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    let canonical = |path: &Path| -> Option<PathBuf> { path.canonicalize().ok() };
    canonical(a).is_some() && canonical(a) == canonical(b)
}

/// Replaces a text file as a whole.
pub(crate) fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Kinds of pictures, by the file name's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// Tone mapped, 8 bits.
    Png,
    /// Linear, 32-bit float.
    Exr,
}

impl PictureFormat {
    /// The format that a file name asks for.
    pub(crate) fn of(path: &Path) -> anyhow::Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => bail!("{} must end in .png (for the screen) or .exr (linear values)", path.display()),
        }
    }
}

/// Writes a picture; returns the exposure that was used, as a power of two, if it was tone mapped. Pictures of
/// colours, not of light, have no `exposure`.
pub(crate) fn write_picture(
    image: &Image,
    path: &Path,
    format: PictureFormat,
    exposure: Option<Exposure>,
) -> anyhow::Result<Option<f32>> {
    match (format, exposure) {
        (PictureFormat::Exr, _) => {
            image.write_exr(path)?;
            Ok(None)
        }
        (PictureFormat::Png, None) => {
            DisplayImage::from_colors(image).write_png(path)?;
            Ok(None)
        }
        (PictureFormat::Png, Some(exposure)) => {
            let tone_map = ToneMap::new(exposure, image);
            tone_map.apply(image).write_png(path)?;
            Ok(Some(tone_map.ev()))
        }
    }
}

/// A picture as metrics read it.
pub(crate) fn image_view(image: &Image) -> Result<ImageView<'_>, EvalError> {
    ImageView::new(image.width as usize, image.height as usize, &image.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_that_cannot_work_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.glb");
        std::fs::write(&input, "x").unwrap();
        let fails = |output: &Path, inputs: &[&Path]| check(output, inputs).unwrap_err().to_string();
        assert!(fails(folder.path(), &[]).contains("is a folder"));
        assert!(fails(&folder.path().join("none/a.png"), &[]).contains("does not exist"));
        assert!(fails(&folder.path().join("../..").join(&input), &[&input]).contains("also an input"));
        assert!(fails(&input.join("a.png"), &[]).contains("not a folder"));
        check(&folder.path().join("new.plight"), &[&input]).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "checking leaves nothing behind");
    }

    #[test]
    fn picture_formats_follow_the_extension() {
        assert_eq!(PictureFormat::of(Path::new("a/b.PNG")).unwrap(), PictureFormat::Png);
        assert_eq!(PictureFormat::of(Path::new("b.exr")).unwrap(), PictureFormat::Exr);
        assert!(PictureFormat::of(Path::new("b.jpg")).is_err());
        assert!(PictureFormat::of(Path::new("png")).is_err());
    }
}
