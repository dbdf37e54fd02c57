//! From gains and limits in SI to the numbers of the integer loop ([`super::fixed`]), and how far that loop may be from the one in
//! `f64`.

use super::fixed::{FixedParams, Gain};
use super::{WheelGains, WheelLimits};

/// 2^24: a duty of 1 in Q7.24.
const DUTY_ONE: f64 = 16_777_216.0;
/// 2^16: 1 in Q16.16.
const ONE: f64 = 65_536.0;
/// Largest integral term that the integral's format holds, in duty. It stays below 1 but for the moment after a reversal.
const INTEGRAL_DUTY: f64 = 2.0;

/// Why a loop cannot be had in 16-bit integers.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ScalingError {
    /// The encoder counts too much within a tick.
    #[error(
        "at full speed the encoder counts {counts_per_tick:.0} in a tick, and twice that must fit 16 bits with a sign: at most 16383"
    )]
    TooFast {
        /// Counts a tick at full speed.
        counts_per_tick: f64,
    },
    /// A count moves the duty too much.
    #[error(
        "one count of speed error moves the duty by {duty_per_count:.1}: the encoder is too coarse for this bandwidth and rate"
    )]
    TooCoarse {
        /// Duty for one count a tick.
        duty_per_count: f64,
    },
    /// The integral cannot carry a load.
    #[error("in 16 bits the integral term reaches only {duty:.3} of full duty: the bandwidth is too low for so fine an encoder")]
    TooWeak {
        /// The largest integral term, in duty.
        duty: f64,
    },
}

/// The integer loop's numbers, and the scale of its set-points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// What the integer loop runs with.
    pub params: FixedParams,
    counts_per_rad_s: f64,
    /// Duty for one count a tick of set-point and of error, and for one count of the integral.
    duty_per_count: [f64; 3],
}

impl Scaling {
    /// For encoders of `counts_per_wheel_turn`, a call every `period_s` and a PWM register of `pwm_bits`, 4 to 15.
    ///
    /// F is chosen as large as twice the unloaded speed allows, G as large as an integral term of twice full duty does. Gains keep
    /// 15 bits.
    ///
    /// # Errors
    /// If speeds, gains or the integral do not fit 16 bits.
    pub fn new(
        gains: &WheelGains,
        limits: &WheelLimits,
        period_s: f64,
        counts_per_wheel_turn: f64,
        pwm_bits: u32,
    ) -> Result<Self, ScalingError> {
        let counts_per_rad_s = counts_per_wheel_turn / std::f64::consts::TAU * period_s;
        let counts_per_tick = counts_per_rad_s / gains.feed_forward_s_rad;
        let speed_bits = bits_beside(2.0 * counts_per_tick).ok_or(ScalingError::TooFast { counts_per_tick })?;
        let feed_forward = gains.feed_forward_s_rad / counts_per_rad_s;
        let proportional = gains.proportional_s_rad / counts_per_rad_s;
        let integral = gains.integral_1_rad * period_s / counts_per_rad_s;
        // Its sum has 16 bits before the point.
        let most = integral * 32_767.0;
        if most < 1.0 {
            return Err(ScalingError::TooWeak { duty: most });
        }
        let integral_bits = bits_beside(INTEGRAL_DUTY / integral).unwrap_or(0);
        let gain = |duty: f64, bits: u32| Gain::new(duty * DUTY_ONE / f64::from(1 << bits));
        let too_coarse = ScalingError::TooCoarse { duty_per_count: proportional.max(integral) };
        let register = 1.0 - 1.0 / f64::from(1 << pwm_bits);
        Ok(Self {
            params: FixedParams {
                speed_bits,
                integral_bits,
                pwm_bits,
                proportional: gain(proportional, speed_bits).ok_or(too_coarse)?,
                integral: gain(integral, integral_bits).ok_or(too_coarse)?,
                feed_forward: gain(feed_forward, speed_bits).ok_or(too_coarse)?,
                // Casts saturate: a limit that is infinite is the largest number.
                duty_limit: (limits.duty.min(register) * DUTY_ONE) as i32,
                current_limit: (limits.current_duty * DUTY_ONE) as i32,
            },
            counts_per_rad_s,
            duty_per_count: [feed_forward, proportional, integral],
        })
    }

    /// A wheel speed in rad/s as a set-point in counts a tick, Q16.16, nearest; one beyond what the loop's numbers hold is brought
    /// down to the largest, which is the unloaded speed or more.
    pub fn set_point(&self, wheel_rad_s: f64) -> i32 {
        let most = f64::from(1_u32 << (14 - self.params.speed_bits)) * ONE;
        (wheel_rad_s * self.counts_per_rad_s * ONE).round().clamp(-most, most) as i32
    }

    /// The wheel speed in rad/s of a set-point in counts a tick, Q16.16.
    pub fn speed(&self, set_point: i32) -> f64 {
        f64::from(set_point) / (self.counts_per_rad_s * ONE)
    }

    /// An angular deceleration in rad/s2 as the step of a set-point a tick, Q16.16, at least the smallest.
    pub fn step(&self, rad_s2: f64, period_s: f64) -> i32 {
        self.set_point(rad_s2 * period_s).max(1)
    }

