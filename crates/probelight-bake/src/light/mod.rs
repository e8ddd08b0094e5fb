//! Where the scene's light is evaluated: surfels, emitters, and what relight rays see of them.

pub(crate) mod blur_balance;
pub(crate) mod emitters;
pub(crate) mod ensemble;
pub(crate) mod form_factors;
mod random_lights;
mod surfel_builder;
pub(crate) mod surfels;

use probelight_asset::{Metric, NONE};
use probelight_trace::Progress;

use crate::BakeError;
use crate::ground::Groundwork;
use crate::light::blur_balance::BlurBalance;
use crate::light::emitters::Emitters;
use crate::light::ensemble::LightEnsemble;
use crate::light::surfels::SurfelTree;
use crate::options::SurfaceSignals;

/// The scene's sources of light for probes and sites.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSources {
    /// The file's surfels.
    pub(crate) surfels: SurfelTree,
    /// Per relight ray: the surfel it meets, or [`NONE`] for the sky.
    pub(crate) relight_surfels: Vec<u32>,
    /// What keeps light that probes blur from being lost; nothing does in the paper's method.
    pub(crate) balance: BlurBalance,
    /// Emissive surfaces with signals of their own; none in the paper's method.
    pub(crate) emitters: Emitters,
}

/// The scene's light: where it comes from, and what it may be.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneLight {
    pub(crate) sources: LightSources,
    /// The signals under random lightings, where the method or the metric needs them.
    pub(crate) ensemble: Option<LightEnsemble>,
}

impl SceneLight {
    /// Builds surfels and emitters, and lights them with random lightings.
    pub(crate) fn prepare(ground: &Groundwork, progress: &dyn Progress) -> Result<Self, BakeError> {
        let of_rays = || LightSources::of_relight_hits(ground);
        match (ground.plan.surfaces, ground.settings.metric) {
            (SurfaceSignals::RelightHits, Metric::Plain | Metric::Band) => {
                Ok(Self { sources: of_rays(), ensemble: None })
            }
            (surfaces, _) => {
                progress.begin("building surfels", 1);
                let sources = LightSources::of_patches(ground);
                progress.advance(1);
                let ensemble = Some(LightEnsemble::light(ground, &sources, progress)?);
                // Bounces of the ensemble need patches; the file has what the method asks for.
                let sources = if surfaces == SurfaceSignals::Patches { sources } else { of_rays() };
                Ok(Self { sources, ensemble })
            }
        }
    }
}

impl LightSources {
    /// Surfels and the groups above them, and emitters of their own.
    fn of_patches(ground: &Groundwork) -> Self {
        let surfels = SurfelTree::build(ground);
        let surfel = |hit: &Option<_>| hit.map_or(NONE, |hit| surfels.surfel_of_hit(&ground.atlas, &hit));
        let relight_surfels: Vec<u32> = ground.relight_hits.iter().map(surfel).collect();
        let balance = if ground.plan.has_scalar_signals() {
            BlurBalance::of(&relight_surfels, &ground.directions, ground.settings.sh_degree as usize)
        } else {
            BlurBalance::none(relight_surfels.len())
        };
        let emitters = Emitters::find(ground.tracer.scene(), ground.settings.surfel_size);
        Self { surfels, relight_surfels, balance, emitters }
    }

    /// A surfel for each relight ray that meets a surface.
    fn of_relight_hits(ground: &Groundwork) -> Self {
        let (surfels, relight_surfels) = SurfelTree::of_relight_hits(ground);
        let balance = BlurBalance::none(relight_surfels.len());
        Self { surfels, relight_surfels, balance, emitters: Emitters::default() }
    }
}
