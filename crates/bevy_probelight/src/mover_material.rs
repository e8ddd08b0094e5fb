//! A material that reads the light of free space: Bevy's standard material, extended.

use bevy::app::App;
use bevy::asset::{Asset, Assets, Handle, uuid_handle};
use bevy::ecs::entity::Entity;
use bevy::ecs::system::SystemParamItem;
use bevy::ecs::system::lifetimeless::SRes;
use bevy::pbr::{ExtendedMaterial, MaterialExtension, MaterialPlugin, StandardMaterial};
use bevy::reflect::TypePath;
use bevy::render::render_resource::{
    AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingResources, Buffer,
    BufferInitDescriptor, BufferUsages, OwnedBindingResource, ShaderStages, UnpreparedBindGroup,
};
use bevy::render::renderer::RenderDevice;
use bevy::shader::{Shader, ShaderRef};
use probelight_runtime::gpu::shaders;

use crate::render::RenderScenes;

/// Bevy's standard material with the soft light of the place where the surface is. [`ProbelightMover`](crate::ProbelightMover)
/// makes them.
pub type GridLitMaterial = ExtendedMaterial<StandardMaterial, GridLight>;

/// Takes soft light from the grid of a scene, in place of lightmap, ambient light and irradiance volumes.
///
/// The fragment shader looks up the eight vertices around the surface, with the masks that keep light behind walls, and reads
/// them for the mapped normal (diffuse) and the mirrored direction (gloss, as wide as a cosine lobe). It binds five storage
/// buffers beside Bevy's own.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct GridLight {
    /// The entity with the scene.
    pub scene: Entity,
    /// Columns of the matrix from the world to the scene's space: a rotation, an even scale and a translation.
    pub scene_from_world: [[f32; 4]; 4],
}

/// Bindings of the grid in the material's group: its own numbers and this; the matrix comes behind them.
const FIRST_BINDING: u32 = 110;
const GRID_BINDINGS: u32 = 6;

const SHADER: Handle<Shader> = uuid_handle!("b3f4c1ce-64d5-4c49-9d0c-3a1f9f2c8f0e");

/// Storage buffers that a fragment shader of Bevy's may need beside the grid's five.
const STORAGE_BUFFERS: u32 = 12;

/// Whether materials on that device may read the grid.
pub(crate) fn is_supported(device: &RenderDevice) -> bool {
    device.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
}

pub(crate) fn add(app: &mut App) {
    if let Some(mut shaders) = app.world_mut().get_resource_mut::<Assets<Shader>>() {
        // A handle with an identifier of its own is never refused.
        let _inserted =
            shaders.insert(SHADER.id(), Shader::from_wgsl(source(), "bevy_probelight/mover.wgsl"));
    }
    app.add_plugins(MaterialPlugin::<GridLitMaterial>::default());
}

/// The runtime's grid in the group of Bevy's materials, and the fragment shader.
fn source() -> String {
    let group =
        |binding: u32| format!("@group(#{{MATERIAL_BIND_GROUP}}) @binding({})", FIRST_BINDING + binding);
    let mut grid = shaders::GRID.to_owned();
    for binding in 0..GRID_BINDINGS {
        grid = grid.replace(&format!("@group(3) @binding({binding})"), &group(binding));
    }
    let matrix = format!("{} var<uniform> scene_from_world: mat4x4f;\n", group(GRID_BINDINGS));
    [IMPORTS, &grid, &matrix, include_str!("mover.wgsl")].concat()
}

const IMPORTS: &str = "\
#import bevy_pbr::{
    forward_io::{VertexOutput, FragmentOutput},
    lighting::{EnvBRDFApprox, F_AB},
    mesh_view_bindings::view,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{
        alpha_discard, apply_pbr_lighting, calculate_F0, calculate_diffuse_color, main_pass_post_lighting_processing,
    },
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
}
";

impl MaterialExtension for GridLight {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }
}

impl AsBindGroup for GridLight {
    type Data = ();
    type Param = SRes<RenderScenes>;

    fn label() -> &'static str {
        "grid-lit material"
    }

    fn bind_group_data(&self) {}

    fn unprepared_bind_group(
        &self,
        _: &BindGroupLayout,
        device: &RenderDevice,
        scenes: &mut SystemParamItem<'_, '_, Self::Param>,
        _: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        // Where the device could not hold the scene, free space is dark.
        let scene = scenes.scenes.get(&self.scene);
        let grid: Vec<Buffer> = match scene {
            Some(scene) => scene.runtime.grid().grid_buffers().iter().cloned().map(Buffer::from).collect(),
            None if scenes.is_pending(self.scene) => return Err(AsBindGroupError::RetryNextUpdate),
            None => (0..GRID_BINDINGS).map(|binding| darkness(device, binding)).collect(),
        };
        let matrix = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("scene from world"),
            contents: bytemuck::bytes_of(&self.scene_from_world),
            usage: BufferUsages::UNIFORM,
        });
        let bindings =
            (FIRST_BINDING..).zip(grid.into_iter().chain([matrix]).map(OwnedBindingResource::Buffer));
        Ok(UnpreparedBindGroup { bindings: BindingResources(bindings.collect()) })
    }

    fn bind_group_layout_entries(_: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding: FIRST_BINDING + binding,
            visibility: ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let is_uniform = |binding| binding == 0 || binding == GRID_BINDINGS;
        let ty = |binding| if is_uniform(binding) { wgpu::BufferBindingType::Uniform } else { storage };
        (0..=GRID_BINDINGS).map(|binding| entry(binding, ty(binding))).collect()
    }
}

/// A grid without vertices.
fn darkness(device: &RenderDevice, binding: u32) -> Buffer {
    let usage = if binding == 0 { BufferUsages::UNIFORM } else { BufferUsages::STORAGE };
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("no grid"),
        contents: &[0; 1024],
        usage,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_is_moved_to_the_materials_group() {
        let source = source();
        assert!(!source.contains("@group(3)"), "a binding of the grid was left behind");
        for binding in FIRST_BINDING..=FIRST_BINDING + GRID_BINDINGS {
            let wanted = format!("@group(#{{MATERIAL_BIND_GROUP}}) @binding({binding})");
            assert_eq!(source.matches(&wanted).count(), 1, "{wanted}");
        }
    }
}
