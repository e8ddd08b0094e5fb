//! What of a frame's plan is computed: where the signals changed. The twin of `cpu::choose_work`.
//!
//! All is decided on the GPU. Signals are compared with a copy of those of the last frame; workgroups of the stages that
//! have nothing to do end at once.

use bytemuck::{Pod, Zeroable};
use probelight_asset::BakedScene;

use super::cluster_shards::ClusterShard;
use super::device::GpuError;
use super::frame_buffers::FrameBuffers;
use super::frame_extents::{ProbeRecord, probe_records};
use super::kernel::{Kernel, whole};
use super::stage_shaders::{
    ADMIT_CLUSTERS, CHOOSE_CLUSTERS, CHOOSE_PROBES, FIND_DIRTY_BLOCKS, MEASURE_BANDS, MEASURE_SIGNALS,
    NOTE_LIGHT, TOUCH_CLUSTERS,
};
use super::storage::Storage;
use crate::frame::{ChangeTables, Lists, Thresholds, URGENCIES, Waiting, matrix_bytes};
use crate::{ClusterExtent, FramePlan, LodSettings};

/// Invocations of a workgroup.
pub(super) const WORKGROUP: usize = 64;

/// The rules of a frame, and how many there are of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct WorkRules {
    /// Frames after which even a small change is computed.
    pub(super) longest_wait: u32,
    /// Most words of matrices.
    pub(super) most_words: u32,
    /// Surfels, which are the first signals.
    pub(super) surfels: u32,
    /// First signal that is neither a surfel's nor a group's.
    pub(super) first_emitter: u32,
    /// Number of scalar signals.
    pub(super) scalar_signals: u32,
    /// Sources of scalar signals; those of the probes' bands follow.
    pub(super) blocks: u32,
    /// Bands of a probe.
    pub(super) bands: u32,
    /// Coefficients of a probe.
    pub(super) coefficients: u32,
    /// Whose turn it is of the probes, and how many frames they have for their turns.
    pub(super) probe_turn: u32,
    pub(super) probe_turns: u32,
}

/// What is wanted of a cluster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ClusterWish {
    /// What is to be computed.
    pub(super) wanted: ClusterExtent,
    /// Words of matrices that this takes.
    pub(super) words: u32,
    /// The largest change that may wait, as a share of the light.
    pub(super) threshold: f32,
}

/// What is wanted of a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ProbeWish {
    /// What is to be computed.
    pub(super) wanted: ProbeRecord,
    /// The largest change that may wait, as a share of the light, before probes get their share of it.
    pub(super) threshold: f32,
}

/// What waits of a probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ProbeState {
    /// What was last computed.
    pub(super) held: ProbeRecord,
    /// What changed since then.
    pub(super) waiting: Waiting,
}

/// A kernel with its bindings and its number of workgroups.
type Step = (Kernel, wgpu::BindGroup, usize);

/// What waits, and what is computed.
#[derive(Debug)]
pub(super) struct ChooseWork {
    rules: WorkRules,
    uploaded_clusters: Vec<ClusterWish>,
    uploaded_probes: Vec<ProbeWish>,
    buffers: WorkBuffers,
    find_dirty_blocks: Step,
    measure_signals: Step,
    choose_probes: Step,
    measure_bands: Step,
    /// Three kernels, one after the other.
    choose_clusters: [Step; 3],
    note_light: Vec<Step>,
    is_forced: bool,
    /// Number of the present frame.
    frame: u32,
}

/// What only these kernels read and write.
#[derive(Debug)]
struct WorkBuffers {
    rules: wgpu::Buffer,
    cluster_wishes: wgpu::Buffer,
    probe_wishes: wgpu::Buffer,
    states: wgpu::Buffer,
    probe_states: wgpu::Buffer,
    /// What of each cluster was last computed.
    held: wgpu::Buffer,
    /// Words of work of each urgency.
    words: wgpu::Buffer,
    /// Largest change of each source.
    changes: wgpu::Buffer,
    last_signals: wgpu::Buffer,
}

impl WorkBuffers {
    fn new(
        storage: &Storage,
        baked: &BakedScene,
        rules: &WorkRules,
        sources: usize,
        signals: &wgpu::Buffer,
    ) -> Result<Self, GpuError> {
        let (clusters, probes) = (baked.clusters.len(), baked.probes.len());
        let zeros = |content, count: usize, of: usize| storage.zeros(content, (count * of) as u64);
        Ok(Self {
            rules: storage.uniform("rules of a frame", rules),
            cluster_wishes: zeros("wishes of clusters", clusters, size_of::<ClusterWish>())?,
            probe_wishes: zeros("wishes of probes", probes, size_of::<ProbeWish>())?,
            states: zeros("waiting clusters", clusters, size_of::<Waiting>())?,
            probe_states: zeros("waiting probes", probes, size_of::<ProbeState>())?,
            held: zeros("computed clusters", clusters, size_of::<ClusterExtent>())?,
            words: zeros("work of each urgency", URGENCIES, 4)?,
            changes: zeros("changes of sources", sources, 4)?,
            last_signals: storage.zeros("last signals", signals.size())?,
        })
    }
}

