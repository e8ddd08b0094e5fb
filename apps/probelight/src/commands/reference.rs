//! `probelight reference SCENE (--camera NAME | --points P.csv) -o OUT`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, ensure};
use clap::Args;
use probelight_math::glam::Vec3;
use probelight_render::{Exposure, Image};
use probelight_scene::Camera;
use probelight_trace::{PathTracer, PointIrradiance, Tracer};
use serde::Serialize;

use crate::commands::render::finite;
use crate::console::{self, Console};
use crate::movers::{Movers, ObjectFlags};
use crate::output::PictureFormat;
use crate::points::PointsTable;
use crate::sample_points::sample_points;
use crate::{input, output};

const EXAMPLES: &str = "\
Examples:
  probelight reference room.glb --setup night.json --camera door -o truth.png
  probelight reference room.glb --setup night.json --camera door --samples 1024 -o truth.exr
  probelight reference room.glb --setup night.json --points points.csv -o irradiance.csv
  probelight reference room.glb --setup night.json --sample 2000 -o irradiance.csv

--sample chooses the points: that many evenly over the area, and as many evenly over the
triangles, because detail is seen although it has little area. Places that no light reaches are
left out. `probelight eval` then also reports the errors on small triangles.

Points are read from the columns position_x, position_y, position_z, normal_x, normal_y, normal_z.
The output repeats the table and sets the columns E_delta, E_area, E_sky, E_direct, E_indirect
(W/m², _r _g _b) and the standard errors se_area, se_sky, se_indirect. Noise halves with four
times the samples.";

/// Flags of `reference`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A scene (.glb or .gltf)
    scene: PathBuf,
    /// Lights, sky and cameras [default: those of the glTF file]
    #[arg(long, value_name = "S.json")]
    setup: Option<PathBuf>,
    #[command(flatten)]
    subject: SubjectFlags,
    /// The picture (.png, .exr) or table (.csv) to write
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Paths per pixel or point [default: 256 per pixel, 4096 per point]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    samples: Option<u32>,
    /// Exposure as a power of two, for .png [default: from the picture's brightness]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = finite)]
    exposure: Option<f32>,
    /// Size of the picture, instead of the camera's
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = input::parse_size)]
    size: Option<(u32, u32)>,
    #[command(flatten)]
    objects: ObjectFlags,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Print what was done as one JSON object
    #[arg(long)]
    json: bool,
}

/// What is to be traced.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct SubjectFlags {
    /// Make the picture that this camera sees
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Compute the irradiance at these points
    #[arg(long, value_name = "P.csv")]
    points: Option<PathBuf>,
    /// Compute the irradiance at this many points chosen by area and as many chosen by triangle
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    sample: Option<u32>,
}

/// What is traced, checked.
enum Subject {
    Picture { camera: Camera, format: PictureFormat, exposure: Exposure },
    Points { table: PointsTable, points: Vec<(Vec3, Vec3)>, only_lit: bool },
}

const DEFAULT_SAMPLES_PER_PIXEL: u32 = 256;
const DEFAULT_SAMPLES_PER_POINT: u32 = 4096;

/// What `reference --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    output: &'a Path,
    samples: u32,
    /// Pixels or points.
    count: usize,
    seconds: f64,
}

