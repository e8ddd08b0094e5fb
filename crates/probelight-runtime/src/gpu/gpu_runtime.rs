//! The runtime on the GPU: a baked scene, its present lighting and materials, and the stages of a frame.

use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::{Camera, Lighting};
#[cfg(feature = "cpu")]
use probelight_trace::Tracer;

use super::blend_borders::BlendBorders;
use super::choose_work::ChooseWork;
use super::cluster_shards::{ClusterShard, cluster_shards};
use super::device::{GpuError, checked, checked_async, new_encoder};
use super::dilate_lightmap::DilateLightmap;
use super::fill_receivers::FillReceivers;
use super::frame_buffers::FrameBuffers;
use super::gather_receivers::GatherReceivers;
use super::grid_tables::GridTables;
use super::light_surfels::LightSurfels;
use super::moving_geometry::MovingGeometry;
use super::project_clusters::ProjectClusters;
use super::reduce_lightmap::ReduceLightmap;
use super::relight_probes::RelightProbes;
use super::scene_geometry::SceneGeometry;
use super::shadow_maps::{ShadowMapOptions, ShadowMaps};
use super::storage::Storage;
use super::timestamps::FrameTimestamps;
#[cfg(feature = "cpu")]
use crate::doors::Doors;
use crate::frame::FramePlans;
use crate::scene_state::SceneState;
use crate::{FrameInput, RuntimeError, Stage, SurfaceColors};

/// How a [`GpuRuntime`] uses the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuOptions {
    /// How fine the shadow maps are that light the surfels.
    pub shadow_maps: ShadowMapOptions,
    /// Most bytes of a buffer; `None`: what the device can bind. Longer arrays are divided.
    pub largest_buffer: Option<u64>,
    /// Whether coarser levels of the lightmap are computed.
    pub reduces_lightmap: bool,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self { shadow_maps: ShadowMapOptions::default(), largest_buffer: None, reduces_lightmap: true }
    }
}

/// Lights a baked scene on the GPU, frame by frame: the twin of `Runtime`.
///
/// It works on any [`wgpu::Device`] with WebGPU's default limits. A frame is a number of passes in a command
/// encoder of the caller's; nothing is read back and nothing waits.
#[derive(Debug)]
pub struct GpuRuntime {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) baked: Arc<BakedScene>,
    pub(super) state: SceneState,
    pub(super) plans: FramePlans,
    /// What of the plan is computed, where levels of detail let something wait.
    pub(super) work: Option<Box<ChooseWork>>,
    geometry: SceneGeometry,
    shadow_maps: ShadowMaps,
    pub(super) moving: MovingGeometry,
    pub(super) moved: bool,
    /// Once there was one, with what traces rays for them.
    #[cfg(feature = "cpu")]
    pub(super) doors: Option<(Tracer, Box<Doors>)>,
    pub(super) grid: GridTables,
    pub(super) buffers: FrameBuffers,
    pub(super) shards: Vec<ClusterShard>,
    pub(super) stages: Stages,
}

#[derive(Debug)]
pub(super) struct Stages {
    pub(super) light_surfels: LightSurfels,
    pub(super) relight_probes: RelightProbes,
    project_clusters: ProjectClusters,
    gather_receivers: GatherReceivers,
    /// Where levels of detail leave receivers out.
    pub(super) fill_receivers: Option<FillReceivers>,
    pub(super) blend_borders: BlendBorders,
    dilate_lightmap: DilateLightmap,
    pub(super) reduce_lightmap: Option<ReduceLightmap>,
}

impl Stages {
    fn new(
        storage: &Storage,
        baked: &BakedScene,
        buffers: &FrameBuffers,
        shards: &[ClusterShard],
        shadow_maps: &ShadowMaps,
        reduces_lightmap: bool,
    ) -> Result<Self, GpuError> {
        let device = storage.device;
        Ok(Self {
            light_surfels: LightSurfels::new(storage, baked, buffers, shadow_maps.bind_group_layout())?,
            relight_probes: RelightProbes::new(storage, baked, buffers)?,
            project_clusters: ProjectClusters::new(device, shards, buffers),
            gather_receivers: GatherReceivers::new(device, shards, buffers),
            fill_receivers: None,
            blend_borders: BlendBorders::new(storage, baked, buffers)?,
            dilate_lightmap: DilateLightmap::new(storage, baked, buffers)?,
            reduce_lightmap: reduces_lightmap.then(|| ReduceLightmap::new(device, buffers)),
        })
    }
}

