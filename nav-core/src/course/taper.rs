//! The path through a transition: from the middle of one duct to the middle of the next, which may lie aside.

use super::bend::OnPath;
use crate::ahead::{Stretch, WallChange};

/// A transition of the path. The exit duct's coordinates begin where the transition ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taper {
    /// Where the walls leave their lines, in metres along the entry duct.
    pub start_m: f64,
    /// Length of the transition, in metres.
    pub length_m: f64,
    /// How far to the left the exit duct's middle lies, in metres.
    pub aside_m: f64,
    /// Width of the exit duct, in metres.
    pub exit_width_m: f64,
}

/// Points this far off a wall's line are its own, in metres.
const NEAR_M: f64 = 0.03;
/// Walls count as straight up to this before they are not, in metres.
const MARGIN_M: f64 = 0.05;

impl Taper {
    /// Between a duct of this width and what its walls become, left and right; one that is not seen to change keeps its line.
    pub fn between(width_m: f64, changes: &[Option<WallChange>; 2]) -> Option<Self> {
        let seen = || changes.iter().flatten();
        let start_m = seen().map(|change| change.from_m).min_by(f64::total_cmp)?;
        let end_m = seen().map(|change| change.to_m).max_by(f64::total_cmp)?;
        let [left_m, right_m] = changes.map(|change| change.map_or(width_m / 2.0, |change| change.offset_m));
        let length_m = (end_m - start_m).max(NEAR_M);
        Some(Self { start_m, length_m, aside_m: (left_m - right_m) / 2.0, exit_width_m: left_m + right_m })
    }

    /// A pose in the entry duct (along, left, heading), in the exit duct's coordinates.
    pub fn exit_from_entry(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> [f64; 3] {
        [along_m - self.start_m - self.length_m, lateral_m - self.aside_m, heading_rad]
    }

    /// A pose in the exit duct, in the entry duct's coordinates.
    pub fn entry_from_exit(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> [f64; 3] {
        [along_m + self.start_m + self.length_m, lateral_m + self.aside_m, heading_rad]
    }

    /// A pose in the entry duct, against the path: the straight line from where the one duct ends to where the other begins.
    pub fn project(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> OnPath {
        let way_m = along_m - self.start_m;
        let share = (way_m / self.length_m).clamp(0.0, 1.0);
        let slope_rad = if share > 0.0 && share < 1.0 { libm::atan2(self.aside_m, self.length_m) } else { 0.0 };
        OnPath { way_m, lateral_m: lateral_m - share * self.aside_m, heading_rad: heading_rad - slope_rad, curvature_1_m: 0.0 }
    }

    /// Where the walls of the entry duct are straight.
    pub fn straight_before(&self) -> Stretch {
        Stretch { along_m: [[f64::NEG_INFINITY, self.start_m - MARGIN_M]; 2], near_m: NEAR_M, is_rough: false }
    }

    /// Where the walls of the exit duct are.
    pub fn straight_behind(&self) -> Stretch {
        Stretch { along_m: [[MARGIN_M, f64::INFINITY]; 2], near_m: NEAR_M, is_rough: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 0.5 m to 0.6 m, all of it to the left: the middle moves by half of that.
    #[test]
    fn the_middle_moves_aside_with_the_walls() {
        let left = WallChange { from_m: 3.0, to_m: 3.3, offset_m: 0.35 };
        let taper = Taper::between(0.5, &[Some(left), None]).expect("a change");
        assert!((taper.aside_m - 0.05).abs() < 1e-12 && (taper.exit_width_m - 0.6).abs() < 1e-12, "{taper:?}");
        let middle = taper.project([3.15, 0.025, libm::atan2(0.05, 0.3)]);
        assert!(middle.lateral_m.abs() < 1e-12 && middle.heading_rad.abs() < 1e-12, "{middle:?}");
        let there = taper.exit_from_entry([3.4, 0.05, 0.1]);
        assert!((there[0] - 0.1).abs() < 1e-12 && there[1].abs() < 1e-12);
        assert!(Taper::between(0.5, &[None, None]).is_none());
    }
}
