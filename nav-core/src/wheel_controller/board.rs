//! The wheel controller as a robot carries it: a loop a side, in integers or in `f64`, and the watch over a link that may go dead.

use super::fixed::FixedSide;
use super::following::Following;
use super::scaling::{Scaling, ScalingError};
use super::silence::{Hearing, Silence};
use super::{WheelController, WheelGains, WheelLimits};
use crate::messages::{Counts, Sides};

/// What the loop reckons in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arithmetic {
    /// 16-bit integers and a PWM register ([`super::fixed`]).
    #[default]
    Fixed,
    /// `f64`, and a duty as fine as that.
    Float,
}

impl Arithmetic {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Float => "float",
        }
    }
}

/// What a wheel controller is made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardParams {
    /// What it reckons in.
    pub arithmetic: Arithmetic,
    /// The loop's gains.
    pub gains: WheelGains,
    /// What the motors may be given.
    pub limits: WheelLimits,
    /// Time between calls, in seconds.
    pub period_s: f64,
    /// Encoder counts for one turn of a wheel.
    pub counts_per_wheel_turn: f64,
    /// Bits of the PWM register; of no account in `f64`.
    pub pwm_bits: u32,
    /// Longest silence before it slows down, in seconds.
    pub silence_s: f64,
    /// How fast it then slows down, in rad/s2 at the wheel.
    pub ramp_rad_s2: f64,
    /// Longest time that a wheel may be off its set-point before the motors are cut off, in seconds.
    pub follow_s: f64,
}

/// Both sides' loops and what they do when no command comes.
#[derive(Clone, Debug)]
pub struct WheelBoard {
    loops: Loops,
    silence: Silence,
    following: Following,
    counts: Option<Counts>,
    rad_s_per_count: f64,
    hearing: Hearing,
}

#[derive(Clone, Debug)]
enum Loops {
    Fixed { scaling: Scaling, left: FixedSide, right: FixedSide, step: i32 },
    Float { controller: WheelController, step_rad_s: f64 },
}

impl WheelBoard {
    /// At rest, with standstill commanded.
    ///
    /// # Errors
    /// If the loop cannot be had in 16-bit integers.
    pub fn new(params: &BoardParams) -> Result<Self, ScalingError> {
        let BoardParams {
            arithmetic,
            gains,
            limits,
            period_s,
            counts_per_wheel_turn,
            pwm_bits,
            silence_s,
            ramp_rad_s2,
            follow_s,
        } = *params;
        let loops = match arithmetic {
            Arithmetic::Fixed => {
                let scaling = Scaling::new(&gains, &limits, period_s, counts_per_wheel_turn, pwm_bits)?;
                let step = scaling.step(ramp_rad_s2, period_s);
                Loops::Fixed { scaling, left: FixedSide::default(), right: FixedSide::default(), step }
            }
            Arithmetic::Float => Loops::Float {
                controller: WheelController::new(gains, period_s, counts_per_wheel_turn).with_limits(limits),
                step_rad_s: ramp_rad_s2 * period_s,
            },
        };
        // The cast saturates; a limit of less than a tick would mean to slow down between any two commands.
        let ticks = |time_s: f64| ((time_s / period_s).round() as u32).max(1);
        let rad_s_per_count = std::f64::consts::TAU / (counts_per_wheel_turn * period_s);
        Ok(Self {
            loops,
            silence: Silence::new(ticks(silence_s)),
            following: Following::new(ticks(follow_s)),
            counts: None,
            rad_s_per_count,
            hearing: Hearing::Commanded,
        })
    }

    /// A command has come: the wheel speeds to hold from now on, in rad/s.
    pub fn command(&mut self, wheel_speed_rad_s: Sides) {
        self.silence.heard();
        match &mut self.loops {
            Loops::Fixed { scaling, left, right, .. } => {
                left.command(scaling.set_point(wheel_speed_rad_s.left));
                right.command(scaling.set_point(wheel_speed_rad_s.right));
            }
            Loops::Float { controller, .. } => controller.command(wheel_speed_rad_s),
        }
    }