/// Traces a picture or points.
pub(crate) fn run(flags: Flags, console: &Console) -> anyhow::Result<()> {
    check_outputs(&flags)?;
    let scene = input::load_scene(&flags.scene, console)?;
    let setup = input::load_setup(flags.setup.as_deref(), &scene)?;
    let subject = match (&flags.subject.points, flags.subject.sample) {
        (Some(path), _) => points_subject(PointsTable::read(path)?, false)
            .with_context(|| format!("{} is not a usable table of points", path.display()))?,
        (None, Some(count)) => points_subject(sample_points(&scene, count, flags.seed), true)?,
        (None, None) => Subject::Picture {
            camera: input::choose_camera(&setup, flags.subject.camera.as_deref(), flags.size)?,
            format: PictureFormat::of(&flags.out)?,
            exposure: flags.exposure.map_or(Exposure::Automatic, Exposure::Ev),
        },
    };
    input::warn_of_unknown_materials(&setup, &scene, console);
    let movers = Movers::load(&setup, flags.setup.as_deref(), &flags.objects.paths(), console)?;
    let scene = movers.traced_scene(&setup, scene)?;
    let path_tracer = PathTracer::new(Arc::new(Tracer::new(scene)), setup.lighting);
    let start = Instant::now();
    let (count, samples) = subject.trace(&path_tracer, &flags, console)?;
    let seconds = start.elapsed().as_secs_f64();
    if flags.json {
        return console::print_json(&Report { output: &flags.out, samples, count, seconds });
    }
    console.note(format!("wrote {} ({samples} samples each, {seconds:.1} s)", flags.out.display()));
    Ok(())
}

fn check_outputs(flags: &Flags) -> anyhow::Result<()> {
    let inputs = [Some(&flags.scene), flags.setup.as_ref(), flags.subject.points.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    if flags.subject.camera.is_none() {
        let is_table = flags.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
        ensure!(is_table, "{} must end in .csv, because points give a table", flags.out.display());
    } else {
        PictureFormat::of(&flags.out)?;
    }
    output::check(&flags.out, &inputs)
}

fn points_subject(table: PointsTable, only_lit: bool) -> anyhow::Result<Subject> {
    let positions = table.vectors(["position_x", "position_y", "position_z"])?;
    let normals = table.vectors(["normal_x", "normal_y", "normal_z"])?;
    let unit = normals.into_iter().enumerate().map(|(row, normal)| {
        normal.try_normalize().with_context(|| format!("row {}: the normal is zero", row + 1))
    });
    let unit: Vec<Vec3> = unit.collect::<anyhow::Result<_>>()?;
    Ok(Subject::Points { table, points: positions.into_iter().zip(unit).collect(), only_lit })
}

impl Subject {
    /// Traces and writes; returns the number of pixels or points, and the samples of each.
    fn trace(self, tracer: &PathTracer, flags: &Flags, console: &Console) -> anyhow::Result<(usize, u32)> {
        match self {
            Self::Picture { camera, format, exposure } => {
                let samples = flags.samples.unwrap_or(DEFAULT_SAMPLES_PER_PIXEL);
                let pixels = tracer.render(&camera, samples, flags.seed, console)?;
                console.clear_progress();
                let image = Image { width: camera.width, height: camera.height, pixels };
                output::write_picture(&image, &flags.out, format, Some(exposure))?;
                Ok((image.pixels.len(), samples))
            }
            Self::Points { mut table, points, only_lit } => {
                let samples = flags.samples.unwrap_or(DEFAULT_SAMPLES_PER_POINT);
                let irradiance = tracer.irradiance_of_points(&points, samples, flags.seed, console)?;
                console.clear_progress();
                set_irradiance(&mut table, &irradiance);
                let is_lit = |e: &PointIrradiance| e.delta + e.area + e.sky + e.indirect != Vec3::ZERO;
                table.retain_rows(|row| !only_lit || is_lit(&irradiance[row]));
                output::write_text(&flags.out, &table.to_csv())?;
                Ok((points.len(), samples))
            }
        }
    }
}

fn set_irradiance(table: &mut PointsTable, irradiance: &[PointIrradiance]) {
    let mut set = |name, value: fn(&PointIrradiance) -> Vec3| {
        table.set_colors(name, irradiance.iter().map(value));
    };
    set("E_delta", |e| e.delta);
    set("E_area", |e| e.area);
    set("E_sky", |e| e.sky);
    set("E_direct", |e| e.delta + e.area + e.sky);
    set("E_indirect", |e| e.indirect);
    set("se_area", |e| e.se_area);
    set("se_sky", |e| e.se_sky);
    set("se_indirect", |e| e.se_indirect);
}
