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
    // Where rounding moved the sample of a sliver into the texel of another surfel, it leaves the texel to that.
    let mut by_area: Vec<u32> = (0..baked.surfels.len() as u32).collect();
    let area = |number: &u32| {
        let surfel = &baked.surfels[*number as usize];
        surfel.area / surfel.sample_count as f32
    };
    by_area.sort_by(|a, b| area(b).total_cmp(&area(a)));
    for number in by_area {
        let samples = baked.samples_of(&baked.surfels[number as usize]);
        for texel in samples.iter().map(|sample| baked.texel_of(sample) as usize) {
            if let Some(surfel) = surfels.get_mut(texel).filter(|surfel| **surfel == NONE) {
                *surfel = number;
                front.push_back(texel);
            }
        }
    }
    // No chart touches another, so what spreads stays in its chart.
    while let Some(texel) = front.pop_front() {
        let (x, y, surfel) = (texel % width, texel / width, surfels[texel]);
        let around = (y.saturating_sub(1)..=y + 1)
            .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| y * width + x));
        for next in around {
            if is_needed.get(next) == Some(&true) && surfels[next] == NONE {
                surfels[next] = surfel;
                front.push_back(next);
            }
        }
    }
    surfels
}
