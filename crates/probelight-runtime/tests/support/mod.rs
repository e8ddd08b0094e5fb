//! Baked scenes made by hand: a room whose transport matrices are random numbers, of any size, and the slow
//! truth of a frame.
#![allow(dead_code, reason = "each test binary uses a part")]

pub(crate) mod slow_frame;

use half::f16;
use probelight_asset::{BakedScene, Cluster, LightmapFace, LightmapLayout, NONE, Probe, RelightPoint};
use probelight_math::directions::progressive_sphere;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_math::sampling::Rng;
use probelight_math::sh::{Y00, coefficient_count};
use probelight_scene::{Bounds, Light, Lighting, Material, Scene, Sky};

/// Size of a [`random_room`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) clusters: usize,
    pub(crate) receivers_per_cluster: usize,
    pub(crate) rank: usize,
    pub(crate) probes: usize,
    pub(crate) probes_per_cluster: usize,
    pub(crate) rays: usize,
    pub(crate) sh_degree: usize,
}

/// Small, with every remainder that the vector loops must handle.
pub(crate) const SMALL: Size = Size {
    clusters: 11,
    receivers_per_cluster: 101,
    rank: 7,
    probes: 19,
    probes_per_cluster: 3,
    rays: 60,
    sh_degree: 4,
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

/// [`floor_and_shade`] with random relight points and random matrices. Clusters are square tiles of the
/// lightmap, with a border of dilated texels.
pub(crate) fn random_room(size: Size) -> BakedScene {
    let scene = floor_and_shade();
    let rng = &mut Rng::new(size.clusters as u64, 1);
    let mut baked = BakedScene { relight_directions: progressive_sphere(size.rays), ..BakedScene::default() };
    baked.settings.sh_degree = size.sh_degree as u32;
    baked.probes =
        (0..size.probes).map(|i| Probe { position: Vec3::splat(i as f32), support_radius: 1.0 }).collect();
    tile_lightmap(&mut baked, size);
    baked.lightmap.faces = vec![LightmapFace::default(); scene.triangles.len()];
    baked.lightmap.back_faces = vec![NONE; scene.triangles.len()];
    baked.relight_points = (0..size.probes * size.rays)
        .map(|_| random_relight_point(rng, &scene, &baked.receiver_texels))
        .collect();
    baked.scene = scene;
    for index in 0..size.clusters {
        push_random_cluster(&mut baked, rng, size, index);
    }
    baked
}

fn random_relight_point(rng: &mut Rng, scene: &Scene, receiver_texels: &[u32]) -> RelightPoint {
    if rng.next_f32() < 0.1 {
        return RelightPoint { triangle: NONE, texel: NONE, ..RelightPoint::default() };
    }
    let triangle = rng.next_u32() as usize % scene.triangles.len();
    let [a, b, c] = scene.corners(triangle);
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
        receiver_texels[rng.next_u32() as usize % receiver_texels.len()]
    };
    RelightPoint {
        position: a + (b - a) * u + (c - a) * v,
        triangle: triangle as u32,
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
    let columns = size.probes_per_cluster * coefficient_count(size.sh_degree);
    baked.clusters.push(Cluster {
        bounds: Bounds { min: Vec3::ZERO, max: Vec3::ONE },
        first_receiver: (index * size.receivers_per_cluster) as u32,
        receiver_count: size.receivers_per_cluster as u32,
        first_probe: baked.cluster_probes.len() as u32,
        probe_count: size.probes_per_cluster as u32,
        rank: size.rank as u32,
        receiver_basis_offset: baked.receiver_basis.len() as u64,
        signal_basis_offset: baked.signal_basis.len() as u64,
        row_scale_offset: baked.row_scales.len() as u32,
        error: 0.0,
    });
    let first = index % size.probes;
    baked.cluster_probes.extend((0..size.probes_per_cluster).map(|p| ((first + p) % size.probes) as u32));
    baked.row_scales.extend((0..size.rank).map(|_| 0.001 + 0.002 * rng.next_f32()));
    let mut random = |_| f16::from_f32(rng.next_f32() - 0.45);
    baked.receiver_basis.extend((0..size.rank * size.receivers_per_cluster).map(&mut random));
    baked.signal_basis.extend((0..size.rank * columns).map(&mut random));
}

/// One probe whose rays all bring the radiance of `point`, and one receiver per gain, side by side in the
/// lightmap: E of receiver i is `gains[i]` times the probe's mean radiance.
pub(crate) fn single_probe(scene: Scene, point: RelightPoint, gains: &[f32]) -> BakedScene {
    let size = Size {
        clusters: 1,
        receivers_per_cluster: gains.len(),
        rank: 1,
        probes: 1,
        probes_per_cluster: 1,
        rays: 64,
        sh_degree: 3,
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
    baked.scene = scene;
    baked.receiver_texels = (0..gains.len() as u32).collect();
    baked.relight_points = vec![point; size.rays];
    baked.signal_basis.fill(f16::ZERO);
    baked.signal_basis[0] = f16::ONE;
    baked.row_scales = vec![Y00];
    baked.receiver_basis = gains.iter().map(|gain| f16::from_f32(*gain)).collect();
    baked
}

/// A point on the front of triangle 0 with white textures that reads texel 0.
pub(crate) fn white_point() -> RelightPoint {
    RelightPoint {
        position: Vec3::ZERO,
        triangle: 0,
        texel: 0,
        base_color_and_side: [255, 255, 255, 0],
        emission_texel: [255, 255, 255, 0],
    }
}

/// A ray that reaches the sky.
pub(crate) fn sky_point() -> RelightPoint {
    RelightPoint { triangle: NONE, texel: NONE, ..RelightPoint::default() }
}

/// A lighting with nothing but a uniform sky.
pub(crate) fn uniform_sky(radiance: Vec3) -> Lighting {
    Lighting { sky: Sky::Uniform(radiance), ..Lighting::default() }
}