impl ChooseWork {
    /// Nothing was computed yet, so the first frame computes everything.
    pub(super) fn new(
        storage: &Storage,
        baked: &BakedScene,
        frame: &FrameBuffers,
        shards: &[ClusterShard],
    ) -> Result<Self, GpuError> {
        let tables = ChangeTables::new(baked);
        let rules = rules(baked, &tables);
        let FrameBuffers { signals, extents, work, .. } = frame;
        let own = WorkBuffers::new(storage, baked, &rules, tables.sources(baked.probes.len()), signals)?;
        let WorkBuffers { rules: r, changes, last_signals, states, held, words, .. } = &own;
        let (wishes, probe_wishes) = (&own.cluster_wishes, &own.probe_wishes);
        let [reflected, reflected_items] = lists(storage, "what surfels reflect", &tables.reflected)?;
        let [probe_starts, probe_terms] = lists(storage, "changes of probes", &tables.probe_terms)?;
        let [starts, terms] = lists(storage, "changes of clusters", &tables.cluster_terms)?;
        let [borders, neighbors] = lists(storage, "neighbouring clusters", &tables.neighbors)?;
        let (blocks, probes) = (rules.blocks as usize, baked.probes.len());
        let step = |shader, workgroups, resources: &[&wgpu::Buffer]| {
            let kernel = Kernel::new(storage.device, shader, None);
            let group = kernel.bind(storage.device, 0, &whole(resources));
            (kernel, group, workgroups)
        };
        let many = |count: usize| count.div_ceil(WORKGROUP);
        let clusters = many(baked.clusters.len());
        let dirty = [r, &reflected, &reflected_items, &work.touched, &work.flags, &work.dirty];
        let measured = [r, signals, last_signals, &work.dirty, &work.flags, changes];
        let of_probes = [r, probe_wishes, &probe_starts, &probe_terms, changes, signals];
        let of_probes = [&of_probes[..], &[&own.probe_states, &extents.probes]].concat();
        let bands = [r, signals, last_signals, &extents.probes, changes];
        let chosen = [r, wishes, &starts, &terms, changes, held, states, words];
        let admitted = [r, wishes, held, states, words, &extents.clusters];
        let touched = [&borders, &neighbors, &extents.clusters, &work.touched, &work.flags];
        let note_light = |shard: &ClusterShard| {
            let strengths = storage.array("strengths of rows", &tables.row_strengths[shard.rows.clone()])?;
            let lit = [&shard.clusters, &strengths, &shard.coefficients, &extents.clusters, states];
            Ok(step(&NOTE_LIGHT, many(shard.cluster_count), &lit))
        };
        Ok(Self {
            find_dirty_blocks: step(&FIND_DIRTY_BLOCKS, many(blocks), &dirty),
            measure_signals: step(&MEASURE_SIGNALS, blocks, &measured),
            choose_probes: step(&CHOOSE_PROBES, many(probes), &of_probes),
            measure_bands: step(&MEASURE_BANDS, probes, &bands),
            choose_clusters: [
                step(&CHOOSE_CLUSTERS, clusters, &chosen),
                step(&ADMIT_CLUSTERS, clusters, &admitted),
                step(&TOUCH_CLUSTERS, clusters, &touched),
            ],
            note_light: shards.iter().map(note_light).collect::<Result<_, GpuError>>()?,
            uploaded_clusters: Vec::new(),
            uploaded_probes: Vec::new(),
            rules,
            buffers: own,
            is_forced: true,
            frame: 0,
        })
    }

    /// Uploads what is wanted of the next frame, as far as it is not there yet.
    pub(super) fn upload(
        &mut self,
        queue: &wgpu::Queue,
        baked: &BakedScene,
        plan: &FramePlan,
        thresholds: &Thresholds,
        lod: &LodSettings,
    ) {
        self.frame = self.frame.wrapping_add(1);
        let rules = WorkRules {
            longest_wait: lod.changes.longest_wait,
            most_words: lod.changes.most_words(baked, self.is_forced),
            probe_turn: self.frame % lod.probe_turns,
            probe_turns: lod.probe_turns,
            ..self.rules
        };
        if rules != self.rules {
            self.rules = rules;
            queue.write_buffer(&self.buffers.rules, 0, bytemuck::bytes_of(&rules));
        }
        let cluster_wishes = cluster_wishes(baked, plan, thresholds);
        if cluster_wishes != self.uploaded_clusters {
            queue.write_buffer(&self.buffers.cluster_wishes, 0, bytemuck::cast_slice(&cluster_wishes));
            self.uploaded_clusters = cluster_wishes;
        }
        let records = probe_records(plan.probes(), baked.relight_directions.len() as u32);
        let wish = |(wanted, threshold): (ProbeRecord, &f32)| ProbeWish { wanted, threshold: *threshold };
        let probe_wishes: Vec<ProbeWish> = records.into_iter().zip(&thresholds.probes).map(wish).collect();
        if probe_wishes != self.uploaded_probes {
            queue.write_buffer(&self.buffers.probe_wishes, 0, bytemuck::cast_slice(&probe_wishes));
            self.uploaded_probes = probe_wishes;
        }
    }

