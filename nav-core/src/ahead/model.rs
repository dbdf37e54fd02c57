//! Fittings as they may lie ahead: families with a few dimensions each. Drawn as plans they are held against what rays found.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI};

use super::change::WallChange;
use super::outer::{Outer, OuterArc, OuterWall};
use super::outlook::{Fitting, Side};
use super::plan::Plan;

/// The families. The first dimension of each is where its first wall ends, in metres along the duct; the others are said here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    /// Angle, width behind.
    Mitre,
    /// Angle, radius of the inner wall.
    Radius,
    /// Length of the opening. A shoe on its near side cannot be told: its wall faces away from where the robot comes from.
    Branch,
    /// Width of the branch, and how far a shoe on the far side widens its opening.
    FarShoe,
    /// Width of the branches.
    Cross,
    /// Width of the branches.
    Bullhead,
    /// Angle of each branch against the duct, width of the branches.
    Wye,
    /// Length, how far the left wall moves outwards, and the right one.
    Transition,
    /// Length, how far the duct moves aside.
    Offset,
    /// Nothing more.
    DeadEnd,
    /// Where its middle is to the left, its width.
    Obstacle,
    /// No fitting at all: the duct goes on.
    Straight,
}

/// Most dimensions of a family.
pub(super) const MOST: usize = 4;

/// A family with its dimensions, in metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    pub(super) family: Family,
    /// To which side; of a family without one: left.
    pub(super) side: Side,
    pub(super) dimensions: [f64; MOST],
}

/// Bounds of a dimension, and the first step in which it is sought.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) step: f64,
}

/// How far walls are drawn, in metres.
const FAR_M: f64 = 5.0;
/// A piece of an arc, in radians.
const GORE_RAD: f64 = 0.131;
/// So long a radius elbow is looked at from within, in metres: until then its angle is known.
const INSIDE_M: f64 = 1.2;
/// What a thing in the duct costs.
const THING: f64 = 0.015;
/// Dimensions within this of what they were are the same ones, found anew: metres or radians.
const SAME: f64 = 0.3;
/// What a radian more than a right angle costs.
const FARTHER_1_RAD: f64 = 0.008;
/// What stands in a duct is taken to be this long, in metres: little is seen of its sides.
const DEEP_M: f64 = 0.1;
/// A transition moves at least one wall by so much, in metres; less is a bead or a dent.
const LEAST_MOVE_M: f64 = 0.02;
/// An offset goes aside by no less than this share of its length (5 degrees): seen with a heading that is a degree off, a straight duct seems
/// to go aside.
const LEAST_SLOPE: f64 = 0.08;

const fn bounds(least: f64, most: f64, step: f64) -> Bounds {
    Bounds { least, most, step }
}

impl Family {
    /// Bounds of the dimensions behind the first, in a duct of this width.
    pub(super) fn bounds(self, width_m: f64) -> ([Bounds; MOST - 1], usize) {
        let none = bounds(0.0, 0.0, 0.0);
        let branch = bounds(0.4 * width_m, 2.2 * width_m, 0.1);
        let shoe = bounds(0.06, 0.6 * width_m, 0.06);
        match self {
            Self::Mitre => ([bounds(0.3, 2.5, 0.15), bounds(0.45 * width_m, 2.2 * width_m, 0.1), none], 2),
            Self::Radius => ([bounds(0.3, PI, 0.2), bounds(0.08, 2.2 * width_m, 0.15), none], 2),
            Self::Branch | Self::Cross | Self::Bullhead => ([branch, none, none], 1),
            Self::FarShoe => ([branch, shoe, none], 2),
            Self::Wye => ([bounds(0.4, 1.15, 0.1), bounds(0.4 * width_m, 1.6 * width_m, 0.1), none], 2),
            Self::Transition => {
                let moves = bounds(-0.3 * width_m, 0.45 * width_m, 0.04);
                ([bounds(0.02, 1.5, 0.15), moves, moves], 3)
            }
            Self::Offset => ([bounds(0.25, 2.5, 0.2), bounds(0.12 * width_m, 0.8 * width_m, 0.06), none], 2),
            Self::Obstacle => ([bounds(-0.5 * width_m, 0.5 * width_m, 0.06), bounds(0.02, 0.7 * width_m, 0.06), none], 2),
            Self::DeadEnd | Self::Straight => ([none, none, none], 0),
        }
    }

