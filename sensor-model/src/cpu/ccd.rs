//! From light to grey values, a row at a time.

use super::tables::BLOCK;
use crate::noise::{self, Key, Stream};
use crate::optics::{Ccd, Optics};
use crate::vector_math::{clamp, max, min, normals};

/// The CCD in single precision.
#[derive(Debug)]
pub(super) struct Exposure {
    /// Electrons that the full well holds.
    well_e: f32,
    read_e2: f32,
    electrons_per_dn: f64,
    nominal_s: f64,
    dark_e_s: f64,
    black: f32,
    per_electron: f32,
    largest: f32,
    /// (constant, slope) of the cube root of the speckle.
    speckle: [f32; 2],
    has_speckle: bool,
    noise: bool,
    grain: Option<Grain>,
}

/// The lattice of a grain wider than a pixel: nodes and weights of each column and row.
#[derive(Debug)]
struct Grain {
    columns: Vec<(u32, [f32; 2])>,
    rows: Vec<(u32, [f32; 2])>,
    /// Nodes in a row that are drawn, whole pairs of blocks.
    nodes: usize,
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shot {
    /// Electrons a DN of light.
    pub(super) electrons_per_dn: f32,
    /// Electrons of dark current.
    pub(super) dark_e: f32,
    /// The exposure, in seconds.
    pub(super) exposure_s: f32,
    noise_key: Key,
    speckle_key: Key,
}

/// Random numbers of a row; kept for their memory.
#[derive(Debug, Default)]
pub(super) struct RowNoise {
    pairs: [Vec<f32>; 2],
    /// Shot and read noise of each pixel.
    shot: Vec<f32>,
    /// Normal numbers of the speckle: of the pixels, or of a row of nodes above and below.
    speckle: [Vec<f32>; 2],
}

impl Exposure {
    pub(super) fn new(optics: &Optics, width: usize, height: usize) -> Self {
        let ccd = &optics.ccd;
        let Ccd { full_well_e, read_noise_e, black_level_dn, bits, .. } = *ccd;
        let largest = f64::from(bits.max_dn());
        let spacing = optics.speckle_grain_px;
        let has_speckle = optics.noise && optics.speckle_contrast > 0.0;
        let grain = (has_speckle && spacing > 1.0).then(|| {
            let along = |pixels: usize| {
                (0..pixels).map(|at| noise::grain(at, spacing)).map(|(node, w)| (node, w.map(|w| w as f32))).collect()
            };
            let columns: Vec<(u32, [f32; 2])> = along(width);
            let nodes = columns.last().map_or(0, |(node, _)| *node as usize + 2).next_multiple_of(BLOCK);
            Grain { columns, rows: along(height), nodes }
        });
        Self {
            well_e: full_well_e as f32,
            read_e2: (read_noise_e * read_noise_e) as f32,
            electrons_per_dn: 1.0 / ccd.dn_per_electron(),
            nominal_s: optics.exposure_s,
            dark_e_s: ccd.dark_current_e_s,
            black: (black_level_dn * largest / 255.0) as f32,
            per_electron: (ccd.dn_per_electron() * largest / 255.0) as f32,
            largest: largest as f32,
            speckle: noise::speckle_terms(optics.speckle_contrast).map(|term| term as f32),
            has_speckle,
            noise: optics.noise,
            grain,
        }
    }

    /// The exposure of a frame.
    pub(super) fn shot(&self, seed: u64, frame: u64, exposure_s: f64) -> Shot {
        Shot {
            electrons_per_dn: (self.electrons_per_dn * exposure_s / self.nominal_s) as f32,
            dark_e: (self.dark_e_s * exposure_s) as f32,
            exposure_s: exposure_s as f32,
            noise_key: noise::key(seed, Stream::Shot, frame),
            speckle_key: noise::key(seed, Stream::Speckle, frame),
        }
    }

    /// Multiplies lasers' light in some columns of a row by its speckle; both ends are whole blocks.
    #[inline(always)]
    pub(super) fn speckle(&self, shot: &Shot, row: usize, from: usize, laser: &mut [f32], numbers: &mut RowNoise) {
        if !self.has_speckle {
            return;
        }
        let count = laser.len();
        let [constant, slope] = self.speckle;
        let factor = |normal: f32| {
            let root = max(constant + slope * normal, 0.0);
            root * root * root
        };
        let RowNoise { pairs, speckle: [above, below], .. } = numbers;
        let Some(grain) = &self.grain else {
            draw_row(shot.speckle_key, row, from, count, pairs, above);
            let normals = &above[..count];
            for i in 0..count {
                laser[i] *= factor(normals[i]);
            }
            return;
        };
        let (line, [w_above, w_below]) = grain.rows[row];
        let last = grain.columns.len() - 1;
        let column = |at: usize| grain.columns[if at < last { at } else { last }];
        let first = column(from).0 as usize / BLOCK * BLOCK;
        let nodes = (column(from + count - 1).0 as usize + 2 - first).next_multiple_of(BLOCK).min(grain.nodes - first);
        draw_row(shot.speckle_key, line as usize, first, nodes, pairs, above);
        draw_row(shot.speckle_key, line as usize + 1, first, nodes, pairs, below);
        for i in 0..nodes {
            above[i] = w_above * above[i] + w_below * below[i];
        }
        for (i, light) in laser.iter_mut().enumerate() {
            let (node, [left, right]) = column(from + i);
            let node = node as usize - first;
            *light *= factor(left * above[node] + right * above[node + 1]);
        }
    }

