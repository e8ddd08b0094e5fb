//! The runtime: a baked scene, its present lighting and materials, and the stages of a frame.

use std::sync::Arc;
use std::time::Instant;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_scene::{Lighting, Object};
use probelight_trace::{TracedObject, Tracer, World};

use crate::convergence::relative_change;
use crate::cpu::{
    ChooseWork, ClusterCoefficients, Dilation, ProbeRadiance, ReceiverIrradiance, ScalarSignals,
};
use crate::doors::Doors;
use crate::frame::{FramePlans, ReceiverPlace};
use crate::irradiance_grid::WeightedVertex;
use crate::scene_state::SceneState;
use crate::shadow_turns::ShadowTurns;
use crate::{
    Convergence, EmissiveDisc, FrameInput, FramePlan, GridPlaces, IrradianceGrid, IrradianceLightmap,
    LodSettings, ObjectInfluence, Objects, RuntimeError, Stage, StageTimings, SurfaceColors, Ways, Workload,
};

/// Lights a baked scene, frame by frame. Feature `cpu`, on by default.
///
/// Work is divided among the threads of the rayon pool that calls; the result does not depend on their number.
/// After the first frame, [`step`](Self::step) allocates nothing, unless there are more lights than ever before.
pub struct Runtime {
    baked: Arc<BakedScene>,
    tracer: Tracer,
    state: SceneState,
    /// The objects of the last frame.
    traced_objects: Vec<TracedObject>,
    /// Once there was one.
    doors: Option<Box<Doors>>,
    shadow_turns: ShadowTurns,
    grid_places: GridPlaces,
    plans: FramePlans,
    /// What of the plan is computed, where levels of detail let something wait.
    work: Option<Box<ChooseWork>>,
    signals: ScalarSignals,
    probes: ProbeRadiance,
    coefficients: ClusterCoefficients,
    receivers: ReceiverIrradiance,
    dilation: Dilation,
    lightmap: IrradianceLightmap,
}

impl Runtime {
    /// Prepares a baked scene: builds the BVH for shadow rays, and all buffers. The lights are those of the
    /// scene's file, the sky is black, emissive surfaces shine.
    pub fn new(baked: Arc<BakedScene>) -> Self {
        Self {
            tracer: Tracer::new(Arc::clone(&baked.scene)),
            state: SceneState::new(&baked),
            traced_objects: Vec::new(),
            doors: None,
            shadow_turns: ShadowTurns::default(),
            grid_places: GridPlaces::new(&baked),
            plans: FramePlans::new(&baked),
            work: None,
            signals: ScalarSignals::new(&baked),
            probes: ProbeRadiance::new(&baked),
            coefficients: ClusterCoefficients::new(&baked),
            receivers: ReceiverIrradiance::new(&baked),
            dilation: Dilation::new(&baked),
            lightmap: IrradianceLightmap::new(baked.lightmap.width, baked.lightmap.height),
            baked,
        }
    }

    /// The baked scene.
    pub fn baked(&self) -> &Arc<BakedScene> {
        &self.baked
    }

    /// The ray tracer of the scene.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// The light sources of the next frame.
    pub fn lighting(&self) -> &Lighting {
        &self.state.lighting
    }

    /// Changes the light sources. Rays are traced again only of analytic lights that moved.
    ///
    /// # Errors
    /// If a number of the lighting is not finite or negative where light cannot be; then it stays as it was.
    pub fn set_lighting(&mut self, lighting: Lighting) -> Result<(), RuntimeError> {
        self.state.set_lighting(lighting)
    }

    /// A material's present colours.
    pub fn surface_colors(&self, material: usize) -> Option<SurfaceColors> {
        self.state.colors.get(material).copied()
    }

