//! Baked scenes made by hand: a room whose transport matrices are random numbers, of any size, for measurements and
//! tests of the stages.

use probelight_asset::packed::Ranks;
use probelight_asset::{
    BakedParts, Cluster, Emitter, LightSample, LightmapFace, LightmapLayout, NONE, Probe, Surfel, SurfelGroup,
};
use probelight_math::directions::progressive_sphere;
use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_math::sampling::Rng;
use probelight_scene::{Bounds, Light, Lighting, Material, Scene, Sky};

/// Size of a [`synthetic_room`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntheticSize {
    /// Number of clusters.
    pub clusters: usize,
    /// Receivers of each.
    pub receivers_per_cluster: usize,
    /// Singular values of each, by the precision that U has them with.
    pub receiver_ranks: Ranks,
    /// By that of ΣVᵀ; as many.
    pub signal_ranks: Ranks,
    /// Number of surfels.
    pub surfels: usize,
    /// Surfels have 1 to this many samples.
    pub samples_per_surfel: usize,
    /// Number of surfel groups.
    pub surfel_groups: usize,
    /// Number of emitters.
    pub emitters: usize,
    /// Highest band of the sky's own signals.
    pub sky_degree: Option<u32>,
    /// Scalar signals of each cluster.
    pub signals_per_cluster: usize,
    /// Number of probes.
    pub probes: usize,
    /// Probes of each cluster.
    pub probes_per_cluster: usize,
    /// Relight rays of each probe.
    pub rays: usize,
    /// Highest band of the probes.
    pub sh_degree: usize,
    /// Whether every third cluster has no scalar signals and every third no probes, with the ranks of the
    /// precisions changing places; and whether what belongs together is chosen anywhere in the room, not nearby.
    pub varied: bool,
}

impl SyntheticSize {
    /// As a bake with the default settings makes it, by its proportions on the bundled scenes: packed matrices of
    /// some 65 bytes per receiver, near light from surfels.
    pub fn hybrid(receivers: usize) -> Self {
        let receivers_per_cluster = 256;
        let surfels = receivers.div_ceil(5);
        Self {
            clusters: receivers.div_ceil(receivers_per_cluster),
            receivers_per_cluster,
            receiver_ranks: Ranks { f16: 0, snorm8: 8, snorm4: 16 },
            signal_ranks: Ranks { f16: 0, snorm8: 4, snorm4: 20 },
            surfels,
            samples_per_surfel: 7,
            surfel_groups: surfels - 1,
            emitters: 1,
            sky_degree: Some(4),
            signals_per_cluster: 256,
            probes: receivers.div_ceil(300),
            probes_per_cluster: 6,
            rays: 512,
            sh_degree: 7,
            varied: false,
        }
    }

    /// As published: half floats, signals from ten probes alone, relight rays that each see a point of their own.
    pub fn paper(receivers: usize) -> Self {
        let (probes, rays) = (receivers.div_ceil(300), 512);
        Self {
            receiver_ranks: Ranks { f16: 32, snorm8: 0, snorm4: 0 },
            signal_ranks: Ranks { f16: 32, snorm8: 0, snorm4: 0 },
            surfels: probes * rays,
            samples_per_surfel: 1,
            surfel_groups: 0,
            emitters: 0,
            sky_degree: None,
            signals_per_cluster: 0,
            probes_per_cluster: 10.min(probes),
            ..Self::hybrid(receivers)
        }
    }

    /// Number of receivers.
    pub fn receivers(&self) -> usize {
        self.clusters * self.receivers_per_cluster
    }
}

/// Adds a quad (counter-clockwise corners) to a scene.
pub fn add_quad(scene: &mut Scene, corners: [Vec3; 4], material: u32) {
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
pub fn horizontal_quad(center: Vec3) -> [Vec3; 4] {
    [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, z)| center + Vec3::new(x, 0.0, z))
}

/// A material with a base colour and emission.
pub fn material(base_color: Vec3, emission: Vec3) -> Material {
    Material { base_color: base_color.extend(1.0), emission, ..Material::default() }
}