    /// What counts the clusters that wait, once their states are read from the buffer that comes with it.
    pub(super) fn pending_clusters(&self) -> (wgpu::Buffer, impl FnOnce(Vec<Waiting>) -> usize + use<>) {
        let thresholds: Vec<f32> = self.uploaded_clusters.iter().map(|wish| wish.threshold).collect();
        let count = move |clusters: Vec<Waiting>| {
            clusters.iter().zip(thresholds).filter(|(it, threshold)| it.is_pending(*threshold)).count()
        };
        (self.buffers.states.clone(), count)
    }

    /// Makes the next frame compute all clusters and probes, whatever it may cost.
    pub(super) fn forget(&mut self) {
        self.is_forced = true;
    }

    /// Begins a frame whose surfels, or whose sky along relight rays, may shine differently.
    pub(super) fn begin(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameBuffers,
        shine_differently: bool,
        sky_differs: bool,
    ) {
        let is_forced = std::mem::take(&mut self.is_forced);
        encoder.clear_buffer(&self.buffers.words, 0, None);
        // All flags, or all but the first, whether surfels are quiet.
        let first = if shine_differently || is_forced { 0 } else { 4 };
        encoder.clear_buffer(&frame.work.flags, first, None);
        if is_forced {
            encoder.clear_buffer(&self.buffers.held, 0, None);
        }
        if is_forced || sky_differs {
            encoder.clear_buffer(&self.buffers.probe_states, 0, None);
        }
    }

    /// Before surfels are lit.
    pub(super) fn find_dirty_blocks(&self, pass: &mut wgpu::ComputePass) {
        run(pass, &self.find_dirty_blocks);
    }

    /// After surfels were lit.
    pub(super) fn measure_signals(&self, pass: &mut wgpu::ComputePass) {
        run(pass, &self.measure_signals);
    }

    /// Before probes are relit.
    pub(super) fn choose_probes(&self, pass: &mut wgpu::ComputePass) {
        run(pass, &self.choose_probes);
    }

    /// After probes were relit.
    pub(super) fn measure_bands(&self, pass: &mut wgpu::ComputePass) {
        run(pass, &self.measure_bands);
    }

    /// Before clusters are computed.
    pub(super) fn choose_clusters(&self, pass: &mut wgpu::ComputePass) {
        self.choose_clusters.iter().for_each(|step| run(pass, step));
    }

    /// After clusters were computed.
    pub(super) fn note_light(&self, pass: &mut wgpu::ComputePass) {
        self.note_light.iter().for_each(|step| run(pass, step));
    }
}

fn run(pass: &mut wgpu::ComputePass, (kernel, group, workgroups): &Step) {
    kernel.run(pass, &[group], *workgroups);
}

fn rules(baked: &BakedScene, tables: &ChangeTables) -> WorkRules {
    WorkRules {
        longest_wait: 0,
        most_words: 0,
        surfels: baked.surfels.len() as u32,
        first_emitter: baked.first_emitter_signal() as u32,
        scalar_signals: baked.scalar_signals() as u32,
        blocks: tables.blocks as u32,
        bands: tables.bands as u32,
        coefficients: baked.coefficients() as u32,
        probe_turn: 0,
        probe_turns: 1,
    }
}

fn cluster_wishes(baked: &BakedScene, plan: &FramePlan, thresholds: &Thresholds) -> Vec<ClusterWish> {
    let wanted = plan.clusters().iter().zip(&baked.clusters).zip(&thresholds.clusters);
    let wish = |((extent, cluster), threshold): ((&ClusterExtent, _), &f32)| ClusterWish {
        wanted: *extent,
        words: (matrix_bytes(cluster, *extent) / 4) as u32,
        threshold: *threshold,
    };
    wanted.map(wish).collect()
}

/// Where lists begin and what they hold.
fn lists<T: bytemuck::NoUninit>(
    storage: &Storage,
    content: &'static str,
    lists: &Lists<T>,
) -> Result<[wgpu::Buffer; 2], GpuError> {
    Ok([storage.array(content, &lists.starts)?, storage.array(content, &lists.items)?])
}