    /// A register's value as duty.
    pub fn duty(&self, pwm: i16) -> f64 {
        f64::from(pwm) / f64::from(1 << self.params.pwm_bits)
    }

    /// How far the integer loop's duty, before the PWM rounds it, may be from the `f64` loop's on the same counts and set-points,
    /// where both have integrated on the same ticks, `ticks` of them. `terms` are the magnitudes of the three terms, in duty.
    ///
    /// The set-point is off by 2^-17, as factors set-point and error by 2^-(F+1) more, the integral by 2^-(G+1) and by the
    /// set-point's error a tick; a gain by 2^-15 of its value; each product by half of 2^-24. With kf, kp, ki the duty a count:
    ///
    /// ```text
    /// |d_fixed - d| <= (kf + kp) (2^-(F+1) + 2^-17) + ki (2^-(G+1) + 2^-17 ticks) + 2^-15 (|kf t| + |kp e| + |ki s|) + 3 2^-25
    /// ```
    ///
    /// The current limit's window is off by kf 2^-(F+1) + 2^-15 |kf dc| + 2^-24, less than this where kf dc is one of the terms. The
    /// PWM adds half of its last place.
    pub fn duty_error(&self, ticks: u32, terms: f64) -> f64 {
        let half = |bits: u32| 0.5 / f64::from(1_u32 << bits);
        let [feed_forward, proportional, integral] = self.duty_per_count;
        let FixedParams { speed_bits, integral_bits, .. } = self.params;
        (feed_forward + proportional) * (half(speed_bits) + half(16))
            + integral * (half(integral_bits) + half(16) * f64::from(ticks))
            + terms * half(14)
            + 3.0 * half(24)
    }
}

/// Bits after the point with which numbers up to `largest` still fit 16 bits with a sign; 14 at most.
fn bits_beside(largest: f64) -> Option<u32> {
    (0..=14).rev().find(|bits| largest * f64::from(1_u32 << bits) <= 32_767.0)
}

impl Gain {
    /// Nearest with as many bits as 16 with a sign hold; of gains below 2^-17, with fewer. `None` for 2^15 and more.
    fn new(value: f64) -> Option<Self> {
        let fits = |shift: &u32| value * f64::from(1_u32 << shift) <= 32_767.0;
        let shift = (0..=30).rev().find(fits)?;
        Some(Self { mantissa: (value * f64::from(1_u32 << shift)).round() as i16, shift })
    }
}

#[cfg(test)]
#[path = "twin_tests.rs"]
mod twin_tests;

#[cfg(test)]
mod tests {
    use super::*;

    /// INCRA I at 200 Hz: 1638 counts a tick at full speed.
    #[test]
    fn the_numbers_of_the_robot_are_as_the_document_says() {
        let gains = WheelGains::from_bandwidth(60.0, 31.2, 0.02);
        let scaling = Scaling::new(&gains, &WheelLimits::NONE, 0.005, 66_000.0, 8).expect("it fits");
        assert_eq!((scaling.params.speed_bits, scaling.params.integral_bits), (3, 1));
        assert_eq!(scaling.params.duty_limit, 255 << 16);
        for gain in [scaling.params.proportional, scaling.params.integral, scaling.params.feed_forward] {
            assert!(gain.mantissa >= 1 << 14, "{gain:?}");
        }
        // 0.3 m/s is 7.5 rad/s, 393.9 counts a tick.
        assert_eq!(scaling.set_point(7.5), (7.5 * 66_000.0 / std::f64::consts::TAU * 0.005 * 65_536.0_f64).round() as i32);
        assert_eq!(scaling.set_point(1e9), 2048 << 16);
        assert_eq!(scaling.set_point(-1e9), -2048 << 16);
    }

    #[test]
    fn what_does_not_fit_sixteen_bits_is_refused() {
        // At 60 rad/s the integral would give out before the counts a tick do.
        let gains = WheelGains::from_bandwidth(80.0, 31.2, 0.02);
        let of = |counts: f64| Scaling::new(&gains, &WheelLimits::NONE, 0.005, counts, 8);
        assert!(matches!(of(700_000.0), Err(ScalingError::TooFast { .. })), "{:?}", of(700_000.0));
        assert!(of(650_000.0).is_ok());
        // A bandwidth of 5000 rad/s on an encoder of four counts a turn.
        let wild = WheelGains::from_bandwidth(5000.0, 3.0, 0.02);
        let coarse = Scaling::new(&wild, &WheelLimits::NONE, 0.1, 4.0, 8);
        assert!(matches!(coarse, Err(ScalingError::TooCoarse { .. })), "{coarse:?}");
        // 20 rad/s instead of 60: a ninth of the integral's gain, 0.80 of full duty at 32767 counts.
        let weak = Scaling::new(&WheelGains::from_bandwidth(20.0, 31.2, 0.02), &WheelLimits::NONE, 0.005, 66_000.0, 8);
        assert!(matches!(weak, Err(ScalingError::TooWeak { duty }) if (0.79..0.81).contains(&duty)), "{weak:?}");
    }
}
