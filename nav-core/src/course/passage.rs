//! From one duct to the next: through a bend or a transition.

use super::bend::{Bend, OnPath};
use super::taper::Taper;
use crate::ahead::Stretch;

/// A way from the duct that the robot is in to the next one. Each duct has its own coordinates: along it, to the left of its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passage {
    /// The way turns.
    Bend(Bend),
    /// The width changes.
    Taper(Taper),
}

impl Passage {
    /// Where it begins, in metres along the entry duct.
    pub fn start_m(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.start_m,
            Self::Taper(taper) => taper.start_m,
        }
    }

    /// Length of the path through it, in metres.
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.length_m(),
            Self::Taper(taper) => taper.length_m,
        }
    }

    /// Where the robot changes over to the exit duct, as a way from its beginning, in metres.
    pub fn settled_m(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.settled_m(),
            Self::Taper(taper) => taper.length_m / 2.0,
        }
    }

    /// By how much the way turns, positive to the left, in radians.
    pub fn turn_rad(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.turn_rad,
            Self::Taper(_) => 0.0,
        }
    }

    /// Radius of its arc, in metres; infinite where it does not turn.
    pub fn radius_m(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.radius_m,
            Self::Taper(_) => f64::INFINITY,
        }
    }

    /// Width of the exit duct, in metres.
    pub fn exit_width_m(&self) -> f64 {
        match self {
            Self::Bend(bend) => bend.exit_width_m,
            Self::Taper(taper) => taper.exit_width_m,
        }
    }

    /// A pose in the entry duct (along, left, heading), in the exit duct's coordinates.
    pub fn exit_from_entry(&self, pose: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Bend(bend) => bend.exit_from_entry(pose),
            Self::Taper(taper) => taper.exit_from_entry(pose),
        }
    }

    /// A pose in the exit duct, in the entry duct's coordinates.
    pub fn entry_from_exit(&self, pose: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Bend(bend) => bend.entry_from_exit(pose),
            Self::Taper(taper) => taper.entry_from_exit(pose),
        }
    }

    /// A pose in the entry duct, against the path.
    pub fn project(&self, pose: [f64; 3]) -> OnPath {
        match self {
            Self::Bend(bend) => bend.project(pose),
            Self::Taper(taper) => taper.project(pose),
        }
    }

    /// Where the walls of the entry duct are straight.
    pub fn straight_before(&self) -> Stretch {
        match self {
            Self::Bend(bend) => bend.straight_before(),
            Self::Taper(taper) => taper.straight_before(),
        }
    }

    /// Where the walls of the exit duct are straight.
    pub fn straight_behind(&self) -> Stretch {
        match self {
            Self::Bend(bend) => bend.straight_behind(),
            Self::Taper(taper) => taper.straight_behind(),
        }
    }
}
