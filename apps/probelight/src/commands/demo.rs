//! `probelight demo`, and `probelight` alone

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use probelight_eval::{EvalError, ImageView, ssim};
use probelight_render::comparison::difference;
use probelight_render::contact_sheet::ContactSheetRow;
use probelight_render::gpu::GpuView;
use probelight_render::{ContactSheet, Exposure, Image, PixelFilter, ToneMap};
use probelight_scene::{Camera, Setup};
use probelight_trace::{PathTracer, Tracer};
use serde::Serialize;

use crate::backend::BackendFlags;
use crate::bundled::{BundledScene, LightPosition};
use crate::console::{self, Console};
use crate::studio::{PictureOptions, ShadingFlag, Studio};
use crate::{interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight                                 the atrium, into ./out
  probelight demo --scene cornell -o /tmp/cornell

The contact sheet shows each light position without global illumination, with it, path-traced, and the
difference of the last two. It takes some minutes on two cores; most of it is the path tracer.";

/// Flags of `demo`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Flags {
    /// The scene
    #[arg(long, value_enum, default_value_t)]
    scene: BundledScene,
    /// Folder for the results; created if missing
    #[arg(short, long, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    out: PathBuf,
    #[command(flatten)]
    backend: BackendFlags,
    /// Print times and file names as one JSON object
    #[arg(long)]
    json: bool,
}

const DEFAULT_FOLDER: &str = "out";

impl Default for Flags {
    fn default() -> Self {
        Self {
            scene: BundledScene::default(),
            out: DEFAULT_FOLDER.into(),
            backend: BackendFlags::default(),
            json: false,
        }
    }
}

/// Gain of the difference pictures.
const DIFFERENCE_GAIN: f32 = 4.0;

/// What the demo measured and where its files are.
#[derive(Default, Serialize)]
struct Report {
    contact_sheet: PathBuf,
    baked_file: PathBuf,
    /// What computed light and pictures.
    backend: String,
    seconds: Seconds,
    /// One frame under light that stays as it is: the mean over the light positions.
    frame_milliseconds: FrameMilliseconds,
    light_positions: Vec<Similarity>,
}

/// Time by stage, over all light positions.
#[derive(Default, Serialize)]
struct Seconds {
    bake: f64,
    light: f64,
    render: f64,
    reference: f64,
    total: f64,
}

/// Time of a frame and of its stages, in order.
#[derive(Default, Serialize)]
struct FrameMilliseconds {
    stages: Vec<StageMilliseconds>,
    total: f64,
}

#[derive(Clone, Copy, Default, Serialize)]
struct StageMilliseconds {
    name: &'static str,
    milliseconds: f64,
}

