//! What can be tested of the shaders without a GPU.

use std::collections::HashMap;

use naga::{Literal, Module, TypeInner};

use super::cluster_shards::{ClusterRecord, GATHER_BLOCK, GatherTask};
use probelight_asset::BorderBlend;

use super::blend_borders::BorderReceiver;
use super::dilate_lightmap::TexelCopy;
use super::frame_buffers::SignalShape;
use super::light_surfels::MaterialColors;
use super::shadow_views::{LightRecord, LightsRecord, ShadowViewRecord};
use super::stage_shaders::STAGE_SHADERS;
use super::surfel_groups::{GroupRecord, Levels};
use super::surfel_shards::{Bounce, SampleColors, SamplePlace};
use super::wgsl_layout::{parse, write_for_direct3d_and_metal};

fn stage_modules() -> Vec<(&'static str, Module)> {
    let module = |shader: &super::stage_shaders::Shader| {
        (shader.entry_point, parse(&shader.source()).unwrap_or_else(|error| panic!("{error}")))
    };
    STAGE_SHADERS.iter().map(module).collect()
}

#[test]
fn all_shaders_are_valid_and_have_their_function() {
    for (entry_point, module) in stage_modules() {
        let functions: Vec<&str> = module.entry_points.iter().map(|point| point.name.as_str()).collect();
        assert!(functions.contains(&entry_point), "{entry_point} is not among {functions:?}");
    }
}

#[test]
fn all_shaders_keep_to_the_limits_of_webgpu() {
    let limits = wgpu::Limits::default();
    for (entry_point, module) in stage_modules() {
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
    for (entry_point, module) in stage_modules() {
        write_for_direct3d_and_metal(&module).unwrap_or_else(|error| panic!("{entry_point}: {error}"));
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

/// Name, offset and size of each field, and the size of the whole.
type Layout = (Vec<(String, usize, usize)>, usize);

/// All structs of a module.
fn structs_of(module: &Module) -> HashMap<String, Layout> {
    let layout = |(_, kind): (_, &naga::Type)| {
        let (Some(name), TypeInner::Struct { members, span }) = (&kind.name, &kind.inner) else {
            return None;
        };
        let field = |member: &naga::StructMember| {
            let size = module.types[member.ty].inner.size(module.to_ctx()) as usize;
            (member.name.clone().unwrap_or_default(), member.offset as usize, size)
        };
        Some((name.clone(), (members.iter().map(field).collect(), *span as usize)))
    };
    module.types.iter().filter_map(layout).collect()
}

/// Bytes of the field that `field` takes.
fn size_behind<S, F>(_field: fn(&S) -> &F) -> usize {
    size_of::<F>()
}

/// Compares a struct of the host with all shaders that declare one of that name; says what differs. A field that is
/// not listed differs, too.
fn compare(modules: &[(&str, Module)], name: &str, expected: &Layout) -> Result<(), String> {
    let declarations: Vec<(&str, Layout)> = modules
        .iter()
        .filter_map(|(shader, module)| Some((*shader, structs_of(module).remove(name)?)))
        .collect();
    if declarations.is_empty() {
        return Err(format!("no shader declares {name}"));
    }
    match declarations.into_iter().find(|(_, layout)| layout != expected) {
        Some((shader, layout)) => Err(format!("{name} in {shader} is {layout:?}, here {expected:?}")),
        None => Ok(()),
    }
}

/// [`compare`] for a `#[repr(C)]` struct and its name and fields in WGSL.
macro_rules! compare {
    ($modules:expr, $type:ty as $name:literal { $($field:ident),* }) => {{
        let fields = [$((
            stringify!($field).to_owned(),
            std::mem::offset_of!($type, $field),
            size_behind(|record: &$type| &record.$field),
        )),*];
        compare($modules, $name, &(fields.to_vec(), size_of::<$type>()))
    }};
}

#[test]
fn structs_are_the_same_on_both_sides() {
    let m = &stage_modules();
    let results = [
        compare!(m, SamplePlace as "SamplePlace" { position, padding_a, normal, padding_b }),
        compare!(m, SampleColors as "SampleColors" { base_color, emission, material }),
        compare!(m, Bounce as "Bounce" { reflectance, receiver }),
        compare!(m, MaterialColors as "MaterialColors" { base_color, emission }),
        compare!(m, GroupRecord as "GroupRecord" { first, second, first_weight, signal }),
        compare!(m, Levels as "Levels" { first_group, level_count }),
        compare!(m, SignalShape as "SignalShape" { scalar_signals, coefficients, rays, probes }),
        compare!(m, ClusterRecord as "ClusterRecord" {
            first_receiver, first_texel, receiver_count, first_column, column_count, receiver_ranks, signal_ranks,
            receiver_basis_offset, signal_basis_offset, first_row, exponent_offset
        }),
        compare!(m, GatherTask as "GatherTask" { cluster, first }),
        compare!(m, BorderReceiver as "BorderReceiver" { receiver, texel, first_record, record_count }),
        compare!(m, BorderBlend as "BorderBlend" { receiver, neighbor, beyond }),
        compare!(m, TexelCopy as "TexelCopy" { texel, receiver }),
        compare!(m, LightRecord as "Light" {
            position, kind, direction, first_view, intensity, cone_scale, cos_outer, view_count,
            inverse_squared_range, unused
        }),
        compare!(m, ShadowViewRecord as "ShadowView" { clip_from_world, axis, texel_width }),
    ];
    for result in results {
        result.unwrap();
    }
    // The end of `LightsRecord` fills it up to a multiple of sixteen bytes, which WGSL does by itself.
    let lights = m.iter().find_map(|(_, module)| structs_of(module).remove("Lights")).unwrap();
    assert_eq!(lights.1, size_of::<LightsRecord>());
    assert_eq!(lights.0[1].1, std::mem::offset_of!(LightsRecord, count));
}

#[test]
fn the_comparison_of_structs_notices_a_wrong_field() {
    let compare_with = |source: &str| {
        let modules = [("wrong", parse(source).unwrap())];
        compare!(&modules, TexelCopy as "TexelCopy" { texel, receiver })
    };
    for wrong in [
        "struct TexelCopy { receiver: u32, texel: u32 }",
        "struct TexelCopy { texel: u32 }",
        "struct TexelCopy { texel: u32, receiver: vec2u }",
        "struct TexelCopy { texel: u32, receiver: u32, more: u32 }",
        "struct Another { texel: u32, receiver: u32 }",
    ] {
        assert!(compare_with(wrong).is_err(), "{wrong}");
    }
    compare_with("struct TexelCopy { texel: u32, receiver: u32 }").unwrap();
}

/// Value of an integer constant of a shader.
fn constant(entry_point: &str, name: &str) -> u32 {
    let (_, module) = stage_modules().into_iter().find(|(shader, _)| *shader == entry_point).unwrap();
    let (_, constant) =
        module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name)).unwrap();
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(Literal::U32(value)) => value,
        ref other => panic!("{name} of {entry_point} is {other:?}"),
    }
}

