//! What can be tested of the shaders without a GPU.

use half::f16;
use naga::Module;
use probelight_asset::packed::{EXPONENT_STEPS, GAIN_STEPS, Ranks, STEEPEST_SLOPE};
use probelight_asset::{BLOCK_EDGE, GridCell, MAX_GRID_LEVELS, MAX_GRID_ROWS, MAX_SH_DEGREE, NONE};
use probelight_math::sh::Y00;

use super::blend_borders::BorderReceiver;
use super::cast_shadows::AlphaTestRecord;
use super::choose_work::{ClusterWish, ProbeState, ProbeWish, WorkRules};
use super::cluster_shards::{ClusterRecord, GATHER_BLOCK, GatherTask};
use super::dilate_lightmap::TexelCopy;
use super::eye_views::{EYE_VIEWS, MAX_EYE_VIEWS};
use super::frame_buffers::SignalShape;
use super::frame_extents::ProbeRecord;
use super::frame_work::FrameFlags;
use super::grid_tables::{DiscsRecord, GRID_AXES, GRID_COSINES, GRID_SH2, GridBlockRecord, GridRecord};
use super::light_surfels::MaterialColors;
use super::lit_points::LitPoint;
use super::moving_geometry::PlacementRecord;
use super::reflection::{Layout, Partners, parse, record, workgroup_size, write_for_direct3d_and_metal};
use super::shaders;
use super::shadow_views::{
    DIRECTIONAL_LIGHT, DIRECTIONAL_VIEWS_PER_SIDE, GUARD_TEXELS, LightRecord, LightsRecord, MAX_SHADOW_VIEWS,
    NO_VIEW, POINT_LIGHT, SPOT_LIGHT, ShadowViewRecord,
};
use super::stage_shaders::STAGE_SHADERS;
use super::surfel_groups::{GroupRecord, Levels};
use super::surfel_shards::{Bounce, SampleColors};
use crate::emissive_discs::{EDGE_ANGLE, EDGE_SHARE, HIDDEN_SHARE, MOST_DISCS, SMALLEST_DISC};
use crate::frame::{
    BLOCK, BORDER_SLOT, BorderRecord, ChangeTerm, FillRecord, NEXT_TO_NOTHING, PROBES_A_TURN, PROBES_SHARE,
    URGENCIES, URGENCY_STEP_BITS, Waiting,
};
use crate::grid_light::LAMP_PASSES;
use crate::object_spheres::{EVEN_REACH, FADE_FROM, OPACITY};
use crate::{ClusterExtent, EmissiveDisc, FADE_STEPS, ObjectSphere};

/// All shaders of the crate, by the name of their function.
fn sources() -> Vec<(&'static str, String)> {
    let stages = STAGE_SHADERS.iter().map(|shader| (shader.entry_point, shader.source()));
    let in_air = [
        shaders::GRID,
        shaders::OBJECT_SPHERES,
        "@compute @workgroup_size(1) fn look_up() {
            var light = light_in_air(vec3f(0.0), vec3f(0.0));
            _ = irradiance_from(&light, vec3f(0.0));
            _ = object_influence_on_scene(vec3f(0.0), vec3f(0.0), vec3f(0.0));
        }",
    ];
    stages.chain([("cut_holes", shaders::cast_shadows()), ("look_up", in_air.concat())]).collect()
}

fn modules() -> Vec<(&'static str, Module)> {
    let module =
        |(name, source): (_, String)| (name, parse(&source).unwrap_or_else(|error| panic!("{error}")));
    sources().into_iter().map(module).collect()
}

#[test]
fn all_shaders_are_valid_and_have_their_function() {
    for (entry_point, module) in modules() {
        let functions: Vec<&str> = module.entry_points.iter().map(|point| point.name.as_str()).collect();
        assert!(functions.contains(&entry_point), "{entry_point} is not among {functions:?}");
    }
}

#[test]
fn all_shaders_keep_to_the_limits_of_webgpu() {
    let limits = wgpu::Limits::default();
    for (entry_point, module) in modules() {
        let storage = |space: &naga::AddressSpace| matches!(space, naga::AddressSpace::Storage { .. });
        let buffers = module.global_variables.iter().filter(|(_, variable)| storage(&variable.space)).count();
        assert!(buffers <= limits.max_storage_buffers_per_shader_stage as usize, "{entry_point}: {buffers}");
        let shared: u32 = module
            .global_variables
            .iter()
            .filter(|(_, variable)| variable.space == naga::AddressSpace::WorkGroup)
            .map(|(_, variable)| module.types[variable.ty].inner.size(module.to_ctx()))
            .sum();
        assert!(shared <= limits.max_compute_workgroup_storage_size, "{entry_point}: {shared} bytes");
        for point in &module.entry_points {
            let invocations: u32 = point.workgroup_size.iter().product();
            assert!(invocations <= limits.max_compute_invocations_per_workgroup, "{entry_point}");
        }
    }
}

