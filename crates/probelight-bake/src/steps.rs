//! Steps of the bake that can be watched and stopped.

use probelight_trace::Progress;
use rayon::prelude::*;

use crate::BakeError;

/// Does `work` for each item in parallel, as one stage with as many steps. The results keep the items' order.
///
/// # Errors
/// [`BakeError::Cancelled`] if `progress` asks to stop; no further item is begun then.
pub(crate) fn for_each_in_parallel<I: IndexedParallelIterator, R: Send>(
    stage: &str,
    items: I,
    progress: &dyn Progress,
    work: impl Fn(I::Item) -> R + Sync + Send,
) -> Result<Vec<R>, BakeError> {
    progress.begin(stage, items.len() as u64);
    let step = |item| {
        (!progress.is_cancelled()).then(|| {
            let result = work(item);
            progress.advance(1);
            result
        })
    };
    items.map(step).collect::<Option<Vec<R>>>().ok_or(BakeError::Cancelled)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    /// Asks to stop after some steps.
    struct StopAfter {
        steps: u64,
        done: AtomicU64,
    }

    impl StopAfter {
        fn new(steps: u64) -> Self {
            Self { steps, done: AtomicU64::new(0) }
        }
    }

    impl Progress for StopAfter {
        fn begin(&self, _stage: &str, total: u64) {
            assert_eq!(total, 1000);
        }

        fn advance(&self, steps: u64) {
            self.done.fetch_add(steps, Ordering::Relaxed);
        }

        fn is_cancelled(&self) -> bool {
            self.done.load(Ordering::Relaxed) >= self.steps
        }
    }

    #[test]
    fn results_keep_their_order_and_a_wish_to_stop_is_obeyed_at_once() {
        let patient = StopAfter::new(1001);
        let square = |progress: &StopAfter| {
            for_each_in_parallel("squaring", (0..1000u32).into_par_iter(), progress, |i| i * i)
        };
        let squares = square(&patient).unwrap();
        assert_eq!(squares, (0..1000).map(|i| i * i).collect::<Vec<u32>>());
        assert_eq!(patient.done.into_inner(), 1000);

        let impatient = StopAfter::new(10);
        assert!(matches!(square(&impatient), Err(BakeError::Cancelled)));
        let begun_before = rayon::current_num_threads() as u64;
        assert!(impatient.done.into_inner() < 10 + begun_before);
    }
}