/// A floor with a smaller quad above it, which casts a shadow.
pub fn floor_and_shade() -> Scene {
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
pub fn synthetic_lighting() -> Lighting {
    Lighting {
        lights: vec![
            Light::Point {
                position: Vec3::new(0.5, 2.0, 0.3),
                intensity: Vec3::new(9.0, 8.0, 7.0),
                range: None,
            },
            Light::Spot {
                position: Vec3::new(-1.0, 3.0, 0.0),
                direction: -Vec3::Y,
                intensity: Vec3::splat(20.0),
                inner_angle: 0.3,
                outer_angle: 0.6,
                range: None,
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
/// dilated texels around their rows; their boxes are tiles of a square metre each.
pub fn synthetic_room(size: SyntheticSize) -> BakedParts {
    let rng = &mut Rng::new(size.clusters as u64, 1);
    let mut baked = BakedParts {
        scene: floor_and_shade().into(),
        relight_directions: progressive_sphere(size.rays),
        ..BakedParts::default()
    };
    baked.settings.sh_degree = size.sh_degree as u32;
    baked.settings.sky_degree = size.sky_degree;
    baked.probes =
        (0..size.probes).map(|i| Probe { position: Vec3::splat(i as f32), support_radius: 1.0 }).collect();
    tile_lightmap(&mut baked, size);
    faces_of_quads(&mut baked.lightmap);
    push_random_surfels(&mut baked, rng, size);
    baked.emitters = (0..size.emitters)
        .map(|_| Emitter { material: 1, mean_texel: rng.next_vec2().extend(rng.next_f32()) })
        .collect();
    let rays = size.probes * size.rays;
    let surfel = |ray: usize| match rng.next_f32() {
        ..0.1 => NONE,
        // As published, each ray sees a point of its own.
        _ if size.surfels == rays => ray as u32,
        _ => Neighbours::new(size, ray, rays, size.surfels).pick(rng),
    };
    baked.relight_surfels = (0..rays).map(surfel).collect();
    baked.relight_gains = (0..rays).map(|_| 100 + below(rng, 50) as u8).collect();
    for index in 0..size.clusters {
        push_random_cluster(&mut baked, rng, size, index);
    }
    baked
}

/// Things that a thing of another kind may have to do with: any, or those at about the same place in their order.
struct Neighbours {
    first: usize,
    count: usize,
}

impl Neighbours {
    /// How many are near.
    const NEAR: usize = 1024;

    /// Those of `total` for number `index` of `indices`.
    fn new(size: SyntheticSize, index: usize, indices: usize, total: usize) -> Self {
        Self::within(size, index, indices, total, Self::NEAR)
    }

    fn within(size: SyntheticSize, index: usize, indices: usize, total: usize, near: usize) -> Self {
        if size.varied {
            return Self { first: 0, count: total };
        }
        let count = near.min(total);
        Self { first: index * (total - count) / indices.max(1), count }
    }

    fn pick(&self, rng: &mut Rng) -> u32 {
        self.first as u32 + below(rng, self.count)
    }
}

/// A random number below `end`.
fn below(rng: &mut Rng, end: usize) -> u32 {
    rng.next_u32() % end as u32
}

fn push_random_surfels(baked: &mut BakedParts, rng: &mut Rng, size: SyntheticSize) {
    let receivers = baked.receiver_texels.len();
    for index in 0..size.surfels {
        let sample_count = 1 + below(rng, size.samples_per_surfel);
        let first_sample = baked.light_samples.len() as u32;
        baked.surfels.push(Surfel { first_sample, sample_count, area: 0.0 });
        // Few receivers, so that samples meet.
        let near = Neighbours::within(size, index, size.surfels, receivers, 5);
        for _ in 0..sample_count {
            let texel = baked.receiver_texels[near.pick(rng) as usize];
            let sample = random_light_sample(rng, &baked.lightmap, texel);
            baked.light_samples.push(sample);
        }
    }
    for group in 0..size.surfel_groups {
        let number = size.surfels + group;
        // The patches that are not yet part of a group, two by two; or any.
        let children = match 2 * group + 1 {
            second if second < number && !size.varied => [second - 1, second].map(|child| child as u32),
            _ => [below(rng, number), below(rng, number)],
        };
        baked.surfel_groups.push(SurfelGroup { children, first_weight: rng.next_f32() });
    }
}

/// A sample on a random side that reads a texel of the lightmap, or none on the back of the shade.
fn random_light_sample(rng: &mut Rng, layout: &LightmapLayout, texel: u32) -> LightSample {
    let (quad, is_back_face) = (below(rng, 2), rng.next_f32() < 0.5);
    let at = Vec2::new((texel % layout.width) as f32, (texel / layout.width) as f32) + 0.5;
    let at = at / Vec2::new(layout.width as f32, layout.height as f32);
    // The lightmap's image lies on each quad as a whole; see `faces_of_quads`.
    let (triangle, weights) =
        if at.y <= at.x { (0, Vec2::new(at.x - at.y, at.y)) } else { (1, Vec2::new(at.x, at.y - at.x)) };
    let mut code = || (rng.next_u32() >> 24) as u8;
    LightSample::new(2 * quad + triangle, is_back_face, weights, [code(), code(), code()])
}

/// The lightmap of [`floor_and_shade`]: all of it on each side, but for the back of the shade.
fn faces_of_quads(layout: &mut LightmapLayout) {
    let (right, bottom) = (Vec2::X * layout.width as f32, Vec2::Y * layout.height as f32);
    let face = |corners| LightmapFace { corners };
    let quad = [face([Vec2::ZERO, right, right + bottom]), face([Vec2::ZERO, right + bottom, bottom])];
    layout.faces = [quad; 3].concat();
    layout.back_faces = vec![4, 5, NONE, NONE];
}

/// Tiles touch the ones left and right of them, so that clusters meet there, and have dilated texels below them.
fn tile_lightmap(baked: &mut BakedParts, size: SyntheticSize) {
    baked.settings.blend_borders = true;
    let side = (size.receivers_per_cluster as f64).sqrt().ceil() as u32;
    let tiles_across = (size.clusters as f64).sqrt().ceil() as u32;
    let layout = &mut baked.lightmap;
    layout.pages = 1;
    layout.width = tiles_across * side + 1;
    layout.height = (size.clusters as u32).div_ceil(tiles_across) * (side + 1);
    for cluster in 0..size.clusters as u32 {
        let corner = [cluster % tiles_across * side, cluster / tiles_across * (side + 1)];
        let texel = |x: u32, y: u32| (corner[1] + y) * layout.width + corner[0] + x;
        let texels = (0..size.receivers_per_cluster as u32).map(|i| texel(i % side, i / side));
        baked.receiver_texels.extend(texels);
        baked.receiver_errors.resize(baked.receiver_texels.len(), 0);
        for x in 0..side {
            layout.dilation.push([texel(x, side), texel(x, 0)]);
        }
        let is_last = (cluster + 1) % tiles_across == 0 || cluster + 1 == size.clusters as u32;
        if is_last {
            layout.dilation.extend((0..=side).map(|y| [texel(side, y), texel(0, 0)]));
        }
    }
}

fn push_random_cluster(baked: &mut BakedParts, rng: &mut Rng, size: SyntheticSize, index: usize) {
    let kind = if size.varied { index % 3 } else { 0 };
    let signal_count = if kind == 2 { 0 } else { size.signals_per_cluster };
    let probe_count = if kind == 1 { 0 } else { size.probes_per_cluster };
    let [receiver_ranks, signal_ranks] = [size.receiver_ranks, size.signal_ranks].map(|ranks| {
        let Ranks { f16, snorm8, snorm4 } = ranks;
        match kind {
            0 => ranks,
            1 => Ranks { f16: snorm8, snorm8: snorm4, snorm4: f16 },
            _ => Ranks { f16: snorm4, snorm8: f16, snorm4: snorm8 },
        }
    });
    let tiles_across = (size.clusters as f64).sqrt().ceil() as usize;
    let corner = Vec3::new((index % tiles_across) as f32, 0.0, (index / tiles_across) as f32);
    let cluster = Cluster {
        bounds: Bounds { min: corner, max: corner + Vec3::ONE },
        air_space: 0,
        first_receiver: (index * size.receivers_per_cluster) as u32,
        receiver_count: size.receivers_per_cluster as u32,
        first_signal: baked.cluster_signals.len() as u32,
        signal_count: signal_count as u32,
        first_probe: baked.cluster_probes.len() as u32,
        probe_count: probe_count as u32,
        receiver_ranks,
        signal_ranks,
        receiver_basis_offset: baked.receiver_basis.len() as u64,
        signal_basis_offset: baked.signal_basis.len() as u64,
        row_scale_offset: baked.row_scales.len() as u64,
        column_exponent_offset: baked.column_exponents.len() as u64,
        error: 0.0,
    };
    let (signals, columns) = (baked.scalar_signals(), baked.column_count(&cluster));
    let near = Neighbours::new(size, index, size.clusters, signals);
    baked.cluster_signals.extend((0..signal_count).map(|_| near.pick(rng)));
    let first = index * size.probes / size.clusters;
    baked.cluster_probes.extend((0..probe_count).map(|p| ((first + p) % size.probes) as u32));
    baked.column_exponents.extend((0..columns).map(|_| below(rng, 30) as u8));
    for k in 0..receiver_ranks.total() as usize {
        baked.row_scales.push(0.01 + 0.02 * rng.next_f32());
        let mut line = |count: usize| (0..count).map(|_| 2.0 * rng.next_f32() - 0.9).collect::<Vec<f32>>();
        receiver_ranks.precision(k).pack(&line(size.receivers_per_cluster), &mut baked.receiver_basis);
        signal_ranks.precision(k).pack(&line(columns), &mut baked.signal_basis);
    }
    baked.clusters.push(cluster);
}
