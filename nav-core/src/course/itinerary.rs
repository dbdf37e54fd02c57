//! Which way to take next: as a route names it, or so that every branch is seen.

use super::route::Turn;
use super::topology::Topology;
use crate::ahead::{Fitting, Side};

/// Where to go.
#[derive(Clone, Debug, PartialEq)]
pub enum Mission {
    /// These turns in order; behind the last one straight on to the end.
    Route(Vec<Turn>),
    /// Into every branch once.
    Explore,
}

/// How far it is.
#[derive(Clone, Debug)]
pub(super) struct Itinerary {
    mission: Mission,
    next: usize,
    topology: Topology,
}

impl Itinerary {
    pub(super) fn new(mission: Mission) -> Self {
        Self { mission, next: 0, topology: Topology::default() }
    }

    /// Whether this fitting is one at which there is a choice.
    pub(super) fn has_say(fitting: Fitting) -> bool {
        fitting == Fitting::DeadEnd || is_junction(fitting)
    }

    /// The turn at this fitting, which is in this place (along, left, heading in the frame of the first duct); `None` where nothing is said
    /// of it.
    pub(super) fn turn(&self, fitting: Fitting, here: [f64; 3]) -> Option<Turn> {
        match &self.mission {
            Mission::Route(turns) => turns.get(self.next).copied(),
            Mission::Explore if ends(fitting) => Some(self.topology.turn_at_end()),
            Mission::Explore if is_junction(fitting) || self.topology.returns() => self.topology.turn_at(here, exits(fitting)),
            Mission::Explore => None,
        }
    }

    /// It was taken.
    pub(super) fn took(&mut self, fitting: Fitting, here: [f64; 3]) {
        self.next += 1;
        if self.mission == Mission::Explore {
            match ends(fitting) {
                true => self.topology.turned_back(),
                false => self.topology.took(here, exits(fitting)),
            }
        }
    }
}

/// Whether the way is over there: a wall, a hole, something that is not passed.
fn ends(fitting: Fitting) -> bool {
    matches!(fitting, Fitting::DeadEnd | Fitting::Drop | Fitting::Obstacle)
}

/// Whether there is more than one way on.
pub(super) fn is_junction(fitting: Fitting) -> bool {
    !exits(fitting).is_empty()
}

/// The exits that a junction shows: straight on, and quarter turns to the left of that.
fn exits(fitting: Fitting) -> &'static [i32] {
    match fitting {
        Fitting::Branch(Side::Left) => &[1, 0],
        Fitting::Branch(Side::Right) => &[0, -1],
        Fitting::BullheadTee => &[1, -1],
        Fitting::Cross => &[1, 0, -1],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stem with a branch to the left, which itself ends across another duct; behind the branch a dead end.
    #[test]
    fn every_branch_is_seen_once() {
        let mut itinerary = Itinerary::new(Mission::Explore);
        let tee = Fitting::Branch(Side::Left);
        const FIRST: [f64; 3] = [2.0, 0.0, 0.0];
        const SECOND: [f64; 3] = [2.0, 3.0, std::f64::consts::FRAC_PI_2];
        const END: [f64; 3] = [9.0, 9.0, 0.0];
        for (fitting, here, turn) in [
            (tee, FIRST, Turn::Left),
            // The branch's own junction.
            (Fitting::BullheadTee, SECOND, Turn::Left),
            (Fitting::DeadEnd, END, Turn::TurnBack),
            // From its left arm: straight on into the right one, past the stem on the right. There the floor ends.
            (Fitting::Branch(Side::Right), SECOND, Turn::Straight),
            (Fitting::Drop, END, Turn::TurnBack),
            // From its right arm: the stem is on the left.
            (Fitting::Branch(Side::Left), SECOND, Turn::Left),
            // Back at the first tee, from its branch: its straight exit is on the left.
            (Fitting::BullheadTee, FIRST, Turn::Left),
            (Fitting::DeadEnd, END, Turn::Stop),
        ] {
            assert_eq!(itinerary.turn(fitting, here), Some(turn), "{fitting:?}: {itinerary:?}");
            itinerary.took(fitting, here);
        }
    }

    #[test]
    fn a_route_is_taken_in_order_and_then_says_nothing() {
        let mut itinerary = Itinerary::new(Mission::Route(vec![Turn::Right, Turn::Stop]));
        assert_eq!(itinerary.turn(Fitting::Cross, [0.0; 3]), Some(Turn::Right));
        itinerary.took(Fitting::Cross, [0.0; 3]);
        assert_eq!(itinerary.turn(Fitting::DeadEnd, [0.0; 3]), Some(Turn::Stop));
        itinerary.took(Fitting::DeadEnd, [0.0; 3]);
        assert_eq!(itinerary.turn(Fitting::DeadEnd, [0.0; 3]), None);
    }
}
