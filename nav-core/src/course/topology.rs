//! The network as exploring finds it: junctions, their exits, and what each leads to; and the fewest turns to an exit that was not taken yet.
//!
//! At a junction the first exit that is new is taken, left before straight before right; where there is none, the nearest way to one,
//! counted in turns; at dead ends the robot turns back. A junction is known again by the duct that leads to it, and where that is driven
//! for the first time by its place: so a network's loops are closed. The reference path of exploring goes by the same rules.

use std::f64::consts::{FRAC_PI_2, PI};

use super::route::Turn;

/// A direction at a junction, in quarter turns to the left of the way in which it was first entered, 0 to 3.
type Quarter = i32;
const BACK: Quarter = 2;

/// Two junctions of ducts that a robot passes through lie farther apart than this, in metres; dead reckoning is off by less.
const SAME_M: f64 = 0.3;

/// What an exit leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lead {
    /// A junction, and by which of its exits one comes to it.
    Junction(usize, Quarter),
    /// The end of a duct.
    End,
}

#[derive(Clone, Debug, PartialEq)]
struct Exit {
    quarter: Quarter,
    is_taken: bool,
    leads: Option<Lead>,
}

#[derive(Clone, Debug, PartialEq)]
struct Node {
    /// Where its middle is and which way it was first entered, in the frame of the first duct.
    place: [f64; 3],
    exits: Vec<Exit>,
}

/// Where there is a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// At a junction, come by this exit of it.
    At(usize, Quarter),
    /// At the end of the duct that begins at this exit.
    End(usize, Quarter),
}

/// What is known of the network.
#[derive(Clone, Debug, Default)]
pub(super) struct Topology {
    nodes: Vec<Node>,
    /// The exit by which the robot left the last junction.
    from: Option<(usize, Quarter)>,
    /// Whether it has turned round since.
    returns: bool,
}

/// Left before straight before right.
fn order(turn: Turn) -> u8 {
    match turn {
        Turn::Left => 0,
        Turn::Straight => 1,
        _ => 2,
    }
}

/// The turn from one exit of a junction to another one.
fn turn(from: Quarter, to: Quarter) -> Turn {
    match (to - from - BACK).rem_euclid(4) {
        0 => Turn::Straight,
        1 => Turn::Left,
        2 => Turn::TurnBack,
        _ => Turn::Right,
    }
}

impl Topology {
    /// Whether the robot comes back to the junction that it left last.
    pub(super) fn returns(&self) -> bool {
        self.returns
    }

    /// What to do at the end of a duct.
    pub(super) fn turn_at_end(&self) -> Turn {
        let state = self.from.map(|(node, quarter)| State::End(node, quarter));
        state.and_then(|state| self.to_new_exit(state)).unwrap_or(Turn::Stop)
    }

    /// The turn at a junction in this place (along, left, heading in the frame of the first duct), which shows these exits to one who
    /// comes to it (0 straight on, 1 left, -1 right); stop where everything has been seen.
    pub(super) fn turn_at(&self, here: [f64; 3], shown: &[i32]) -> Option<Turn> {
        match self.arrival(here) {
            Some((node, quarter)) => Some(self.to_new_exit(State::At(node, quarter)).unwrap_or(Turn::Stop)),
            None => shown.iter().map(|exit| turn(BACK, exit.rem_euclid(4))).min_by_key(|turn| order(*turn)),
        }
    }

    /// The robot has turned back at the end of a duct.
    pub(super) fn turned_back(&mut self) {
        self.returns = true;
        if let Some(from) = self.from {
            self.leads(from, Lead::End);
        }
    }

    /// The robot has taken the turn that was told.
    pub(super) fn took(&mut self, here: [f64; 3], shown: &[i32]) {
        let Some(taken) = self.turn_at(here, shown) else { return };
        let (node, quarter) = self.arrival(here).unwrap_or_else(|| {
            let exit = |quarter: Quarter| Exit { quarter, is_taken: quarter == BACK, leads: None };
            let exits = std::iter::once(BACK).chain(shown.iter().map(|quarter| quarter.rem_euclid(4))).map(exit).collect();
            self.nodes.push(Node { place: here, exits });
            (self.nodes.len() - 1, BACK)
        });
        match self.from.filter(|_| !self.returns) {
            Some(from) => {
                self.leads(from, Lead::Junction(node, quarter));
                self.leads((node, quarter), Lead::Junction(from.0, from.1));
            }
            None if self.from.is_none() => self.leads((node, quarter), Lead::End),
            None => {}
        }
        let next = self.nodes[node].exits.iter_mut().find(|exit| turn(quarter, exit.quarter) == taken);
        if let Some(exit) = next {
            exit.is_taken = true;
            self.from = Some((node, exit.quarter));
            self.returns = false;
        }
    }

    fn exit(&self, (node, quarter): (usize, Quarter)) -> Option<&Exit> {
        self.nodes.get(node)?.exits.iter().find(|exit| exit.quarter == quarter)
    }

    fn leads(&mut self, (node, quarter): (usize, Quarter), lead: Lead) {
        let exits = self.nodes.get_mut(node).map(|node| &mut node.exits);
        if let Some(exit) = exits.and_then(|exits| exits.iter_mut().find(|exit| exit.quarter == quarter)) {
            exit.leads = Some(lead);
            exit.is_taken = true;
        }
    }

