//! What can be tested of the shaders without a GPU.

use std::collections::HashMap;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Literal, Module, TypeInner};

use super::cluster_shards::{ClusterRecord, GATHER_BLOCK, GatherTask};
use super::dilate_lightmap::TexelCopy;
use super::frame_buffers::SignalShape;
use super::light_surfels::MaterialColors;
use super::shared_struct::{SharedField, SharedStruct};
use super::stage_shaders::STAGE_SHADERS;
use super::surfel_groups::{GroupRecord, Levels};
use super::surfel_shards::{Bounce, SampleColors, SamplePlace};

fn parse(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)))
}

/// Fails where a shader would not compile, or needs more than WebGPU's core.
fn validate(source: &str) -> Result<Module, String> {
    let module = parse(source);
    // Half floats packed in words are part of the core, unlike arithmetic with them.
    let core = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let mut validator = Validator::new(ValidationFlags::all(), core);
    validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
    Ok(module)
}

fn stage_modules() -> Vec<(&'static str, Module)> {
    let module = |shader: &super::stage_shaders::Shader| {
        (shader.entry_point, validate(&shader.source()).unwrap_or_else(|error| panic!("{error}")))
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

/// Compares a struct with all shaders that declare it; says what differs.
fn compare<T: SharedStruct>(modules: &[(&str, Module)]) -> Result<(), String> {
    let expected: Vec<(String, usize, usize)> =
        T::FIELDS.iter().map(|SharedField { name, offset, size }| ((*name).into(), *offset, *size)).collect();
    let mut declarations = 0;
    for (entry_point, module) in modules {
        if let Some((fields, size)) = structs_of(module).get(T::NAME) {
            declarations += 1;
            if (fields, *size) != (&expected, size_of::<T>()) {
                return Err(format!("{} in {entry_point}: {fields:?}, here {expected:?}", T::NAME));
            }
        }
    }
    if declarations == 0 { Err(format!("no shader declares {}", T::NAME)) } else { Ok(()) }
}

#[test]
fn structs_are_the_same_on_both_sides() {
    let modules = stage_modules();
    let results = [
        compare::<SamplePlace>(&modules),
        compare::<SampleColors>(&modules),
        compare::<Bounce>(&modules),
        compare::<MaterialColors>(&modules),
        compare::<GroupRecord>(&modules),
        compare::<Levels>(&modules),
        compare::<SignalShape>(&modules),
        compare::<ClusterRecord>(&modules),
        compare::<GatherTask>(&modules),
        compare::<TexelCopy>(&modules),
    ];
    for result in results {
        result.unwrap();
    }
}

#[test]
fn the_comparison_of_structs_notices_a_wrong_field() {
    for wrong in [
        "struct TexelCopy { receiver: u32, texel: u32 }",
        "struct TexelCopy { texel: u32 }",
        "struct TexelCopy { texel: u32, receiver: vec2u }",
        "struct Another { texel: u32, receiver: u32 }",
    ] {
        assert!(compare::<TexelCopy>(&[("wrong", parse(wrong))]).is_err(), "{wrong}");
    }
    compare::<TexelCopy>(&[("right", parse("struct TexelCopy { texel: u32, receiver: u32 }"))]).unwrap();
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
    assert_eq!(workgroup_size("dilate_lightmap") as usize, super::dilate_lightmap::WORKGROUP);
    assert_eq!(workgroup_size("reduce_lightmap"), super::reduce_lightmap::WORKGROUP.pow(2));
    for entry_point in ["group_level", "group_levels"] {
        assert_eq!(workgroup_size(entry_point) as usize, super::surfel_groups::WORKGROUP);
    }
    for entry_point in ["group_level", "relight_probes", "project_clusters", "gather_receivers"] {
        assert_eq!(workgroup_size(entry_point), constant(entry_point, "WORKGROUP"), "{entry_point}");
    }
}
