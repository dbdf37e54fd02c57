//! The law of the robot Stanley: G. M. Hoffmann, C. J. Tomlin, M. Montemerlo and S. Thrun, "Autonomous Automobile Trajectory
//! Tracking for Off-Road Driving", American Control Conference 2007, equation 5 with the softening of equation 7:
//! delta = psi + atan(k e / (k_soft + v)).
//!
//! A car's front wheels take that angle at once; a differential drive has a yaw rate instead. So here the angle is a heading to be
//! reached: w = w_r + k_th e_th + k_y atan(k e / (k_soft + v)), and the errors are those of the base, not of a front axle. With
//! k_y = k_th the heading converges to the one that lets e decay at the rate k v / (k_soft + v), whatever the speed. Linearised, it
//! is damped by sqrt(k_th / (4 k)) of the critical damping (k_soft = 0).

use super::cruise::Cruise;
use super::limits::Limits;
use super::{ControlLaw, PathState, Twist, lane_factor};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanleyParams {
    /// k_th: yaw rate for a radian of heading error, in 1/s.
    pub heading_gain_1_s: f64,
    /// k_y: yaw rate for a radian of the angle towards the path, in 1/s.
    pub lateral_gain_1_s: f64,
    /// k: how fast the lateral error is to decay, in 1/s.
    pub decay_1_s: f64,
    /// k_soft, in m/s: keeps the angle small at low speed.
    pub softening_m_s: f64,
}

impl Default for StanleyParams {
    fn default() -> Self {
        Self { heading_gain_1_s: 3.0, lateral_gain_1_s: 3.0, decay_1_s: 0.7, softening_m_s: 0.05 }
    }
}

/// The law and what it holds.
#[derive(Clone, Debug)]
pub struct Stanley {
    params: StanleyParams,
    cruise: Cruise,
}

impl Stanley {
    /// The law at rest, to drive at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: StanleyParams) -> Self {
        Self { params, cruise: Cruise::new(speed_m_s, limits) }
    }
}

impl ControlLaw for Stanley {
    fn twist(&mut self, state: &PathState) -> Twist {
        let StanleyParams { heading_gain_1_s, lateral_gain_1_s, decay_1_s, softening_m_s } = self.params;
        let v = self.cruise.commanded.speed_m_s;
        let (e_y, e_th) = (-state.lateral_m, -state.heading_rad);
        let w_r = v * state.curvature_1_m / lane_factor(state.curvature_1_m, state.lateral_m);
        let towards = libm::atan(decay_1_s * e_y / (softening_m_s + v.abs()).max(1e-6));
        self.cruise.steer(w_r + heading_gain_1_s * e_th + lateral_gain_1_s * towards, state)
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.cruise.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a gain and limits that leave heading no choice, e' = v sin(atan(-k e / v)): the source's closed loop;
    /// near the path its solution is e^(-k t).
    #[test]
    fn near_the_path_the_error_decays_at_k() {
        let wide = Limits {
            max_acceleration_m_s2: 1e9,
            max_yaw_acceleration_rad_s2: 1e9,
            max_wheel_acceleration_m_s2: 1e9,
            ..Limits::default()
        };
        let params = StanleyParams { heading_gain_1_s: 400.0, lateral_gain_1_s: 400.0, decay_1_s: 1.2, softening_m_s: 0.0 };
        let mut law = Stanley::new(0.3, wide, params);
        law.cruise.commanded.speed_m_s = 0.3;
        let period_s = 1e-4;
        let (mut lateral_m, mut heading_rad) = (1e-3, -libm::atan(1.2 * 1e-3 / 0.3));
        for _ in 0..10_000 {
            let twist = law.twist(&PathState { lateral_m, heading_rad, period_s, ..PathState::default() });
            (lateral_m, heading_rad, _) = crate::odometry::advance(lateral_m, heading_rad, twist, period_s);
        }
        // After 1 s. The heading lags by 1/400 s: k 0.0025 of the rate, 0.4 % in all.
        assert!((lateral_m / (1e-3 * libm::exp(-1.2)) - 1.0).abs() < 0.005, "{lateral_m}");
    }
}
