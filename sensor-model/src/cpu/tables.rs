//! What is the same in every frame: each pixel's ray through the lens, and its own behaviour on the CCD.

use crate::lens::Projection;
use crate::noise;
use crate::optics::Optics;

/// Columns that rows of tables and of light have to the left of the image.
pub(crate) const LEFT: usize = 16;

/// Columns that they have beyond the image's right edge, at least.
const RIGHT: usize = 64;

/// Columns that a vectorised loop takes at a time: rows are filled up to whole blocks.
pub(crate) const BLOCK: usize = 16;

/// The rays of all pixels, and of those in a margin about the image that the point spread reaches.
#[derive(Debug)]
pub(crate) struct RayTable {
    /// Columns of the image.
    pub(crate) width: usize,
    /// Rows of the image.
    pub(crate) height: usize,
    /// Rows above and below the image, and columns beside it, that have rays.
    pub(crate) margin: usize,
    /// Columns of the tables; image column u is at [`LEFT`] + u.
    pub(crate) stride: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    cosine: Vec<f32>,
    slopes: Slopes,
}

/// Derivative of the ray by the pixel.
#[derive(Debug)]
enum Slopes {
    /// The same everywhere: d x / d u and d y / d v.
    Pinhole([f32; 2]),
    /// Of each pixel: d x / d u, d x / d v, d y / d u, d y / d v.
    Bent(Box<[Vec<f32>; 4]>),
}

/// A row's rays. Slices have as many values as asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays<'a> {
    /// x of each pixel's ray (x, y, 1).
    pub(crate) x: &'a [f32],
    /// y of each; with a pinhole a single one, for all.
    pub(crate) y: &'a [f32],
    /// 1 / |(x, y, 1)|.
    pub(crate) cosine: &'a [f32],
    /// Derivatives d x / d u, d x / d v, d y / d u, d y / d v of each; with a pinhole, single numbers.
    pub(crate) slopes: [&'a [f32]; 4],
}

impl RayTable {
    pub(crate) fn new(projection: &Projection, margin: usize) -> Self {
        let (width, height) = (projection.camera.width_px, projection.camera.height_px);
        let stride = LEFT + width.next_multiple_of(BLOCK) + RIGHT;
        let bent = !projection.is_pinhole();
        let reach = |at: isize, last: usize| at.clamp(-(margin as isize), (last + margin) as isize - 1) as f64;
        let columns = || (0..stride).map(|c| reach(c as isize - LEFT as isize, width));
        let rows = || (0..height + 2 * margin).map(|r| reach(r as isize - margin as isize, height));
        let pixels = || rows().flat_map(|v| columns().map(move |u| [u, v]));
        let rays = || pixels().map(|pixel| projection.ray(pixel));
        let cosine = rays().map(|[x, y]| (1.0 / (x * x + y * y + 1.0).sqrt()) as f32).collect();
        let (x, y, slopes) = if bent {
            let mut slopes = [const { Vec::new() }; 4];
            for ray in rays() {
                let m = projection.rays_per_pixel(ray);
                for (table, value) in slopes.iter_mut().zip([m.m11, m.m12, m.m21, m.m22]) {
                    table.push(value as f32);
                }
            }
            let (x, y) = rays().map(|[x, y]| (x as f32, y as f32)).unzip();
            (x, y, Slopes::Bent(Box::new(slopes)))
        } else {
            let x = columns().map(|u| projection.ray([u, 0.0])[0] as f32).collect();
            let y = rows().map(|v| projection.ray([0.0, v])[1] as f32).collect();
            (x, y, Slopes::Pinhole(projection.camera.focal_px.map(|f| (1.0 / f) as f32)))
        };
        Self { width, height, margin, stride, x, y, cosine, slopes }
    }

    /// Whether straight lines are bent.
    pub(crate) fn is_bent(&self) -> bool {
        matches!(self.slopes, Slopes::Bent(_))
    }

    /// The rays of `count` pixels of a row, from a column on.
    pub(crate) fn rays(&self, row: isize, column: isize, count: usize) -> Rays<'_> {
        let row = (row + self.margin as isize) as usize;
        let column = (column + LEFT as isize) as usize;
        let whole = row * self.stride + column..row * self.stride + column + count;
        let cosine = &self.cosine[whole.clone()];
        match &self.slopes {
            Slopes::Pinhole([du, dv]) => {
                let du = std::slice::from_ref(du);
                let dv = std::slice::from_ref(dv);
                Rays { x: &self.x[column..column + count], y: &self.y[row..=row], cosine, slopes: [du, &[], &[], dv] }
            }
            Slopes::Bent(slopes) => Rays {
                x: &self.x[whole.clone()],
                y: &self.y[whole.clone()],
                cosine,
                slopes: [0, 1, 2, 3].map(|i| &slopes[i][whole.clone()]),
            },
        }
    }

    /// x and y of a pixel's ray.
    pub(crate) fn ray(&self, row: isize, column: isize) -> [f32; 2] {
        let rays = self.rays(row, column, 1);
        [rays.x[0], rays.y[0]]
    }
}

/// How each pixel differs from the next, for all frames of a seed.
#[derive(Debug)]
pub(super) struct PixelTable {
    /// Values in a row.
    pub(super) stride: usize,
    /// Gain of each pixel; empty where all are 1.
    pub(super) gains: Vec<f32>,
    /// Dark value of each pixel, in electrons; empty where all are 0.
    pub(super) dark_e: Vec<f32>,
    /// Hot pixels as (row, column, electrons a second), row by row.
    pub(super) hot: Vec<(usize, usize, f32)>,
}

impl PixelTable {
    pub(super) fn new(optics: &Optics, seed: u64, width: usize, height: usize) -> Self {
        let ccd = &optics.ccd;
        let stride = width.next_multiple_of(BLOCK);
        let padded = |values: &mut dyn Iterator<Item = f64>, rest: f32| {
            let mut table = vec![rest; stride * height];
            for row in table.chunks_exact_mut(stride) {
                row[..width].fill_with(|| values.next().map_or(rest, |v| v as f32));
            }
            table
        };
        let mut table = Self { stride, gains: Vec::new(), dark_e: Vec::new(), hot: Vec::new() };
        if !optics.noise {
            return table;
        }
        if ccd.prnu > 0.0 {
            table.gains = padded(&mut noise::gains(seed, ccd.prnu, width, height), 1.0);
        }
        if ccd.dsnu_e > 0.0 {
            table.dark_e = padded(&mut noise::dark_values(seed, ccd.dsnu_e, width, height), 0.0);
        }
        table.hot.extend(
            noise::hot_pixels(seed, ccd.hot_pixels, ccd.hot_pixel_e_s, width, height)
                .map(|(column, row, rate)| (row, column, rate as f32)),
        );
        table
    }

    /// The hot pixels of a row, as (row, column, electrons a second).
    pub(super) fn hot_in(&self, row: usize) -> &[(usize, usize, f32)] {
        let first = self.hot.partition_point(|(r, ..)| *r < row);
        let count = self.hot[first..].partition_point(|(r, ..)| *r == row);
        &self.hot[first..first + count]
    }
}
