//! Each stage on the GPU against its twin on the CPU, fed with the same input.
#![cfg(all(feature = "cpu", feature = "gpu", feature = "blocking"))]

#[path = "support/gpu.rs"]
mod gpu;
mod support;

use half::f16;
use probelight_asset::packed::Ranks;
use probelight_asset::{BakedParts, BakedScene};
use probelight_math::glam::{DVec3, Vec3};
use probelight_math::sampling::Rng;
use probelight_runtime::gpu::readback::read_texture;
use probelight_runtime::gpu::{GpuDevice, GpuOptions, GpuRuntime, ShadowMapOptions};
use probelight_runtime::{ClusterExtent, FrameInput, FramePlan, ProbeExtent, Runtime, Stage};
use probelight_scene::{Light, Lighting};
use support::{SMALL, SMALL_PAPER, Size, all_lights, checked, probe_coefficients, random_plan, random_room};

/// A sum of n products of random sign in f32 is off by some √n · 6e-8 and n is about a hundred here; the orders
/// of the sums differ, and GPUs may round 2^x and divisions by 2 in the last place.
const TOLERANCE: f64 = 2e-6;

/// The lightmap's half floats have eleven significant bits; they are rounded, or cut off by some drivers.
const TEXEL_TOLERANCE: f64 = 1.0 / 1024.0;

fn options() -> GpuOptions {
    GpuOptions {
        shadow_maps: ShadowMapOptions { resolution: 256, ..ShadowMapOptions::default() },
        ..GpuOptions::default()
    }
}

/// Largest difference, relative to the largest value (if there is one).
fn difference(gpu: &[Vec3], cpu: &[Vec3]) -> f64 {
    let cpu: Vec<DVec3> = cpu.iter().map(|value| value.as_dvec3()).collect();
    support::difference(gpu.iter().copied(), &cpu)
}

/// What a CPU's frame leaves for the next one.
struct Before {
    probes: Vec<Vec3>,
    coefficients: Vec<Vec3>,
    irradiance: Vec<Vec3>,
}

impl Before {
    fn of(runtime: &Runtime) -> Self {
        Self {
            probes: probe_coefficients(runtime),
            coefficients: runtime.cluster_coefficients().values().iter().map(|b| Vec3::from(*b)).collect(),
            irradiance: runtime.receiver_irradiance().to_vec(),
        }
    }
}

/// The CPU's and the GPU's runtime with the same light, and what the CPU had before its last frame.
struct Twins {
    gpu: &'static GpuDevice,
    on_gpu: GpuRuntime,
    on_cpu: Runtime,
    before: Before,
}

impl Twins {
    fn new(gpu: &'static GpuDevice, parts: BakedParts, options: GpuOptions) -> Self {
        let full = FramePlan::full(&checked(parts.clone()));
        Self::with_plan(gpu, parts, options, &full)
    }

    /// After a full frame and one by `plan`.
    fn with_plan(gpu: &'static GpuDevice, parts: BakedParts, options: GpuOptions, plan: &FramePlan) -> Self {
        let baked = checked(parts);
        let mut on_cpu = Runtime::new(baked.clone());
        on_cpu.set_lighting(all_lights()).unwrap();
        on_cpu.step(&FrameInput::default());
        let before = Before::of(&on_cpu);
        on_cpu.step_with(plan).unwrap();
        let mut on_gpu = GpuRuntime::new(&gpu.device, &gpu.queue, baked, options).unwrap();
        on_gpu.set_lighting(all_lights()).unwrap();
        let mut twins = Self { gpu, on_gpu, on_cpu, before };
        // The lightmap of the full frame.
        twins.on_gpu.write_coefficients(&twins.before.coefficients);
        twins.run(Stage::GatherReceivers);
        twins.run(Stage::DilateLightmap);
        twins.on_gpu.set_plan(plan).unwrap();
        twins
    }