impl FrameMilliseconds {
    /// Adds a share of a frame's times.
    fn add(&mut self, stages: &[(&'static str, Duration)], share: f64) {
        self.stages.resize(stages.len(), StageMilliseconds::default());
        for (sum, (name, time)) in self.stages.iter_mut().zip(stages) {
            let milliseconds = time.as_secs_f64() * 1e3 * share;
            sum.name = name;
            sum.milliseconds += milliseconds;
            self.total += milliseconds;
        }
    }
}

#[derive(Serialize)]
struct Similarity {
    name: String,
    bounces: usize,
    /// Structural similarity of the tone-mapped pictures with and without global illumination to the
    /// reference.
    ssim: f64,
    ssim_without: f64,
}

/// Bakes, moves the light, and writes the contact sheet.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    let start = Instant::now();
    output::create_folder(&flags.out)?;
    let file = |extension: &str| flags.out.join(format!("{}.{extension}", flags.scene.name()));
    let mut report = Report { contact_sheet: file("png"), baked_file: file("plight"), ..Report::default() };
    output::check(&report.contact_sheet, &[])?;
    output::check(&report.baked_file, &[])?;
    let backend = flags.backend.open(console)?;
    report.backend = backend.describe();

    console.note(format!("baking the scene \"{}\" ...", flags.scene.name()));
    let scene = flags.scene.load()?;
    let options = flags.scene.bake_options();
    let baked = timed(&mut report.seconds.bake, || {
        probelight_bake::bake(Arc::clone(&scene), &options, None, console)
    })?;
    baked.write(&report.baked_file)?;

    let tracer = Arc::new(Tracer::new(scene));
    let rows = light_and_compare(
        flags.scene,
        Studio::new(backend, Arc::new(baked))?,
        &tracer,
        &mut report,
        console,
    )?;
    console.clear_progress();
    let columns =
        ["without GI", "with GI (Probelight)", "path-traced reference", "difference x4 (grey: equal)"];
    let sheet = ContactSheet {
        title: format!("Probelight: {}, baked once, lit {} times", flags.scene.name(), rows.len()),
        columns: columns.map(String::from).into(),
        rows,
    };
    sheet.draw().write_png(&report.contact_sheet)?;
    report.seconds.total = start.elapsed().as_secs_f64();
    if flags.json { console::print_json(&report) } else { console::print(describe(&report)?.trim_end()) }
}

/// One row of the contact sheet for each light position.
fn light_and_compare(
    scene: BundledScene,
    mut studio: Studio,
    tracer: &Arc<Tracer>,
    report: &mut Report,
    console: &Console,
) -> anyhow::Result<Vec<ContactSheetRow>> {
    let camera = scene.camera();
    let mut rows = Vec::new();
    let path = scene.light_path();
    let share = 1.0 / path.len() as f64;
    for position in path {
        interrupt::check()?;
        console.note(format!("{} ...", position.name));
        let setup = Setup { lighting: position.lighting.clone(), ..Setup::default() };
        let bounces = timed(&mut report.seconds.light, || studio.light(&setup, console))?;
        report.frame_milliseconds.add(&studio.frame()?, share);
        let [without, with] = timed(&mut report.seconds.render, || pictures(&mut studio, &camera, console))?;
        let path_tracer = PathTracer::new(Arc::clone(tracer), position.lighting.clone());
        let samples = scene.reference_samples();
        let pixels =
            timed(&mut report.seconds.reference, || path_tracer.render(&camera, samples, 0, console))?;
        let reference = Image { width: camera.width, height: camera.height, pixels };
        let (row, similarity) = compare(&position, bounces, &without, &with, &reference)?;
        rows.push(row);
        report.light_positions.push(similarity);
    }
    Ok(rows)
}

/// The scene without and with global illumination.
fn pictures(studio: &mut Studio, camera: &Camera, console: &Console) -> anyhow::Result<[Image; 2]> {
    let mut picture = |view| {
        let options =
            PictureOptions { view, shading: ShadingFlag::Diffuse, samples: 16, filter: PixelFilter::Box };
        studio.picture(camera, &options, console)
    };
    Ok([picture(GpuView::Direct)?, picture(GpuView::Full)?])
}

/// A row of pictures, all with the exposure that suits the reference.
fn compare(
    position: &LightPosition,
    bounces: usize,
    without: &Image,
    with: &Image,
    reference: &Image,
) -> Result<(ContactSheetRow, Similarity), EvalError> {
    let tone_map = ToneMap::new(Exposure::Automatic, reference);
    let similarity = Similarity {
        name: position.name.clone(),
        bounces,
        ssim: shown_similarity(with, reference, tone_map)?,
        ssim_without: shown_similarity(without, reference, tone_map)?,
    };
    let caption = format!(
        "{}; SSIM to the reference: {:.3} with GI, {:.3} without",
        position.name, similarity.ssim, similarity.ssim_without
    );
    let mut pictures: Vec<_> = [without, with, reference].map(|image| tone_map.apply(image)).into();
    pictures.push(difference(with, reference, tone_map, DIFFERENCE_GAIN));
    Ok((ContactSheetRow { caption, pictures }, similarity))
}

/// Structural similarity of two pictures as the screen shows them.
fn shown_similarity(image: &Image, reference: &Image, tone_map: ToneMap) -> Result<f64, EvalError> {
    let [image, reference] = [image, reference].map(|image| tone_map.display_from_image(image));
    ssim(&view(&image)?, &view(&reference)?)
}

fn view(image: &Image) -> Result<ImageView<'_>, EvalError> {
    ImageView::new(image.width as usize, image.height as usize, &image.pixels)
}

/// Runs a stage and adds the seconds it took.
fn timed<T>(seconds: &mut f64, stage: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = stage();
    *seconds += start.elapsed().as_secs_f64();
    result
}

fn describe(report: &Report) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let seconds = &report.seconds;
    writeln!(text, "light and pictures on the {}", report.backend)?;
    let bounces: usize = report.light_positions.iter().map(|position| position.bounces).sum();
    let positions = report.light_positions.len();
    writeln!(text, "bake                 {:>7.1} s, once", seconds.bake)?;
    writeln!(
        text,
        "indirect light       {:>7.1} s, {bounces} bounces for {positions} light positions",
        seconds.light
    )?;
    let frame = &report.frame_milliseconds;
    writeln!(text, "one bounce of these  {:>7.2} ms, of which", frame.total)?;
    for StageMilliseconds { name, milliseconds } in &frame.stages {
        writeln!(text, "  {name:<19}{milliseconds:>7.2} ms")?;
    }
    writeln!(text, "pictures             {:>7.1} s", seconds.render)?;
    writeln!(text, "path-traced pictures {:>7.1} s", seconds.reference)?;
    writeln!(text, "everything           {:>7.1} s", seconds.total)?;
    let shown = |path: &Path| path.display().to_string();
    writeln!(text, "contact sheet: {}", shown(&report.contact_sheet))?;
    writeln!(text, "baked scene:   {} (try `probelight info` on it)", shown(&report.baked_file))?;
    Ok(text)
}
