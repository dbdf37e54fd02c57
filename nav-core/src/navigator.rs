//! The command controller (CC): frame by frame, from what the camera sees to wheel speeds.
//!
//! A frame's command takes effect one frame period after its exposure. So the errors measured in it are advanced to that time:
//! by the encoders up to the exposure, by the commanded wheel speeds and their lag from there on.

use crate::control::{ControlLaw, PathState};
use crate::exposure::AutoExposure;
use crate::messages::{Command, Counts, Frame, Sides, Tick};
use crate::odometry::{DriveModel, advance};
use crate::perception::{Measurement, Perception, Stages};
use crate::rig::MountAngles;

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
    /// The last frame did not; it goes on by its wheels.
    Coasting,
    /// It has seen nothing for too long and stands.
    Stopped,
}

/// What a navigator made of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report<'a> {
    /// How sure it is.
    pub state: State,
    /// What the frame said of where the robot stood at the exposure.
    pub measurement: Measurement,
    /// What the stages of its perception made of it.
    pub stages: Stages<'a>,
}

/// Parameters of [`DuctNavigator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigatorParams {
    /// Physics ticks in a second.
    pub ticks_per_s: f64,
    /// Ticks from one frame to the next.
    pub ticks_per_frame: u64,
    /// What is known of the drive.
    pub drive: DriveModel,
    /// Longest time without sight of a wall before the robot stops, in seconds.
    pub coast_s: f64,
    /// Where the mount is to point.
    pub mount: MountAngles,
}

/// Follows the middle of a duct by what a perception sees and a control law demands.
#[derive(Debug)]
pub struct DuctNavigator<P, L> {
    params: NavigatorParams,
    perception: P,
    law: L,
    auto_exposure: Option<AutoExposure>,
    lateral_m: f64,
    heading_rad: f64,
    travelled_m: f64,
    last: Option<(Counts, Tick)>,
    /// The command that takes effect at the exposure of the frame being read.
    commanded: Sides,
    measurement: Measurement,
    state: State,
    unseen_since: Option<Tick>,
}

impl<P: Perception, L: ControlLaw> DuctNavigator<P, L> {
    /// At rest, in the middle of the duct until a frame says otherwise.
    pub fn new(params: NavigatorParams, perception: P, law: L) -> Self {
        Self {
            params,
            perception,
            law,
            auto_exposure: None,
            lateral_m: 0.0,
            heading_rad: 0.0,
            travelled_m: 0.0,
            last: None,
            commanded: Sides::default(),
            measurement: Measurement::default(),
            state: State::Unknown,
            unseen_since: None,
        }
    }

    /// With exposure and laser power chosen frame by frame, instead of left as they are.
    pub fn with_auto_exposure(self, auto_exposure: AutoExposure) -> Self {
        Self { auto_exposure: Some(auto_exposure), ..self }
    }

    /// The perception, to look at its stages.
    pub fn perception(&self) -> &P {
        &self.perception
    }

    /// Carries the errors on to this exposure by the encoders; returns the wheels' speeds.
    fn dead_reckon(&mut self, counts: Counts, tick: Tick) -> Sides {
        let Some((before, then)) = self.last.replace((counts, tick)) else { return Sides::default() };
        if tick <= then {
            return Sides::default();
        }
        let period_s = (tick - then) as f64 / self.params.ticks_per_s;
        let wheels = self.params.drive.wheel_speeds(before, counts, period_s);
        let (lateral, heading, along) = advance(self.lateral_m, self.heading_rad, self.params.drive.twist(wheels), period_s);
        (self.lateral_m, self.heading_rad) = (lateral, heading);
        self.travelled_m += along;
        wheels
    }

    /// Takes over what the frame shows; says how long it has shown nothing.
    fn look(&mut self, frame: &Frame<'_>, mount: MountAngles, tick: Tick) -> f64 {
        self.measurement = self.perception.perceive(frame, mount);
        if let (Some(lateral), Some(heading)) = (self.measurement.lateral_m, self.measurement.heading_rad) {
            (self.lateral_m, self.heading_rad) = (lateral, heading);
            self.unseen_since = None;
            return 0.0;
        }
        let since = *self.unseen_since.get_or_insert(tick);
        (tick - since) as f64 / self.params.ticks_per_s
    }

    /// The errors at the time at which the command takes effect.
    fn at_actuation(&self, wheels: Sides, period_s: f64) -> PathState {
        let drive = &self.params.drive;
        let meanwhile = drive.twist(drive.approach(wheels, self.commanded, period_s));
        let (lateral_m, heading_rad, along) = advance(self.lateral_m, self.heading_rad, meanwhile, period_s);
        let (travelled_m, measured) = (self.travelled_m + along, drive.twist(wheels));
        PathState { lateral_m, heading_rad, curvature_1_m: 0.0, travelled_m, measured, period_s }
    }

    /// Wheels and mount: what to do on what this frame shows.
    fn drive(&mut self, frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command {
        let period_s = self.params.ticks_per_frame as f64 / self.params.ticks_per_s;
        let wheels = self.dead_reckon(counts, tick);
        let unseen_s = self.look(frame, mount, tick);
        let seen = unseen_s == 0.0 && self.unseen_since.is_none();
        // Until the walls were seen once there is nothing to coast on.
        let blind = !seen && (self.state == State::Unknown || unseen_s > self.params.coast_s);
        if blind || (self.state == State::Stopped && !seen) {
            if self.state != State::Unknown {
                self.state = State::Stopped;
            }
            self.law.reset(self.travelled_m);
            self.commanded = Sides::default();
            return Command::stop(self.params.mount);
        }
        self.state = if seen { State::Tracking } else { State::Coasting };
        let twist = self.law.twist(&self.at_actuation(wheels, period_s));
        self.commanded = self.params.drive.wheels(twist);
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
        Report { state: self.state, measurement: self.measurement, stages: self.perception.stages() }
    }
}