    fn run(&mut self, stage: Stage) {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.on_gpu.encode_stage(stage, &mut encoder, None);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Light of the shadow rays, in the place of that of the shadow maps.
    fn upload_direct(&mut self) {
        self.run(Stage::LightSurfels);
        self.on_gpu.write_direct(self.on_cpu.signals().direct_irradiance());
        let color = self.on_gpu.surface_colors(0).unwrap().base_color;
        self.on_gpu.set_base_color(0, Vec3::ONE).unwrap();
        self.on_gpu.set_base_color(0, color).unwrap();
    }

    /// RGB and alpha of a level of the lightmap.
    fn texels(&self, level: u32) -> Vec<(Vec3, f32)> {
        let lightmap = &self.on_gpu.buffers().lightmap;
        let size = lightmap.size().mip_level_size(level, wgpu::TextureDimension::D2);
        let copy = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: lightmap.format(),
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let source = wgpu::TexelCopyTextureInfo { mip_level: level, ..lightmap.as_image_copy() };
        encoder.copy_texture_to_texture(source, copy.as_image_copy(), size);
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = read_texture(&self.gpu.device, &self.gpu.queue, &copy).unwrap();
        let halves: Vec<f32> =
            bytes.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect();
        halves.chunks_exact(4).map(|t| (Vec3::new(t[0], t[1], t[2]), t[3])).collect()
    }

    /// Differences of the five stages that both sides have, each fed with the CPU's input, and of the lightmap.
    fn differences(&mut self) -> [f64; 6] {
        let scalar_signals = self.on_cpu.baked().scalar_signals();
        let signals = self.on_cpu.signals().values().to_vec();
        let Before { probes, coefficients, irradiance } = Before::of(&self.on_cpu);

        self.upload_direct();
        self.on_gpu.write_irradiance(&self.before.irradiance);
        self.run(Stage::LightSurfels);
        let lit = self.on_gpu.read_signals().unwrap();
        self.on_gpu.write_signals(0, &signals);
        self.on_gpu.write_signals(scalar_signals, &self.before.probes);
        self.run(Stage::RelightProbes);
        let relit = self.on_gpu.read_signals().unwrap();
        self.on_gpu.write_signals(scalar_signals, &probes);
        self.on_gpu.write_coefficients(&self.before.coefficients);
        self.run(Stage::ProjectClusters);
        let projected = self.on_gpu.read_coefficients().unwrap();
        self.on_gpu.write_coefficients(&coefficients);
        self.run(Stage::GatherReceivers);
        let gathered = self.on_gpu.read_irradiance().unwrap();
        self.on_gpu.write_irradiance(&irradiance);
        self.run(Stage::DilateLightmap);
        let texels: Vec<Vec3> = self.texels(0).into_iter().map(|(texel, _)| texel).collect();
        [
            difference(&lit[..scalar_signals], &signals),
            difference(&relit[scalar_signals..], &probes),
            difference(&projected, &coefficients),
            difference(&gathered, &irradiance),
            difference(&self.on_gpu.read_lightmap().unwrap().texels, &self.on_cpu.irradiance().texels),
            difference(&texels, &self.on_cpu.irradiance().texels),
        ]
    }
}

fn are_small(differences: &[f64; 6]) -> [bool; 6] {
    std::array::from_fn(|i| differences[i] < if i == 5 { TEXEL_TOLERANCE } else { TOLERANCE })
}

fn compare(size: Size, options: GpuOptions) {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let differences = Twins::new(gpu, random_room(size), options).differences();
    assert_eq!(are_small(&differences), [true; 6], "{size:?}: {differences:?}");
}

#[test]
fn stages_equal_their_twins() {
    compare(SMALL, options());
}

#[test]
fn stages_equal_their_twins_as_published() {
    compare(SMALL_PAPER, options());
}

/// More of everything than one workgroup handles, and less.
#[test]
fn stages_equal_their_twins_at_other_sizes() {
    let many = Size {
        clusters: 3,
        receivers_per_cluster: 700,
        receiver_ranks: Ranks { f16: 30, snorm8: 40, snorm4: 50 },
        signal_ranks: Ranks { f16: 5, snorm8: 15, snorm4: 100 },
        surfels: 5000,
        surfel_groups: 4000,
        signals_per_cluster: 2500,
        rays: 300,
        sh_degree: 9,
        ..SMALL
    };
    compare(many, options());
    compare(Size { sh_degree: 0, receivers_per_cluster: 1, probes: 8, ..SMALL_PAPER }, options());
    compare(Size { probes: 0, probes_per_cluster: 0, rays: 0, varied: false, ..SMALL }, options());
    compare(Size { surfel_groups: 0, emitters: 0, sky_degree: None, ..SMALL }, options());
    // The gains of so many rays fill no whole words.
    compare(Size { probes: 7, rays: 33, ..SMALL }, options());
}

fn small_plan(baked: &BakedScene, seed: u64) -> FramePlan {
    random_plan(baked, &mut Rng::new(seed, 0))
}

#[test]
fn stages_equal_their_twins_where_they_compute_less() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let many =
        Size { clusters: 3, receivers_per_cluster: 700, signals_per_cluster: 2500, sh_degree: 9, ..SMALL };
    for (seed, size) in
        [(1, SMALL), (2, SMALL_PAPER), (3, Size { probes: 40, rays: 300, ..SMALL }), (4, many)]
    {
        let parts = random_room(size);
        let plan = small_plan(&checked(parts.clone()), seed);
        let differences = Twins::with_plan(gpu, parts, options(), &plan).differences();
        assert_eq!(are_small(&differences), [true; 6], "{size:?}: {differences:?}");
    }
}

