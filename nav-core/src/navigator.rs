//! The command controller (CC): frame by frame, from what the camera sees to wheel speeds.
//!
//! A frame's command takes effect one frame period after its exposure. So the errors at the exposure, as walls and encoders together
//! have them ([`crate::estimation`]), are advanced to that time by the commanded wheel speeds and their lag.

use crate::ahead::{self, DuctPlace, Outlook, Stretch};
use crate::control::limits::Limits;
use crate::control::{ControlLaw, PathState, Twist};
use crate::course::backing::{back, reversed};
use crate::course::{Course, CourseParams, DuctRecord, End};
use crate::estimation::localiser::{Localiser, Sight};
use crate::estimation::{Estimate, Estimator};
use crate::exposure::AutoExposure;
use crate::frozen::FrozenCamera;
use crate::messages::{Command, Counts, Frame, Sides, Tick};
use crate::odometry::DriveModel;
use crate::perception::{Measurement, Perception, Stages};
use crate::rig::MountAngles;
use crate::swapped_wheels::SwappedWheels;

/// The longest way by the wheels alone in which walls are lost and found again, in metres: from where a fitting's walls are out of view
/// through half a circle. Beyond it the robot is lost, or stands against something.
const BY_WHEELS_M: f64 = 4.0;

/// Steers a robot: one call a frame, and nothing else reaches it from the world.
pub trait Navigator: Send {
    /// What to do from the next frame on. `counts` and `mount` were read at the frame's exposure, at `tick`.
    fn on_frame(&mut self, frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command;

    /// What it made of the last frame, for logs and reports; a navigator that tells nothing still navigates.
    fn report(&self) -> Report<'_> {
        Report::default()
    }
}

/// How sure a navigator is of where it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// It says nothing of it.
    #[default]
    Unknown,
    /// The last frame showed where it stands.
    Tracking,
    /// It knows where it stands, but not as well as it should: see [`Reason`].
    Degraded,
    /// The last frame did not show where it stands; it goes on by its wheels.
    Coasting,
    /// It has seen nothing for too long and stands.
    Stopped,
}

/// Why a navigator is in a state other than [`State::Tracking`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// No frame yet has shown a wall.
    NothingSeenYet,
    /// A side wall that was seen earlier in the run is not seen.
    WallLost,
    /// The estimate's own deviation is larger than it should be.
    Uncertain,
    /// The walls appear where they cannot be: the estimator's gate refused them.
    Refused,
    /// The frame shows no side wall.
    NoWall,
    /// The camera gives the same frame again and again.
    FrozenCamera,
    /// Nothing that could be believed was seen for longer than the navigator may coast.
    CoastedTooLong,
    /// Its route ends here.
    RouteEnds,
    /// The duct ends, and the route does not say that it is to turn back.
    DeadEnd,
    /// Something stands in the way.
    Obstacle,
    /// The floor ends.
    Drop,
    /// How the duct goes on cannot be told.
    NoWayKnown,
    /// The way that the route names is not there.
    NoSuchWay,
    /// It is to turn back, and there is no room for that.
    NoRoom,
    /// The wheels turn the robot the other way than they are told: left and right are exchanged.
    WheelsSwapped,
}

impl Reason {
    fn of_end(end: End) -> Self {
        match end {
            End::Route => Self::RouteEnds,
            End::DeadEnd => Self::DeadEnd,
            End::Obstacle => Self::Obstacle,
            End::Drop => Self::Drop,
            End::Unknown => Self::NoWayKnown,
            End::NoSuchWay => Self::NoSuchWay,
            End::NoRoom => Self::NoRoom,
        }
    }
}

/// What a navigator made of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report<'a> {
    /// How sure it is.
    pub state: State,
    /// Why it is not tracking.
    pub reason: Option<Reason>,
    /// What its estimator believes, if it has one.
    pub estimate: Option<Estimate>,
    /// What the frame said of where the robot stood at the exposure.
    pub measurement: Measurement,
    /// What the stages of its perception made of it.
    pub stages: Stages<'a>,
    /// What it sees of the duct ahead.
    pub outlook: Option<Outlook>,
    /// Where it believes the base was at the exposure, in the frame of the duct in which it began: along it from where it began, to the
    /// left of its middle, in metres, and the heading, in radians.
    pub pose: Option<[f64; 3]>,
    /// The ducts that it was in, the present one last.
    pub ducts: &'a [DuctRecord],
    /// Junctions that it took, by its own count.
    pub junctions: u32,
}