    /// Grey values of a row of mean electrons. `dark_e` is the row's dark values, if the CCD has any; `put` takes a column and its value.
    #[inline(always)]
    pub(super) fn read_out<T: Grey>(
        &self,
        shot: &Shot,
        row: usize,
        mean_e: &[f32],
        dark_e: Option<&[f32]>,
        numbers: &mut RowNoise,
        out: &mut [T],
    ) {
        let width = out.len();
        let mean_e = &mean_e[..width];
        let (black, per_electron, largest, well) = (self.black, self.per_electron, self.largest, self.well_e);
        let grey = |charge: f32| {
            let dn = clamp(black + per_electron * min(charge, well), 0.0, largest);
            T::of(round(dn))
        };
        if !self.noise {
            for i in 0..width {
                out[i] = grey(mean_e[i]);
            }
            return;
        }
        let RowNoise { pairs, shot: normals, .. } = numbers;
        draw_row(shot.noise_key, row, 0, width.next_multiple_of(BLOCK), pairs, normals);
        let normals = &normals[..width];
        let read_e2 = self.read_e2;
        if let Some(dark_e) = dark_e {
            let dark_e = &dark_e[..width];
            for i in 0..width {
                out[i] = grey(mean_e[i] + dark_e[i] + (mean_e[i] + read_e2).sqrt() * normals[i]);
            }
        } else {
            for i in 0..width {
                out[i] = grey(mean_e[i] + (mean_e[i] + read_e2).sqrt() * normals[i]);
            }
        }
    }
}

/// A grey value of a certain depth.
pub(super) trait Grey: Copy + Send {
    /// From a number that fits.
    fn of(value: u32) -> Self;
}

impl Grey for u8 {
    #[inline(always)]
    fn of(value: u32) -> Self {
        value as Self
    }
}

impl Grey for u16 {
    #[inline(always)]
    fn of(value: u32) -> Self {
        value as Self
    }
}

/// floor(x + 1/2) for x from 0 to 65535.
#[inline(always)]
fn round(x: f32) -> u32 {
    /// 2^23: numbers above have no fraction, and the integer in their low bits.
    const INTEGERS: f32 = 8_388_608.0;
    let up = x + 0.5;
    let shifted = up + INTEGERS;
    let above = shifted - INTEGERS > up;
    (shifted.to_bits() & 0xffff).wrapping_sub(u32::from(above))
}

/// The normal numbers of `count` places of a row from `from` on (both whole blocks), into `out`.
#[inline(always)]
fn draw_row(key: Key, row: usize, from: usize, count: usize, pairs: &mut [Vec<f32>; 2], out: &mut Vec<f32>) {
    let half = count / 2;
    let [cosines, sines] = pairs;
    // Only a renderer's first frames find less room than they need.
    for room in [&mut *cosines, &mut *sines] {
        if room.len() < half {
            room.resize(half, 0.0);
        }
    }
    if out.len() < count {
        out.resize(count, 0.0);
    }
    let (cosines, sines, out) = (&mut cosines[..half], &mut sines[..half], &mut out[..count]);
    let first = noise::pair(noise::place(from as u32, row as u32));
    for i in 0..half {
        (cosines[i], sines[i]) = normals(noise::draw(first.wrapping_add(i as u32), key));
    }
    const HALF: usize = BLOCK / 2;
    for ((block, cosines), sines) in out.chunks_exact_mut(BLOCK).zip(cosines.chunks_exact(HALF)).zip(sines.chunks_exact(HALF)) {
        block[..HALF].copy_from_slice(cosines);
        block[HALF..].copy_from_slice(sines);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_that_of_the_formula() {
        for x in [0.0, 0.25, 0.5, 0.75, 1.0, 1.49, 1.5, 2.5, 254.5, 254.99, 255.0, 4094.5, 4095.0] {
            assert_eq!(round(x), (x + 0.5).floor() as u32, "{x}");
        }
        let mut x = 0.0_f32;
        while x < 300.0 {
            assert_eq!(round(x), (x + 0.5).floor() as u32, "{x}");
            x += 0.001_37;
        }
    }

    #[test]
    fn a_rows_numbers_are_those_of_its_places() {
        let key = noise::key(4, Stream::Shot, 9);
        let (mut pairs, mut row) = ([Vec::new(), Vec::new()], Vec::new());
        draw_row(key, 3, 32, 64, &mut pairs, &mut row);
        for (i, found) in row.iter().enumerate() {
            let exact = noise::normal(noise::place(32 + i as u32, 3), key);
            assert!((f64::from(*found) - exact).abs() < 2e-6, "{i}: {found} {exact}");
        }
    }
}