    /// The junction that the robot comes to and the exit of it by which it comes; `None` if it has not been there.
    fn arrival(&self, [along_m, left_m, heading_rad]: [f64; 3]) -> Option<(usize, Quarter)> {
        let from = self.from?;
        if self.returns {
            return Some(from);
        }
        if let Some(Lead::Junction(node, quarter)) = self.exit(from)?.leads {
            return Some((node, quarter));
        }
        let is_here = |node: &Node| libm::hypot(node.place[0] - along_m, node.place[1] - left_m) < SAME_M;
        let node = self.nodes.iter().position(is_here)?;
        let quarter = (libm::round((heading_rad + PI - self.nodes[node].place[2]) / FRAC_PI_2) as i32).rem_euclid(4);
        self.exit((node, quarter)).map(|_| (node, quarter))
    }

    /// The turns from here, in their order, and the exits by which they leave.
    fn moves(&self, state: State) -> Vec<(Turn, (usize, Quarter))> {
        let (node, quarter) = match state {
            State::At(node, quarter) => (node, quarter),
            State::End(node, quarter) => return vec![(Turn::TurnBack, (node, quarter))],
        };
        let others = self.nodes[node].exits.iter().filter(|exit| exit.quarter != quarter);
        let mut moves: Vec<_> = others.map(|exit| (turn(quarter, exit.quarter), (node, exit.quarter))).collect();
        moves.sort_by_key(|(turn, _)| order(*turn));
        moves
    }

    /// Where a turn from here leads, if that is known.
    fn next(&self, state: State, exit: (usize, Quarter)) -> Option<State> {
        match (state, self.exit(exit)?.leads) {
            (State::End(..), _) => Some(State::At(exit.0, exit.1)),
            (_, Some(Lead::Junction(node, quarter))) => Some(State::At(node, quarter)),
            (_, Some(Lead::End)) => Some(State::End(exit.0, exit.1)),
            (_, None) => None,
        }
    }

    /// The first of the fewest turns that end with one into an exit that was not taken yet.
    fn to_new_exit(&self, from: State) -> Option<Turn> {
        // In the order in which they are come to: where, and by which first turn.
        let mut reached: Vec<(State, Option<Turn>)> = vec![(from, None)];
        let (State::At(node, quarter) | State::End(node, quarter)) = from;
        let came_by = (node, quarter);
        let mut done = 0;
        while let Some((state, first)) = reached.get(done).copied() {
            let moves = self.moves(state);
            let is_new = |exit| exit != came_by && self.exit(exit).is_some_and(|exit| !exit.is_taken);
            if let Some((turn, _)) = moves.iter().find(|(turn, exit)| *turn != Turn::TurnBack && is_new(*exit)) {
                return first.or(Some(*turn));
            }
            for (turn, exit) in moves {
                if let Some(next) = self.next(state, exit).filter(|next| reached.iter().all(|(known, _)| known != next)) {
                    reached.push((next, first.or(Some(turn))));
                }
            }
            done += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEE: [i32; 2] = [1, 0];

    /// A tee whose straight exit leads round a ring to its left one: from the ring's end nothing is left to see.
    #[test]
    fn a_ring_is_closed_where_it_began() {
        let mut topology = Topology::default();
        let tee = [2.0, 0.0, 0.0];
        assert_eq!(topology.turn_at(tee, &TEE), Some(Turn::Left));
        topology.took(tee, &TEE);
        // Round it, with dead reckoning off by a hand's breadth: back at the tee, by its straight exit, facing the way in.
        let again = [2.08, -0.1, PI + 0.03];
        assert_eq!(topology.turn_at(again, &[0, -1]), Some(Turn::Stop));
        assert_eq!(topology.arrival(again), Some((0, 0)));
    }

    /// The same with a dead end at the end of the way in's other side: a cross. The ring's end is known, the new exit is taken from there.
    #[test]
    fn from_the_end_of_a_ring_the_exit_that_is_left_is_taken() {
        let mut topology = Topology::default();
        let cross = [2.0, 0.0, 0.0];
        topology.took(cross, &[1, 0, -1]);
        // The ring from left to right: one comes by the right exit, and what was straight on is on the right.
        let again = [1.95, 0.05, FRAC_PI_2];
        assert_eq!(topology.arrival(again), Some((0, 3)));
        assert_eq!(topology.turn_at(again, &[1, 0, -1]), Some(Turn::Right));
        topology.took(again, &[1, 0, -1]);
        assert_eq!(topology.turn_at_end(), Turn::Stop);
    }

    /// Two junctions, each with a dead end: from the farther one back to what is left at the nearer one.
    #[test]
    fn the_nearest_exit_that_is_left_is_gone_to() {
        let mut topology = Topology::default();
        let (near, far) = ([2.0, 0.0, 0.0], [2.0, 3.0, FRAC_PI_2]);
        // Left of two at the near one, left of two at the far one, to its end.
        topology.took(near, &TEE);
        topology.took(far, &TEE);
        assert_eq!(topology.turn_at_end(), Turn::TurnBack);
        topology.turned_back();
        // Out of its left exit its straight one is on the left.
        assert_eq!(topology.turn_at(far, &[]), Some(Turn::Left));
        topology.took(far, &[]);
        assert_eq!(topology.turn_at_end(), Turn::TurnBack);
        topology.turned_back();
        // Past the left exit, which was seen: straight on to the near one; there left.
        assert_eq!(topology.turn_at(far, &[]), Some(Turn::Straight));
        topology.took(far, &[]);
        assert_eq!(topology.turn_at(near, &[1, -1]), Some(Turn::Left));
        topology.took(near, &[1, -1]);
        assert_eq!(topology.turn_at_end(), Turn::Stop);
    }
}