/// Parameters of [`DuctNavigator`].
#[derive(Clone, Debug, PartialEq)]
pub struct NavigatorParams {
    /// Physics ticks in a second.
    pub ticks_per_s: f64,
    /// Ticks from one frame to the next.
    pub ticks_per_frame: u64,
    /// What is known of the drive.
    pub drive: DriveModel,
    /// Longest time without sight of a wall before the robot stops, in seconds.
    pub coast_s: f64,
    /// So many frames in a row that are the same as the one before are a frozen camera; `None`: whatever comes is believed.
    pub frozen_frames: Option<u64>,
    /// Where the mount is to point.
    pub mount: MountAngles,
    /// Limits of manoeuvres.
    pub limits: Limits,
    /// Which way to take, and how.
    pub course: CourseParams,
    /// Width of the duct as it is told, in metres: where no filter estimates it.
    pub duct_width_m: f64,
}

/// Follows the middle of a duct by what a perception sees and a control law demands.
#[derive(Debug)]
pub struct DuctNavigator<P, L> {
    params: NavigatorParams,
    perception: P,
    law: L,
    auto_exposure: Option<AutoExposure>,
    localiser: Localiser,
    course: Course,
    /// Where the base was at the last exposure, in the frame of the first duct.
    pose: [f64; 3],
    /// Whether the left and the right wall were ever seen.
    walls_known: [bool; 2],
    last: Option<(Counts, Tick)>,
    /// The command that takes effect at the exposure of the frame being read.
    commanded: Sides,
    /// The motion that it stands for.
    twist: Twist,
    /// Whether the law drives it backwards.
    is_backwards: bool,
    /// The one before, under which the wheels have turned since the frame before.
    obeyed: Sides,
    exchange: SwappedWheels,
    measurement: Measurement,
    state: State,
    reason: Option<Reason>,
    unseen_since: Option<Tick>,
    /// Way of the wheels since walls were used last, in metres.
    by_wheels_m: f64,
    camera: FrozenCamera,
    is_frozen: bool,
}

impl<P: Perception, L: ControlLaw> DuctNavigator<P, L> {
    /// At rest, in the middle of the duct until a frame says otherwise.
    pub fn new(params: NavigatorParams, perception: P, law: L) -> Self {
        Self {
            course: Course::new(params.course.clone()),
            params,
            perception,
            law,
            auto_exposure: None,
            localiser: Localiser::last_seen(),
            pose: [0.0; 3],
            walls_known: [false; 2],
            last: None,
            commanded: Sides::default(),
            twist: Twist::default(),
            is_backwards: false,
            obeyed: Sides::default(),
            exchange: SwappedWheels::default(),
            measurement: Measurement::default(),
            state: State::Unknown,
            reason: None,
            unseen_since: None,
            by_wheels_m: 0.0,
            camera: FrozenCamera::default(),
            is_frozen: false,
        }
    }

    /// With exposure and laser power chosen frame by frame, instead of left as they are.
    pub fn with_auto_exposure(self, auto_exposure: AutoExposure) -> Self {
        Self { auto_exposure: Some(auto_exposure), ..self }
    }

    /// With an estimator that weighs wheels and walls, instead of the last measurement taken for exact.
    pub fn with_estimator(self, estimator: Estimator) -> Self {
        Self { localiser: Localiser::Kalman(Box::new(estimator)), ..self }
    }

    /// The perception, to look at its stages.
    pub fn perception(&self) -> &P {
        &self.perception
    }

    /// Carries the place on to this exposure by the encoders; returns the wheels' speeds, and the time since the frame before.
    fn dead_reckon(&mut self, counts: Counts, tick: Tick) -> (Sides, f64) {
        let frame_s = self.frame_s();
        let Some((before, then)) = self.last else {
            self.last = Some((counts, tick));
            return (Sides::default(), frame_s);
        };
        // A frame exposed before the last reading: the wheels have nothing new to say, its walls belong to an earlier place.
        if tick <= then {
            return (Sides::default(), frame_s);
        }
        self.last = Some((counts, tick));
        let period_s = (tick - then) as f64 / self.params.ticks_per_s;
        let wheels = self.params.drive.wheel_speeds(before, counts, period_s);
        self.exchange.look(self.obeyed, wheels);
        let travel = self.params.drive.travel(wheels, period_s);
        self.by_wheels_m += (travel.left_m.abs() + travel.right_m.abs()) / 2.0;
        self.course.advance(self.localiser.advance(travel, self.params.drive.effective_track_m, tick));
        (wheels, period_s)
    }