    /// Changes the base colour factor of a material (linear RGB; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_base_color(&mut self, material: usize, base_color: Vec3) -> Result<(), RuntimeError> {
        self.state.set_base_color(material, base_color)
    }

    /// Changes the radiance that the front faces of a material emit (W·m⁻²·sr⁻¹; its texture stays).
    ///
    /// # Errors
    /// If there is no such material, or a channel is negative or not finite.
    pub fn set_emission(&mut self, material: usize, radiance: Vec3) -> Result<(), RuntimeError> {
        self.state.set_emission(material, radiance)
    }

    /// Whether surfaces pass on what they receive, as they do unless it is switched off. Without, what is left is what sky
    /// and emissive surfaces send straight to each place.
    pub fn set_bounces(&mut self, bounces: bool) {
        self.state.set_bounces(bounces);
    }

    /// What moves through the scene.
    pub fn objects(&self) -> &Objects {
        &self.state.objects
    }

    /// What moves through the scene, to change it from the next frame on.
    pub fn objects_mut(&mut self) -> &mut Objects {
        &mut self.state.objects
    }

    /// The scene of the last frame with its objects, for rays.
    pub fn world(&self) -> World<'_> {
        World { tracer: &self.tracer, objects: &self.traced_objects }
    }

    /// The levels of detail by which frames are planned.
    pub fn lod(&self) -> &LodSettings {
        self.plans.lod()
    }

    /// Changes the levels of detail from the next frame on. The first that let something wait take a fraction of a second
    /// to find out what each signal can change.
    ///
    /// # Errors
    /// See [`LodSettings::check`].
    pub fn set_lod(&mut self, lod: LodSettings) -> Result<(), RuntimeError> {
        let (lets_wait, coarsest) = (lod.lets_wait(), lod.coarsest_lightmap());
        self.plans.set_lod(lod)?;
        self.receivers.prepare_fills(&self.baked, coarsest);
        self.shadow_turns.all_at_once();
        if !lets_wait {
            self.work = None;
        } else if self.work.is_none() {
            self.work = Some(Box::new(ChooseWork::new(&self.baked)));
        }
        Ok(())
    }

    /// What the last frame was to keep up to date.
    pub fn plan(&self) -> &FramePlan {
        self.plans.plan()
    }

    /// What the last frame computed: of the [plan](Self::plan) what did not wait, see [`LodChanges`](crate::LodChanges).
    pub fn work(&self) -> &FramePlan {
        work_of(self.work.as_deref(), &self.plans)
    }

    /// The same in numbers, and what waits.
    pub fn workload(&self) -> Workload {
        let thresholds = self.plans.thresholds();
        let pending = self.work.as_ref().map_or(0, |work| work.pending_clusters(thresholds));
        Workload::new(&self.baked, self.work().clusters(), pending)
    }

    /// Computes one frame, which adds one bounce to the lightmap.
    pub fn step(&mut self, input: &FrameInput) -> StageTimings {
        let start = Instant::now();
        self.plans.plan_frame(&self.baked, input, self.state.objects.bounds());
        self.run_stages(start)
    }

    /// Computes one frame by a plan of the caller's. Nothing of it waits.
    ///
    /// # Errors
    /// [`RuntimeError::ForeignPlan`] if the plan is one for another scene.
    pub fn step_with(&mut self, plan: &FramePlan) -> Result<StageTimings, RuntimeError> {
        let start = Instant::now();
        self.plans.set_plan(&self.baked, plan)?;
        self.forget_work();
        Ok(self.run_stages(start))
    }

    fn run_stages(&mut self, start: Instant) -> StageTimings {
        let mut timings = StageTimings::default();
        for stage in Stage::ALL.into_iter().filter(|stage| stage.is_on_cpu()) {
            let start = Instant::now();
            self.run_stage(stage);
            timings.stages[stage] = start.elapsed();
        }
        timings.frame = start.elapsed();
        timings
    }

    fn run_stage(&mut self, stage: Stage) {
        let touched = self.work.as_ref().map(|work| work.touched());
        let is_touched = |cluster: u32| touched.is_none_or(|touched| touched[cluster as usize]);
        match stage {
            Stage::LightSurfels => self.light_surfels(),
            Stage::RelightProbes => self.relight_probes(),
            Stage::ProjectClusters => self.project_clusters(),
            Stage::GatherReceivers => {
                let plan = work_of(self.work.as_deref(), &self.plans);
                let (coefficients, lightmap) = (self.coefficients.values(), &mut self.lightmap);
                self.receivers.gather_receivers(&self.baked, plan, coefficients, lightmap, is_touched);
            }
            Stage::DilateLightmap => {
                self.dilation.dilate_lightmap(self.receivers.values(), &mut self.lightmap, is_touched);
            }
            // The CPU's renderer takes several samples per pixel instead.
            Stage::ReduceLightmap => {}
        }
    }

    fn light_surfels(&mut self) {
        let (baked, signals) = (&*self.baked, &mut self.signals);
        let stale = self.state.take_stale(&self.baked.scene);
        let moved = self.state.objects.take_stale();
        let SceneState { lighting, objects, .. } = &self.state;
        if moved {
            trace_objects(&mut self.traced_objects, objects.as_slice());
            if self.doors.is_none() && objects.doors().next().is_some() {
                self.doors = Some(Box::new(Doors::new(baked, &self.tracer)));
            }
            if let Some(doors) = &mut self.doors
                && doors.follow(baked, &self.tracer, objects)
                && let Some(work) = &mut self.work
            {
                work.forget();
            }
        }
        let turns = self.plans.lod().shadow_turns;
        let work = self.shadow_turns.next(turns, stale.direct, moved);
        if work.lights || work.objects {
            let world = World { tracer: &self.tracer, objects: &self.traced_objects };
            signals.light_directly(baked, world, &lighting.lights, work);
        }
        if stale.shading {
            signals.color(baked, lighting, &self.state.bouncing_colors());
        }
        let shine_differently = work.lights || work.objects || stale.shading;
        if shine_differently {
            signals.shade();
        }
        if stale.sky {
            signals.project_sky(baked, &lighting.sky);
            self.probes.see_sky(baked, &lighting.sky);
        }
        let Some(work) = &mut self.work else {
            signals.light_surfels(baked, &self.lightmap);
            return;
        };
        if stale.sky && baked.settings.sky_degree.is_none() {
            work.forget_probes();
        }
        // A material that changed reflects the lightmap differently, too.
        let is_shaded = signals.is_shaded();
        let (is_dirty, changes) =
            work.begin(|block| stale.shading || (shine_differently && is_shaded[block]));
        signals.light_dirty_surfels(baked, &self.lightmap, is_dirty, changes);
        work.note_emitters_and_sky(baked, signals.values());
    }

    fn relight_probes(&mut self) {
        let (plans, probes) = (&self.plans, &mut self.probes);
        let (plan, waits) = match &mut self.work {
            Some(work) => (work.choose_probes(plans.plan(), plans.thresholds(), plans.lod(), probes), true),
            None => (plans.plan(), false),
        };
        let ways = ways_of(self.doors.as_deref(), &self.baked);
        probes.relight_probes(
            &self.baked,
            ways,
            plan,
            &self.signals.values()[..self.baked.surfels.len()],
            waits,
        );
    }

    fn project_clusters(&mut self) {
        let (baked, plans) = (&*self.baked, &self.plans);
        let (coefficients, signals, probes) = (&mut self.coefficients, self.signals.values(), &self.probes);
        let ways = ways_of(self.doors.as_deref(), baked);
        let Some(work) = &mut self.work else {
            coefficients.project_clusters(baked, ways, plans.plan(), signals, probes);
            return;
        };
        let (rules, bands) = (&plans.lod().changes, probes.band_changes());
        let plan = work.choose_clusters(baked, plans.plan(), plans.thresholds(), rules, bands);
        coefficients.project_clusters(baked, ways, plan, signals, probes);
        work.note_light(baked, coefficients.values());
    }

    /// Makes the next frame compute all that it is to keep up to date.
    fn forget_work(&mut self) {
        self.shadow_turns.all_at_once();
        if let Some(work) = &mut self.work {
            work.forget();
        }
    }

    /// Computes frames without a view until the relative change of the lightmap is at most `tolerance`, at most `max_steps`.
    /// Nothing waits.
    pub fn converge(&mut self, tolerance: f64, max_steps: usize) -> Convergence {
        let mut previous = self.receivers.values().to_vec();
        let mut convergence = Convergence { steps: 0, change: f64::INFINITY };
        while convergence.steps < max_steps && convergence.change > tolerance {
            self.forget_work();
            self.step(&FrameInput::default());
            convergence.steps += 1;
            convergence.change = relative_change(&previous, self.receivers.values());
            previous.copy_from_slice(self.receivers.values());
        }
        convergence
    }

    /// Forgets all bounced light: the next step starts from darkness.
    pub fn reset(&mut self) {
        self.receivers.clear();
        self.lightmap.texels.fill(Vec3::ZERO);
        self.forget_work();
    }

    /// The lightmap of the last frame.
    pub fn irradiance(&self) -> &IrradianceLightmap {
        &self.lightmap
    }

    /// Irradiance (W/m²) of the surface at a world position, on its side towards `normal` (unit): what arrives
    /// by way of the signals. `None` if there is no such surface within a thousandth of the scene's diagonal.
    /// Sides without light of their own, such as the insides of solids, are dark.
    pub fn irradiance_at(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        self.lightmap.irradiance_at(&self.tracer, &self.baked.lightmap, position, normal)
    }

    /// Irradiance (W/m²) of a surface in free space at a world position that faces along `normal` (unit), as
    /// [`irradiance_at`](Self::irradiance_at) says of static ones. `None` if the scene was baked without a grid, or if the
    /// last frame did not compute the grid there ([`FrameInput::active_boxes`], [`FrameInput::whole_grid`]).
    pub fn irradiance_in_air(&self, position: Vec3, normal: Vec3) -> Option<Vec3> {
        let held = self.work.as_ref().map_or(self.plans.plan().clusters(), |work| work.held());
        let is_computed = |(vertex, weight): &WeightedVertex| {
            let mut rows = self.baked.vertex_receivers(*vertex).iter();
            let is_held = |row: &u32| ReceiverPlace::at(&self.baked.clusters, *row).is_computed(held);
            *weight == 0.0 || rows.all(is_held)
        };
        let vertices = self.grid().vertices_lighting(position, normal);
        let is_known = self.baked.has_grid() && vertices.iter().all(is_computed);
        is_known.then(|| self.grid().between(&vertices).irradiance(normal))
    }

    /// What objects make of the lightmap's light, or that of free space, at a point of a surface that faces along `normal`
    /// (unit), where `irradiance` arrives without them. `own` is the place among [`objects`](Self::objects) of the object that the
    /// surface belongs to, if it does.
    pub fn object_influence(
        &self,
        position: Vec3,
        normal: Vec3,
        irradiance: Vec3,
        own: Option<usize>,
    ) -> ObjectInfluence {
        let own = own.map(|index| index as u32);
        let light = || self.grid().light(position, normal);
        ObjectInfluence::of(
            self.state.objects.spheres(),
            self.emissive_discs(),
            own,
            position,
            normal,
            irradiance,
            light,
        )
    }

    /// Emissive surfaces as they shone in the last frame.
    pub fn emissive_discs(&self) -> &[EmissiveDisc] {
        self.state.discs.as_slice()
    }

    /// The grid in free space with the light of the last frame, as far as that computed it.
    pub fn grid(&self) -> IrradianceGrid<'_> {
        IrradianceGrid::new(&self.baked, &self.grid_places, self.receivers.values())
    }

    /// Scalar signals of the last frame.
    pub fn signals(&self) -> &ScalarSignals {
        &self.signals
    }

    /// Radiance of the surfels in the last frame, W·m⁻²·sr⁻¹.
    pub fn surfel_radiance(&self) -> &[Vec3] {
        &self.signals.values()[..self.baked.surfels.len()]
    }

    /// Probe coefficients λ of the last frame.
    pub fn probe_radiance(&self) -> &ProbeRadiance {
        &self.probes
    }

    /// Cluster coefficients b of the last frame.
    pub fn cluster_coefficients(&self) -> &ClusterCoefficients {
        &self.coefficients
    }

    /// Irradiance of the receivers in the last frame, W/m²: in the order of `receiver_texels`, then the grid's.
    pub fn receiver_irradiance(&self) -> &[Vec3] {
        self.receivers.values()
    }
}

/// What of a plan a frame computes.
fn work_of<'a>(work: Option<&'a ChooseWork>, plans: &'a FramePlans) -> &'a FramePlan {
    work.map_or(plans.plan(), ChooseWork::work)
}

/// The ways that light takes.
fn ways_of<'a>(doors: Option<&'a Doors>, baked: &'a BakedScene) -> Ways<'a> {
    doors.map_or_else(|| baked.into(), Doors::ways)
}

/// Renews the objects for rays; models that were there already keep their BVH.
fn trace_objects(traced: &mut Vec<TracedObject>, objects: &[Object]) {
    let before = std::mem::take(traced);
    for object in objects {
        let model = object.model();
        let known = before.iter().chain(traced.iter()).map(TracedObject::tracer);
        let tracer = known.into_iter().find(|tracer| Arc::ptr_eq(tracer.scene(), model)).map(Arc::clone);
        let tracer = tracer.unwrap_or_else(|| Arc::new(Tracer::new(Arc::clone(model))));
        traced.push(TracedObject::new(object, tracer));
    }
}
