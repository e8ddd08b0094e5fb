//! The first steps of a bake of a bundled scene, for tests of the later ones.

use std::path::Path;
use std::sync::Arc;

use probelight_math::directions::progressive_sphere;
use probelight_scene::load_gltf;
use probelight_trace::{Silent, Tracer};

use crate::BakeOptions;
use crate::air_spaces::assign_outlooks;
use crate::atlas::Atlas;
use crate::cut::cut_along_walls;
use crate::gather::{GatherRay, gather_rays};
use crate::layout::fit_layout;
use crate::options::Resolved;
use crate::point_grid::PointGrid;
use crate::probes::place_probes;
use crate::receivers::{Receivers, place_receivers};
use crate::relight::trace_relight_rays;
use crate::scene_light::{SceneLight, SceneParts};
use crate::sides::LitSides;

/// A scene that is ready for its groups to be baked.
pub(crate) struct SmallScene {
    pub(crate) tracer: Tracer,
    pub(crate) atlas: Atlas,
    pub(crate) receivers: Receivers,
    pub(crate) light: SceneLight,
    pub(crate) resolved: Resolved,
}

impl SmallScene {
    /// `assets/scenes/NAME` with about 1500 receivers.
    pub(crate) fn load(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name);
        let options = BakeOptions {
            receivers: Some(1500),
            relight_rays: Some(64),
            sh_degree: Some(2),
            ..BakeOptions::default()
        };
        let tracer = Tracer::new(Arc::new(load_gltf(&path).unwrap()));
        let mut resolved = options.resolve(&tracer).unwrap();
        let cut = cut_along_walls(tracer.scene(), resolved.estimated_texel_size(tracer.scene()));
        let tracer = Tracer::new(Arc::new(cut.scene));
        let lit_sides = LitSides::find(&tracer, resolved.smallest_spacing() * 0.5, 0);
        let atlas = fit_layout(&tracer, &lit_sides, &cut.seams, false, &mut resolved, &Silent).unwrap();
        let mut receivers = place_receivers(&tracer, &atlas, &lit_sides);
        let probes = place_probes(&tracer, &resolved, &lit_sides, &receivers.receivers, &Silent).unwrap();
        let directions = progressive_sphere(resolved.settings.relight_rays as usize);
        let hits = trace_relight_rays(&tracer, &probes, &directions, &Silent).unwrap();
        let grid = PointGrid::of(&probes, resolved.settings.probe_spacing * 0.5);
        assign_outlooks(&tracer, &grid, &directions, &hits, &mut receivers.receivers);
        let texel_size = 1.0 / resolved.settings.texels_per_meter;
        receivers.points.keep_those_in_sight(&tracer, &receivers.receivers, &grid, texel_size);
        let parts = SceneParts { tracer: &tracer, atlas: &atlas, receivers: &receivers, probes: &probes };
        let light = SceneLight::prepare(&parts, &directions, &hits, &resolved.settings, &Silent).unwrap();
        Self { tracer, atlas, receivers, light, resolved }
    }

    /// Gather rays of a receiver.
    pub(crate) fn gather(&self, receiver: u32, rays: u32) -> Vec<GatherRay> {
        let texel = self.receivers.receivers[receiver as usize].texel;
        gather_rays(&self.tracer, texel, self.receivers.points.of(receiver), rays, 0).collect()
    }
}
