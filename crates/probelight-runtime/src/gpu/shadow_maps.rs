//! Shadow maps: which surfaces the analytic lights see.
//!
//! One depth texture holds all views of all lights as its layers, see `shadow_views.rs`. Shaders get
//! it, and the lights themselves, as bind group 0 and call `light_visibility` of `shadow_maps.wgsl`. Maps are only drawn
//! again when lights change. Where objects move, a second texture keeps the maps without them: each frame begins with a
//! copy of it. Views for an eye (`eye_views.rs`) have a texture of their own: what lights the scene does not depend on it.

use bytemuck::Zeroable;
use probelight_scene::{Camera, Light};

use super::bindings::{UNIFORM, bind, layout};
use super::cast_shadows::{Caster, DEPTH_FORMAT};
use super::device::{GpuError, checked};
use super::eye_views::{EyeViews, MAX_EYE_VIEWS, eye_view_count};
use super::moving_geometry::MovingGeometry;
use super::scene_geometry::SceneGeometry;
use super::shadow_views::{
    LightRecord, LightsRecord, MAX_SHADOW_VIEWS, ShadowViewRecord, light_records, view_count,
};

/// How fine shadow maps are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowMapOptions {
    /// Width and height of a view, texels; at least 64. A directional light has 2 × 2 views.
    pub resolution: u32,
    /// Most memory for all views, bytes. With more views the resolution is halved until they fit, but not
    /// below 64.
    pub memory: u64,
    /// Whether the lights that matter most have two more views, as wide as [`resolution`](Self::resolution) says, which
    /// [`fit_to_eye`](ShadowMaps::fit_to_eye) fits to what a camera sees: for pictures with sharp shadows nearby.
    pub for_eye: bool,
}

impl Default for ShadowMapOptions {
    /// 2048 texels: a centimetre for a sun over forty metres. 512 MiB hold 32 such views. None for the eye.
    fn default() -> Self {
        Self { resolution: 2048, memory: 512 << 20, for_eye: false }
    }
}

const SMALLEST_RESOLUTION: u32 = 64;

/// WebGPU's limit for the width of a texture.
const LARGEST_RESOLUTION: u32 = 8192;

impl ShadowMapOptions {
    /// The width of a view, if there are not too many of them.
    fn largest_resolution(&self) -> u32 {
        self.resolution.clamp(SMALLEST_RESOLUTION, LARGEST_RESOLUTION)
    }

    /// The width of each of `views` views, texels.
    fn resolution_of(&self, views: usize) -> u32 {
        let mut resolution = self.largest_resolution();
        let bytes = |resolution: u32| 4 * u64::from(resolution).pow(2) * views as u64;
        while bytes(resolution) > self.memory && resolution / 2 >= SMALLEST_RESOLUTION {
            resolution /= 2;
        }
        resolution
    }
}

/// Lights and their shadow maps in the memory of a GPU.
#[derive(Debug)]
pub struct ShadowMaps {
    options: ShadowMapOptions,
    lights: Vec<Light>,
    is_stale: bool,
    light_buffer: wgpu::Buffer,
    view_buffer: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    caster: Caster,
    maps: Maps,
    /// The maps without objects, once there were any.
    still: Option<wgpu::Texture>,
    eye: EyeMaps,
    bind_group: wgpu::BindGroup,
}

/// Depth in some views, each a layer of one texture.
#[derive(Debug)]
struct Maps {
    texture: wgpu::Texture,
    all: wgpu::TextureView,
    layers: Vec<wgpu::TextureView>,
}

/// Depth in the views for an eye.
#[derive(Debug)]
struct EyeMaps {
    maps: Maps,
    views: EyeViews,
    /// For each view whether its layer shows something else.
    stale: Vec<bool>,
}