    /// Time from one frame to the next, in seconds.
    fn frame_s(&self) -> f64 {
        self.params.ticks_per_frame as f64 / self.params.ticks_per_s
    }

    /// Takes over what the frame shows; says what it was good for, and for how long frames have been good for nothing.
    fn look(&mut self, frame: &Frame<'_>, mount: MountAngles, tick: Tick) -> (Sight, f64) {
        let repeated = self.camera.look(frame);
        self.is_frozen = self.params.frozen_frames.is_some_and(|most| repeated >= most);
        self.measurement = if self.is_frozen { Measurement::default() } else { self.perception.perceive(frame, mount) };
        let before = self.localiser.place();
        let believed = self.course.believes(before.1);
        let sight = match self.course.straight() {
            _ if !believed => Sight::None,
            Some(stretch) if !self.is_frozen => self.look_beside(&stretch, tick),
            _ => self.localiser.look(&self.measurement, tick, self.course.is_near_bend()),
        };
        let now = self.localiser.place();
        self.course.corrected(now.0 - before.0, now.1 - before.1);
        self.look_ahead();
        // In a bend walls are lost and found again: there it may go by its wheels, but not on and on.
        if sight == Sight::Used {
            self.by_wheels_m = 0.0;
        }
        if sight == Sight::Used || (self.course.goes_by_wheels() && self.by_wheels_m < BY_WHEELS_M) {
            self.unseen_since = None;
            return (sight, 0.0);
        }
        let since = *self.unseen_since.get_or_insert(tick);
        (sight, tick.saturating_sub(since) as f64 / self.params.ticks_per_s)
    }

    /// Takes in the walls beside the robot, where they are straight.
    fn look_beside(&mut self, stretch: &Stretch, tick: Tick) -> Sight {
        let walls = ahead::side_walls(self.perception.stages().ranges, &self.place(), stretch);
        walls.map_or(Sight::None, |walls| self.localiser.look_at(&walls, tick, true))
    }

    /// Where the robot is believed to be in its duct.
    fn place(&self) -> DuctPlace {
        let (lateral_m, heading_rad) = self.localiser.place();
        let width_m = self.localiser.estimate().map_or(self.params.duct_width_m, |estimate| estimate.width_m);
        DuctPlace { along_m: self.course.along_m(), lateral_m, heading_rad, width_m }
    }

    /// Looks for what the duct becomes, and changes over to the next duct in the middle of a bend.
    fn look_ahead(&mut self) {
        let place = self.place();
        self.pose = self.course.first_from_base(place.lateral_m, place.heading_rad);
        // State 2 of the filter is the duct's width.
        self.course.measured_width(place.width_m, self.localiser.estimate().map(|estimate| estimate.deviation(2)));
        let ranges = if self.is_frozen { &[] } else { self.perception.stages().ranges };
        if let Some(entered) = self.course.look(&place, ranges) {
            self.localiser.enter(entered.lateral_m, entered.heading_rad, entered.width_m);
        }
    }

    /// How sure it is of its place, and why no surer. Stopped or not is decided already: it goes on.
    fn judge(&mut self, sight: Sight) -> (State, Option<Reason>) {
        let seen = [self.measurement.left.is_some(), self.measurement.right.is_some()];
        let lost = (0..2).any(|side| self.walls_known[side] && !seen[side]);
        if sight == Sight::Used {
            (0..2).for_each(|side| self.walls_known[side] |= seen[side]);
        }
        match sight {
            Sight::None if self.is_frozen => (State::Coasting, Some(Reason::FrozenCamera)),
            Sight::None => (State::Coasting, Some(Reason::NoWall)),
            Sight::Refused => (State::Degraded, Some(Reason::Refused)),
            Sight::Used if lost => (State::Degraded, Some(Reason::WallLost)),
            Sight::Used if self.localiser.is_uncertain() => (State::Degraded, Some(Reason::Uncertain)),
            Sight::Used => (State::Tracking, None),
        }
    }

    /// The motion that follows the path. Before it goes the other way along it the robot stands: the law begins anew.
    fn follow(&mut self, wheels: Sides, period_s: f64) -> Twist {
        let (state, is_backwards) = self.at_actuation(wheels, period_s);
        let state = if is_backwards { reversed(state) } else { state };
        if is_backwards != self.is_backwards {
            self.is_backwards = is_backwards;
            self.law.reset(state.travelled_m);
        }
        let twist = self.law.twist(&state);
        if is_backwards { back(twist) } else { twist }
    }

