//! Which way the next fitting is to be taken, planned anew with every frame until it is entered.

use super::backing::Step;
use super::bend::Bend;
use super::itinerary::{Itinerary, is_junction};
use super::passage::Passage;
use super::route::Turn;
use super::taper::Taper;
use super::{AT_REST_M, BLIND_M, Course, End, PLANNED_M, Phase};
use crate::ahead::{DuctPlace, Fitting, Outer, Outlook, Side};

/// An opening that begins so far behind the robot's origin is passed, in metres.
const MISSED_M: f64 = 0.05;
/// A passage nearer than this is gone through though it is not seen any more, in metres.
const FORGOTTEN_M: f64 = 0.4;
/// A plan holds from this before its beginning on, in metres.
const HELD_M: f64 = 0.35;
/// A bend is entered by what is known this far before its beginning, in metres.
const COMMITTED_M: f64 = 0.02;

impl Course {
    /// Which way the duct's next fitting is to be taken.
    pub(super) fn plan(&mut self, place: &DuctPlace) {
        let outlook = *self.ahead.outlook();
        if self.passing.iter().any(Option::is_some) {
            if self.passing.iter().flatten().all(|[_, to_m]| self.along_m > *to_m) {
                self.passing = [None; 2];
                self.ahead.passed();
            }
            return;
        }
        if is_junction(outlook.fitting) {
            let middle_m =
                outlook.openings.iter().flatten().map(|[from_m, to_m]| (from_m + to_m) / 2.0).next().unwrap_or(outlook.at_m);
            self.junction = self.log.first_from([middle_m, 0.0, 0.0]);
        }
        let turn = self.turn(outlook.fitting);
        if self.pass_by(place) {
            return;
        }
        // What stands in a bend that was planned, or a floor that ends before it: the way is not open.
        if matches!(outlook.fitting, Fitting::Obstacle | Fitting::Drop) {
            self.planned = None;
        }
        // Right before a bend its far side is out of view: what was planned holds.
        let holds = self.planned.is_some_and(|passage| passage.start_m() - self.along_m < HELD_M);
        // Not what was planned of an offset: how far it goes aside is seen last, and from there.
        let is_offset = matches!((outlook.fitting, self.planned), (Fitting::Offset(_), Some(Passage::Taper(_))));
        match (outlook.fitting, turn) {
            _ if holds && !is_offset => {}
            (Fitting::Elbow(side), _) => self.plan_bend(place, &outlook, side),
            (Fitting::Branch(Side::Left) | Fitting::Cross | Fitting::BullheadTee, Some(Turn::Left)) => {
                self.plan_bend(place, &outlook, Side::Left);
            }
            (Fitting::Branch(Side::Right) | Fitting::Cross | Fitting::BullheadTee, Some(Turn::Right)) => {
                self.plan_bend(place, &outlook, Side::Right);
            }
            (Fitting::Transition | Fitting::Offset(_), _) => {
                let taper = Taper::between(place.width_m, &self.ahead.changes(place.width_m));
                // One that would have begun already is none.
                let found = taper.filter(|taper| taper.start_m > self.along_m - COMMITTED_M).map(Passage::Taper);
                if found.is_some() || !holds {
                    self.planned = found;
                }
                self.taken = outlook.fitting;
            }
            (Fitting::Branch(_) | Fitting::Cross, None | Some(Turn::Straight)) => self.pass(&outlook),
            _ => self.forget(outlook.fitting),
        }
        // A way that was named and is passed by now was not found.
        let is_missed = |side: Side| outlook.openings[side.index()].is_some_and(|[from_m, _]| self.along_m > from_m + MISSED_M);
        let missed = match turn {
            Some(Turn::Left) => is_missed(Side::Left),
            Some(Turn::Right) => is_missed(Side::Right),
            _ => false,
        };
        if self.planned.is_none() && missed {
            self.phase = Phase::AtTheEnd(End::NoSuchWay);
        }
        if let Some(bend) = self.planned {
            if self.along_m > bend.start_m() - COMMITTED_M {
                if Itinerary::has_say(self.taken) {
                    self.take_turn(self.taken);
                }
                self.phase = Phase::Entering(bend);
            }
        } else if let Some(at_m) = self.stands_m().filter(|at_m| self.along_m >= at_m - self.room_m() - AT_REST_M) {
            self.log.blocked(outlook.fitting, at_m);
            self.phase = match (outlook.fitting, turn) {
                (Fitting::DeadEnd | Fitting::Drop | Fitting::Obstacle, Some(Turn::TurnBack)) => self.turn_back(place),
                (_, Some(Turn::Stop)) => Phase::AtTheEnd(End::Route),
                (Fitting::DeadEnd, None) => Phase::AtTheEnd(End::DeadEnd),
                (Fitting::Drop, _) => Phase::AtTheEnd(End::Drop),
                (Fitting::Obstacle, _) => Phase::AtTheEnd(End::Obstacle),
                (Fitting::Unknown, _) => Phase::AtTheEnd(End::Unknown),
                _ => Phase::AtTheEnd(End::NoSuchWay),
            };
        }
    }

    /// Before what it is to stand, in metres along the duct: what bars the way, or a junction at which its route ends.
    pub(super) fn stands_m(&self) -> Option<f64> {
        let Outlook { fitting, at_m, blocked_m, .. } = *self.ahead.outlook();
        // Not the one that it is passing: what its route says next is not of that.
        let is_ahead = is_junction(fitting) && self.passing.iter().all(Option::is_none);
        let is_goal = is_ahead && self.turn(fitting) == Some(Turn::Stop);
        if is_goal { Some(at_m) } else { blocked_m }
    }

    pub(super) fn take_turn(&mut self, fitting: Fitting) {
        self.itinerary.took(fitting, self.junction);
        self.came_by = None;
        self.junctions += 1;
    }

    /// Plans the path into the opening on a side, anew with every frame.
    fn plan_bend(&mut self, place: &DuctPlace, outlook: &Outlook, side: Side) {
        if outlook.at_m - self.along_m > PLANNED_M {
            return;
        }
        if let Some(outer) = self.ahead.outer(side, place.width_m) {
            let bend = match outer {
                Outer::Wall(wall) => Passage::Bend(Bend::along(&wall, place.width_m)),
                Outer::Arc(arc) => Passage::Bend(Bend::within(&arc, place.width_m)),
            };
            // One that would have begun already is none.
            if bend.start_m() > self.along_m - COMMITTED_M {
                self.taken = outlook.fitting;
                self.planned = Some(bend);
            }
        }
    }

    /// A passage that is not close at hand was none, if it is taken for something else by now; a transition also if it is not seen any more.
    fn forget(&mut self, seen: Fitting) {
        let is_far = |passage: &Passage| passage.start_m() - self.along_m > FORGOTTEN_M;
        let is_none = |passage: &Passage| seen != Fitting::Unknown || matches!(passage, Passage::Taper(_));
        if self.planned.is_some_and(|passage| is_far(&passage) && is_none(&passage)) {
            self.planned = None;
        }
    }

    /// Goes straight on past branches.
    fn pass(&mut self, outlook: &Outlook) {
        if outlook.at_m - BLIND_M > self.along_m {
            return;
        }
        self.passing = outlook.openings;
        self.trail.push(Step::Past { fitting: outlook.fitting, at_m: outlook.at_m, openings: outlook.openings });
        self.log.passed(outlook.fitting, outlook.at_m);
        self.take_turn(outlook.fitting);
    }
}