#[test]
fn another_plan_of_the_twin_is_noticed() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let parts = random_room(SMALL);
    let baked = checked(parts.clone());
    let extent = ClusterExtent { rank: 5, columns: 60, receivers: 70, ..ClusterExtent::ALL };
    let probe = ProbeExtent { rays: 30, degree: 2 };
    let plan = |extent, probe| FramePlan::new(&baked, |_| extent, |_| probe);
    let noticed = |other: &FramePlan| {
        let mut twins = Twins::with_plan(gpu, parts.clone(), options(), &plan(extent, probe));
        twins.on_gpu.set_plan(other).unwrap();
        are_small(&twins.differences()).map(|is_small| !is_small)
    };
    assert_eq!(noticed(&plan(extent, probe)), [false; 6]);
    let [_, relight, project, gather, ..] = [0, 1, 2, 3, 4, 5];
    assert!(noticed(&plan(extent, ProbeExtent { rays: 60, ..probe }))[relight]);
    assert!(noticed(&plan(extent, ProbeExtent { degree: 4, ..probe }))[relight]);
    assert!(noticed(&plan(ClusterExtent { rank: 6, ..extent }, probe))[project]);
    assert!(noticed(&plan(ClusterExtent { solid: 4, fade: 9, ..extent }, probe))[project]);
    assert!(noticed(&plan(ClusterExtent { columns: 61, ..extent }, probe))[project]);
    assert!(noticed(&plan(ClusterExtent { receivers: 71, ..extent }, probe))[gather]);
}

#[test]
fn divided_arrays_change_nothing() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let divided = GpuOptions { largest_buffer: Some(13_500), ..options() };
    let parts = random_room(Size { surfels: 300, ..SMALL });
    let baked = checked(parts.clone());
    for plan in [FramePlan::full(&baked), small_plan(&baked, 5)] {
        let mut twins = Twins::with_plan(gpu, parts.clone(), divided, &plan);
        let [surfels, clusters] = twins.on_gpu.shard_counts();
        assert!(surfels > 1 && clusters > 1, "{surfels} and {clusters} portions");
        let differences = twins.differences();
        assert_eq!(are_small(&differences), [true; 6], "{differences:?}");
    }
}

#[test]
fn comparison_notices_a_wrong_input_of_each_stage() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    for wrong in 0..5 {
        let mut twins = Twins::new(gpu, random_room(SMALL), options());
        let mut damaged = BakedParts::clone(twins.on_cpu.baked());
        match wrong {
            0 => damaged.surfel_groups[3].first_weight *= 0.99,
            1 => damaged.relight_surfels.swap(0, 1),
            2 => damaged.row_scales[0] *= 1.001,
            3 => damaged.receiver_basis[0] ^= 0x1010_1010,
            _ => damaged.lightmap.dilation.last_mut().unwrap()[1] = damaged.receiver_texels[1],
        }
        twins.on_gpu = Twins::new(gpu, damaged, options()).on_gpu;
        let small = are_small(&twins.differences());
        // The lightmap itself, the last of the six, shows what dilation does, and what the stage before wrote.
        let expected: [bool; 6] = std::array::from_fn(|i| if i == 5 { wrong < 3 } else { i != wrong });
        assert_eq!(small, expected, "{wrong}");
    }
}

