//! The page of `web` in a browser, and its pictures beside those that `render` draws.
#![cfg(target_os = "linux")]
#![expect(clippy::print_stdout, reason = "figures for whoever asks for them by --nocapture")]

use std::path::{Path, PathBuf};
use std::process::Command;

use probelight_eval::{ImageView, ssim};
use probelight_math::glam::Vec3;

/// Structural similarity from which pictures are the same.
const SAME: f64 = 0.99;

/// A picture's pixels, 0 to 1 as screens have them, and its width and height.
struct Picture {
    pixels: Vec<Vec3>,
    size: (u32, u32),
}

impl Picture {
    fn read(path: &Path) -> Self {
        let image =
            image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgb8();
        let pixels = image.pixels().map(|pixel| Vec3::from(pixel.0.map(f32::from)) / 255.0).collect();
        Self { pixels, size: image.dimensions() }
    }

    fn view(&self) -> ImageView<'_> {
        ImageView::new(self.size.0 as usize, self.size.1 as usize, &self.pixels).unwrap()
    }

    fn similarity(&self, other: &Self) -> f64 {
        ssim(&self.view(), &other.view()).unwrap()
    }

    /// Mean difference of a channel, of 255.
    fn difference(&self, other: &Self) -> f32 {
        let pairs = self.pixels.iter().zip(&other.pixels);
        let sum: f32 = pairs.map(|(a, b)| (*a - *b).abs().element_sum()).sum();
        sum * 255.0 / (3.0 * self.pixels.len() as f32)
    }
}

/// What `render` draws of a setup.
fn native(folder: &Path, setup: &str, size: (u32, u32)) -> Picture {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let picture = folder.join(format!("{setup}.native.png"));
    let output = Command::new(env!("CARGO_BIN_EXE_probelight"))
        .arg("render")
        .arg(root.join("crates/probelight-render/tests/data/cornell.plight"))
        .arg("--setup")
        .arg(folder.join(format!("{setup}.json")))
        .args(["--backend", "gpu", "--samples", "4", "--exposure", "1", "--camera", "front", "--quiet"])
        .args(["--size", &format!("{}x{}", size.0, size.1)])
        .arg("-o")
        .arg(&picture)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Picture::read(&picture)
}

#[test]
fn a_page_is_written_with_its_scene_setup_and_objects() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = tempfile::tempdir().unwrap();
    let setup = std::fs::read_to_string(root.join("assets/setups/cornell_lamp.json")).unwrap();
    let object = r#""objects": [{"file": "things/ball.glb", "position": [1, 1, 1]}], "cameras""#;
    std::fs::create_dir(folder.path().join("things")).unwrap();
    std::fs::copy(root.join("assets/objects/ball.glb"), folder.path().join("things/ball.glb")).unwrap();
    std::fs::write(folder.path().join("s.json"), setup.replace("\"cameras\"", object)).unwrap();
    let write = |camera: &str| {
        Command::new(env!("CARGO_BIN_EXE_probelight"))
            .args(["web", "site", "--setup", "s.json", "--camera", camera])
            .arg(root.join("crates/probelight-render/tests/data/cornell.plight"))
            .arg("--page")
            .arg(root.join("apps/web/static"))
            .current_dir(&folder)
            .output()
            .unwrap()
    };
    let site = folder.path().join("site");
    let refused = write("back");
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("front"), "it names the cameras there are");
    assert!(!site.exists());

    let written = write("front");
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let index = std::fs::read_to_string(site.join("index.html")).unwrap();
    assert!(
        index.contains(r#"data-scene="scene.plight" data-setup="setup.json" data-camera="front""#),
        "{index}"
    );
    let setup = std::fs::read_to_string(site.join("setup.json")).unwrap();
    assert!(setup.contains(r#""ball.glb""#) && !setup.contains("things"), "{setup}");
    for name in ["ball.glb", "page.js", "page.css", "scene.plight"] {
        assert!(site.join(name).is_file(), "{name}");
    }
}

/// The scripts say what they do, and whether they are skipped.
#[test]
fn the_page_works_and_shows_what_render_draws() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let kept = std::env::var_os("PROBELIGHT_WEB_PICTURES").map(PathBuf::from);
    let folder = tempfile::tempdir().unwrap();
    let folder = kept.as_deref().unwrap_or(folder.path());
    let output = Command::new(root.join("tools/check-web.sh"))
        .arg(folder)
        .env("PROBELIGHT", env!("CARGO_BIN_EXE_probelight"))
        .output()
        .expect("bash is there");
    let said = [&output.stdout[..], &output.stderr].map(String::from_utf8_lossy).concat();
    println!("{said}");
    assert!(output.status.success(), "{said}");
    if said.contains("SKIPPED") {
        return;
    }
    assert!(said.contains("the page works"), "{said}");

    let [first, dragged] = ["first", "dragged"].map(|name| {
        let shown = Picture::read(&folder.join(format!("{name}.png")));
        let drawn = native(folder, name, shown.size);
        let (similarity, difference) = (shown.similarity(&drawn), shown.difference(&drawn));
        println!("{name}: SSIM {similarity:.4}, mean difference {difference:.2} of 255");
        assert!(similarity >= SAME, "{name}: SSIM {similarity} against the native picture");
        (shown, drawn)
    });
    // Another setup is another picture, in the browser and beside the native one.
    let moved = first.0.similarity(&dragged.0);
    let wrong = first.0.similarity(&dragged.1);
    println!("under the other setup: SSIM {moved:.4}, against the native one {wrong:.4}");
    assert!(moved < SAME && wrong < SAME, "the comparison sees no difference: {moved}, {wrong}");
}
