//! The path through a bend: along the duct before it, an arc, and along the duct behind it.

use std::f64::consts::PI;

use crate::ahead::{OuterArc, OuterWall, Stretch};

/// A bend of the path. Both ducts' coordinates have their origin on the duct's middle: the entry's where its odometry has it, the exit's
/// where the arc ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Where the arc begins, in metres along the entry duct.
    pub start_m: f64,
    /// Radius of the arc, in metres.
    pub radius_m: f64,
    /// The turn, positive to the left, in radians.
    pub turn_rad: f64,
    /// Width of the exit duct, in metres.
    pub exit_width_m: f64,
    /// Where the wall on the outer side ends to be straight, in metres along the entry duct.
    pub outer_end_m: f64,
}

/// Walls count as straight up to this before they are not, in metres: an arc leaves its tangent by little at first, and one that is only
/// just off it turns the robot with it.
const MARGIN_M: f64 = 0.15;
/// So much of an arc is left, in radians, when its end has been in sight for a while: with radii of 0.75 and 1.75 widths a robot in its
/// middle sees 117 degrees round.
const LAST_RAD: f64 = 0.55;
/// Points this far off a wall's line are its own, in metres: before a bend the robot knows its place, behind it only by its wheels.
const NEAR_BEFORE_M: f64 = 0.04;
const NEAR_BEHIND_M: f64 = 0.04;

/// Where the robot is against the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OnPath {
    /// Way along the path from the arc's beginning, in metres: negative before it.
    pub way_m: f64,
    /// Offset to the left of the path, in metres.
    pub lateral_m: f64,
    /// Heading against the path, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Curvature of the path there, positive to the left, in 1/m.
    pub curvature_1_m: f64,
}

impl Bend {
    /// The arc tangent to the middle of both ducts, its radius half the narrower one's width. The exit duct's middle runs along the outer wall, half its width inside it.
    pub fn along(wall: &OuterWall, entry_width_m: f64) -> Self {
        let (sin, cos) = libm::sincos(wall.turn_rad);
        let side = wall.turn_rad.signum();
        // From a point of the outer wall inwards: to the left of its direction, for a bend to the left.
        let half_m = side * wall.width_m / 2.0;
        let middle = [wall.point_m[0] - sin * half_m, wall.point_m[1] + cos * half_m];
        // Where it crosses the middle of the entry duct.
        let corner_m = middle[0] - middle[1] * cos / sin;
        let radius_m = entry_width_m.min(wall.width_m) / 2.0;
        let tangent_m = radius_m * libm::tan(wall.turn_rad.abs() / 2.0);
        // The outer wall meets this duct's wall on the outer side.
        let outer_y_m = -side * entry_width_m / 2.0;
        let outer_end_m = wall.point_m[0] + (outer_y_m - wall.point_m[1]) * cos / sin;
        Self { start_m: corner_m - tangent_m, radius_m, turn_rad: wall.turn_rad, exit_width_m: wall.width_m, outer_end_m }
    }

    /// The arc in the middle of a radius elbow, which is as wide as the duct before it.
    pub fn within(arc: &OuterArc, width_m: f64) -> Self {
        let radius_m = (arc.radius_m - width_m / 2.0).max(width_m / 4.0);
        Self { start_m: arc.start_m, radius_m, turn_rad: arc.turn_rad, exit_width_m: width_m, outer_end_m: arc.start_m }
    }

    /// Where the walls of the entry duct are straight.
    pub fn straight_before(&self) -> Stretch {
        let (inner, outer) = ([f64::NEG_INFINITY, self.start_m - MARGIN_M], [f64::NEG_INFINITY, self.outer_end_m - MARGIN_M]);
        Stretch {
            along_m: if self.turn_rad > 0.0 { [inner, outer] } else { [outer, inner] },
            near_m: NEAR_BEFORE_M,
            is_rough: false,
        }
    }

    /// Where the walls of the exit duct are straight. A wall that is no arc reaches back to where it meets the entry's.
    pub fn straight_behind(&self) -> Stretch {
        let back_m = if self.outer_end_m > self.start_m { -self.radius_m } else { 0.0 };
        let (inner, outer) = ([0.0, f64::INFINITY], [back_m, f64::INFINITY]);
        Stretch {
            along_m: if self.turn_rad > 0.0 { [inner, outer] } else { [outer, inner] },
            near_m: NEAR_BEHIND_M,
            is_rough: true,
        }
    }

    /// Whether the walls themselves are arcs.
    pub fn is_arc(&self) -> bool {
        self.outer_end_m == self.start_m
    }

    /// Length of the arc, in metres.
    pub fn length_m(&self) -> f64 {
        self.radius_m * self.turn_rad.abs()
    }

    /// Where the robot changes over to the duct behind it, as a way from its beginning, in metres: in its middle; of an arc that goes far
    /// round, whose end is out of sight there, later.
    pub fn settled_m(&self) -> f64 {
        let half_m = self.length_m() / 2.0;
        if self.is_arc() { half_m.max(self.length_m() - LAST_RAD * self.radius_m) } else { half_m }
    }

