//! Kanayama's law: Y. Kanayama, Y. Kimura, F. Miyazaki and T. Noguchi, "A Stable Tracking Control Method for an Autonomous Mobile
//! Robot", IEEE International Conference on Robotics and Automation 1990, equation 7:
//! v = v_r cos th_e + K_x x_e, w = w_r + v_r (K_y y_e + K_th sin th_e),
//! where (x_e, y_e, th_e) is the target's pose in the robot's frame.
//!
//! With V = (x_e^2 + y_e^2) / 2 + (1 - cos th_e) / K_y the errors obey V' = -K_x x_e^2 - v_r K_th sin^2 th_e / K_y <= 0 (the source's
//! proposition 1). Near the path y_e obeys, along the path, y'' + K_th y' + K_y y = 0: critical damping at K_th^2 = 4 K_y.
//!
//! The target is a distance along the path ahead; between its place and the robot's the path is taken as straight.

use super::limits::Limits;
use super::target::Target;
use super::{ControlLaw, PathState, Twist};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KanayamaParams {
    /// K_x: speed for a metre to the target, in 1/s.
    pub along_gain_1_s: f64,
    /// K_y, in 1/m2.
    pub lateral_gain_1_m2: f64,
    /// K_th, in 1/m.
    pub heading_gain_1_m: f64,
}

impl Default for KanayamaParams {
    fn default() -> Self {
        Self { along_gain_1_s: 2.0, lateral_gain_1_m2: 25.0, heading_gain_1_m: 10.0 }
    }
}

/// The law, its target, and the motion that it last commanded.
#[derive(Clone, Debug)]
pub struct Kanayama {
    params: KanayamaParams,
    speed_m_s: f64,
    limits: Limits,
    commanded: Twist,
    target: Target,
}

impl Kanayama {
    /// The law at rest, with its target beside the robot; the target will move at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: KanayamaParams) -> Self {
        Self { params, speed_m_s: limits.speed(speed_m_s), limits, commanded: Twist::default(), target: Target::default() }
    }

    /// What the source's equation demands at these errors, given in the robot's frame.
    fn demand(&self, (x_e, y_e, th_e): (f64, f64, f64), reference: Twist) -> Twist {
        let KanayamaParams { along_gain_1_s, lateral_gain_1_m2, heading_gain_1_m } = self.params;
        let Twist { speed_m_s: v_r, yaw_rate_rad_s: w_r } = reference;
        let (sin, cos) = libm::sincos(th_e);
        Twist {
            speed_m_s: v_r * cos + along_gain_1_s * x_e,
            yaw_rate_rad_s: w_r + v_r * (lateral_gain_1_m2 * y_e + heading_gain_1_m * sin),
        }
    }
}

impl ControlLaw for Kanayama {
    fn twist(&mut self, state: &PathState) -> Twist {
        self.target.advance(self.speed_m_s * (1.0 - state.slowing), &self.limits, state.period_s);
        let reference = Twist { speed_m_s: self.target.speed_m_s, yaw_rate_rad_s: self.target.speed_m_s * state.curvature_1_m };
        let (ahead, left) = (self.target.travelled_m - state.travelled_m, -state.lateral_m);
        let (sin, cos) = libm::sincos(state.heading_rad);
        let wanted = self.demand((cos * ahead + sin * left, -sin * ahead + cos * left, -state.heading_rad), reference);
        self.commanded = self.limits.approach(self.commanded, wanted, state.period_s);
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

    /// The error's motion under the law has the source's V': checked against a numeric derivative of V along
    /// x_e' = y_e w - v + v_r cos th_e, y_e' = -x_e w + v_r sin th_e, th_e' = w_r - w, in bends too.
    #[test]
    fn lyapunovs_function_decreases_as_the_source_says() {
        let law = Kanayama::new(0.3, Limits::default(), KanayamaParams::default());
        let KanayamaParams { along_gain_1_s: k_x, lateral_gain_1_m2: k_y, heading_gain_1_m: k_th } = law.params;
        let potential = |(x, y, th): (f64, f64, f64)| 0.5 * (x * x + y * y) + (1.0 - libm::cos(th)) / k_y;
        for w_r in [0.0, 0.4, -0.9] {
            let reference = Twist { speed_m_s: 0.3, yaw_rate_rad_s: w_r };
            for e in [(0.0, 0.06, -0.1), (0.05, -0.2, 0.7), (-0.1, 0.01, 1.5), (0.02, 0.0, -2.5)] {
                let Twist { speed_m_s: v, yaw_rate_rad_s: w } = law.demand(e, reference);
                let (sin, cos) = libm::sincos(e.2);
                let rate = (e.1 * w - v + 0.3 * cos, -e.0 * w + 0.3 * sin, w_r - w);
                let at = |t: f64| potential((e.0 + t * rate.0, e.1 + t * rate.1, e.2 + t * rate.2));
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                let stated = -k_x * e.0 * e.0 - 0.3 * k_th * sin * sin / k_y;
                assert!((slope - stated).abs() < 1e-8 && slope <= 0.0, "{e:?} {w_r}: {slope} {stated}");
            }
        }
    }
}
