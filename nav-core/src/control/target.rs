//! A target that moves along the path ahead of the robot, from rest: what Koh and Cho's law and Kanayama's follow.

use super::limits::Limits;

/// The target: its speed, and how far along the path it is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Target {
    pub(super) speed_m_s: f64,
    pub(super) travelled_m: f64,
}

impl Target {
    /// At rest beside a robot that has travelled so far.
    pub(super) fn at(travelled_m: f64) -> Self {
        Self { speed_m_s: 0.0, travelled_m }
    }

    /// Moves on towards `speed_m_s`: it accelerates and brakes half as hard as the robot may, so that the robot can catch up with it.
    pub(super) fn advance(&mut self, speed_m_s: f64, limits: &Limits, period_s: f64) {
        let step = 0.5 * limits.max_acceleration_m_s2 * period_s;
        let before = self.speed_m_s;
        self.speed_m_s = speed_m_s.clamp(before - step, before + step);
        self.travelled_m += 0.5 * (before + self.speed_m_s) * period_s;
    }
}
