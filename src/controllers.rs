//! The controllers on the robot's body, wheels (WC) and mount (MC), and the links over which they are commanded.

use ductloop_nav::messages::{Command, Counts, MountSweep, Sides, Tick};
use ductloop_nav::mount_controller::{MountController, MountParams};
use ductloop_nav::rig::MountAngles;
use ductloop_nav::wheel_controller::board::{BoardParams, WheelBoard};
use ductloop_nav::wheel_controller::scaling::ScalingError;
use ductloop_nav::wheel_controller::silence::Hearing;
use ductloop_sim::world::World;

use crate::link::{Channel, Link, LinkCounts};
use crate::record::BodyRecord;
use crate::scenario::Scenario;

/// Wheel and mount controller, each behind its link.
pub(crate) struct Controllers {
    wheels: WheelBoard,
    mount: MountController,
    /// The mount controller's standing order, where a command does not say how to swing.
    sweep: Option<MountSweep>,
    to_wheels: Link<Sides>,
    to_mount: Link<(MountAngles, Option<MountSweep>)>,
    ticks_per_wheel_control: Tick,
    duty: Sides,
}

impl Controllers {
    pub(crate) fn new(scenario: &Scenario) -> Result<Self, ScalingError> {
        let ticks_per_s = f64::from(scenario.rates.physics_hz);
        let (params, seed) = (scenario.link, scenario.seed);
        Ok(Self {
            wheels: WheelBoard::new(&scenario.wheel_board())?,
            mount: MountController::new(scenario.mount_params(), scenario.rig.mount.rest),
            sweep: scenario.mount_control.standing_sweep(),
            to_wheels: Link::new(params, Channel::Wheels, seed, ticks_per_s),
            to_mount: Link::new(params, Channel::Mount, seed, ticks_per_s),
            ticks_per_wheel_control: scenario.rates.ticks_per_wheel_control(),
            duty: Sides::default(),
        })
    }

    /// Sends a command: these wheel speeds, and the mount's part of it. With the link down it is lost.
    pub(crate) fn send(&mut self, tick: Tick, wheel_speed_rad_s: Sides, command: &Command, is_up: bool) {
        self.to_wheels.send(tick, wheel_speed_rad_s, is_up);
        self.to_mount.send(tick, (command.mount, command.sweep.or(self.sweep)), is_up);
    }

    /// Lets both act on what has reached them by this tick: points the mount, returns the duty of each motor. The
    /// encoders read `counts`.
    pub(crate) fn tick(&mut self, world: &mut World, counts: Counts) -> Sides {
        let tick = world.tick();
        if let Some(wheel_speed_rad_s) = self.to_wheels.receive(tick) {
            self.wheels.command(wheel_speed_rad_s);
        }
        if let Some((about, sweep)) = self.to_mount.receive(tick) {
            self.mount.command(about, sweep);
        }
        if tick.is_multiple_of(self.ticks_per_wheel_control) {
            self.duty = self.wheels.tick(counts);
        }
        world.point_mount(self.mount.tick());
        self.duty
    }

    /// Whether the wheel controller has brought the wheels down of its own: for want of commands, or because one does not follow.
    pub(crate) fn are_down(&self) -> bool {
        matches!(self.wheels.hearing(), Hearing::Down | Hearing::CutOff)
    }

    /// What the frame log says of them. `mount` is where the camera truly points.
    pub(crate) fn record(&self, mount: MountAngles) -> BodyRecord {
        let (wheels, of_mount) = (self.to_wheels.counts(), self.to_mount.counts());
        let link = LinkCounts { lost: wheels.lost + of_mount.lost, dropped: wheels.dropped + of_mount.dropped };
        BodyRecord { hearing: self.wheels.hearing(), duty: self.duty, mount, link }
    }
}

impl Scenario {
    /// What the wheel controller is made with.
    pub fn wheel_board(&self) -> BoardParams {
        let control = &self.wheel_control;
        BoardParams {
            arithmetic: control.arithmetic,
            gains: self.wheel_gains(),
            limits: self.wheel_limits(),
            period_s: 1.0 / f64::from(self.rates.wheel_control_hz),
            counts_per_wheel_turn: self.robot.drive.counts_per_wheel_turn(),
            pwm_bits: control.pwm_bits,
            silence_s: control.silence_s,
            ramp_rad_s2: control.ramp_m_s2 / self.robot.wheel_radius_m,
            follow_s: control.follow_s,
        }
    }

    /// What the mount controller is made with.
    pub fn mount_params(&self) -> MountParams {
        MountParams {
            period_s: 1.0 / f64::from(self.rates.physics_hz),
            rate_rad_s: self.robot.mount_rate_rad_s,
            acceleration_rad_s2: self.mount_control.acceleration_rad_s2,
        }
    }
}
