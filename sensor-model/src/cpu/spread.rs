//! The point spread of what the strips do not blur themselves: a separable filter, only where regions meet.
//!
//! Within a region the smooth light bends so little that the filter would not change it by a hundredth of a grey value; so it is
//! applied to tiles that an edge between regions comes near, and to surfaces with a sharp reflection of the headlamp.
//!
//! Out of focus, every block of 16 pixels is spread as its middle pixel's depth asks for. A spread of more than
//! [`SIGMA_MAX_PX`] is cut to it: what is that blurred keeps its light but looks sharper than it should.

use super::raster::Span;
use super::surfaces::Surface;
use super::tables::{BLOCK, LEFT};
use crate::light::{PSF_RADIUS, psf_taps};
use crate::optics::Lens;
use crate::strip::Blur;
use crate::vector_math::{max, min};

/// Columns of a tile.
pub(super) const TILE: usize = 32;

/// Rows and columns that the filter reaches at most.
const DEFOCUS_RADIUS: usize = 12;

/// Widest spread of the filter in pixels; three of it are its reach.
const SIGMA_MAX_PX: f32 = crate::light::DEFOCUS_SIGMA_MAX_PX as f32;

/// Steps between no spread and the widest, in the square of its standard deviation.
const STEPS: usize = 256;

/// Weights of the filter.
#[derive(Debug)]
pub(super) struct Spread {
    /// Pixels to each side.
    pub(super) radius: usize,
    /// Weights at 0, 1, 2, … pixels, for each step of variance; a single set where everything is in focus.
    taps: Vec<[f32; DEFOCUS_RADIUS + 1]>,
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
}

impl Spread {
    pub(super) fn new(lens: &Lens, blur: &Blur) -> Self {
        let focused = lens.aperture_m == 0.0;
        let taps = if focused {
            let mut taps = [0.0; DEFOCUS_RADIUS + 1];
            for (tap, weight) in taps.iter_mut().zip(psf_taps(lens.psf_sigma_px)) {
                *tap = weight as f32;
            }
            vec![taps]
        } else {
            (0..=STEPS).map(|step| wide_taps(variance_px2(step))).collect()
        };
        let radius = match (focused, lens.psf_sigma_px == 0.0) {
            (true, true) => 0,
            (true, false) => PSF_RADIUS,
            (false, _) => DEFOCUS_RADIUS,
        };
        Self {
            radius,
            taps,
            psf_px2: blur.psf_px2 as f32,
            defocus_px_m: blur.defocus_px_m as f32,
            focus_1_m: blur.focus_1_m as f32,
        }
    }

    /// The weights for what is seen at z = 1 / `inverse_z`.
    fn taps(&self, inverse_z: f32) -> &[f32; DEFOCUS_RADIUS + 1] {
        if self.taps.len() == 1 {
            return &self.taps[0];
        }
        let defocus = self.defocus_px_m * (inverse_z - self.focus_1_m);
        let share = (self.psf_px2 + defocus * defocus) / (SIGMA_MAX_PX * SIGMA_MAX_PX);
        &self.taps[(min(max(share, 0.0), 1.0) * STEPS as f32 + 0.5) as usize]
    }

    /// Whether every pixel has the same weights.
    pub(super) fn is_uniform(&self) -> bool {
        self.taps.len() == 1
    }
}

fn variance_px2(step: usize) -> f64 {
    f64::from(SIGMA_MAX_PX * SIGMA_MAX_PX) * step as f64 / STEPS as f64
}

/// As [`psf_taps`], out to [`DEFOCUS_RADIUS`].
fn wide_taps(variance_px2: f64) -> [f32; DEFOCUS_RADIUS + 1] {
    let mut taps = [0.0; DEFOCUS_RADIUS + 1];
    if variance_px2 == 0.0 {
        taps[0] = 1.0;
        return taps.map(|tap| tap as f32);
    }
    let below = |x_px: f64| 0.5 * libm::erfc(-x_px / (2.0 * variance_px2).sqrt());
    for (i, tap) in taps.iter_mut().enumerate() {
        *tap = below(i as f64 + 0.5) - below(i as f64 - 0.5);
    }
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.map(|tap| (tap / sum) as f32)
}

