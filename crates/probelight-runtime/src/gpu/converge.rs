//! Frames until light stands still, on the GPU.

#[cfg(feature = "blocking")]
use super::device::wait_for;
use super::{GpuError, GpuRuntime};
use crate::convergence::relative_change;
use crate::{Convergence, FrameInput};

impl GpuRuntime {
    /// Computes frames without a view until the relative change of the receivers' irradiance is at most `tolerance`, at
    /// most `max_steps`; nothing is put off. It waits for the irradiance of each frame: for still pictures, not for real time.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    #[cfg(feature = "blocking")]
    pub fn converge(&mut self, tolerance: f64, max_steps: usize) -> Result<Convergence, GpuError> {
        wait_for(&self.device.clone(), self.converge_async(tolerance, max_steps))
    }

    /// Computes frames without a view until the relative change of the receivers' irradiance is at most `tolerance`, at
    /// most `max_steps`; nothing is put off. It reads the irradiance of each frame: for still pictures, not for real time.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if the GPU does not answer.
    pub async fn converge_async(
        &mut self,
        tolerance: f64,
        max_steps: usize,
    ) -> Result<Convergence, GpuError> {
        let mut previous = self.read_irradiance_async().await?;
        let mut convergence = Convergence { steps: 0, change: f64::INFINITY };
        while convergence.steps < max_steps && convergence.change > tolerance {
            self.forget_work();
            self.step(&FrameInput::default());
            let now = self.read_irradiance_async().await?;
            convergence.steps += 1;
            convergence.change = relative_change(&previous, &now);
            previous = now;
        }
        Ok(convergence)
    }
}
