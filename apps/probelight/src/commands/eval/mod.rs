//! `probelight eval FILE --setup S.json --points REF.csv`

mod floor;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use probelight_asset::BakedScene;
use probelight_eval::{
    BorderJumps, EvalError, FloorErrors, PointErrors, PointKind, PointSelection, ReferencePoint,
    ReferencePoints, SMALL_TRIANGLE, write_predictions,
};
use probelight_math::glam::Vec3;
use probelight_runtime::gpu::{GpuOptions, GpuRuntime};
use probelight_runtime::{
    EmissiveDisc, FrameInput, GridPlaces, IrradianceGrid, IrradianceLightmap, ObjectInfluence, ObjectSphere,
    Runtime,
};
use probelight_scene::Setup;
use probelight_trace::Tracer;
use rayon::prelude::*;
use serde::Serialize;

use self::floor::{mean_of_halves, trace_ideal_lightmap};
use crate::backend::{Backend, BackendFlags};
use crate::console::{self, Console};
use crate::movers::{Movers, ObjectFlags};
use crate::{input, interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight eval room.plight --setup night.json --points night.csv
  probelight eval room.plight --setup night.json --points night.csv --predictions ours.csv --json

Irradiance of the lightmap is compared with the reference's E_indirect + E_area + E_sky, because
light of the sky and of emissive surfaces reaches the lightmap, too; direct light of point, spot
and directional lights is not part of it. `probelight reference --points` makes such tables. A
table made by `probelight reference --sample` also gives the errors on small triangles.

--floor tells the light transport's errors from those of the lightmap's texels: it traces the mean
light of every texel around the points, and says how far such an ideal lightmap is from the
reference, and our light from it. Noise is subtracted; more paths make the figures surer.";

/// Flags of `eval`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// A baked file (.plight)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The lights of the reference
    #[arg(long, value_name = "S.json")]
    setup: PathBuf,
    /// Reference irradiance at points
    #[arg(long, value_name = "REF.csv")]
    points: PathBuf,
    /// Write the predicted irradiance of every row: columns E_r,E_g,E_b, with --floor also ideal_r,…; NaN
    /// where there is none
    #[arg(long, value_name = "OUT.csv")]
    predictions: Option<PathBuf>,
    /// Also trace an ideal lightmap of the same texels, with N paths for each [default: 1024]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "1024",
        value_parser = clap::value_parser!(u32).range(2..=16_777_216))]
    floor: Option<u32>,
    #[command(flatten)]
    objects: ObjectFlags,
    #[command(flatten)]
    backend: BackendFlags,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// What `eval --json` prints.
#[derive(Serialize)]
struct Report<'a> {
    file: &'a Path,
    setup: &'a str,
    backend: String,
    points: &'a Path,
    /// Rows on surfaces.
    surface_points: usize,
    /// Rows in free space.
    free_space_points: usize,
    bounces: usize,
    /// Errors on surfaces; none for tables of free space alone.
    #[serde(flatten)]
    errors: Option<PointErrors>,
    /// Errors on small triangles, if the table has points chosen by triangle.
    small_triangles: Option<PointErrors>,
    /// Errors in free space, if the table has points there and the file light.
    free_space: Option<PointErrors>,
    /// What of the errors on surfaces are the lightmap's, if that was asked for.
    floor: Option<FloorErrors>,
    /// Seams between clusters; the reference has no part in them.
    border_jumps: BorderJumps,
}

