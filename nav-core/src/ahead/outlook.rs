//! Which fitting lies ahead, and how sure that is.

use super::features::{Features, Opening};
use super::strip::DuctPlace;

/// A side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// What the duct becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fitting {
    /// Not known.
    #[default]
    Unknown,
    /// It goes straight on as far as is seen.
    Straight,
    /// It turns to this side and goes nowhere else.
    Elbow(Side),
    /// It goes on, and a branch leaves to this side.
    Branch(Side),
    /// It ends across another duct: left and right.
    BullheadTee,
    /// It goes on, and branches leave to both sides.
    Cross,
    /// It becomes wider or narrower.
    Transition,
    /// Its floor ends.
    Drop,
    /// Something stands in it that does not reach from wall to wall.
    Obstacle,
    /// It ends.
    DeadEnd,
}

impl Fitting {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Straight => "straight",
            Self::Elbow(Side::Left) => "elbow-left",
            Self::Elbow(Side::Right) => "elbow-right",
            Self::Branch(Side::Left) => "branch-left",
            Self::Branch(Side::Right) => "branch-right",
            Self::BullheadTee => "bullhead-tee",
            Self::Cross => "cross",
            Self::Transition => "transition",
            Self::Drop => "drop",
            Self::Obstacle => "obstacle",
            Self::DeadEnd => "dead-end",
        }
    }
}

impl Side {
    /// 0 left, 1 right.
    pub fn index(self) -> usize {
        self as usize
    }

    /// 1 left, -1 right: the sign of a turn to this side.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// What is ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outlook {
    /// Which fitting, after hysteresis.
    pub fitting: Fitting,
    /// Where it begins, in metres along the duct: where its first wall ends, or where the duct does.
    pub at_m: f64,
    /// How far that is from the base, along the duct, in metres.
    pub distance_m: f64,
    /// Share of the last frames that showed this fitting.
    pub confidence: f64,
    /// What it rests on.
    pub features: Features,
}

/// Frames over which a fitting must hold.
const FRAMES: u32 = 8;
/// Share of them that must show it.
const HOLDS: f64 = 0.7;
/// Both openings belong to one fitting if the second begins within this many widths of the first.
const TOGETHER_WIDTHS: f64 = 1.2;
/// The wall opposite an opening must be seen closed so far beyond where that begins, in widths, for there to be no opening in it.
const OPPOSITE_WIDTHS: f64 = 0.4;
/// What stands across no farther than this beyond an opening is the opening's own far side, in widths.
const ENDS_WIDTHS: f64 = 0.5;
/// Beyond an opening the middle must be seen free by this many widths for the duct to go on.
const GOES_ON_WIDTHS: f64 = 0.4;
/// A wall that ends a duct is seen to reach so far to both sides, as a share of half the width.
const SPANS_SHARE: f64 = 0.75;
/// A wall that is not seen to be closed up to this short of the end leaves a dead end in doubt, in widths.
const UNSEEN_WIDTHS: f64 = 0.3;
/// A duct is straight if it is seen to be for this many widths.
const STRAIGHT_WIDTHS: f64 = 1.5;

/// Watches what frames show.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Watch {
    /// What the last frames showed: the same fitting so often ...
    last: Fitting,
    /// ... as an exponential mean over [`FRAMES`].
    share: f64,
    held: Fitting,
}

impl Watch {
    pub(super) fn look(&mut self, features: Features, place: &DuctPlace) -> Outlook {
        let (fitting, at_m) = classify(&features, place);
        let weight = 1.0 / f64::from(FRAMES);
        if fitting == self.last {
            self.share += weight * (1.0 - self.share);
        } else {
            (self.last, self.share) = (fitting, weight);
        }
        if self.share >= HOLDS {
            self.held = self.last;
        } else if self.held != self.last && self.share >= 0.3 {
            self.held = Fitting::Unknown;
        }
        let confidence = if self.held == self.last { self.share } else { 0.0 };
        Outlook { fitting: self.held, at_m, distance_m: at_m - place.along_m, confidence, features }
    }
}

/// The table of which walls end and what stands across.
fn classify(features: &Features, place: &DuctPlace) -> (Fitting, f64) {
    let width_m = place.width_m;
    if let Some(at_m) = features.drop_m {
        return (Fitting::Drop, at_m);
    }
    let begins = |opening: &Opening| opening.from_m;
    let [left, right] = features.openings;
    let nearer = left.iter().chain(&right).map(begins).fold(f64::INFINITY, f64::min);
    // An opening much farther on than the first belongs to the next fitting.
    let here = |opening: Option<Opening>| opening.filter(|o| o.from_m <= nearer + TOGETHER_WIDTHS * width_m);
    let (left, right) = (here(left), here(right));
    let last_m = left.iter().chain(&right).map(|o| o.to_m.unwrap_or(o.from_m + width_m)).fold(f64::NEG_INFINITY, f64::max);
    // What stands across ends this fitting if it is not beyond the openings' own far sides.
    let across = features.across_m.filter(|at| !nearer.is_finite() || *at <= last_m + ENDS_WIDTHS * width_m);
    let last_m = features.changes.iter().flatten().map(|change| change.to_m).fold(last_m, f64::max);
    let goes_on = features.free_to_m >= last_m + GOES_ON_WIDTHS * width_m;
    // The wall opposite a branch is seen to go on.
    // What may be an opening is one of this fitting's if it is as near as that could be.
    let sure = |side: Side| features.doubtful_m[side.index()].is_none_or(|from_m| from_m > nearer + OPPOSITE_WIDTHS * width_m);
    let closed = |side: Side| sure(side) && features.closed_to_m[side.index()] >= nearer + OPPOSITE_WIDTHS * width_m;
    match (left, right, across) {
        (Some(_), Some(_), Some(_)) => (Fitting::BullheadTee, nearer),
        (Some(_), Some(_), None) if goes_on => (Fitting::Cross, nearer),
        (Some(_), None, Some(_)) if sure(Side::Right) => (Fitting::Elbow(Side::Left), nearer),
        (None, Some(_), Some(_)) if sure(Side::Left) => (Fitting::Elbow(Side::Right), nearer),
        (Some(_), None, None) if goes_on && closed(Side::Right) => (Fitting::Branch(Side::Left), nearer),
        (None, Some(_), None) if goes_on && closed(Side::Left) => (Fitting::Branch(Side::Right), nearer),
        (None, None, Some(at)) if features.closed_to_m.iter().all(|to| *to >= at - UNSEEN_WIDTHS * width_m) => {
            let spans = features.across_reach_m.iter().all(|reach| reach.abs() >= SPANS_SHARE * width_m / 2.0);
            (if spans { Fitting::DeadEnd } else { Fitting::Obstacle }, at)
        }
        (None, None, None) if features.changes.iter().any(Option::is_some) && goes_on => {
            (Fitting::Transition, features.changes.iter().flatten().map(|change| change.from_m).fold(f64::INFINITY, f64::min))
        }
        (None, None, None) if features.free_to_m >= place.along_m + STRAIGHT_WIDTHS * width_m => {
            (Fitting::Straight, features.free_to_m)
        }
        _ => (Fitting::Unknown, if nearer.is_finite() { nearer } else { features.free_to_m }),
    }
}
