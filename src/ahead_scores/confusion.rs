//! Counts of what was true against what was named. They add up over runs.

use ductloop_nav::ahead::{Fitting, Side};
use serde::Serialize;

use super::approach::{FittingScore, LOST_FRAMES};
use super::glance::Glance;

/// The word for nothing having been said, not even that it is unknown.
pub const NOTHING: &str = "nothing";

/// What can be ahead, and be named, in the order of tables.
pub const FITTINGS: [Fitting; 14] = [
    Fitting::Straight,
    Fitting::Elbow(Side::Left),
    Fitting::Elbow(Side::Right),
    Fitting::Branch(Side::Left),
    Fitting::Branch(Side::Right),
    Fitting::BullheadTee,
    Fitting::Cross,
    Fitting::Transition,
    Fitting::Offset(Side::Left),
    Fitting::Offset(Side::Right),
    Fitting::DeadEnd,
    Fitting::Obstacle,
    Fitting::Drop,
    Fitting::Unknown,
];

/// How often this was named that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Pair {
    /// What was true.
    #[serde(rename = "true")]
    pub truth: &'static str,
    /// What was named.
    pub named: &'static str,
    /// How often.
    pub count: u64,
}

/// Counts by pairs; those that did not occur are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Confusion {
    /// In the order of tables: by what was true, then by what was named.
    pub pairs: Vec<Pair>,
}

/// Place of a word in tables.
fn place(word: &str) -> usize {
    FITTINGS.iter().position(|fitting| fitting.word() == word).unwrap_or(FITTINGS.len())
}

impl Confusion {
    /// Of fittings: each by the name that it had last.
    pub(super) fn of_fittings(scores: &[FittingScore]) -> Self {
        let mut confusion = Self::default();
        scores.iter().for_each(|score| confusion.count(score.truth, score.named, 1));
        confusion
    }

    /// Of frames in which the robot is in no fitting: each by what is within reach. What is named rightly from farther away is that.
    pub(super) fn of_frames(glances: &[Glance]) -> Self {
        let mut confusion = Self::default();
        for glance in glances.iter().filter(|glance| !glance.truth.is_inside) {
            let named = glance.named.map_or(NOTHING, |named| named.fitting.word());
            confusion.count(glance.true_class().word(), named, 1);
        }
        confusion
    }

    /// So many more of a pair.
    pub fn count(&mut self, truth: &'static str, named: &'static str, count: u64) {
        let key = |pair: &Pair| (place(pair.truth), place(pair.named));
        let new = Pair { truth, named, count };
        match self.pairs.binary_search_by_key(&key(&new), key) {
            Ok(index) => self.pairs[index].count += count,
            Err(index) => self.pairs.insert(index, new),
        }
    }

    /// These and those.
    pub fn add(&mut self, other: &Self) {
        other.pairs.iter().for_each(|pair| self.count(pair.truth, pair.named, pair.count));
    }

    /// How often this was named that.
    pub fn of(&self, truth: &str, named: &str) -> u64 {
        self.pairs.iter().find(|pair| pair.truth == truth && pair.named == named).map_or(0, |pair| pair.count)
    }
}

/// How often something was named where nothing is within reach: runs of frames, interrupted by fewer than make a name lost.
pub(super) fn false_alarms(glances: &[Glance]) -> u32 {
    let (mut alarms, mut quiet) = (0, LOST_FRAMES);
    for glance in glances {
        let outside = !glance.truth.is_inside && glance.true_class() == Fitting::Straight;
        if outside && glance.thing_named().is_some() {
            alarms += u32::from(quiet >= LOST_FRAMES);
            quiet = 0;
        } else {
            quiet += 1;
        }
    }
    alarms
}
