//! Which surfel each lightmap texel belongs to.

use std::collections::VecDeque;

use probelight_asset::{BakedScene, NONE};

/// The surfel of each texel that a chart reaches or lookups touch, else [`NONE`]. A texel without a light sample belongs to
/// the surfel of the nearest that has one: surfels are compact, and samples spread over all of each.
pub(crate) fn surfels_of_texels(baked: &BakedScene) -> Vec<u32> {
    let (width, texels) =
        (baked.lightmap.width as usize, baked.lightmap.width as usize * baked.lightmap.height as usize);
    let mut is_needed = vec![false; texels];
    for texel in baked.receiver_texels.iter().chain(baked.lightmap.dilation.iter().map(|[texel, _]| texel)) {
        is_needed[*texel as usize] = true;
    }
    let mut surfels = vec![NONE; texels];
    let mut front = VecDeque::new();
    for (number, surfel) in (0..).zip(&baked.surfels) {
        for texel in baked.samples_of(surfel).iter().map(|sample| baked.texel_of(sample) as usize) {
            if let Some(surfel) = surfels.get_mut(texel).filter(|surfel| **surfel == NONE) {
                *surfel = number;
                front.push_back(texel);
            }
        }
    }
    // No chart touches another, so what spreads stays in its chart.
    while let Some(texel) = front.pop_front() {
        let (x, surfel) = (texel % width, surfels[texel]);
        let left = (x > 0).then(|| texel - 1);
        let right = (x + 1 < width).then_some(texel + 1);
        for next in [left, right, texel.checked_sub(width), Some(texel + width)].into_iter().flatten() {
            if is_needed.get(next) == Some(&true) && surfels[next] == NONE {
                surfels[next] = surfel;
                front.push_back(next);
            }
        }
    }
    surfels
}