fn workgroup_size(entry_point: &str) -> u32 {
    let (_, module) = stage_modules().into_iter().find(|(shader, _)| *shader == entry_point).unwrap();
    let point = module.entry_points.iter().find(|point| point.name == entry_point).unwrap();
    point.workgroup_size.iter().product()
}

#[test]
fn constants_are_the_same_on_both_sides() {
    assert_eq!(constant("gather_receivers", "BLOCK"), GATHER_BLOCK);
    assert_eq!(constant("relight_probes", "PROBES") as usize, super::relight_probes::PROBES);
    assert_eq!(constant("relight_probes", "PANEL") as usize, super::relight_probes::PANEL);
    assert_eq!(constant("light_surfels", "NONE"), probelight_asset::NONE);
    for entry_point in ["light_samples", "shade_surfels", "light_surfels"] {
        assert_eq!(workgroup_size(entry_point) as usize, super::light_surfels::WORKGROUP);
    }
    for entry_point in ["blend_borders", "store_blended"] {
        assert_eq!(workgroup_size(entry_point) as usize, super::blend_borders::WORKGROUP);
    }
    assert_eq!(workgroup_size("dilate_lightmap") as usize, super::dilate_lightmap::WORKGROUP);
    assert_eq!(workgroup_size("reduce_lightmap"), super::reduce_lightmap::WORKGROUP.pow(2));
    for entry_point in ["group_level", "group_levels"] {
        assert_eq!(workgroup_size(entry_point) as usize, super::surfel_groups::WORKGROUP);
    }
    for entry_point in ["group_level", "relight_probes", "project_clusters", "gather_receivers"] {
        assert_eq!(workgroup_size(entry_point), constant(entry_point, "WORKGROUP"), "{entry_point}");
    }
}
