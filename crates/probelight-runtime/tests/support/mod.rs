//! Baked scenes made by hand: a room whose transport matrices are random numbers, of any size, and the slow
//! truth of a frame.
#![allow(dead_code, reason = "each test binary uses a part")]

pub(crate) mod slow_frame;

use probelight_asset::packed::{Precision, Ranks};
use probelight_asset::{
    BakedScene, Cluster, Emitter, LightSample, LightmapFace, LightmapLayout, NONE, Probe, Surfel, SurfelGroup,
};
use probelight_math::directions::progressive_sphere;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_math::sampling::Rng;
use probelight_math::sh::Y00;
use probelight_scene::{Bounds, Light, Lighting, Material, Scene, Sky};

/// Size of a [`random_room`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) clusters: usize,
    pub(crate) receivers_per_cluster: usize,
    pub(crate) ranks: Ranks,
    pub(crate) surfels: usize,
    /// Surfels have 1 to this many samples.
    pub(crate) samples_per_surfel: usize,
    pub(crate) surfel_groups: usize,
    pub(crate) emitters: usize,
    pub(crate) sky_degree: Option<u32>,
    pub(crate) signals_per_cluster: usize,
    pub(crate) probes: usize,
    pub(crate) probes_per_cluster: usize,
    pub(crate) rays: usize,
    pub(crate) sh_degree: usize,
    /// Whether every third cluster has no scalar signals and every third no probes, with the ranks of the
    /// precisions changing places.
    pub(crate) varied: bool,
}

/// Small, with every remainder that the vector loops must handle.
pub(crate) const SMALL: Size = Size {
    clusters: 11,
    receivers_per_cluster: 101,
    ranks: Ranks { f16: 2, snorm8: 7, snorm4: 5 },
    surfels: 70,
    samples_per_surfel: 5,
    surfel_groups: 30,
    emitters: 2,
    sky_degree: Some(2),
    signals_per_cluster: 37,
    probes: 19,
    probes_per_cluster: 3,
    rays: 60,
    sh_degree: 4,
    varied: true,
};

/// As [`SMALL`], but as published: relight rays that each see a point of their own or the sky, signals from
/// probes alone, half floats.
pub(crate) const SMALL_PAPER: Size = Size {
    ranks: Ranks { f16: 7, snorm8: 0, snorm4: 0 },
    surfels: 19 * 60,
    samples_per_surfel: 1,
    surfel_groups: 0,
    emitters: 0,
    sky_degree: None,
    signals_per_cluster: 0,
    varied: false,
    ..SMALL
};

/// Adds a quad (counter-clockwise corners) to a scene.
pub(crate) fn add_quad(scene: &mut Scene, corners: [Vec3; 4], material: u32) {
    let first = scene.positions.len() as u32;
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    scene.positions.extend(corners);
    scene.normals.extend([normal; 4]);
    scene.tangents.extend([Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    scene.uv0.extend([Vec2::ZERO; 4]);
    scene.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| first + v)));
    scene.triangle_material.extend([material; 2]);
}

/// A horizontal quad of side 2 around `center`, facing up.
pub(crate) fn horizontal_quad(center: Vec3) -> [Vec3; 4] {
    [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, z)| center + Vec3::new(x, 0.0, z))
}

/// A material with a base colour and emission.
pub(crate) fn material(base_color: Vec3, emission: Vec3) -> Material {
    Material { base_color: base_color.extend(1.0), emission, ..Material::default() }
}

/// A floor with a smaller quad above it, which casts a shadow.
pub(crate) fn floor_and_shade() -> Scene {
    let mut scene = Scene {
        materials: vec![
            material(Vec3::new(0.7, 0.5, 0.3), Vec3::ZERO),
            material(Vec3::new(0.2, 0.4, 0.6), Vec3::new(1.0, 2.0, 0.5)),
        ],
        ..Scene::default()
    };
    add_quad(&mut scene, horizontal_quad(Vec3::ZERO).map(|c| c * 3.0), 0);
    add_quad(&mut scene, horizontal_quad(Vec3::Y), 1);
    scene
}

/// One light of each kind, a sky, and emission.
pub(crate) fn all_lights() -> Lighting {
    Lighting {
        lights: vec![
            Light::Point { position: Vec3::new(0.5, 2.0, 0.3), intensity: Vec3::new(9.0, 8.0, 7.0) },
            Light::Spot {
                position: Vec3::new(-1.0, 3.0, 0.0),
                direction: -Vec3::Y,
                intensity: Vec3::splat(20.0),
                inner_angle: 0.3,
                outer_angle: 0.6,
            },
            Light::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance: Vec3::new(3.0, 2.5, 2.0) },
        ],
        sky: Sky::Gradient {
            zenith: Vec3::new(0.2, 0.4, 0.9),
            horizon: Vec3::splat(0.5),
            ground: Vec3::splat(0.1),
        },
        emissive_scale: 1.5,
    }
}

