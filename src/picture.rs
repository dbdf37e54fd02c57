//! Frames as PNG, plain and with the lines that were found in them.

use ductloop_nav::messages::Pixels;
use ductloop_nav::perception::StripeLine;
use image::codecs::png::PngEncoder;
use image::error::{ImageError, ParameterError, ParameterErrorKind};
use image::{ExtendedColorType, ImageEncoder, ImageResult};

use crate::grey_image::GreyImage;

/// Colours of the lasers in order, distinct for colour-blind eyes too (Okabe and Ito); of a line that no laser is taken for.
pub(crate) const LASER_COLOURS: [[u8; 3]; 4] = [[230, 159, 0], [86, 180, 233], [0, 200, 130], [204, 121, 167]];
pub(crate) const UNASSIGNED: [u8; 3] = [255, 80, 80];

/// The colour of a line: its laser's.
pub(crate) fn colour(line: &StripeLine) -> [u8; 3] {
    line.assigned.map_or(UNASSIGNED, |(laser, _)| LASER_COLOURS[laser % LASER_COLOURS.len()])
}

/// A grey image as PNG with its values as they are: of 8 bits, or of 16 where it has more (a value of 10 bits is 1023 at most, so
/// the picture looks dark; [`preview_png`] is for the eye).
///
/// # Errors
/// None that is known of.
pub fn grey_png(image: &GreyImage) -> ImageResult<Vec<u8>> {
    let [width, height] = image.size_px();
    match image.pixels() {
        Pixels::Grey8(values) => encode(values, width, height, ExtendedColorType::L8),
        Pixels::Grey16(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
            encode(&bytes, width, height, ExtendedColorType::L16)
        }
    }
}

/// A grey image as PNG of 8 bits, the largest value white.
///
/// # Errors
/// None that is known of.
pub fn preview_png(image: &GreyImage) -> ImageResult<Vec<u8>> {
    let [width, height] = image.size_px();
    encode(&image.to_8_bits(), width, height, ExtendedColorType::L8)
}

/// The image as a coloured PNG of 8 bits with the lines drawn on it, each in its laser's colour with a square at each end.
///
/// # Errors
/// None that is known of.
pub fn overlay_png(image: &GreyImage, lines: &[StripeLine]) -> ImageResult<Vec<u8>> {
    let [width, height] = image.size_px();
    let mut pixels: Vec<u8> = image.to_8_bits().iter().flat_map(|grey| [*grey; 3]).collect();
    for line in lines {
        draw(&mut pixels, width, line);
    }
    encode(&pixels, width, height, ExtendedColorType::Rgb8)
}

/// Length of a dash and of the gap after it, in pixels: between dashes the stripe stays to be seen.
const DASH_PX: usize = 8;

/// Draws a dashed line one pixel wide, with a square at each end.
fn draw(pixels: &mut [u8], width: usize, line: &StripeLine) {
    let [[u0, v0], [u1, v1]] = line.ends_px;
    if ![u0, v0, u1, v1].iter().all(|x| x.is_finite()) {
        return;
    }
    let colour = colour(line);
    let mut set = |u: f64, v: f64| {
        // Pixel (0, 0) is the centre of the first pixel.
        let (u, v) = (u.round(), v.round());
        if u >= 0.0 && v >= 0.0 && u < width as f64 {
            let at = 3 * (v as usize * width + u as usize);
            if let Some(pixel) = pixels.get_mut(at..at + 3) {
                pixel.copy_from_slice(&colour);
            }
        }
    };
    // No image is longer than 8192 pixels a side; a line may be anything.
    let steps = (u1 - u0).abs().max((v1 - v0).abs()).ceil().clamp(1.0, 16_384.0) as usize;
    for i in (0..=steps).filter(|i| (i / DASH_PX).is_multiple_of(2)) {
        let along = i as f64 / steps as f64;
        set(u0 + along * (u1 - u0), v0 + along * (v1 - v0));
    }
    for (u, v) in [(u0, v0), (u1, v1)] {
        for i in -3..=3 {
            let i = f64::from(i);
            [(i, -3.0), (i, 3.0), (-3.0, i), (3.0, i)].into_iter().for_each(|(du, dv)| set(u + du, v + dv));
        }
    }
}

fn encode(pixels: &[u8], width: usize, height: usize, format: ExtendedColorType) -> ImageResult<Vec<u8>> {
    let expected = width as u64 * height as u64 * u64::from(format.bits_per_pixel()) / 8;
    if pixels.len() as u64 != expected {
        // The encoder itself panics on this.
        return Err(ImageError::Parameter(ParameterError::from_kind(ParameterErrorKind::DimensionMismatch)));
    }
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(pixels, width as u32, height as u32, format)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ductloop_nav::perception::Wall;
    use ductloop_sensor::optics::Bits;

    fn line(ends_px: [[f64; 2]; 2], assigned: Option<(usize, Wall)>) -> StripeLine {
        StripeLine { ends_px, assigned, points: 10, residual_px: 0.1 }
    }

    #[test]
    fn lines_lie_on_the_image_in_their_lasers_colour() {
        let image = GreyImage::of([32, 24], Bits::Eight, &[40; 32 * 24]).expect("so many values");
        let lines = [
            line([[4.0, 10.0], [27.0, 10.0]], Some((1, Wall::Right))),
            // Ends that are nowhere near the image, and no number at all, do no harm.
            line([[-500.0, -3.0], [1e9, 40.0]], None),
            line([[f64::NAN, 0.0], [1.0, 1.0]], None),
        ];
        let png = overlay_png(&image, &lines).expect("a picture");
        let seen = image::load_from_memory(&png).expect("a PNG").to_rgb8();
        assert_eq!(seen.dimensions(), (32, 24));
        assert_eq!(seen.get_pixel(10, 10).0, LASER_COLOURS[1]);
        assert_eq!(seen.get_pixel(14, 10).0, [40; 3], "a gap");
        assert_eq!(seen.get_pixel(10, 12).0, [40; 3], "beside the line");
    }

    /// 16 bits hold what is there, to the last one; the preview is for the eye.
    #[test]
    fn grey_values_are_kept_as_they_are() {
        let ramp: Vec<u16> = (0..64 * 64).collect();
        let deep = GreyImage::of([64, 64], Bits::Twelve, &ramp).expect("so many values");
        let open = |png: ImageResult<Vec<u8>>| image::load_from_memory(&png.expect("a picture")).expect("a PNG");
        assert_eq!(open(grey_png(&deep)).into_luma16().into_raw(), ramp);
        let seen = open(preview_png(&deep)).into_luma8();
        assert_eq!((seen.get_pixel(0, 0).0, seen.get_pixel(63, 63).0), ([0], [255]));
        let values: Vec<u16> = (0..64).collect();
        let plain = GreyImage::of([8, 8], Bits::Eight, &values).expect("so many values");
        assert_eq!(open(grey_png(&plain)).as_luma8().map(|p| p.as_raw().clone()), Some((0..64).collect()));
    }
}
