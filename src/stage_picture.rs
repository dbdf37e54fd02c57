//! What a perception's stages found in a picture, drawn over it: centres, lines, the region that was looked at.

use ductloop_nav::perception::ridge::Region;
use ductloop_nav::perception::{StripeCentre, StripeLine, Wall};
use image::ImageResult;

use crate::canvas::{Canvas, Rgb};
use crate::picture::{LASER_COLOURS, UNASSIGNED};
use crate::picture_mark::{is_marked, marked};

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Overlay<'a> {
    /// Stripe centres.
    pub centres: &'a [StripeCentre],
    /// Lines.
    pub lines: &'a [StripeLine],
    /// The region that was looked at.
    pub region: Option<&'a Region>,
}

/// Pictures up to this size are shown twice as large: a centre is then half a pixel wide, and the stripe stays to be seen.
const TWICE_UP_TO_PX: usize = 2000;
/// How far beside its stripe a line is drawn, in pixels.
const BESIDE_PX: f64 = 7.0;
/// Length of a dash and of the gap after it, in pixels of the drawing.
const DASH_PX: usize = 8;
const REGION: Rgb = [120, 120, 120];
/// Which program the picture says that it is of.
const PROGRAM: &str = "ductloop perceive";

/// The picture in grey with all of it drawn over it, as PNG: centres in their laser's colour, lines beside their stripes as dashes from end
/// to end, the region's outline in grey. `grey` holds 8 bits a pixel, row by row. [`is_overlay`] knows it.
///
/// # Errors
/// None that is known of.
pub fn overlay_png([width, height]: [usize; 2], grey: &[u8], overlay: &Overlay<'_>) -> ImageResult<Vec<u8>> {
    let scale = if width.max(height) <= TWICE_UP_TO_PX { 2 } else { 1 };
    let mut drawing = Drawing { canvas: Canvas::new(scale * width, scale * height), scale: scale as f64 };
    drawing.canvas.put([0, 0], [scale * width, scale * height], |x, y| [grey[y / scale * width + x / scale]; 3]);
    if let Some(region) = overlay.region {
        let corners = region.corners_px();
        for (i, from) in corners.iter().enumerate() {
            drawing.line(*from, corners[(i + 1) % corners.len()], REGION);
        }
    }
    for line in overlay.lines {
        drawing.beside(line);
    }
    for centre in overlay.centres {
        drawing.dot([centre.u_px, centre.v_px], colour(centre.assigned));
    }
    Ok(marked(drawing.canvas.png()?, PROGRAM))
}

/// Whether a file is a picture that [`overlay_png`] made; the first few hundred bytes suffice.
pub fn is_overlay(first: &[u8]) -> bool {
    is_marked(first, PROGRAM)
}

fn colour(assigned: Option<(usize, Wall)>) -> Rgb {
    assigned.map_or(UNASSIGNED, |(laser, _)| LASER_COLOURS[laser % LASER_COLOURS.len()])
}

struct Drawing {
    canvas: Canvas,
    scale: f64,
}

impl Drawing {
    /// Sets the place of the drawing that (u, v) falls on.
    fn dot(&mut self, [u_px, v_px]: [f64; 2], colour: Rgb) {
        // Pixel (0, 0) is the centre of the first pixel.
        let [x, y] = [u_px, v_px].map(|at| (at + 0.5) * self.scale);
        if x >= 0.0 && y >= 0.0 {
            self.canvas.set(x as usize, y as usize, colour);
        }
    }

    /// A dashed line.
    fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: Rgb) {
        let (du, dv) = (to[0] - from[0], to[1] - from[1]);
        // No picture is longer than 8192 pixels a side; a line may be anything.
        let steps = (self.scale * du.abs().max(dv.abs())).ceil().clamp(1.0, 32_768.0) as usize;
        for i in (0..=steps).filter(|i| (i / DASH_PX).is_multiple_of(2)) {
            let along = i as f64 / steps as f64;
            self.dot([from[0] + along * du, from[1] + along * dv], colour);
        }
    }

    /// A line beside its stripe, with a tick to the stripe at each end.
    fn beside(&mut self, line: &StripeLine) {
        let [from, to] = line.ends_px;
        let (du, dv) = (to[0] - from[0], to[1] - from[1]);
        let length = libm::sqrt(du * du + dv * dv);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let colour = colour(line.assigned);
        let aside = |[u, v]: [f64; 2]| [u - BESIDE_PX * dv / length, v + BESIDE_PX * du / length];
        self.line(aside(from), aside(to), colour);
        for end in [from, to] {
            self.line(end, aside(end), colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing_of_nothing() -> Vec<u8> {
        Canvas::new(4, 4).png().unwrap_or_default()
    }

    #[test]
    fn centres_and_lines_stand_where_they_are() {
        let centres = [StripeCentre { u_px: 10.0, v_px: 6.4, sigma_px: 0.1, assigned: Some((1, Wall::Left)) }];
        let line = |ends_px| StripeLine { ends_px, assigned: None, points: 10, residual_px: 0.1 };
        // Nowhere near the picture, and no number at all: no harm.
        let lines = [line([[4.0, 10.0], [30.0, 10.0]]), line([[-500.0, -3.0], [1e9, 40.0]]), line([[f64::NAN, 0.0], [1.0, 1.0]])];
        let region = Region::rectangle([1.0, 1.0], [1e7, 20.0]);
        let overlay = Overlay { centres: &centres, lines: &lines, region: region.as_ref() };
        let png = overlay_png([32, 24], &[40; 32 * 24], &overlay).expect("a picture");
        assert!(is_overlay(&png) && !is_overlay(&drawing_of_nothing()));
        let seen = image::load_from_memory(&png).expect("a PNG").to_rgb8();
        assert_eq!(seen.dimensions(), (64, 48));
        // (10.5, 6.9) times two.
        assert_eq!(seen.get_pixel(21, 13).0, LASER_COLOURS[1]);
        assert_eq!(seen.get_pixel(21, 12).0, [40; 3]);
        // Seven pixels beside: (10 + 7 + 0.5) times two.
        assert_eq!(seen.get_pixel(10, 35).0, UNASSIGNED);
        assert_eq!(seen.get_pixel(3, 3).0, REGION);
    }
}