impl ShadowMaps {
    /// Maps for the given geometry, without lights.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(
        device: &wgpu::Device,
        geometry: &SceneGeometry,
        options: ShadowMapOptions,
    ) -> Result<Self, GpuError> {
        checked(device, "shadow maps", || {
            let light_buffer = uniform_buffer(device, "lights", size_of::<LightsRecord>());
            let views_size = size_of::<ShadowViewRecord>() * (MAX_SHADOW_VIEWS + MAX_EYE_VIEWS);
            let view_buffer = uniform_buffer(device, "shadow views", views_size);
            let layout = lights_layout(device);
            let maps = Maps::new(device, SMALLEST_RESOLUTION, 0);
            let eye = EyeMaps::new(device, SMALLEST_RESOLUTION, 0);
            let bind_group = bind_maps(device, &layout, [&light_buffer, &view_buffer], [&maps, &eye.maps]);
            let caster = Caster::new(device, geometry, &view_buffer);
            let lights = Vec::new();
            Ok(Self {
                options,
                lights,
                is_stale: true,
                light_buffer,
                view_buffer,
                layout,
                caster,
                maps,
                still: None,
                eye,
                bind_group,
            })
        })
    }

    /// The lights whose maps these are.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Layout of [`bind_group`](Self::bind_group): group 0 of shaders that begin with
    /// [`super::shaders::LIGHTS`] and [`super::shaders::SHADOW_MAPS`].
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Lights and maps for shaders. Another one after [`set_lights`](Self::set_lights).
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    /// Changes the lights. Nothing happens if they are the same.
    ///
    /// # Errors
    /// [`GpuError::TooManyLights`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn set_lights(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        geometry: &SceneGeometry,
        lights: &[Light],
    ) -> Result<(), GpuError> {
        if lights == self.lights {
            return Ok(());
        }
        let needed = view_count(lights);
        if needed > MAX_SHADOW_VIEWS {
            return Err(GpuError::TooManyLights { lights: lights.len(), needed, limit: MAX_SHADOW_VIEWS });
        }
        let resolution = self.options.resolution_of(needed);
        self.make_room(device, resolution, lights)?;
        let (records, views) = light_records(lights, &geometry.bounds, resolution);
        let mut record = LightsRecord { count: records.len() as u32, ..LightsRecord::zeroed() };
        record.list[..records.len()].copy_from_slice(&records);
        queue.write_buffer(&self.light_buffer, 0, bytemuck::bytes_of(&record));
        queue.write_buffer(&self.view_buffer, 0, bytemuck::cast_slice(&views));
        self.lights = lights.to_vec();
        self.is_stale = true;
        // Until an eye says what it sees, there are no views for it.
        self.eye.views = EyeViews::none(lights);
        Ok(())
    }

    /// Replaces textures that have another size than views of lights need.
    fn make_room(
        &mut self,
        device: &wgpu::Device,
        resolution: u32,
        lights: &[Light],
    ) -> Result<(), GpuError> {
        let needed = view_count(lights);
        let for_eye = if self.options.for_eye { eye_view_count(lights) } else { 0 };
        let are_fit = self.maps.are(resolution, needed);
        let eyes_are_fit = self.eye.maps.layers.len() >= for_eye;
        if are_fit && eyes_are_fit {
            return Ok(());
        }
        checked(device, "shadow maps", || {
            if !are_fit {
                self.maps = Maps::new(device, resolution, needed);
            }
            if !eyes_are_fit {
                self.eye = EyeMaps::new(device, self.options.largest_resolution(), for_eye);
            }
            let buffers = [&self.light_buffer, &self.view_buffer];
            self.bind_group = bind_maps(device, &self.layout, buffers, [&self.maps, &self.eye.maps]);
            Ok(())
        })
    }

    /// Gives the views for the eye another place. Nothing happens to those that stay.
    fn set_eye(&mut self, queue: &wgpu::Queue, geometry: &SceneGeometry, eye: &Camera) {
        let views = EyeViews::new(&self.lights, &geometry.bounds, self.options.largest_resolution(), eye);
        if views == self.eye.views {
            return;
        }
        let first = MAX_SHADOW_VIEWS * size_of::<ShadowViewRecord>();
        queue.write_buffer(&self.view_buffer, first as u64, bytemuck::cast_slice(&views.records));
        let pairs = views.first.iter().zip(&self.eye.views.first).enumerate();
        for (light, (view, _)) in pairs.filter(|(_, (new, old))| new != old) {
            let record = light * size_of::<LightRecord>() + std::mem::offset_of!(LightRecord, eye_view);
            queue.write_buffer(&self.light_buffer, record as u64, bytemuck::bytes_of(view));
        }
        self.eye.replace_views(views);
    }

    /// Draws the maps of those lights that are fitted to what a camera sees, as far as it sees something else than before, or
    /// lights or objects changed. Goes between [`encode_with_objects`](Self::encode_with_objects) and the picture; of one
    /// submission only the last eye counts. Without [`ShadowMapOptions::for_eye`] there are none.
    pub fn fit_to_eye(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        geometry: &SceneGeometry,
        moving: &MovingGeometry,
        eye: &Camera,
    ) {
        if !self.options.for_eye {
            return;
        }
        self.set_eye(queue, geometry, eye);
        let stale: Vec<usize> = (0..self.eye.stale.len()).filter(|view| self.eye.stale[*view]).collect();
        self.eye.stale.fill(false);
        if stale.is_empty() {
            return;
        }
        let objects = (moving.count > 0).then(|| self.caster.bind_objects(device, queue, moving));
        for layer in stale {
            let (view, layer) = ((MAX_SHADOW_VIEWS + layer) as u32, &self.eye.maps.layers[layer]);
            self.caster.draw(encoder, geometry, layer, view);
            if let Some(bound) = &objects {
                self.caster.draw_objects(encoder, moving, bound, layer, view);
            }
        }
    }

    /// Draws the maps if lights changed since they were drawn last.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, geometry: &SceneGeometry) {
        if !std::mem::replace(&mut self.is_stale, false) {
            return;
        }
        for (view, layer) in self.maps.layers.iter().enumerate() {
            self.caster.draw(encoder, geometry, layer, view as u32);
        }
        self.eye.stale.fill(true);
        self.still = None;
    }

    /// Draws the maps with objects if lights changed or `moved` says that objects did.
    pub fn encode_with_objects(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        geometry: &SceneGeometry,
        moving: &MovingGeometry,
        moved: bool,
    ) {
        let are_new = self.is_stale;
        self.encode(encoder, geometry);
        if !(are_new || moved) || self.maps.layers.is_empty() {
            return;
        }
        self.eye.stale.fill(true);
        let all = self.maps.texture.size();
        match &self.still {
            Some(still) => {
                encoder.copy_texture_to_texture(
                    still.as_image_copy(),
                    self.maps.texture.as_image_copy(),
                    all,
                );
            }
            None if moving.count == 0 => return,
            None => {
                let still = depth_texture(device, all);
                encoder.copy_texture_to_texture(
                    self.maps.texture.as_image_copy(),
                    still.as_image_copy(),
                    all,
                );
                self.still = Some(still);
            }
        }
        if moving.count > 0 {
            let bound = self.caster.bind_objects(device, queue, moving);
            for (view, layer) in self.maps.layers.iter().enumerate() {
                self.caster.draw_objects(encoder, moving, &bound, layer, view as u32);
            }
        }
    }
}