/// [`floor_and_shade`] with random surfels and random matrices. Clusters are square tiles of the lightmap, with
/// a border of dilated texels.
pub(crate) fn random_room(size: Size) -> BakedScene {
    let rng = &mut Rng::new(size.clusters as u64, 1);
    let mut baked = BakedScene {
        scene: floor_and_shade(),
        relight_directions: progressive_sphere(size.rays),
        ..BakedScene::default()
    };
    baked.settings.sh_degree = size.sh_degree as u32;
    baked.settings.sky_degree = size.sky_degree;
    baked.probes =
        (0..size.probes).map(|i| Probe { position: Vec3::splat(i as f32), support_radius: 1.0 }).collect();
    tile_lightmap(&mut baked, size);
    baked.lightmap.faces = vec![LightmapFace::default(); baked.scene.triangles.len()];
    baked.lightmap.back_faces = vec![NONE; baked.scene.triangles.len()];
    push_random_surfels(&mut baked, rng, size);
    baked.emitters = (0..size.emitters)
        .map(|_| Emitter { material: 1, mean_texel: rng.next_vec2().extend(rng.next_f32()) })
        .collect();
    let rays = size.probes * size.rays;
    let surfel = |ray: usize| match rng.next_f32() {
        ..0.1 => NONE,
        // As published, each ray sees a point of its own.
        _ if size.surfels == rays => ray as u32,
        _ => below(rng, size.surfels),
    };
    baked.relight_surfels = (0..rays).map(surfel).collect();
    for index in 0..size.clusters {
        push_random_cluster(&mut baked, rng, size, index);
    }
    baked
}

/// A random number below `end`.
fn below(rng: &mut Rng, end: usize) -> u32 {
    rng.next_u32() % end as u32
}

fn push_random_surfels(baked: &mut BakedScene, rng: &mut Rng, size: Size) {
    for _ in 0..size.surfels {
        let sample_count = 1 + below(rng, size.samples_per_surfel);
        let first_sample = baked.light_samples.len() as u32;
        baked.surfels.push(Surfel { first_sample, sample_count });
        for _ in 0..sample_count {
            let sample = random_light_sample(rng, &baked.scene, &baked.receiver_texels);
            baked.light_samples.push(sample);
        }
    }
    for number in size.surfels..size.surfels + size.surfel_groups {
        let children = [below(rng, number), below(rng, number)];
        baked.surfel_groups.push(SurfelGroup { children, first_weight: rng.next_f32() });
    }
}

fn random_light_sample(rng: &mut Rng, scene: &Scene, receiver_texels: &[u32]) -> LightSample {
    let triangle = below(rng, scene.triangles.len());
    let [a, b, c] = scene.corners(triangle as usize);
    let (mut u, mut v) = (rng.next_f32(), rng.next_f32());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let mut code = || (rng.next_u32() >> 24) as u8;
    let (base_color_and_side, emission_texel) =
        ([code(), code(), code(), code() & 1], [code(), code(), code(), 0]);
    let texel = if rng.next_f32() < 0.05 {
        NONE
    } else {
        receiver_texels[below(rng, receiver_texels.len()) as usize]
    };
    LightSample {
        position: a + (b - a) * u + (c - a) * v,
        triangle,
        texel,
        base_color_and_side,
        emission_texel,
    }
}

fn tile_lightmap(baked: &mut BakedScene, size: Size) {
    let side = (size.receivers_per_cluster as f64).sqrt().ceil() as u32;
    let tiles_across = (size.clusters as f64).sqrt().ceil() as u32;
    let layout = &mut baked.lightmap;
    layout.pages = 1;
    layout.width = tiles_across * (side + 1);
    layout.height = (size.clusters as u32).div_ceil(tiles_across) * (side + 1);
    for cluster in 0..size.clusters as u32 {
        let corner = [cluster % tiles_across * (side + 1), cluster / tiles_across * (side + 1)];
        let texel = |x: u32, y: u32| (corner[1] + y) * layout.width + corner[0] + x;
        let texels = (0..size.receivers_per_cluster as u32).map(|i| texel(i % side, i / side));
        baked.receiver_texels.extend(texels);
        for x in 0..side {
            layout.dilation.push([texel(x, side), texel(x, 0)]);
        }
        for y in 0..=side {
            layout.dilation.push([texel(side, y), texel(0, 0)]);
        }
    }
}

