//! The route that sees every branch: depth first, left before straight before right.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::route::Arrival;
use super::{Attached, Network, PortRef, Turn};

/// Where an exploration has to decide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    arrival: Arrival,
    /// The port by which the duct that ends here was entered.
    entered: PortRef,
}

impl Network {
    /// A route that goes through every reachable branch at least once and ends where the last one is seen: at a junction into the first
    /// exit that was not yet gone through, left before straight before right; where there is none, the nearest way to one, counted in
    /// turns; at dead ends and before what cannot be passed, back. A branch with no length to drive in (an open exit of a junction, a
    /// shut damper right at it) is left out.
    pub fn exploration(&self, start: PortRef) -> Vec<Turn> {
        let mut route = Vec::new();
        let Some(piece) = self.fittings.get(start.0).filter(|fitting| fitting.port(start.1).is_some()) else { return route };
        let mut length = usize::from(piece.is_junction());
        let arrival = self.go(start, |_, _, _| length += 1);
        let mut place = Place { arrival, entered: start };
        let mut explored: BTreeSet<PortRef> = match arrival {
            Arrival::Junction(at) => BTreeSet::from([at]),
            _ => BTreeSet::new(),
        };
        if length > 0 {
            while let Some(turns) = self.way_to_unexplored(place, &explored) {
                for turn in turns {
                    let Some((_, next)) = self.moves(place).into_iter().find(|(offered, _)| *offered == turn) else { break };
                    explored.extend(self.exit_taken(place, turn));
                    if let Arrival::Junction(at) = next.arrival {
                        explored.insert(at);
                    }
                    place = next;
                    route.push(turn);
                }
            }
        }
        route.push(Turn::Stop);
        route
    }

    /// The port by which a turn leaves a junction.
    fn exit_taken(&self, place: Place, turn: Turn) -> Option<PortRef> {
        let Arrival::Junction(at) = place.arrival else { return None };
        let (_, exit) = self.exits(at).into_iter().find(|(offered, _)| *offered == turn)?;
        Some((at.0, exit))
    }

    /// The turns that can be driven here, and where each leads.
    fn moves(&self, place: Place) -> Vec<(Turn, Place)> {
        match place.arrival {
            Arrival::Junction(at) => {
                let exits = self.exits(at).into_iter();
                exits
                    .filter_map(|(turn, exit)| {
                        let Some(Attached::Port(entered)) = self.attached((at.0, exit)) else { return None };
                        let mut length = 0;
                        let arrival = self.leave((at.0, exit), |_, _, _| length += 1);
                        let can_leave_again = length > 0 || matches!(arrival, Arrival::Junction(_));
                        can_leave_again.then_some((turn, Place { arrival, entered }))
                    })
                    .collect()
            }
            Arrival::DeadEnd(at) | Arrival::Impassable(at) => {
                let entered = match self.attached(at) {
                    Some(Attached::Port(before)) => before,
                    _ => at,
                };
                vec![(Turn::TurnBack, Place { arrival: self.leave(place.entered, |_, _, _| {}), entered })]
            }
            Arrival::Round(_) => Vec::new(),
        }
    }

    /// The fewest turns that end with one into an exit that was not yet gone through.
    fn way_to_unexplored(&self, from: Place, explored: &BTreeSet<PortRef>) -> Option<Vec<Turn>> {
        let mut before: BTreeMap<Place, Option<(Place, Turn)>> = BTreeMap::from([(from, None)]);
        let mut queue = VecDeque::from([from]);
        while let Some(place) = queue.pop_front() {
            let moves = self.moves(place);
            let is_new = |turn: &Turn| self.exit_taken(place, *turn).is_some_and(|exit| !explored.contains(&exit));
            if let Some((turn, _)) = moves.iter().find(|(turn, _)| is_new(turn)) {
                let mut turns = vec![*turn];
                let mut at = place;
                while let Some(Some((earlier, turn))) = before.get(&at) {
                    turns.push(*turn);
                    at = *earlier;
                }
                turns.reverse();
                return Some(turns);
            }
            for (turn, next) in moves {
                before.entry(next).or_insert_with(|| {
                    queue.push_back(next);
                    Some((place, turn))
                });
            }
        }
        None
    }
}
