//! Scratch memory that is made once and used by one thread at a time.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// One value per worker thread.
#[derive(Debug)]
pub(super) struct PerThread<T>(Vec<Mutex<T>>);

impl<T> PerThread<T> {
    /// As many values as the present pool has threads.
    pub(super) fn new(value: impl Fn() -> T) -> Self {
        Self((0..rayon::current_num_threads()).map(|_| Mutex::new(value())).collect())
    }

    /// The calling thread's value. If a larger pool came since, threads wait for each other.
    pub(super) fn lock(&self) -> MutexGuard<'_, T> {
        let slot = rayon::current_thread_index().unwrap_or(0) % self.0.len();
        self.0[slot].lock().unwrap_or_else(PoisonError::into_inner)
    }
}
