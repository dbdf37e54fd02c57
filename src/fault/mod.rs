//! What goes wrong on purpose: faults stand between the body and its controllers, like wrappers around their interface.
//!
//! - here: which faults are at work, and what they do to light, commands and the body;
//! - [`camera`]: frames that are dropped, repeated or late, dirt on the lens, a gain that drifts;
//! - [`encoder`]: counts that are lost, an encoder that is stuck.
//!
//! Everything random is a function of (seed, fault, frame or tick), so that the same seed makes the same faults.

pub mod camera;
pub mod encoder;

use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sensor::renderer::View;
use ductloop_sim::disturbance::{Disturbance, Push, PushFrame};
use nalgebra::Vector3;

use crate::scenario::{Fault, FaultKind, Scenario, Side};

/// The faults of a scenario.
#[derive(Clone, Debug)]
pub struct Faults(Vec<Fault>);

/// The faults at work at one time.
#[derive(Clone, Copy, Debug)]
pub struct ActiveFaults<'a> {
    all: &'a [Fault],
    bits: u32,
    time_s: f64,
}

/// A fault at work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveFault {
    /// Its index in the scenario: the stream of its random numbers.
    pub index: usize,
    /// What it is.
    pub kind: FaultKind,
    /// For how long it has been at work, in seconds.
    pub since_s: f64,
}

impl Faults {
    /// Those of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        Self(scenario.faults.clone())
    }

    /// Those at work at `time_s`.
    pub fn at(&self, time_s: f64) -> ActiveFaults<'_> {
        let works = |fault: &Fault| time_s >= fault.at_s && fault.for_s.is_none_or(|length| time_s < fault.at_s + length);
        let bits = self.0.iter().enumerate().take(32).map(|(i, fault)| u32::from(works(fault)) << i).sum();
        ActiveFaults { all: &self.0, bits, time_s }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl ActiveFaults<'_> {
    /// Bit i is set if fault i of the scenario is at work.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    /// They, in the order of the scenario.
    pub fn iter(&self) -> impl Iterator<Item = ActiveFault> + '_ {
        let at_work = self.all.iter().enumerate().filter(|(index, _)| self.bits >> index & 1 == 1);
        at_work.map(|(index, fault)| ActiveFault { index, kind: fault.kind, since_s: self.time_s - fault.at_s })
    }

    /// Takes away the light that faults take away.
    pub fn dim(&self, view: &mut View) {
        for fault in self.iter() {
            match fault.kind {
                FaultKind::LaserOff { laser } => view.laser_power[laser] = 0.0,
                FaultKind::LaserDim { laser, share } => view.laser_power[laser] *= share,
                FaultKind::FrameBlank => {
                    view.laser_power.fill(0.0);
                    view.headlamp_power = 0.0;
                }
                _ => {}
            }
        }
    }

    /// Whether commands reach wheel and mount controller.
    pub fn link_is_up(&self) -> bool {
        !self.iter().any(|fault| fault.kind == FaultKind::LinkLost)
    }

    /// The wheel speeds that are sent to the wheel controller.
    pub fn wheel_speeds(&self, commanded: Sides) -> Sides {
        let swapped = self.iter().any(|fault| fault.kind == FaultKind::WheelsSwapped);
        if swapped { Sides { left: commanded.right, right: commanded.left } } else { commanded }
    }

    /// The mount's angles as they are read.
    pub fn mount_read(&self, mount: MountAngles) -> MountAngles {
        self.iter().fold(mount, |mount, fault| match fault.kind {
            FaultKind::PanMisread { by_rad } => MountAngles { pan_rad: mount.pan_rad + by_rad, ..mount },
            _ => mount,
        })
    }

    /// What they do to the body.
    pub fn disturbance(&self) -> Disturbance {
        let mut body = Disturbance::default();
        for fault in self.iter() {
            match fault.kind {
                FaultKind::MotorWeak { side, share } => *motor(&mut body, side) *= share,
                FaultKind::MotorDead { side } => *motor(&mut body, side) = 0.0,
                FaultKind::WheelSlips { wheel, share } => body.grip_scale[wheel as usize] *= share,
                FaultKind::Push { force_n: [forward, left] } => {
                    let before = body.push.map_or(Vector3::zeros(), |push| push.force_n);
                    let force_n = before + Vector3::new(forward, left, 0.0);
                    body.push = Some(Push { force_n, frame: PushFrame::Base });
                }
                _ => {}
            }
        }
        body
    }
}

fn motor(body: &mut Disturbance, side: Side) -> &mut f64 {
    match side {
        Side::Left => &mut body.motor_strength.left,
        Side::Right => &mut body.motor_strength.right,
    }
}

/// The value of a side.
fn side_of<T>(pair: &mut [T; 2], side: Side) -> &mut T {
    &mut pair[side as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Wheel;

    fn faults(kinds: &[FaultKind]) -> Faults {
        Faults(kinds.iter().map(|kind| Fault { at_s: 1.0, for_s: Some(0.5), kind: *kind }).collect())
    }

    #[test]
    fn a_fault_is_at_work_from_its_beginning_to_before_its_end() {
        let faults = faults(&[FaultKind::LinkLost]);
        let is_up = |time_s: f64| faults.at(time_s).link_is_up();
        assert_eq!([0.99, 1.0, 1.49, 1.5].map(is_up), [true, false, false, true]);
    }

    #[test]
    fn what_is_wrong_with_the_body_adds_up() {
        let left = Side::Left;
        let body = faults(&[
            FaultKind::MotorWeak { side: left, share: 0.5 },
            FaultKind::MotorWeak { side: left, share: 0.5 },
            FaultKind::MotorDead { side: Side::Right },
            FaultKind::WheelSlips { wheel: Wheel::RearLeft, share: 0.3 },
            FaultKind::Push { force_n: [2.0, -1.0] },
            FaultKind::Push { force_n: [1.0, 0.0] },
        ]);
        let disturbance = body.at(1.0).disturbance();
        assert_eq!(disturbance.motor_strength, Sides { left: 0.25, right: 0.0 });
        assert_eq!(disturbance.grip_scale, [1.0, 0.3, 1.0, 1.0]);
        assert_eq!(disturbance.push.map(|push| push.force_n), Some(Vector3::new(3.0, -1.0, 0.0)));
        assert_eq!(body.at(2.0).disturbance(), Disturbance::default());
    }

    #[test]
    fn the_pan_is_read_with_its_error() {
        let mount = MountAngles { pan_rad: -0.1, tilt_rad: 0.2 };
        let read = faults(&[FaultKind::PanMisread { by_rad: 0.03 }]).at(1.0).mount_read(mount);
        assert!((read.pan_rad + 0.07).abs() < 1e-15 && read.tilt_rad == 0.2);
    }
}
