//! The speed loop of one side in integers, as a 16-bit microcontroller runs it: INCRA I's WC is an 80C196KC, which multiplies 16 by
//! 16 bits into 32, adds and shifts 32, has no floating point, counts its encoder in 16 bits that wrap, and sets its motor by a PWM
//! register of 8 bits (Intel, 8XC196KC/8XC196KD User's Manual).
//!
//! | quantity | format | unit of the last place |
//! |---|---|---|
//! | encoder | `u16`, wraps | 1 count |
//! | set-point t | `i32`, Q16.16 | 2^-16 counts a tick |
//! | error e = t - dc | `i32`, Q16.16 | 2^-16 counts a tick |
//! | integral s, the sum of e | `i32`, Q16.16 | 2^-16 counts |
//! | t, dc, e as factors | `i16`, F bits after the point | 2^-F counts a tick |
//! | s as a factor | `i16`, G bits after the point | 2^-G counts |
//! | a gain | `i16` mantissa m and a shift, m 2^-shift | relative 2^-15 |
//! | duty d and its limits | `i32`, Q7.24 | 2^-24 of the supply |
//! | PWM | `i16`, -(2^B - 1) to 2^B - 1 | 2^-B of the supply |
//!
//! Each tick, dc the counts since the tick before (right while |dc| < 2^15):
//!
//! ```text
//! e = t - dc          s' = s + e
//! d = kf t + kp e + ki s'
//! least, most = clamp(kf dc -+ c, -v, v)                  current limit c, voltage limit v
//! s = s'   if least <= d <= most, or e would bring d back; else s stays
//! PWM = round(clamp(d, least, most) 2^B)
//! ```
//!
//! Every sum saturates. Because s holds the fraction of every set-point, the mean speed is the commanded one to 2^-17 counts a tick
//! however coarse encoder and PWM are: no speed is too slow for the integral. Positive and negative duties round alike. The sign of
//! the PWM is the bridge's direction pin.

/// A gain: x becomes m x 2^-shift, rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gain {
    pub(super) mantissa: i16,
    pub(super) shift: u32,
}

/// The numbers of a loop; [`super::scaling`] makes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedParams {
    /// F: bits after the point of a speed as a factor.
    pub(super) speed_bits: u32,
    /// G: bits after the point of the integral as a factor.
    pub(super) integral_bits: u32,
    /// B: bits of the PWM register.
    pub(super) pwm_bits: u32,
    pub(super) proportional: Gain,
    pub(super) integral: Gain,
    pub(super) feed_forward: Gain,
    /// v, Q7.24.
    pub(super) duty_limit: i32,
    /// c, Q7.24.
    pub(super) current_limit: i32,
}

/// State of one side's loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FixedSide {
    target: i32,
    counts: Option<u16>,
    pub(super) integral: i32,
    /// The limited duty of the last tick, Q7.24: what the PWM rounds.
    pub(super) duty: i32,
}

impl Gain {
    fn of(self, x: i16) -> i32 {
        shifted(i32::from(self.mantissa) * i32::from(x), self.shift)
    }
}

/// x 2^-bits, rounded to nearest, halves up.
fn shifted(x: i32, bits: u32) -> i32 {
    if bits == 0 { x } else { x.saturating_add(1 << (bits - 1)) >> bits }
}

/// A Q16.16 number with `bits` bits after the point, in 16 bits.
fn factor(x: i32, bits: u32) -> i16 {
    let rounded = shifted(x, 16 - bits);
    i16::try_from(rounded).unwrap_or(if rounded < 0 { -i16::MAX } else { i16::MAX })
}

impl FixedSide {
    /// The speed to hold from now on, in counts a tick, Q16.16.
    pub fn command(&mut self, target: i32) {
        self.target = target;
    }

    /// The speed that it holds, in counts a tick, Q16.16.
    pub fn target(&self) -> i32 {
        self.target
    }

    /// Brings the speed to hold nearer to standstill, by at most `by` (not negative), Q16.16.
    pub fn slow(&mut self, by: i32) {
        self.target -= self.target.clamp(-by, by);
    }

