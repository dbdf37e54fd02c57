//! Routes: a turn a junction, and the path through the network that they make.

use std::collections::BTreeSet;

use super::{Attached, End, Network, PortRef};
use crate::Transform;
use crate::centreline::{Centreline, Segment};
use crate::fitting::Fitting;
use crate::fitting::passage::PathPiece;
use crate::fitting::port::PortName;

/// Exits at least this far aside are turns, in radians: 30 degrees, a wye's least, less rounding.
const TURN_RAD: f64 = std::f64::consts::FRAC_PI_6 - 1e-9;

/// What to do where there is a choice: at a junction, at a dead end, or before something that cannot be passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Turn {
    /// Into the exit on the left.
    Left,
    /// Straight on.
    Straight,
    /// Into the exit on the right.
    Right,
    /// At a dead end: the same way back.
    TurnBack,
    /// The path ends.
    Stop,
}

/// Why a route leads nowhere.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// The place to start from is not there, or a fitting has no such port.
    #[error("the route starts at port `{port}` of fitting {piece}, which is not there")]
    Start {
        /// Index of the fitting.
        piece: usize,
        /// The port.
        port: PortName,
    },
    /// A turn that is not offered where the route asks for it.
    #[error("turn {} of the route, at `{piece}`, is \"{turn}\"; {place} offers {}", .index + 1, list(.offers))]
    NotOffered {
        /// Which turn of the route, from 0.
        index: usize,
        /// Name of the junction, or of the last fitting before a dead end or before what cannot be passed.
        piece: String,
        /// What was asked for.
        turn: Turn,
        /// What the place is: "the junction", "the dead end", "what cannot be passed".
        place: &'static str,
        /// What there is to choose.
        offers: Vec<Turn>,
    },
    /// A junction comes after the last turn.
    #[error("the route has no turn for `{piece}`, a junction, after {turns} turns; it offers {}", list(.offers))]
    TooShort {
        /// Name of the junction.
        piece: String,
        /// How many turns the route has.
        turns: usize,
        /// What there is to choose.
        offers: Vec<Turn>,
    },
    /// The path has ended, and the route has not.
    #[error("the route ends with turn {turns} at `{piece}`, and goes on with \"{next}\" after it")]
    TooLong {
        /// Turns that were taken.
        turns: usize,
        /// Where.
        piece: String,
        /// The next one.
        next: Turn,
    },
}

impl Turn {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Left, Self::Straight, Self::Right, Self::TurnBack, Self::Stop];

    /// How it is written.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Straight => "straight",
            Self::Right => "right",
            Self::TurnBack => "turn-back",
            Self::Stop => "stop",
        }
    }

    /// The turn that is written like this.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|turn| turn.as_str() == name)
    }
}

impl std::fmt::Display for Turn {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

fn list(turns: &[Turn]) -> String {
    turns.iter().map(|turn| format!("\"{turn}\"")).collect::<Vec<_>>().join(", ")
}

/// Where a way along fittings with two ports leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Arrival {
    /// At a junction, by this port.
    Junction(PortRef),
    /// At the free port of the last fitting.
    DeadEnd(PortRef),
    /// Before a fitting that cannot be passed, at this port of it.
    Impassable(PortRef),
    /// Where it began, round a cycle without a junction.
    Round(PortRef),
}

impl Arrival {
    pub(super) fn at(self) -> PortRef {
        match self {
            Self::Junction(at) | Self::DeadEnd(at) | Self::Impassable(at) | Self::Round(at) => at,
        }
    }

    fn place(self) -> &'static str {
        match self {
            Self::Junction(_) => "the junction",
            Self::DeadEnd(_) => "the end of the duct",
            Self::Impassable(_) => "a fitting that cannot be passed",
            Self::Round(_) => "the end of the round",
        }
    }
}

/// A path in the making.
struct Walk<'n> {
    network: &'n Network,
    path: Centreline,
    /// The first segment of the duct that the path is in: behind the last junction or the last turning place.
    first: usize,
    /// The port by which that duct was entered.
    entered: PortRef,
    arrival: Arrival,
}

impl Network {
    /// What a port leads to; `None` if there is no such port.
    pub fn attached(&self, (piece, port): PortRef) -> Option<Attached> {
        self.attached.get(piece)?.iter().find(|(name, _)| *name == port).map(|(_, what)| *what)
    }

