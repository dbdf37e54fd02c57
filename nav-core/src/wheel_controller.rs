//! The wheel controller (WC): holds each side's wheel speed by the duty of its motor, at a rate of its own.
//!
//! PI on the speed that the encoder counts give, with the back-EMF fed forward, and anti-windup by conditional integration: the
//! integral stands still while the duty is saturated and the error would drive it further.

use crate::messages::{Counts, Sides};

/// Gains and scales of the speed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelGains {
    /// Duty for one rad/s of error.
    pub proportional_s_rad: f64,
    /// Duty for one rad of accumulated error.
    pub integral_1_rad: f64,
    /// Duty for one rad/s of commanded speed: the inverse of the unloaded speed at full duty.
    pub feed_forward_s_rad: f64,
}

/// The loop of both sides.
#[derive(Clone, Debug)]
pub struct WheelController {
    gains: WheelGains,
    period_s: f64,
    rad_per_count: f64,
    target_rad_s: Sides,
    counts: Option<Counts>,
    integral: Sides,
}

impl WheelGains {
    /// Gains that place both poles of the loop at `-bandwidth_rad_s`, for a motor and load that reach `full_speed_rad_s` at full
    /// duty with time constant `time_constant_s`.
    ///
    /// With G = K / (tau s + 1), the closed loop's denominator is tau s^2 + (1 + K kp) s + K ki.
    pub fn from_bandwidth(bandwidth_rad_s: f64, full_speed_rad_s: f64, time_constant_s: f64) -> Self {
        Self {
            proportional_s_rad: (2.0 * bandwidth_rad_s * time_constant_s - 1.0).max(0.0) / full_speed_rad_s,
            integral_1_rad: bandwidth_rad_s * bandwidth_rad_s * time_constant_s / full_speed_rad_s,
            feed_forward_s_rad: 1.0 / full_speed_rad_s,
        }
    }
}

impl WheelController {
    /// A loop that is called every `period_s`, with encoders of `counts_per_wheel_turn`.
    pub fn new(gains: WheelGains, period_s: f64, counts_per_wheel_turn: f64) -> Self {
        Self {
            gains,
            period_s,
            rad_per_count: std::f64::consts::TAU / counts_per_wheel_turn,
            target_rad_s: Sides::default(),
            counts: None,
            integral: Sides::default(),
        }
    }

    /// The wheel speeds to hold from now on, in rad/s.
    pub fn command(&mut self, wheel_speed_rad_s: Sides) {
        self.target_rad_s = wheel_speed_rad_s;
    }

    /// The duty of each motor, -1 to 1, until the next call.
    pub fn tick(&mut self, counts: Counts) -> Sides {
        let before = self.counts.replace(counts).unwrap_or(counts);
        let speed = |now: i64, before: i64| (now - before) as f64 * self.rad_per_count / self.period_s;
        let measured = Sides { left: speed(counts.left, before.left), right: speed(counts.right, before.right) };
        Sides {
            left: side(&self.gains, self.period_s, self.target_rad_s.left, measured.left, &mut self.integral.left),
            right: side(&self.gains, self.period_s, self.target_rad_s.right, measured.right, &mut self.integral.right),
        }
    }
}

fn side(gains: &WheelGains, period_s: f64, target: f64, measured: f64, integral: &mut f64) -> f64 {
    let error = target - measured;
    let next = *integral + gains.integral_1_rad * error * period_s;
    let duty = gains.feed_forward_s_rad * target + gains.proportional_s_rad * error + next;
    let saturated = duty.clamp(-1.0, 1.0);
    if saturated == duty || error.signum() != duty.signum() {
        *integral = next;
    }
    saturated
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: f64 = 66_000.0;

    /// A first-order motor, exact over a tick.
    fn run(load_duty: f64, target: f64, ticks: usize) -> (Vec<f64>, Vec<f64>) {
        let (full, tau, period) = (31.2, 0.02, 0.005);
        let gains = WheelGains::from_bandwidth(60.0, full, tau);
        let mut controller = WheelController::new(gains, period, COUNTS);
        controller.command(Sides { left: target, right: 0.0 });
        let (mut speed, mut angle) = (0.0, 0.0);
        let (mut speeds, mut duties) = (Vec::new(), Vec::new());
        let decay = libm::exp(-period / tau);
        for _ in 0..ticks {
            let counts = (angle / std::f64::consts::TAU * COUNTS).floor() as i64;
            let duty = controller.tick(Counts { left: counts, right: 0 }).left;
            let final_speed = (duty - load_duty) * full;
            angle += final_speed * period + (speed - final_speed) * tau * (1.0 - decay);
            speed = final_speed + (speed - final_speed) * decay;
            speeds.push(speed);
            duties.push(duty);
        }
        (speeds, duties)
    }

    #[test]
    fn a_step_settles_without_error_under_load() {
        let (speeds, duties) = run(0.15, 7.5, 200);
        let settled = &speeds[60..];
        // One count in a tick is 0.019 rad/s.
        assert!(settled.iter().all(|s| (s - 7.5).abs() < 0.05), "{:?}", &speeds[..80]);
        assert!(duties.iter().all(|d| d.abs() <= 1.0));
    }

    #[test]
    fn a_step_without_load_overshoots_as_its_closed_form_says() {
        let (speeds, _) = run(0.0, 7.5, 200);
        let peak = speeds.iter().copied().fold(0.0, f64::max) / 7.5;
        // 1 + (w t - 1) exp(-w t) has its peak at 1 + exp(-2) = 1.135; sampling at 200 Hz, three ticks to 1/w, adds as much again.
        assert!((1.12..1.30).contains(&peak), "{peak}");
    }

    /// Saturated by a step up, the integral may still run down: a step back down is not held up by it.
    #[test]
    fn while_saturated_the_integral_moves_only_away_from_the_limit() {
        let gains = WheelGains { proportional_s_rad: 0.0, integral_1_rad: 1.0, feed_forward_s_rad: 1.0 };
        // Feed-forward alone saturates; the wheel turns faster than asked, so the integral must run down all the same.
        let mut integral = 0.5;
        let duty = side(&gains, 0.1, 2.0, 3.0, &mut integral);
        assert_eq!((duty, integral), (1.0, 0.4));
        let duty = side(&gains, 0.1, 2.0, 1.0, &mut integral);
        assert_eq!((duty, integral), (1.0, 0.4));
    }

    #[test]
    fn a_target_out_of_reach_does_not_wind_the_integral_up() {
        let gains = WheelGains::from_bandwidth(60.0, 31.2, 0.02);
        let mut controller = WheelController::new(gains, 0.005, COUNTS);
        controller.command(Sides { left: 100.0, right: 100.0 });
        for _ in 0..2000 {
            assert_eq!(controller.tick(Counts::default()).left, 1.0);
        }
        controller.command(Sides::default());
        assert!(controller.tick(Counts::default()).left.abs() < 0.2, "the integral kept {:?}", controller.integral);
    }
}
