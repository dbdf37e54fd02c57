//! One range a laser in each block of columns: the plan of what is around, as a line scanner would see it, whatever it is.
//!
//! A ridge of the image may be any laser's, and says where its surface is for each. In a column a laser's plane is met once, so each laser
//! takes one ridge or none. What is likely: stripes of two lasers on one upright surface lie above one another in the plan; a point at the
//! floor's height is the floor; and a stripe goes on from column to column. The likeliest choices along the image are found by dynamic
//! programming (A. J. Viterbi, IEEE Trans. Inf. Theory 13, 1967), block by block.

use nalgebra::Point3;

use super::super::{RangePoint, Upon};
use super::detect::Ridge;
use super::proposal::{MOST_LASERS, Upright};
use super::stripe::Projector;
use super::view::BLOCK;

/// Ridges that a laser chooses among in a block: those whose thickness suits it best.
const CANDIDATES: usize = 4;
/// Choices of all lasers in a block at most; further ones are left out.
const MOST_CHOICES: usize = 128;
/// What it is worth that a ridge is explained ...
const EXPLAINED: f64 = 2.0;
/// ... less this times the squared logarithm of its thickness over the expected one, beyond what the thickness of a ridge, which is taken
/// over the filter's own width, may be off, ...
const THICKNESS: f64 = 6.0;
const THICKNESS_OFF: f64 = 0.25;
/// ... and what it is worth that two lasers show the same upright surface, or that a point lies on the floor, ...
const AGREED: f64 = 2.0;
const ON_FLOOR: f64 = 1.0;
/// ... and what it costs that two lasers show different ones, and that a laser's stripe jumps or begins or ends.
const DISAGREED: f64 = 1.5;
const JUMPS: f64 = 2.0;
const BREAKS: f64 = 0.7;
/// ... and that it becomes another's where a chain of ridges goes straight on: stripes cross, and by their rows alone they might as well
/// turn away from each other there.
const EXCHANGED: f64 = 4.0;
/// A point within this of the floor's height lies on it, in metres.
const FLOOR_M: f64 = 0.02;
/// Light from below the floor is none of this duct's, unless it falls away: by no more than this for the way to there (11 degrees), as far
/// aside as this for the way ahead, beyond which a near wall's stripe would be taken for it.
const BELOW_M: f64 = -0.02;
const STEEPEST: f64 = 0.194;
const BELOW_ASIDE: f64 = 0.45;
/// Two ranges agree within this, in metres, and this times the square of the range, per metre: 0.2 px of a base of 60 mm and 380 px.
const AGREE_M: f64 = 0.01;
const AGREE_1_M: f64 = 0.02;
/// Anything nearer ahead than this would be seen, in metres.
const AIR_M: f64 = 1.8;
/// Stripes touch where they are nearer than this, in pixels, over no more blocks than these in which they cannot be told apart.
const TOUCH_PX: f64 = 12.0;
const TOUCH_BLOCKS: usize = 14;
/// A floor farther than this is too faint to be missed, in metres.
const FLOOR_WITHIN_M: f64 = 1.6;
/// A stripe goes on if its row changes by less than this from a block to the next, in pixels.
const GOES_ON_PX: f64 = 4.0;
/// A stripe shorter than this many blocks is noise.
const FEWEST_BLOCKS: usize = 4;

/// A ridge taken for a laser.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    laser: usize,
    ridge: usize,
    point: Point3<f64>,
    range_m: f64,
    upon: Upon,
    worth: f64,
}

/// What each laser takes in a block.
#[derive(Clone, Copy, Debug)]
struct Choice {
    taken: [Option<u32>; MOST_LASERS],
    /// The ridge that each laser took last, here or in the blocks before.
    last: [Option<u32>; MOST_LASERS],
    worth: f64,
    total: f64,
    before: u32,
}