    /// The exits that a junction offers to one that enters it by this port: the turn, and the port that it leads to. Exits behind a cap
    /// are none.
    pub fn exits(&self, (piece, entry): PortRef) -> Vec<(Turn, PortName)> {
        let fitting = &self.fittings[piece];
        let Some(from) = fitting.port(entry) else { return Vec::new() };
        let mut exits: Vec<(Turn, PortName)> = fitting
            .ports()
            .iter()
            .filter(|port| port.name != entry && self.attached((piece, port.name)) != Some(Attached::End(End::Cap)))
            .map(|port| {
                let entry_from_out = from.entry_from_port.rotation;
                let out = entry_from_out.inverse() * (port.entry_from_port.rotation * nalgebra::Vector3::x());
                // Seen against x, which points out of the entry: straight on is -x, left is -y.
                let turn_rad = libm::atan2(-out.y, -out.x);
                let turn = if turn_rad >= TURN_RAD {
                    Turn::Left
                } else if turn_rad <= -TURN_RAD {
                    Turn::Right
                } else {
                    Turn::Straight
                };
                (turn, port.name)
            })
            .collect();
        exits.sort();
        exits
    }

    /// The path that a route makes: entering the fitting of `start` by its port, then a turn for every junction, dead end, and fitting
    /// that cannot be passed. Turning back is done `short_m` before the end of the duct, or midway in a duct shorter than twice that.
    /// After the last turn the path goes on to the end of the duct, also through what cannot be passed.
    ///
    /// # Errors
    /// If the start is not there, a turn is not offered where it is asked for, or the route is too short or too long.
    pub fn path(&self, route: &[Turn], start: PortRef, short_m: f64) -> Result<Centreline, RouteError> {
        let (piece, port) = start;
        if self.attached(start).is_none() {
            return Err(RouteError::Start { piece, port });
        }
        let mut walk = Walk::new(self, start);
        for (index, turn) in route.iter().copied().enumerate() {
            if turn == Turn::Stop {
                let piece = self.names[walk.arrival.at().0].clone();
                let too_long = |next: &Turn| Err(RouteError::TooLong { turns: index + 1, piece, next: *next });
                return route.get(index + 1).map_or(Ok(walk.path), too_long);
            }
            if !walk.take(turn, short_m) {
                let (piece, place) = (self.names[walk.arrival.at().0].clone(), walk.arrival.place());
                return Err(RouteError::NotOffered { index, piece, turn, place, offers: walk.offers() });
            }
        }
        let mut seen = BTreeSet::new();
        while let Arrival::Impassable(at) = walk.arrival
            && seen.insert(at)
        {
            walk.through(at);
        }
        if let Arrival::Junction((piece, _)) = walk.arrival {
            let piece = self.names[piece].clone();
            return Err(RouteError::TooShort { piece, turns: route.len(), offers: walk.offers() });
        }
        Ok(walk.path)
    }

    /// The path that a run without branches follows: from the first fitting's `in` on, straight through junctions and through what
    /// cannot be passed, to the end of the duct or to a junction without a way straight on.
    pub(super) fn straight_through(&self) -> Centreline {
        let mut walk = Walk::new(self, (0, PortName::In));
        let mut seen = BTreeSet::new();
        while seen.insert(walk.arrival) {
            match walk.arrival {
                Arrival::Impassable(at) => walk.through(at),
                Arrival::Junction(_) => {
                    if !walk.take(Turn::Straight, 0.0) {
                        break;
                    }
                }
                Arrival::DeadEnd(_) | Arrival::Round(_) => break,
            }
        }
        walk.path
    }

    /// Goes into a fitting by this port, and on as long as there is nothing to decide. Each fitting gone through is told to `visit`,
    /// with the ports by which it is entered and left.
    pub(super) fn go(&self, start: PortRef, mut visit: impl FnMut(usize, PortName, PortName)) -> Arrival {
        let mut at = start;
        loop {
            let (piece, entry) = at;
            let fitting = &self.fittings[piece];
            if !fitting.is_passable() {
                return Arrival::Impassable(at);
            }
            let Some(exit) = other_port(fitting, entry) else { return Arrival::Junction(at) };
            visit(piece, entry, exit);
            match self.attached((piece, exit)) {
                Some(Attached::Port(next)) if next == start => return Arrival::Round(start),
                Some(Attached::Port(next)) => at = next,
                _ => return Arrival::DeadEnd((piece, exit)),
            }
        }
    }

