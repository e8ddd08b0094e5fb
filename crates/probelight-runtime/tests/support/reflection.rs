//! What shaders declare, held against what the host has. No GPU needed.
#![allow(dead_code, reason = "each test uses a part")]

use std::collections::BTreeMap;

use naga::back::{hlsl, msl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, Expression, Handle, Literal, Module, Type, TypeInner};

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

/// Name, offset and size of each field, and the size of the whole; without fields called `unused`, which fill gaps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    fields: Vec<(String, usize, usize)>,
    size: usize,
}

impl Layout {
    pub(crate) fn new(fields: &[(&str, usize, usize)], size: usize) -> Self {
        let used = fields.iter().filter(|(name, ..)| *name != "unused");
        let fields = used.map(|(name, offset, size)| ((*name).to_owned(), *offset, *size)).collect();
        Self { fields, size }
    }
}

/// Bytes of the field that `field` takes.
pub(crate) fn size_behind<S, F>(_field: fn(&S) -> &F) -> usize {
    size_of::<F>()
}

/// The name in WGSL and the [`Layout`] of a `#[repr(C)]` struct.
macro_rules! record {
    ($type:ty as $name:literal { $($field:ident),* $(,)? }) => {{
        let fields = [$((
            stringify!($field),
            std::mem::offset_of!($type, $field),
            $crate::gpu::reflection::size_behind(|record: &$type| &record.$field),
        )),*];
        ($name, $crate::gpu::reflection::Layout::new(&fields, size_of::<$type>()))
    }};
}
pub(crate) use record;

/// What the host has of what shaders declare.
pub(crate) struct Partners {
    /// Structs that lie in buffers.
    pub(crate) records: Vec<(&'static str, Layout)>,
    /// Constants with their numbers.
    pub(crate) constants: Vec<(&'static str, Vec<f64>)>,
    /// Constants that the host has no use for.
    pub(crate) shader_only: &'static [&'static str],
    /// Files that are part of some shaders, and whose declarations another test compares.
    pub(crate) compared_elsewhere: &'static [&'static str],
}

impl Partners {
    /// What is wrong with shaders, given by name and source: structs in buffers and constants that differ from the host's or
    /// have no partner, and partners that no shader declares.
    pub(crate) fn compare(&self, shaders: &[(&str, String)]) -> Vec<String> {
        let mut wrong = Vec::new();
        let mut declared = Vec::new();
        for (shader, source) in shaders {
            let module = match parse(source) {
                Ok(module) => module,
                Err(error) => {
                    wrong.push(format!("{shader}: {error}"));
                    continue;
                }
            };
            let structs = structs_in_buffers(&module).into_iter().map(|(name, layout)| {
                let expected = self.records.iter().find(|(partner, _)| *partner == name);
                let is_same = expected.is_some_and(|(_, expected)| *expected == layout);
                let problem = format!("struct {name} is {layout:?}, here {expected:?}");
                (name, is_same, problem)
            });
            let constants = constant_names(source).map(|name| {
                let value = constant(&module, name);
                let expected = self.constants.iter().find(|(partner, _)| *partner == name);
                let is_same = match expected {
                    Some((_, expected)) => value.as_ref() == Some(expected),
                    None if name == "WORKGROUP" => {
                        value == Some(vec![f64::from(workgroup_size(&module, shader))])
                    }
                    None => self.shader_only.contains(&name),
                };
                (name.to_owned(), is_same, format!("const {name} is {value:?}, here {expected:?}"))
            });
            for (name, is_same, problem) in structs.chain(constants) {
                if !is_same && !self.is_compared_elsewhere(&name) {
                    wrong.push(format!("{shader}: {problem}"));
                }
                declared.push(name);
            }
        }
        let records = self.records.iter().map(|(name, _)| *name);
        let partners = records.chain(self.constants.iter().map(|(name, _)| *name));
        let forgotten = partners.chain(self.shader_only.iter().copied());
        let forgotten = forgotten.filter(|name| !declared.iter().any(|declared| declared == name));
        wrong.extend(forgotten.map(|name| format!("no shader declares {name}")));
        wrong
    }

    fn is_compared_elsewhere(&self, name: &str) -> bool {
        let declares = |source: &&str| {
            constant_names(source).any(|constant| constant == name)
                || source
                    .lines()
                    .any(|line| line.strip_prefix("struct ").is_some_and(|rest| rest.starts_with(name)))
        };
        self.compared_elsewhere.iter().any(declares)
    }
}

/// Names of the constants that a source declares: naga drops those whose type is open, such as 1.5.
fn constant_names(source: &str) -> impl Iterator<Item = &str> {
    let name = |line: &'_ str| Some(line.strip_prefix("const ")?.split([' ', ':', '=']).next()?.len());
    source.lines().filter_map(move |line| name(line).map(|length| &line["const ".len()..][..length]))
}

/// All structs that lie in buffers, and those within them.
fn structs_in_buffers(module: &Module) -> BTreeMap<String, Layout> {
    let mut found = BTreeMap::new();
    for (_, variable) in module.global_variables.iter() {
        if matches!(variable.space, AddressSpace::Uniform | AddressSpace::Storage { .. }) {
            add_structs(module, variable.ty, &mut found);
        }
    }
    found
}

fn add_structs(module: &Module, kind: Handle<Type>, found: &mut BTreeMap<String, Layout>) {
    let Type { name, inner } = &module.types[kind];
    match inner {
        TypeInner::Array { base, .. } => add_structs(module, *base, found),
        TypeInner::Struct { members, span } => {
            let size =
                |member: &naga::StructMember| module.types[member.ty].inner.size(module.to_ctx()) as usize;
            let field = |member: &'_ naga::StructMember| {
                (member.name.clone().unwrap_or_default(), member.offset as usize, size(member))
            };
            let fields: Vec<(String, usize, usize)> = members.iter().map(field).collect();
            let fields: Vec<(&str, usize, usize)> =
                fields.iter().map(|(name, offset, size)| (name.as_str(), *offset, *size)).collect();
            found.insert(name.clone().unwrap_or_default(), Layout::new(&fields, *span as usize));
            members.iter().for_each(|member| add_structs(module, member.ty, found));
        }
        _ => {}
    }
}

/// The numbers of a constant, in order.
pub(crate) fn constant(module: &Module, name: &str) -> Option<Vec<f64>> {
    let (_, constant) =
        module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some(name))?;
    numbers(module, constant.init)
}

fn numbers(module: &Module, expression: Handle<Expression>) -> Option<Vec<f64>> {
    match &module.global_expressions[expression] {
        Expression::Literal(Literal::U32(value)) => Some(vec![f64::from(*value)]),
        Expression::Literal(Literal::F32(value)) => Some(vec![f64::from(*value)]),
        Expression::Compose { components, .. } => {
            let parts: Option<Vec<_>> = components.iter().map(|part| numbers(module, *part)).collect();
            Some(parts?.concat())
        }
        _ => None,
    }
}

/// Invocations of a workgroup of a compute shader.
pub(crate) fn workgroup_size(module: &Module, entry_point: &str) -> u32 {
    let point = module.entry_points.iter().find(|point| point.name == entry_point);
    point.map_or(0, |point| point.workgroup_size.iter().product())
}
