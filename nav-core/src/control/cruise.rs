//! One speed held and a yaw rate chosen, within the limits: what the laws without a moving target have in common.

use super::limits::Limits;
use super::{PathState, Twist};

/// The speed to hold, the limits, and the motion that was last commanded.
#[derive(Clone, Debug)]
pub(super) struct Cruise {
    pub(super) speed_m_s: f64,
    limits: Limits,
    pub(super) commanded: Twist,
}

impl Cruise {
    /// At rest, to drive at `speed_m_s`.
    pub(super) fn new(speed_m_s: f64, limits: Limits) -> Self {
        Self { speed_m_s: limits.speed(speed_m_s), limits, commanded: Twist::default() }
    }

    /// What to command next, if this yaw rate is wanted there.
    pub(super) fn steer(&mut self, yaw_rate_rad_s: f64, state: &PathState) -> Twist {
        let wanted = Twist { speed_m_s: self.speed_m_s * (1.0 - state.slowing), yaw_rate_rad_s };
        self.commanded = self.limits.approach(self.commanded, wanted, state.period_s);
        self.commanded
    }

    /// It stands, and starts anew.
    pub(super) fn stop(&mut self) {
        self.commanded = Twist::default();
    }
}
