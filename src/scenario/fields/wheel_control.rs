//! The wheel controller: what it reckons in, its limits, and what it does when it hears nothing.

use ductloop_nav::wheel_controller::board::Arithmetic;

use super::field::Slot;
use super::{Default, Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] = &[TableRow::new(
    "wheel_control",
    "The wheel controller: what it reckons in, what it may give the motors, what it does when no command comes.",
)];

pub(super) const FIELDS: &[Field] = &[
    Field::word(
        "wheel_control.arithmetic",
        &["fixed", "float"],
        |s| s.wheel_control.arithmetic.word(),
        |s, word| s.wheel_control.arithmetic = if word == "float" { Arithmetic::Float } else { Arithmetic::Fixed },
    )
    .default("\"fixed\"")
    .about(
        "\"fixed\" is 16-bit integers and a PWM register, as on the 80C196KC; \"float\" is the same loop without quantisation.",
    ),
    Field::count("wheel_control.pwm_bits", 4, 15, |s| &mut s.wheel_control.pwm_bits)
        .default("8")
        .about("Bits of the PWM register; of no account with arithmetic = \"float\"."),
    Field::number("wheel_control.current_limit_a", 0.05, 1000.0, |s| &mut s.wheel_control.current_limit_a)
        .unit("A")
        .default("4.0")
        .about("Largest motor current, reckoned from duty and wheel speed."),
    Field::new(
        "wheel_control.voltage_limit_v",
        Kind::NumberOr { min: 0.1, max: 100.0, word: "supply" },
        Slot::NumberOr(|s| &mut s.wheel_control.voltage_limit_v, super::Scale::Si),
    )
    .unit("V")
    .default("\"supply\"")
    .about("Largest motor voltage; \"supply\" is all of the supply."),
    Field::number("wheel_control.silence_s", 0.01, 60.0, |s| &mut s.wheel_control.silence_s)
        .unit("s")
        .or(Default::Computed("0.5 s, or five frames where that is longer"))
        .about("Longest time without a command before the wheels are slowed down to a stop."),
    Field::number("wheel_control.ramp_m_s2", 0.01, 100.0, |s| &mut s.wheel_control.ramp_m_s2)
        .unit("m/s2")
        .default("1.0")
        .about("Deceleration of the wheels' rims when no command comes."),
    Field::number("wheel_control.follow_s", 0.01, 36_000.0, |s| &mut s.wheel_control.follow_s)
        .unit("s")
        .default("0.25")
        .about(
            "Longest time that a wheel may be off its set-point by a quarter of it (by 1 rad/s, if that is more) before the motors are cut \
             off: a motor is dead, an encoder stuck, or the wheel held.",
        ),
];
