//! Ridges of the width that a stripe must have, found in every fourth column.
//!
//! A matched filter of boxes: the mean over the stripe's middle (2 h rows, h = 1.2 standard deviations) less the *greater* of the
//! means over h rows on either side, a gap of h rows away. Taking the greater makes the edge between a bright and a dark wall answer
//! with nothing, where the mean would answer with half the step. The width follows the stripe: at each pixel a laser's light can
//! have come from one depth only, so the standard deviation it must have there is known beforehand
//! ([`super::stripe::Projector::upright_sigma`]); where lasers differ, the better answer counts.

use super::stripe::Projector;
use super::view::BLOCK;

/// A ridge in one block of columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ridge {
    /// Which block.
    pub(super) block: u16,
    /// Its middle in scan coordinates, in pixels.
    pub(super) y_px: f64,
    /// Its height above what is beside it, averaged over its middle, in DN of 8 bits.
    pub(super) contrast_dn: f64,
    /// Standard deviation of its light, from its area and its peak, in pixels.
    pub(super) sigma_px: f64,
    /// Whether its top is cut off: then area over peak is more than its thickness.
    pub(super) is_full: bool,
}

/// A run of blocks in a row for which one half width is right.
#[derive(Clone, Copy, Debug)]
struct Run {
    from: u16,
    to: u16,
    half: u16,
}

/// The filter with its tables and buffers.
#[derive(Clone, Debug)]
pub(super) struct Detector {
    size: [usize; 2],
    /// Runs of each laser and row, and where each row's begin.
    runs: Vec<Run>,
    starts: Vec<u32>,
    least: u16,
    sums: Vec<u16>,
    /// Sums of `sums` from the first row on, wrapping: differences over fewer than 64 rows are exact.
    prefix: Vec<u16>,
    /// Answer in eighths of a DN in the upper 11 bits, half width in the lower 5.
    answer: Vec<u16>,
    found: Vec<Ridge>,
    order: Vec<u32>,
}

/// Half of the filter's middle, in standard deviations.
const HALF_PER_SIGMA: f64 = 1.2;
/// Least and greatest half width, in rows.
const HALF_PX: [f64; 2] = [2.0, 30.0];
/// Most ridges that a frame may have: an image of nothing but noise has more, and is none of ours.
const MOST: usize = 6000;
/// A block is full from this share of the largest sum on: the four pixels of a block are not all full where a stripe's edge is slanted.
const FULL_SHARE: f64 = 0.98;
/// 1 / sqrt(2 pi).
const PEAK_OF_UNIT_AREA: f64 = 0.398_942_280_401_432_7;

impl Detector {
    /// For ridges at least `contrast_dn` (DN of 8 bits) high, of lasers seen on surfaces within `range_m` (depths).
    pub(super) fn new(projector: &Projector, range_m: [f64; 2], contrast_dn: f64) -> Self {
        let size = [projector.size[0] / BLOCK, projector.size[1]];
        let (mut runs, mut starts) = (Vec::new(), vec![0]);
        for y in 0..size[1] {
            for laser in 0..projector.lasers.len() {
                let half = |block: usize| -> u16 {
                    let x = (block * BLOCK) as f64 + (BLOCK as f64 - 1.0) / 2.0;
                    let sigma = projector.upright_sigma(laser, x, y as f64, range_m);
                    sigma.map_or(0, |sigma| (HALF_PER_SIGMA * sigma).round().clamp(HALF_PX[0], HALF_PX[1]) as u16)
                };
                let mut from = 0;
                while from < size[0] {
                    let width = half(from);
                    let to = (from + 1..size[0]).find(|block| half(*block) != width).unwrap_or(size[0]);
                    if width > 0 {
                        runs.push(Run { from: from as u16, to: to as u16, half: width });
                    }
                    from = to;
                }
            }
            starts.push(runs.len() as u32);
        }
        Self {
            size,
            runs,
            starts,
            least: (contrast_dn * 8.0).round().clamp(1.0, 2047.0) as u16,
            sums: Vec::new(),
            prefix: vec![0; size[0] * (size[1] + 1)],
            answer: vec![0; size[0] * size[1]],
            found: Vec::with_capacity(MOST),
            order: Vec::with_capacity(MOST),
        }
    }

    /// Room for the sums of [`super::view::View::sum_blocks`], to be filled before [`Self::find`].
    pub(super) fn sums(&mut self) -> &mut Vec<u16> {
        &mut self.sums
    }

    /// The ridges, ordered by block and row, written to `ridges`. A block of nothing but full pixels has the sum `full`.
    pub(super) fn find(&mut self, full: u16, ridges: &mut Vec<Ridge>) {
        self.add_up();
        self.respond();
        self.peaks(FULL_SHARE * f64::from(full));
        self.order.clear();
        self.order.extend(0..self.found.len() as u32);
        let found = &self.found;
        // Rows come in order already; a sort by block that is stable keeps it. (`sort_by_key` allocates; ties are told apart instead.)
        self.order.sort_unstable_by_key(|i| (found[*i as usize].block, *i));
        ridges.clear();
        for i in &self.order {
            let ridge = found[*i as usize];
            // Of two in one column that are nearer than their widths the higher stays.
            match ridges
                .last_mut()
                .filter(|last| last.block == ridge.block && ridge.y_px - last.y_px < 1.5 * last.sigma_px.min(ridge.sigma_px))
            {
                Some(last) if last.contrast_dn < ridge.contrast_dn => *last = ridge,
                Some(_) => {}
                None => ridges.push(ridge),
            }
        }
    }