    /// Place and direction of the arc's end in the entry duct: along, to the left, and the turn.
    fn end(&self) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.turn_rad.abs());
        [self.start_m + self.radius_m * sin, self.turn_rad.signum() * self.radius_m * (1.0 - cos)]
    }

    /// A pose in the entry duct (along, left, heading), in the exit duct's coordinates.
    pub fn exit_from_entry(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.turn_rad);
        let end = self.end();
        let (ds, dy) = (along_m - end[0], lateral_m - end[1]);
        [cos * ds + sin * dy, -sin * ds + cos * dy, heading_rad - self.turn_rad]
    }

    /// A pose in the exit duct, in the entry duct's coordinates.
    pub fn entry_from_exit(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.turn_rad);
        let end = self.end();
        [end[0] + cos * along_m - sin * lateral_m, end[1] + sin * along_m + cos * lateral_m, heading_rad + self.turn_rad]
    }

    /// A pose in the entry duct, against the path.
    pub fn project(&self, [along_m, lateral_m, heading_rad]: [f64; 3]) -> OnPath {
        let side = self.turn_rad.signum();
        // The arc's centre stands beside its beginning.
        let (dx, dy) = (along_m - self.start_m, self.radius_m - side * lateral_m);
        if dx <= 0.0 && dy > 0.0 {
            return OnPath { way_m: along_m - self.start_m, lateral_m, heading_rad, curvature_1_m: 0.0 };
        }
        let angle = libm::atan2(dx, dy).rem_euclid(2.0 * PI);
        if angle <= self.turn_rad.abs() {
            let lateral_m = side * (self.radius_m - (dx * dx + dy * dy).sqrt());
            return OnPath {
                way_m: angle * self.radius_m,
                lateral_m,
                heading_rad: heading_rad - side * angle,
                curvature_1_m: side / self.radius_m,
            };
        }
        let [beyond_m, lateral_m, heading_rad] = self.exit_from_entry([along_m, lateral_m, heading_rad]);
        OnPath { way_m: self.length_m() + beyond_m, lateral_m, heading_rad, curvature_1_m: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn wall(turn_rad: f64, point_m: [f64; 2], width_m: f64) -> OuterWall {
        OuterWall { turn_rad, point_m, width_m }
    }

    /// A square elbow to the left in a duct of 0.5 m whose front wall stands at 3.5 m: the arc is about the inner corner at (3, 0.25).
    #[test]
    fn a_square_elbow_is_turned_about_its_inner_corner() {
        let bend = Bend::along(&wall(FRAC_PI_2, [3.5, 0.1], 0.5), 0.5);
        assert!((bend.outer_end_m - 3.5).abs() < 1e-12);
        assert!((bend.start_m - 3.0).abs() < 1e-12 && (bend.radius_m - 0.25).abs() < 1e-12, "{bend:?}");
        let end = bend.entry_from_exit([0.0; 3]);
        assert!((end[0] - 3.25).abs() < 1e-12 && (end[1] - 0.25).abs() < 1e-12 && (end[2] - FRAC_PI_2).abs() < 1e-12);
    }

    /// An elbow of half a circle comes back beside where it began: behind it a place is behind it, though it is not farther along.
    #[test]
    fn half_a_circle_is_left_backwards() {
        for turn in [PI, -PI] {
            let bend = Bend::within(&OuterArc { start_m: 2.0, radius_m: 0.875, turn_rad: turn }, 0.5);
            for [along, lateral] in [[-0.2, 0.01], [0.0, -0.02], [0.4, 0.0]] {
                let on = bend.project(bend.entry_from_exit([along, lateral, 0.1]));
                assert!((on.way_m - bend.length_m() - along).abs() < 0.02, "{along} {on:?}");
                assert!((on.lateral_m - lateral).abs() < 0.04, "{along} {lateral} {on:?}");
            }
            assert!((bend.project([1.5, 0.02, 0.0]).way_m + 0.5).abs() < 1e-12);
            // Its end is out of sight in its middle.
            assert!(bend.settled_m() > 0.7 * bend.length_m() && bend.settled_m() < bend.length_m());
        }
    }

    /// To the right all is mirrored, and for any angle the path's pieces meet.
    #[test]
    fn bends_are_mirrored_and_their_pieces_meet() {
        for turn_deg in [30.0_f64, 45.0, 90.0, 120.0] {
            let turn = turn_deg.to_radians();
            let (sin, cos) = libm::sincos(turn);
            // Outer wall through the outer corner of a mitre of 0.4 m whose inner corner is at (2, 0.2).
            let outer = [2.0 + 0.4 * libm::tan(turn / 2.0), -0.2];
            let left = Bend::along(&wall(turn, [outer[0] + cos, outer[1] + sin], 0.4), 0.4);
            let right = Bend::along(&wall(-turn, [outer[0] + cos, -outer[1] - sin], 0.4), 0.4);
            assert!((left.start_m - 2.0).abs() < 1e-9 && (right.start_m - 2.0).abs() < 1e-9, "{turn_deg}: {left:?}");
            for share in [0.0, 0.3, 0.7, 1.0] {
                let angle = share * turn;
                let at = [left.start_m + left.radius_m * libm::sin(angle), left.radius_m * (1.0 - libm::cos(angle)), angle];
                let on = left.project(at);
                assert!(on.lateral_m.abs() < 1e-9 && on.heading_rad.abs() < 1e-9, "{turn_deg} {share}: {on:?}");
                assert!((on.way_m - share * left.length_m()).abs() < 1e-9);
                let mirrored = right.project([at[0], -at[1], -at[2]]);
                assert!((mirrored.way_m - on.way_m).abs() < 1e-9 && mirrored.lateral_m.abs() < 1e-9);
            }
            let beyond = left.entry_from_exit([0.3, 0.02, 0.1]);
            let on = left.project(beyond);
            assert!((on.way_m - left.length_m() - 0.3).abs() < 1e-9 && (on.lateral_m - 0.02).abs() < 1e-9);
            let back = left.exit_from_entry(beyond);
            assert!((back[0] - 0.3).abs() < 1e-9 && (back[1] - 0.02).abs() < 1e-9 && (back[2] - 0.1).abs() < 1e-9);
        }
    }
}