#[test]
fn all_shaders_can_be_written_for_direct3d_and_metal() {
    for (entry_point, module) in modules() {
        write_for_direct3d_and_metal(&module).unwrap_or_else(|error| panic!("{entry_point}: {error}"));
    }
}

#[test]
fn shaders_of_the_page_for_renderers_compile_with_those_that_they_name() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/your-renderer.md");
    let page = std::fs::read_to_string(page).unwrap();
    let blocks: Vec<&str> = page.split("```wgsl\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
    assert_eq!(blocks.len(), 3);
    for block in blocks {
        let grid = if block.contains("shaders::GRID") { shaders::GRID } else { "" };
        let spheres = if block.contains("shaders::OBJECT_SPHERES") { shaders::OBJECT_SPHERES } else { "" };
        parse(&[grid, spheres, block].concat()).unwrap_or_else(|error| panic!("{block}\n{error}"));
        // Negative control: what a block names is needed.
        assert!(grid.is_empty() || parse(block).is_err(), "{block}");
    }
}

#[test]
fn what_other_languages_lack_is_noticed() {
    let written = |declaration: &str| {
        let function = "@compute @workgroup_size(1) fn fill() { value = WIDTH; }";
        let source = format!("{declaration} WIDTH = 4u; var<private> value: u32; {function}");
        write_for_direct3d_and_metal(&parse(&source).unwrap())
    };
    written("const").unwrap();
    assert!(written("override").is_err(), "neither has constants that pipelines set");
}

