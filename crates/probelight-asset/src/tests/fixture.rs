//! A small baked scene, written by hand, with something in every field.

use probelight_math::glam::{UVec3, Vec2, Vec3, Vec4};
use probelight_scene::{
    AlphaMode, Bounds, Camera, Light, Material, Scene, SourceInstance, SourceTriangle, Sources, Texture,
    TextureSlot, Warning,
};

use crate::packed::Ranks;
use crate::{
    BakeReport, BakeSettings, BakedParts, Cluster, Emitter, GridBasis, GridBasisKind, GridBlock, GridCell,
    GridLayout, GridLobe, GridVertex, LightSample, LightmapFace, LightmapLayout, Method, Metric, NONE, Probe,
    Storage, Surfel, SurfelGroup,
};

/// Two triangles, 2 × 6 lightmap texels, five receivers in two clusters and a vertex of a grid in a third, two probes,
/// three surfels in two groups, an emitter, a sky of four signals.
pub(super) fn baked_parts() -> BakedParts {
    BakedParts {
        scene: scene().into(),
        scene_hash: u64::MAX - 12,
        settings: settings(),
        report: report(),
        lightmap: lightmap(),
        light_samples: light_samples(),
        surfels: [[0, 2], [2, 1], [3, 1]]
            .map(|[first_sample, sample_count]| Surfel { first_sample, sample_count, area: 0.25 })
            .to_vec(),
        surfel_groups: vec![
            SurfelGroup { children: [0, 2], first_weight: 1.0 / 3.0 },
            SurfelGroup { children: [3, 1], first_weight: 1.0 },
        ],
        emitters: vec![Emitter { material: 1, mean_texel: Vec3::new(0.0, 0.1, 2.0 / 3.0) }],
        probes: vec![
            Probe { position: Vec3::new(0.5, 0.25, 1.0 / 3.0), support_radius: 1.5 },
            Probe { position: Vec3::new(-0.0, 2.0, 0.5), support_radius: 0.0 },
        ],
        relight_directions: vec![Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)],
        relight_surfels: vec![NONE, 0, 2, 1, NONE, 1],
        relight_gains: vec![128, 255, 0, 64, 128, 130],
        grid: GridLayout {
            origin: Vec3::new(0.1, 0.2, -3.5),
            spacing: Vec3::new(1.0, 2.0, 1.5),
            counts: UVec3::new(3, 5, 3),
            levels: 2,
        },
        grid_blocks: vec![GridBlock::new(1 << 5, 0, 0), GridBlock::new(0, 1, 1)],
        grid_vertices: vec![GridVertex { offset: [3, -127, 0, 0] }],
        grid_receivers: vec![7, 6, 5, 10, 9, 8],
        grid_cell_blocks: vec![
            GridBlock::new(1 << 4, 0, 0),
            GridBlock::new(0, 1, 0),
            GridBlock::new(1 << 4, 1, 1),
        ],
        grid_cells: vec![GridCell { planes: [1, 0, NONE, NONE], corners: [0x80; 16] }; 2],
        grid_planes: vec![Vec4::new(0.0, -1.0, 0.0, 0.5), Vec4::new(0.6, 0.0, 0.8, -0.0)],
        clusters: clusters(),
        cluster_signals: vec![3, 9, 0, 2],
        cluster_probes: vec![1, 0, 1],
        receiver_texels: vec![0, 2, 1, 7, 10],
        receiver_errors: vec![0, 64, 255, 3, 9, 1, 2, 3, 4, 5, 6],
        receiver_basis: vec![0xbc00_3555, 0x0001_7bff, 0x0081_7f01, 0x7000_0000, 0x0012_7654],
        signal_basis: (0..5)
            .map(|i| 0x0001_3c00 * i)
            .chain([0x8171_017f, 0x0042_2400, 0x7f, 0x9705_3217, 0x0000_3217])
            .collect(),
        row_scales: vec![1.0, 2.5, 1e-20, 0.5],
        column_exponents: (0..16).map(|i| i * 16).collect(),
    }
}

fn scene() -> Scene {
    Scene {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.1, 1.0)],
        normals: vec![Vec3::Y; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 4],
        uv0: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
        uv1: vec![Vec2::new(0.1, 0.2); 4],
        triangles: vec![[0, 2, 1], [1, 2, 3]],
        triangle_material: vec![1, 0],
        materials: vec![Material::default(), painted()],
        textures: textures(),
        lights: lights(),
        cameras: vec![Camera {
            name: "front".into(),
            position: Vec3::new(0.1, 0.2, 0.3),
            target: Vec3::ZERO,
            up: Vec3::Y,
            vertical_fov: 0.7,
            width: 320,
            height: 200,
        }],
        warnings: vec![Warning { message: "triangles without area, left out".into(), count: 3 }],
        sources: Sources {
            instances: vec![
                SourceInstance {
                    node: 3,
                    node_name: "Table \"é\"".into(),
                    copy: 1,
                    mesh: 2,
                    ..SourceInstance::default()
                },
                SourceInstance { mesh_name: "lamp".into(), primitive: 4, ..SourceInstance::default() },
            ],
            triangles: vec![
                SourceTriangle { instance: 1, triangle: 70_000 },
                SourceTriangle { instance: 0, triangle: 0 },
            ],
        },
    }
}

