//! `probelight demo`, and `probelight` alone

use std::fmt::Write as _;
#[cfg(feature = "window")]
use std::io::IsTerminal;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use probelight_asset::write_atomically;
use probelight_eval::{EvalError, ssim};
use probelight_render::comparison::difference;
use probelight_render::contact_sheet::ContactSheetRow;
use probelight_render::gpu::GpuView;
use probelight_render::{ContactSheet, Exposure, Image, PixelFilter, ToneMap};
use probelight_scene::{Camera, Keyframe, LightMotion, LightTrack, Object, ObjectPath, Scene, Setup};
use probelight_trace::{PathTracer, Tracer};
use serde::Serialize;

use crate::backend::BackendFlags;
use crate::bundled::{BundledScene, LightPosition};
use crate::console::{self, Console};
use crate::output::image_view;
use crate::studio::{PictureOptions, ShadingFlag, Studio};
use crate::{interrupt, output};

const EXAMPLES: &str = "\
Examples:
  probelight                                 the atrium, into ./out
  probelight demo --scene cornell -o /tmp/cornell

The first picture is there within half a minute on two cores: without global illumination and with
it, side by side. More follow at once, one for each position of the light. Then the path tracer
takes a minute or so, and a contact sheet shows all of it beside the truth. Ctrl-C keeps the
pictures that are finished. In a terminal with a display, a window opens in the end in which one
moves the light oneself.";

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

/// File of the ball.
const BALL: &str = "ball.glb";

/// Gain of the difference pictures.
const DIFFERENCE_GAIN: f32 = 4.0;