    /// What its other dimensions may be about: lengths in widths of the duct before it.
    pub(super) fn beginnings(self) -> &'static [[f64; MOST - 1]] {
        const MITRES: &[[f64; 3]] = &[[0.5, 1.0, 0.0], [0.8, 1.0, 0.0], [1.1, 1.0, 0.0], [FRAC_PI_2, 1.0, 0.0]];
        const RADII: &[[f64; 3]] = &[[0.5, 0.75, 0.0], [0.8, 0.75, 0.0], [FRAC_PI_2, 0.4, 0.0], [FRAC_PI_2, 0.75, 0.0]];
        const ONE: &[[f64; 3]] = &[[1.0, 0.0, 0.0]];
        const SHOES: &[[f64; 3]] = &[[1.0, 0.25, 0.0]];
        const WYES: &[[f64; 3]] = &[[FRAC_PI_6, 0.9, 0.0], [0.785, 1.0, 0.0]];
        const MOVES: &[[f64; 3]] = &[[0.5, 0.15, 0.15], [0.5, -0.12, -0.12], [0.4, 0.2, 0.0], [0.4, 0.0, 0.2]];
        const ASIDE: &[[f64; 3]] = &[[2.0, 0.5, 0.0], [1.2, 0.3, 0.0]];
        const THINGS: &[[f64; 3]] = &[[0.0, 0.3, 0.0], [0.3, 0.3, 0.0], [-0.3, 0.3, 0.0]];
        match self {
            Self::Mitre => MITRES,
            Self::Radius => RADII,
            Self::Branch | Self::Cross | Self::Bullhead => ONE,
            Self::FarShoe => SHOES,
            Self::Wye => WYES,
            Self::Transition => MOVES,
            Self::Offset => ASIDE,
            Self::Obstacle => THINGS,
            Self::DeadEnd | Self::Straight => &[[0.0; 3]],
        }
    }

    /// Whether a dimension behind the first is an angle.
    pub(super) fn is_angle(self, index: usize) -> bool {
        index == 0 && matches!(self, Self::Mitre | Self::Radius | Self::Wye)
    }

    /// Whether it is to one side.
    pub(super) fn has_side(self) -> bool {
        matches!(self, Self::Mitre | Self::Radius | Self::Branch | Self::FarShoe | Self::Offset)
    }
}

impl Model {
    /// A radius elbow that begins here, turns so far, and has an inner wall of this radius.
    pub(super) fn arc(side: Side, start_m: f64, turn_rad: f64, throat_m: f64) -> Self {
        Self { family: Family::Radius, side, dimensions: [start_m, turn_rad, throat_m, 0.0] }
    }

    /// What it is called.
    pub(super) fn fitting(&self) -> Fitting {
        match self.family {
            Family::Mitre | Family::Radius => Fitting::Elbow(self.side),
            Family::Branch | Family::FarShoe => Fitting::Branch(self.side),
            Family::Cross => Fitting::Cross,
            Family::Bullhead | Family::Wye => Fitting::BullheadTee,
            Family::Transition => Fitting::Transition,
            Family::Offset => Fitting::Offset(self.side),
            Family::DeadEnd => Fitting::DeadEnd,
            Family::Obstacle => Fitting::Obstacle,
            Family::Straight => Fitting::Straight,
        }
    }