    /// As [`Self::go`], out of a fitting by this port; a dead end if nothing is joined to it.
    pub(super) fn leave(&self, exit: PortRef, visit: impl FnMut(usize, PortName, PortName)) -> Arrival {
        match self.attached(exit) {
            Some(Attached::Port(next)) => self.go(next, visit),
            _ => Arrival::DeadEnd(exit),
        }
    }

    fn add_passage(&self, (piece, from): PortRef, to: PortName, path: &mut Centreline) {
        let world_from_entry = self.world_from_fitting[piece];
        for piece_of_path in self.fittings[piece].passage(from, to).unwrap_or_default() {
            path.push(segment(&piece_of_path, &world_from_entry, piece));
        }
    }
}

impl<'n> Walk<'n> {
    fn new(network: &'n Network, start: PortRef) -> Self {
        let mut walk = Self { network, path: Centreline::default(), first: 0, entered: start, arrival: Arrival::Junction(start) };
        walk.arrival = network.go(start, |piece, from, to| network.add_passage((piece, from), to, &mut walk.path));
        walk
    }

    /// What there is to choose.
    fn offers(&self) -> Vec<Turn> {
        let exits = match self.arrival {
            Arrival::Junction(at) => self.network.exits(at).into_iter().map(|(turn, _)| turn).collect(),
            Arrival::Round(_) => Vec::new(),
            _ if self.path.segments.len() > self.first => vec![Turn::TurnBack],
            _ => Vec::new(),
        };
        exits.into_iter().chain([Turn::Stop]).collect()
    }

    /// Goes on until there is something to decide again; false if the turn is not offered here.
    fn take(&mut self, turn: Turn, short_m: f64) -> bool {
        if !self.offers().contains(&turn) {
            return false;
        }
        match self.arrival {
            Arrival::Junction(at) => {
                let exits = self.network.exits(at);
                let Some((_, exit)) = exits.into_iter().find(|(offered, _)| *offered == turn) else { return false };
                self.network.add_passage(at, exit, &mut self.path);
                self.leave((at.0, exit));
            }
            Arrival::DeadEnd(at) | Arrival::Impassable(at) | Arrival::Round(at) => {
                let back = self.entered;
                // The duct behind the turning place ends at the port that this one ends at.
                self.entered = match self.network.attached(at) {
                    Some(Attached::Port(before)) => before,
                    _ => at,
                };
                self.first = self.path.turn_back(self.first, short_m);
                let (network, path) = (self.network, &mut self.path);
                self.arrival = network.leave(back, |piece, from, to| network.add_passage((piece, from), to, path));
            }
        }
        true
    }

    /// Out of a junction.
    fn leave(&mut self, exit: PortRef) {
        self.first = self.path.segments.len();
        self.entered = match self.network.attached(exit) {
            Some(Attached::Port(next)) => next,
            _ => exit,
        };
        let (network, path) = (self.network, &mut self.path);
        self.arrival = network.leave(exit, |piece, from, to| network.add_passage((piece, from), to, path));
    }

    /// Through a fitting that cannot be passed.
    fn through(&mut self, (piece, entry): PortRef) {
        let network = self.network;
        let Some(exit) = other_port(&network.fittings[piece], entry) else { return };
        network.add_passage((piece, entry), exit, &mut self.path);
        self.arrival = network.leave((piece, exit), |piece, from, to| network.add_passage((piece, from), to, &mut self.path));
    }
}

/// The port that a way in by `entry` leads to where there is nothing to choose.
fn other_port(fitting: &Fitting, entry: PortName) -> Option<PortName> {
    let ports = fitting.ports();
    match ports.iter().filter(|port| port.name != entry).collect::<Vec<_>>()[..] {
        [only] => Some(only.name),
        _ => None,
    }
}

fn segment(piece: &PathPiece, world_from_entry: &Transform, fitting: usize) -> Segment {
    Segment {
        world_from_start: world_from_entry * piece.entry_from_start,
        length_m: piece.length_m,
        curvature_1_m: piece.curvature_1_m,
        pitch_rad: piece.pitch_rad,
        width_m: piece.width_m[0],
        height_m: piece.height_m[0],
        end_width_m: piece.width_m[1],
        end_height_m: piece.height_m[1],
        start_m: 0.0,
        fitting,
        turns_back: false,
    }
}
