//! The working image: grey values turned so that stripes run along its rows.
//!
//! All later stages look down columns, across the stripe. A rig whose stripes stand rather upright in the image (INCRA I's own,
//! whose camera is mounted in portrait) has its frame transposed here, once, so that the rest need not know.

use crate::messages::{Frame, Pixels};
use crate::rig::Rig;

/// Which axis of the image runs across the stripes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Rows: stripes run along u. Scan coordinates are (u, v).
    V,
    /// Columns: stripes run along v. Scan coordinates are (v, u).
    U,
}

/// A grey image in scan coordinates: x along the stripes, y across them.
#[derive(Clone, Debug, Default)]
pub struct ScanImage {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Grey values, row by row.
    pub pixels: Vec<u16>,
}

impl Across {
    /// The axis that runs across the stripes of this rig: the one along which the laser planes' normals point more.
    pub fn of(rig: &Rig) -> Self {
        let (mut u, mut v) = (0.0, 0.0);
        for laser in &rig.lasers {
            u += laser.normal_in_camera.x.abs();
            v += laser.normal_in_camera.y.abs();
        }
        if v >= u { Across::V } else { Across::U }
    }

    /// Pixel coordinates (u, v) of a place in scan coordinates. Its own inverse.
    pub fn pixel(self, x: f64, y: f64) -> [f64; 2] {
        match self {
            Across::V => [x, y],
            Across::U => [y, x],
        }
    }
}

impl ScanImage {
    /// Takes a frame over, transposed where stripes run along v.
    pub fn load(&mut self, frame: &Frame<'_>, across: Across) {
        (self.width, self.height) = match across {
            Across::V => (frame.width_px, frame.height_px),
            Across::U => (frame.height_px, frame.width_px),
        };
        self.pixels.resize(self.width * self.height, 0);
        match frame.pixels {
            Pixels::Grey8(pixels) => self.fill(pixels, across, frame.width_px),
            Pixels::Grey16(pixels) => self.fill(pixels, across, frame.width_px),
        }
    }

    fn fill<T: Copy + Into<u16>>(&mut self, source: &[T], across: Across, source_width: usize) {
        match across {
            Across::V => {
                for (to, from) in self.pixels.iter_mut().zip(source) {
                    *to = (*from).into();
                }
            }
            Across::U => transpose(source, source_width, &mut self.pixels),
        }
    }

    /// One row.
    pub fn row(&self, y: usize) -> &[u16] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }
}

/// Transposes in tiles, so that both sides stay in the cache.
fn transpose<T: Copy + Into<u16>>(source: &[T], source_width: usize, target: &mut [u16]) {
    const TILE: usize = 16;
    let source_height = source.len() / source_width;
    for v0 in (0..source_height).step_by(TILE) {
        for u0 in (0..source_width).step_by(TILE) {
            for u in u0..(u0 + TILE).min(source_width) {
                for v in v0..(v0 + TILE).min(source_height) {
                    target[u * source_height + v] = source[v * source_width + u].into();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transposed_image_has_its_pixels_where_its_coordinates_say() {
        let pixels: Vec<u8> = (0..20 * 18).map(|i| (i % 251) as u8).collect();
        let frame = Frame::grey8(20, 18, &pixels);
        for across in [Across::V, Across::U] {
            let mut image = ScanImage::default();
            image.load(&frame, across);
            for y in 0..image.height {
                for x in 0..image.width {
                    let [u, v] = across.pixel(x as f64, y as f64);
                    assert_eq!(image.row(y)[x], u16::from(pixels[v as usize * 20 + u as usize]));
                }
            }
        }
    }
}