/// Finds ranges, with room to work in.
#[derive(Clone, Debug, Default)]
pub(super) struct Ranger {
    candidates: Vec<Candidate>,
    choices: Vec<Choice>,
    /// Where each block's choices begin, and which block it is.
    blocks: Vec<(u32, u16)>,
    chosen: Vec<(u16, [Option<u32>; MOST_LASERS])>,
    /// Blocks in which two lasers are seen, and those in which they are exchanged.
    both: Vec<(usize, f64)>,
    exchange: Vec<usize>,
}

impl Ranger {
    /// The points of `ridges` (ordered by block and row), written to `points`, by laser and then across the image.
    /// `chained` has for each ridge the one before it in its chain.
    pub(super) fn find(
        &mut self,
        ridges: &[Ridge],
        chained: &[u32],
        projector: &Projector,
        upright: &Upright,
        range_m: [f64; 2],
        points: &mut Vec<RangePoint>,
    ) {
        points.clear();
        self.candidates.clear();
        self.choices.clear();
        self.blocks.clear();
        let mut first = 0;
        while first < ridges.len() {
            let block = ridges[first].block;
            let last = first + ridges[first..].iter().take_while(|ridge| ridge.block == block).count();
            self.block(first..last, ridges, chained, projector, upright, range_m);
            first = last;
        }
        self.trace();
        self.uncross(ridges);
        let lasers = projector.lasers.len().min(MOST_LASERS);
        for laser in 0..lasers {
            self.stripes(laser, ridges, points);
            self.unlit_floor(laser, projector, upright, points);
            self.open_air(laser, projector, upright, points);
        }
    }

    /// What the lasers may take in one block, and the best way to each of these choices from the blocks before.
    fn block(
        &mut self,
        here: std::ops::Range<usize>,
        ridges: &[Ridge],
        chained: &[u32],
        projector: &Projector,
        upright: &Upright,
        range_m: [f64; 2],
    ) {
        let lasers = projector.lasers.len().min(MOST_LASERS);
        let mut of_laser: [std::ops::Range<usize>; MOST_LASERS] = std::array::from_fn(|_| 0..0);
        for (laser, own) in of_laser.iter_mut().enumerate().take(lasers) {
            let from = self.candidates.len();
            let found = here.clone().filter_map(|i| candidate(i, &ridges[i], laser, projector, upright, range_m));
            self.candidates.extend(found);
            let own_candidates = &mut self.candidates[from..];
            own_candidates.sort_unstable_by(|a, b| b.worth.total_cmp(&a.worth).then(a.ridge.cmp(&b.ridge)));
            let kept = own_candidates.len().min(CANDIDATES);
            self.candidates.truncate(from + kept);
            *own = from..from + kept;
        }
        let start = self.choices.len();
        self.choices.push(Choice { taken: [None; MOST_LASERS], last: [None; MOST_LASERS], worth: 0.0, total: 0.0, before: 0 });
        for (laser, own) in of_laser.iter().enumerate().take(lasers) {
            // Each choice of the lasers before, with each candidate of this one, or none.
            for choice in start..self.choices.len() {
                let base = self.choices[choice];
                for at in own.clone() {
                    if self.choices.len() - start >= MOST_CHOICES {
                        break;
                    }
                    if let Some(worth) = self.with(&base, at) {
                        let mut taken = base.taken;
                        taken[laser] = Some(at as u32);
                        self.choices.push(Choice { taken, worth, ..base });
                    }
                }
            }
        }
        self.link(start, ridges, chained);
        self.blocks.push((start as u32, ridges[here.start].block));
    }

    /// What a choice is worth with one more candidate; `None` where its ridge is taken.
    fn with(&self, base: &Choice, at: usize) -> Option<f64> {
        let new = &self.candidates[at];
        let mut worth = base.worth + new.worth;
        for other in base.taken.iter().flatten().map(|at| &self.candidates[*at as usize]) {
            if other.ridge == new.ridge {
                return None;
            }
            let play_m = AGREE_M + AGREE_1_M * square(new.range_m.min(other.range_m));
            worth += match (other.upon, new.upon) {
                (Upon::Upright, Upon::Upright) if (other.range_m - new.range_m).abs() <= play_m => AGREED,
                (Upon::Upright, Upon::Upright) => -DISAGREED,
                // An upright surface in front of the floor that is seen would hide it.
                (Upon::Floor | Upon::Below, Upon::Upright) if new.range_m < other.range_m - play_m => -DISAGREED,
                (Upon::Upright, Upon::Floor | Upon::Below) if other.range_m < new.range_m - play_m => -DISAGREED,
                _ => 0.0,
            };
        }
        Some(worth)
    }

