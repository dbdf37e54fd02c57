//! Where the robot is to go: along its duct, and at each fitting the way that its route names.
//!
//! - [`route`]: the ways to take;
//! - [`Mission`]: a route, or every branch;
//! - [`bend`], [`taper`]: the path through a bend or a transition, and poses against it; [`passage`] is either;
//! - [`detour`]: the path past what stands in a duct;
//! - [`backing`]: the way back out of where there is no room to turn;
//! - [`Log`]: the ducts that were driven through;
//! - [`Course`]: follows both, from duct to duct; `planning` decides on the next fitting, `motion` has the path and its speed.
//!
//! A duct has coordinates of its own: along it, by odometry, and to the left of its middle. In the middle of a bend the robot changes over to
//! those of the duct behind it. Until the walls of that duct are seen it goes by its wheels.

pub mod backing;
pub mod bend;
pub mod detour;
mod itinerary;
mod log;
mod motion;
pub mod passage;
mod planning;
pub mod route;
pub mod taper;
mod topology;

use std::f64::consts::PI;

use crate::ahead::{Ahead, DuctPlace, Fitting, OuterArc, Outlook, Stretch};
use crate::perception::RangePoint;
use backing::{Entry, Step};
use bend::Bend;
use detour::Detour;
use itinerary::Itinerary;
pub use itinerary::Mission;
pub use log::{DuctRecord, Log, Met};
pub use motion::PathHere;
use passage::Passage;

/// Parameters of a course.
#[derive(Clone, Debug, PartialEq)]
pub struct CourseParams {
    /// Where to go.
    pub mission: Mission,
    /// The robot's usual speed, in m/s.
    pub speed_m_s: f64,
    /// Largest yaw rate in a bend, in rad/s: the robot slows down to it.
    pub turn_rate_rad_s: f64,
    /// How hard it brakes before bends and ends, in m/s2.
    pub braking_m_s2: f64,
    /// Room that it leaves between its origin and a wall ahead, in metres.
    pub stand_off_m: f64,
    /// The same where it is to turn back, in metres: enough to turn on the spot.
    pub turn_back_m: f64,
    /// Where the camera is in the base frame: ahead and to the left, in metres.
    pub camera_m: [f64; 2],
}

impl Default for CourseParams {
    fn default() -> Self {
        Self {
            mission: Mission::Route(Vec::new()),
            speed_m_s: 0.3,
            turn_rate_rad_s: 0.7,
            braking_m_s2: 0.15,
            stand_off_m: 0.25,
            turn_back_m: 0.3,
            camera_m: [0.12, 0.0],
        }
    }
}

/// Share of a bend's angle up to which the walls before it are believed.
const BELIEVED_SHARE: f64 = 0.25;
/// Way behind a bend after which it is over, in metres.
const OVER_M: f64 = 0.3;
/// What the wheels leave in doubt of a bend: share of its angle, of an arc's, which is seen last, more; and of its lateral place, in metres.
const TURN_DOUBT: f64 = 0.05;
const ARC_DOUBT: f64 = 0.1;
/// And what is in doubt of its heading without any turn, in radians.
const HEADING_DOUBT_RAD: f64 = 0.005;
const LATERAL_DOUBT_M: f64 = 0.03;
const WIDTH_DOUBT_M: f64 = 0.02;
/// Beside the robot no wall is seen: before a bend it goes by its wheels from here on, in metres.
const BLIND_M: f64 = 0.85;
/// An arc's angle is looked at up to this share of the way to where the robot changes over to the duct behind it.
const SETTLED_SHARE: f64 = 0.96;
/// A bend is looked for from this far before its beginning, in metres.
const PLANNED_M: f64 = 1.5;
/// Past a junction points this far off a wall's line are its own, in metres.
const PASSING_NEAR_M: f64 = 0.04;
/// This near to where it is to stand a robot has arrived, in metres.
const AT_REST_M: f64 = 0.02;
/// Rays of places that are farther off than this are not kept, in metres and radians.
const JUMP_M: f64 = 0.02;
const JUMP_RAD: f64 = 0.03;
/// If what it stands before is farther off than this, it goes there, in metres.
const FARTHER_M: f64 = 0.15;
/// It has turned round when so little is left, in radians.
const ROUND_RAD: f64 = 0.03;

