//! Ridges of neighbouring blocks linked to chains, and chains cut to straight segments.
//!
//! A chain follows a stripe across the image by an alpha-beta filter on its row and slope, over gaps of a few blocks (where another
//! stripe crosses). Where a stripe passes from one wall to the next it kinks: there the chain is cut, by splitting at the point that
//! lies farthest off the chord until none does (Ramer 1972; Douglas and Peucker 1973).

use nalgebra::Vector3;

use super::super::scan::Across;
use super::detect::Ridge;
use super::stripe::Projector;
use super::view::BLOCK;

/// A straight piece of a stripe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Scan coordinates of its ends, on the fitted line.
    pub(super) ends: [[f64; 2]; 2],
    /// Two rays that stand for its points: a line through points of mean a and deviation b has the same weight as two, each of half
    /// their number, at a - b and a + b.
    pub(super) rays: [Vector3<f64>; 2],
    /// How many ridges it rests on.
    pub(super) blocks: usize,
    /// Mean standard deviation of its light, in pixels.
    pub(super) sigma_px: f64,
    /// RMS distance of its ridges from its line, in pixels.
    pub(super) residual_px: f64,
    /// Whether many of its ridges are cut off at their top: it is then no thicker than it seems, but it may be thinner.
    pub(super) is_full: bool,
}

/// A chain while it grows.
#[derive(Clone, Copy, Debug)]
struct Track {
    last: u32,
    block: f64,
    y_px: f64,
    slope: f64,
    /// Thickness of its last ridge (standard deviation), in pixels.
    sigma_px: f64,
    blocks: u32,
}

/// Chains of a frame, with room to work in.
#[derive(Clone, Debug)]
pub(super) struct Chains {
    /// The ridge before, in its chain.
    before: Vec<u32>,
    growing: Vec<Track>,
    members: Vec<u32>,
    pieces: Vec<[u32; 2]>,
}

const NONE: u32 = u32::MAX;
/// A segment of which more ridges than this share are cut off seems thicker than it is.
const FULL_SHARE: f64 = 0.1;
/// Most chains that grow at once.
const MOST_GROWING: usize = 64;
/// Most segments kept.
pub(super) const MOST_SEGMENTS: usize = 48;
/// Blocks that a chain may go without a ridge.
const GAP_BLOCKS: f64 = 10.0;
/// Fewest ridges of a segment.
pub(super) const FEWEST_BLOCKS: usize = 6;
/// Gains of the alpha-beta filter: half of what a ridge is off moves the row, a sixth the slope.
const ALPHA: f64 = 0.5;
const BETA: f64 = 0.17;
/// How far the second ridge of a chain may be off the first, in rows a block: a slope of one.
const FIRST_STEP_PX: f64 = 4.5;
/// How far a ridge may be off where the chain goes, in rows, and how much more for each block since the last.
const GATE_PX: [f64; 2] = [1.2, 0.25];
/// A point farther than this off its chord cuts it, in pixels.
const KINK_PX: f64 = 0.9;
/// Both grow with the stripe's thickness: uneven light moves the middle of a thick one by as large a share of it.
const GATE_SHARE: f64 = 0.2;
const KINK_SHARE: f64 = 0.35;

impl Default for Chains {
    fn default() -> Self {
        Self {
            before: Vec::new(),
            growing: Vec::with_capacity(MOST_GROWING + 1),
            members: Vec::new(),
            pieces: Vec::with_capacity(64),
        }
    }
}

impl Chains {
    /// The straight segments of `ridges`, which come ordered by block and row.
    pub(super) fn find(&mut self, ridges: &[Ridge], projector: &Projector, segments: &mut Vec<Segment>) {
        segments.clear();
        self.before.clear();
        self.before.resize(ridges.len(), NONE);
        self.growing.clear();
        let mut first = 0;
        while first < ridges.len() {
            let block = ridges[first].block;
            let last = first + ridges[first..].iter().take_while(|ridge| ridge.block == block).count();
            self.retire(f64::from(block), ridges, projector, segments);
            self.extend(first..last, ridges);
            first = last;
        }
        self.retire(f64::INFINITY, ridges, projector, segments);
    }