/// Coarser levels are the mean of those of the four texels below that have light.
#[test]
fn coarser_levels_average_what_has_light() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut twins = Twins::new(gpu, random_room(SMALL), options());
    for stage in Stage::ALL {
        twins.run(stage);
    }
    let lightmap = twins.on_gpu.buffers().lightmap.clone();
    assert_eq!(lightmap.mip_level_count(), 4);
    for level in 1..lightmap.mip_level_count() {
        let [width, finer_width] =
            [level, level - 1].map(|level| (lightmap.width() >> level).max(1) as usize);
        let (coarser, finer) = (twins.texels(level), twins.texels(level - 1));
        for (index, (value, alpha)) in coarser.iter().enumerate() {
            let (x, y) = (2 * (index % width), 2 * (index / width));
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| finer[(y + j) * finer_width + x + i]);
            let lit: Vec<Vec3> =
                four.iter().filter(|(_, alpha)| *alpha > 0.0).map(|(value, _)| *value).collect();
            let mean = lit.iter().sum::<Vec3>() / lit.len().max(1) as f32;
            assert_eq!(*alpha > 0.0, !lit.is_empty());
            let scale = lit.iter().fold(1e-3, |m: f32, v| m.max(v.abs().max_element()));
            assert!((*value - mean).abs().max_element() <= 2e-3 * scale, "level {level}: {value} for {mean}");
        }
    }
}

/// Several frames without anything in between, against several frames on the CPU.
fn compare_frames(lighting: &Lighting, tolerance: f64) {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    for size in [SMALL, SMALL_PAPER] {
        let mut twins = Twins::new(gpu, random_room(size), options());
        twins.on_cpu.set_lighting(lighting.clone()).unwrap();
        twins.on_cpu.reset();
        twins.on_gpu.set_lighting(lighting.clone()).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut lightmaps = Vec::new();
        for _ in 0..2 {
            twins.on_cpu.step(&FrameInput::default());
            lightmaps.push(twins.on_cpu.irradiance().texels.clone());
            twins.on_gpu.encode(&FrameInput::default(), &mut encoder);
        }
        gpu.queue.submit([encoder.finish()]);
        let on_gpu = twins.on_gpu.read_lightmap().unwrap().texels;
        let [previous, found] = [0, 1].map(|frame| difference(&on_gpu, &lightmaps[frame]));
        assert!(found < tolerance, "{found}");
        assert!(previous > tolerance, "a missing bounce goes unnoticed: {previous}");
    }
}

#[test]
fn frames_equal_those_of_the_cpu() {
    // Without shadows, both sides compute the same.
    let lights = vec![Light::Directional { direction: -Vec3::Y, irradiance: Vec3::ZERO }];
    compare_frames(&Lighting { lights, ..all_lights() }, 1.5 * TOLERANCE);
}

#[test]
fn convergence_is_that_of_the_cpu() {
    let Some(gpu) = gpu::gpu_or_skip() else { return };
    let mut twins = Twins::new(gpu, random_room(SMALL), options());
    let lighting = Lighting { lights: Vec::new(), ..all_lights() };
    twins.on_cpu.set_lighting(lighting.clone()).unwrap();
    twins.on_cpu.reset();
    twins.on_gpu.set_lighting(lighting).unwrap();
    twins.on_gpu.reset();
    let (cpu, on_gpu) = (twins.on_cpu.converge(1e-4, 100), twins.on_gpu.converge(1e-4, 100).unwrap());
    assert!(cpu.steps.abs_diff(on_gpu.steps) <= 1, "{cpu:?} {on_gpu:?}");
    let found = difference(&twins.on_gpu.read_irradiance().unwrap(), twins.on_cpu.receiver_irradiance());
    assert!(found < 1e-4, "{found}");
    // The same without bounces.
    let bounced = twins.on_cpu.receiver_irradiance().to_vec();
    twins.on_cpu.set_bounces(false);
    twins.on_gpu.set_bounces(false);
    twins.on_cpu.converge(1e-4, 100);
    twins.on_gpu.converge(1e-4, 100).unwrap();
    let on_gpu = twins.on_gpu.read_irradiance().unwrap();
    let [found, lost] =
        [twins.on_cpu.receiver_irradiance(), &bounced].map(|expected| difference(&on_gpu, expected));
    assert!(found < 1e-4 && lost > 1e-3, "{found}, {lost} with bounces");
}
