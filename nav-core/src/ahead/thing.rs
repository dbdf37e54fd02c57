//! What stands in the duct beside a way past it: how far it reaches across and along.

use super::features::Verdict;
use super::strip::{BIN_M, CELLS, DuctPlace, Strip};
use super::{Ahead, Fitting, Side};

/// A thing in the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thing {
    /// Where it begins and ends, in metres along the duct.
    pub at_m: f64,
    /// See `at_m`.
    pub to_m: f64,
    /// How far it reaches to the right and to the left of the middle (left positive), in metres; to the wall where less than 0.2 m is
    /// between or the wall is not seen to go on beside it.
    pub reach_m: [f64; 2],
}

/// It is taken to be at least this long, in metres; and what is seen no farther behind what is seen of it is its own.
const LEAST_LONG_M: f64 = 0.1;
const GAP_M: f64 = 0.1;
/// So far before it and behind where it begins nothing may stand in the way past it, in metres.
const BEFORE_M: f64 = 0.1;
const BEHIND_M: f64 = 0.5;
/// Rays that ended in a piece of the duct's width for something to stand there: so many, and this share of those in the fullest piece, for
/// stray ones grow in number as the others do.
const FEWEST_RAYS: f64 = 8.0;
const SHARE: f64 = 0.04;
/// Rays that ended in a bin, off the walls, for something to be there.
const FEWEST_OF_A_BIN: f64 = 3.0;
/// No robot passes through less than this, in metres.
const BESIDE_M: f64 = 0.2;
/// Share of the bins beside it in which the wall must be seen to be closed for the way past it to be a duct's.
const GOES_ON_SHARE: f64 = 0.6;

impl Ahead {
    /// The thing that is held to stand in the duct.
    ///
    /// No plan need explain the rays: what stands there has other shapes than the one that is drawn. What counts is what is free, by pieces
    /// of the width. What else stands there is taken with it.
    pub fn thing(&self, place: &DuctPlace) -> Option<Thing> {
        let at_m = self.outlook.blocked_m.filter(|_| self.outlook.fitting == Fitting::Obstacle)?;
        let half_m = place.width_m / 2.0;
        let hits = self.strip.across_cells([at_m - BEFORE_M, at_m + BEHIND_M]);
        let fewest = FEWEST_RAYS.max(SHARE * hits.iter().copied().fold(0.0, f64::max));
        let first = hits.iter().position(|hits| *hits >= fewest)?;
        let last = hits.iter().rposition(|hits| *hits >= fewest)?;
        let edge_m = |cell: usize| cell as f64 * place.width_m / CELLS as f64 - half_m;
        let mut reach_m = [edge_m(first), edge_m(last + 1)];
        if reach_m[0] + half_m < BESIDE_M || !self.strip.goes_on(Side::Right, at_m) {
            reach_m[0] = -half_m;
        }
        if half_m - reach_m[1] < BESIDE_M || !self.strip.goes_on(Side::Left, at_m) {
            reach_m[1] = half_m;
        }
        Some(Thing { at_m, to_m: self.thing_to_m(at_m), reach_m })
    }

    /// Where something stands across the middle farther than this, in metres along the duct.
    pub fn stands_beyond(&self, from_m: f64) -> Option<f64> {
        self.strip.across(from_m).map(|(at_m, _)| at_m)
    }

    /// Where a thing ends that begins here, as far as it is seen by now, in metres along the duct.
    pub fn thing_to_m(&self, at_m: f64) -> f64 {
        let (first, gap) = (Strip::number(at_m), (GAP_M / BIN_M) as i64);
        let mut last = first;
        while let Some(next) = (last + 1..=last + gap)
            .rev()
            .find(|number| self.strip.bin(*number).is_some_and(|bin| bin.inside.any >= FEWEST_OF_A_BIN))
        {
            last = next;
        }
        ((last + 1) as f64 * BIN_M).max(at_m + LEAST_LONG_M)
    }
}

impl Strip {
    /// Whether the wall on a side is seen to go on beside a thing that begins here, and behind that.
    fn goes_on(&self, side: Side, at_m: f64) -> bool {
        let numbers = Self::number(at_m)..Self::number(at_m + BEHIND_M);
        let verdict = |number| self.bin(number).map_or(Verdict::Unknown, |bin| bin.flanks[side.index()].verdict());
        let count = |wanted: Verdict| numbers.clone().filter(|number| verdict(*number) == wanted).count();
        count(Verdict::Open) == 0 && count(Verdict::Closed) as f64 >= GOES_ON_SHARE * numbers.clone().count() as f64
    }
}
