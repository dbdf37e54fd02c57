//! The wheel controller (WC): holds each side's wheel speed by the duty of its motor, at a rate of its own.
//!
//! PI on the speed that the encoder counts give, with the back-EMF fed forward, and anti-windup by conditional integration: the
//! integral stands still while the duty is at a limit and the error would drive it further. Limits: [`WheelLimits`].
//!
//! - [`WheelController`]: the loop in `f64`;
//! - [`fixed`]: the same loop in 16-bit integers, as a microcontroller runs it; [`scaling`] makes its numbers, and says how far
//!   the two may differ;
//! - [`silence`]: what happens when no command comes any more;
//! - [`board`]: either loop with its watch over the silence: what a robot carries.

pub mod board;
pub mod fixed;
pub mod following;
pub mod scaling;
pub mod silence;

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

/// What the motor may be given.
///
/// The current is not measured but computed: in the steady state of the winding it is (duty V - k n w) / R, so that |current| <= I
/// is the window |duty - w / w_0| <= I R / V about the back-EMF's share w / w_0 of the supply, w_0 the unloaded speed. A current
/// sensor would tell a loop of 200 Hz no more: the winding's time constant (0.1 ms for INCRA I's motor) is over within a tick, and
/// a loop that answers to a current which has been is a tick late. What it costs: w is the mean speed over the last tick, half a
/// tick old at the start of the next and one and a half at its end, so at the angular acceleration a the true current is off by up
/// to 3/2 T a k n / R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelLimits {
    /// Largest duty either way: the voltage limit over the supply; at most 1.
    pub duty: f64,
    /// Largest current times winding resistance over supply: the window's half width, in duty.
    pub current_duty: f64,
}

impl WheelLimits {
    /// Full duty, any current.
    pub const NONE: Self = Self { duty: 1.0, current_duty: f64::INFINITY };

    /// The duties allowed at a speed whose back-EMF is this share of the supply. The voltage limit comes last: it always holds.
    fn window(&self, back_emf_duty: f64) -> [f64; 2] {
        let within = |duty: f64| duty.clamp(-self.duty, self.duty);
        [within(back_emf_duty - self.current_duty), within(back_emf_duty + self.current_duty)]
    }
}

/// The loop of both sides.
#[derive(Clone, Debug)]
pub struct WheelController {
    gains: WheelGains,
    limits: WheelLimits,
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
            limits: WheelLimits::NONE,
            period_s,
            rad_per_count: std::f64::consts::TAU / counts_per_wheel_turn,
            target_rad_s: Sides::default(),
            counts: None,
            integral: Sides::default(),
        }
    }

    /// The same loop within these limits.
    pub fn with_limits(self, limits: WheelLimits) -> Self {
        Self { limits, ..self }
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
        let Self { gains, limits, period_s, target_rad_s: target, integral, .. } = self;
        Sides {
            left: side(gains, limits, *period_s, target.left, measured.left, &mut integral.left),
            right: side(gains, limits, *period_s, target.right, measured.right, &mut integral.right),
        }
    }

    /// Brings the speeds to hold nearer to standstill, by at most this much.
    pub fn slow(&mut self, by_rad_s: f64) {
        let toward = |speed: f64| if speed.abs() <= by_rad_s { 0.0 } else { speed - by_rad_s.copysign(speed) };
        self.target_rad_s = Sides { left: toward(self.target_rad_s.left), right: toward(self.target_rad_s.right) };
    }

    /// The speeds that it holds, in rad/s.
    pub fn target_rad_s(&self) -> Sides {
        self.target_rad_s
    }
}

fn side(gains: &WheelGains, limits: &WheelLimits, period_s: f64, target: f64, measured: f64, integral: &mut f64) -> f64 {
    let error = target - measured;
    let next = *integral + gains.integral_1_rad * error * period_s;
    let duty = gains.feed_forward_s_rad * target + gains.proportional_s_rad * error + next;
    let [least, most] = limits.window(gains.feed_forward_s_rad * measured);
    let limited = duty.clamp(least, most);
    if limited == duty || (error < 0.0) == (duty > limited) {
        *integral = next;
    }
    limited
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
        let duty = side(&gains, &WheelLimits::NONE, 0.1, 2.0, 3.0, &mut integral);
        assert_eq!((duty, integral), (1.0, 0.4));
        let duty = side(&gains, &WheelLimits::NONE, 0.1, 2.0, 1.0, &mut integral);
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

    /// A wheel that stands: the window is about zero. One that turns at half speed: about half.
    #[test]
    fn the_current_limit_is_a_window_about_the_back_emf() {
        let gains = WheelGains { proportional_s_rad: 1.0, integral_1_rad: 1.0, feed_forward_s_rad: 0.1 };
        let limits = WheelLimits { duty: 0.9, current_duty: 0.25 };
        let duty = |target: f64, measured: f64| {
            let mut integral = 0.0;
            (side(&gains, &limits, 0.1, target, measured, &mut integral), integral)
        };
        assert_eq!(duty(10.0, 0.0), (0.25, 0.0));
        assert_eq!(duty(10.0, 5.0), (0.75, 0.0));
        assert_eq!(duty(-10.0, 5.0), (0.25, 0.0));
        // Beyond the voltage limit nothing goes.
        assert_eq!(duty(20.0, 10.0), (0.9, 0.0));
        assert_eq!(duty(20.0, 15.0), (0.9, 0.0));
    }

    /// What it holds comes down to standstill, not past it.
    #[test]
    fn slowing_ends_at_standstill() {
        let mut controller = WheelController::new(WheelGains::from_bandwidth(60.0, 31.2, 0.02), 0.005, COUNTS);
        controller.command(Sides { left: 1.0, right: -0.3 });
        for expected in [(0.6, 0.0), (0.2, 0.0), (0.0, 0.0), (0.0, 0.0)] {
            controller.slow(0.4);
            let target = controller.target_rad_s();
            // One subtraction each: rounding only.
            assert!((target.left - expected.0).abs() < 1e-15 && target.right == expected.1, "{target:?}");
        }
    }
}
