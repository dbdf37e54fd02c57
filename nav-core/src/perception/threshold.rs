//! Grey values to a binary image (section 4.1, "a binary image is obtained by thresholding the gray level image").
//!
//! Deviation from the paper: the threshold stands above the *local* background, not above zero. A headlamp lights near walls
//! more than far ones, and the far end of a stripe is darker than a near wall; one number for the whole image cannot serve
//! both. The background of a pixel is the brighter of two means, of the pixels above and of those below it: at an edge between
//! two faces of different brightness one of the two is the bright side, and the edge stays dark. [`binarise_global`] is the
//! paper's own.

use super::bit_image::BitImage;
use super::scan::ScanImage;

/// How the background is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalThreshold {
    /// How far above its background a pixel must stand, in DN.
    pub above_background_dn: u16,
    /// Pixels between the pixel itself and each background window: at least half the thickness of a stripe.
    pub gap_px: usize,
    /// Pixels in each background window.
    pub window_px: usize,
}

/// Sets every pixel that stands above the background on both of its sides. `sums` is room to work in.
///
/// Pixels whose windows would leave the image are not set.
pub fn binarise_local(image: &ScanImage, threshold: &LocalThreshold, sums: &mut Vec<u32>, binary: &mut BitImage) {
    let (width, height) = (image.width, image.height);
    let (gap, window) = (threshold.gap_px, threshold.window_px.max(1));
    binary.reset(width, height);
    let margin = gap + window;
    if height <= 2 * margin {
        return;
    }
    // sums row y: the sum of image rows y .. y + window.
    let rows = height - window + 1;
    sums.resize(rows * width, 0);
    for (x, sum) in sums[..width].iter_mut().enumerate() {
        *sum = (0..window).map(|j| u32::from(image.pixels[j * width + x])).sum();
    }
    for y in 1..rows {
        let (before, here) = sums.split_at_mut(y * width);
        let before = &before[(y - 1) * width..];
        let (entering, leaving) = (image.row(y + window - 1), image.row(y - 1));
        for (((to, from), enters), leaves) in here[..width].iter_mut().zip(before).zip(entering).zip(leaving) {
            *to = from + u32::from(*enters) - u32::from(*leaves);
        }
    }
    let above = u32::from(threshold.above_background_dn) * window as u32;
    for y in margin..height - margin {
        let over = &sums[(y - margin) * width..][..width];
        let under = &sums[(y + gap + 1) * width..][..width];
        let row = image.row(y);
        pack(binary.row_mut(y), width, |x| u32::from(row[x]) * window as u32 >= over[x].max(under[x]) + above);
    }
}

/// Sets every pixel of at least `threshold_dn`: the paper's own stage.
pub fn binarise_global(image: &ScanImage, threshold_dn: u16, binary: &mut BitImage) {
    binary.reset(image.width, image.height);
    for y in 0..image.height {
        let row = image.row(y);
        pack(binary.row_mut(y), image.width, |x| row[x] >= threshold_dn);
    }
}

/// Packs a row of conditions into words, by way of bytes so that the comparison is vectorised.
fn pack(words: &mut [u64], width: usize, set: impl Fn(usize) -> bool) {
    for (j, word) in words.iter_mut().enumerate() {
        let first = 64 * j;
        let mut bytes = [0u8; 64];
        for (i, byte) in bytes.iter_mut().enumerate().take(width - first) {
            *byte = u8::from(set(first + i));
        }
        *word = 0;
        for (k, eight) in bytes.chunks_exact(8).enumerate() {
            // Gathers the lowest bit of each of eight bytes into one byte.
            let lanes = u64::from_le_bytes(eight.try_into().unwrap_or([0; 8]));
            *word |= (lanes.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * k);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, value: impl Fn(usize, usize) -> u16) -> ScanImage {
        let pixels = (0..width * height).map(|i| value(i % width, i / width)).collect();
        ScanImage { width, height, pixels }
    }

    #[test]
    fn packing_puts_every_column_into_its_own_bit() {
        let image = image(70, 2, |x, y| if (x * 7 + y) % 5 == 0 { 9 } else { 0 });
        let mut binary = BitImage::default();
        binarise_global(&image, 5, &mut binary);
        for y in 0..2 {
            for x in 0..70 {
                assert_eq!(binary.get(x, y), (x * 7 + y) % 5 == 0, "({x}, {y})");
            }
        }
    }

    #[test]
    fn a_stripe_is_found_and_an_edge_is_not() {
        let threshold = LocalThreshold { above_background_dn: 6, gap_px: 4, window_px: 8 };
        // Bright below row 30, and a stripe four pixels thick around row 60 on top of it.
        let scene = image(64, 100, |_, y| 10 + 40 * u16::from(y >= 30) + 20 * u16::from((58..62).contains(&y)));
        let (mut binary, mut sums) = (BitImage::default(), Vec::new());
        binarise_local(&scene, &threshold, &mut sums, &mut binary);
        for y in 0..100 {
            assert_eq!(binary.get(31, y), (58..62).contains(&y), "row {y}");
        }
    }
}