/// What the robot is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    /// Going along a duct, with the bend that it is coming to.
    #[default]
    Along,
    /// In a bend, still in the coordinates of the duct before it.
    Entering(Passage),
    /// In a bend, in the coordinates of the duct behind it.
    Leaving(Passage),
    /// Turning round on the spot.
    TurningRound,
    /// Passing something that stands in the duct.
    Passing(Detour),
    /// Driving backwards, in the coordinates of the duct that it is in.
    BackingOut,
    /// Driving backwards out of the passage by which it first left the duct in whose coordinates it is.
    BackingInto(Entry),
    /// Standing at the end of its route.
    AtTheEnd(End),
}

/// Why a robot goes no farther.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its route says so.
    Route,
    /// The duct ends, and its route says nothing of it.
    DeadEnd,
    /// Something stands in the way.
    Obstacle,
    /// The floor ends.
    Drop,
    /// It does not know how the duct goes on.
    Unknown,
    /// The way that its route names is not there.
    NoSuchWay,
    /// It is to turn back, and there is no room for that in all the ducts that it came by.
    NoRoom,
}

/// That the robot has come into another duct: where it stands there, each figure with its deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entered {
    /// Offset to the left, in metres.
    pub lateral_m: [f64; 2],
    /// Heading, in radians.
    pub heading_rad: [f64; 2],
    /// Width, in metres.
    pub width_m: [f64; 2],
}

/// Follows a route from duct to duct.
#[derive(Clone, Debug)]
pub struct Course {
    params: CourseParams,
    ahead: Ahead,
    phase: Phase,
    /// The passage that lies ahead, as planned by the last frames.
    planned: Option<Passage>,
    itinerary: Itinerary,
    log: Log,
    /// A junction that is passed straight through: where its left and its right wall are open, in metres along the duct.
    passing: [Option<[f64; 2]>; 2],
    /// The way that it came by since it last turned round.
    trail: Vec<Step>,
    /// By which quarter it first took the junction that it has backed out of and stands before.
    came_by: Option<i32>,
    /// Along the duct, in metres.
    along_m: f64,
    /// Way along the path up to this duct's coordinate zero, in metres.
    before_m: f64,
    /// The fitting that the robot is about to go through, goes through, or went through last.
    taken: Fitting,
    /// Where the junction ahead is, in the frame of the first duct: its middle, and the way to it.
    junction: [f64; 3],
    /// Junctions taken.
    junctions: u32,
}

impl Course {
    /// At the beginning of a route.
    pub fn new(params: CourseParams) -> Self {
        Self {
            ahead: Ahead::new(params.camera_m),
            phase: Phase::Along,
            planned: None,
            itinerary: Itinerary::new(params.mission.clone()),
            log: Log::default(),
            passing: [None; 2],
            trail: Vec::new(),
            came_by: None,
            along_m: 0.0,
            before_m: 0.0,
            taken: Fitting::Unknown,
            junction: [0.0; 3],
            junctions: 0,
            params,
        }
    }

    /// What is seen ahead.
    pub fn outlook(&self) -> &Outlook {
        self.ahead.outlook()
    }

    /// What was driven through.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// A pose in the present duct (lateral offset and heading), in the frame of the first duct: along it, to its left, heading.
    pub fn first_from_base(&self, lateral_m: f64, heading_rad: f64) -> [f64; 3] {
        self.log.first_from([self.along_m, lateral_m, heading_rad])
    }

    /// Junctions taken so far.
    pub fn junctions(&self) -> u32 {
        self.junctions
    }

    /// Why it goes no farther, if it does not.
    pub fn end(&self) -> Option<End> {
        match self.phase {
            Phase::AtTheEnd(end) => Some(end),
            _ => None,
        }
    }

