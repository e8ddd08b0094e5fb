//! Pictures as a screen shows them.

use probelight_math::color::srgb8_from_linear;

use crate::Image;

/// 8-bit sRGB pixels, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayImage {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// `width × height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl DisplayImage {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, pixel: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![pixel; width as usize * height as usize] }
    }

    /// A linear picture of colours from 0 to 1 as it is, without exposure and curve.
    pub fn from_colors(image: &Image) -> Self {
        let pixels = image.pixels.iter().map(|pixel| srgb8_from_linear(*pixel)).collect();
        Self { width: image.width, height: image.height, pixels }
    }

    /// The pixel in column `x` of row `y`, counted from the top left.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Copies `picture` into this one with its top left corner at column `x` of row `y`; what does not fit
    /// is cut off.
    pub fn paste(&mut self, picture: &Self, x: u32, y: u32) {
        let width = picture.width.min(self.width.saturating_sub(x)) as usize;
        let height = picture.height.min(self.height.saturating_sub(y));
        for row in 0..height {
            let from = row as usize * picture.width as usize;
            let to = (y + row) as usize * self.width as usize + x as usize;
            self.pixels[to..to + width].copy_from_slice(&picture.pixels[from..from + width]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paste_cuts_off_what_does_not_fit() {
        let mut sheet = DisplayImage::filled(4, 4, [0; 3]);
        sheet.paste(&DisplayImage::filled(3, 3, [9; 3]), 2, 3);
        let lit = sheet.pixels.iter().filter(|p| **p == [9; 3]).count();
        assert_eq!(
            (lit, sheet.pixel(2, 3), sheet.pixel(3, 3), sheet.pixel(2, 2)),
            (2, [9; 3], [9; 3], [0; 3])
        );
        sheet.paste(&DisplayImage::filled(3, 3, [1; 3]), 10, 10);
    }
}
