//! Pure pursuit: R. C. Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992, section 2:
//! the arc through the robot's place and heading that meets the path a look-ahead distance l away has the curvature
//! gamma = 2 x / l^2, where x is how far that goal lies to the side (here to the left, y).
//!
//! The path is taken as the arc of its curvature here. Linearised on a straight, gamma = -2 e / l^2 - 2 th / l: along the path a
//! second-order system of 1/sqrt(2) of critical damping, whatever l, so it overshoots by 4 %; its settling distance grows with l.

use super::cruise::Cruise;
use super::limits::Limits;
use super::{ControlLaw, PathState, Twist, lane_factor};

/// Parameters of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PurePursuitParams {
    /// Shortest look-ahead distance, in metres.
    pub lookahead_m: f64,
    /// Look-ahead in time, in seconds: at speed, l is what is covered in it, if that is more.
    pub lookahead_s: f64,
}

impl Default for PurePursuitParams {
    fn default() -> Self {
        Self { lookahead_m: 0.3, lookahead_s: 0.9 }
    }
}

/// The law and what it holds.
#[derive(Clone, Debug)]
pub struct PurePursuit {
    params: PurePursuitParams,
    cruise: Cruise,
}

impl PurePursuit {
    /// The law at rest, to drive at `speed_m_s`.
    pub fn new(speed_m_s: f64, limits: Limits, params: PurePursuitParams) -> Self {
        Self { params, cruise: Cruise::new(speed_m_s, limits) }
    }

    /// Curvature of the arc to the goal, in 1/m.
    fn curvature(&self, state: &PathState) -> f64 {
        let PathState { lateral_m: e, heading_rad, curvature_1_m: c, .. } = *state;
        let l = self.params.lookahead_m.max(self.params.lookahead_s * self.cruise.speed_m_s);
        // Where the path is farther away than l, the goal is where it is met at 45 degrees.
        let l2 = (l * l).max(2.0 * e * e);
        // In the frame of the path's nearest point: a point of the arc, (sin f, 1 - cos f) / c, has the distance l from (0, e) where
        // 1 - cos f = c^2 q with q = (l^2 - e^2) / (2 (1 - c e)). No term is singular on a straight.
        let q = (l2 - e * e) / (2.0 * lane_factor(c, e));
        // No farther than half around a circle that is smaller than l.
        let turned = (c * c * q).min(2.0);
        let (goal_x, goal_y) = ((q * (2.0 - turned)).sqrt(), c * q);
        let (sin, cos) = libm::sincos(heading_rad);
        2.0 * ((goal_y - e) * cos - goal_x * sin) / l2
    }
}

impl ControlLaw for PurePursuit {
    fn twist(&mut self, state: &PathState) -> Twist {
        let yaw_rate_rad_s = self.cruise.commanded.speed_m_s * self.curvature(state);
        self.cruise.steer(yaw_rate_rad_s, state)
    }

    fn reset(&mut self, _travelled_m: f64) {
        self.cruise.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> PurePursuit {
        PurePursuit::new(0.3, Limits::default(), PurePursuitParams::default())
    }

    /// Any chord of a circle, seen from a tangent, gives that circle.
    #[test]
    fn on_a_circle_the_arc_is_the_circle() {
        for c in [-2.0, -0.5, 1e-9, 0.7, 3.0] {
            let found = law().curvature(&PathState { curvature_1_m: c, ..PathState::default() });
            assert!((found - c).abs() < 1e-12, "{c}: {found}");
        }
    }

    /// The goal is on the path and l away, found here by walking along the circle.
    #[test]
    fn beside_a_circle_the_goal_is_where_walking_finds_it() {
        let (c, l) = (1.3, 0.3);
        for (e, heading) in [(0.05, 0.1), (-0.08, -0.3), (0.1, 0.0)] {
            let point = |s: f64| (libm::sin(c * s) / c, (1.0 - libm::cos(c * s)) / c);
            let distance = |s: f64| libm::hypot(point(s).0, point(s).1 - e);
            // Bisection: the distance grows along the quarter circle.
            let (mut near, mut far) = (0.0, 1.0);
            for _ in 0..80 {
                let middle = 0.5 * (near + far);
                *(if distance(middle) < l { &mut near } else { &mut far }) = middle;
            }
            let (x, y) = point(near);
            let side = -x * libm::sin(heading) + (y - e) * libm::cos(heading);
            let state = PathState { lateral_m: e, heading_rad: heading, curvature_1_m: c, ..PathState::default() };
            let found = law().curvature(&state);
            assert!((found - 2.0 * side / (l * l)).abs() < 1e-9, "{e} {heading}: {found}");
        }
    }

    #[test]
    fn far_beside_the_path_it_still_steers_to_it() {
        let found = law().curvature(&PathState { lateral_m: 2.0, ..PathState::default() });
        // 45 degrees over sqrt(2) 2 m: 2 y / l^2 = -4 / 8.
        assert!((found + 0.5).abs() < 1e-12, "{found}");
    }
}
