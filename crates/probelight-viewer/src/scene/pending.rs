//! Answers of the GPU that are on their way: nothing waits for them.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

/// A result that is there some frames later.
pub struct Pending<T>(Pin<Box<dyn Future<Output = T>>>);

impl<T> Pending<T> {
    /// Of work that has to be asked for its result now and then.
    pub fn new(work: impl Future<Output = T> + 'static) -> Self {
        Self(Box::pin(work))
    }

    /// The result, if it is there. After that there is no other.
    pub fn poll(&mut self) -> Option<T> {
        match self.0.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(result) => Some(result),
            Poll::Pending => None,
        }
    }
}

/// Takes the result out of a slot if it is there; the slot is then free.
pub fn take_ready<T>(slot: &mut Option<Pending<T>>) -> Option<T> {
    let result = slot.as_mut()?.poll()?;
    *slot = None;
    Some(result)
}
