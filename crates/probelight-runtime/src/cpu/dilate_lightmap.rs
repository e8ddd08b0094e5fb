//! Stage 5: fills the texels around charts that bilinear lookups touch.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;

use super::scatter::Scatter;
use crate::IrradianceLightmap;

/// Which receiver each texel outside the charts repeats.
#[derive(Clone, Debug)]
pub struct Dilation {
    copies: Scatter,
}

impl Dilation {
    /// Prepares the copies. Their sources are receivers, so that no copy waits for another.
    pub fn new(baked: &BakedScene) -> Self {
        let (receivers, clusters) = (baked.receivers_of_chart_texels(), baked.clusters_of_receivers());
        let pairs = baked.lightmap.dilation.iter();
        let pairs = pairs.map(|[texel, source]| (*texel, receivers[*source as usize]));
        Self { copies: Scatter::new(pairs, |receiver| clusters[receiver as usize]) }
    }

    /// Copies the receivers' irradiance (in the order of `receiver_texels`) to the texels around the charts, at least that
    /// of the clusters (by number) that are touched.
    pub fn dilate_lightmap(
        &self,
        receivers: &[Vec3],
        lightmap: &mut IrradianceLightmap,
        is_touched: impl Fn(u32) -> bool + Sync,
    ) {
        self.copies.copy(receivers, &mut lightmap.texels, is_touched);
    }
}