fn push_random_cluster(baked: &mut BakedScene, rng: &mut Rng, size: Size, index: usize) {
    let kind = if size.varied { index % 3 } else { 0 };
    let signal_count = if kind == 2 { 0 } else { size.signals_per_cluster };
    let probe_count = if kind == 1 { 0 } else { size.probes_per_cluster };
    let Ranks { f16, snorm8, snorm4 } = size.ranks;
    let ranks = match kind {
        0 => size.ranks,
        1 => Ranks { f16: snorm8, snorm8: snorm4, snorm4: f16 },
        _ => Ranks { f16: snorm4, snorm8: f16, snorm4: snorm8 },
    };
    let cluster = Cluster {
        bounds: Bounds { min: Vec3::ZERO, max: Vec3::ONE },
        first_receiver: (index * size.receivers_per_cluster) as u32,
        receiver_count: size.receivers_per_cluster as u32,
        first_signal: baked.cluster_signals.len() as u32,
        signal_count: signal_count as u32,
        first_probe: baked.cluster_probes.len() as u32,
        probe_count: probe_count as u32,
        ranks,
        receiver_basis_offset: baked.receiver_basis.len() as u64,
        signal_basis_offset: baked.signal_basis.len() as u64,
        row_scale_offset: baked.row_scales.len() as u32,
        column_exponent_offset: baked.column_exponents.len() as u64,
        error: 0.0,
    };
    let (signals, columns) = (baked.scalar_signals(), baked.column_count(&cluster));
    baked.cluster_signals.extend((0..signal_count).map(|_| below(rng, signals)));
    baked.cluster_probes.extend((0..probe_count).map(|p| ((index + p) % size.probes) as u32));
    baked.column_exponents.extend((0..columns).map(|_| below(rng, 30) as u8));
    for k in 0..ranks.total() as usize {
        baked.row_scales.push(0.01 + 0.02 * rng.next_f32());
        let mut line = |count: usize| (0..count).map(|_| 2.0 * rng.next_f32() - 0.9).collect::<Vec<f32>>();
        ranks.precision(k).pack(&line(size.receivers_per_cluster), &mut baked.receiver_basis);
        ranks.precision(k).pack(&line(columns), &mut baked.signal_basis);
    }
    baked.clusters.push(cluster);
}

/// One probe whose rays all see `sample`, or else the sky, and one receiver per gain, side by side in the
/// lightmap: E of receiver i is `gains[i]` times the probe's mean radiance.
pub(crate) fn single_probe(scene: Scene, sample: Option<LightSample>, gains: &[f32]) -> BakedScene {
    let size = Size {
        clusters: 1,
        receivers_per_cluster: gains.len(),
        ranks: Ranks { f16: 1, ..Ranks::default() },
        probes: 1,
        probes_per_cluster: 1,
        rays: 64,
        sh_degree: 3,
        ..SMALL_PAPER
    };
    let mut baked = random_room(size);
    baked.lightmap = LightmapLayout {
        width: gains.len() as u32,
        height: 1,
        pages: 1,
        faces: vec![LightmapFace::default(); scene.triangles.len()],
        back_faces: vec![NONE; scene.triangles.len()],
        dilation: Vec::new(),
    };
    baked.receiver_texels = (0..gains.len() as u32).collect();
    baked.surfels = sample.iter().map(|_| Surfel { first_sample: 0, sample_count: 1 }).collect();
    baked.light_samples = sample.into_iter().collect();
    baked.relight_surfels = vec![if sample.is_some() { 0 } else { NONE }; size.rays];
    baked.scene = scene;
    let columns = baked.column_count(&baked.clusters[0]);
    baked.column_exponents = vec![0; columns];
    baked.row_scales = vec![Y00];
    baked.signal_basis.clear();
    baked.receiver_basis.clear();
    let first_column: Vec<f32> = (0..columns).map(|c| if c == 0 { 1.0 } else { 0.0 }).collect();
    Precision::F16.pack(&first_column, &mut baked.signal_basis);
    Precision::F16.pack(gains, &mut baked.receiver_basis);
    baked
}

/// A sample on the front of triangle 0 with white textures that reads texel 0.
pub(crate) fn white_sample() -> LightSample {
    LightSample {
        position: Vec3::ZERO,
        triangle: 0,
        texel: 0,
        base_color_and_side: [255, 255, 255, 0],
        emission_texel: [255, 255, 255, 0],
    }
}

/// A lighting with nothing but a uniform sky.
pub(crate) fn uniform_sky(radiance: Vec3) -> Lighting {
    Lighting { sky: Sky::Uniform(radiance), ..Lighting::default() }
}