    /// The errors at the time at which the command takes effect, a frame from now, and whether it is to drive backwards; `period_s` is the
    /// time since the last command.
    fn at_actuation(&self, wheels: Sides, period_s: f64) -> (PathState, bool) {
        let (drive, frame_s) = (&self.params.drive, self.frame_s());
        let meanwhile = drive.travel(drive.approach(wheels, self.commanded, frame_s), frame_s);
        let (lateral_m, heading_rad, along) = self.localiser.foresee(meanwhile, drive.effective_track_m);
        let here = self.course.path(along, lateral_m, heading_rad);
        let state = PathState {
            lateral_m: here.on_path.lateral_m,
            heading_rad: here.on_path.heading_rad,
            curvature_1_m: here.on_path.curvature_1_m,
            slowing: here.slowing,
            travelled_m: here.travelled_m,
            measured: drive.twist(wheels),
            period_s,
        };
        (state, here.is_backwards)
    }

    /// Moves as a manoeuvre asks, within what the wheels can do; the law begins anew after it.
    fn manoeuvre(&mut self, wanted: Twist, period_s: f64) -> Twist {
        self.law.reset(self.course.path(0.0, 0.0, 0.0).travelled_m);
        self.params.limits.approach(self.twist, wanted, period_s)
    }

    /// Stands, for this reason.
    fn stand(&mut self, reason: Reason) -> Command {
        self.reason = Some(reason);
        self.twist = Twist::default();
        self.law.reset(self.course.path(0.0, 0.0, 0.0).travelled_m);
        (self.obeyed, self.commanded) = (self.commanded, Sides::default());
        Command::stop(self.params.mount)
    }

    /// Wheels and mount: what to do on what this frame shows.
    fn drive(&mut self, frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command {
        let (wheels, since_s) = self.dead_reckon(counts, tick);
        // A law goes on by the time that has passed, so that lost frames do not slow it down; but it does not run after a target that
        // has moved on for longer than the robot may coast.
        let period_s = since_s.min(self.params.coast_s.max(self.frame_s()));
        let (sight, unseen_s) = self.look(frame, mount, tick);
        let seen = sight == Sight::Used;
        // Until the walls were seen once there is nothing to coast on.
        let blind = !seen && (self.state == State::Unknown || unseen_s > self.params.coast_s);
        if self.exchange.found() {
            self.state = State::Stopped;
            return self.stand(Reason::WheelsSwapped);
        }
        // Where its route ends it sees no wall beside it, and stands for the reason that it stopped for.
        if let Some(end) = self.course.end()
            && self.twist == Twist::default()
        {
            self.state = State::Stopped;
            return self.stand(Reason::of_end(end));
        }
        if blind || (self.state == State::Stopped && !seen) {
            if self.state == State::Unknown {
                return self.stand(Reason::NothingSeenYet);
            }
            self.state = State::Stopped;
            return self.stand(if self.is_frozen { Reason::FrozenCamera } else { Reason::CoastedTooLong });
        }
        (self.state, self.reason) = self.judge(sight);
        let twist = match self.course.manoeuvre(self.localiser.place().1) {
            Some(wanted) => self.manoeuvre(wanted, period_s),
            None => self.follow(wheels, period_s),
        };
        self.twist = twist;
        let told_m = self.params.drive.effective_track_m;
        let drive = DriveModel { effective_track_m: self.localiser.effective_track_m(told_m), ..self.params.drive };
        (self.obeyed, self.commanded) = (self.commanded, drive.wheels(twist));
        Command { wheel_speed_rad_s: self.commanded, ..Command::stop(self.params.mount) }
    }
}

impl<P: Perception, L: ControlLaw> Navigator for DuctNavigator<P, L> {
    fn on_frame(&mut self, frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command {
        let command = self.drive(frame, counts, mount, tick);
        // Also while it stands: it may be too dark to see anything.
        match self.auto_exposure.as_mut().map(|auto| auto.on_frame(frame)) {
            Some(light) => Command { exposure_s: Some(light.exposure_s), laser_power: Some(light.laser_power), ..command },
            None => command,
        }
    }

    fn report(&self) -> Report<'_> {
        Report {
            state: self.state,
            reason: self.reason,
            estimate: self.localiser.estimate(),
            measurement: self.measurement,
            outlook: Some(*self.course.outlook()),
            pose: Some(self.pose),
            ducts: self.course.log().ducts(),
            junctions: self.course.junctions(),
            stages: if self.is_frozen { Stages::default() } else { self.perception.stages() },
        }
    }
}
