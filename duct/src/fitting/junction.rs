//! Fittings with more than two ports: boxes with ports in their sides, the shoe of a side branch, the legs of a wye.

use nalgebra::Point2;

use super::Hand;
use super::parts::{Part, Role};
use super::port::PortName;

/// What is shorter than this is rounding.
const ROUNDING_M: f64 = 1e-9;

/// A box over x from 0 to `length_m` with these roles: at the entry, right, ahead, left.
fn body(length_m: f64, width_m: f64, height_m: f64, [entry, right, ahead, left]: [Role; 4]) -> Part {
    let half = width_m / 2.0;
    let at = Point2::new;
    let sides = [(at(0.0, half), entry), (at(0.0, -half), right), (at(length_m, -half), ahead), (at(length_m, half), left)];
    Part::level(&sides, height_m)
}

fn on_side(hand: Hand, parts: Vec<Part>) -> Vec<Part> {
    match hand {
        Hand::Left => parts,
        Hand::Right => parts.into_iter().map(Part::mirrored).collect(),
    }
}

const IN: Role = Role::Port(PortName::In);
const OUT: Role = Role::Port(PortName::Out);
const LEFT: Role = Role::Port(PortName::Left);
const RIGHT: Role = Role::Port(PortName::Right);

pub(super) fn tee(hand: Hand, width_m: f64, height_m: f64, branch_width_m: f64) -> Vec<Part> {
    on_side(hand, vec![body(branch_width_m, width_m, height_m, [IN, Role::Wall, OUT, LEFT])])
}

pub(super) fn bullhead(width_m: f64, height_m: f64, branch_width_m: f64) -> Vec<Part> {
    vec![body(branch_width_m, width_m, height_m, [IN, RIGHT, Role::Wall, LEFT])]
}

pub(super) fn cross(width_m: f64, height_m: f64, branch_width_m: f64) -> Vec<Part> {
    vec![body(branch_width_m, width_m, height_m, [IN, RIGHT, OUT, LEFT])]
}

/// The duct, and the shoe beside it: a trapezium that starts as wide as its opening and ends as wide as the branch.
pub(super) fn side_branch(hand: Hand, [width_m, height_m]: [f64; 2], branch_width_m: f64, shoe_m: f64) -> Vec<Part> {
    let (half, length_m) = (width_m / 2.0, shoe_m + branch_width_m);
    let at = Point2::new;
    let shoe = [
        (at(0.0, half), Role::Part(0)),
        (at(length_m, half), Role::Wall),
        (at(length_m, half + shoe_m), LEFT),
        (at(shoe_m, half + shoe_m), Role::Wall),
    ];
    let duct = body(length_m, width_m, height_m, [IN, Role::Wall, OUT, Role::Part(1)]);
    on_side(hand, vec![duct, Part::level(&shoe, height_m)])
}

/// The plan of a wye. Each branch's outer wall goes out from the stem's wall at the half angle. Wide branches meet in a crotch on the
/// middle; between narrow ones a flat wall is left.
pub(super) struct WyePlan {
    half_m: f64,
    branch_width_m: f64,
    /// Direction of the left branch.
    sin_cos: (f64, f64),
    /// Length of the stem before the branches part: as long as the path needs to turn out of the middle.
    stem_m: f64,
    /// Length of a branch's outer wall.
    leg_m: f64,
}

impl WyePlan {
    pub(super) fn new(width_m: f64, branch_width_m: f64, half_angle_rad: f64) -> Self {
        let (s, c) = libm::sincos(half_angle_rad);
        // Branch and stem meet, in their middles, this far behind where the walls part.
        let meet_m = (branch_width_m - width_m * c) / (2.0 * s);
        let tangent_m = width_m.min(branch_width_m) / 2.0 * libm::tan(half_angle_rad / 2.0);
        let stem_m = tangent_m - meet_m;
        Self {
            half_m: width_m / 2.0,
            branch_width_m,
            sin_cos: (s, c),
            stem_m: if stem_m > ROUNDING_M { stem_m } else { 0.0 },
            leg_m: ((branch_width_m * c - width_m / 2.0) / s).max(0.0),
        }
    }

    /// Outer and inner corner of the left branch's port.
    fn port_corners(&self) -> [Point2<f64>; 2] {
        let (s, c) = self.sin_cos;
        let outer = Point2::new(self.stem_m + self.leg_m * c, self.half_m + self.leg_m * s);
        let inner_y = self.half_m + self.leg_m * s - self.branch_width_m * c;
        [outer, Point2::new(outer.x + self.branch_width_m * s, if inner_y > ROUNDING_M { inner_y } else { 0.0 })]
    }

    /// Middle of the left branch's port.
    pub(super) fn port_middle(&self) -> Point2<f64> {
        let [outer, inner] = self.port_corners();
        nalgebra::center(&outer, &inner)
    }

    pub(super) fn parts(&self, height_m: f64) -> Vec<Part> {
        let at = Point2::new;
        let (left, right) = (at(self.stem_m, self.half_m), at(self.stem_m, -self.half_m));
        let [outer, inner] = self.port_corners();
        let mirrored = |p: Point2<f64>| at(p.x, -p.y);
        let mut parts = Vec::new();
        let mut before = IN;
        if self.stem_m > 0.0 {
            parts.push(body(self.stem_m, 2.0 * self.half_m, height_m, [IN, Role::Wall, Role::Part(1), Role::Wall]));
            before = Role::Part(0);
        }
        let fork = parts.len();
        if self.leg_m > ROUNDING_M {
            let [left_leg, right_leg] = [Role::Part(fork + 1), Role::Part(fork + 2)];
            parts.push(Part::level(&[(left, before), (right, right_leg), (inner, left_leg)], height_m));
            parts.push(Part::level(&[(left, Role::Part(fork)), (inner, LEFT), (outer, Role::Wall)], height_m));
            parts.push(Part::level(&[(right, Role::Wall), (mirrored(outer), RIGHT), (inner, Role::Part(fork))], height_m));
        } else if inner.y > 0.0 {
            let sides = [(left, before), (right, RIGHT), (mirrored(inner), Role::Wall), (inner, LEFT)];
            parts.push(Part::level(&sides, height_m));
        } else {
            parts.push(Part::level(&[(left, before), (right, RIGHT), (inner, LEFT)], height_m));
        }
        parts
    }
}