    /// Between it and what it was found to be before, of which a share is kept, if that is much the same.
    pub(super) fn blended(&self, before: Option<Self>, share: f64) -> Self {
        let is_same = |before: &Self| {
            before.family == self.family
                && before.side == self.side
                && before.dimensions.iter().zip(&self.dimensions).all(|(a, b)| (a - b).abs() < SAME)
        };
        before.filter(is_same).map_or(*self, |before| Self {
            dimensions: std::array::from_fn(|i| share * before.dimensions[i] + (1.0 - share) * self.dimensions[i]),
            ..*self
        })
    }

    /// Where it begins, in metres along the duct.
    pub(super) fn begins_m(&self) -> f64 {
        self.dimensions[0]
    }

    /// How odd it is, as a cost: a bend that turns farther than ducts mostly do, how far an arc goes round being seen last; a thing that
    /// stands in the duct, which from afar a bend's first piece looks like.
    pub(super) fn oddity(&self) -> f64 {
        let turn_rad = self.turn_rad().unwrap_or_default().abs();
        let thing = if self.family == Family::Obstacle { THING } else { 0.0 };
        FARTHER_1_RAD * (turn_rad - FRAC_PI_2).max(0.0) + thing
    }

    /// Whether it is none of its family: no different from a straight duct, or another family's.
    pub(super) fn is_nothing(&self) -> bool {
        match (self.family, self.dimensions) {
            (Family::Transition, [_, _, left_m, right_m]) => {
                let is_straight = left_m.abs().max(right_m.abs()) < LEAST_MOVE_M;
                // Walls that move to the same side are an offset's.
                let is_offset = left_m * right_m < 0.0 && left_m.abs().min(right_m.abs()) > LEAST_MOVE_M / 2.0;
                is_straight || is_offset
            }
            (Family::Offset, [_, length_m, aside_m, _]) => aside_m < LEAST_SLOPE * length_m,
            _ => false,
        }
    }

