//! Smaller copies of textures: Bevy makes none, and far textures flicker without.

use probelight_math::color::{linear_from_srgb, srgb_from_linear};

/// All levels of an image of four bytes a texel, one after the other, the largest first; and how many there are. A texel is the
/// mean of those it covers: of light, if the bytes are sRGB.
pub(crate) fn with_smaller_levels(width: u32, height: u32, rgba8: &[u8], is_srgb: bool) -> (Vec<u8>, u32) {
    let decode: [f32; 256] = std::array::from_fn(|code| {
        let share = code as f32 / 255.0;
        if is_srgb { linear_from_srgb(share) } else { share }
    });
    let mut bytes = rgba8.to_vec();
    let (mut first, mut width, mut height, mut levels) = (0, width as usize, height as usize, 1);
    while width.max(height) > 1 {
        let next = halved(&bytes[first..], width, height, &decode, is_srgb);
        first = bytes.len();
        bytes.extend(next);
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        levels += 1;
    }
    (bytes, levels)
}

fn halved(rgba8: &[u8], width: usize, height: usize, decode: &[f32; 256], is_srgb: bool) -> Vec<u8> {
    let (columns, rows) = ((width / 2).max(1), (height / 2).max(1));
    let mut bytes = Vec::with_capacity(4 * columns * rows);
    for y in 0..rows {
        for x in 0..columns {
            for channel in 0..4 {
                let is_color = is_srgb && channel < 3;
                let at = |dx: usize, dy: usize| {
                    let (x, y) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
                    let byte = rgba8[4 * (y * width + x) + channel];
                    if is_color { decode[usize::from(byte)] } else { f32::from(byte) / 255.0 }
                };
                let mean = 0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
                let code = if is_color { srgb_from_linear(mean) } else { mean };
                bytes.push((255.0 * code).round() as u8);
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_go_down_to_one_texel_and_keep_the_light() {
        let image: Vec<u8> = [[0, 0, 0, 255], [255, 255, 255, 255]].concat().repeat(4);
        let (bytes, levels) = with_smaller_levels(4, 2, &image, true);
        assert_eq!((bytes.len(), levels), (4 * (8 + 2 + 1), 3));
        // Half the light is sRGB 188, not 128.
        assert_eq!(bytes[4 * 8..], [[188, 188, 188, 255]; 3].concat());
        let (bytes, _) = with_smaller_levels(4, 2, &image, false);
        assert_eq!(bytes[4 * 8..4 * 9], [128, 128, 128, 255]);
    }
}