/// Compares a baked file with reference points.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    if let Some(predictions) = &flags.predictions {
        output::check(predictions, &[&flags.file, &flags.setup, &flags.points])?;
    }
    let setup = Setup::load(&flags.setup)?;
    let reference = ReferencePoints::read(&flags.points)?;
    let baked = Arc::new(BakedScene::read(&flags.file)?);
    let backend = flags.backend.open(console)?;
    let movers = Movers::load(&setup, Some(&flags.setup), &flags.objects.paths(), console)?;
    let light = lit_scene(&backend, &baked, &setup, &movers, console)?;
    interrupt::check()?;

    let predictions = predict(&light, &baked, &reference);
    let trace = |paths| trace_ideal_lightmap(&baked, &setup, &movers, &reference, paths, console);
    let ideal = flags.floor.map(trace).transpose()?;
    if let Some(path) = &flags.predictions {
        let ideal = ideal.as_ref().map(mean_of_halves);
        let sets = [Some(("E", &predictions)), ideal.as_ref().map(|ideal| ("ideal", ideal))];
        let sets: Vec<_> = sets.into_iter().flatten().map(|(name, rows)| (name, &rows[..])).collect();
        write_predictions(path, &sets)?;
    }
    let small_triangles = measure_some(&reference, &predictions, &PointSelection::small_triangles())?;
    let free_space = measure_some(&reference, &predictions, &PointSelection::free_space())?;
    let on_surfaces = PointSelection::default();
    let errors = match &free_space {
        Some(_) => measure_some(&reference, &predictions, &on_surfaces)?,
        // Without any there is something wrong, which this says.
        None => Some(PointErrors::measure(&reference, &predictions, &on_surfaces)?),
    };
    let floor = ideal.map(|ideal| FloorErrors::measure(&reference, &predictions, &ideal, &on_surfaces));
    let surface_points = reference.points.iter().filter(|point| point.kind == PointKind::Surface).count();
    let report = Report {
        file: &flags.file,
        setup: &setup.name,
        backend: backend.describe(),
        points: &flags.points,
        surface_points,
        free_space_points: reference.points.len() - surface_points,
        bounces: light.bounces,
        errors,
        small_triangles,
        free_space,
        floor: floor.transpose()?,
        border_jumps: BorderJumps::measure(&baked, &light.lightmap.texels),
    };
    if flags.json { console::print_json(&report) } else { console::print(describe(&report)?.trim_end()) }
}

/// The errors of some points, if any of them has a prediction.
fn measure_some(
    reference: &ReferencePoints,
    predictions: &[Option<Vec3>],
    selection: &PointSelection,
) -> Result<Option<PointErrors>, EvalError> {
    let mut rows = reference.points.iter().zip(predictions);
    let has_any = rows.any(|(point, prediction)| prediction.is_some() && selection.contains(point));
    has_any.then(|| PointErrors::measure(reference, predictions, selection)).transpose()
}

/// The light of a scene after all bounces.
struct LitScene {
    lightmap: IrradianceLightmap,
    /// Irradiance of all receivers.
    receivers: Vec<Vec3>,
    bounces: usize,
    /// What stands for the objects where they darken and colour soft light.
    spheres: Vec<ObjectSphere>,
    /// What stands for emissive surfaces there.
    discs: Vec<EmissiveDisc>,
}

fn lit_scene(
    backend: &Backend,
    baked: &Arc<BakedScene>,
    setup: &Setup,
    movers: &Movers,
    console: &Console,
) -> anyhow::Result<LitScene> {
    let with_grid = baked.has_grid().then(|| FrameInput { whole_grid: true, ..FrameInput::default() });
    match backend {
        Backend::Cpu => {
            let mut runtime = Runtime::new(baked.clone());
            movers.enter(runtime.objects_mut())?;
            let bounces = input::light(&mut runtime, setup, console)?;
            if let Some(input) = &with_grid {
                runtime.step(input);
            }
            let receivers = runtime.receiver_irradiance().to_vec();
            let spheres = runtime.objects().spheres().to_vec();
            let discs = runtime.emissive_discs().to_vec();
            Ok(LitScene { lightmap: runtime.irradiance().clone(), receivers, bounces, spheres, discs })
        }
        Backend::Gpu(gpu) => {
            let options = GpuOptions::default();
            let mut runtime = GpuRuntime::new(&gpu.device, &gpu.queue, baked.clone(), options)?;
            movers.enter(runtime.objects_mut())?;
            let bounces = input::light_on_gpu(&mut runtime, setup, console)?;
            if let Some(input) = &with_grid {
                runtime.step(input);
            }
            let (lightmap, receivers) = (runtime.read_lightmap()?, runtime.read_irradiance()?);
            let spheres = runtime.objects().spheres().to_vec();
            let discs = runtime.emissive_discs().to_vec();
            Ok(LitScene { lightmap, receivers, bounces, spheres, discs })
        }
    }
}

