//! Light for the renderers of others. `package/index.js` is what they call; it also hands devices and textures over, which
//! wgpu does not.

use std::sync::Arc;

use js_sys::{Array, Float32Array, Object, Reflect, Uint32Array};
use probelight_asset::{BakedScene, LitMesh};
use probelight_math::glam::{Vec2, Vec3};
use probelight_runtime::gpu::{GpuOptions, GpuRuntime};
use probelight_runtime::{FrameInput, SurfaceColors};
use probelight_scene::Setup;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};

/// A device that scenes are lit on.
#[wasm_bindgen]
pub struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// Opens the device that the browser's adapter hands out.
///
/// # Errors
/// If there is none.
#[wasm_bindgen]
pub async fn open() -> Result<Device, JsError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor::default()).await?;
    Ok(Device { device, queue })
}

#[wasm_bindgen]
impl Device {
    /// Uploads a baked file.
    ///
    /// # Errors
    /// If it is broken, or the device cannot hold it.
    pub async fn load(&self, bytes: &[u8]) -> Result<Scene, JsError> {
        let baked = Arc::new(BakedScene::from_bytes(bytes)?);
        let options = GpuOptions::default();
        let runtime = GpuRuntime::new_async(&self.device, &self.queue, Arc::clone(&baked), options).await?;
        Ok(Scene { runtime, baked })
    }
}

/// A scene and its light.
#[wasm_bindgen]
pub struct Scene {
    runtime: GpuRuntime,
    baked: Arc<BakedScene>,
}

#[wasm_bindgen]
impl Scene {
    /// Lights, sky, strength of emission and changed colours: the text of a setup file.
    ///
    /// # Errors
    /// If it breaks the rules of setup files; nothing is changed then.
    #[wasm_bindgen(js_name = setLights)]
    pub fn set_lights(&mut self, setup: &str) -> Result<(), JsError> {
        let setup = Setup::parse(setup, "the setup".as_ref())?;
        let colors = SurfaceColors::changed(&self.baked.scene, &setup.materials);
        self.runtime.set_lighting(setup.lighting)?;
        for (material, colors) in colors.iter().enumerate() {
            self.runtime.set_base_color(material, colors.base_color)?;
            self.runtime.set_emission(material, colors.emission)?;
        }
        Ok(())
    }

    /// The lights of the glTF file that was baked, as the text of a setup file.
    pub fn setup(&self) -> String {
        Setup::from_scene(&self.baked.scene).to_json()
    }

    /// Computes one frame's light on the device: one more bounce. Submits it; waits for nothing.
    pub fn frame(&mut self) {
        self.runtime.step(&FrameInput::default());
    }

    /// The scene's triangles, a mesh for each material: `name`, `baseColor` and `emission` (linear red, green, blue),
    /// `positions`, `normals`, `uvs`, `lightmapUvs`, `indices`.
    pub fn meshes(&self) -> Array {
        let materials = self.baked.scene.materials.iter().enumerate();
        materials
            .map(|(number, material)| {
                let mesh = LitMesh::of_material(&self.baked, number);
                let members: [(&str, JsValue); 8] = [
                    ("name", material.name.as_str().into()),
                    ("baseColor", floats(material.base_color.truncate().to_array()).into()),
                    ("emission", floats(material.emission.to_array()).into()),
                    ("positions", floats(mesh.positions.iter().flat_map(Vec3::to_array)).into()),
                    ("normals", floats(mesh.normals.iter().flat_map(Vec3::to_array)).into()),
                    ("uvs", floats(mesh.uvs.iter().flat_map(Vec2::to_array)).into()),
                    ("lightmapUvs", floats(mesh.lightmap_uvs.iter().flat_map(Vec2::to_array)).into()),
                    ("indices", Uint32Array::from(&mesh.indices[..]).into()),
                ];
                object(members)
            })
            .collect()
    }
}

fn floats(values: impl IntoIterator<Item = f32>) -> Float32Array {
    Float32Array::from(&values.into_iter().collect::<Vec<f32>>()[..])
}

fn object<const N: usize>(members: [(&str, JsValue); N]) -> JsValue {
    let object = Object::new();
    for (name, value) in members {
        // An object of our own takes every member.
        let _ = Reflect::set(&object, &name.into(), &value);
    }
    object.into()
}
