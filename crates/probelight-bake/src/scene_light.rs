//! Where the scene's light is evaluated: surfels, emitters, and what relight rays see of them.

use probelight_asset::{BakeSettings, Method, Metric, NONE};
use probelight_math::glam::Vec3;
use probelight_trace::{Hit, Progress, Tracer};

use crate::BakeError;
use crate::atlas::Atlas;
use crate::blur_balance::BlurBalance;
use crate::emitters::Emitters;
use crate::light_ensemble::{EnsembleInput, LightEnsemble};
use crate::receivers::Receivers;
use crate::surfels::SurfelTree;

/// What earlier steps have made of the scene.
pub(crate) struct SceneParts<'a> {
    pub(crate) tracer: &'a Tracer,
    pub(crate) atlas: &'a Atlas,
    pub(crate) receivers: &'a Receivers,
    pub(crate) probes: &'a [Vec3],
}

/// The scene's sources of light for probes and receivers.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneLight {
    /// The file's surfels.
    pub(crate) surfels: SurfelTree,
    /// Per relight ray: the surfel it meets, or [`NONE`] for the sky.
    pub(crate) relight_surfels: Vec<u32>,
    /// What keeps light that probes blur from being lost; nothing does in the paper's method.
    pub(crate) balance: BlurBalance,
    /// Emissive surfaces with signals of their own; none in the paper's method.
    pub(crate) emitters: Emitters,
    /// The signals under random lightings, where the method or the metric needs them.
    pub(crate) ensemble: Option<LightEnsemble>,
}

impl SceneLight {
    /// Builds surfels and emitters, and lights them with random lightings.
    pub(crate) fn prepare(
        parts: &SceneParts<'_>,
        directions: &[Vec3],
        relight_hits: &[Option<Hit>],
        settings: &BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let is_hybrid = settings.method == Method::Hybrid;
        let mut light = Self { balance: BlurBalance::none(relight_hits.len()), ..Self::default() };
        if is_hybrid || settings.metric == Metric::Radiance {
            progress.begin("building surfels", 1);
            let samples = settings.samples_per_surfel as usize;
            let (tracer, atlas) = (parts.tracer, parts.atlas);
            light.surfels =
                SurfelTree::build(tracer.scene(), atlas, parts.receivers, settings.surfel_size, samples);
            light.emitters = Emitters::find(tracer.scene(), settings.surfel_size);
            let surfel = |hit: &Option<Hit>| hit.map_or(NONE, |hit| light.surfels.surfel_of_hit(atlas, &hit));
            light.relight_surfels = relight_hits.iter().map(surfel).collect();
            if is_hybrid {
                light.balance =
                    BlurBalance::of(&light.relight_surfels, directions, settings.sh_degree as usize);
            }
            progress.advance(1);
            let input = EnsembleInput {
                tracer,
                atlas,
                tree: &light.surfels,
                emitters: &light.emitters,
                probes: parts.probes,
                directions,
                relight_surfels: &light.relight_surfels,
                relight_gains: &light.balance.gains,
                sh_degree: settings.sh_degree as usize,
                sky_degree: settings.sky_degree.map(|degree| degree as usize),
                seed: settings.seed,
            };
            light.ensemble = Some(LightEnsemble::light(&input, progress)?);
        }
        if !is_hybrid {
            (light.surfels, light.relight_surfels) = SurfelTree::of_relight_hits(
                parts.tracer,
                parts.atlas,
                parts.probes,
                directions,
                relight_hits,
            );
            light.emitters = Emitters::default();
        }
        Ok(light)
    }
}
