//! Where work in the background stands.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui::Context;
use probelight_trace::Progress;
use web_time::Instant;

/// How often the window hears of progress.
const INTERVAL: Duration = Duration::from_millis(100);

/// A stage of the work.
#[derive(Clone, Debug)]
struct Stage {
    name: String,
    total: u64,
    since: Instant,
    told: Instant,
}

/// Shared by the work and the window.
#[derive(Debug)]
pub struct BackgroundProgress {
    stage: Mutex<Stage>,
    done: AtomicU64,
    is_cancelled: AtomicBool,
    context: Context,
}

/// What the window shows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// The stage's name.
    pub stage: String,
    /// Share of the stage that is done.
    pub share: f32,
    /// Time left in this stage, at the speed so far; `None` as long as nothing is known.
    pub left: Option<Duration>,
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:.0} %", self.stage, 100.0 * self.share)?;
        match self.left {
            Some(left) => write!(f, ", {} s left in this step", left.as_secs()),
            None => Ok(()),
        }
    }
}

impl BackgroundProgress {
    /// Of work that begins now.
    pub fn new(context: &Context) -> Arc<Self> {
        let now = Instant::now();
        Arc::new(Self {
            stage: Mutex::new(Stage { name: "begins".into(), total: 1, since: now, told: now }),
            done: AtomicU64::new(0),
            is_cancelled: AtomicBool::new(false),
            context: context.clone(),
        })
    }

    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Where it stands.
    pub fn standing(&self) -> Standing {
        let stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let share = self.done.load(Ordering::Relaxed) as f32 / stage.total.max(1) as f32;
        let elapsed = stage.since.elapsed();
        let is_known = share > 0.02 && elapsed > Duration::from_millis(500);
        let left = is_known.then(|| elapsed.mul_f32((1.0 / share - 1.0).max(0.0)));
        Standing { stage: stage.name, share: share.min(1.0), left }
    }
}

impl Progress for BackgroundProgress {
    fn begin(&self, stage: &str, total: u64) {
        let now = Instant::now();
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) =
            Stage { name: stage.into(), total, since: now, told: now };
        self.done.store(0, Ordering::Relaxed);
        self.context.request_repaint();
    }

    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        // Whoever finds the lock taken leaves it to the other to tell.
        let Ok(mut stage) = self.stage.try_lock() else { return };
        if stage.told.elapsed() > INTERVAL {
            stage.told = Instant::now();
            self.context.request_repaint();
        }
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}
