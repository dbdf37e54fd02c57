//! The integer loop against the one in `f64`: the same counts, the same set-points, a motor that the integers drive.

use proptest::prelude::*;

use super::super::fixed::FixedSide;
use super::super::{WheelGains, WheelLimits, side};
use super::Scaling;

const COUNTS: f64 = 66_000.0;
const PERIOD_S: f64 = 0.005;
const FULL_RAD_S: f64 = 31.2;
const TIME_CONSTANT_S: f64 = 0.02;

/// A first-order motor with a load, exact over a tick.
#[derive(Default)]
struct Motor {
    speed_rad_s: f64,
    angle_rad: f64,
}

impl Motor {
    fn step(&mut self, duty: f64) {
        let decay = libm::exp(-PERIOD_S / TIME_CONSTANT_S);
        let end = duty * FULL_RAD_S;
        self.angle_rad += end * PERIOD_S + (self.speed_rad_s - end) * TIME_CONSTANT_S * (1.0 - decay);
        self.speed_rad_s = end + (self.speed_rad_s - end) * decay;
    }
}

/// What a profile came to: the largest difference of the duties, over what was allowed there; and the ticks on which one loop
/// integrated and the other did not.
struct Outcome {
    worst_share: f64,
    worst_duty: f64,
    apart: u32,
    limited: u32,
}

/// Runs both loops over `(target, load in duty, ticks)`. A tick on which the loops fall on different sides of a limit, which they
/// may within the bound, moves their integrals apart by one tick's term, ki |e|; the bound then grows by that.
fn run(profile: &[(f64, f64, u32)], limits: WheelLimits, pwm_bits: u32, first_count: i64) -> Outcome {
    let gains = WheelGains::from_bandwidth(60.0, FULL_RAD_S, TIME_CONSTANT_S);
    let scaling = Scaling::new(&gains, &limits, PERIOD_S, COUNTS, pwm_bits).expect("it fits");
    let twin_limits = WheelLimits { duty: limits.duty.min(1.0 - 1.0 / f64::from(1 << pwm_bits)), ..limits };
    let (mut fixed, mut integral, mut motor) = (FixedSide::default(), 0.0, Motor::default());
    let (mut before, mut ticks, mut drifted) = (first_count, 0, 0.0);
    let mut outcome = Outcome { worst_share: 0.0, worst_duty: 0.0, apart: 0, limited: 0 };
    for (target, load, length) in profile {
        fixed.command(scaling.set_point(*target));
        for _ in 0..*length {
            ticks += 1;
            let counts = first_count + (motor.angle_rad / std::f64::consts::TAU * COUNTS).floor() as i64;
            let measured = (counts - before) as f64 * std::f64::consts::TAU / COUNTS / PERIOD_S;
            before = counts;
            let (was, fixed_was, error) = (integral, fixed.integral, target - measured);
            let pwm = fixed.tick(&scaling.params, counts as u16);
            let duty = side(&gains, &twin_limits, PERIOD_S, *target, measured, &mut integral);
            let terms = [gains.feed_forward_s_rad * target, gains.proportional_s_rad * error, was.abs().max(integral.abs())];
            // An error of nothing, to the last place, moves neither.
            let step = gains.integral_1_rad * error.abs() * PERIOD_S;
            if (integral != was) != (fixed.integral != fixed_was) {
                outcome.apart += 1;
                drifted += step;
            }
            let sum = terms.iter().map(|term| term.abs()).sum::<f64>() + gains.feed_forward_s_rad * measured.abs() + step;
            let allowed = scaling.duty_error(ticks, sum) + drifted;
            let difference = (f64::from(fixed.duty) / super::DUTY_ONE - duty).abs();
            outcome.worst_share = outcome.worst_share.max(difference / allowed);
            outcome.worst_duty = outcome.worst_duty.max(difference);
            outcome.limited += u32::from(integral == was && error != 0.0);
            let register = (scaling.duty(pwm) - f64::from(fixed.duty) / super::DUTY_ONE).abs();
            assert!(register <= 0.5 / f64::from(1 << pwm_bits), "the PWM is {register} off");
            motor.step(scaling.duty(pwm) - load);
        }
    }
    outcome
}

proptest! {
    /// Set-points up to the unloaded speed either way, loads, limits that bind and limits that do not, registers of all sizes,
    /// counters that start anywhere.
    #[test]
    fn the_twins_agree_within_quantisation(
        profile in prop::collection::vec((-31.2..31.2_f64, -0.3..0.3_f64, 1..120_u32), 1..12),
        current_duty in prop_oneof![Just(f64::INFINITY), 0.05..0.6_f64],
        duty in prop_oneof![Just(1.0), 0.3..1.0_f64],
        pwm_bits in 6..=12_u32,
        first_count in any::<i32>(),
    ) {
        let outcome = run(&profile, WheelLimits { duty, current_duty }, pwm_bits, i64::from(first_count));
        prop_assert!(outcome.worst_share <= 1.0, "{} of what is allowed", outcome.worst_share);
    }
}

/// The bound is no wide net: without a limit in reach no tick is judged differently, and the duties differ by less than a tenth of
/// the register's last place, but by more than a hundredth of what the bound allows.
#[test]
fn an_everyday_profile_is_far_within_a_register() {
    let profile = [(7.5, 0.05, 200), (7.9, 0.05, 100), (7.1, 0.08, 100), (-4.0, 0.05, 200), (0.0, 0.0, 100)];
    let outcome = run(&profile, WheelLimits::NONE, 8, 65_000);
    assert_eq!((outcome.apart, outcome.limited), (0, 0));
    assert!(outcome.worst_share > 0.01 && outcome.worst_duty < 0.1 / 256.0, "{} {}", outcome.worst_share, outcome.worst_duty);
}
