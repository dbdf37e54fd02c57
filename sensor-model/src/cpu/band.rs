//! A band of rows: from a picture to mean electrons, while everything stays in the processor's nearest memory.

use std::ops::Range;

use pulp::Arch;

use super::ccd::{Exposure, RowNoise, Shot};
use super::edges::{Keeps, Kept};
use super::picture::Picture;
use super::ridges::{LensBlur, RUN, Run};
use super::smooth;
use super::spread::{self, Spread, TILE};
use super::surfaces::Surface;
use super::tables::{BLOCK, LEFT, PixelTable, RayTable};
use super::transmission;
use super::vectors::vectorised;

/// Rows of a band.
pub(super) const BAND_ROWS: usize = 16;

/// What all bands of all frames share.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) arch: Arch,
    pub(super) rays: RayTable,
    pub(super) pixels: PixelTable,
    pub(super) spread: Spread,
    pub(super) lens: LensBlur,
    pub(super) exposure: Exposure,
    pub(super) vignetting: bool,
}

/// Working memory of a thread.
#[derive(Debug)]
pub(super) struct Workspace {
    /// Smooth light of the band's rows and of the spread's radius about them; column u is at [`LEFT`] + u.
    smooth: Vec<f32>,
    /// The lasers' light of the band's rows, where it is lit; column u is at u.
    laser: Vec<f32>,
    /// Whether a run of [`RUN`] columns of a row has lasers' light.
    lit: Vec<bool>,
    /// Tiles that the point spread changes, and what they have seen so far.
    marked: Vec<bool>,
    seen: Vec<Option<u32>>,
    filtered: Vec<[f32; TILE]>,
    filter_rows: Vec<[f32; TILE]>,
    run: Run,
    kept: Kept,
    /// Sums over the parts of an exposure: smooth light, lasers' light, whether there is any.
    sum_smooth: Vec<f32>,
    sum_laser: Vec<f32>,
    sum_lit: Vec<bool>,
    pub(super) numbers: RowNoise,
    /// Mean electrons of the band.
    pub(super) mean_e: Vec<f32>,
}

impl Workspace {
    pub(super) fn new(model: &Model) -> Self {
        let RayTable { stride, width, .. } = model.rays;
        let radius = model.spread.radius;
        let (tiles, runs) = (width.div_ceil(TILE), stride.div_ceil(RUN));
        Self {
            smooth: vec![0.0; stride * (BAND_ROWS + 2 * radius)],
            laser: vec![0.0; stride * BAND_ROWS],
            lit: vec![false; runs * BAND_ROWS],
            marked: vec![false; tiles],
            seen: vec![None; tiles],
            filtered: vec![[0.0; TILE]; tiles * BAND_ROWS],
            filter_rows: vec![[0.0; TILE]; BAND_ROWS + 2 * radius],
            run: Run::new(),
            kept: Kept::new(),
            sum_smooth: Vec::new(),
            sum_laser: Vec::new(),
            sum_lit: Vec::new(),
            numbers: RowNoise::default(),
            mean_e: vec![0.0; model.pixels.stride * BAND_ROWS],
        }
    }

    /// Mean electrons of a band, rows of the pixel table's stride, into `mean_e`; the pictures are the parts of the exposure.
    pub(super) fn expose(&mut self, model: &Model, pictures: &[Picture], shot: &Shot, rows: Range<usize>, mean_e: &mut [f32]) {
        if let [picture] = pictures {
            self.light(model, picture, rows.clone());
        } else {
            self.average(model, pictures, rows.clone());
        }
        let RayTable { stride, .. } = model.rays;
        let padded = model.pixels.stride;
        let runs = stride.div_ceil(RUN);
        for (r, row) in rows.enumerate() {
            let smooth = &self.smooth[(r + model.spread.radius) * stride + LEFT..][..padded];
            let hot = model.pixels.hot_in(row);
            for from in (0..padded).step_by(RUN) {
                let count = RUN.min(padded - from);
                let mut laser = self.lit[r * runs + from / RUN].then(|| &mut self.laser[r * stride + from..][..count]);
                let smooth = &smooth[from..from + count];
                let gains = model.pixels.gains.get(row * padded + from..row * padded + from + count);
                let out = &mut mean_e[r * padded + from..][..count];
                let numbers = &mut self.numbers;
                vectorised(
                    model.arch,
                    #[inline(always)]
                    || electrons(&model.exposure, shot, row, from, smooth, laser.as_deref_mut(), gains, numbers, out),
                );
            }
            for (_, column, rate) in hot {
                mean_e[r * padded + column] += rate * shot.exposure_s;
            }
        }
    }

