//! Koh and Cho's law as it is printed, kept to compare: K. C. Koh and H. S. Cho, J. Intelligent and Robotic Systems 24:367-385,
//! 1999, sections 3 and 4.
//!
//! Against [`super::koh_cho`], which holds on this robot: the steering law's root and the landing curve's slope are unbounded at
//! zero error, and both accelerations start from the *measured* motion, which lags the commanded one by wheels and latency. Two
//! things are not as printed: at e_y = 0 exactly, where the slope's derivative is infinite, it is left out; and the errors are
//! those at the time of actuation, as for every law here.

use super::limits::Limits;
use super::target::Target;
use super::{ControlLaw, PathState, Twist};

/// The law as printed.
#[derive(Clone, Debug)]
pub struct KohChoPrinted {
    landing: f64,
    speed_m_s: f64,
    limits: Limits,
    target: Target,
}

impl KohChoPrinted {
    /// The law at rest, with its target beside the robot; `landing` is m of C = m alpha_max / (6 v^2), without unit.
    pub fn new(speed_m_s: f64, limits: Limits, landing: f64) -> Self {
        Self { landing, speed_m_s: limits.speed(speed_m_s), limits, target: Target::default() }
    }

    /// Angle of the landing curve's tangent against the target's heading, and its derivative by e_y.
    fn landing_angle(&self, e_y: f64) -> (f64, f64) {
        if e_y == 0.0 {
            return (0.0, 0.0);
        }
        let c = self.landing * self.limits.max_yaw_acceleration_rad_s2 / (6.0 * self.speed_m_s * self.speed_m_s);
        let x = libm::cbrt(e_y.abs() / c);
        let slope = 3.0 * c * x * x;
        (libm::atan(slope).copysign(e_y), 2.0 / x / (1.0 + slope * slope))
    }
}

/// sqrt(2 limit |error|) with the error's sign.
fn root(error: f64, limit: f64) -> f64 {
    (2.0 * limit * error.abs()).sqrt().copysign(error)
}

impl ControlLaw for KohChoPrinted {
    fn twist(&mut self, state: &PathState) -> Twist {
        let limits = self.limits;
        self.target.advance(self.speed_m_s * (1.0 - state.slowing), &limits, state.period_s);
        let v_t = self.target.speed_m_s;
        let w_t = v_t * state.curvature_1_m;
        let Twist { speed_m_s: v, yaw_rate_rad_s: w } = state.measured;
        let (e_x, e_y, e_th) = (self.target.travelled_m - state.travelled_m, -state.lateral_m, -state.heading_rad);
        let e_x_rate = v_t - v * libm::cos(e_th) + w_t * e_y;
        let e_y_rate = v * libm::sin(e_th) - w_t * e_x;
        let (landing_angle, derivative) = self.landing_angle(e_y);
        let w_p = w_t + derivative * e_y_rate;
        let w_s = (w_p - w) + root(landing_angle + e_th, limits.max_yaw_acceleration_rad_s2);
        let v_s = e_x_rate + root(e_x, limits.max_acceleration_m_s2);
        limits.change(state.measured, Twist { speed_m_s: v_s, yaw_rate_rad_s: w_s }, state.period_s)
    }

    fn reset(&mut self, travelled_m: f64) {
        self.target = Target::at(travelled_m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the bounded form is the printed one, outside its straight lines, both demand the same of a robot that moves as it was
    /// told to.
    #[test]
    fn far_from_the_path_it_is_the_bounded_law() {
        use crate::control::koh_cho::{KohCho, KohChoParams};
        // Limits so wide that what is demanded is seen, not where it is cut off.
        let limits = Limits {
            max_wheel_acceleration_m_s2: 1e9,
            max_acceleration_m_s2: 0.5,
            max_yaw_acceleration_rad_s2: 2.0,
            ..Limits::default()
        };
        let params =
            KohChoParams { linear_heading_rad: 1e-9, linear_lateral_m: 1e-9, linear_along_m: 1e-9, ..KohChoParams::default() };
        let state = PathState { lateral_m: 0.05, heading_rad: 0.02, period_s: 1.0 / 30.0, ..PathState::default() };
        let mut bounded = KohCho::new(0.3, limits, params);
        let mut printed = KohChoPrinted::new(0.3, limits, params.landing);
        assert_eq!(bounded.twist(&state), printed.twist(&state));
    }

    /// At rest on the path nothing infinite comes out.
    #[test]
    fn on_the_path_its_output_is_finite() {
        let mut law = KohChoPrinted::new(0.3, Limits::default(), 0.02);
        for lateral_m in [0.0, 1e-300, -1e-12] {
            let twist = law.twist(&PathState { lateral_m, period_s: 1.0 / 30.0, ..PathState::default() });
            assert!(twist.speed_m_s.is_finite() && twist.yaw_rate_rad_s.is_finite(), "{lateral_m}: {twist:?}");
        }
    }
}