    /// The duty of each motor, -1 to 1, until the next call. Of the counts the integer loop reads the lower 16 bits.
    pub fn tick(&mut self, counts: Counts) -> Sides {
        let before = self.counts.replace(counts).unwrap_or(counts);
        let speed = |now: i64, before: i64| (now - before) as f64 * self.rad_s_per_count;
        let measured = Sides { left: speed(counts.left, before.left), right: speed(counts.right, before.right) };
        if self.following.tick(self.target_rad_s(), measured) {
            self.hearing = Hearing::CutOff;
            return Sides::default();
        }
        self.hearing = self.listen();
        match &mut self.loops {
            Loops::Fixed { scaling, left, right, .. } => Sides {
                left: scaling.duty(left.tick(&scaling.params, counts.left as u16)),
                right: scaling.duty(right.tick(&scaling.params, counts.right as u16)),
            },
            Loops::Float { controller, .. } => controller.tick(counts),
        }
    }

    /// What it did about its commands on the last tick.
    pub fn hearing(&self) -> Hearing {
        self.hearing
    }

    /// The set-points that are held, in rad/s.
    fn target_rad_s(&self) -> Sides {
        match &self.loops {
            Loops::Fixed { scaling, left, right, .. } => {
                Sides { left: scaling.speed(left.target()), right: scaling.speed(right.target()) }
            }
            Loops::Float { controller, .. } => controller.target_rad_s(),
        }
    }

    fn listen(&mut self) -> Hearing {
        if !self.silence.tick() {
            return Hearing::Commanded;
        }
        let stands = match &mut self.loops {
            Loops::Fixed { left, right, step, .. } => {
                left.slow(*step);
                right.slow(*step);
                left.target() == 0 && right.target() == 0
            }
            Loops::Float { controller, step_rad_s } => {
                controller.slow(*step_rad_s);
                controller.target_rad_s() == Sides::default()
            }
        };
        if stands { Hearing::Down } else { Hearing::RampingDown }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: BoardParams = BoardParams {
        arithmetic: Arithmetic::Fixed,
        gains: WheelGains { proportional_s_rad: 0.045, integral_1_rad: 2.3, feed_forward_s_rad: 0.032 },
        limits: WheelLimits::NONE,
        period_s: 0.005,
        counts_per_wheel_turn: 66_000.0,
        pwm_bits: 8,
        silence_s: 0.1,
        ramp_rad_s2: 25.0,
        // These tests have no wheels that could follow.
        follow_s: 1e6,
    };

    /// 0.1 s of silence are 20 ticks; 7.5 rad/s at 25 rad/s2 are 0.3 s, 60 ticks.
    #[test]
    fn silence_brings_both_kinds_down_at_the_same_ticks() {
        for arithmetic in [Arithmetic::Fixed, Arithmetic::Float] {
            let mut board = WheelBoard::new(&BoardParams { arithmetic, ..PARAMS }).expect("a board");
            board.command(Sides { left: 7.5, right: -3.0 });
            let said: Vec<Hearing> = (0..100)
                .map(|_| {
                    board.tick(Counts::default());
                    board.hearing()
                })
                .collect();
            let until = |hearing| said.iter().position(|said| *said == hearing);
            assert_eq!(until(Hearing::RampingDown), Some(20), "{arithmetic:?}");
            // Q16.16 and f64 round 60 steps to a tick more or less.
            let down = until(Hearing::Down).expect("down");
            assert!((79..=81).contains(&down), "{arithmetic:?}: {down}");
            assert_eq!(board.hearing(), Hearing::Down);
            board.command(Sides { left: 1.0, right: 1.0 });
            board.tick(Counts::default());
            assert_eq!(board.hearing(), Hearing::Commanded, "a command ends it at once");
        }
    }

    /// A robot that has never been commanded stands, and says after the same time that it hears nothing.
    #[test]
    fn silence_counts_from_the_start() {
        let mut board = WheelBoard::new(&PARAMS).expect("a board");
        for _ in 0..20 {
            assert_eq!(board.tick(Counts::default()), Sides::default());
            assert_eq!(board.hearing(), Hearing::Commanded);
        }
        board.tick(Counts::default());
        assert_eq!(board.hearing(), Hearing::Down);
    }
}
