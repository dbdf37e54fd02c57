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

use super::limits::Limits;
use super::target::Target;
use super::{ControlLaw, PathState, Twist};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KohChoParams {
    /// m of C = m alpha_max / (6 v^2): how much of the yaw acceleration the landing curve may need. No unit.
    pub landing: f64,
    /// Heading error within which steering is linear, in radians.
    pub linear_heading_rad: f64,
    /// Lateral error within which the landing curve's slope is linear, in metres.
    pub linear_lateral_m: f64,
    /// Distance to the target within which the speed law is linear, in metres.
    pub linear_along_m: f64,
}

impl Default for KohChoParams {
    /// Landing, heading and lateral error come out of the study `koh-cho` (`docs/tuning.md`), to three digits.
    fn default() -> Self {
        Self { landing: 0.0126, linear_heading_rad: 38.7_f64.to_radians(), linear_lateral_m: 6.91e-3, linear_along_m: 0.05 }
    }
}

/// The law and the motion that it last commanded.
#[derive(Clone, Debug)]
pub struct KohCho {
    params: KohChoParams,
    speed_m_s: f64,
    limits: Limits,
    commanded: Twist,
    target: Target,
}

impl KohCho {
    /// The law at rest, with its target beside the robot; the target will move at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: KohChoParams) -> Self {
        let speed_m_s = limits.speed(speed_m_s);
        Self { params, speed_m_s, limits, commanded: Twist::default(), target: Target::default() }
    }

    /// Angle of the landing curve's tangent against the target's heading, and its derivative by e_y.
    fn landing_angle(&self, e_y: f64) -> (f64, f64) {
        let KohChoParams { landing, linear_lateral_m, .. } = self.params;
        let c = landing * self.limits.max_yaw_acceleration_rad_s2 / (6.0 * self.speed_m_s * self.speed_m_s);
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
        let Self { params, limits, .. } = *self;
        let period = state.period_s;
        self.target.advance(self.speed_m_s * (1.0 - state.slowing), &limits, period);

        let v_t = self.target.speed_m_s;
        let w_t = v_t * state.curvature_1_m;
        let Twist { speed_m_s: v, yaw_rate_rad_s: w } = self.commanded;
        let (e_x, e_y, e_th) = (self.target.travelled_m - state.travelled_m, -state.lateral_m, -state.heading_rad);
        let e_x_rate = v_t - v * libm::cos(e_th) + w_t * e_y;
        let e_y_rate = v * libm::sin(e_th) - w_t * e_x;

        let (landing_angle, derivative) = self.landing_angle(e_y);
        let w_p = w_t + derivative * e_y_rate;
        // th_p - th = (th_p - th_t) + (th_t - th)
        let heading_to_go = landing_angle + e_th;
        let w_s = (w_p - w) + bounded_root(heading_to_go, limits.max_yaw_acceleration_rad_s2, params.linear_heading_rad);
        let v_s = e_x_rate + bounded_root(e_x, limits.max_acceleration_m_s2, params.linear_along_m);
        self.commanded = limits.change(self.commanded, Twist { speed_m_s: v_s, yaw_rate_rad_s: w_s }, period);
        self.commanded
    }

    fn reset(&mut self, travelled_m: f64) {
        self.commanded = Twist::default();
        self.target = Target::at(travelled_m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED_M_S: f64 = 0.3;

    fn law() -> KohCho {
        KohCho::new(SPEED_M_S, Limits::default(), KohChoParams::default())
    }

    #[test]
    fn the_landing_curve_is_the_cubic_and_its_derivative_is_its_own() {
        let law = law();
        let c = law.params.landing * law.limits.max_yaw_acceleration_rad_s2 / (6.0 * SPEED_M_S * SPEED_M_S);
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
        let period_s = 1.0 / 30.0;
        for lateral_m in [-0.05, 0.03] {
            let mut law = law();
            let (angle, derivative) = law.landing_angle(-lateral_m);
            let rate = derivative * SPEED_M_S * libm::sin(-angle);
            law.commanded = Twist { speed_m_s: SPEED_M_S, yaw_rate_rad_s: rate };
            law.target.speed_m_s = SPEED_M_S;
            let state = PathState { lateral_m, heading_rad: angle, period_s, ..PathState::default() };
            let next = law.twist(&state);
            assert!((next.yaw_rate_rad_s - rate).abs() < 1e-9, "{lateral_m}: {} {rate}", next.yaw_rate_rad_s);
        }
    }

    /// On the path and in step with its target, a robot in a bend turns as the target turns; behind it, or beside it, the
    /// errors' rates of a turning frame come in: e_x' = v_t - v cos(e_th) + w_t e_y, e_y' = v sin(e_th) - w_t e_x.
    #[test]
    fn in_a_bend_the_frame_turns_with_the_target() {
        let (period_s, curvature) = (1.0 / 30.0, 1.6);
        let w_t = SPEED_M_S * curvature;
        let step = |lateral_m: f64, ahead_m: f64| {
            let mut law = law();
            law.commanded = Twist { speed_m_s: SPEED_M_S, yaw_rate_rad_s: w_t };
            law.target.speed_m_s = SPEED_M_S;
            law.target.travelled_m = ahead_m - SPEED_M_S * period_s;
            let state = PathState { lateral_m, curvature_1_m: curvature, period_s, ..PathState::default() };
            (law.twist(&state), law)
        };
        let (on_path, _) = step(0.0, 0.0);
        assert!((on_path.speed_m_s - SPEED_M_S).abs() < 1e-12 && (on_path.yaw_rate_rad_s - w_t).abs() < 1e-12);
        // The target 4 mm ahead: e_y' = -w_t e_x, fed forward by the landing curve's derivative.
        let (behind, law) = step(0.0, 0.004);
        let expected = law.landing_angle(0.0).1 * -w_t * 0.004;
        assert!((behind.yaw_rate_rad_s - w_t - expected).abs() < 1e-9, "{behind:?}: {expected}");
        // Two millimetres to the right of the path, e_y = 2 mm: the robot in the outer lane must be faster by w_t e_y.
        let (beside, _) = step(-0.002, 0.0);
        assert!((beside.speed_m_s - SPEED_M_S - w_t * 0.002).abs() < 1e-9, "{beside:?}");
    }
}
