//! Work beside the window: a thread for each.

use std::future::Future;

/// Does some work in a thread of its own.
pub fn spawn<F: Future<Output = ()>>(work: impl FnOnce() -> F + Send + 'static) {
    std::thread::spawn(move || pollster::block_on(work()));
}

/// Lets others do something between two steps of work: threads need not be asked.
pub async fn breathe() {}
