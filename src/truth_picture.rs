//! What is truly in view, as a picture for people: the frame with the stripes' centre lines, depth, surface, normal.

use ductloop_sensor::truth::{FrameTruth, OPEN};
use image::ImageResult;

use crate::canvas::{Canvas, LETTER_PX, Rgb, TEXT_LINE_PX};
use crate::grey_image::GreyImage;
use crate::picture::LASER_COLOURS;

/// Space between the panels.
const GAP_PX: usize = 8;
const WHITE: Rgb = [230; 3];
/// Colours of the surfaces in order, distinct for colour-blind eyes too (Okabe and Ito).
const SURFACE_COLOURS: [Rgb; 7] =
    [[153, 153, 153], [230, 159, 0], [86, 180, 233], [0, 158, 115], [240, 228, 66], [213, 94, 0], [204, 121, 167]];
/// Near to far: five colours of viridis (Smith and van der Walt 2015), between which colours are mixed.
const DEPTH_COLOURS: [Rgb; 5] = [[253, 231, 37], [94, 201, 98], [33, 145, 140], [59, 82, 139], [68, 1, 84]];

/// Four panels with their legends, as a PNG: the frame with the centre lines in the lasers' colours, and beside and below it
/// depth, surface and normal in false colours; black is where the view is open.
///
/// # Errors
/// None that is known of.
pub fn png(image: &GreyImage, truth: &FrameTruth, lasers: &[&str], surfaces: &[&str]) -> ImageResult<Vec<u8>> {
    let size = [truth.width_px, truth.height_px];
    let pitch = [size[0] + GAP_PX, size[1] + 2 * TEXT_LINE_PX + GAP_PX];
    let mut canvas = Canvas::new(2 * pitch[0] + GAP_PX, 2 * pitch[1] + GAP_PX);
    let corner = |column: usize, row: usize| [GAP_PX + column * pitch[0], GAP_PX + row * pitch[1] + 2 * TEXT_LINE_PX];
    let legend = |[x, y]: [usize; 2]| [x, y - 2 * TEXT_LINE_PX + TEXT_LINE_PX / 2];

    let at = corner(0, 0);
    let grey = image.to_8_bits();
    // The root of the grey value, so that dim walls are seen beside bright stripes.
    canvas.put(at, size, |x, y| [(f32::from(grey[y * size[0] + x]) * 255.0).sqrt().round() as u8; 3]);
    for centre in &truth.centres {
        // Pixel (0, 0) is the centre of the first pixel.
        let (u, v) = (centre.u_px.round(), centre.v_px.round());
        if u >= 0.0 && v >= 0.0 && (u as usize) < size[0] && (v as usize) < size[1] {
            canvas.set(at[0] + u as usize, at[1] + v as usize, LASER_COLOURS[centre.laser % LASER_COLOURS.len()]);
        }
    }
    let named = lasers.iter().zip(LASER_COLOURS.iter().cycle());
    keys(
        &mut canvas,
        legend(at),
        "frame (root of its grey values), stripe centres:",
        named.map(|(name, colour)| (*name, *colour)),
    );

    let at = corner(1, 0);
    let [near, far] = depths(&truth.depth_m);
    canvas.put(at, size, |x, y| {
        let depth_m = truth.depth_m[y * size[0] + x];
        // By the logarithm: what is twice as far is as many colours on, near or far.
        if depth_m.is_finite() { depth_colour(libm::logf(depth_m / near) / libm::logf(far / near)) } else { [0; 3] }
    });
    depth_bar(&mut canvas, legend(at), near, far);

    let at = corner(0, 1);
    canvas.put(at, size, |x, y| match truth.surface[y * size[0] + x] {
        OPEN => [0; 3],
        surface => SURFACE_COLOURS[usize::from(surface) % SURFACE_COLOURS.len()],
    });
    let named = surfaces.iter().zip(SURFACE_COLOURS.iter().cycle());
    keys(&mut canvas, legend(at), "surface:", named.map(|(name, colour)| (*name, *colour)));

    let at = corner(1, 1);
    canvas.put(at, size, |x, y| match truth.normal[y * size[0] + x] {
        [0.0, 0.0, 0.0] => [0; 3],
        // z points along the view, the normals against it.
        [right, down, ahead] => [right, down, -ahead].map(|part| (127.5 + 127.5 * part).round() as u8),
    });
    let axes = [("to the right", [255, 128, 128]), ("down", [128, 255, 128]), ("to the camera", [128, 128, 255])];
    keys(&mut canvas, legend(at), "normal:", axes.into_iter());
    canvas.png()
}

/// A title, then names, each with a square of its colour before it.
fn keys<'a>(canvas: &mut Canvas, [x, y]: [usize; 2], title: &str, named: impl Iterator<Item = (&'a str, Rgb)>) {
    let mut x = canvas.text([x, y], title, WHITE) + LETTER_PX;
    for (name, colour) in named {
        canvas.fill([x, y], [TEXT_LINE_PX - 2; 2], colour);
        x = canvas.text([x + TEXT_LINE_PX, y], name, WHITE) + LETTER_PX;
    }
}

fn depth_bar(canvas: &mut Canvas, [x, y]: [usize; 2], near: f32, far: f32) {
    const BAR_PX: usize = 100;
    let x = canvas.text([x, y], &format!("depth: {near:.2} m "), WHITE);
    canvas.put([x, y], [BAR_PX, TEXT_LINE_PX - 2], |column, _| depth_colour(column as f32 / (BAR_PX - 1) as f32));
    canvas.text([x + BAR_PX + LETTER_PX, y], &format!("{far:.2} m"), WHITE);
}

/// Least and largest of the finite depths, both positive and never equal.
fn depths(depths_m: &[f32]) -> [f32; 2] {
    let finite = depths_m.iter().copied().filter(|depth| depth.is_finite());
    let (near, far) = finite.fold((f32::INFINITY, 0.0), |(near, far): (f32, f32), depth| (near.min(depth), far.max(depth)));
    if 0.0 < near && near < far { [near, far] } else { [1.0, far.max(2.0)] }
}

/// The colour of a share, 0 near and 1 far.
fn depth_colour(share: f32) -> Rgb {
    let at = share.clamp(0.0, 1.0) * (DEPTH_COLOURS.len() - 1) as f32;
    let below = (at as usize).min(DEPTH_COLOURS.len() - 2);
    let part = at - below as f32;
    let (from, to) = (DEPTH_COLOURS[below], DEPTH_COLOURS[below + 1]);
    std::array::from_fn(|i| (f32::from(from[i]) + part * (f32::from(to[i]) - f32::from(from[i]))).round() as u8)
}
