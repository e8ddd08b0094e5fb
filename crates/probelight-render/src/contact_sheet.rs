//! Pictures side by side with titles.

use std::convert::Infallible;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::ascii::{FONT_6X13, FONT_9X18_BOLD};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable, Pixel};

use crate::DisplayImage;

/// A grid of equally large pictures: a title on top, a title over each column, a caption under each row.
///
/// ```text
/// title
/// column 0     column 1     …
/// ┌─────────┐ ┌─────────┐
/// │  0, 0   │ │  0, 1   │
/// └─────────┘ └─────────┘
/// caption of row 0
/// ```
#[derive(Clone, Debug, Default)]
pub struct ContactSheet {
    /// Over everything.
    pub title: String,
    /// One per column.
    pub columns: Vec<String>,
    /// From the top.
    pub rows: Vec<ContactSheetRow>,
}

/// One row of a [`ContactSheet`].
#[derive(Clone, Debug, Default)]
pub struct ContactSheetRow {
    /// Under the row's pictures.
    pub caption: String,
    /// One per column; missing ones leave a gap.
    pub pictures: Vec<DisplayImage>,
}

/// Space between pictures and around them, pixels.
const GAP: u32 = 8;
/// Height of a line of the title, the column titles and the captions, pixels.
const LINE: u32 = 22;
const BACKGROUND: [u8; 3] = [24; 3];
const TITLE_FONT: &MonoFont = &FONT_9X18_BOLD;
const CAPTION_FONT: &MonoFont = &FONT_6X13;

impl ContactSheet {
    /// Size of a picture's cell: the largest width and height of all.
    fn cell(&self) -> (u32, u32) {
        let pictures = self.rows.iter().flat_map(|row| &row.pictures);
        pictures.fold((0, 0), |(w, h), picture| (w.max(picture.width), h.max(picture.height)))
    }

    /// Top left corner of the picture in `column` of `row`, pixels of the sheet.
    pub fn position(&self, row: usize, column: usize) -> (u32, u32) {
        let (width, height) = self.cell();
        let x = GAP + column as u32 * (width + GAP);
        let y = GAP + 2 * LINE + row as u32 * (height + LINE + GAP);
        (x, y)
    }

    /// Draws the sheet. Characters outside ASCII are drawn as `?`.
    pub fn draw(&self) -> DisplayImage {
        let columns = self.rows.iter().map(|row| row.pictures.len()).fold(self.columns.len(), usize::max);
        let (width, height) = self.position(self.rows.len(), columns);
        let mut sheet = DisplayImage::filled(width, height, BACKGROUND);
        sheet.write_text(&self.title, GAP, GAP, TITLE_FONT);
        for (column, title) in self.columns.iter().enumerate() {
            sheet.write_text(title, self.position(0, column).0, GAP + LINE, CAPTION_FONT);
        }
        for (r, row) in self.rows.iter().enumerate() {
            for (column, picture) in row.pictures.iter().enumerate() {
                let (x, y) = self.position(r, column);
                sheet.paste(picture, x, y);
            }
            let (x, y) = self.position(r, 0);
            sheet.write_text(&row.caption, x, y + self.cell().1 + 3, CAPTION_FONT);
        }
        sheet
    }
}

impl DisplayImage {
    fn write_text(&mut self, text: &str, x: u32, y: u32, font: &MonoFont) {
        let style = MonoTextStyle::new(font, Rgb888::WHITE);
        let Ok(_) =
            Text::with_baseline(text, Point::new(x as i32, y as i32), style, Baseline::Top).draw(self);
    }
}

impl OriginDimensions for DisplayImage {
    fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }
}

impl DrawTarget for DisplayImage {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(point, color) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(point.x), u32::try_from(point.y)) else { continue };
            if x < self.width && y < self.height {
                let at = y as usize * self.width as usize + x as usize;
                self.pixels[at] = [color.r(), color.g(), color.b()];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> ContactSheet {
        let picture = |code| DisplayImage::filled(40, 30, [code; 3]);
        ContactSheet {
            title: "Title".into(),
            columns: vec!["a".into(), "b".into()],
            rows: vec![
                ContactSheetRow { caption: "first".into(), pictures: vec![picture(1), picture(2)] },
                ContactSheetRow { caption: "second".into(), pictures: vec![picture(3), picture(4)] },
            ],
        }
    }

    #[test]
    fn every_picture_lies_whole_in_its_cell() {
        let sheet = sheet();
        let drawn = sheet.draw();
        for (row, column, code) in [(0, 0, 1), (0, 1, 2), (1, 0, 3), (1, 1, 4)] {
            let (x, y) = sheet.position(row, column);
            let inside = (y..y + 30).flat_map(|y| (x..x + 40).map(move |x| (x, y)));
            assert!(inside.into_iter().all(|(x, y)| drawn.pixel(x, y) == [code; 3]), "{row} {column}");
            assert_eq!(drawn.pixels.iter().filter(|p| **p == [code; 3]).count(), 40 * 30);
        }
        assert_eq!((drawn.width, drawn.height), (3 * 8 + 2 * 40, 8 + 44 + 2 * (30 + 22 + 8)));
    }

    #[test]
    fn titles_are_visible_and_differ() {
        let drawn = sheet().draw();
        assert!(drawn.pixels.contains(&[255; 3]));
        let other = ContactSheet { title: "Tittle".into(), ..sheet() }.draw();
        assert_ne!(drawn, other);
    }

    #[test]
    fn an_empty_sheet_and_a_far_too_long_title_are_harmless() {
        let empty = ContactSheet { title: "x".repeat(1000), ..ContactSheet::default() }.draw();
        assert_eq!(empty.width, 8);
    }
}
