//! Motion of a skid-steered base from its wheels.
//!
//! Four wheels, two a side at one speed: turning, they slip sideways, and the base turns slower than an ideal differential
//! drive of the same track W would, by chi = 1 + (L/W)^2 (isotropic Coulomb friction, centre of mass in the middle).

use crate::control::Twist;
use crate::estimation::Travel;
use crate::messages::{Counts, Sides};

/// What the navigator knows of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveModel {
    /// Wheel radius, in metres.
    pub wheel_radius_m: f64,
    /// Effective track chi W, in metres.
    pub effective_track_m: f64,
    /// Encoder counts for one turn of a wheel.
    pub counts_per_wheel_turn: f64,
    /// Bandwidth w of the wheels' speed loop, in rad/s (see [`crate::wheel_controller::WheelGains::from_bandwidth`]).
    pub wheel_bandwidth_rad_s: f64,
}

impl DriveModel {
    /// The base's motion at these wheel speeds, in rad/s.
    pub fn twist(&self, wheels: Sides) -> Twist {
        Twist {
            speed_m_s: self.wheel_radius_m * (wheels.left + wheels.right) / 2.0,
            yaw_rate_rad_s: self.wheel_radius_m * (wheels.right - wheels.left) / self.effective_track_m,
        }
    }

    /// The wheel speeds for this motion, in rad/s.
    pub fn wheels(&self, twist: Twist) -> Sides {
        let difference = twist.yaw_rate_rad_s * self.effective_track_m / 2.0;
        Sides {
            left: (twist.speed_m_s - difference) / self.wheel_radius_m,
            right: (twist.speed_m_s + difference) / self.wheel_radius_m,
        }
    }

    /// Mean wheel speeds between two readings of the encoders, in rad/s.
    pub fn wheel_speeds(&self, before: Counts, now: Counts, period_s: f64) -> Sides {
        let scale = std::f64::consts::TAU / (self.counts_per_wheel_turn * period_s);
        Sides { left: (now.left - before.left) as f64 * scale, right: (now.right - before.right) as f64 * scale }
    }

    /// What the rims travel in `period_s` at these wheel speeds, in rad/s.
    pub fn travel(&self, wheels: Sides, period_s: f64) -> Travel {
        let scale = self.wheel_radius_m * period_s;
        Travel { left_m: wheels.left * scale, right_m: wheels.right * scale }
    }

    /// Way of a wheel's rim for one encoder count, in metres.
    pub fn metres_per_count(&self) -> f64 {
        std::f64::consts::TAU * self.wheel_radius_m / self.counts_per_wheel_turn
    }

    /// Mean wheel speeds over the next `period_s`, when wheels that turn steadily at `now` are commanded to turn at `to`.
    ///
    /// With the back-EMF fed forward the speed loop answers a step as (2 w s + w^2) / (s + w)^2, that is 1 + (w t - 1) exp(-w t);
    /// what is missing of the step, in the mean over the time T, is exp(-w T).
    pub fn approach(&self, now: Sides, to: Sides, period_s: f64) -> Sides {
        let missing = libm::exp(-self.wheel_bandwidth_rad_s * period_s);
        Sides { left: to.left + (now.left - to.left) * missing, right: to.right + (now.right - to.right) * missing }
    }
}

/// Offset and heading relative to a straight path, after `period_s` of constant motion.
///
/// Exact for an arc of constant twist. Returns (lateral, heading, distance along the path).
pub fn advance(lateral_m: f64, heading_rad: f64, twist: Twist, period_s: f64) -> (f64, f64, f64) {
    let turn = twist.yaw_rate_rad_s * period_s;
    let chord = twist.speed_m_s * period_s * sinc(turn / 2.0);
    let (s, c) = libm::sincos(heading_rad + turn / 2.0);
    (lateral_m + chord * s, heading_rad + turn, chord * c)
}

/// sin(x) / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-6 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: DriveModel = DriveModel {
        wheel_radius_m: 0.04,
        effective_track_m: 0.325,
        counts_per_wheel_turn: 66_000.0,
        wheel_bandwidth_rad_s: 60.0,
    };

    #[test]
    fn wheels_and_twist_are_inverse() {
        let twist = Twist { speed_m_s: 0.3, yaw_rate_rad_s: -0.7 };
        let back = DRIVE.twist(DRIVE.wheels(twist));
        assert!((back.speed_m_s - 0.3).abs() < 1e-15 && (back.yaw_rate_rad_s + 0.7).abs() < 1e-15);
    }

    #[test]
    fn the_mean_of_a_step_is_that_of_the_loops_closed_form() {
        let (now, to, period) = (Sides { left: 2.0, right: 8.0 }, Sides { left: 5.0, right: 5.0 }, 1.0 / 30.0);
        let mean = DRIVE.approach(now, to, period);
        // Midpoint rule, fine enough for six digits.
        let steps = 10_000;
        let sampled = |from: f64, to: f64| {
            let at = |i: i32| {
                let x = (f64::from(i) + 0.5) / f64::from(steps) * period * DRIVE.wheel_bandwidth_rad_s;
                from + (to - from) * (1.0 + (x - 1.0) * libm::exp(-x))
            };
            (0..steps).map(at).sum::<f64>() / f64::from(steps)
        };
        assert!((mean.left - sampled(2.0, 5.0)).abs() < 1e-6 && (mean.right - sampled(8.0, 5.0)).abs() < 1e-6, "{mean:?}");
    }

    #[test]
    fn a_quarter_circle_ends_beside_its_centre() {
        // Radius 2 m, a quarter turn to the left in 1 s.
        let quarter = std::f64::consts::FRAC_PI_2;
        let (lateral, heading, along) = advance(0.0, 0.0, Twist { speed_m_s: 2.0 * quarter, yaw_rate_rad_s: quarter }, 1.0);
        assert!((lateral - 2.0).abs() < 1e-12 && (along - 2.0).abs() < 1e-12 && (heading - quarter).abs() < 1e-12);
    }
}
