//! Samson's path following in chained form: A. Micaelli and C. Samson, "Trajectory Tracking for Unicycle-Type and
//! Two-Steering-Wheels Mobile Robots", INRIA report 2097, 1993; C. Samson, "Control of Chained Systems", IEEE Transactions on
//! Automatic Control 40(1):64-77, 1995, section III.
//!
//! With d and th relative to a path of curvature c, z_1 = s, z_2 = d, z_3 = (1 - c d) tan th: z_1' = u_1, z_2' = u_1 z_3,
//! z_3' = u_2, exactly, also at large angles. u_2 = -k_2 u_1 z_2 - k_3 |u_1| z_3 makes d obey d'' + k_3 d' + k_2 d = 0 *along the
//! path*, whatever the speed: the same trace at any speed. Back in the robot's terms, with s' = v cos th / (1 - c d):
//! w = c s' + cos^2 th / (1 - c d) (u_2 + c v sin th tan th), where the change of c along the path is left out: it is not told.

use super::cruise::Cruise;
use super::limits::Limits;
use super::{ControlLaw, PathState, Twist, lane_factor};

/// Beyond this angle to the path tan th is taken at it: at a right angle the chained form ends.
const STEEPEST_RAD: f64 = 1.2;

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamsonParams {
    /// k_2, in 1/m2.
    pub lateral_gain_1_m2: f64,
    /// k_3, in 1/m. Critical damping at k_3^2 = 4 k_2.
    pub heading_gain_1_m: f64,
}

impl Default for SamsonParams {
    fn default() -> Self {
        Self { lateral_gain_1_m2: 25.0, heading_gain_1_m: 10.0 }
    }
}

/// The law and what it holds.
#[derive(Clone, Debug)]
pub struct Samson {
    params: SamsonParams,
    cruise: Cruise,
}

impl Samson {
    /// The law at rest, to drive at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: SamsonParams) -> Self {
        Self { params, cruise: Cruise::new(speed_m_s, limits) }
    }

    /// The yaw rate that it demands at a forward speed, in rad/s.
    fn yaw_rate(&self, state: &PathState, v: f64) -> f64 {
        let PathState { lateral_m: d, curvature_1_m: c, .. } = *state;
        let th = state.heading_rad.clamp(-STEEPEST_RAD, STEEPEST_RAD);
        let (sin, cos) = libm::sincos(th);
        let (tan, lane) = (sin / cos, lane_factor(c, d));
        let u_1 = v * cos / lane;
        let z_3 = lane * tan;
        let u_2 = -self.params.lateral_gain_1_m2 * u_1 * d - self.params.heading_gain_1_m * u_1.abs() * z_3;
        // z_3' = -c d' tan th + (1 - c d) th' / cos^2 th with d' = v sin th, solved for th'; then w = th' + c s'.
        c * u_1 + cos * cos / lane * (u_2 + c * v * sin * tan)
    }
}

impl ControlLaw for Samson {
    fn twist(&mut self, state: &PathState) -> Twist {
        self.cruise.steer(self.yaw_rate(state, self.cruise.commanded.speed_m_s), state)
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.cruise.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along the path d is the solution of d'' + k_3 d' + k_2 d = 0 to the step's accuracy: at critical damping with p^2 = k_2,
    /// d = (d_0 + (d_0' + p d_0) s) exp(-p s), where d' = (1 - c d) tan th. On a straight and in both kinds of bend.
    #[test]
    fn along_the_path_the_error_is_that_of_the_linear_system() {
        let law = Samson::new(0.3, Limits::default(), SamsonParams::default());
        for c in [0.0, 0.8, -0.8] {
            let (mut d, mut th, mut s) = (0.06_f64, 0.6_f64, 0.0_f64);
            let slope = (1.0 - c * d) * libm::tan(th);
            let p = 5.0;
            let solution = |s: f64| (0.06 + (slope + p * 0.06) * s) * libm::exp(-p * s);
            let step_s = 1e-4;
            for _ in 0..40_000 {
                let w = law.yaw_rate(&PathState { lateral_m: d, heading_rad: th, curvature_1_m: c, ..PathState::default() }, 0.3);
                let along = 0.3 * libm::cos(th) / (1.0 - c * d);
                (d, th, s) = (d + 0.3 * libm::sin(th) * step_s, th + (w - c * along) * step_s, s + along * step_s);
                // Euler's error at this step: 0.3e-4 m a step times p and the slope stays below 0.01 mm.
                assert!((d - solution(s)).abs() < 2e-5, "c {c}, s {s}: {d} {}", solution(s));
            }
        }
    }
}