impl GpuRuntime {
    /// Copies a baked scene to a GPU. The lights are those of the scene's file, the sky is black, emissive surfaces
    /// shine.
    ///
    /// # Errors
    /// If the device cannot hold the scene. In browsers, where devices take
    /// time to say so, [`new_async`](Self::new_async) is needed to hear it.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: Arc<BakedScene>,
        options: GpuOptions,
    ) -> Result<Self, GpuError> {
        checked(device, "the baked scene", || Self::make(device, queue, baked, options))
    }

    /// [`new`](Self::new), after the device said whether it has all that was made.
    ///
    /// # Errors
    /// As those of [`new`](Self::new).
    pub async fn new_async(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: Arc<BakedScene>,
        options: GpuOptions,
    ) -> Result<Self, GpuError> {
        checked_async(device, "the baked scene", || Self::make(device, queue, baked, options)).await
    }

    fn make(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        baked: Arc<BakedScene>,
        options: GpuOptions,
    ) -> Result<Self, GpuError> {
        let geometry = SceneGeometry::new(device, queue, &baked.scene)?;
        let mut shadow_maps = ShadowMaps::new(device, &geometry, options.shadow_maps)?;
        let mut storage = Storage::new(device, queue);
        storage.limit = storage.limit.min(options.largest_buffer.unwrap_or(u64::MAX));
        let buffers = FrameBuffers::new(&storage, &baked)?;
        let grid = GridTables::new(device, queue, &baked, &buffers.irradiance)?;
        let shards = cluster_shards(&storage, &baked)?;
        let stages =
            Stages::new(&storage, &baked, &buffers, &shards, &shadow_maps, options.reduces_lightmap)?;
        let state = SceneState::new(&baked);
        shadow_maps.set_lights(device, queue, &geometry, &state.lighting.lights)?;
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            plans: FramePlans::new(&baked),
            work: None,
            baked,
            state,
            geometry,
            shadow_maps,
            moving: MovingGeometry::new(device),
            moved: false,
            #[cfg(feature = "cpu")]
            doors: None,
            grid,
            buffers,
            shards,
            stages,
        })
    }

    /// The baked scene.
    pub fn baked(&self) -> &Arc<BakedScene> {
        &self.baked
    }

    /// The scene's triangles on the GPU.
    pub fn geometry(&self) -> &SceneGeometry {
        &self.geometry
    }

    /// The lights and their shadow maps, drawn by [`encode`](Self::encode).
    pub fn shadow_maps(&self) -> &ShadowMaps {
        &self.shadow_maps
    }

    /// Signals, irradiance, and the lightmap for renderers.
    pub fn buffers(&self) -> &FrameBuffers {
        &self.buffers
    }

    /// The irradiance lightmap with all its levels, for renderers; see [`FrameBuffers::lightmap`]. It stays the same
    /// texture for the life of the runtime.
    pub fn lightmap_view(&self) -> &wgpu::TextureView {
        &self.buffers.lightmap_view
    }

    /// The light sources of the next frame.
    pub fn lighting(&self) -> &Lighting {
        &self.state.lighting
    }

    /// Changes the light sources. Shadow maps are drawn again only if an analytic light changed.
    ///
    /// # Errors
    /// If a number of the lighting is not finite or negative where light cannot be, or the device cannot hold the shadow
    /// maps of so many lights; then the lighting stays as it was.
    pub fn set_lighting(&mut self, lighting: Lighting) -> Result<(), GpuError> {
        lighting.validate().map_err(RuntimeError::from)?;
        self.shadow_maps.set_lights(&self.device, &self.queue, &self.geometry, &lighting.lights)?;
        Ok(self.state.set_lighting(lighting)?)
    }

    /// A material's present colours.
    pub fn surface_colors(&self, material: usize) -> Option<SurfaceColors> {
        self.state.colors.get(material).copied()
    }

    /// Changes the base colour factor of a material (linear RGB; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_base_color(&mut self, material: usize, base_color: Vec3) -> Result<(), GpuError> {
        Ok(self.state.set_base_color(material, base_color)?)
    }

    /// Changes the radiance that the front faces of a material emit (W·m⁻²·sr⁻¹; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_emission(&mut self, material: usize, radiance: Vec3) -> Result<(), GpuError> {
        Ok(self.state.set_emission(material, radiance)?)
    }

    /// As [`Runtime::set_bounces`](crate::Runtime::set_bounces).
    pub fn set_bounces(&mut self, bounces: bool) {
        self.state.set_bounces(bounces);
    }

    /// Encodes one frame, which adds one bounce to the lightmap. Changes and plans reach the GPU with the next
    /// submission to the queue, so submit before the next change.
    pub fn encode(&mut self, input: &FrameInput, encoder: &mut wgpu::CommandEncoder) {
        self.plan_frame(input);
        for stage in Stage::ALL {
            self.encode_stage(stage, encoder, None);
        }
    }

    /// Encodes one frame and measures its stages.
    pub fn encode_timed(
        &mut self,
        input: &FrameInput,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: &FrameTimestamps,
    ) {
        self.plan_frame(input);
        self.encode_stages_timed(encoder, timestamps);
    }

    /// Encodes all stages by the present plan and measures them.
    pub(super) fn encode_stages_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: &FrameTimestamps,
    ) {
        for stage in Stage::ALL {
            self.encode_stage(stage, encoder, Some(timestamps));
        }
        timestamps.resolve(encoder);
    }

    /// Draws the shadow maps if a light changed. The first stage does so by itself; whoever measures it may want to
    /// draw them before.
    pub fn encode_shadow_maps(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let _left_out = self.upload_objects();
        let Self { device, queue, geometry, moving, .. } = self;
        self.shadow_maps.encode_with_objects(device, queue, encoder, geometry, moving, self.moved);
    }

    /// Draws the shadow maps of directional lights that are fitted to what a camera sees, for the picture of the same submission;
    /// see [`ShadowMaps::fit_to_eye`].
    pub fn fit_shadows(&mut self, eye: &Camera, encoder: &mut wgpu::CommandEncoder) {
        let Self { device, queue, geometry, moving, .. } = self;
        self.shadow_maps.fit_to_eye(device, queue, encoder, geometry, moving, eye);
    }

    /// Encodes one stage by the [present plan](Self::plan). A frame is all of them, in order.
    pub fn encode_stage(
        &mut self,
        stage: Stage,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: Option<&FrameTimestamps>,
    ) {
        let stale = match stage {
            Stage::LightSurfels => self.upload_changes(encoder),
            _ => Changes::default(),
        };
        let pass = &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(stage.name()),
            timestamp_writes: timestamps.map(|timestamps| timestamps.writes(stage)),
        });
        let (stages, work) = (&self.stages, self.work.as_ref());
        match stage {
            Stage::LightSurfels => {
                if let Some(work) = work {
                    work.find_dirty_blocks(pass);
                }
                if stale.direct {
                    stages.light_surfels.light_directly(pass, self.shadow_maps.bind_group());
                }
                if stale.shading {
                    stages.light_surfels.shade(pass);
                }
                stages.light_surfels.light_surfels(pass);
                if let Some(work) = work {
                    work.measure_signals(pass);
                }
            }
            Stage::RelightProbes => {
                if let Some(work) = work {
                    work.choose_probes(pass);
                }
                stages.relight_probes.relight_probes(pass);
                if let Some(work) = work {
                    work.measure_bands(pass);
                }
            }
            Stage::ProjectClusters => {
                if let Some(work) = work {
                    work.choose_clusters(pass);
                }
                stages.project_clusters.project_clusters(pass);
                if let Some(work) = work {
                    work.note_light(pass);
                }
            }
            Stage::GatherReceivers => {
                stages.gather_receivers.gather_receivers(pass);
                if let Some(fills) = &stages.fill_receivers {
                    fills.fill_receivers(pass);
                }
                stages.blend_borders.blend_borders(pass);
            }
            Stage::DilateLightmap => stages.dilate_lightmap.dilate_lightmap(pass),
            Stage::ReduceLightmap => {
                if let Some(stage) = &stages.reduce_lightmap {
                    stage.reduce_lightmap(pass);
                }
            }
        }
    }

    /// Uploads what changed and draws shadow maps; returns what the first stage must renew.
    fn upload_changes(&mut self, encoder: &mut wgpu::CommandEncoder) -> Changes {
        let stale = self.state.take_stale(&self.baked.scene);
        let (queue, baked, buffers, state) = (&self.queue, &*self.baked, &self.buffers, &self.state);
        if stale.shading {
            self.grid.set_discs(queue, state.discs.as_slice());
            self.stages.light_surfels.set_colors(
                queue,
                baked,
                buffers,
                &state.lighting,
                &state.bouncing_colors(),
            );
        }
        if stale.sky {
            self.stages.light_surfels.set_sky(queue, baked, buffers, &state.lighting.sky);
            self.stages.relight_probes.set_sky(queue, baked, &state.lighting.sky);
        }
        self.encode_shadow_maps(encoder);
        let direct = std::mem::replace(&mut self.moved, false) || stale.direct;
        let changes = Changes { direct, shading: direct || stale.shading };
        if let Some(work) = &mut self.work {
            let sky_differs = stale.sky && self.baked.settings.sky_degree.is_none();
            work.begin(encoder, &self.buffers, changes.shading, sky_differs);
        }
        changes
    }

    /// Computes one frame in a submission of its own.
    pub fn step(&mut self, input: &FrameInput) {
        let mut encoder = new_encoder(&self.device);
        self.encode(input, &mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    /// Forgets all bounced light: the next frame starts from darkness. The lightmap keeps what it shows until then.
    pub fn reset(&mut self) {
        self.forget_work();
        let mut encoder = new_encoder(&self.device);
        encoder.clear_buffer(&self.buffers.irradiance, 0, None);
        self.stages.blend_borders.clear(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }
}

/// What the first stage must renew.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    direct: bool,
    shading: bool,
}