    /// One tick: the encoder's counter in, the PWM's signed register value out.
    pub fn tick(&mut self, params: &FixedParams, counts: u16) -> i16 {
        let before = self.counts.replace(counts).unwrap_or(counts);
        // The counter wraps: its difference is right as a number with a sign.
        let moved = i32::from(counts.wrapping_sub(before) as i16) << 16;
        let error = self.target.saturating_sub(moved);
        let next = self.integral.saturating_add(error);
        let speed = |x| factor(x, params.speed_bits);
        let duty = params
            .feed_forward
            .of(speed(self.target))
            .saturating_add(params.proportional.of(speed(error)))
            .saturating_add(params.integral.of(factor(next, params.integral_bits)));
        let back_emf = params.feed_forward.of(speed(moved));
        let within = |x: i32| x.clamp(-params.duty_limit, params.duty_limit);
        let least = within(back_emf.saturating_sub(params.current_limit));
        let most = within(back_emf.saturating_add(params.current_limit));
        self.duty = duty.clamp(least, most);
        if self.duty == duty || (error < 0) == (duty > self.duty) {
            self.integral = next;
        }
        pwm(self.duty, params.pwm_bits)
    }
}

/// The register's value for a duty of Q7.24, nearest, halves away from zero, and no more than the register holds.
fn pwm(duty: i32, bits: u32) -> i16 {
    let size = shifted(duty.saturating_abs(), 24 - bits).min((1 << bits) - 1);
    // At most 15 bits: it fits.
    (size * duty.signum()) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: FixedParams = FixedParams {
        speed_bits: 4,
        integral_bits: 1,
        pwm_bits: 8,
        // Duty 2^-10 a count of error; 2^-12 a count of the integral; 2^-11 a count a tick of speed.
        proportional: Gain { mantissa: 1 << 14, shift: 4 },
        integral: Gain { mantissa: 1 << 14, shift: 3 },
        feed_forward: Gain { mantissa: 1 << 14, shift: 5 },
        duty_limit: 255 << 16,
        current_limit: i32::MAX,
    };

    /// Everything within the loop is an integer; what is not stands in `scaling` and `board`.
    #[test]
    fn there_is_no_floating_point() {
        let code = include_str!("fixed.rs").split("#[cfg(test)]").next().expect("the code before its tests");
        for float in ["f64", "f32"] {
            let found = code.lines().find(|line| !line.starts_with("//!") && line.contains(float));
            assert_eq!(found, None, "{float}");
        }
    }

    /// By hand: target 100 counts a tick, the counter moves by 60 across its wrap. e = 40: d = 100/2048 + 40/1024 + 140/4096, the
    /// integral having taken 100 on the first tick.
    #[test]
    fn a_tick_across_the_wrap_is_the_sum_by_hand() {
        let mut side = FixedSide::default();
        side.command(100 << 16);
        let first = side.tick(&PARAMS, 65_500);
        // 100/2048 + 100/1024 + 100/4096 = 700/4096, in 256ths 43.75.
        assert_eq!((first, side.duty), (44, 700 << 12));
        let second = side.tick(&PARAMS, 24);
        assert_eq!(side.duty, (200 + 160 + 140) << 12, "{second}");
        assert_eq!((second, side.integral), (31, 140 << 16));
    }

    #[test]
    fn forward_and_backward_are_alike() {
        for size in [0, 1, 1 << 15, 3 << 15, (1 << 24) - 1, 1 << 24, i32::MAX] {
            for bits in [4, 8, 10, 15] {
                assert_eq!(pwm(size, bits), -pwm(-size, bits), "{size} {bits}");
                assert!(i32::from(pwm(size, bits)) < 1 << bits);
            }
        }
    }

    /// The slowest set-point that there is moves the wheel by one count in 2^16 ticks.
    #[test]
    fn no_speed_is_too_slow_for_the_integral() {
        let mut side = FixedSide::default();
        side.command(1);
        for _ in 0..1 << 16 {
            side.tick(&PARAMS, 0);
        }
        assert_eq!(side.integral, 1 << 16);
        side.slow(5);
        assert_eq!(side.target(), 0);
    }

    /// Nothing overflows, whatever comes in: in a debug build an overflow panics.
    #[test]
    fn the_ends_of_every_range_saturate() {
        for target in [i32::MIN, i32::MAX, 0] {
            let mut side = FixedSide::default();
            side.command(target);
            for counts in [0, 0x8000, 0, 0x7fff, 0xffff, 0x8000] {
                let value = side.tick(&PARAMS, counts);
                assert!(value.unsigned_abs() <= 255, "{target} {counts}");
            }
            side.slow(i32::MAX);
        }
    }
}
