//! Stage 5: fills the texels around charts that bilinear lookups touch.

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;

use super::scatter::Scatter;
use crate::IrradianceLightmap;
use crate::frame::ReceiverPlace;

/// Which receiver each texel outside the charts repeats.
#[derive(Clone, Debug)]
pub struct Dilation {
    copies: Scatter,
}

impl Dilation {
    /// Prepares the copies. Their sources are receivers, so that no copy waits for another.
    pub fn new(baked: &BakedScene) -> Self {
        let mut receiver_of_texel = vec![u32::MAX; texel_count(baked)];
        for (receiver, texel) in (0u32..).zip(&baked.receiver_texels) {
            receiver_of_texel[*texel as usize] = receiver;
        }
        let pairs = baked.lightmap.dilation.iter();
        let pairs = pairs.map(|[texel, source]| (*texel, receiver_of_texel[*source as usize]));
        let cluster = |receiver| ReceiverPlace::at(&baked.clusters, receiver).cluster;
        Self { copies: Scatter::new(pairs, cluster) }
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

fn texel_count(baked: &BakedScene) -> usize {
    baked.lightmap.width as usize * baked.lightmap.height as usize
}