/// Irradiance of every row on a surface with light of its own, or in free space where there is a grid.
fn predict(lit: &LitScene, baked: &BakedScene, reference: &ReferencePoints) -> Vec<Option<Vec3>> {
    let tracer = Tracer::new(Arc::clone(&baked.scene));
    let places = GridPlaces::new(baked);
    let grid = IrradianceGrid::new(baked, &places, &lit.receivers);
    let irradiance = |point: &ReferencePoint| {
        let (position, normal) = (point.position, point.normal);
        let irradiance = match point.kind {
            PointKind::Surface => lit.lightmap.irradiance_at(&tracer, &baked.lightmap, position, normal),
            PointKind::FreeSpace => grid.irradiance(position, normal),
        };
        let light = || grid.light(position, normal);
        irradiance.map(|irradiance| {
            let LitScene { spheres, discs, .. } = lit;
            let objects = ObjectInfluence::of(spheres, discs, None, position, normal, irradiance, light);
            irradiance * objects.left + objects.reflected
        })
    };
    reference.points.par_iter().map(irradiance).collect()
}

fn describe(report: &Report) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let mut line = |name: &str, value: String| writeln!(text, "{name:<26}{value}");
    let percent = |share: Option<f64>| share.map_or("undefined".into(), |s| format!("{:.2} %", s * 100.0));
    let errors = report.errors.as_ref();
    let compared = errors.or(report.free_space.as_ref()).map_or("nothing", |errors| errors.compared);
    line("compared", format!("{compared} under setup \"{}\", on the {}", report.setup, report.backend))?;
    line(
        "points",
        format!(
            "{} on surfaces ({} without an answer), {} in free space",
            report.surface_points,
            errors.map_or(0, |errors| errors.unanswered),
            report.free_space_points
        ),
    )?;
    if let Some(errors) = errors {
        line("relative RMSE", format!("{} (reference noise subtracted)", percent(errors.relative_rmse)))?;
        line("reference noise", percent(errors.reference_noise))?;
        line("median relative error", percent(errors.median_relative_error))?;
        line("95th percentile", percent(errors.p95_relative_error))?;
        line("mean bias", percent(errors.mean_bias))?;
        line("black though lit", percent(Some(errors.black_share)))?;
        line(
            "mean irradiance",
            format!("{:.4} W/m², reference {:.4}", errors.mean_prediction, errors.mean_reference),
        )?;
        line(
            "largest irradiance",
            format!("{:.4} W/m², reference {:.4}", errors.max_prediction, errors.max_reference),
        )?;
    }
    if let Some(floor) = &report.floor {
        line("ideal lightmap", format!("{} points", floor.compared))?;
        line("relative RMSE, the floor", percent(floor.floor))?;
        line("mean bias", percent(floor.floor_bias))?;
        line("ours, above the floor", percent(floor.above_floor))?;
        line("mean bias", percent(floor.above_floor_bias))?;
    }
    if let Some(small) = &report.small_triangles {
        line(&format!("below {SMALL_TRIANGLE} m²"), format!("{} points", small.answered))?;
        line("relative RMSE", percent(small.relative_rmse))?;
        line("median relative error", percent(small.median_relative_error))?;
        line("black though lit", percent(Some(small.black_share)))?;
    }
    if let Some(free) = &report.free_space {
        line("in free space", format!("{} points ({} without an answer)", free.answered, free.unanswered))?;
        line("relative RMSE", percent(free.relative_rmse))?;
        line("median relative error", percent(free.median_relative_error))?;
        line("95th percentile", percent(free.p95_relative_error))?;
        line("mean bias", percent(free.mean_bias))?;
        line("black though lit", percent(Some(free.black_share)))?;
    }
    let jumps = &report.border_jumps;
    let both = |border, inside| format!("{} (inside clusters {})", percent(border), percent(inside));
    line("jumps at cluster borders", both(jumps.median, jumps.median_inside))?;
    line("99th percentile", both(jumps.p99, jumps.p99_inside))?;
    Ok(text)
}
