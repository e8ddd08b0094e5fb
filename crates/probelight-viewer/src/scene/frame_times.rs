//! How long frames take, measured without stopping the GPU.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use probelight_runtime::StageTimings;
use probelight_runtime::gpu::{FrameTimestamps, GpuDevice, GpuError};
use web_time::Instant;

use super::pending::Pending;

/// Frames that are shown.
pub const SHOWN_FRAMES: usize = 240;

/// Queries that may be on their way at once.
const RING: usize = 3;

/// What is known of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameTime {
    /// From one frame of the window to the next.
    pub interval: Duration,
    /// What the host spent on the window: panels and commands.
    pub host: Duration,
    /// The light's stages by the GPU's clock.
    pub light: Option<StageTimings>,
}

/// Times of the last frames.
pub struct FrameTimes {
    ring: Vec<Arc<FrameTimestamps>>,
    pending: VecDeque<(usize, Pending<Result<StageTimings, GpuError>>)>,
    next: usize,
    frames: VecDeque<FrameTime>,
    last: Option<Instant>,
    started: Option<Instant>,
    first_picture: Option<Duration>,
}

impl FrameTimes {
    /// For frames on a GPU of a program that began then; without queries of time, stages have none.
    pub fn new(gpu: &GpuDevice, started: Option<Instant>) -> Self {
        let timestamps = || FrameTimestamps::new(&gpu.device, &gpu.queue).map(Arc::new);
        Self {
            ring: (0..RING).filter_map(|_| timestamps()).collect(),
            pending: VecDeque::new(),
            next: 0,
            frames: VecDeque::new(),
            last: None,
            started,
            first_picture: None,
        }
    }

    /// There is a picture.
    pub fn note_picture(&mut self) {
        if let Some(started) = self.started.take() {
            self.first_picture = Some(started.elapsed());
        }
    }

    /// From the beginning of the program to its first picture.
    pub fn first_picture(&self) -> Option<Duration> {
        self.first_picture
    }

    /// Queries for the next frame, if some are free.
    pub fn queries(&self) -> Option<Arc<FrameTimestamps>> {
        let is_free = self.pending.iter().all(|(used, _)| *used != self.next);
        self.ring.get(self.next).filter(|_| is_free).cloned()
    }

    /// The queries were submitted.
    pub fn submitted(&mut self, gpu: &GpuDevice, queries: Arc<FrameTimestamps>) {
        let (device, queue) = (gpu.device.clone(), gpu.queue.clone());
        let read = async move { queries.read_async(&device, &queue).await };
        self.pending.push_back((self.next, Pending::new(read)));
        self.next = (self.next + 1) % RING;
    }

    /// Notes a frame: what the host spent on it. Returns the light's time of a frame before, if it has become known.
    pub fn note(&mut self, host: Duration) -> Option<Duration> {
        let now = Instant::now();
        let interval = self.last.map_or(Duration::ZERO, |last| now - last);
        self.last = Some(now);
        let read = self.pending.front_mut().and_then(|(_, pending)| pending.poll());
        if read.is_some() {
            self.pending.pop_front();
        }
        let light = read.and_then(Result::ok);
        if self.frames.len() == SHOWN_FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(FrameTime { interval, host, light });
        light.map(|light| light.frame)
    }

    /// The window rests: the pause is not a slow frame.
    pub fn rest(&mut self) {
        self.last = None;
    }

    /// The last frames, the oldest first.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &FrameTime> {
        self.frames.iter()
    }

    /// Stages of the last frame that was measured.
    pub fn last_light(&self) -> Option<&StageTimings> {
        self.frames.iter().rev().find_map(|frame| frame.light.as_ref())
    }

    /// Mean interval of the last second of frames.
    pub fn mean_interval(&self) -> Option<Duration> {
        let intervals = || self.frames.iter().rev().map(|f| f.interval).filter(|i| !i.is_zero()).take(60);
        let count = intervals().count() as u32;
        (count > 0).then(|| intervals().sum::<Duration>() / count)
    }
}