    /// Whether it is in a bend or right before it, where walls are lost and found: there it may go by its wheels.
    pub fn goes_by_wheels(&self) -> bool {
        self.phase != Phase::Along
            || self.planned.is_some_and(|bend| bend.start_m() - self.along_m < BLIND_M)
            || self.ahead.outlook().straight_to_m.is_some_and(|at_m| at_m - self.along_m < BLIND_M)
            || self.passing.iter().flatten().any(|[from_m, to_m]| (from_m - BLIND_M..=*to_m).contains(&self.along_m))
    }

    /// Whether a bend is so near that its walls may be taken for the duct's.
    pub fn is_near_bend(&self) -> bool {
        self.phase != Phase::Along || self.planned.is_some_and(|bend| bend.start_m() - self.along_m < PLANNED_M)
    }

    /// Where the walls of its duct may be believed to be straight, before and behind a bend; `None` elsewhere.
    pub fn straight(&self) -> Option<Stretch> {
        match self.phase {
            Phase::Along => match self.planned.filter(|bend| bend.start_m() - self.along_m < PLANNED_M) {
                Some(bend) => Some(bend.straight_before()),
                None if self.passing.iter().any(Option::is_some) => Some(self.straight_past(&self.passing)),
                None => None,
            },
            Phase::Entering(bend) => Some(bend.straight_before()),
            Phase::Leaving(bend) => Some(bend.straight_behind()),
            Phase::Passing(detour) => Some(self.straight_past(&detour.hidden())),
            Phase::BackingOut | Phase::BackingInto(_) => self.straight_back(),
            Phase::TurningRound | Phase::AtTheEnd(_) => None,
        }
    }

    /// Past a junction a wall counts on the side of its opening that is not behind the camera's first sight of it.
    fn straight_past(&self, openings: &[Option<[f64; 2]>; 2]) -> Stretch {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let of = |open: Option<[f64; 2]>| match open {
            Some([from_m, _]) if self.along_m < from_m - BLIND_M => [f64::NEG_INFINITY, from_m],
            Some([_, to_m]) => [to_m, f64::INFINITY],
            None => all,
        };
        Stretch { along_m: openings.map(of), near_m: PASSING_NEAR_M, is_rough: false }
    }

    /// Along its duct, by odometry, in metres.
    pub fn along_m(&self) -> f64 {
        self.along_m
    }

    /// The robot has gone on, along its duct.
    pub fn advance(&mut self, along_m: f64) {
        self.along_m += along_m;
    }

    /// What the walls show the robot to stand off from where it believed to, to the left in metres and in radians. Rays of places that are
    /// far off do not go with those from now on.
    pub fn corrected(&mut self, lateral_m: f64, heading_rad: f64) {
        if lateral_m.abs() > JUMP_M || heading_rad.abs() > JUMP_RAD {
            self.ahead.forget_rays();
        }
    }

    /// Whether walls seen at this heading are those of the duct in whose coordinates the robot is.
    pub fn believes(&self, heading_rad: f64) -> bool {
        match self.phase {
            Phase::Along | Phase::Passing(_) => true,
            Phase::BackingOut | Phase::BackingInto(_) => self.believes_backwards(heading_rad),
            Phase::TurningRound | Phase::AtTheEnd(_) => false,
            Phase::Entering(Passage::Taper(_)) | Phase::Leaving(Passage::Taper(_)) => true,
            Phase::Entering(bend) => heading_rad.abs() < BELIEVED_SHARE * bend.turn_rad().abs(),
            Phase::Leaving(bend) => heading_rad.abs() < 2.0 * BELIEVED_SHARE * bend.turn_rad().abs(),
        }
    }

    /// How wide the duct is, in metres, and that figure's deviation: for the log, where the duct is straight.
    pub fn measured_width(&mut self, width_m: f64, deviation_m: Option<f64>) {
        if self.phase == Phase::Along {
            self.log.measured(width_m, deviation_m);
        }
    }

