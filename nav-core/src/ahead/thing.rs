//! What stands in the duct beside a way past it: how far it reaches across and along.

use super::Ahead;
use super::model::Family;
use super::strip::{BIN_M, CELLS, DuctPlace, Strip};

/// A thing in the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thing {
    /// Where it begins and ends, in metres along the duct.
    pub at_m: f64,
    /// See `at_m`.
    pub to_m: f64,
    /// How far it reaches to the right and to the left of the middle (left positive), in metres; to the wall where less than [`BESIDE_M`] is
    /// between.
    pub reach_m: [f64; 2],
}

/// It is taken to be at least this long, in metres; and what is seen no farther behind what is seen of it is its own.
const LEAST_LONG_M: f64 = 0.1;
const GAP_M: f64 = 0.1;
/// So far before it and behind where it begins nothing may stand in the way past it, in metres.
const BEFORE_M: f64 = 0.1;
const BEHIND_M: f64 = 0.5;
/// Rays that ended in a piece of the duct's width for something to stand there.
const FEWEST_RAYS: f64 = 10.0;
/// Rays that ended in a bin, off the walls, for something to be there.
const FEWEST_OF_A_BIN: f64 = 3.0;
/// No robot passes through less than this, in metres.
const BESIDE_M: f64 = 0.2;

impl Ahead {
    /// The thing that is held to stand in the duct, if everything about it is clear on one side.
    pub fn thing(&self, place: &DuctPlace) -> Option<Thing> {
        let model = self.watch.model().filter(|model| model.family == Family::Obstacle)?;
        let [at_m, middle_m, width_m, _] = model.dimensions;
        let half_m = place.width_m / 2.0;
        let mut reach_m = [middle_m - width_m / 2.0, middle_m + width_m / 2.0];
        // Whatever else stands there is taken with it, by pieces of the width: what reaches into a piece by little is the thing itself.
        let hits = self.strip.across_cells([at_m - BEFORE_M, at_m + BEHIND_M]);
        let cell_m = place.width_m / CELLS as f64;
        for (cell, _) in hits.iter().enumerate().filter(|(_, hits)| **hits >= FEWEST_RAYS) {
            let [from_m, to_m] = [0, 1].map(|end| (cell + end) as f64 * cell_m - half_m);
            if to_m < reach_m[0] {
                reach_m[0] = from_m;
            } else if from_m > reach_m[1] {
                reach_m[1] = to_m;
            }
        }
        if reach_m[0] + half_m < BESIDE_M {
            reach_m[0] = -half_m;
        }
        if half_m - reach_m[1] < BESIDE_M {
            reach_m[1] = half_m;
        }
        Some(Thing { at_m, to_m: self.thing_to_m(at_m), reach_m })
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
