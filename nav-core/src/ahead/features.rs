//! What the strip shows: openings in the side walls, and what stands across.

use super::change::WallChange;
use super::strip::{BIN_M, Flank, Inside, Strip, widened};

/// Fewest rays that say that a wall's bin is open, or closed.
const FEWEST_RAYS: f64 = 3.0;
/// A bin is open if rays that passed are this many times those that ended on the wall.
const OPEN_SHARE: f64 = 1.5;
/// Shortest opening that is one, in metres: less than the narrowest duct that this robot fits.
const OPENING_M: f64 = 0.12;
/// Closed wall of at least this length ends an opening, in metres.
const CLOSES_M: f64 = 0.06;
/// Bins without a verdict that an opening or a wall may go over, in metres.
const GAP_M: f64 = 0.2;
/// Rays that ended across the duct within three bins for something to stand there.
const ACROSS_RAYS: f64 = 24.0;
/// What stands across is believed if it was seen at one place while the robot moved by so much, in metres: a ceiling that a laser meets far
/// ahead goes along with the robot, and a wall does not.
const PARALLAX_M: f64 = 0.12;
/// What goes along with the robot by so much of its way is no wall, looked at over so much to both sides, in metres.
const MOVES_SHARE: f64 = 0.2;
const MOVES_WITHIN_M: f64 = 0.12;
/// What is seen behind a wall's line stands across if it spreads so much across for what it spreads along, which far ranges blur.
const ACROSS_SHARE: f64 = 0.6;
/// What is less far behind a wall's line, in metres, may be a stray range.
const LEAST_DEEP_M: f64 = 0.08;
/// What is seen so far behind a wall's line, as a share of half the duct's width, is seen through an opening.
const DEEP_SHARE: f64 = 0.8;
/// The floor ends where it is missed for so long, in metres, so many times as often as it is lit and lit no more often than this in
/// all, after it was lit over so much, from so far behind the robot on, in metres. (Behind a crest of 5 degrees a bin is lit up to 24
/// times while it is missed 57 times, and a few bins hardly ever; a hole's are never lit.)
const MISSED_M: f64 = 0.12;
const MISSED_SHARE: f64 = 30.0;
const LEAST_LIT: f64 = 2.0;
const LIT_M: f64 = 0.1;
const LIT_WITHIN_M: f64 = 0.5;
/// Right before a wall the stripe on the floor is lost in what the wall throws back: there nothing is made of it, in metres.
const BEFORE_WALL_M: f64 = 0.4;
/// A wall that leaves its line is told from stray ranges only within this, in metres.
const CHANGE_WITHIN_M: f64 = 1.0;
/// An opening and a wall that leaves its line begin at one place within this, in metres.
const SAME_M: f64 = 0.15;
/// Free rays over those that ended, beyond which nothing stands there.
const FREE_SHARE: f64 = 4.0;

/// An opening in a side wall, from where the wall ends to where it goes on, in metres along the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Opening {
    /// Where the wall ends.
    pub(super) from_m: f64,
    /// Where it is closed again; `None` where that has not been seen.
    pub(super) to_m: Option<f64>,
    /// How far it is known to be open, in metres.
    pub(super) open_to_m: f64,
}

/// What is seen of the duct ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Features {
    /// The next opening to the left and to the right.
    pub(super) openings: [Option<Opening>; 2],
    /// Where there may be an opening to the left and to the right that is not seen well enough to be one, in metres along the duct.
    pub(super) doubtful_m: [Option<f64>; 2],
    /// Where something stands across the middle, in metres along the duct.
    pub(super) across_m: Option<f64>,
    /// How far that reaches to the right and to the left of the middle, in metres.
    pub(super) across_reach_m: [f64; 2],
    /// How far the middle is known to be free, in metres along the duct.
    pub(super) free_to_m: f64,
    /// Where the left and the right wall leave their lines without ending.
    pub(super) changes: [Option<WallChange>; 2],
    /// Where the floor ends, in metres along the duct.
    pub(super) drop_m: Option<f64>,
}

impl Features {
    /// Where walls do not go on along their lines, in metres along the duct: where a fitting may begin.
    pub(super) fn events_m(&self) -> impl Iterator<Item = f64> {
        let openings = self.openings.iter().flatten().map(|opening| opening.from_m);
        let changes = self.changes.iter().flatten().map(|change| change.from_m);
        openings.chain(self.doubtful_m.iter().flatten().copied()).chain(changes)
    }
}

