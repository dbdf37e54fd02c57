//! Path tracking after K. C. Koh and H. S. Cho, "A Smooth Path Tracking Algorithm for Wheeled Mobile Robots with Dynamic
//! Constraints", J. Intelligent and Robotic Systems 24:367-385, 1999, the paper's reference 7.
//!
//! A virtual target vehicle moves exactly along the path. The robot lands on the target's tangent along the cubic |e_y| = C x^3,
//! with both its accelerations bounded by what the wheels can do. Errors are the target's pose less the robot's, in the
//! target's frame: e_x ahead, e_y to the left, e_th = th_t - th.
//!
//! As printed the law has unbounded gain at e_y = 0, and with a frame of latency and wheels that lag it never settles. What
//! differs here, and why it holds (the errors handed in are already advanced to the time of actuation):
//!
//! - inside |th_p - th| < [`KohChoParams::linear_heading_rad`] the square root of the steering law is a straight line;
//! - inside |e_y| < [`KohChoParams::linear_lateral_m`] the slope of the landing curve is linear in e_y;
//! - likewise inside |e_x| < [`KohChoParams::linear_along_m`] in the speed law;
//! - both accelerations integrate the last *commanded* motion, not the measured one;
//! - the target starts from rest with the robot, so that e_x starts at zero.

use super::{ControlLaw, PathState, Twist};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KohChoParams {
    /// Speed of the target along the path, in m/s.
    pub speed_m_s: f64,
    /// m of C = m alpha_max / (6 v^2): how much of the yaw acceleration the landing curve may need. No unit.
    pub landing: f64,
    /// Largest yaw acceleration alpha_max, in rad/s2.
    pub max_yaw_acceleration_rad_s2: f64,
    /// Largest forward acceleration a_max, in m/s2.
    pub max_acceleration_m_s2: f64,
    /// Largest acceleration of a wheel's rim, in m/s2: |a| + W_eff / 2 |alpha| stays within it.
    pub max_wheel_acceleration_m_s2: f64,
    /// Effective track W_eff = chi W, in metres.
    pub effective_track_m: f64,
    /// Heading error within which steering is linear, in radians.
    pub linear_heading_rad: f64,
    /// Lateral error within which the landing curve's slope is linear, in metres.
    pub linear_lateral_m: f64,
    /// Distance to the target within which the speed law is linear, in metres.
    pub linear_along_m: f64,
}

impl Default for KohChoParams {
    fn default() -> Self {
        Self {
            speed_m_s: 0.3,
            landing: 0.02,
            max_yaw_acceleration_rad_s2: 2.0,
            max_acceleration_m_s2: 0.5,
            max_wheel_acceleration_m_s2: 1.0,
            effective_track_m: 0.325,
            linear_heading_rad: 0.2,
            linear_lateral_m: 0.010,
            linear_along_m: 0.05,
        }
    }
}

/// The law and the motion that it last commanded.
#[derive(Clone, Debug)]
pub struct KohCho {
    params: KohChoParams,
    commanded: Twist,
    target_speed_m_s: f64,
    target_travelled_m: f64,
}

impl KohCho {
    /// The law at rest, with its target beside the robot.
    pub fn new(params: KohChoParams) -> Self {
        Self { params, commanded: Twist::default(), target_speed_m_s: 0.0, target_travelled_m: 0.0 }
    }

    /// Angle of the landing curve's tangent against the target's heading, and its derivative by e_y.
    fn landing_angle(&self, e_y: f64) -> (f64, f64) {
        let KohChoParams { landing, max_yaw_acceleration_rad_s2, speed_m_s, linear_lateral_m, .. } = self.params;
        let c = landing * max_yaw_acceleration_rad_s2 / (6.0 * speed_m_s * speed_m_s);
        // |e_y| = C x^3, so the slope 3 C x^2 is 3 C (|e_y| / C)^(2/3).
        let slope_at = |e: f64| {
            let x = libm::cbrt(e / c);
            3.0 * c * x * x
        };
        let distance = e_y.abs();
        let (slope, derivative) = if distance < linear_lateral_m {
            let gain = slope_at(linear_lateral_m) / linear_lateral_m;
            (gain * distance, gain)
        } else {
            (slope_at(distance), 2.0 / libm::cbrt(distance / c))
        };
        (libm::atan(slope).copysign(e_y), derivative / (1.0 + slope * slope))
    }
}

/// sqrt(2 limit |error|) with the error's sign; a straight line where |error| is below `linear`.
fn bounded_root(error: f64, limit: f64, linear: f64) -> f64 {
    if error.abs() < linear { (2.0 * limit / linear).sqrt() * error } else { (2.0 * limit * error.abs()).sqrt().copysign(error) }
}

