//! What a shader declares: structs, constants, and whether it is valid. No GPU needed.
#![allow(dead_code, reason = "each test uses a part")]

use naga::back::{hlsl, msl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Literal, Module, TypeInner};

/// Parses a shader and checks that it is valid with nothing but WebGPU's core.
pub(crate) fn parse(source: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    validate(&module, source)?;
    Ok(module)
}

fn validate(module: &Module, source: &str) -> Result<ModuleInfo, String> {
    // Half floats packed in words are part of the core, unlike arithmetic with them.
    let core = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    Validator::new(ValidationFlags::all(), core)
        .validate(module)
        .map_err(|error| error.emit_to_string(source))
}

/// Checks that a shader can be written for Direct3D and Metal, which get it in languages of their own and say no to
/// some valid WGSL.
pub(crate) fn write_for_direct3d_and_metal(module: &Module) -> Result<(), String> {
    let info = validate(module, "")?;
    let mut for_direct3d = String::new();
    let (options, pipeline) = (hlsl::Options::default(), hlsl::PipelineOptions::default());
    hlsl::Writer::new(&mut for_direct3d, &options, &pipeline)
        .write(module, &info, None)
        .map_err(|error| format!("Direct3D: {error}"))?;
    // Version 2.0 is of macOS 10.13, 2017.
    let options = msl::Options { lang_version: (2, 0), ..msl::Options::default() };
    let pipeline = msl::PipelineOptions::default();
    let (for_metal, _) =
        msl::write_string(module, &info, &options, &pipeline).map_err(|error| format!("Metal: {error}"))?;
    let is_missing = |point: &&naga::EntryPoint| {
        ![&for_direct3d, &for_metal].iter().all(|text| text.contains(&point.name))
    };
    match module.entry_points.iter().find(is_missing) {
        Some(point) => Err(format!("{} is missing", point.name)),
        None => Ok(()),
    }
}

/// Name and offset of each field of a struct, and the size of the whole.
pub(crate) fn layout_of(module: &Module, name: &str) -> Option<(Vec<(String, usize)>, usize)> {
    module.types.iter().find_map(|(_, kind)| match &kind.inner {
        TypeInner::Struct { members, span } if kind.name.as_deref() == Some(name) => {
            let field = |member: &naga::StructMember| {
                (member.name.clone().unwrap_or_default(), member.offset as usize)
            };
            Some((members.iter().map(field).collect(), *span as usize))
        }
        _ => None,
    })
}

/// Value of a constant that is a whole number.
pub(crate) fn constant(module: &Module, name: &str) -> Option<u32> {
    let (_, constant) =
        module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(Literal::U32(value)) => Some(value),
        _ => None,
    }
}

/// Says what differs between a struct of a shader and the host's, given as name and offset of each field. Fields
/// called `unused` fill the host's struct where WGSL leaves a gap.
pub(crate) fn compare(
    module: &Module,
    name: &str,
    fields: &[(&str, usize)],
    size: usize,
) -> Result<(), String> {
    let (declared, span) = layout_of(module, name).ok_or(format!("no struct {name}"))?;
    let used = |(name, _): &&(&str, usize)| *name != "unused";
    let expected: Vec<(String, usize)> =
        fields.iter().filter(used).map(|(name, offset)| ((*name).to_owned(), *offset)).collect();
    let declared: Vec<_> = declared.into_iter().filter(|(name, _)| name != "unused").collect();
    if (&declared, span) == (&expected, size) {
        return Ok(());
    }
    Err(format!("{name}: {declared:?} of {span} bytes, here {expected:?} of {size}"))
}

/// Name and offset of each field, in order.
#[allow(unused_macros, reason = "each test uses a part")]
macro_rules! fields {
    ($record:ty: $($field:ident)*) => {
        &[$((stringify!($field), std::mem::offset_of!($record, $field))),*]
    };
}
pub(crate) use fields;
