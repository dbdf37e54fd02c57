//! The frame as the robust pipeline looks at it: in scan coordinates, x along the stripes and y across them, at full resolution
//! for measuring, and in sums of four pixels along the stripes for finding.
//!
//! A stripe is a long ridge, so a quarter of the columns shows where all are; the sums also halve the noise.

use super::super::scan::Across;
use crate::messages::{Frame, Pixels};

/// Columns that are added up for finding.
pub(super) const BLOCK: usize = 4;

/// A frame in scan coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pixels: Pixels<'a>,
    stride: [usize; 2],
    /// Columns (along the stripes) and rows (across them).
    pub(super) size: [usize; 2],
    /// At this value and beyond a pixel is taken as full.
    pub(super) full: f64,
    /// Grey values of 8 bits for one of this frame.
    pub(super) dn8_per_dn: f64,
}

impl<'a> View<'a> {
    pub(super) fn new(frame: &Frame<'a>, across: Across) -> Self {
        let (stride, size) = match across {
            Across::V => ([1, frame.width_px], [frame.width_px, frame.height_px]),
            Across::U => ([frame.width_px, 1], [frame.height_px, frame.width_px]),
        };
        Self { pixels: frame.pixels, stride, size, full: f64::from(frame.max_dn) - 0.5, dn8_per_dn: 1.0 / frame.dn_per_dn8() }
    }

    /// Calls `each` with the values of column `x`, rows `from..to`.
    pub(super) fn column(&self, x: usize, from: usize, to: usize, mut each: impl FnMut(usize, f64)) {
        let start = x * self.stride[0];
        match self.pixels {
            Pixels::Grey8(values) => (from..to).for_each(|y| each(y, f64::from(values[start + y * self.stride[1]]))),
            Pixels::Grey16(values) => (from..to).for_each(|y| each(y, f64::from(values[start + y * self.stride[1]]))),
        }
    }

    /// Sums over `BLOCK` columns, row by row, in the units of four pixels of 8 bits at most 10 bits in all: deeper frames lose their
    /// last bits, which finding does not need.
    pub(super) fn sum_blocks(&self, sums: &mut Vec<u16>) -> [usize; 2] {
        let size = [self.size[0] / BLOCK, self.size[1]];
        sums.clear();
        sums.resize(size[0] * size[1], 0);
        match self.pixels {
            Pixels::Grey8(values) => self.sum(values, 0, size, sums),
            Pixels::Grey16(values) => {
                let most = (self.full + 0.5) as u32;
                let shift = (32 - most.leading_zeros()).saturating_sub(8);
                self.sum(values, shift, size, sums);
            }
        }
        size
    }

    /// What [`Self::sum_blocks`] gives for a block of full pixels.
    pub(super) fn full_block(&self) -> u16 {
        let most = (self.full + 0.5) as u32;
        let shift = match self.pixels {
            Pixels::Grey8(_) => 0,
            Pixels::Grey16(_) => (32 - most.leading_zeros()).saturating_sub(8),
        };
        // 255 at most.
        (most >> shift) as u16 * BLOCK as u16
    }

    fn sum<T: Copy + Into<u16>>(&self, values: &[T], shift: u32, [columns, rows]: [usize; 2], sums: &mut [u16]) {
        if self.stride[0] == 1 {
            for (line, to) in values.chunks_exact(self.stride[1]).zip(sums.chunks_exact_mut(columns)) {
                for (four, sum) in line.chunks_exact(BLOCK).zip(to) {
                    *sum = four.iter().map(|value| (*value).into() >> shift).sum();
                }
            }
            return;
        }
        // Stripes run down the image: four of its rows are added up, and the result is turned.
        for block in 0..columns {
            let lines = &values[block * BLOCK * rows..(block + 1) * BLOCK * rows];
            let (a, rest) = lines.split_at(rows);
            let (b, rest) = rest.split_at(rows);
            let (c, d) = rest.split_at(rows);
            for y in 0..rows {
                let four = [a[y], b[y], c[y], d[y]];
                sums[y * columns + block] = four.into_iter().map(|value| value.into() >> shift).sum();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_sums_along_the_stripes() {
        let pixels: Vec<u8> = (0..24 * 17).map(|i| (i * 7 % 251) as u8).collect();
        let frame = Frame::grey8(24, 17, &pixels);
        for across in [Across::V, Across::U] {
            let view = View::new(&frame, across);
            let mut sums = Vec::new();
            let [columns, rows] = view.sum_blocks(&mut sums);
            assert_eq!([columns, rows], [view.size[0] / 4, view.size[1]]);
            for block in 0..columns {
                for y in 0..rows {
                    let mut expected = 0.0;
                    (0..4).for_each(|i| view.column(4 * block + i, y, y + 1, |_, value| expected += value));
                    assert_eq!(f64::from(sums[y * columns + block]), expected, "{across:?} {block} {y}");
                }
            }
        }
    }
}
