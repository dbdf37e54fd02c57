//! Backing out of where there is no room to turn round: the way that the robot came by, in order, to be gone over once more backwards.
//!
//! A unicycle that drives backwards along a path is one that drives forwards along the same path run through the other way, its nose where
//! its tail is: both headings turn by half a turn, so that their difference stays. What lies to the left lies to the right then, and a bend
//! to the left is one to the right; the yaw rate is the same about the same axis, and the speed changes its sign:
//!
//! | forwards | e_y' = v sin(e_th) | e_th' = w - v c cos(e_th) / (1 - c e_y) |
//! |---|---|---|
//! | with u = -v, f_y = -e_y, d = -c | f_y' = u sin(e_th) | e_th' = w - u d cos(e_th) / (1 - d f_y) |
//!
//! So every control law that is stable forwards is as stable backwards, with lateral error, curvature and speed negated and heading error and
//! yaw rate kept ([`reversed`]); the test holds it. What differs is what is seen: the camera looks at where the robot comes from.

use super::bend::OnPath;
use super::detour::Detour;
use super::passage::Passage;
use super::route::Turn;
use super::{
    AT_REST_M, BELIEVED_SHARE, Course, End, Entered, HEADING_DOUBT_RAD, LATERAL_DOUBT_M, OVER_M, Phase, TURN_DOUBT, WIDTH_DOUBT_M,
};
use crate::ahead::{DuctPlace, Fitting, Stretch};
use crate::control::{PathState, Twist};

/// Narrowest duct in which this robot turns round on the spot, in metres: its nose's corners, 0.16 m ahead and 0.08 m aside, sweep a circle of
/// 0.358 m; the rest is its place, which it knows to millimetres.
const ROUND_WIDTH_M: f64 = 0.375;
/// Out of a passage it turns round this far before it, in metres.
const ROOM_M: f64 = 0.5;
/// A duct that widens on the way back is so much wider before it turns there, in metres.
const WIDER_M: f64 = 0.02;
/// It backs to this before a junction, in metres, so that the duct's walls and the junction are in view again.
const BEFORE_JUNCTION_M: f64 = 1.0;
/// It goes no nearer to where its duct began than this, in metres.
const AFTER_BEGIN_M: f64 = 0.1;
/// Its usual speed backwards, as a share of that forwards: it sees nothing of where it goes.
const SPEED_SHARE: f64 = 0.6;

/// A piece of the way that it came by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Straight on past a junction.
    Past {
        /// Which.
        fitting: Fitting,
        /// Where it begins, in metres along the duct.
        at_m: f64,
        /// Where its left and its right wall are open, in metres along the duct.
        openings: [Option<[f64; 2]>; 2],
    },
    /// Past something that stands in the duct.
    Aside(Detour),
    /// Into another duct.
    Through(Entry),
}

/// How the robot came into a duct out of another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    /// The passage.
    pub(super) passage: Passage,
    /// What it leads through.
    pub(super) fitting: Fitting,
    /// Whether there was a choice.
    pub(super) is_junction: bool,
    /// Frame of the duct before it in the first one's.
    pub(super) first_from_duct: [f64; 3],
    /// Width of that duct, in metres.
    pub(super) width_m: f64,
}

/// A turn as it is named by one who comes out of the dead end, for a robot that stands before the junction as it did when it first came to it,
/// `quarter` being the turn that it took then (1 left, 0 straight, -1 right).
fn as_before(turn: Turn, quarter: i32) -> Turn {
    let named = match turn {
        Turn::Left => 1,
        Turn::Straight => 0,
        Turn::Right => -1,
        Turn::TurnBack | Turn::Stop => return turn,
    };
    // It faces the other way: two quarters more.
    match (quarter + 2 + named).rem_euclid(4) {
        0 => Turn::Straight,
        1 => Turn::Left,
        2 => Turn::TurnBack,
        _ => Turn::Right,
    }
}

/// Which quarter a passage through a junction turns by.
fn quarter(passage: &Passage) -> i32 {
    let turn_rad = passage.turn_rad();
    if turn_rad == 0.0 { 0 } else { turn_rad.signum() as i32 }
}

/// The path as a robot that drives backwards along it has it in front of its tail, and its motion likewise.
pub fn reversed(state: PathState) -> PathState {
    PathState {
        lateral_m: -state.lateral_m,
        curvature_1_m: -state.curvature_1_m,
        travelled_m: -state.travelled_m,
        measured: back(state.measured),
        ..state
    }
}

/// A motion, nose and tail exchanged.
pub fn back(twist: Twist) -> Twist {
    Twist { speed_m_s: -twist.speed_m_s, ..twist }
}

impl Course {
    /// Turns back: on the spot where there is room, backwards where there is not.
    pub(super) fn turn_back(&mut self, place: &DuctPlace) -> Phase {
        self.itinerary.took(Fitting::DeadEnd, self.junction);
        self.round_or_back(place)
    }

    fn round_or_back(&mut self, place: &DuctPlace) -> Phase {
        if place.width_m >= ROUND_WIDTH_M {
            return Phase::TurningRound;
        }
        self.planned = None;
        self.ahead.enter();
        Phase::BackingOut
    }