fn painted() -> Material {
    let slot = |texture, tex_coord| Some(TextureSlot { texture, tex_coord });
    Material {
        name: "painted “wood”".into(),
        base_color: Vec4::new(0.1, 0.2, 0.3, 0.4),
        base_color_texture: slot(0, 1),
        metallic: 0.25,
        roughness: 0.75,
        metallic_roughness_texture: slot(1, 0),
        normal_texture: slot(1, 1),
        normal_scale: -0.5,
        occlusion_texture: slot(0, 0),
        emission: Vec3::new(1e-7, 17.0, 1e9),
        emissive_texture: slot(1, 0),
        alpha_mode: AlphaMode::Mask { cutoff: 0.3 },
        double_sided: true,
    }
}

fn textures() -> Vec<Texture> {
    let noise = (0..3 * 2 * 4u32).map(|i| (i * 37 % 251) as u8).collect();
    vec![
        Texture { name: "noise.png".into(), width: 3, height: 2, rgba8: noise },
        Texture { name: String::new(), width: 1, height: 1, rgba8: [1, 2, 3, 0].into() },
    ]
}

fn lights() -> Vec<Light> {
    vec![
        Light::Point { position: Vec3::ONE, intensity: Vec3::new(0.1, 0.7, 3.3), range: None },
        Light::Spot {
            position: Vec3::Y,
            direction: Vec3::NEG_Y,
            intensity: Vec3::ONE,
            inner_angle: 0.1,
            outer_angle: 0.3,
            range: Some(4.5),
        },
        Light::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(3.0) },
    ]
}

fn settings() -> BakeSettings {
    BakeSettings {
        method: Method::Paper,
        metric: Metric::Band,
        storage: Storage::F16,
        texels_per_meter: 4.0,
        probe_spacing: 1.1,
        sh_degree: 1,
        sky_degree: Some(1),
        surfel_size: 0.3,
        samples_per_surfel: 4,
        near_radius: Some(2.1),
        gather_rays: 256,
        relight_rays: 3,
        probes_per_cluster: 8,
        receivers_per_cluster: 1024,
        blend_borders: true,
        byte_price: 0.25,
        max_rank: 32,
        max_cluster_error: 0.01,
        grid_vertices: Some(40),
        grid_spacing: Some(2.0),
        grid_basis: GridBasis { kind: GridBasisKind::Axes6, lobe: GridLobe::Angle },
        seed: u64::MAX,
    }
}

fn report() -> BakeReport {
    BakeReport {
        chart_texels: 8,
        invalid_texels: 1,
        approximated_fraction: 0.1 + 0.2,
        uncovered_fraction: 1.0 / 3.0,
        mean_cluster_error: 1e-300,
        max_cluster_error: 5e-3,
        warnings: vec!["a warning".into()],
    }
}

fn lightmap() -> LightmapLayout {
    let face = |x: f32, y: f32| LightmapFace {
        corners: [Vec2::new(x, y), Vec2::new(x + 1.0, y), Vec2::new(x, y + 1.5)],
    };
    LightmapLayout {
        width: 2,
        height: 6,
        pages: 2,
        faces: vec![face(0.5, 0.5), face(0.5, 3.5), face(1.0, 4.0)],
        back_faces: vec![2, NONE],
        dilation: vec![[3, 2], [11, 10], [6, 7]],
    }
}

fn light_samples() -> Vec<LightSample> {
    let sample = LightSample::new(1, true, Vec2::new(0.3, 0.25), [255, 128, 7]);
    vec![sample, sample, LightSample::new(0, false, Vec2::X, [1, 2, 3]), sample]
}

/// Degree 1 has four coefficients: the first cluster has ten columns (two scalar signals, two probes), the
/// second five.
fn clusters() -> Vec<Cluster> {
    let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
    let first = Cluster {
        bounds,
        air_space: 0,
        first_receiver: 0,
        receiver_count: 3,
        first_signal: 0,
        signal_count: 2,
        first_probe: 0,
        probe_count: 2,
        receiver_ranks: Ranks { f16: 1, snorm8: 1, snorm4: 0 },
        signal_ranks: Ranks { f16: 1, snorm8: 1, snorm4: 0 },
        receiver_basis_offset: 0,
        signal_basis_offset: 0,
        row_scale_offset: 0,
        column_exponent_offset: 0,
        error: 0.004,
    };
    let second = Cluster {
        bounds,
        air_space: NONE,
        first_receiver: 3,
        receiver_count: 2,
        first_signal: 2,
        signal_count: 1,
        first_probe: 2,
        probe_count: 1,
        receiver_ranks: Ranks { f16: 0, snorm8: 1, snorm4: 0 },
        signal_ranks: Ranks { f16: 0, snorm8: 0, snorm4: 1 },
        receiver_basis_offset: 3,
        signal_basis_offset: 8,
        row_scale_offset: 2,
        column_exponent_offset: 10,
        error: 0.0,
    };
    let of_grid = Cluster {
        air_space: 0,
        first_receiver: 5,
        receiver_count: 6,
        first_signal: 3,
        signal_count: 1,
        first_probe: 3,
        probe_count: 0,
        receiver_ranks: Ranks { f16: 0, snorm8: 0, snorm4: 1 },
        receiver_basis_offset: 4,
        signal_basis_offset: 9,
        row_scale_offset: 3,
        column_exponent_offset: 15,
        ..second
    };
    vec![first, second, of_grid]
}
