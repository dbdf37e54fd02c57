//! A frame as the scores take it: what was ahead, and what was named.

use ductloop_nav::ahead::{Fitting, Outlook};

use super::way::TrueAhead;
use crate::record::FrameRecord;

/// What was named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named {
    /// The fitting.
    pub fitting: Fitting,
    /// How far ahead of the base it was said to begin, in metres.
    pub distance_m: f64,
    /// Of a transition: the width behind it, in metres.
    pub width_m: Option<f64>,
}

/// A frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glance {
    /// Simulated time, in seconds.
    pub time_s: f64,
    /// The truth.
    pub truth: TrueAhead,
    /// What was named; `None` where nothing was said, not even that it is unknown.
    pub named: Option<Named>,
    /// How many ducts the robot had been in, by its own count.
    pub ducts: usize,
}

impl Glance {
    /// Of a frame; `None` where the robot is off the path.
    pub fn of(frame: &FrameRecord) -> Option<Self> {
        let width_m = frame.estimate.map(|estimate| estimate.width_m).or(frame.measurement.width_m);
        let named = frame.outlook.as_ref().map(|outlook| Named::of(outlook, width_m));
        Some(Self { time_s: frame.time_s, truth: frame.true_ahead?, named, ducts: frame.ducts })
    }

    /// What was named, if it was something: not straight, and not unknown.
    pub fn thing_named(&self) -> Option<Named> {
        self.named.filter(|named| !matches!(named.fitting, Fitting::Straight | Fitting::Unknown))
    }

    /// What a frame should show: the next thing if it is within reach. What is named rightly from farther away is that, too.
    pub fn true_class(&self) -> Fitting {
        if self.truth.is_in_reach || self.is_right() { self.truth.fitting } else { Fitting::Straight }
    }

    /// Whether the next thing was named, and where it is.
    pub fn is_right(&self) -> bool {
        self.thing_named().is_some_and(|named| named.is(&self.truth))
    }
}

/// A name that is given to a place so far from where the thing is, in metres, is another thing's.
const SAME_THING_M: f64 = 0.5;

impl Named {
    /// What an outlook says, in a duct that the robot takes to be this wide. A wall that is not seen to leave its line keeps it.
    fn of(outlook: &Outlook, width_m: Option<f64>) -> Self {
        let sides = outlook.features.changes.map(|change| change.map(|change| change.offset_m));
        let is_seen = outlook.fitting == Fitting::Transition && sides.iter().any(Option::is_some);
        let [left_m, right_m] = sides.map(|side| side.or(width_m.map(|width_m| width_m / 2.0)));
        let width_m = left_m.zip(right_m).filter(|_| is_seen).map(|(left_m, right_m)| left_m + right_m);
        Self { fitting: outlook.fitting, distance_m: outlook.distance_m, width_m }
    }

    /// Whether this is a name of that.
    fn is(&self, truth: &TrueAhead) -> bool {
        self.fitting == truth.fitting && (self.distance_m - truth.distance_m).abs() <= SAME_THING_M
    }
}