    /// Draws it, behind a duct of this width.
    pub(super) fn draw(&self, width_m: f64, plan: &mut Plan) {
        let (half, side) = (width_m / 2.0, self.side.sign());
        let [a, p, q, r] = self.dimensions;
        plan.clear();
        let before_m = a - FAR_M;
        // Drawn as to the left.
        let mut wall = |from: [f64; 2], to: [f64; 2]| plan.wall([from[0], side * from[1]], [to[0], side * to[1]]);
        let along = |[x, y]: [f64; 2], turn: f64| {
            let (sin, cos) = libm::sincos(turn);
            [x + FAR_M * cos, y + FAR_M * sin]
        };
        match self.family {
            Family::Mitre => {
                let [inner, outer] = [[a, half], self.outer_corner(width_m)];
                wall([before_m, half], inner);
                wall(inner, along(inner, p));
                wall([before_m, -half], outer);
                wall(outer, along(outer, p));
            }
            Family::Radius => {
                let on = |radius: f64, turn: f64| {
                    let (sin, cos) = libm::sincos(turn);
                    [a + radius * sin, half + q - radius * cos]
                };
                let gores = libm::ceil(p / GORE_RAD);
                for (radius, y) in [(q, half), (q + width_m, -half)] {
                    wall([before_m, y], [a, y]);
                    let mut from = [a, y];
                    for gore in 1..=gores as usize {
                        let to = on(radius, p * gore as f64 / gores);
                        wall(from, to);
                        from = to;
                    }
                    wall(from, along(from, p));
                }
            }
            Family::Branch | Family::FarShoe => {
                let far = if self.family == Family::FarShoe { q } else { 0.0 };
                wall([before_m, -half], [a + FAR_M, -half]);
                wall([before_m, half], [a, half]);
                wall([a, half], [a, half + FAR_M]);
                let [behind, end] = [a + p, a + p + far];
                wall([behind, half + FAR_M], [behind, half + far]);
                wall([behind, half + far], [end, half]);
                wall([end, half], [a + FAR_M, half]);
            }
            Family::Cross | Family::Bullhead => {
                for half in [half, -half] {
                    let far = FAR_M.copysign(half);
                    wall([before_m, half], [a, half]);
                    wall([a, half], [a, half + far]);
                    if self.family == Family::Cross {
                        wall([a + p, half + far], [a + p, half]);
                        wall([a + p, half], [a + FAR_M, half]);
                    }
                }
                if self.family == Family::Bullhead {
                    wall([a + p, -FAR_M], [a + p, FAR_M]);
                }
            }
            Family::Wye => {
                let (sin, cos) = libm::sincos(p);
                let crotch = self.crotch(half);
                for y in [1.0, -1.0] {
                    wall([before_m, y * half], [a, y * half]);
                    wall([a, y * half], [a + FAR_M * cos, y * (half + FAR_M * sin)]);
                    wall([crotch[0], y * crotch[1]], [crotch[0] + FAR_M * cos, y * (crotch[1] + FAR_M * sin)]);
                }
                wall(crotch, [crotch[0], -crotch[1]]);
            }
            Family::Transition => {
                for (y, moved) in [(1.0, q), (-1.0, r)] {
                    wall([before_m, y * half], [a, y * half]);
                    wall([a, y * half], [a + p, y * (half + moved)]);
                    wall([a + p, y * (half + moved)], [a + FAR_M, y * (half + moved)]);
                }
            }
            Family::Offset => {
                // Two equal arcs, one against the other.
                let turn = 2.0 * libm::atan2(q, p);
                let radius = p / (2.0 * libm::sin(turn));
                let gores = libm::ceil(2.0 * turn / GORE_RAD).max(2.0) as usize;
                for y in [half, -half] {
                    let mut from = [a, y];
                    wall([before_m, y], from);
                    for gore in 1..=gores {
                        let share = gore as f64 / gores as f64;
                        let angle = if share < 0.5 { 2.0 * share * turn } else { 2.0 * (1.0 - share) * turn };
                        let (sin, cos) = libm::sincos(angle);
                        let middle = if share < 0.5 {
                            [a + radius * sin, radius * (1.0 - cos)]
                        } else {
                            [a + p - radius * sin, q - radius * (1.0 - cos)]
                        };
                        let to = [middle[0] - y * sin, middle[1] + y * cos];
                        wall(from, to);
                        from = to;
                    }
                    wall(from, [a + FAR_M, q + y]);
                }
            }
            Family::DeadEnd => {
                wall([before_m, half], [a, half]);
                wall([before_m, -half], [a, -half]);
                wall([a, half], [a, -half]);
            }
            Family::Obstacle | Family::Straight => {
                wall([before_m, half], [a + FAR_M, half]);
                wall([before_m, -half], [a + FAR_M, -half]);
                if self.family == Family::Obstacle {
                    let [right, left] = [(p - q / 2.0).max(-half), (p + q / 2.0).min(half)];
                    wall([a, right], [a, left]);
                    wall([a, right], [a + DEEP_M, right]);
                    wall([a, left], [a + DEEP_M, left]);
                }
            }
        }
    }

    /// A mitre's outer corner, as to the left.
    fn outer_corner(&self, width_m: f64) -> [f64; 2] {
        let [a, turn, behind_m, _] = self.dimensions;
        let (sin, cos) = libm::sincos(turn);
        // The outer wall runs `behind_m` to the right of the inner corner, and meets this duct's right wall.
        let through = [a + behind_m * sin, width_m / 2.0 - behind_m * cos];
        [through[0] + (-width_m / 2.0 - through[1]) * cos / sin, -width_m / 2.0]
    }

    /// Where a wye's branches part: on the middle, or the left end of a flat wall.
    fn crotch(&self, half_m: f64) -> [f64; 2] {
        let [a, turn, branch_m, _] = self.dimensions;
        let (sin, cos) = libm::sincos(turn);
        let along_m = ((branch_m * cos - half_m) / sin).max(0.0);
        [a + branch_m * sin + along_m * cos, half_m - branch_m * cos + along_m * sin]
    }