    /// The mean light of several pictures.
    fn average(&mut self, model: &Model, pictures: &[Picture], rows: Range<usize>) {
        let share = 1.0 / pictures.len() as f32;
        self.sum_smooth.resize(self.smooth.len(), 0.0);
        self.sum_laser.resize(self.laser.len(), 0.0);
        self.sum_lit.resize(self.lit.len(), false);
        self.sum_smooth.fill(0.0);
        self.sum_laser.fill(0.0);
        self.sum_lit.fill(false);
        let runs = self.lit.len() / BAND_ROWS;
        for picture in pictures {
            self.light(model, picture, rows.clone());
            let (smooth, sum) = (&self.smooth, &mut self.sum_smooth);
            vectorised(
                model.arch,
                #[inline(always)]
                || add(share, smooth, sum),
            );
            for (index, lit) in self.lit.iter().enumerate().filter(|(_, lit)| **lit) {
                let start = index / runs * model.rays.stride + index % runs * RUN;
                let here = start..(start + RUN).min(self.laser.len());
                add(share, &self.laser[here.clone()], &mut self.sum_laser[here]);
                self.sum_lit[index] |= lit;
            }
        }
        std::mem::swap(&mut self.smooth, &mut self.sum_smooth);
        std::mem::swap(&mut self.laser, &mut self.sum_laser);
        std::mem::swap(&mut self.lit, &mut self.sum_lit);
    }

    /// The light of a picture.
    fn light(&mut self, model: &Model, picture: &Picture, rows: Range<usize>) {
        let radius = model.spread.radius as isize;
        let near = rows.start as isize - radius..rows.end as isize + radius;
        let spans = near.map(|row| picture.raster.row(row));
        spread::mark(spans, |region| picture.surface(region), model.spread.radius, &mut self.marked, &mut self.seen);
        self.paint(model, picture, rows.clone());
        self.spread(model, picture, rows.clone());
        self.lit.fill(false);
        for strip in 0..picture.ridges.len() {
            self.ridge(model, picture, strip, rows.clone());
        }
        self.transmit(model, picture, rows);
    }

    /// Smooth light: the band's rows, and of the rows about it what marked tiles need.
    fn paint(&mut self, model: &Model, picture: &Picture, rows: Range<usize>) {
        let (radius, width) = (model.spread.radius as i32, model.rays.width as i32);
        for row in rows.start as i32 - radius..rows.end as i32 + radius {
            let line = (row - rows.start as i32 + radius) as usize * model.rays.stride;
            let line = line..line + model.rays.stride;
            if rows.contains(&(row as usize)) && row >= 0 {
                paint_row(model, picture, row as isize, -radius..width + radius, &mut self.smooth[line.clone()]);
                soften(picture, row as isize, &mut self.smooth[line]);
                continue;
            }
            let mut tile = 0;
            while let Some(first) = self.marked[tile..].iter().position(|marked| *marked) {
                let first = tile + first;
                let count = self.marked[first..].iter().position(|marked| !*marked).unwrap_or(self.marked.len() - first);
                let columns = (first * TILE) as i32 - radius..((first + count) * TILE) as i32 + radius;
                let columns = columns.start..columns.end.min(width + radius);
                paint_row(model, picture, row as isize, columns, &mut self.smooth[line.clone()]);
                tile = first + count;
            }
            // Tiles that are not painted are not read.
            soften(picture, row as isize, &mut self.smooth[line]);
        }
    }

    /// Filters the marked tiles.
    fn spread(&mut self, model: &Model, picture: &Picture, rows: Range<usize>) {
        let stride = model.rays.stride;
        let count = rows.len();
        let radius = model.spread.radius;
        let marked = || self.marked.iter().enumerate().filter(|(_, marked)| **marked).map(|(tile, _)| tile);
        for tile in marked() {
            let out = &mut self.filtered[tile * BAND_ROWS..][..count];
            let lines = &mut self.filter_rows[..count + 2 * radius];
            let raw = &self.smooth;
            if model.spread.is_uniform() {
                vectorised(
                    model.arch,
                    #[inline(always)]
                    || spread::filter_uniform(&model.spread, raw, stride, tile * TILE, lines, out),
                );
            } else {
                let depth = |r: usize, block: usize| {
                    let row = rows.start as isize + r as isize - radius as isize;
                    let column = (tile * TILE + block * BLOCK + BLOCK / 2).min(model.rays.width - 1);
                    inverse_depth(model, picture, row, column as isize)
                };
                vectorised(
                    model.arch,
                    #[inline(always)]
                    || spread::filter_varying(&model.spread, raw, stride, tile * TILE, depth, lines, out),
                );
            }
        }
        for tile in marked() {
            for (r, row) in self.filtered[tile * BAND_ROWS..][..count].iter().enumerate() {
                let start = (r + radius) * stride + LEFT + tile * TILE;
                self.smooth[start..start + TILE].copy_from_slice(row);
            }
        }
    }

