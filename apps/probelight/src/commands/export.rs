//! `probelight export FILE -o OUT.glb`

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, ensure};
use clap::Args;
use probelight_asset::{BakedScene, write_atomically};
use probelight_math::glam::Vec3;
use probelight_render::Image;
use probelight_runtime::Runtime;
use probelight_trace::Tracer;
use serde::Serialize;

use crate::console::{self, Console};
use crate::export::direct_light::direct_light;
use crate::export::glb::glb;
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight export room.plight -o room.glb
  probelight export room.plight --setup night.json --all-light -o room.glb

Writes the scene as glTF with the lightmap's texture coordinates as TEXCOORD_1, and beside it
OUT.lightmap.exr: irradiance in W/m², 32-bit floats, of the light of a setup as it stands still.
It holds bounced light, the sky and emissive surfaces; the file's own lights are to shine in the
other program. With --all-light it holds their light, too, and the file has no lights.";

/// Flags of `export`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Where to write the scene
    #[arg(short, long, value_name = "OUT.glb")]
    out: PathBuf,
    /// Lights and sky [default: those of the glTF file that was baked]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    /// Direct light of lamps and suns is in the lightmap, too, with its shadows
    #[arg(long)]
    all_light: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// What `export --json` prints.
#[derive(Serialize)]
struct Report {
    scene: PathBuf,
    lightmap: PathBuf,
    width: u32,
    height: u32,
    lights: usize,
}

/// Writes a scene and its light for other programs.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    let is_glb = flags.out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    ensure!(is_glb, "{} must end in .glb", flags.out.display());
    let lightmap_file = flags.out.with_extension("lightmap.exr");
    let inputs: Vec<_> = std::iter::once(&flags.file).chain(&flags.setup).map(PathBuf::as_path).collect();
    output::check(&flags.out, &inputs)?;
    output::check(&lightmap_file, &inputs)?;

    let baked = Arc::new(BakedScene::read(&flags.file)?);
    let setup = input::load_setup(flags.setup.as_deref(), &baked.scene)?;
    let mut runtime = Runtime::new(Arc::clone(&baked));
    input::light(&mut runtime, &setup, console)?;
    interrupt::check()?;
    let mut texels: Vec<Vec3> = runtime.irradiance().texels.clone();
    let mut lights = &setup.lighting.lights[..];
    if flags.all_light {
        let tracer = Tracer::new(Arc::clone(&baked.scene));
        let direct = direct_light(&baked, &tracer, lights, console)?;
        texels.iter_mut().zip(direct).for_each(|(texel, direct)| *texel += direct);
        lights = &[];
    }
    let (width, height) = (baked.lightmap.width, baked.lightmap.height);
    // Compression may leave a trace of negative light, which other programs do not expect.
    let pixels = texels.into_iter().map(|texel| texel.max(Vec3::ZERO)).collect();
    let file = glb(&baked, lights)?;
    Image { width, height, pixels }.write_exr(&lightmap_file)?;
    write_atomically(&flags.out, |out| out.write_all(&file))
        .with_context(|| format!("cannot write {}", flags.out.display()))?;
    console.clear_progress();
    let report =
        Report { scene: flags.out.clone(), lightmap: lightmap_file, width, height, lights: lights.len() };
    if flags.json {
        return console::print_json(&report);
    }
    console::print(format!(
        "{}: scene with {} lights\n{}: irradiance, {width} × {height} texels",
        report.scene.display(),
        report.lights,
        report.lightmap.display()
    ))
}