/// Each constant has one number.
fn constants(list: &[(&'static str, f64)]) -> Vec<(&'static str, Vec<f64>)> {
    list.iter().map(|(name, value)| (*name, vec![*value])).collect()
}

fn records() -> Vec<(&'static str, Layout)> {
    vec![
        record!(LitPoint as "LitPoint" { position, share, normal, padding }),
        record!(SampleColors as "SampleColors" { base_color, emission, material }),
        record!(Bounce as "Bounce" { reflectance, receiver }),
        record!(MaterialColors as "MaterialColors" { base_color, emission }),
        record!(GroupRecord as "GroupRecord" { first, second, first_weight, signal }),
        record!(Levels as "Levels" { first_group, level_count }),
        record!(SignalShape as "SignalShape" { scalar_signals, coefficients, rays, probes }),
        record!(ProbeRecord as "ProbeRecord" { rays, coefficients, first_weight }),
        record!(ClusterExtent as "ClusterExtent" { rank, columns, receivers, solid, fade, fill }),
        record!(FillRecord as "FillRecord" { sources, weights }),
        record!(Ranks as "Ranks" { f16, snorm8, snorm4 }),
        record!(ClusterRecord as "ClusterRecord" {
            number, first_receiver, first_texel, receiver_count, first_column, column_count, receiver_ranks,
            signal_ranks, receiver_basis_offset, signal_basis_offset, first_row, exponent_offset,
        }),
        record!(GatherTask as "GatherTask" { cluster, first }),
        record!(BorderReceiver as "BorderReceiver" {
            receiver, texel, first_record, record_count, cluster, index,
        }),
        record!(BorderRecord as "BorderRecord" { neighbor, beyond, across }),
        record!(TexelCopy as "TexelCopy" { texel, receiver, cluster }),
        record!(FrameFlags as "FrameFlags" { is_quiet, any_dirty, any_touched }),
        record!(WorkRules as "WorkRules" {
            longest_wait, most_words, surfels, first_emitter, scalar_signals, blocks, bands, coefficients,
            probe_turn, probe_turns,
        }),
        record!(ClusterWish as "ClusterWish" { wanted, words, threshold }),
        record!(ProbeWish as "ProbeWish" { wanted, threshold }),
        record!(ProbeState as "ProbeState" { held, waiting }),
        record!(Waiting as "Waiting" { change, light, frames, urgency }),
        record!(ChangeTerm as "ChangeTerm" { source, weight }),
        record!(LightRecord as "Light" {
            position, kind, direction, first_view, intensity, cone_scale, cos_outer, view_count,
            inverse_squared_range, eye_view,
        }),
        record!(LightsRecord as "Lights" { list, count, unused }),
        record!(ShadowViewRecord as "ShadowView" { clip_from_world, axis, texel_width }),
        record!(PlacementRecord as "Placement" { rows, number, light_offset, unused }),
        record!(GridRecord as "Grid" {
            origin, rows, last, kind, spacing, off_surface, counts, sphere_count, cell_blocks, polynomial, axes,
        }),
        record!(ObjectSphere as "ObjectSphere" { center, radius, albedo, reach, object, hides, is_core, unused }),
        record!(EmissiveDisc as "EmissiveDisc" { center, area, normal, padding, radiance, padding_2 }),
        record!(DiscsRecord as "EmissiveDiscs" { discs, count }),
        record!(GridCell as "GridCell" { planes, corners }),
        record!(GridBlockRecord as "GridBlock" { present, first, level, nearest }),
        record!(AlphaTestRecord as "AlphaTest" { factor, cutoff, unused }),
    ]
}

fn host_constants() -> Vec<(&'static str, Vec<f64>)> {
    constants(&[
        ("NONE", f64::from(NONE)),
        ("BLOCK_EDGE", f64::from(BLOCK_EDGE)),
        ("MAX_GRID_LEVELS", f64::from(MAX_GRID_LEVELS)),
        ("MAX_GRID_CORNERS", f64::from(8 * MAX_GRID_LEVELS)),
        ("GRID_SH2", f64::from(GRID_SH2)),
        ("GRID_AXES", f64::from(GRID_AXES)),
        ("GRID_COSINES", f64::from(GRID_COSINES)),
        ("MAX_GRID_ROWS", MAX_GRID_ROWS as f64),
        ("FADE_FROM", f64::from(FADE_FROM)),
        ("EVEN_REACH", f64::from(EVEN_REACH)),
        ("OPACITY", f64::from(OPACITY)),
        ("MOST_DISCS", MOST_DISCS as f64),
        ("SMALLEST_DISC", f64::from(SMALLEST_DISC)),
        ("EDGE_SHARE", f64::from(EDGE_SHARE)),
        ("EDGE_ANGLE", f64::from(EDGE_ANGLE)),
        ("HIDDEN_SHARE", f64::from(HIDDEN_SHARE)),
        ("HALF_TURN", f64::from(std::f32::consts::PI)),
        ("LAMP_PASSES", f64::from(LAMP_PASSES)),
        ("LARGEST", f16::MAX.to_f64()),
        ("INVERSE_PI", f64::from(std::f32::consts::FRAC_1_PI)),
        ("GAIN_STEPS", f64::from(GAIN_STEPS)),
        ("EXPONENT_STEPS", f64::from(EXPONENT_STEPS)),
        ("STEEPEST_SLOPE", f64::from(STEEPEST_SLOPE)),
        ("BORDER_SLOT", f64::from(BORDER_SLOT)),
        ("SOURCE_SIGNALS", BLOCK as f64),
        ("URGENCIES", URGENCIES as f64),
        ("URGENCY_STEP_BITS", f64::from(URGENCY_STEP_BITS)),
        ("NEXT_TO_NOTHING", f64::from(NEXT_TO_NOTHING)),
        ("PROBES_SHARE", f64::from(PROBES_SHARE)),
        ("PROBES_A_TURN", f64::from(PROBES_A_TURN)),
        ("Y00", f64::from(Y00)),
        ("MOST_BANDS", f64::from(MAX_SH_DEGREE + 1)),
        ("BLOCK", f64::from(GATHER_BLOCK)),
        ("FADE_STEPS", f64::from(FADE_STEPS)),
        ("PROBES", super::relight_probes::PROBES as f64),
        ("PANEL", super::relight_probes::PANEL as f64),
        ("MAX_LIGHTS", MAX_SHADOW_VIEWS as f64),
        ("MAX_SHADOW_VIEWS", MAX_SHADOW_VIEWS as f64),
        ("DIRECTIONAL_VIEWS_PER_SIDE", f64::from(DIRECTIONAL_VIEWS_PER_SIDE)),
        ("GUARD_TEXELS", f64::from(GUARD_TEXELS)),
        ("MAX_EYE_VIEWS", MAX_EYE_VIEWS as f64),
        ("EYE_VIEWS", EYE_VIEWS as f64),
        ("NO_VIEW", f64::from(NO_VIEW)),
        ("DIRECTIONAL_LIGHT", f64::from(DIRECTIONAL_LIGHT)),
        ("POINT_LIGHT", f64::from(POINT_LIGHT)),
        ("SPOT_LIGHT", f64::from(SPOT_LIGHT)),
    ])
}

fn partners() -> Partners {
    Partners {
        records: records(),
        constants: host_constants(),
        shader_only: &[
            // Names of the encodings; where each begins follows from the ranks.
            "F16",
            "SNORM8",
            "SNORM4",
            // How project_clusters divides its work.
            "LANES",
            "GROUPS",
            "TILE",
            // Compared with the host's by what comes of them.
            "SMALLEST_WEIGHT",
            "SMALLEST_LAMP",
            // No index of an object.
            "NO_OBJECT",
            // How shadow maps are looked up.
            "FILTER_REACH",
            "EYE_BLEND",
            "LEAST_BIAS",
            "STEEPEST",
            "CONTACT_RANGE",
            "LIT_SHARE_AT_WALLS",
        ],
        compared_elsewhere: &[],
    }
}

#[test]
fn every_struct_in_a_buffer_and_every_constant_has_a_partner() {
    assert_eq!(partners().compare(&sources()), Vec::<String>::new());
}

/// What [`Partners::compare`] says of one shader that uses a record and a constant.
fn compare_with(declarations: &str, constants: Vec<(&'static str, Vec<f64>)>) -> Vec<String> {
    let records = vec![record!(TexelCopy as "TexelCopy" { texel, receiver, cluster })];
    let source = format!(
        "{declarations}\n@group(0) @binding(0) var<storage, read> copies: array<TexelCopy>;\n\
         @compute @workgroup_size(64)\nfn copy() {{ _ = copies[0]; }}"
    );
    let partners = Partners { records, constants, shader_only: &[], compared_elsewhere: &[] };
    partners.compare(&[("copy", source)])
}

#[test]
fn wrong_and_missing_partners_are_noticed() {
    let right = "struct TexelCopy { texel: u32, receiver: u32, cluster: u32 }";
    let steps = || constants(&[("STEPS", 8.0)]);
    assert!(compare_with(right, Vec::new()).is_empty());
    assert!(compare_with(&format!("const STEPS: u32 = 8u;\n{right}"), steps()).is_empty());
    for wrong in [
        "struct TexelCopy { receiver: u32, texel: u32, cluster: u32 }",
        "struct TexelCopy { texel: u32 }",
        "struct TexelCopy { texel: u32, receiver: vec2u, cluster: u32 }",
        "struct TexelCopy { texel: u32, receiver: u32, cluster: u32, more: u32 }",
        "struct Inner { texel: u32 }\nstruct TexelCopy { texel: Inner, receiver: u32, cluster: u32 }",
        "const STEPS: u32 = 8u;\nstruct TexelCopy { texel: u32, receiver: u32, cluster: u32 }",
        "const STEPS = 8.0;\nstruct TexelCopy { texel: u32, receiver: u32, cluster: u32 }",
        "const WORKGROUP: u32 = 32u;\nstruct TexelCopy { texel: u32, receiver: u32, cluster: u32 }",
    ] {
        assert!(!compare_with(wrong, Vec::new()).is_empty(), "{wrong}");
    }
    assert!(!compare_with(&format!("const STEPS: u32 = 7u;\n{right}"), steps()).is_empty(), "another value");
    assert!(!compare_with(&format!("const STEPS = 8.0;\n{right}"), steps()).is_empty(), "a value of no type");
    assert!(!compare_with(right, steps()).is_empty(), "a partner that no shader declares");
}

#[test]
fn layouts_leave_out_what_fills_gaps() {
    let with = Layout::new(&[("a", 0, 4), ("unused", 4, 12)], 16);
    assert_eq!(with, Layout::new(&[("a", 0, 4)], 16));
    assert_ne!(with, Layout::new(&[("a", 0, 4)], 4));
}

#[test]
fn workgroups_have_the_size_that_dispatches_count_with() {
    for (size, entry_points) in [
        (super::light_surfels::WORKGROUP, &["light_directly", "shade_surfels", "light_surfels"][..]),
        (super::blend_borders::WORKGROUP, &["keep_unblended", "blend_borders"]),
        (super::dilate_lightmap::WORKGROUP, &["dilate_lightmap"]),
        (super::reduce_lightmap::WORKGROUP.pow(2) as usize, &["reduce_lightmap"]),
        (super::surfel_groups::WORKGROUP, &["group_level", "group_levels"]),
        (
            super::choose_work::WORKGROUP,
            &[
                "find_dirty_blocks",
                "choose_probes",
                "choose_clusters",
                "admit_clusters",
                "touch_clusters",
                "note_light",
            ],
        ),
        (BLOCK, &["measure_signals"]),
        (GATHER_BLOCK as usize, &["fill_receivers"]),
    ] {
        for entry_point in entry_points {
            let (_, module) = modules().into_iter().find(|(name, _)| name == entry_point).unwrap();
            assert_eq!(workgroup_size(&module, entry_point) as usize, size, "{entry_point}");
        }
    }
}