    /// Whether it drives backwards.
    pub(super) fn is_backwards(&self) -> bool {
        matches!(self.phase, Phase::BackingOut | Phase::BackingInto(_))
    }

    /// The passage by which it came into the duct that it is in, if nothing lies between.
    fn came_through(&self) -> Option<Passage> {
        match self.trail.last() {
            Some(Step::Through(entry)) => Some(entry.passage),
            _ => None,
        }
    }

    /// Up to where it drives backwards in this duct, in metres along it, and whether it stands there; `None` where the passage into the duct
    /// before is next.
    pub(super) fn back_to_m(&self) -> Option<(f64, bool)> {
        let before = |at_m: f64, by_m: f64| (at_m - by_m).max(AFTER_BEGIN_M);
        match (self.phase, self.trail.last()) {
            (Phase::BackingInto(entry), _) if entry.is_junction => {
                Some((before(entry.passage.start_m(), BEFORE_JUNCTION_M), true))
            }
            (Phase::BackingInto(entry), _) => Some((before(entry.passage.start_m(), ROOM_M), entry.width_m >= ROUND_WIDTH_M)),
            (Phase::BackingOut, Some(Step::Past { at_m, .. })) => Some((before(*at_m, BEFORE_JUNCTION_M), true)),
            (Phase::BackingOut, Some(Step::Aside(detour))) => Some((detour.from_m, false)),
            (Phase::BackingOut, None) => Some((AFTER_BEGIN_M, true)),
            _ => None,
        }
    }

    /// Goes on backwards from where a frame shows it; says if it is in the duct before from now on.
    pub(super) fn back_out(&mut self, place: &DuctPlace) -> Option<Entered> {
        let pose = [place.along_m, place.lateral_m, place.heading_rad];
        // Out of what was not told as a passage when it came in: what is seen to be wide enough lies ahead of it, and so it is behind the mouth.
        if self.phase == Phase::BackingOut && place.width_m >= ROUND_WIDTH_M + WIDER_M {
            self.phase = Phase::TurningRound;
            return None;
        }
        if let (Phase::BackingOut, Some(Step::Through(entry))) = (self.phase, self.trail.last().copied()) {
            let entry_pose = entry.passage.entry_from_exit(pose);
            let is_there = entry.passage.project(entry_pose).way_m < entry.passage.length_m() / 2.0;
            return is_there.then(|| self.back_into(entry, entry_pose));
        }
        let (to_m, stands) = self.back_to_m()?;
        if place.along_m > to_m + if stands { AT_REST_M } else { 0.0 } {
            return None;
        }
        match (self.phase, self.trail.last().copied()) {
            (Phase::BackingInto(entry), _) if entry.is_junction => {
                self.stands_before(entry.fitting, quarter(&entry.passage), place)
            }
            (Phase::BackingInto(_), _) => self.phase = self.round_or_back(place),
            (_, Some(Step::Past { fitting, .. })) => {
                self.trail.pop();
                self.stands_before(fitting, 0, place);
            }
            (_, Some(Step::Aside(_))) => {
                self.trail.pop();
            }
            _ => self.phase = Phase::AtTheEnd(End::NoRoom),
        }
        None
    }

    /// From a duct's coordinates to those of the one before it.
    fn back_into(&mut self, entry: Entry, [along_m, lateral_m, heading_rad]: [f64; 3]) -> Entered {
        self.trail.pop();
        self.before_m -= entry.passage.start_m() + entry.passage.length_m();
        self.log.backed_into(entry.first_from_duct, self.along_m, along_m, entry.width_m);
        self.along_m = along_m;
        self.phase = Phase::BackingInto(entry);
        Entered {
            lateral_m: [lateral_m, LATERAL_DOUBT_M],
            heading_rad: [heading_rad, TURN_DOUBT * entry.passage.turn_rad().abs() + HEADING_DOUBT_RAD],
            width_m: [entry.width_m, WIDTH_DOUBT_M],
        }
    }

    /// It stands before a junction as it did when it first came to it, and took it by this quarter: what its route says next is taken from here.
    fn stands_before(&mut self, fitting: Fitting, quarter: i32, place: &DuctPlace) {
        if self.itinerary.turn(fitting, self.junction).map(|turn| as_before(turn, quarter)) == Some(Turn::TurnBack) {
            // Back the way that it first came: the junction is behind it already.
            self.take_turn(fitting);
            self.phase = self.round_or_back(place);
        } else {
            self.came_by = Some(quarter);
            self.ahead.enter();
            self.planned = None;
            self.phase = Phase::Along;
        }
    }

    /// What its route says of a fitting, as it is named from where the robot stands.
    pub(super) fn turn(&self, fitting: Fitting) -> Option<Turn> {
        let turn = self.itinerary.turn(fitting, self.junction)?;
        Some(self.came_by.map_or(turn, |quarter| as_before(turn, quarter)))
    }

