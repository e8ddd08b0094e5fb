//! What frames on the GPU compute.

use super::choose_work::ChooseWork;
use super::fill_receivers::FillReceivers;
use super::storage::Storage;
use super::{GpuError, GpuRuntime};
#[cfg(doc)]
use crate::RuntimeError;
use crate::{FrameInput, FramePlan, LodSettings};

impl GpuRuntime {
    /// The levels of detail by which frames are planned.
    pub fn lod(&self) -> &LodSettings {
        self.plans.lod()
    }

    /// Changes the levels of detail from the next frame on. The first that let something wait take a fraction of a second
    /// to find out what each signal can change.
    ///
    /// # Errors
    /// See [`LodSettings::check`]; or if the device cannot hold what was found out.
    pub fn set_lod(&mut self, lod: LodSettings) -> Result<(), GpuError> {
        lod.check()?;
        let (lets_wait, coarsest) = (lod.lets_wait(), lod.coarsest_lightmap());
        let storage = Storage::new(&self.device, &self.queue);
        let filled = self.stages.fill_receivers.as_ref().map_or(0, FillReceivers::levels);
        if filled < coarsest as usize {
            let Self { baked, buffers, shards, .. } = self;
            let fills = FillReceivers::new(&storage, baked, buffers, shards, coarsest)?;
            self.stages.fill_receivers = Some(fills);
        }
        if !lets_wait && self.work.take().is_some() {
            self.buffers.work.set_all(&self.queue);
            self.buffers.extents.upload_again(&self.queue, self.plans.plan());
        } else if lets_wait && self.work.is_none() {
            let work = ChooseWork::new(&storage, &self.baked, &self.buffers, &self.shards)?;
            self.work = Some(Box::new(work));
        }
        Ok(self.plans.set_lod(lod)?)
    }

    /// What frames are to keep up to date; everything at first. What of it one computes, the GPU decides where something
    /// may wait, see [`LodChanges`](crate::LodChanges).
    pub fn plan(&self) -> &FramePlan {
        self.plans.plan()
    }

    /// Plans the stages that are encoded from now on.
    pub fn plan_frame(&mut self, input: &FrameInput) {
        self.plans.plan_frame(&self.baked, input, self.state.objects.bounds());
        self.upload_plan();
    }

    fn upload_plan(&mut self) {
        let Self { queue, baked, plans, .. } = self;
        match &mut self.work {
            Some(work) => work.upload(queue, baked, plans.plan(), plans.thresholds(), plans.lod()),
            None => self.buffers.extents.upload(queue, plans.plan()),
        }
    }

    /// Makes the next frame compute all that it is to keep up to date.
    pub(super) fn forget_work(&mut self) {
        if let Some(work) = &mut self.work {
            work.forget();
        }
    }

    /// Takes a plan of the caller's for the stages that are encoded from now on. Nothing of the next frame waits.
    ///
    /// # Errors
    /// [`RuntimeError::ForeignPlan`] if the plan is one for another scene.
    pub fn set_plan(&mut self, plan: &FramePlan) -> Result<(), GpuError> {
        self.plans.set_plan(&self.baked, plan)?;
        self.forget_work();
        self.upload_plan();
        Ok(())
    }
}