/// A bin of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Open,
    Closed,
    Unknown,
}

impl Flank {
    pub(super) fn verdict(&self) -> Verdict {
        if self.open >= FEWEST_RAYS && self.open > OPEN_SHARE * self.closed {
            Verdict::Open
        } else if self.closed >= FEWEST_RAYS && self.closed >= self.open {
            Verdict::Closed
        } else {
            Verdict::Unknown
        }
    }
}

impl Strip {
    /// What is ahead of a robot at `along_m`.
    /// `run` is room to work in.
    pub(super) fn features(&self, along_m: f64, half_m: f64, run: &mut Vec<(i64, f64)>) -> Features {
        let (across_m, across_reach_m) = self.across(along_m).map_or((None, [0.0; 2]), |(at, reach)| (Some(at), reach));
        let [left, right] = [0, 1].map(|side| self.wall(side, along_m, across_m));
        let until = across_m.map_or(i64::MAX, Self::number);
        // Where something stands across, what leaves a wall's line before it is a bend's.
        let goes_on = |change: &WallChange| {
            change.from_m < along_m + CHANGE_WITHIN_M && across_m.is_none_or(|at_m| at_m > change.to_m + 2.0 * half_m)
        };
        let changes = [0, 1].map(|side| self.change(side, along_m, half_m, until, run).filter(goes_on));
        // Rays that reach a wall which has left its line outwards have passed through no opening.
        let opening = |opening: Option<Opening>, side: usize| {
            let is_wall = |o: &Opening| changes[side].is_some_and(|change| change.from_m <= o.from_m + SAME_M);
            opening.filter(|o| !is_wall(o) && self.is_deep(side, o, half_m, across_m.is_some()))
        };
        let openings = [opening(left, 0), opening(right, 1)];
        Features {
            openings,
            doubtful_m: [0, 1].map(|side| {
                let raw = [left, right][side];
                raw.filter(|_| openings[side].is_none() && changes[side].is_none()).map(|opening| opening.from_m)
            }),
            changes,
            drop_m: self.drop(along_m).filter(|at_m| across_m.is_none_or(|across_m| across_m > at_m + BEFORE_WALL_M)),
            across_m,
            across_reach_m,
            free_to_m: self.free_to(along_m),
        }
    }

    /// Whether what is behind an opening stands across its own way, or is far behind it. A wall that has left its line is neither.
    /// Where something stands across the duct, what is seen through the opening is that, too: there it must only be behind the wall's line
    /// by more than a stray range.
    fn is_deep(&self, side: usize, opening: &Opening, half_m: f64, ends: bool) -> bool {
        let bins = Self::number(opening.from_m)..Self::number(opening.open_to_m);
        let behind = bins.filter_map(|number| self.bin(number)?.flanks[side].ends_m);
        let Some([along_m, offset_m]) = behind.fold(None, |all, ends| Some(widened(all, ends))) else { return false };
        let deep_m = offset_m[1] - half_m;
        deep_m > LEAST_DEEP_M
            && (ends || offset_m[1] - offset_m[0] > ACROSS_SHARE * (along_m[1] - along_m[0]) || deep_m > DEEP_SHARE * half_m)
    }

    /// The next opening of a side's wall.
    fn wall(&self, side: usize, along_m: f64, across_m: Option<f64>) -> Option<Opening> {
        let bins = self.ahead_of(along_m);
        let end = across_m.map_or(bins.end, |at| bins.end.min(Self::number(at)));
        let place = |number: i64| number as f64 * BIN_M;
        let verdict = |number: i64| self.bin(number).map_or(Verdict::Unknown, |bin| bin.flanks[side].verdict());
        let gap = (GAP_M / BIN_M) as i64;
        let mut run: Option<(i64, i64)> = None;
        let mut closes = 0;
        for number in bins.start..end {
            match (verdict(number), &mut run) {
                (Verdict::Open, Some((_, last))) => {
                    *last = number + 1;
                    closes = 0;
                }
                (Verdict::Open, None) => run = Some((number, number + 1)),
                (Verdict::Closed, Some((first, last))) => {
                    closes += 1;
                    let is_opening = (*last - *first) as f64 * BIN_M >= OPENING_M;
                    if closes as f64 * BIN_M >= CLOSES_M {
                        if is_opening {
                            let closed = number + 1 - closes;
                            let opening = Opening { from_m: place(*first), to_m: Some(place(closed)), open_to_m: place(*last) };
                            return Some(opening);
                        }
                        run = None;
                        closes = 0;
                    }
                }
                (Verdict::Unknown, Some((first, last))) => {
                    let is_opening = (*last - *first) as f64 * BIN_M >= OPENING_M;
                    if number - *last > gap && !is_opening {
                        run = None;
                    }
                }
                (Verdict::Closed | Verdict::Unknown, None) => {}
            }
        }
        run.filter(|(first, last)| (*last - *first) as f64 * BIN_M >= OPENING_M).map(|(first, last)| Opening {
            from_m: place(first),
            to_m: None,
            open_to_m: place(last),
        })
    }