    /// Adds a strip's light.
    fn ridge(&mut self, model: &Model, picture: &Picture, strip: usize, rows: Range<usize>) {
        let stride = model.rays.stride;
        let runs = stride.div_ceil(RUN);
        for (r, row) in rows.enumerate() {
            let Some(columns) = picture.intervals.columns(strip, row, model.rays.width) else { continue };
            let mut from = columns.start;
            while from < columns.end {
                let count = (columns.end - from).next_multiple_of(BLOCK).min(RUN);
                for lit in from / RUN..=(from + count - 1) / RUN {
                    if !std::mem::replace(&mut self.lit[r * runs + lit], true) {
                        self.laser[r * stride + lit * RUN..(r * stride + (lit + 1) * RUN).min((r + 1) * stride)].fill(0.0);
                    }
                }
                let out = &mut self.laser[r * stride + from..][..count];
                let (run, kept) = (&mut self.run, &mut self.kept);
                if model.rays.is_bent() {
                    vectorised(
                        model.arch,
                        #[inline(always)]
                        || add_ridge::<true>(model, picture, strip, row, from, run, kept, out),
                    );
                } else {
                    vectorised(
                        model.arch,
                        #[inline(always)]
                        || add_ridge::<false>(model, picture, strip, row, from, run, kept, out),
                    );
                }
                from += count;
            }
        }
    }

    /// Takes away what seams and spangle do not reflect.
    fn transmit(&mut self, model: &Model, picture: &Picture, rows: Range<usize>) {
        let stride = model.rays.stride;
        let runs = stride.div_ceil(RUN);
        for (r, row) in rows.enumerate() {
            for span in picture.raster.row(row as isize) {
                let surface = picture.surface(span.region);
                if surface.seams.is_empty() && surface.spangle.is_none() {
                    continue;
                }
                let (start, end) = (span.from.max(0) as usize, span.to.min(model.rays.width as i32).max(0) as usize);
                let mut from = start;
                while from < end {
                    // Runs end where those of the lasers' light do.
                    let count = (RUN - from % RUN).min(end - from);
                    let mut share = [1.0; RUN];
                    let share = &mut share[..count.next_multiple_of(BLOCK)];
                    transmission(model, picture, surface, row, from, share);
                    let smooth = &mut self.smooth[(r + model.spread.radius) * stride + LEFT + from..][..count];
                    smooth.iter_mut().zip(share.iter()).for_each(|(light, share)| *light *= share);
                    if self.lit[r * runs + from / RUN] {
                        let laser = &mut self.laser[r * stride + from..][..count];
                        laser.iter_mut().zip(share.iter()).for_each(|(light, share)| *light *= share);
                    }
                    from += count;
                }
            }
        }
    }
}

/// 1/z of what a pixel sees.
fn inverse_depth(model: &Model, picture: &Picture, row: isize, column: isize) -> f32 {
    let spans = picture.raster.row(row);
    let span = spans.partition_point(|span| span.to as isize <= column).min(spans.len() - 1);
    let [ax, ay, az] = picture.surface(spans[span].region).inverse_depth;
    let [x, y] = model.rays.ray(row, column);
    ax * x + ay * y + az
}

/// Adds what pixels that edges cross lack.
fn soften(picture: &Picture, row: isize, out: &mut [f32]) {
    for pixel in picture.soft.row(row) {
        out[(pixel.column + LEFT as i32) as usize] += pixel.light_dn;
    }
}