impl ControlLaw for KohCho {
    fn twist(&mut self, state: &PathState) -> Twist {
        let params = self.params;
        let period = state.period_s;
        // The target accelerates half as hard as the robot may, so that the robot can catch up with it.
        let step = 0.5 * params.max_acceleration_m_s2 * period;
        let target_before = self.target_speed_m_s;
        self.target_speed_m_s = params.speed_m_s.min(target_before + step);
        self.target_travelled_m += 0.5 * (target_before + self.target_speed_m_s) * period;

        let v_t = self.target_speed_m_s;
        let w_t = v_t * state.curvature_1_m;
        let Twist { speed_m_s: v, yaw_rate_rad_s: w } = self.commanded;
        let (e_x, e_y, e_th) = (self.target_travelled_m - state.travelled_m, -state.lateral_m, -state.heading_rad);
        let e_x_rate = v_t - v * libm::cos(e_th) + w_t * e_y;
        let e_y_rate = v * libm::sin(e_th) - w_t * e_x;

        let (landing_angle, derivative) = self.landing_angle(e_y);
        let w_p = w_t + derivative * e_y_rate;
        // th_p - th = (th_p - th_t) + (th_t - th)
        let heading_to_go = landing_angle + e_th;
        let w_s = (w_p - w) + bounded_root(heading_to_go, params.max_yaw_acceleration_rad_s2, params.linear_heading_rad);
        let half_track_m = params.effective_track_m / 2.0;
        let alpha_max = params.max_yaw_acceleration_rad_s2.min(params.max_wheel_acceleration_m_s2 / half_track_m);
        let alpha = (w_s / period).clamp(-alpha_max, alpha_max);

        let v_s = e_x_rate + bounded_root(e_x, params.max_acceleration_m_s2, params.linear_along_m);
        // Steering first: what the wheels have left goes to the speed.
        let left_over = (params.max_wheel_acceleration_m_s2 - half_track_m * alpha.abs()).max(0.0);
        let a_max = params.max_acceleration_m_s2.min(left_over);
        let a = (v_s / period).clamp(-a_max, a_max);

        self.commanded = Twist { speed_m_s: v + a * period, yaw_rate_rad_s: w + alpha * period };
        self.commanded
    }

    fn reset(&mut self, travelled_m: f64) {
        self.commanded = Twist::default();
        self.target_speed_m_s = 0.0;
        self.target_travelled_m = travelled_m;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_landing_curve_is_the_cubic_and_its_derivative_is_its_own() {
        let params = KohChoParams::default();
        let law = KohCho::new(params);
        let c = params.landing * params.max_yaw_acceleration_rad_s2 / (6.0 * params.speed_m_s * params.speed_m_s);
        for e_y in [-0.08, -0.02, 0.015, 0.06] {
            // On |e_y| = C x^3 the slope is 3 C x^2.
            let x = libm::cbrt(f64::abs(e_y) / c);
            let (angle, _) = law.landing_angle(e_y);
            assert!((libm::tan(angle) - (3.0 * c * x * x).copysign(e_y)).abs() < 1e-12, "{e_y}");
        }
        for e_y in [-0.08, -0.02, -0.004, 0.003, 0.015, 0.06] {
            let step = 1e-6;
            let slope = (law.landing_angle(e_y + step).0 - law.landing_angle(e_y - step).0) / (2.0 * step);
            let (_, derivative) = law.landing_angle(e_y);
            assert!((slope - derivative).abs() < 1e-4 * derivative, "{e_y}: {slope} {derivative}");
        }
    }

    /// A robot that moves along the landing curve, at the curve's own turn rate, is left to go on: the feed-forward holds it there.
    #[test]
    fn on_the_landing_curve_nothing_is_corrected() {
        let params = KohChoParams::default();
        let period_s = 1.0 / 30.0;
        for lateral_m in [-0.05, 0.03] {
            let mut law = KohCho::new(params);
            let (angle, derivative) = law.landing_angle(-lateral_m);
            let rate = derivative * params.speed_m_s * libm::sin(-angle);
            law.commanded = Twist { speed_m_s: params.speed_m_s, yaw_rate_rad_s: rate };
            law.target_speed_m_s = params.speed_m_s;
            let state = PathState { lateral_m, heading_rad: angle, period_s, ..PathState::default() };
            let next = law.twist(&state);
            assert!((next.yaw_rate_rad_s - rate).abs() < 1e-9, "{lateral_m}: {} {rate}", next.yaw_rate_rad_s);
        }
    }

    /// On the path and in step with its target, a robot in a bend turns as the target turns; behind it, or beside it, the
    /// errors' rates of a turning frame come in: e_x' = v_t - v cos(e_th) + w_t e_y, e_y' = v sin(e_th) - w_t e_x.
    #[test]
    fn in_a_bend_the_frame_turns_with_the_target() {
        let params = KohChoParams::default();
        let (period_s, curvature) = (1.0 / 30.0, 1.6);
        let w_t = params.speed_m_s * curvature;
        let step = |lateral_m: f64, ahead_m: f64| {
            let mut law = KohCho::new(params);
            law.commanded = Twist { speed_m_s: params.speed_m_s, yaw_rate_rad_s: w_t };
            law.target_speed_m_s = params.speed_m_s;
            law.target_travelled_m = ahead_m - params.speed_m_s * period_s;
            let state = PathState { lateral_m, curvature_1_m: curvature, period_s, ..PathState::default() };
            (law.twist(&state), law)
        };
        let (on_path, _) = step(0.0, 0.0);
        assert!((on_path.speed_m_s - params.speed_m_s).abs() < 1e-12 && (on_path.yaw_rate_rad_s - w_t).abs() < 1e-12);
        // The target 4 mm ahead: e_y' = -w_t e_x, fed forward by the landing curve's derivative.
        let (behind, law) = step(0.0, 0.004);
        let expected = law.landing_angle(0.0).1 * -w_t * 0.004;
        assert!((behind.yaw_rate_rad_s - w_t - expected).abs() < 1e-9, "{behind:?}: {expected}");
        // Two millimetres to the right of the path, e_y = 2 mm: the robot in the outer lane must be faster by w_t e_y.
        let (beside, _) = step(-0.002, 0.0);
        assert!((beside.speed_m_s - params.speed_m_s - w_t * 0.002).abs() < 1e-9, "{beside:?}");
    }
}