    /// For each ridge of the last frame the one before it in its chain; a number beyond them where there is none.
    pub(super) fn before(&self) -> &[u32] {
        &self.before
    }

    /// Takes the chains out that have ended before `block`.
    fn retire(&mut self, block: f64, ridges: &[Ridge], projector: &Projector, segments: &mut Vec<Segment>) {
        let mut i = 0;
        while i < self.growing.len() {
            if block - self.growing[i].block > GAP_BLOCKS {
                // The order of those that remain is kept: it decides who chooses first.
                let track = self.growing.remove(i);
                if track.blocks as usize >= FEWEST_BLOCKS {
                    self.cut(&track, ridges, projector, segments);
                }
            } else {
                i += 1;
            }
        }
    }

    /// Gives each chain the ridge of this block that lies nearest to where it goes; the others begin chains.
    fn extend(&mut self, here: std::ops::Range<usize>, ridges: &[Ridge]) {
        let block = f64::from(ridges[here.start].block);
        // Longer chains choose first.
        self.growing.sort_by_key(|track| std::cmp::Reverse(track.blocks.min(16)));
        let mut taken = 0u64;
        for track in &mut self.growing {
            let gap = block - track.block;
            let expected = track.y_px + track.slope * gap;
            let gate = if track.blocks == 1 {
                FIRST_STEP_PX * gap.min(2.0)
            } else {
                GATE_PX[0] + GATE_PX[1] * gap + GATE_SHARE * track.sigma_px
            };
            let mut nearest: Option<(usize, f64)> = None;
            for (j, i) in here.clone().enumerate().take(64) {
                let off = ridges[i].y_px - expected;
                if off.abs() <= gate && taken >> j & 1 == 0 && nearest.is_none_or(|(_, best)| off.abs() < best.abs()) {
                    nearest = Some((j, off));
                }
            }
            let Some((j, off)) = nearest else { continue };
            taken |= 1 << j;
            let i = here.start + j;
            self.before[i] = track.last;
            let (slope, y_px) = if track.blocks == 1 {
                (off / gap, ridges[i].y_px)
            } else {
                (track.slope + BETA * off / gap, expected + ALPHA * off)
            };
            *track = Track { last: i as u32, block, y_px, slope, sigma_px: ridges[i].sigma_px, blocks: track.blocks + 1 };
        }
        for (j, i) in here.enumerate().take(64) {
            if taken >> j & 1 == 0 && self.growing.len() < MOST_GROWING {
                self.growing.push(Track {
                    last: i as u32,
                    block,
                    y_px: ridges[i].y_px,
                    slope: 0.0,
                    sigma_px: ridges[i].sigma_px,
                    blocks: 1,
                });
            }
        }
    }

    /// Cuts a chain where it kinks and keeps its straight pieces.
    fn cut(&mut self, track: &Track, ridges: &[Ridge], projector: &Projector, segments: &mut Vec<Segment>) {
        self.members.clear();
        let mut at = track.last;
        while at != NONE {
            self.members.push(at);
            at = self.before[at as usize];
        }
        self.members.reverse();
        self.pieces.clear();
        self.pieces.push([0, self.members.len() as u32]);
        while let Some([from, to]) = self.pieces.pop() {
            let members = &self.members[from as usize..to as usize];
            if members.len() < FEWEST_BLOCKS || segments.len() >= MOST_SEGMENTS {
                continue;
            }
            match farthest(members, ridges) {
                Some(kink) if self.pieces.len() + 2 <= self.pieces.capacity() => {
                    let kink = from + kink as u32;
                    self.pieces.push([kink, to]);
                    self.pieces.push([from, kink]);
                }
                _ => segments.extend(fit(members, ridges, projector)),
            }
        }
    }
}

fn place(ridge: &Ridge) -> [f64; 2] {
    [f64::from(ridge.block) * BLOCK as f64 + (BLOCK as f64 - 1.0) / 2.0, ridge.y_px]
}

