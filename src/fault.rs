//! What goes wrong on purpose: faults stand between the body and its navigator, like wrappers around their interface.

use ductloop_nav::messages::Sides;
use ductloop_sensor::renderer::View;

use crate::scenario::{Fault, FaultKind, Scenario};

/// The faults of a scenario.
#[derive(Clone, Debug)]
pub struct Faults(Vec<Fault>);

/// The faults at work at one time.
#[derive(Clone, Copy, Debug)]
pub struct ActiveFaults<'a> {
    all: &'a [Fault],
    bits: u32,
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
        ActiveFaults { all: &self.0, bits }
    }
}

impl ActiveFaults<'_> {
    /// Bit i is set if fault i of the scenario is at work.
    pub fn bits(&self) -> u32 {
        self.bits
    }

    fn kinds(&self) -> impl Iterator<Item = FaultKind> + '_ {
        self.all.iter().enumerate().filter(|(i, _)| self.bits >> i & 1 == 1).map(|(_, fault)| fault.kind)
    }

    /// Takes away the light that faults take away.
    pub fn dim(&self, view: &mut View) {
        for kind in self.kinds() {
            match kind {
                FaultKind::LaserOff { laser } => view.laser_power[laser] = 0.0,
                FaultKind::FrameBlank => {
                    view.laser_power.fill(0.0);
                    view.headlamp_power = 0.0;
                }
                FaultKind::WheelsSwapped | FaultKind::LinkLost => {}
            }
        }
    }

    /// Whether commands reach wheel and mount controller.
    pub fn link_is_up(&self) -> bool {
        !self.kinds().any(|kind| kind == FaultKind::LinkLost)
    }

    /// The wheel speeds that reach the wheel controller.
    pub fn wheel_speeds(&self, commanded: Sides) -> Sides {
        let swapped = self.kinds().any(|kind| kind == FaultKind::WheelsSwapped);
        if swapped { Sides { left: commanded.right, right: commanded.left } } else { commanded }
    }
}
