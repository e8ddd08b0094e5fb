//! The plan of a runtime's next frame, and what it is made by.

use probelight_asset::BakedScene;
use probelight_scene::Bounds;

use super::input::FrameInput;
use super::lod::LodSettings;
use super::plan::FramePlan;
use super::planner::{Planner, Thresholds};
use crate::RuntimeError;

/// Levels of detail and the present plan; everything at first.
#[derive(Clone, Debug)]
pub(crate) struct FramePlans {
    planner: Planner,
    lod: LodSettings,
    plan: FramePlan,
    /// All boxes around what moves.
    active_boxes: Vec<Bounds>,
}

impl FramePlans {
    pub(crate) fn new(baked: &BakedScene) -> Self {
        let (planner, plan) = (Planner::new(baked), FramePlan::full(baked));
        Self { planner, lod: LodSettings::default(), plan, active_boxes: Vec::new() }
    }

    pub(crate) fn lod(&self) -> &LodSettings {
        &self.lod
    }

    pub(crate) fn set_lod(&mut self, lod: LodSettings) -> Result<(), RuntimeError> {
        lod.check()?;
        self.lod = lod;
        Ok(())
    }

    pub(crate) fn plan(&self) -> &FramePlan {
        &self.plan
    }

    /// What of the plan may wait.
    pub(crate) fn thresholds(&self) -> &Thresholds {
        self.planner.thresholds()
    }

    /// Plans the next frame, with boxes around the scene's own objects. Allocates nothing, unless there are more than ever.
    pub(crate) fn plan_frame(&mut self, baked: &BakedScene, input: &FrameInput, objects: &[Bounds]) {
        self.active_boxes.clear();
        self.active_boxes.extend(input.active_boxes.iter().chain(objects));
        let input = FrameInput { active_boxes: &self.active_boxes, ..*input };
        self.planner.plan(baked, &self.lod, &input, &mut self.plan);
    }

    /// Takes another's plan for the next frame.
    pub(crate) fn set_plan(&mut self, baked: &BakedScene, plan: &FramePlan) -> Result<(), RuntimeError> {
        let planned = [plan.clusters().len(), plan.probes().len()];
        if planned != [baked.clusters.len(), baked.probes.len()] {
            return Err(RuntimeError::ForeignPlan);
        }
        // Once more, in case that only the numbers are the same.
        self.plan.fill(baked, |cluster| plan.clusters()[cluster], |probe| plan.probes()[probe]);
        Ok(())
    }
}