/// Marks the tiles of a band that need the filter; `rows` are the spans of the band's rows and of `radius` rows about it.
pub(super) fn mark<'a>(
    rows: impl Iterator<Item = &'a [Span]>,
    surface: impl Fn(u32) -> &'a Surface,
    radius: usize,
    marked: &mut [bool],
    seen: &mut [Option<u32>],
) {
    marked.fill(false);
    seen.fill(None);
    if radius == 0 {
        return;
    }
    let last = marked.len() as i32 - 1;
    let (tile, radius) = (TILE as i32, radius as i32);
    for row in rows {
        for span in row {
            let surface = surface(span.region);
            let first = (span.from - radius).div_euclid(tile).max(0);
            let end = (span.to - 1 + radius).div_euclid(tile).min(last);
            for t in first..=end {
                let t = t as usize;
                marked[t] |= surface.is_sharp || *seen[t].get_or_insert(surface.class) != surface.class;
            }
        }
    }
}

/// Filters a tile in which all pixels have the same weights. `raw` holds `count + 2 radius` rows of `stride` values, the first
/// `radius` rows above the tile; `column` is the tile's first. The result goes to `out`, rows of [`TILE`] values.
#[inline(always)]
pub(super) fn filter_uniform(
    spread: &Spread,
    raw: &[f32],
    stride: usize,
    column: usize,
    rows: &mut [[f32; TILE]],
    out: &mut [[f32; TILE]],
) {
    const R: usize = PSF_RADIUS;
    let [t0, t1, t2, t3, ..] = spread.taps[0];
    for (r, row) in rows.iter_mut().enumerate() {
        let start = r * stride + LEFT + column - R;
        let near: &[f32; TILE + 2 * R] = raw[start..start + TILE + 2 * R].try_into().expect("as many values");
        for i in 0..TILE {
            row[i] = t0 * near[i + 3]
                + t1 * (near[i + 2] + near[i + 4])
                + t2 * (near[i + 1] + near[i + 5])
                + t3 * (near[i] + near[i + 6]);
        }
    }
    for (row, near) in out.iter_mut().zip(rows.windows(2 * R + 1)) {
        for i in 0..TILE {
            row[i] = t0 * near[3][i]
                + t1 * (near[2][i] + near[4][i])
                + t2 * (near[1][i] + near[5][i])
                + t3 * (near[0][i] + near[6][i]);
        }
    }
}

/// Filters a tile of varying depth: `depth(r, block)` gives 1/z in the middle of a block of row r, counted from the first row of `raw`.
#[inline(always)]
pub(super) fn filter_varying(
    spread: &Spread,
    raw: &[f32],
    stride: usize,
    column: usize,
    depth: impl Fn(usize, usize) -> f32,
    rows: &mut [[f32; TILE]],
    out: &mut [[f32; TILE]],
) {
    const R: usize = DEFOCUS_RADIUS;
    for (r, row) in rows.iter_mut().enumerate() {
        for block in 0..TILE / BLOCK {
            let taps = spread.taps(depth(r, block));
            let start = r * stride + LEFT + column + block * BLOCK - R;
            let near: &[f32; BLOCK + 2 * R] = raw[start..start + BLOCK + 2 * R].try_into().expect("as many values");
            let mut sum = [0.0; BLOCK];
            for i in 0..BLOCK {
                sum[i] = taps[0] * near[i + R];
            }
            for k in 1..=R {
                for i in 0..BLOCK {
                    sum[i] += taps[k] * (near[i + R - k] + near[i + R + k]);
                }
            }
            row[block * BLOCK..(block + 1) * BLOCK].copy_from_slice(&sum);
        }
    }
    for (r, row) in out.iter_mut().enumerate() {
        for block in 0..TILE / BLOCK {
            let taps = spread.taps(depth(r + R, block));
            let first = block * BLOCK;
            let mut sum = [0.0; BLOCK];
            for i in 0..BLOCK {
                sum[i] = taps[0] * rows[r + R][first + i];
            }
            for k in 1..=R {
                for i in 0..BLOCK {
                    sum[i] += taps[k] * (rows[r + R - k][first + i] + rows[r + R + k][first + i]);
                }
            }
            row[first..first + BLOCK].copy_from_slice(&sum);
        }
    }
}
