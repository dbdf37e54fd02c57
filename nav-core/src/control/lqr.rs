//! A linear-quadratic regulator on (lateral, heading): the gains that minimise the sum over all commands to come of
//! (lateral / l)^2 + (heading / h)^2 + (w / r)^2, found by the discrete Riccati equation at the robot's speed and period. Textbook:
//! B. D. O. Anderson and J. B. Moore, "Optimal Control: Linear Quadratic Methods", 1990, section 2.4.
//!
//! Over a period T at speed v, linearised, with a constant yaw rate w: lateral += v T heading + v T^2 / 2 w, heading += T w. In the
//! limit of short periods the gains are k_y = r / l and k_th = sqrt(2 v k_y + (r / h)^2). While the robot gathers speed the
//! feedback is scaled by v over its final value, so that its trace along the path stays the same.

use super::cruise::Cruise;
use super::limits::Limits;
use super::{ControlLaw, PathState, Twist, lane_factor};

/// Parameters of the law: deviations that cost the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LqrParams {
    /// l, in metres.
    pub lateral_m: f64,
    /// h, in radians.
    pub heading_rad: f64,
    /// r, in rad/s.
    pub yaw_rate_rad_s: f64,
}

impl Default for LqrParams {
    fn default() -> Self {
        Self { lateral_m: 0.06, heading_rad: 0.2, yaw_rate_rad_s: 0.4 }
    }
}

/// Yaw rate for a metre beside the path and for a radian of heading, in rad/(s m) and 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gains {
    lateral: f64,
    heading: f64,
}

/// A symmetric cost matrix [[yy, yh], [yh, hh]].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost {
    yy: f64,
    yh: f64,
    hh: f64,
}

/// The law and what it holds.
#[derive(Clone, Debug)]
pub struct Lqr {
    params: LqrParams,
    cruise: Cruise,
    /// The period that the gains are for, and they.
    solved: Option<(f64, Gains)>,
}

impl Lqr {
    /// The law at rest, to drive at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: LqrParams) -> Self {
        Self { params, cruise: Cruise::new(speed_m_s, limits), solved: None }
    }

    fn gains(&mut self, period_s: f64) -> Gains {
        match self.solved {
            Some((period, gains)) if period == period_s => gains,
            _ => {
                let gains = solve(&self.params, self.cruise.speed_m_s, period_s).0;
                self.solved = Some((period_s, gains));
                gains
            }
        }
    }
}

/// One step backward of the Riccati equation: the gains that are best if `next` is the cost from the next command on, and the cost
/// from this command on.
fn riccati_step(params: &LqrParams, v: f64, t: f64, next: Cost) -> (Gains, Cost) {
    let q = (1.0 / (params.lateral_m * params.lateral_m), 1.0 / (params.heading_rad * params.heading_rad));
    let r = 1.0 / (params.yaw_rate_rad_s * params.yaw_rate_rad_s);
    // A = [[1, v T], [0, 1]], B = [v T^2 / 2, T].
    let (a, b) = (v * t, (0.5 * v * t * t, t));
    let pb = (next.yy * b.0 + next.yh * b.1, next.yh * b.0 + next.hh * b.1);
    let denominator = r + b.0 * pb.0 + b.1 * pb.1;
    // K = B' P A / (r + B' P B)
    let gains = Gains { lateral: pb.0 / denominator, heading: (pb.0 * a + pb.1) / denominator };
    // P = Q + A' P A - K' (r + B' P B) K
    let cost = Cost {
        yy: q.0 + next.yy - gains.lateral * gains.lateral * denominator,
        yh: next.yy * a + next.yh - gains.lateral * gains.heading * denominator,
        hh: q.1 + next.yy * a * a + 2.0 * next.yh * a + next.hh - gains.heading * gains.heading * denominator,
    };
    (gains, cost)
}

/// The steady gains and cost: the step repeated until nothing changes. It converges as the square of the closed loop, so some
/// hundred steps at 30 Hz; the bound is for parameters at the ends of their ranges.
fn solve(params: &LqrParams, v: f64, t: f64) -> (Gains, Cost) {
    let (mut gains, mut cost) = riccati_step(params, v, t, Cost { yy: 0.0, yh: 0.0, hh: 0.0 });
    for _ in 0..100_000 {
        let (next, from_here) = riccati_step(params, v, t, cost);
        let settled = (next.lateral - gains.lateral).abs() <= 1e-13 * next.lateral.abs()
            && (next.heading - gains.heading).abs() <= 1e-13 * next.heading.abs();
        (gains, cost) = (next, from_here);
        if settled {
            break;
        }
    }
    (gains, cost)
}

impl ControlLaw for Lqr {
    fn twist(&mut self, state: &PathState) -> Twist {
        let gains = self.gains(state.period_s);
        let v = self.cruise.commanded.speed_m_s;
        let w_r = v * state.curvature_1_m / lane_factor(state.curvature_1_m, state.lateral_m);
        let feedback = gains.lateral * state.lateral_m + gains.heading * state.heading_rad;
        let share = if self.cruise.speed_m_s == 0.0 { 0.0 } else { v / self.cruise.speed_m_s };
        self.cruise.steer(w_r - share * feedback, state)
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.cruise.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 1.0 / 30.0;

    /// In the limit of short periods the Riccati equation has a closed solution.
    #[test]
    fn at_short_periods_the_gains_are_those_of_the_continuous_regulator() {
        let params = LqrParams::default();
        for v in [0.1, 0.3, 0.8] {
            let (gains, _) = solve(&params, v, 1e-3);
            let lateral = params.yaw_rate_rad_s / params.lateral_m;
            let ratio = params.yaw_rate_rad_s / params.heading_rad;
            let heading = (2.0 * v * lateral + ratio * ratio).sqrt();
            // The period enters at first order: about k_th T / 2, up to 0.2 %.
            assert!((gains.lateral / lateral - 1.0).abs() < 3e-3, "{v}: {gains:?} {lateral}");
            assert!((gains.heading / heading - 1.0).abs() < 3e-3, "{v}: {gains:?} {heading}");
        }
    }

    /// The cost of any linear feedback, by adding it up; no other gains are cheaper than those found, and theirs is what the
    /// solution says.
    #[test]
    fn no_other_gains_cost_less() {
        let (params, v) = (LqrParams::default(), 0.3);
        let (gains, cost) = solve(&params, v, PERIOD_S);
        let spent = |g: Gains| {
            let (mut y, mut h, mut sum) = (0.06, 0.1, 0.0);
            for _ in 0..5000 {
                let w = -g.lateral * y - g.heading * h;
                sum += (y / params.lateral_m) * (y / params.lateral_m)
                    + (h / params.heading_rad) * (h / params.heading_rad)
                    + (w / params.yaw_rate_rad_s) * (w / params.yaw_rate_rad_s);
                (y, h) = (y + v * PERIOD_S * h + 0.5 * v * PERIOD_S * PERIOD_S * w, h + PERIOD_S * w);
            }
            sum
        };
        let best = spent(gains);
        let stated = cost.yy * 0.06 * 0.06 + 2.0 * cost.yh * 0.06 * 0.1 + cost.hh * 0.1 * 0.1;
        assert!((best / stated - 1.0).abs() < 1e-9, "{best} {stated}");
        for (dl, dh) in [(1.1, 1.0), (0.9, 1.0), (1.0, 1.1), (1.0, 0.9), (1.05, 0.95), (0.5, 2.0)] {
            let other = spent(Gains { lateral: gains.lateral * dl, heading: gains.heading * dh });
            assert!(other > best * (1.0 + 1e-5), "{dl} {dh}: {other} {best}");
        }
    }
}