/// The layers of shadow maps.
fn depth_texture(device: &wgpu::Device, size: wgpu::Extent3d) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadow maps"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DEPTH_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

impl Maps {
    fn new(device: &wgpu::Device, resolution: u32, layers: usize) -> Self {
        // A texture has at least one layer, and an array at least two on some backends' word.
        let depth_or_array_layers = layers.max(2) as u32;
        let size = wgpu::Extent3d { width: resolution, height: resolution, depth_or_array_layers };
        let texture = depth_texture(device, size);
        let all = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..wgpu::TextureViewDescriptor::default()
        });
        let layer = |layer: u32| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        Self { layers: (0..layers as u32).map(layer).collect(), all, texture }
    }

    fn are(&self, resolution: u32, layers: usize) -> bool {
        self.layers.len() == layers && self.texture.width() == resolution
    }
}

impl EyeMaps {
    fn new(device: &wgpu::Device, resolution: u32, layers: usize) -> Self {
        Self { maps: Maps::new(device, resolution, layers), views: EyeViews::default(), stale: Vec::new() }
    }

    /// Notes which layers are to be drawn again for new views.
    fn replace_views(&mut self, views: EyeViews) {
        let is_drawn =
            |(i, view): (usize, &ShadowViewRecord)| self.views.records.get(i) == Some(view) && !self.stale[i];
        self.stale = views.records.iter().enumerate().map(|view| !is_drawn(view)).collect();
        self.views = views;
    }
}

fn bind_maps(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: [&wgpu::Buffer; 2],
    [maps, eye]: [&Maps; 2],
) -> wgpu::BindGroup {
    let [lights, views] = buffers.map(wgpu::Buffer::as_entire_binding);
    let [maps, eye] = [maps, eye].map(|maps| wgpu::BindingResource::TextureView(&maps.all));
    bind(device, "lights", layout, [lights, views, maps, eye])
}

fn lights_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let stages = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
    let depth = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Depth,
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    layout(device, "lights", [UNIFORM, UNIFORM, depth, depth].map(|ty| (ty, stages)))
}

fn uniform_buffer(device: &wgpu::Device, label: &str, size: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_views_share_the_memory() {
        let options = ShadowMapOptions::default();
        assert_eq!([1, 32, 33, 256].map(|views| options.resolution_of(views)), [2048, 2048, 1024, 512]);
        let tiny = ShadowMapOptions { resolution: 1, memory: 0, ..options };
        assert_eq!(tiny.resolution_of(256), 64);
    }
}