    /// Takes in what a frame shows from where the robot stands in its duct; says if it is in another one from now on.
    pub fn look(&mut self, place: &DuctPlace, ranges: &[RangePoint]) -> Option<Entered> {
        if !ranges.is_empty() && self.phase != Phase::TurningRound && !self.is_backwards() {
            self.ahead.look(place, ranges);
        }
        let pose = [place.along_m, place.lateral_m, place.heading_rad];
        match self.phase {
            Phase::Along => self.plan(place),
            Phase::Entering(bend) => {
                let bend = self.looked_round(bend, place);
                let way_m = bend.project(pose).way_m;
                return (way_m > bend.settled_m()).then(|| self.change_over(bend, pose));
            }
            Phase::Leaving(_) if self.along_m > OVER_M => {
                self.phase = Phase::Along;
                self.planned = None;
            }
            Phase::TurningRound if place.heading_rad.abs() >= PI - ROUND_RAD => return Some(self.turned_round(place)),
            Phase::Passing(detour) => self.look_along(detour, place),
            Phase::BackingOut | Phase::BackingInto(_) => return self.back_out(place),
            Phase::AtTheEnd(_) => self.go_on(),
            Phase::Leaving(_) | Phase::TurningRound => {}
        }
        None
    }

    /// If what it stands before is farther off than was thought when it came to rest, it drives up to it.
    fn go_on(&mut self) {
        let is_farther = self.stands_m().is_some_and(|at_m| at_m - self.room_m() - self.along_m > FARTHER_M);
        if is_farther && self.log.unblocked() {
            self.phase = Phase::Along;
        }
    }

    /// How far round an arc goes is only seen on the way: until its first part is behind the robot, its angle follows what is seen.
    fn looked_round(&mut self, passage: Passage, place: &DuctPlace) -> Passage {
        let Passage::Bend(mut bend) = passage else { return passage };
        let way_m = bend.project([place.along_m, place.lateral_m, place.heading_rad]).way_m;
        if bend.is_arc() && way_m < SETTLED_SHARE * bend.settled_m() {
            let radius_m = bend.radius_m + place.width_m / 2.0;
            let arc = OuterArc { start_m: bend.start_m, radius_m, turn_rad: bend.turn_rad };
            if let Some(arc) = self.ahead.arc(&arc, place.width_m) {
                bend = Bend::within(&arc, place.width_m);
                self.phase = Phase::Entering(Passage::Bend(bend));
            }
        }
        Passage::Bend(bend)
    }

    /// The same duct, the other way.
    fn turned_round(&mut self, place: &DuctPlace) -> Entered {
        self.before_m += self.along_m;
        self.log.turned_round(self.along_m, place.width_m);
        self.along_m = 0.0;
        self.phase = Phase::Along;
        self.planned = None;
        self.passing = [None; 2];
        self.trail.clear();
        self.ahead.enter();
        Entered {
            lateral_m: [-place.lateral_m, LATERAL_DOUBT_M],
            heading_rad: [place.heading_rad - PI.copysign(place.heading_rad), TURN_DOUBT * PI],
            width_m: [place.width_m, WIDTH_DOUBT_M],
        }
    }

    /// From the entry's coordinates to the exit's.
    fn change_over(&mut self, bend: Passage, pose: [f64; 3]) -> Entered {
        let [along_m, lateral_m, heading_rad] = bend.exit_from_entry(pose);
        let doubt = if matches!(bend, Passage::Bend(bend) if bend.is_arc()) { ARC_DOUBT } else { TURN_DOUBT };
        self.before_m += bend.start_m() + bend.length_m();
        if let Some(duct) = self.log.ducts().last() {
            let is_junction = Itinerary::has_say(self.taken);
            let (first_from_duct, width_m) = (duct.first_from_duct, duct.width_m);
            self.trail.push(Step::Through(Entry { passage: bend, fitting: self.taken, is_junction, first_from_duct, width_m }));
        }
        self.log.left_by(self.taken, &bend, along_m);
        self.along_m = along_m;
        self.phase = Phase::Leaving(bend);
        self.passing = [None; 2];
        self.ahead.enter();
        Entered {
            lateral_m: [lateral_m, LATERAL_DOUBT_M],
            heading_rad: [heading_rad, doubt * bend.turn_rad().abs() + HEADING_DOUBT_RAD],
            width_m: [bend.exit_width_m(), WIDTH_DOUBT_M],
        }
    }
}
