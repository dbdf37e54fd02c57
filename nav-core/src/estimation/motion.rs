//! How a skid-steered base moves on its wheels, with the derivatives that a filter needs.
//!
//! Turning, all four wheels slip sideways; only the points of one line across the robot, x = x_ICR in the base frame, do not move
//! sideways: there lies the instantaneous centre of rotation. With the ground speeds of the two sides and the effective track W_eff
//! (A. Mandow et al., "Experimental kinematics for wheeled skid-steer mobile robots", IROS 2007):
//!
//! v = (v_l + v_r) / 2,  w = (v_r - v_l) / W_eff,  v_y = -w x_ICR
//!
//! at the base's origin, v_y to the left. So the point C of the robot's midplane at x_ICR moves as a unicycle does, and for the travels
//! s_l, s_r of the sides in a period, s = (s_l + s_r) / 2, turn d = (s_r - s_l) / W_eff, heading th before and th' = th + d after:
//!
//! y' = y + x_ICR (sin th - sin th') + s sinc(d / 2) sin(th + d / 2).

use nalgebra::{SMatrix, SVector, Vector2};

/// Lateral offset, heading, width, 1 / W_eff, x_ICR: places in the state. The turn is linear in 1 / W_eff, so that a track which is
/// hardly known at first does the linearised filter no harm.
pub(super) const LATERAL: usize = 0;
pub(super) const HEADING: usize = 1;
pub(super) const WIDTH: usize = 2;
pub(super) const PER_TRACK: usize = 3;
pub(super) const ICR: usize = 4;
/// States of the robot and its duct.
pub(super) const STATES: usize = 5;

/// What the wheels' rims travelled, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Travel {
    /// Of the left side.
    pub left_m: f64,
    /// Of the right side.
    pub right_m: f64,
}

/// One step, linearised.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The state after it.
    pub(super) state: SVector<f64, STATES>,
    /// Derivatives by the state before it.
    pub(super) by_state: SMatrix<f64, STATES, STATES>,
    /// Derivatives of the lateral offset and the heading by the turn.
    pub(super) by_turn: Vector2<f64>,
    /// Derivative of the lateral offset by the way of the middle.
    pub(super) by_way: f64,
    /// The turn, in radians.
    pub(super) turn_rad: f64,
    /// The way along the duct, of the base's origin, in metres.
    pub(super) along_m: f64,
}

impl Step {
    pub(super) fn of(before: &SVector<f64, STATES>, travel: Travel) -> Self {
        let icr_m = before[ICR];
        let way_m = (travel.left_m + travel.right_m) / 2.0;
        let difference_m = travel.right_m - travel.left_m;
        let turn = difference_m * before[PER_TRACK];
        let half = turn / 2.0;
        let (chord, chord_by_half) = (way_m * sinc(half), way_m * sinc_slope(half));
        let heading = before[HEADING];
        let (sin0, cos0) = libm::sincos(heading);
        let (sin1, cos1) = libm::sincos(heading + turn);
        let (sin_m, cos_m) = libm::sincos(heading + half);

        let mut state = *before;
        state[LATERAL] += icr_m * (sin0 - sin1) + chord * sin_m;
        state[HEADING] += turn;

        let lateral_by_turn = -icr_m * cos1 + 0.5 * (chord_by_half * sin_m + chord * cos_m);
        let mut by_state = SMatrix::identity();
        by_state[(LATERAL, HEADING)] = icr_m * (cos0 - cos1) + chord * cos_m;
        by_state[(LATERAL, PER_TRACK)] = lateral_by_turn * difference_m;
        by_state[(LATERAL, ICR)] = sin0 - sin1;
        by_state[(HEADING, PER_TRACK)] = difference_m;
        Self {
            state,
            by_state,
            by_turn: Vector2::new(lateral_by_turn, 1.0),
            by_way: sinc(half) * sin_m,
            turn_rad: turn,
            along_m: icr_m * (cos0 - cos1) + chord * cos_m,
        }
    }
}

/// sin(x) / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

/// Derivative of sin(x) / x.
fn sinc_slope(x: f64) -> f64 {
    if x.abs() < 1e-4 { -x / 3.0 } else { (libm::cos(x) - libm::sin(x) / x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivatives_are_those_of_the_motion() {
        let before = SVector::from([0.03, 0.1, 0.5, 1.0 / 0.325, 0.02]);
        let travel = Travel { left_m: 0.02, right_m: 0.05 };
        let step = Step::of(&before, travel);
        for i in 0..STATES {
            let moved = |by: f64| {
                let mut from = before;
                from[i] += by;
                Step::of(&from, travel).state
            };
            // Central differences of 1e-6: good to 1e-9 for curvatures of order one.
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            for j in 0..STATES {
                assert!((slope[j] - step.by_state[(j, i)]).abs() < 1e-8, "{j} by {i}: {} {}", slope[j], step.by_state[(j, i)]);
            }
        }
        let further = Step::of(&before, Travel { left_m: 0.02 - 1e-6, right_m: 0.05 + 1e-6 }).state - step.state;
        let by_turn = further[LATERAL] / (2e-6 / 0.325);
        assert!((by_turn - step.by_turn[0]).abs() < 1e-5, "{by_turn} {}", step.by_turn[0]);
    }

    /// The base's velocity at its origin is (v, -w x_ICR): a robot that turns on the spot about a point ahead of its origin swings its
    /// origin to the right when it turns left.
    #[test]
    fn turning_left_about_a_point_ahead_moves_the_origin_right() {
        let before = SVector::from([0.0, 0.0, 0.5, 1.0 / 0.325, 0.05]);
        let quarter = std::f64::consts::FRAC_PI_2 * 0.325 / 2.0;
        let step = Step::of(&before, Travel { left_m: -quarter, right_m: quarter });
        // From (0, 0) about (0.05, 0) by a quarter turn to the left: to (0.05, -0.05).
        assert!((step.state[LATERAL] + 0.05).abs() < 1e-12 && (step.along_m - 0.05).abs() < 1e-12, "{step:?}");
    }

    /// With x_ICR = 0 it is the motion that the navigator without a filter reckons with.
    #[test]
    fn without_an_offset_it_is_plain_dead_reckoning() {
        use crate::control::Twist;
        use crate::odometry::advance;
        let before = SVector::from([0.03, -0.1, 0.5, 1.0 / 0.325, 0.0]);
        let step = Step::of(&before, Travel { left_m: 0.02, right_m: 0.05 });
        let twist = Twist { speed_m_s: 0.035, yaw_rate_rad_s: 0.03 / 0.325 };
        let (lateral, heading, along) = advance(0.03, -0.1, twist, 1.0);
        assert!((step.state[LATERAL] - lateral).abs() < 1e-15 && (step.state[HEADING] - heading).abs() < 1e-15);
        assert!((step.along_m - along).abs() < 1e-15);
    }
}
