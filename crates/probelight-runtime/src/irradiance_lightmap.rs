//! The frame's result: irradiance per lightmap texel.

#[cfg(feature = "cpu")]
use probelight_asset::LightmapLayout;
use probelight_math::glam::{Vec2, Vec3};
#[cfg(feature = "cpu")]
use probelight_trace::Tracer;

#[cfg(feature = "cpu")]
use crate::lightmap_position::lightmap_position;

/// Irradiance that the signals bring: light that bounced, the sky, and emissive surfaces, W/m².
/// Light straight from analytic lights is not in it.
///
/// Texels keep what the linear system yields, which truncation can make slightly negative; reading with
/// [`sample`](Self::sample) clamps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IrradianceLightmap {
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// Row by row from the top, `width × height`; zero where no chart lies.
    pub texels: Vec<Vec3>,
}

impl IrradianceLightmap {
    /// Black.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, texels: vec![Vec3::ZERO; width as usize * height as usize] }
    }

    /// Irradiance between the four texels around a position, W/m², never negative.
    ///
    /// The position is in texels; the centre of texel (x, y) is (x + ½, y + ½). Charts are padded, so that a
    /// position inside a chart only meets texels of that chart. Positions outside the image take its border.
    #[inline]
    pub fn sample(&self, position: Vec2) -> Vec3 {
        if self.texels.is_empty() {
            return Vec3::ZERO;
        }
        let weighted = Self::footprint([self.width, self.height], position)
            .map(|(texel, weight)| self.texels[texel as usize] * weight);
        weighted.into_iter().sum::<Vec3>().max(Vec3::ZERO)
    }

    /// The four texels that [`sample`](Self::sample) reads in a lightmap of `[width, height]` texels, neither zero, and
    /// what each counts; their sum is one.
    #[inline]
    pub fn footprint([width, height]: [u32; 2], position: Vec2) -> [(u32, f32); 4] {
        let last = Vec2::new((width - 1) as f32, (height - 1) as f32);
        // `max` before `min` turns NaN into the first texel.
        let position = (position - 0.5).max(Vec2::ZERO).min(last);
        let corner = position.floor();
        let after = position - corner;
        let before = 1.0 - after;
        let (x, y) = (corner.x as u32, corner.y as u32);
        let right = u32::from(x + 1 < width);
        let below = if y + 1 < height { width } else { 0 };
        let at = y * width + x;
        [
            (at, before.x * before.y),
            (at + right, after.x * before.y),
            (at + below, before.x * after.y),
            (at + below + right, after.x * after.y),
        ]
    }

    /// Irradiance (W/m²) of the surface at a world position, on its side towards `normal` (unit). `None` if the
    /// tracer's scene has no such surface within a thousandth of its diagonal. Sides without light of their own,
    /// such as the insides of solids, are dark.
    #[cfg(feature = "cpu")]
    pub fn irradiance_at(
        &self,
        tracer: &Tracer,
        layout: &LightmapLayout,
        position: Vec3,
        normal: Vec3,
    ) -> Option<Vec3> {
        let texel = lightmap_position(tracer, layout, position, normal)?;
        Some(texel.map_or(Vec3::ZERO, |texel| self.sample(texel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> IrradianceLightmap {
        let mut lightmap = IrradianceLightmap::new(3, 2);
        for (i, texel) in lightmap.texels.iter_mut().enumerate() {
            *texel = Vec3::new((i % 3) as f32, (i / 3) as f32, 1.0);
        }
        lightmap
    }

    #[test]
    fn sampling_reproduces_texels_and_linear_ramps() {
        let lightmap = ramp();
        assert_eq!(lightmap.sample(Vec2::new(1.5, 0.5)), Vec3::new(1.0, 0.0, 1.0));
        let between = lightmap.sample(Vec2::new(1.75, 0.9));
        assert!(between.abs_diff_eq(Vec3::new(1.25, 0.4, 1.0), 1e-6), "{between}");
    }

    #[test]
    fn sampling_clamps_position_and_value() {
        let mut lightmap = ramp();
        assert_eq!(lightmap.sample(Vec2::new(-9.0, 9.0)), Vec3::new(0.0, 1.0, 1.0));
        assert_eq!(lightmap.sample(Vec2::new(f32::INFINITY, 0.0)), Vec3::new(2.0, 0.0, 1.0));
        assert_eq!(lightmap.sample(Vec2::NAN), Vec3::new(0.0, 0.0, 1.0));
        lightmap.texels[0] = -Vec3::ONE;
        assert_eq!(lightmap.sample(Vec2::ZERO), Vec3::ZERO);
        assert_eq!(IrradianceLightmap::default().sample(Vec2::ONE), Vec3::ZERO);
    }
}
