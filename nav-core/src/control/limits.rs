//! What body and wheels can do: one set of limits for every law, so that laws are compared at the same effort.

use super::Twist;

/// Limits that hold whatever a law wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest forward speed, in m/s, backward too.
    pub max_speed_m_s: f64,
    /// Largest forward acceleration a_max, in m/s2.
    pub max_acceleration_m_s2: f64,
    /// Largest yaw acceleration alpha_max, in rad/s2.
    pub max_yaw_acceleration_rad_s2: f64,
    /// Largest acceleration of a wheel's rim, in m/s2: |a| + W_eff / 2 |alpha| stays within it.
    pub max_wheel_acceleration_m_s2: f64,
    /// Effective track W_eff = chi W, in metres.
    pub effective_track_m: f64,
}

impl Default for Limits {
    /// Those of INCRA I; those of yaw and rim come out of the study `koh-cho` (`docs/tuning.md`), to three digits.
    fn default() -> Self {
        Self {
            max_speed_m_s: 1.25,
            max_acceleration_m_s2: 0.5,
            max_yaw_acceleration_rad_s2: 2.81,
            max_wheel_acceleration_m_s2: 1.49,
            effective_track_m: 0.325,
        }
    }
}

impl Limits {
    /// The speed nearest to `speed_m_s` that may be held.
    pub fn speed(&self, speed_m_s: f64) -> f64 {
        speed_m_s.clamp(-self.max_speed_m_s, self.max_speed_m_s)
    }

    /// What `from` has become after `period_s`, if it is to change by `change`. Steering first: what the wheels have left goes to
    /// the speed.
    pub fn change(&self, from: Twist, change: Twist, period_s: f64) -> Twist {
        let half_track_m = self.effective_track_m / 2.0;
        let alpha_max = self.max_yaw_acceleration_rad_s2.min(self.max_wheel_acceleration_m_s2 / half_track_m);
        let alpha = (change.yaw_rate_rad_s / period_s).clamp(-alpha_max, alpha_max);
        let left_over = (self.max_wheel_acceleration_m_s2 - half_track_m * alpha.abs()).max(0.0);
        let a_max = self.max_acceleration_m_s2.min(left_over);
        let a = (change.speed_m_s / period_s).clamp(-a_max, a_max);
        Twist { speed_m_s: self.speed(from.speed_m_s + a * period_s), yaw_rate_rad_s: from.yaw_rate_rad_s + alpha * period_s }
    }

    /// The twist nearest to `wanted` that can be reached from `from` in `period_s`.
    pub fn approach(&self, from: Twist, wanted: Twist, period_s: f64) -> Twist {
        let change =
            Twist { speed_m_s: wanted.speed_m_s - from.speed_m_s, yaw_rate_rad_s: wanted.yaw_rate_rad_s - from.yaw_rate_rad_s };
        self.change(from, change, period_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steering_goes_first_and_the_rim_bounds_both() {
        let limits = Limits { max_yaw_acceleration_rad_s2: 2.0, max_wheel_acceleration_m_s2: 0.4, ..Limits::default() };
        let next = limits.approach(Twist::default(), Twist { speed_m_s: 1.0, yaw_rate_rad_s: -5.0 }, 0.1);
        // All of alpha_max = 2 rad/s2 takes 0.1625 * 2 = 0.325 m/s2 of the rim's 0.4: 0.075 is left.
        assert!((next.yaw_rate_rad_s + 0.2).abs() < 1e-15 && (next.speed_m_s - 0.0075).abs() < 1e-15, "{next:?}");
    }

    #[test]
    fn what_is_within_reach_is_reached_and_no_speed_exceeds_its_limit() {
        let limits = Limits::default();
        let (from, wanted) = (Twist { speed_m_s: 0.3, yaw_rate_rad_s: 0.1 }, Twist { speed_m_s: 0.31, yaw_rate_rad_s: 0.09 });
        let next = limits.approach(from, wanted, 1.0 / 30.0);
        assert!((next.speed_m_s - 0.31).abs() < 1e-15 && (next.yaw_rate_rad_s - 0.09).abs() < 1e-15, "{next:?}");
        let mut twist = Twist::default();
        for _ in 0..1000 {
            twist = limits.approach(twist, Twist { speed_m_s: -9.0, yaw_rate_rad_s: 0.0 }, 1.0 / 30.0);
        }
        assert_eq!(twist.speed_m_s, -1.25);
    }
}