/// The point farthest off the least-squares line of these, if it is farther than a kink allows: smoothed over three neighbours, so
/// that one ridge that is off does not cut.
fn farthest(members: &[u32], ridges: &[Ridge]) -> Option<usize> {
    let point = |i: usize| place(&ridges[members[i] as usize]);
    // The chord: between the means of the first and the last few.
    let few = (members.len() / 6).clamp(1, 4);
    let mean = |from: usize| {
        let sum = (from..from + few).map(point).fold([0.0; 2], |[x, y], p| [x + p[0], y + p[1]]);
        sum.map(|value| value / few as f64)
    };
    let ([x0, y0], [x1, y1]) = (mean(0), mean(members.len() - few));
    let slope = (y1 - y0) / (x1 - x0).max(1.0);
    let off = |i: usize| point(i)[1] - y0 - slope * (point(i)[0] - x0);
    let sigma_px = members.iter().map(|i| ridges[*i as usize].sigma_px).sum::<f64>() / members.len() as f64;
    let mut worst = (0, KINK_PX.max(KINK_SHARE * sigma_px));
    for i in few..members.len() - few {
        let smooth = (off(i - 1) + off(i) + off(i + 1)).abs() / 3.0;
        if smooth > worst.1 {
            worst = (i, smooth);
        }
    }
    (worst.0 > 0).then_some(worst.0)
}

/// Least-squares line through ridges, those left out that lie three deviations off.
fn fit(members: &[u32], ridges: &[Ridge], projector: &Projector) -> Option<Segment> {
    let (mut line, mut limit) = ((0.0, 0.0, 0.0), f64::INFINITY);
    let (mut n, mut residual, mut sigma, mut extent, mut spread, mut full) = (0.0, 0.0, 0.0, [0.0, 0.0], 0.0, 0.0);
    for _ in 0..3 {
        let kept = || {
            let near = move |p: &[f64; 2]| (p[1] - line.0 - line.1 * (p[0] - line.2)).abs() <= limit;
            members.iter().map(|i| &ridges[*i as usize]).filter(move |ridge| near(&place(ridge)))
        };
        let (mut sum_x, mut sum_y) = (0.0, 0.0);
        (n, sigma, full) = (0.0, 0.0, 0.0);
        extent = [f64::INFINITY, f64::NEG_INFINITY];
        for ridge in kept() {
            let [x, y] = place(ridge);
            n += 1.0;
            sum_x += x;
            sum_y += y;
            sigma += ridge.sigma_px;
            full += f64::from(u8::from(ridge.is_full));
            extent = [extent[0].min(x), extent[1].max(x)];
        }
        if (n as usize) < FEWEST_BLOCKS {
            return None;
        }
        let (mean_x, mean_y) = (sum_x / n, sum_y / n);
        let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
        for ridge in kept() {
            let [x, y] = place(ridge);
            let (dx, dy) = (x - mean_x, y - mean_y);
            sxx += dx * dx;
            sxy += dx * dy;
            syy += dy * dy;
        }
        let slope = sxy / sxx;
        residual = ((syy - slope * sxy).max(0.0) / n).sqrt();
        spread = (sxx / n).sqrt();
        line = (mean_y, slope, mean_x);
        limit = (3.0 * residual).max(0.3);
    }
    let at = |x: f64| [x, line.0 + line.1 * (x - line.2)];
    let rays = [line.2 - spread, line.2 + spread].map(|x| projector.ray(x, at(x)[1]));
    Some(Segment {
        ends: extent.map(at),
        rays,
        blocks: n as usize,
        sigma_px: sigma / n,
        residual_px: residual,
        is_full: full > FULL_SHARE * n,
    })
}

impl Segment {
    /// Ends in pixels (u, v).
    pub(super) fn ends_px(&self, across: Across) -> [[f64; 2]; 2] {
        self.ends.map(|[x, y]| across.pixel(x, y))
    }
}