    fn add_up(&mut self) {
        let columns = self.size[0];
        self.prefix[..columns].fill(0);
        for y in 0..self.size[1] {
            let (before, after) = self.prefix[y * columns..].split_at_mut(columns);
            let row = &self.sums[y * columns..(y + 1) * columns];
            for ((to, from), value) in after[..columns].iter_mut().zip(&*before).zip(row) {
                *to = from.wrapping_add(*value);
            }
        }
    }

    fn respond(&mut self) {
        let [columns, rows] = self.size;
        for y in 0..rows {
            let answer = &mut self.answer[y * columns..(y + 1) * columns];
            answer.fill(0);
            for run in &self.runs[self.starts[y] as usize..self.starts[y + 1] as usize] {
                let half = usize::from(run.half);
                let blocks = usize::from(run.from)..usize::from(run.to);
                let row = |y: usize| &self.prefix[y * columns..][blocks.clone()];
                if y < half || y + half > rows {
                    continue;
                }
                let (above, below) = (y.checked_sub(3 * half), (y + 3 * half <= rows).then_some(y + 2 * half));
                // Where the image ends on one side, the other side stands for both.
                let (Some(over), Some(under)) = (above.or(below), below.or(above)) else { continue };
                let middle = (row(y - half), row(y + half));
                let over = (row(over), row(over + half));
                let under = (row(under), row(under + half));
                respond(&mut answer[blocks.clone()], run.half, middle, over, under);
            }
        }
    }

    fn peaks(&mut self, full: f64) {
        let [columns, rows] = self.size;
        self.found.clear();
        let least = self.least << 5;
        for y in 1..rows - 1 {
            let [above, here, below] = [y - 1, y, y + 1].map(|y| &self.answer[y * columns..(y + 1) * columns]);
            for first in (0..columns).step_by(16) {
                let last = (first + 16).min(columns);
                if here[first..last].iter().fold(0, |most: u16, value| most.max(*value)) < least {
                    continue;
                }
                for block in first..last {
                    let value = here[block];
                    if value >= least && value >= above[block] && value > below[block] && self.found.len() < MOST {
                        let ridge = self.measure(block, y, usize::from(value & 31), f64::from(value >> 5) / 8.0, full);
                        self.found.extend(ridge);
                    }
                }
            }
        }
    }

    /// Middle and width of the ridge about the boundary before row `y`.
    fn measure(&self, block: usize, y: usize, half: usize, contrast_dn: f64, most: f64) -> Option<Ridge> {
        let [columns, rows] = self.size;
        let (from, to) = (y.saturating_sub(2 * half + 1), (y + 2 * half + 1).min(rows));
        let value = |y: usize| f64::from(self.sums[y * columns + block]);
        let mean = |from: usize, to: usize| (from..to).map(value).sum::<f64>() / (to - from) as f64;
        let edge = (half / 2).max(2);
        let (over, under) = (mean(from, from + edge), mean(to - edge, to));
        let (over_y, slope) = (from as f64 + (edge as f64 - 1.0) / 2.0, (under - over) / ((to - from - edge) as f64));
        let (mut light, mut moment, mut peak, mut full) = (0.0, 0.0, 0.0, 0);
        for row in from..to {
            let above = value(row) - over - slope * (row as f64 - over_y);
            full += usize::from(value(row) >= most);
            light += above;
            moment += above * row as f64;
            peak = f64::max(peak, above);
        }
        let y_px = moment / light;
        let inside = light > 0.0 && (y_px - (y as f64 - 0.5)).abs() <= 1.5 * half as f64;
        let sigma_px = PEAK_OF_UNIT_AREA * light / peak;
        inside.then_some(Ridge { block: block as u16, y_px, contrast_dn, sigma_px, is_full: full >= 2 })
    }
}

/// Four times what a DN is, over 2 h rows, is 8 h: the answer in eighths of a DN is the difference of the sums over h.
fn respond(answer: &mut [u16], half: u16, middle: (&[u16], &[u16]), over: (&[u16], &[u16]), under: (&[u16], &[u16])) {
    let share = (65536 / u32::from(half)) as u16;
    let n = answer.len();
    let (m0, m1, o0, o1, u0, u1) = (&middle.0[..n], &middle.1[..n], &over.0[..n], &over.1[..n], &under.0[..n], &under.1[..n]);
    for i in 0..n {
        let beside = o1[i].wrapping_sub(o0[i]).max(u1[i].wrapping_sub(u0[i]));
        let above = m1[i].wrapping_sub(m0[i]).saturating_sub(beside).saturating_sub(beside);
        let eighths = ((u32::from(above) * u32::from(share)) >> 16) as u16;
        answer[i] = answer[i].max(eighths << 5 | half);
    }
}