    /// Finds the best way to each choice of a block from those of the block before.
    fn link(&mut self, start: usize, ridges: &[Ridge], chained: &[u32]) {
        let ridge = |at: u32| self.candidates[at as usize].ridge;
        let taken_now = |choice: &Choice| choice.taken.map(|taken| taken.map(|at| ridge(at) as u32));
        let Some((before, _)) = self.blocks.last().copied() else {
            for choice in &mut self.choices[start..] {
                (choice.total, choice.last) = (choice.worth, taken_now(choice));
            }
            return;
        };
        let (past, here) = self.choices.split_at_mut(start);
        let past = &past[before as usize..];
        let row = |at: u32| ridges[ridge(at)].y_px;
        for choice in here {
            let mut best = (f64::NEG_INFINITY, 0);
            for (i, from) in past.iter().enumerate() {
                let cost: f64 = std::iter::zip(from.taken, choice.taken)
                    .map(|pair| match pair {
                        (Some(a), Some(b)) if (row(a) - row(b)).abs() <= GOES_ON_PX => 0.0,
                        (Some(_), Some(_)) => JUMPS,
                        (None, None) => 0.0,
                        _ => BREAKS,
                    })
                    .sum();
                let exchanged = choice.taken.iter().enumerate().filter(|(laser, taken)| {
                    let before = taken.map(|at| chained[ridge(at)]);
                    let held = |other: usize| before.is_some() && from.last[other] == before;
                    (0..MOST_LASERS).any(|other| other != *laser && held(other))
                });
                let cost = cost + EXCHANGED * exchanged.count() as f64;
                if from.total - cost > best.0 {
                    best = (from.total - cost, i as u32);
                }
            }
            (choice.total, choice.before) = (best.0 + choice.worth, best.1);
            let now = taken_now(choice);
            choice.last =
                past.get(best.1 as usize).map_or(now, |from| std::array::from_fn(|laser| now[laser].or(from.last[laser])));
        }
    }

    /// The best choices, from the last block back.
    fn trace(&mut self) {
        self.chosen.clear();
        let Some((start, _)) = self.blocks.last() else { return };
        let last = &self.choices[*start as usize..];
        let best = (0..last.len()).max_by(|a, b| last[*a].total.total_cmp(&last[*b].total).then(b.cmp(a)));
        let mut at = best.unwrap_or(0) as u32;
        for (start, block) in self.blocks.iter().rev() {
            let choice = &self.choices[(start + at) as usize];
            self.chosen.push((*block, choice.taken));
            at = choice.before;
        }
        self.chosen.reverse();
    }

    /// Where a laser should light the floor and does not, though nothing stands before it.
    fn unlit_floor(&self, laser: usize, projector: &Projector, upright: &Upright, points: &mut Vec<RangePoint>) {
        let floor = -upright.up / upright.height_m;
        let middle_px = projector.size[1] as f64 / 2.0;
        let mut chosen = self.chosen.iter().peekable();
        for block in 0..projector.size[0] / BLOCK {
            while chosen.next_if(|(other, _)| usize::from(*other) < block).is_some() {}
            let taken = chosen.peek().filter(|(other, _)| usize::from(*other) == block).map(|(_, taken)| *taken);
            let x = (block * BLOCK) as f64 + (BLOCK as f64 - 1.0) / 2.0;
            let Some(stripe) = projector.stripe(laser, &floor, x, middle_px) else { continue };
            let in_view = (0.0..projector.size[1] as f64).contains(&stripe.y_px);
            let point = upright.base_from_camera * stripe.point;
            let camera = upright.base_from_camera.translation.vector;
            let (dx, dy) = (point.x - camera.x, point.y - camera.y);
            let range_m = (dx * dx + dy * dy).sqrt();
            let mut seen = taken.iter().flatten().flatten().map(|at| &self.candidates[*at as usize]);
            // Something nearer hides it; what is the floor itself is seen.
            let hidden =
                seen.any(|seen| seen.upon == Upon::Floor || seen.range_m < range_m + AGREE_M + AGREE_1_M * square(range_m));
            if in_view && range_m < FLOOR_WITHIN_M && taken.is_some() && !hidden {
                points.push(RangePoint { point_in_base: point, laser, block, upon: Upon::Nothing });
            }
        }
    }