/// What the demo measured and where its files are.
#[derive(Default, Serialize)]
struct Report {
    /// One for each light position: without and with global illumination.
    pictures: Vec<PathBuf>,
    contact_sheet: PathBuf,
    baked_file: PathBuf,
    /// The first light position with its camera and ball, for `view` and `render`.
    setup_file: PathBuf,
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
    /// From the start until the first picture was written.
    first_picture: f64,
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

/// Bakes, moves the light, and at last compares with the path tracer.
pub(crate) fn run(flags: &Flags, console: &Console) -> anyhow::Result<()> {
    let start = Instant::now();
    output::create_folder(&flags.out)?;
    let file = |name: String| flags.out.join(name);
    let mut report = Report {
        contact_sheet: file(format!("{}.png", flags.scene.name())),
        baked_file: file(format!("{}.plight", flags.scene.name())),
        setup_file: file(format!("{}.json", flags.scene.name())),
        ..Report::default()
    };
    output::check(&report.contact_sheet, &[])?;
    output::check(&report.baked_file, &[])?;
    output::check(&report.setup_file, &[])?;
    let backend = flags.backend.open(console)?;
    report.backend = backend.describe();

    console.note(format!("baking the scene \"{}\" ...", flags.scene.name()));
    let scene = flags.scene.load()?;
    let options = flags.scene.bake_options();
    let baked = timed(&mut report.seconds.bake, || {
        probelight_bake::bake(Arc::clone(&scene), &options, None, console)
    })?;
    baked.write(&report.baked_file)?;
    write_setup(flags.scene, &flags.out, &report.setup_file)?;

    let mut studio = Studio::new(backend, Arc::new(baked))?;
    let ball = BundledScene::ball()?;
    let lit = light_all(flags, &mut studio, &ball, start, &mut report, console)?;
    console.note("path tracing the same pictures, to compare; this takes a minute or so ...");
    let sheet = compare_all(flags.scene, &scene, &lit, &mut report, console)?;
    console.clear_progress();
    sheet.draw().write_png(&report.contact_sheet)?;
    report.seconds.total = start.elapsed().as_secs_f64();
    if flags.json {
        return console::print_json(&report);
    }
    console::print(describe(&report)?.trim_end())?;
    #[cfg(feature = "window")]
    if std::io::stdout().is_terminal() && probelight_viewer::has_display() {
        console.note("opening a window: drag the lamp or the sun, and see the light follow");
        super::view::show_file(&report.baked_file, &report.setup_file)?;
    }
    Ok(())
}

/// Seconds from one of the light's positions to the next in the setup.
const SECONDS_PER_POSITION: f32 = 4.0;

/// Writes the light as a setup, in its first position and on its way through all of them and back, and the ball beside it.
fn write_setup(scene: BundledScene, folder: &Path, file: &Path) -> anyhow::Result<()> {
    let path = scene.light_path();
    let lights = path.iter().chain(path.iter().rev().skip(1)).flat_map(|position| &position.lighting.lights);
    let times = (0..).map(|position| SECONDS_PER_POSITION * position as f32);
    let motion = LightMotion::Keyframes(times.zip(lights.cloned()).collect());
    let first = path.into_iter().next();
    let keyframes = scene.ball_path().into_iter().take(1).map(|placement| Keyframe { time: 0.0, placement });
    let ball = ObjectPath { file: BALL.into(), keyframes: keyframes.collect(), clip: None, is_door: false };
    let setup = Setup {
        name: scene.name().into(),
        scene: format!("{}.glb", scene.name()),
        lighting: first.map(|position| position.lighting).unwrap_or_default(),
        light_tracks: vec![LightTrack { name: String::new(), motion }],
        cameras: vec![scene.camera()],
        objects: vec![ball],
        ..Setup::default()
    };
    write_atomically(&folder.join(BALL), |out| out.write_all(BundledScene::ball_glb()))?;
    write_atomically(file, |out| out.write_all(setup.to_json().as_bytes()))?;
    Ok(())
}

/// The scene in one position of its light.
struct LitPictures {
    position: LightPosition,
    /// What moves through it.
    ball: Object,
    bounces: usize,
    without: Image,
    with: Image,
}

impl LitPictures {
    /// Both pictures side by side, with the exposure that suits global illumination.
    fn sheet(&self) -> ContactSheet {
        let tone_map = ToneMap::new(Exposure::Automatic, &self.with);
        let pictures = [&self.without, &self.with].map(|image| tone_map.apply(image)).into();
        ContactSheet {
            title: "Probelight".into(),
            columns: ["without GI", "with GI"].map(String::from).into(),
            rows: vec![ContactSheetRow { caption: self.position.name.clone(), pictures }],
        }
    }
}

/// Moves the light, and shows each position as soon as it is lit.
fn light_all(
    flags: &Flags,
    studio: &mut Studio,
    ball: &Arc<Scene>,
    start: Instant,
    report: &mut Report,
    console: &Console,
) -> anyhow::Result<Vec<LitPictures>> {
    let camera = flags.scene.camera();
    let path = flags.scene.light_path();
    let share = 1.0 / path.len() as f64;
    let mut lit = Vec::new();
    let ball_path = flags.scene.ball_path();
    let mut ball = Object::new(Arc::clone(ball), ball_path[0])?;
    let id = studio.objects_mut().insert(ball.clone());
    for ((number, position), place) in (1..).zip(path).zip(ball_path) {
        interrupt::check()?;
        ball.place(place)?;
        studio.objects_mut().place(id, place)?;
        let file = flags.out.join(format!("{}-{number}.png", flags.scene.name()));
        output::check(&file, &[])?;
        let setup = Setup { lighting: position.lighting.clone(), ..Setup::default() };
        let bounces = timed(&mut report.seconds.light, || studio.light(&setup, console))?;
        report.frame_milliseconds.add(&studio.frame()?, share);
        let [without, with] = timed(&mut report.seconds.render, || pictures(studio, &camera, console))?;
        let pictures = LitPictures { position, ball: ball.clone(), bounces, without, with };
        pictures.sheet().draw().write_png(&file)?;
        if lit.is_empty() {
            report.seconds.first_picture = start.elapsed().as_secs_f64();
        }
        console.note(format!("{}: {}, without and with GI", file.display(), pictures.position.name));
        report.pictures.push(file);
        lit.push(pictures);
    }
    Ok(lit)
}

/// All light positions beside what the path tracer finds, a row each.
fn compare_all(
    bundled: BundledScene,
    scene: &Scene,
    lit: &[LitPictures],
    report: &mut Report,
    console: &Console,
) -> anyhow::Result<ContactSheet> {
    let camera = bundled.camera();
    let mut rows = Vec::new();
    for pictures in lit {
        interrupt::check()?;
        let tracer = Tracer::new(Arc::new(scene.with_objects(std::slice::from_ref(&pictures.ball))));
        let path_tracer = PathTracer::new(Arc::new(tracer), pictures.position.lighting.clone());
        let samples = bundled.reference_samples();
        let pixels =
            timed(&mut report.seconds.reference, || path_tracer.render(&camera, samples, 0, console))?;
        let reference = Image { width: camera.width, height: camera.height, pixels };
        let (row, similarity) = compare(pictures, &reference)?;
        rows.push(row);
        report.light_positions.push(similarity);
    }
    let columns =
        ["without GI", "with GI (Probelight)", "path-traced reference", "difference x4 (grey: equal)"];
    Ok(ContactSheet {
        title: format!("Probelight: {}, baked once, lit {} times", bundled.name(), rows.len()),
        columns: columns.map(String::from).into(),
        rows,
    })
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
fn compare(lit: &LitPictures, reference: &Image) -> Result<(ContactSheetRow, Similarity), EvalError> {
    let LitPictures { position, bounces, without, with, .. } = lit;
    let tone_map = ToneMap::new(Exposure::Automatic, reference);
    let similarity = Similarity {
        name: position.name.clone(),
        bounces: *bounces,
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
    ssim(&image_view(&image)?, &image_view(&reference)?)
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
    writeln!(text, "first picture        {:>7.1} s after the start", seconds.first_picture)?;
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
    let [baked, setup] = [&report.baked_file, &report.setup_file].map(|path| shown(path));
    writeln!(text, "look around:   probelight view {baked} --setup {setup}")?;
    Ok(text)
}
