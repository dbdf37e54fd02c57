//! Several frames on one picture, each with a word below it.

use image::ImageResult;

use crate::canvas::{Canvas, TEXT_LINE_PX};
use crate::grey_image::GreyImage;

/// Frames wider than this are shrunk by a whole number, so that a sheet fits a screen.
const TILE_PX: usize = 400;
/// Space between tiles.
const GAP_PX: usize = 6;

/// Frames of one size in rows from the top left, as a PNG of 8 bits.
///
/// # Errors
/// None that is known of.
pub fn png<'a>(frames: impl Iterator<Item = (&'a GreyImage, &'a str)>) -> ImageResult<Vec<u8>> {
    let frames: Vec<_> = frames.collect();
    let [width, height] = frames.first().map_or([0; 2], |(image, _)| image.size_px());
    let shrink = width.div_ceil(TILE_PX).max(1);
    let tile = [width / shrink, height / shrink];
    let columns = (1..=frames.len()).find(|n| n * n >= frames.len()).unwrap_or(1);
    let rows = frames.len().div_ceil(columns);
    let pitch = [tile[0] + GAP_PX, tile[1] + TEXT_LINE_PX + GAP_PX];
    let mut sheet = Canvas::new(columns * pitch[0] + GAP_PX, rows * pitch[1] + GAP_PX);
    for (i, (image, label)) in frames.iter().enumerate() {
        let at = [GAP_PX + i % columns * pitch[0], GAP_PX + i / columns * pitch[1]];
        let grey = image.to_8_bits();
        sheet.put(at, tile, |x, y| [mean(&grey, width, [x, y], shrink); 3]);
        sheet.text([at[0], at[1] + tile[1]], label, [255; 3]);
    }
    sheet.png()
}

/// Mean grey value of a square of `side` pixels, the (x, y)-th of its kind.
fn mean(grey: &[u8], width: usize, [x, y]: [usize; 2], side: usize) -> u8 {
    let rows = (y * side..(y + 1) * side).map(|row| &grey[row * width + x * side..][..side]);
    let sum: u32 = rows.flatten().map(|v| u32::from(*v)).sum();
    let count = (side * side) as u32;
    ((sum + count / 2) / count) as u8
}

#[cfg(test)]
mod tests {
    use ductloop_sensor::optics::Bits;

    use super::*;

    #[test]
    fn each_frame_stands_in_its_place_in_the_same_grey() {
        let frame = |value: u16| GreyImage::of([900, 60], Bits::Ten, &[value; 900 * 60]).expect("so many values");
        let frames = [1023, 512, 300].map(frame);
        let png = png(frames.iter().map(|image| (image, "0.5 s"))).expect("a sheet");
        let seen = image::load_from_memory(&png).expect("a PNG").to_rgb8();
        // 900 pixels are shrunk to a third; two columns, two rows.
        assert_eq!(seen.dimensions(), (2 * 306 + 6, 2 * 36 + 6));
        let at = |column: u32, row: u32| seen.get_pixel(6 + column * 306 + 150, 6 + row * 36 + 10).0;
        assert_eq!([at(0, 0), at(1, 0), at(0, 1), at(1, 1)], [[255; 3], [128; 3], [75; 3], [0; 3]]);
        // Words below each.
        let white_below = |row: u32| (6..40).any(|x| (26..36).any(|y| seen.get_pixel(x, row * 36 + y).0 == [255; 3]));
        assert!(white_below(0) && white_below(1));
    }
}