    /// Where walls are straight for a robot that drives backwards.
    pub(super) fn straight_back(&self) -> Option<Stretch> {
        match (self.phase, self.trail.last()) {
            // Its place behind the bend is known by the wheels alone.
            (Phase::BackingInto(entry), _) => Some(Stretch { is_rough: true, ..entry.passage.straight_before() }),
            // The camera looks away from the bend: only where the robot is in it are other walls than the duct's in view.
            (_, Some(Step::Through(entry))) if self.along_m < OVER_M => Some(entry.passage.straight_behind()),
            (_, Some(Step::Past { openings, .. })) => Some(self.straight_past(openings)),
            (_, Some(Step::Aside(detour))) => Some(self.straight_past(&detour.hidden())),
            _ => None,
        }
    }

    /// Whether walls seen at this heading are those of the duct that it drives backwards in.
    pub(super) fn believes_backwards(&self, heading_rad: f64) -> bool {
        let (passage, share) = match self.phase {
            Phase::BackingInto(entry) => (Some(entry.passage), BELIEVED_SHARE),
            _ => (self.came_through(), 2.0 * BELIEVED_SHARE),
        };
        passage.is_none_or(|passage| passage.turn_rad() == 0.0 || heading_rad.abs() < share * passage.turn_rad().abs())
    }

    /// A pose in its duct against the path that it drives back along, and where that path's zero is, in metres from the duct's.
    pub(super) fn path_back(&self, pose: [f64; 3]) -> (OnPath, f64) {
        let [along_m, lateral_m, heading_rad] = pose;
        match (self.phase, self.trail.last()) {
            (Phase::BackingInto(entry), _) => (entry.passage.project(pose), entry.passage.start_m()),
            (_, Some(Step::Through(Entry { passage, .. }))) => {
                (passage.project(passage.entry_from_exit(pose)), -passage.length_m())
            }
            (_, Some(Step::Aside(detour))) => (detour.project(pose), 0.0),
            _ => (OnPath { way_m: along_m, lateral_m, heading_rad, curvature_1_m: 0.0 }, 0.0),
        }
    }

    /// Its highest speed backwards but for where it is to stand, in m/s.
    pub(super) fn speed_back_m_s(&self) -> f64 {
        let super::CourseParams { speed_m_s, turn_rate_rad_s, .. } = self.params;
        let passage = match self.phase {
            Phase::BackingInto(entry) => Some(entry.passage),
            _ => self.came_through(),
        };
        (SPEED_SHARE * speed_m_s).min(passage.map_or(f64::INFINITY, |passage| turn_rate_rad_s * passage.radius_m()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::ControlLaw;
    use crate::control::koh_cho::{KohCho, KohChoParams};
    use crate::control::limits::Limits;

    /// Backwards round an arc to the left, from 40 mm beside it and 6 degrees askew: the robot is on the path soon, and stays there.
    #[test]
    fn a_law_is_as_stable_backwards() {
        const PERIOD_S: f64 = 1.0 / 30.0;
        let mut law = KohCho::new(0.2, Limits::default(), KohChoParams::default());
        let curvature_1_m = 1.0;
        let (mut lateral_m, mut heading_rad, mut way_m) = (0.04_f64, 0.1_f64, 0.0_f64);
        let mut measured = Twist::default();
        for frame in 0..600 {
            let state = PathState {
                lateral_m,
                heading_rad,
                curvature_1_m,
                slowing: 0.0,
                travelled_m: way_m,
                measured,
                period_s: PERIOD_S,
            };
            measured = back(law.twist(&reversed(state)));
            assert!(measured.speed_m_s <= 1e-9, "it drives backwards: {measured:?}");
            let steps = 20;
            for _ in 0..steps {
                let dt = PERIOD_S / f64::from(steps);
                let (sin, cos) = libm::sincos(heading_rad);
                let rate = measured.speed_m_s * cos / (1.0 - curvature_1_m * lateral_m);
                way_m += rate * dt;
                lateral_m += measured.speed_m_s * sin * dt;
                heading_rad += (measured.yaw_rate_rad_s - rate * curvature_1_m) * dt;
            }
            assert!(lateral_m.abs() < 0.06 && heading_rad.abs() < 0.5, "frame {frame}: {lateral_m} {heading_rad}");
        }
        assert!(lateral_m.abs() < 1e-3 && heading_rad.abs() < 5e-3 && way_m < -2.5, "{lateral_m} {heading_rad} {way_m}");
    }

    /// Into the branch of a tee on the left and out again: its stem's far end is on the left of one who comes out, straight ahead of one who
    /// stands where he came from.
    #[test]
    fn turns_are_named_by_who_comes_out() {
        assert_eq!(as_before(Turn::Left, 1), Turn::Straight);
        assert_eq!(as_before(Turn::Right, 1), Turn::TurnBack);
        assert_eq!(as_before(Turn::Straight, 1), Turn::Right);
        assert_eq!(as_before(Turn::Right, -1), Turn::Straight);
        assert_eq!(as_before(Turn::Left, 0), Turn::Right);
        assert_eq!(as_before(Turn::Straight, 0), Turn::TurnBack);
        assert_eq!(as_before(Turn::Stop, 0), Turn::Stop);
    }
}
