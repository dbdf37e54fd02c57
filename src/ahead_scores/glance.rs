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
        let named = frame.outlook.as_ref().map(Named::of);
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
    /// What an outlook says: the width is that behind a transition.
    fn of(outlook: &Outlook) -> Self {
        let width_m = outlook.width_m.filter(|_| outlook.fitting == Fitting::Transition);
        Self { fitting: outlook.fitting, distance_m: outlook.distance_m, width_m }
    }

    /// Whether this is a name of that.
    fn is(&self, truth: &TrueAhead) -> bool {
        self.fitting == truth.fitting && (self.distance_m - truth.distance_m).abs() <= SAME_THING_M
    }
}
