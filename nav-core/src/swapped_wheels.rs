//! Left and right exchanged between navigator and wheels: every correction makes the error larger.
//!
//! The wheel controller cannot see it, as each side does what it is told. The navigator can: it turns one way by its commands, the other
//! by its encoders. With (l, r) commanded and (l', r') measured, the sides as they should be miss by (l' - l)^2 + (r' - r)^2, exchanged ones
//! by (l' - r)^2 + (r' - l)^2. A dead motor, a stuck encoder or a wheel that slips misses by both; only an exchange misses by little of the
//! second and much of the first, frame after frame. Of cables of the encoders that are exchanged the same is true, and it is as bad.

use crate::messages::Sides;

/// The sides must differ by this share of their mean before a frame says anything, and by so much, in rad/s.
const TURN_SHARE: f64 = 0.05;
const LEAST_TURN_RAD_S: f64 = 0.3;
/// Exchanged, they must miss by less than this share of what they miss by as they should be.
const CROSSED_SHARE: f64 = 0.25;
/// So many frames in a row: longer than a command of the other direction takes to show, shorter than it takes to meet a wall.
const FRAMES: u32 = 6;

/// Watches whether the wheels turn the way they are told. Once they are found exchanged, that stays so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SwappedWheels {
    in_a_row: u32,
    found: bool,
}

impl SwappedWheels {
    /// A frame period has passed in which these wheel speeds were commanded and these were measured, in rad/s.
    pub fn look(&mut self, commanded: Sides, measured: Sides) {
        let square = |x: f64| x * x;
        let straight = square(measured.left - commanded.left) + square(measured.right - commanded.right);
        let crossed = square(measured.left - commanded.right) + square(measured.right - commanded.left);
        let (turn, mean) = (commanded.right - commanded.left, (commanded.right + commanded.left) / 2.0);
        let tells = turn.abs() > LEAST_TURN_RAD_S.max(TURN_SHARE * mean.abs());
        self.in_a_row = if tells && crossed < CROSSED_SHARE * straight { self.in_a_row + 1 } else { 0 };
        self.found |= self.in_a_row >= FRAMES;
    }

    /// Whether they were ever found exchanged.
    pub fn found(&self) -> bool {
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(left: f64, right: f64) -> Sides {
        Sides { left, right }
    }

    fn found_after(frames: u32, commanded: Sides, measured: Sides) -> bool {
        let mut wheels = SwappedWheels::default();
        (0..frames).for_each(|_| wheels.look(commanded, measured));
        wheels.found()
    }

    #[test]
    fn exchanged_sides_are_found_after_a_few_frames_and_for_good() {
        let (commanded, measured) = (sides(7.0, 8.0), sides(7.9, 7.1));
        assert!(!found_after(FRAMES - 1, commanded, measured));
        assert!(found_after(FRAMES, commanded, measured));
        let mut wheels = SwappedWheels::default();
        (0..FRAMES).for_each(|_| wheels.look(commanded, measured));
        wheels.look(sides(0.0, 0.0), sides(0.0, 0.0));
        assert!(wheels.found(), "it does not start again by itself");
        // One frame that says nothing in between: from the beginning.
        let mut wheels = SwappedWheels::default();
        (0..3 * FRAMES).for_each(|i| wheels.look(commanded, if i % FRAMES == 0 { commanded } else { measured }));
        assert!(!wheels.found());
    }

    /// Obedient wheels, and what else may be wrong with them, are no exchange.
    #[test]
    fn other_faults_are_not_taken_for_it() {
        let commanded = sides(6.0, 9.0);
        for (what, measured) in [
            ("obedient", sides(6.0, 9.0)),
            ("lagging behind a turn the other way", sides(7.5, 7.5)),
            ("the right motor is dead and dragged along", sides(6.0, 6.0)),
            ("the left encoder is stuck", sides(0.0, 9.0)),
            ("the right encoder loses a tenth", sides(6.0, 8.1)),
            ("both stand", sides(0.0, 0.0)),
        ] {
            assert!(!found_after(100, commanded, measured), "{what}");
        }
        // Straight ahead nothing tells left from right.
        assert!(!found_after(100, sides(7.5, 7.6), sides(7.6, 7.5)));
        assert!(!found_after(100, sides(f64::NAN, 1.0), sides(1.0, f64::NAN)));
    }
}