    /// How far a laser that is not seen has met nothing, in the blocks in which another one is seen on the floor.
    fn open_air(&self, laser: usize, projector: &Projector, upright: &Upright, points: &mut Vec<RangePoint>) {
        for (block, taken) in &self.chosen {
            let on_floor = |at: &u32| self.candidates[*at as usize].upon == Upon::Floor;
            if taken[laser].is_some() || !taken.iter().flatten().any(on_floor) {
                continue;
            }
            let x = (usize::from(*block) * BLOCK) as f64 + (BLOCK as f64 - 1.0) / 2.0;
            // Where its plane is so far ahead: a plane square to the way ahead stands in for what is not there.
            let camera = upright.base_from_camera.translation.vector;
            let ahead = upright.base_from_camera.rotation.inverse() * nalgebra::Vector3::x() / AIR_M;
            let Some(stripe) = projector.stripe(laser, &ahead, x, projector.size[1] as f64 / 2.0) else { continue };
            let point = upright.base_from_camera * stripe.point;
            let in_view = (0.0..projector.size[1] as f64).contains(&stripe.y_px);
            if in_view && point.z > 0.0 && point.x > camera.x {
                points.push(RangePoint { point_in_base: point, laser, block: usize::from(*block), upon: Upon::Air });
            }
        }
    }

    /// Stripes that touch cross each other: where two lasers are taken to turn away from each other instead, the shorter side of the touch
    /// has them exchanged. (Rows and ranges alone fit both: for two slits the one is the mirror image of the other.)
    fn uncross(&mut self, ridges: &[Ridge]) {
        // Blocks in which both of the first two lasers are seen, with how far the one is below the other.
        let (mut both, mut exchange) = (std::mem::take(&mut self.both), std::mem::take(&mut self.exchange));
        both.clear();
        exchange.clear();
        let row = |at: u32| ridges[self.candidates[at as usize].ridge].y_px;
        both.extend(self.chosen.iter().enumerate().filter_map(|(i, (_, taken))| Some((i, row(taken[0]?) - row(taken[1]?)))));
        let block = |i: usize| usize::from(self.chosen[both[i].0].0);
        let goes_on = |i: usize| {
            block(i) - block(i - 1) <= TOUCH_BLOCKS
                && (both[i].1 - both[i - 1].1).abs() <= 3.0 * GOES_ON_PX * (block(i) - block(i - 1)) as f64
        };
        for touch in (1..both.len()).filter(|i| goes_on(*i)) {
            let (before, after) = (both[touch - 1].1, both[touch].1);
            let touches = before.abs() < TOUCH_PX && after.abs() < TOUCH_PX;
            let nearest = before.abs().max(after.abs());
            // The nearest that they come to each other: farther apart on both sides.
            let apart = |range: std::ops::Range<usize>| {
                range.clone().count() > FEWEST_BLOCKS && range.map(|i| both[i].1.abs()).fold(0.0, f64::max) > nearest + 1.0
            };
            let from = (1..touch).rev().find(|i| !goes_on(*i)).unwrap_or(0);
            let to = (touch + 1..both.len()).find(|i| !goes_on(*i)).unwrap_or(both.len());
            if !touches || before * after <= 0.0 || !apart(from..touch) || !apart(touch..to) {
                continue;
            }
            let least = |range: std::ops::Range<usize>| range.map(|i| both[i].1.abs()).fold(f64::INFINITY, f64::min);
            if least(from..to) < nearest - 1.0 {
                continue;
            }
            let shorter = if touch - from < to - touch { from..touch } else { touch..to };
            exchange.extend(shorter.map(|i| both[i].0));
        }
        for i in exchange.iter().copied() {
            let [Some(a), Some(b)] = [self.chosen[i].1[0], self.chosen[i].1[1]] else { continue };
            let ridges_of = [a, b].map(|at| self.candidates[at as usize].ridge);
            let other = |laser: usize, ridge: usize| {
                self.candidates.iter().position(|c| c.laser == laser && c.ridge == ridge).map(|at| at as u32)
            };
            if let (Some(first), Some(second)) = (other(0, ridges_of[1]), other(1, ridges_of[0])) {
                (self.chosen[i].1[0], self.chosen[i].1[1]) = (Some(first), Some(second));
            }
        }
        (self.both, self.exchange) = (both, exchange);
    }

