//! Which way to take next: as a route names it, or so that every branch is seen.
//!
//! Exploring goes depth first, left before straight before right. What was taken at each junction on the way back to the start is
//! remembered; a junction is known again by the order in which junctions come, so networks with loops are not explored rightly: a loop's
//! second end would be taken for a junction that is new.

use super::route::Turn;
use crate::ahead::{Fitting, Side};

/// Where to go.
#[derive(Clone, Debug, PartialEq)]
pub enum Mission {
    /// These turns in order; behind the last one straight on to the end.
    Route(Vec<Turn>),
    /// Into every branch once.
    Explore,
}

/// A direction at a junction, in quarter turns to the left of the way in which it was first entered.
type Quarter = i32;
const BACK: Quarter = 2;

/// A junction on the way back to the start.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    /// Exits that were not taken yet, in the order in which they will be.
    left: Vec<Quarter>,
    /// The exit that was taken last.
    taken: Quarter,
}

/// How far it is.
#[derive(Clone, Debug)]
pub(super) struct Itinerary {
    mission: Mission,
    next: usize,
    nodes: Vec<Node>,
    /// Whether the robot comes back to the last of the nodes.
    returns: bool,
}

impl Itinerary {
    pub(super) fn new(mission: Mission) -> Self {
        Self { mission, next: 0, nodes: Vec::new(), returns: false }
    }

    /// Whether this fitting is one at which there is a choice.
    pub(super) fn has_say(&self, fitting: Fitting) -> bool {
        fitting == Fitting::DeadEnd || !exits(fitting).is_empty()
    }

    /// The turn at this fitting; `None` where nothing is said of it.
    pub(super) fn turn(&self, fitting: Fitting) -> Option<Turn> {
        match &self.mission {
            Mission::Route(turns) => turns.get(self.next).copied(),
            Mission::Explore if ends(fitting) => {
                let is_left = self.nodes.iter().any(|node| !node.left.is_empty());
                Some(if is_left { Turn::TurnBack } else { Turn::Stop })
            }
            Mission::Explore => match self.nodes.last().filter(|_| self.returns) {
                Some(node) => Some(turn_of(node.left.first().copied().unwrap_or(BACK) - node.taken - BACK)),
                None => exits(fitting).first().map(|quarter| turn_of(*quarter)),
            },
        }
    }

    /// It was taken.
    pub(super) fn took(&mut self, fitting: Fitting) {
        self.next += 1;
        if self.mission != Mission::Explore {
            return;
        }
        if ends(fitting) {
            self.returns = true;
        } else if !self.returns {
            let mut left = exits(fitting);
            if !left.is_empty() {
                let taken = left.remove(0);
                self.nodes.push(Node { left, taken });
            }
        } else if let Some(node) = self.nodes.last_mut() {
            if node.left.is_empty() {
                self.nodes.pop();
            } else {
                node.taken = node.left.remove(0);
                self.returns = false;
            }
        }
    }
}

/// Whether the way is over there: a wall, a hole, something that is not passed.
fn ends(fitting: Fitting) -> bool {
    matches!(fitting, Fitting::DeadEnd | Fitting::Drop | Fitting::Obstacle)
}

/// The exits that a junction shows, left before straight before right.
fn exits(fitting: Fitting) -> Vec<Quarter> {
    match fitting {
        Fitting::Branch(Side::Left) => vec![1, 0],
        Fitting::Branch(Side::Right) => vec![0, -1],
        Fitting::BullheadTee => vec![1, -1],
        Fitting::Cross => vec![1, 0, -1],
        _ => vec![],
    }
}

fn turn_of(quarter: Quarter) -> Turn {
    match quarter.rem_euclid(4) {
        0 => Turn::Straight,
        1 => Turn::Left,
        2 => Turn::TurnBack,
        _ => Turn::Right,
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
        for (fitting, turn) in [
            (tee, Turn::Left),
            // The branch's own junction.
            (Fitting::BullheadTee, Turn::Left),
            (Fitting::DeadEnd, Turn::TurnBack),
            // From its left arm: straight on into the right one, past the stem on the right. There the floor ends.
            (Fitting::Branch(Side::Right), Turn::Straight),
            (Fitting::Drop, Turn::TurnBack),
            // From its right arm: the stem is on the left.
            (Fitting::Branch(Side::Left), Turn::Left),
            // Back at the first tee, from its branch: its straight exit is on the left.
            (Fitting::BullheadTee, Turn::Left),
            (Fitting::DeadEnd, Turn::Stop),
        ] {
            assert_eq!(itinerary.turn(fitting), Some(turn), "{fitting:?}: {itinerary:?}");
            itinerary.took(fitting);
        }
    }

    #[test]
    fn a_route_is_taken_in_order_and_then_says_nothing() {
        let mut itinerary = Itinerary::new(Mission::Route(vec![Turn::Right, Turn::Stop]));
        assert_eq!(itinerary.turn(Fitting::Cross), Some(Turn::Right));
        itinerary.took(Fitting::Cross);
        assert_eq!(itinerary.turn(Fitting::DeadEnd), Some(Turn::Stop));
        itinerary.took(Fitting::DeadEnd);
        assert_eq!(itinerary.turn(Fitting::DeadEnd), None);
    }
}