/// Smooth light of some columns of a row, and of what follows up to a whole block.
fn paint_row(model: &Model, picture: &Picture, row: isize, columns: Range<i32>, out: &mut [f32]) {
    for span in picture.raster.row(row) {
        let (from, to) = (span.from.max(columns.start), span.to.min(columns.end));
        if from >= to {
            continue;
        }
        let surface = picture.surface(span.region);
        let count = ((to - from) as usize).next_multiple_of(BLOCK);
        let rays = model.rays.rays(row, from as isize, count);
        let start = (from + LEFT as i32) as usize;
        let part = &mut out[start..start + count];
        let vignetting = model.vignetting;
        if model.rays.is_bent() {
            vectorised(
                model.arch,
                #[inline(always)]
                || smooth::shine::<true>(surface, rays, vignetting, part),
            );
        } else {
            vectorised(
                model.arch,
                #[inline(always)]
                || smooth::shine::<false>(surface, rays, vignetting, part),
            );
        }
        if let Some(patch) = &surface.glow {
            let nodes = &picture.geometry.glow;
            vectorised(
                model.arch,
                #[inline(always)]
                || smooth::glow(patch, nodes, row, from, to, out),
            );
        }
    }
}

/// Adds a run of a strip's light to `out`.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // the inside of one loop, with the memory it works on
fn add_ridge<const BENT: bool>(
    model: &Model,
    picture: &Picture,
    strip: usize,
    row: usize,
    from: usize,
    run: &mut Run,
    kept: &mut Kept,
    out: &mut [f32],
) {
    let count = out.len();
    let ridge = &picture.ridges[strip];
    let rays = model.rays.rays(row as isize, from as isize, count);
    ridge.run::<BENT>(&model.lens, rays, count, run);
    for (edges, of_window) in [(&ridge.edges, false), (&ridge.window, true)] {
        let blur2 = if of_window { &run.window2 } else { &run.blur2 };
        match kept.of::<BENT>(&picture.edges[edges.clone()], rays, run, blur2, count) {
            Keeps::Nothing => return,
            Keeps::All => {}
            Keeps::Some => {
                for i in 0..count {
                    run.light[i] *= kept.share[i];
                }
            }
        }
    }
    for hole in &picture.geometry.holes[ridge.holes.clone()] {
        match kept.of::<BENT>(&picture.edges[hole.clone()], rays, run, &run.blur2, count) {
            Keeps::Nothing => {}
            Keeps::All => return,
            Keeps::Some => {
                for i in 0..count {
                    run.light[i] *= 1.0 - kept.share[i];
                }
            }
        }
    }
    for (out, light) in out.iter_mut().zip(&run.light[..count]) {
        *out += light;
    }
}

/// What seams and spangle of a surface leave in a run.
fn transmission(model: &Model, picture: &Picture, surface: &Surface, row: usize, from: usize, share: &mut [f32]) {
    let rays = model.rays.rays(row as isize, from as isize, share.len());
    let lens = &model.lens;
    for seam in &picture.geometry.seams[surface.seams.clone()] {
        if model.rays.is_bent() {
            vectorised(
                model.arch,
                #[inline(always)]
                || transmission::seam::<true>(surface, seam, lens, rays, share),
            );
        } else {
            vectorised(
                model.arch,
                #[inline(always)]
                || transmission::seam::<false>(surface, seam, lens, rays, share),
            );
        }
    }
    if let Some(spangle) = &surface.spangle {
        if model.rays.is_bent() {
            vectorised(
                model.arch,
                #[inline(always)]
                || transmission::spangle::<true>(surface, spangle, lens, rays, share),
            );
        } else {
            vectorised(
                model.arch,
                #[inline(always)]
                || transmission::spangle::<false>(surface, spangle, lens, rays, share),
            );
        }
    }
}

/// Mean electrons of a run: whole blocks.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // the inside of one loop, with the memory it works on
fn electrons(
    exposure: &Exposure,
    shot: &Shot,
    row: usize,
    from: usize,
    smooth: &[f32],
    laser: Option<&mut [f32]>,
    gains: Option<&[f32]>,
    numbers: &mut RowNoise,
    out: &mut [f32],
) {
    let count = out.len();
    let (scale, dark) = (shot.electrons_per_dn, shot.dark_e);
    let out = &mut out[..count];
    let smooth = &smooth[..count];
    if let Some(laser) = laser {
        exposure.speckle(shot, row, from, laser, numbers);
        let laser = &laser[..count];
        for i in 0..count {
            out[i] = (smooth[i] + laser[i]) * scale;
        }
    } else {
        for i in 0..count {
            out[i] = smooth[i] * scale;
        }
    }
    if let Some(gains) = gains {
        let gains = &gains[..count];
        for i in 0..count {
            out[i] = out[i] * gains[i] + dark;
        }
    } else {
        for light in out.iter_mut() {
            *light += dark;
        }
    }
}

#[inline(always)]
fn add(share: f32, light: &[f32], sum: &mut [f32]) {
    for (sum, light) in sum.iter_mut().zip(light) {
        *sum += light * share;
    }
}