    /// One laser's points, without pieces that are too short.
    fn stripes(&self, laser: usize, ridges: &[Ridge], points: &mut Vec<RangePoint>) {
        let mut from = points.len();
        let mut last: Option<(u16, f64)> = None;
        for (block, taken) in &self.chosen {
            let Some(at) = taken[laser] else { continue };
            let candidate = &self.candidates[at as usize];
            let y_px = ridges[candidate.ridge].y_px;
            let goes_on = last.is_some_and(|(before, row)| {
                let gap = block - before;
                gap <= 3 && (y_px - row).abs() <= GOES_ON_PX * f64::from(gap)
            });
            if !goes_on {
                if points.len() - from < FEWEST_BLOCKS {
                    points.truncate(from);
                }
                from = points.len();
            }
            last = Some((*block, y_px));
            points.push(RangePoint { point_in_base: candidate.point, laser, block: usize::from(*block), upon: candidate.upon });
        }
        if points.len() - from < FEWEST_BLOCKS {
            points.truncate(from);
        }
    }
}

/// A ridge taken for a laser, if it can be that laser's.
fn candidate(
    index: usize,
    ridge: &Ridge,
    laser: usize,
    projector: &Projector,
    upright: &Upright,
    range_m: [f64; 2],
) -> Option<Candidate> {
    let x = (usize::from(ridge.block) * BLOCK) as f64 + (BLOCK as f64 - 1.0) / 2.0;
    let expected = projector.upright_sigma(laser, x, ridge.y_px, range_m)?;
    let in_camera = projector.point(laser, x, ridge.y_px)?;
    let point = upright.base_from_camera * in_camera;
    let camera = upright.base_from_camera.translation.vector;
    let (dx, dy) = (point.x - camera.x, point.y - camera.y);
    let is_below = point.z < BELOW_M;
    if is_below && (point.z < -STEEPEST * dx || dy.abs() > BELOW_ASIDE * dx) {
        return None;
    }
    let upon = match point.z {
        _ if is_below => Upon::Below,
        z if z <= FLOOR_M => Upon::Floor,
        _ => Upon::Upright,
    };
    // A stripe on a surface that lies flat along the view is thicker than on an upright one, and one that is cut off may be thinner.
    let ratio = libm::log(ridge.sigma_px / expected);
    let off = (ratio.abs() - THICKNESS_OFF).max(0.0);
    let off = if ratio > 0.0 && (ridge.is_full || upon != Upon::Upright) { 0.0 } else { off };
    let on_floor = if upon == Upon::Upright { 0.0 } else { ON_FLOOR };
    let worth = EXPLAINED + on_floor - (THICKNESS * off * off).min(EXPLAINED);
    Some(Candidate { laser, ridge: index, point, range_m: (dx * dx + dy * dy).sqrt(), upon, worth })
}

fn square(x: f64) -> f64 {
    x * x
}
