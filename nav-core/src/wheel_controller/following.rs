//! Whether the wheels do what they are told: a dead motor, an encoder that counts no more or a wheel that is held shows by a speed that
//! stays away from its set-point. A loop that went on would only push harder, blindly where it is the encoder, so the motors are cut off.

use crate::messages::Sides;

/// A wheel may be off its set-point by this share of it, or by so much if that is more, in rad/s, without being called off it: what
/// acceleration, a bead or a slipping wheel cost for a while.
const SHARE: f64 = 0.25;
const LEAST_RAD_S: f64 = 1.0;

/// Counts for how long a side has been off its set-point. Once it has been for too long, that stays so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Following {
    limit: u32,
    off: [u32; 2],
    has_failed: bool,
}

impl Following {
    /// Too long is `limit` ticks in a row.
    pub fn new(limit: u32) -> Self {
        Self { limit, off: [0; 2], has_failed: false }
    }

    /// A tick passes with these set-points and measured speeds, in rad/s; says whether a side has been off for too long.
    pub fn tick(&mut self, target_rad_s: Sides, measured_rad_s: Sides) -> bool {
        let sides = [(target_rad_s.left, measured_rad_s.left), (target_rad_s.right, measured_rad_s.right)];
        for (ticks, (target, measured)) in self.off.iter_mut().zip(sides) {
            let is_off = (target - measured).abs() > LEAST_RAD_S.max(SHARE * target.abs());
            *ticks = if is_off { ticks.saturating_add(1) } else { 0 };
            self.has_failed |= *ticks > self.limit;
        }
        self.has_failed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(left: f64, right: f64) -> Sides {
        Sides { left, right }
    }

    #[test]
    fn a_side_that_stays_off_is_found_after_the_limit_and_for_good() {
        let mut following = Following::new(5);
        let said: Vec<bool> = (0..8).map(|_| following.tick(sides(7.5, 7.5), sides(7.4, 0.0))).collect();
        assert_eq!(said, [false, false, false, false, false, true, true, true]);
        assert!(following.tick(sides(0.0, 0.0), sides(0.0, 0.0)), "it does not start again by itself");
    }

    #[test]
    fn what_passes_is_let_pass() {
        let mut following = Following::new(5);
        // Off for five ticks, then there for one, and so on; and off by less than a quarter all the time.
        for tick in 0..100 {
            let measured = if tick % 6 == 0 { 7.5 } else { 0.0 };
            assert!(!following.tick(sides(7.5, 8.0), sides(measured, 6.1)), "tick {tick}");
        }
    }
}
