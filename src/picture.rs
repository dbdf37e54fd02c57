//! Frames as PNG, plain and with the lines that were found in them.

use ductloop_nav::perception::StripeLine;
use image::codecs::png::PngEncoder;
use image::error::{ImageError, ParameterError, ParameterErrorKind};
use image::{ExtendedColorType, ImageEncoder, ImageResult};

/// Colours of the lasers in order, distinct for colour-blind eyes too (Okabe and Ito); of a line that no laser is taken for.
pub(crate) const LASER_COLOURS: [[u8; 3]; 4] = [[230, 159, 0], [86, 180, 233], [0, 200, 130], [204, 121, 167]];
pub(crate) const UNASSIGNED: [u8; 3] = [255, 80, 80];

/// The colour of a line: its laser's.
pub(crate) fn colour(line: &StripeLine) -> [u8; 3] {
    line.assigned.map_or(UNASSIGNED, |(laser, _)| LASER_COLOURS[laser % LASER_COLOURS.len()])
}

/// A grey image as PNG, 8 bits a pixel: `image` has `width * height` values, row by row.
///
/// # Errors
/// When the number of values is another.
pub fn grey_png(image: &[u8], width: usize, height: usize) -> ImageResult<Vec<u8>> {
    encode(image, width, height, ExtendedColorType::L8)
}

/// The image as a coloured PNG with the lines drawn on it, each in its laser's colour with a square at each end.
///
/// # Errors
/// When the number of values is not `width * height`.
pub fn overlay_png(image: &[u8], width: usize, height: usize, lines: &[StripeLine]) -> ImageResult<Vec<u8>> {
    let mut pixels: Vec<u8> = image.iter().flat_map(|grey| [*grey; 3]).collect();
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

    fn line(ends_px: [[f64; 2]; 2], assigned: Option<(usize, Wall)>) -> StripeLine {
        StripeLine { ends_px, assigned, points: 10, residual_px: 0.1 }
    }

    #[test]
    fn lines_lie_on_the_image_in_their_lasers_colour() {
        let image = vec![40; 32 * 24];
        let lines = [
            line([[4.0, 10.0], [27.0, 10.0]], Some((1, Wall::Right))),
            // Ends that are nowhere near the image, and no number at all, do no harm.
            line([[-500.0, -3.0], [1e9, 40.0]], None),
            line([[f64::NAN, 0.0], [1.0, 1.0]], None),
        ];
        let png = overlay_png(&image, 32, 24, &lines).expect("the size fits");
        let seen = image::load_from_memory(&png).expect("a PNG").to_rgb8();
        assert_eq!(seen.dimensions(), (32, 24));
        assert_eq!(seen.get_pixel(10, 10).0, LASER_COLOURS[1]);
        assert_eq!(seen.get_pixel(14, 10).0, [40; 3], "a gap");
        assert_eq!(seen.get_pixel(10, 12).0, [40; 3], "beside the line");
        assert!(overlay_png(&image, 31, 24, &[]).is_err());
        let plain = grey_png(&image, 32, 24).expect("the size fits");
        assert_eq!(image::load_from_memory(&plain).expect("a PNG").to_luma8().into_raw(), image);
    }
}