    /// Where the robot has left it behind when it goes straight on, in metres along the duct.
    pub(super) fn ends_m(&self) -> f64 {
        let [a, p, ..] = self.dimensions;
        match self.family {
            Family::Radius => a + INSIDE_M,
            Family::Transition | Family::Offset => a + p,
            _ => self.openings().into_iter().flatten().fold(a, |most, [_, to_m]| most.max(to_m)),
        }
    }

    /// Where walls are open along the duct, left and right, in metres.
    pub(super) fn openings(&self) -> [Option<[f64; 2]>; 2] {
        let [a, p, q, _] = self.dimensions;
        let open = match self.family {
            Family::Mitre => [a, a + q],
            Family::Branch | Family::Cross | Family::Bullhead => [a, a + p],
            Family::FarShoe => [a, a + p + q],
            Family::Wye => [a, a + q],
            Family::Radius => [a, a + q],
            _ => return [None, None],
        };
        match self.side {
            _ if !self.family.has_side() => [Some(open); 2],
            Side::Left => [Some(open), None],
            Side::Right => [None, Some(open)],
        }
    }

    /// What the way to this side turns along, from a duct of this width; `None` where there is no such way.
    pub(super) fn outer(&self, side: Side, width_m: f64) -> Option<Outer> {
        let [a, p, q, _] = self.dimensions;
        let sign = side.sign();
        let wall = |turn_rad: f64, [x, y]: [f64; 2], width_m: f64| {
            Some(Outer::Wall(OuterWall { turn_rad: sign * turn_rad, point_m: [x, sign * y], width_m }))
        };
        match self.family {
            _ if self.family.has_side() && side != self.side => None,
            Family::Mitre => wall(p, self.outer_corner(width_m), q),
            Family::Radius => Some(Outer::Arc(OuterArc { start_m: a, radius_m: q + width_m, turn_rad: sign * p })),
            // An opening that is wider than the duct is one with a shoe.
            Family::Branch | Family::FarShoe => wall(FRAC_PI_2, [a + p, 0.0], p.min(width_m)),
            Family::Cross | Family::Bullhead => wall(FRAC_PI_2, [a + p, 0.0], p),
            Family::Wye => wall(p, self.crotch(width_m / 2.0), q),
            _ => None,
        }
    }

    /// How the left and the right wall move, where the duct goes on without a bend.
    pub(super) fn changes(&self, width_m: f64) -> [Option<WallChange>; 2] {
        let [from_m, length_m, q, r] = self.dimensions;
        let change = |moved_m: f64| Some(WallChange { from_m, to_m: from_m + length_m, offset_m: width_m / 2.0 + moved_m });
        match self.family {
            Family::Transition => [change(q), change(r)],
            Family::Offset => [change(self.side.sign() * q), change(-self.side.sign() * q)],
            _ => [None, None],
        }
    }

    /// Angle of an elbow, positive to the left, in radians.
    pub(super) fn turn_rad(&self) -> Option<f64> {
        matches!(self.family, Family::Mitre | Family::Radius).then(|| self.side.sign() * self.dimensions[1])
    }

    /// Radius of the middle of a radius elbow, in metres.
    pub(super) fn radius_m(&self, width_m: f64) -> Option<f64> {
        (self.family == Family::Radius).then(|| self.dimensions[2] + width_m / 2.0)
    }

    /// Width of the duct behind an elbow or a transition, in metres.
    pub(super) fn width_behind_m(&self, width_m: f64) -> Option<f64> {
        let [_, _, q, r] = self.dimensions;
        match self.family {
            Family::Mitre => Some(q),
            Family::Radius | Family::Offset => Some(width_m),
            Family::Transition => Some(width_m + q + r),
            _ => None,
        }
    }
}