    /// Where something stands across the middle, and how far it reaches to the right and to the left.
    pub(super) fn across(&self, along_m: f64) -> Option<(f64, [f64; 2])> {
        let bins = self.ahead_of(along_m);
        for number in bins.start + 3..bins.end - 1 {
            let three = [-1, 0, 1].map(|by| self.bin(number + by).map(|bin| bin.inside).unwrap_or_default());
            let hits: f64 = three.iter().map(|inside| inside.hits).sum();
            let free = three[2].free;
            let is_peak = three[1].hits >= three[0].hits && three[1].hits >= three[2].hits;
            let hit = || three.iter().filter(|inside| inside.hits > 0.0);
            let from_m = hit().map(|inside| inside.seen_from_m[0]).fold(f64::INFINITY, f64::min);
            let to_m = hit().map(|inside| inside.seen_from_m[1]).fold(f64::NEG_INFINITY, f64::max);
            let stands = || {
                let by = (MOVES_WITHIN_M / BIN_M) as i64;
                let about = (number - by..=number + by).filter_map(|number| self.bin(number));
                Inside::moving(about.map(|bin| bin.inside)).is_some_and(|moving| moving < MOVES_SHARE)
            };
            if is_peak && hits >= ACROSS_RAYS && free <= FREE_SHARE * hits && to_m - from_m >= PARALLAX_M && stands() {
                let mean: f64 = [-1.0, 0.0, 1.0].iter().zip(&three).map(|(by, inside)| by * inside.hits).sum::<f64>() / hits;
                let reach = |side: usize, pick: fn(f64, f64) -> f64| hit().map(|inside| inside.reach_m[side]).fold(0.0, pick);
                return Some(((number as f64 + 0.5 + mean) * BIN_M, [reach(0, f64::min), reach(1, f64::max)]));
            }
        }
        None
    }

    /// Where the floor ends: lit before, and then missed for a while. A floor that is never seen lit says nothing.
    fn drop(&self, along_m: f64) -> Option<f64> {
        let (mut lit_m, mut missed_m, mut stray) = (0.0, 0.0, 0.0);
        let before = (LIT_WITHIN_M / BIN_M) as i64;
        for number in self.ahead_of(along_m).start - before..self.ahead_of(along_m).end {
            let Some([lit, missed]) = self.bin(number).map(|bin| bin.floor) else { continue };
            // A floor that falls away is lit as well, farther on than one that does not: what is seen here is here.
            if lit >= LEAST_LIT && MISSED_SHARE * lit >= missed {
                lit_m += BIN_M;
                (missed_m, stray) = (0.0, 0.0);
            } else if missed >= FEWEST_RAYS {
                missed_m += BIN_M;
                stray += lit;
            }
            if missed_m >= MISSED_M && lit_m >= LIT_M && stray <= LEAST_LIT {
                return Some((number + 1) as f64 * BIN_M - missed_m);
            }
        }
        None
    }

    /// How far the middle is free: up to the first bin through which no ray went.
    fn free_to(&self, along_m: f64) -> f64 {
        let bins = self.ahead_of(along_m);
        let free = |number: &i64| self.bin(*number).is_some_and(|bin| bin.inside.free >= FEWEST_RAYS);
        // Right before the camera no ray has passed yet.
        let from = bins.clone().find(|number| free(number)).unwrap_or(bins.start);
        let end = (from..bins.end).find(|number| !free(number)).unwrap_or(bins.end);
        end as f64 * BIN_M
    }
}
