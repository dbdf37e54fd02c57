//! Where ducts end, by which angle they are left, and how sure both are.
//!
//! A way turns along a wall: the outer one of a mitred elbow, the far one of a branch, the one across a bull-head tee's stem; a dead end is
//! one. The robot sees it from the duct before it, all the way up to the bend, while it knows its heading by that duct's walls. So a line
//! is fitted to what was seen about where the log has that wall: its direction against the duct is the turn, its place is where the duct
//! ends. Each piece of the way has a line of its own. Their mean counts, and its deviation is
//!
//! - what these lines scatter by (standard error of the mean);
//! - what all have in common: a twentieth of a pixel, carried through the fit;
//! - for the turn, the filter's deviation of the robot's own heading.
//!
//! Where a duct begins, behind a bend, it knows by its wheels:
//!
//! - turning about a point x_ICR ahead of its base it moves aside by x_ICR times the turn's sine, and turning round it moves on by twice
//!   that. x_ICR is 9 mm in bends and 0.4 mm on the spot, and one state of the filter cannot be both: behind its first bends it states 2 mm
//!   and is off by up to 12. So what counts is the deviation that it is told at first;
//! - an effective track that is off by a share turns it by that share too far all the way round the arc: the filter's deviation of the
//!   heading where it changes over to the next duct.
//!
//! And along a duct the wheels' scale counts, of which nothing on board knows.
//!
//! What it does not do: arcs, transitions and offsets have no wall across the way, and what is fitted to them states no deviation; of an
//! arc's turn, that of the heading from which its end was seen.

use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI};

use super::COMMON_1_M;
use crate::ahead::{DuctPlace, Fitting};
use crate::course::DuctRecord;
use crate::perception::{RangePoint, Upon};

/// Points are kept over this much of the way, in metres, and up to this far from the base.
const WAY_M: f64 = 1.2;
const FARTHEST_M: f64 = 1.5;
/// Points this near to the line of a side wall are that wall's, in metres.
const BESIDE_WALL_M: f64 = 0.03;
/// Headings beyond which the robot is turning, in radians.
const TURNING_RAD: f64 = 0.15;
/// Points this near to where the log has the wall may be its own, in metres; they are chosen anew about the line found, each time within
/// this share of the distance before.
const NEAR_M: f64 = 0.06;
const CLOSER: f64 = 0.6;
const CHOICES: usize = 3;
/// A wall begins this far behind the corner that it comes from, in metres.
const MARGIN_M: f64 = 0.03;
/// Standard deviation of a point, in metres.
const POINT_M: f64 = 0.004;
/// A piece of the way, in metres; the fewest points and the least stretch of the wall in one, in metres; and fewest pieces.
const PIECE_M: f64 = 0.1;
const FEWEST_POINTS: usize = 20;
const SHORTEST_M: f64 = 0.12;
const FEWEST_PIECES: usize = 3;
/// Turns beyond this are the robot's own, on the spot, in radians.
const ROUND_RAD: f64 = 0.9 * PI;
/// An arc's radius is larger than this share of the width.
const ARC_WIDTHS: f64 = 0.55;
/// What odometry is off by, as a share of the way: over the library's straights 0.08 % RMS.
const WAY_SHARE: f64 = 0.001;

/// What a frame shows that is no side wall, in the duct's coordinates.
#[derive(Clone, Debug, PartialEq)]
struct Sight {
    /// Where the robot was, in metres: along, to the left.
    base_m: [f64; 2],
    /// Deviation of its heading, in radians.
    heading_sigma_rad: f64,
    points: Vec<[f64; 2]>,
}

/// How sure the robot is of itself, as the filter states it: standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sureness {
    /// Of its heading, in radians.
    pub heading_rad: f64,
    /// Of how far its centre of rotation lies ahead of its base, in metres.
    pub icr_m: f64,
}

/// A figure with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// What.
    pub value: f64,
    /// Its standard deviation.
    pub sigma: f64,
}

/// Where a duct begins and ends, in metres along it, and by which turn it was left, positive to the left, in radians. What no deviation is
/// known of is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DuctEnds {
    /// Where it begins.
    pub begin_m: Option<Figure>,
    /// Where it ends, by the wall along which the way turns or before which it stops.
    pub end_m: Option<Figure>,
    /// The turn.
    pub turn_rad: Option<Figure>,
}

/// How a duct was left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Leaving {
    /// Where the wall along which the way turns, or before which it stops, crosses the duct's middle, in metres along it.
    wall_m: Option<Figure>,
    turn_rad: Option<Figure>,
    /// What the wheels leave in doubt of the way round, along the next duct, in metres.
    round_sigma_m: f64,
}

/// The ends of all ducts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ends {
    left: Vec<Leaving>,
    /// Of the present duct, over the last piece of the way.
    seen: VecDeque<Sight>,
    /// Heading in its duct at the last frame, with its deviation.
    last: Option<Figure>,
    /// The largest deviation of x_ICR that was stated, in metres.
    icr_sigma_m: f64,
}

/// Where a wall is thought to be: a point of it, its direction, and from where to where along it.
#[derive(Clone, Copy, Debug)]
struct Line {
    point_m: [f64; 2],
    direction_rad: f64,
    from_m: f64,
    to_m: f64,
}

/// A wall as it was found: how far it is turned and moved, to the left of its direction, from where it was thought to be.
#[derive(Clone, Copy, Debug)]
struct Found {
    turned_rad: Figure,
    moved_m: Figure,
}

impl DuctEnds {
    /// Deviation of a duct's length of so much, in metres.
    pub fn length_sigma_m(&self, length_m: f64) -> Option<f64> {
        Some(libm::hypot(libm::hypot(self.begin_m?.sigma, self.end_m?.sigma), WAY_SHARE * length_m))
    }
}

impl Ends {
    /// Takes in a frame that was exposed at `place` of the last of these ducts.
    pub fn take(&mut self, ducts: &[DuctRecord], place: &DuctPlace, sureness: &Sureness, ranges: &[RangePoint]) {
        self.icr_sigma_m = self.icr_sigma_m.max(sureness.icr_m);
        while self.left.len() + 1 < ducts.len() {
            self.change_over(ducts, self.left.len());
        }
        self.last = Some(Figure { value: place.heading_rad, sigma: sureness.heading_rad });
        if place.heading_rad.abs() > TURNING_RAD {
            return;
        }
        let half_m = place.width_m / 2.0;
        let is_own = |point: &&RangePoint| point.upon == Upon::Upright && point.point_in_base.coords.xy().norm() < FARTHEST_M;
        let in_duct = |point: &RangePoint| place.duct_from_base(point.point_in_base.x, point.point_in_base.y);
        let points = ranges.iter().filter(is_own).map(in_duct).filter(|[_, y]| (y.abs() - half_m).abs() > BESIDE_WALL_M);
        let heading_sigma_rad = sureness.heading_rad;
        self.seen.push_back(Sight { base_m: [place.along_m, place.lateral_m], heading_sigma_rad, points: points.collect() });
        while self.seen.front().is_some_and(|sight| (place.along_m - sight.base_m[0]).abs() > WAY_M) {
            self.seen.pop_front();
        }
    }

    /// The ends of the duct with this number, as the log has them by now.
    pub fn of(&self, ducts: &[DuctRecord], number: usize) -> DuctEnds {
        let Some(duct) = ducts.get(number) else { return DuctEnds::default() };
        let leaving = self.left.get(number);
        let end_m = match leaving {
            Some(leaving) if turned_round(duct) => leaving.wall_m,
            Some(leaving) => leaving.corner(ducts, number).map(|corner| corner.end_m),
            // It may stand before the wall of the present one.
            None => self.wall(duct),
        };
        DuctEnds { begin_m: self.begin_m(ducts, number), end_m, turn_rad: leaving.and_then(|leaving| leaving.turn_rad) }
    }

    fn begin_m(&self, ducts: &[DuctRecord], number: usize) -> Option<Figure> {
        let Some(before) = number.checked_sub(1) else {
            // The first one begins where the robot does.
            return Some(Figure { value: 0.0, sigma: 0.0 });
        };
        let leaving = self.left.get(before)?;
        if turned_round(&ducts[before]) {
            // What it turned back before is where the way back begins.
            let (wall_m, at_m) = (leaving.wall_m?, ducts[before].to_m?);
            return Some(Figure { value: at_m - wall_m.value, sigma: libm::hypot(wall_m.sigma, leaving.round_sigma_m) });
        }
        let Corner { begin_m, end_m } = leaving.corner(ducts, before)?;
        let cos = libm::cos(leaving.turn_rad?.value);
        Some(Figure { value: begin_m, sigma: libm::hypot(leaving.round_sigma_m, cos * end_m.sigma) })
    }

    /// The robot has left this duct for the next one.
    fn change_over(&mut self, ducts: &[DuctRecord], left: usize) {
        let (duct, next) = (&ducts[left], &ducts[left + 1]);
        let turn_rad = duct.turn_rad;
        let leaving = if turned_round(duct) {
            Leaving { wall_m: self.wall(duct), turn_rad: None, round_sigma_m: 2.0 * self.icr_sigma_m }
        } else if let Some(line) = line(duct, next.width_m) {
            let found = found(&self.seen, &line);
            let sin = libm::sin(turn_rad);
            let wall_m = corner_m(duct) + next.width_m / (2.0 * sin.abs());
            // How wrong the heading was where it changed over, as a share of the turn up to there; and all the way round.
            let share = self.last.map_or(0.0, |last| last.sigma / last.value.abs().max(turn_rad.abs() / 4.0));
            let too_far_m = share * duct.radius_m * (turn_rad.abs() - sin.abs());
            Leaving {
                wall_m: found
                    .map(|found| Figure { value: wall_m - found.moved_m.value / sin, sigma: found.moved_m.sigma / sin.abs() }),
                turn_rad: found.map(|found| Figure { value: turn_rad + found.turned_rad.value, ..found.turned_rad }),
                round_sigma_m: libm::hypot(self.icr_sigma_m * sin, too_far_m),
            }
        } else {
            // An arc: its end was seen from where the heading was as sure as it was then.
            let turn_rad = self.last.filter(|_| turn_rad != 0.0).map(|last| Figure { value: turn_rad, sigma: last.sigma });
            Leaving { turn_rad, ..Leaving::default() }
        };
        self.left.push(leaving);
        self.seen.clear();
    }

    /// The wall that ends a duct, in metres along it.
    fn wall(&self, duct: &DuctRecord) -> Option<Figure> {
        let end_m = duct.end_m?;
        let inside_m = duct.width_m / 2.0 - MARGIN_M;
        let line = Line { point_m: [end_m, 0.0], direction_rad: FRAC_PI_2, from_m: -inside_m, to_m: inside_m };
        // To the left of its direction is back.
        found(&self.seen, &line).map(|found| Figure { value: end_m - found.moved_m.value, ..found.moved_m })
    }
}

/// The ends of two ducts at a bend: of the one before it, and of the one behind it.
#[derive(Clone, Copy, Debug)]
struct Corner {
    end_m: Figure,
    begin_m: f64,
}

impl Leaving {
    /// Where the duct with this number ends and the next one begins, by the wall and by how wide that one was measured to be later, in
    /// place of what the plan of the bend took it for; `None` where either is not known.
    fn corner(&self, ducts: &[DuctRecord], number: usize) -> Option<Corner> {
        let (duct, next) = (ducts.get(number)?, ducts.get(number + 1)?);
        let (wall_m, turn_rad) = (self.wall_m?, self.turn_rad?.value);
        let width_sigma_m = next.width_deviation_m?;
        let sin = libm::sin(turn_rad).abs();
        // The middle of the next duct runs half its width before the wall.
        let at_m = wall_m.value - next.width_m / (2.0 * sin);
        let tangent_m = duct.width_m.min(next.width_m) / 2.0 * libm::tan(turn_rad.abs() / 2.0);
        let planned_m = duct.radius_m * libm::tan(duct.turn_rad.abs() / 2.0);
        let end_m = Figure { value: at_m - tangent_m, sigma: libm::hypot(wall_m.sigma, width_sigma_m / sin) };
        let moved_m = (at_m - corner_m(duct)) * libm::cos(turn_rad);
        Some(Corner { end_m, begin_m: tangent_m - planned_m + moved_m })
    }
}

/// Whether a duct was left by turning round in it.
fn turned_round(duct: &DuctRecord) -> bool {
    duct.turn_rad.abs() > ROUND_RAD && !matches!(duct.by, Some(Fitting::Elbow(_)))
}

/// Where the middles of a duct and of the one behind its bend cross, in metres along it.
fn corner_m(duct: &DuctRecord) -> f64 {
    duct.to_m.unwrap_or(0.0) + duct.radius_m * libm::tan(duct.turn_rad.abs() / 2.0)
}

/// The wall along which a duct was left into one of this width; `None` where there is none.
fn line(duct: &DuctRecord, exit_width_m: f64) -> Option<Line> {
    let fitting = duct.by?;
    let is_mitre = duct.radius_m < ARC_WIDTHS * duct.width_m.min(exit_width_m);
    if !is_mitre || duct.turn_rad == 0.0 {
        return None;
    }
    let (sin, cos) = libm::sincos(duct.turn_rad);
    let side = duct.turn_rad.signum();
    let half_m = duct.width_m / 2.0;
    let point_m = [corner_m(duct) + exit_width_m / 2.0 * sin.abs(), -side * exit_width_m / 2.0 * cos];
    // Offset from the duct's middle at which the wall begins.
    let from_y_m = match fitting {
        Fitting::Elbow(_) => -side * half_m,
        Fitting::Branch(_) | Fitting::Cross => side * half_m,
        Fitting::BullheadTee if cos.abs() < 0.2 => -side * 2.0 * half_m,
        // The crotch of a wye.
        Fitting::BullheadTee => 0.0,
        _ => return None,
    };
    let from_m = (from_y_m - point_m[1]) / sin + MARGIN_M;
    Some(Line { point_m, direction_rad: duct.turn_rad, from_m, to_m: f64::INFINITY })
}

/// Sums of a straight line's least squares: of points at u along the wall with offsets v, and of the common error's offsets.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    u: f64,
    uu: f64,
    v: [f64; 2],
    uv: [f64; 2],
    span_m: [f64; 2],
}

impl Sums {
    fn take(&mut self, u: f64, v: [f64; 2]) {
        self.span_m = if self.n == 0.0 { [u; 2] } else { [self.span_m[0].min(u), self.span_m[1].max(u)] };
        self.n += 1.0;
        self.u += u;
        self.uu += u * u;
        for (i, v) in v.into_iter().enumerate() {
            self.v[i] += v;
            self.uv[i] += u * v;
        }
    }

    /// Slope and offset at u = 0 of the one and of the other, and the weights of slope and offset; `None` of too few points.
    fn solved(&self) -> Option<([[f64; 2]; 2], [f64; 2])> {
        if self.n < FEWEST_POINTS as f64 || self.span_m[1] - self.span_m[0] < SHORTEST_M {
            return None;
        }
        let mean = self.u / self.n;
        let squares = self.uu - self.n * mean * mean;
        let of = |i: usize| {
            let slope = (self.uv[i] - mean * self.v[i]) / squares;
            [slope, self.v[i] / self.n - slope * mean]
        };
        let weights = [squares, 1.0 / (1.0 / self.n + mean * mean / squares)];
        (squares > 0.0).then_some(([of(0), of(1)], weights))
    }
}

/// The wall that these sights show about a line.
fn found(seen: &VecDeque<Sight>, line: &Line) -> Option<Found> {
    let (sin, cos) = libm::sincos(line.direction_rad);
    let first_m = seen.front()?.base_m[0];
    let mut about = [0.0, 0.0];
    let mut near_m = NEAR_M;
    let mut pieces: Vec<Sums> = Vec::new();
    for _ in 0..CHOICES {
        pieces.clear();
        let mut all = Sums::default();
        for sight in seen {
            let piece = libm::floor((sight.base_m[0] - first_m).abs() / PIECE_M) as usize;
            if pieces.len() <= piece {
                pieces.resize(piece + 1, Sums::default());
            }
            for [x, y] in &sight.points {
                let (dx, dy) = (x - line.point_m[0], y - line.point_m[1]);
                let (u, v) = (cos * dx + sin * dy, cos * dy - sin * dx);
                if !(line.from_m..=line.to_m).contains(&u) || (v - about[1] - about[0] * u).abs() > near_m {
                    continue;
                }
                let (rx, ry) = (x - sight.base_m[0], y - sight.base_m[1]);
                let common = COMMON_1_M * libm::hypot(rx, ry) * (cos * ry - sin * rx);
                all.take(u, [v, common]);
                pieces[piece].take(u, [v, common]);
            }
        }
        let ([fitted, _], _) = all.solved()?;
        about = fitted;
        near_m *= CLOSER;
    }
    let solved: Vec<_> = pieces.iter().filter_map(Sums::solved).collect();
    if solved.len() < FEWEST_PIECES {
        return None;
    }
    // Slope (0) or offset (1): the mean of the pieces with its standard error, and the mean of what is common, which grows with the
    // distance squared: what was seen from near by counts for more.
    let mean = |i: usize| {
        let of =
            |(lines, weights): &([[f64; 2]; 2], [f64; 2])| 1.0 / (POINT_M * POINT_M / weights[i] + lines[1][i] * lines[1][i]);
        let weight: f64 = solved.iter().map(of).sum();
        let sum = |k: usize| solved.iter().map(|piece| of(piece) * piece.0[k][i]).sum::<f64>() / weight;
        let value = sum(0);
        let scatter = solved.iter().map(|piece| {
            let off = of(piece) * (piece.0[0][i] - value);
            off * off
        });
        let count = solved.len() as f64;
        let sigma = (scatter.sum::<f64>() * count / (count - 1.0)).sqrt() / weight;
        (value, libm::hypot(sigma, sum(1)))
    };
    let ((slope, slope_sigma), (offset_m, offset_sigma_m)) = (mean(0), mean(1));
    let heading_rad = seen.iter().map(|sight| sight.heading_sigma_rad).sum::<f64>() / seen.len() as f64;
    let turned_rad = Figure { value: libm::atan(slope), sigma: libm::hypot(slope_sigma, heading_rad) };
    Some(Found { turned_rad, moved_m: Figure { value: offset_m, sigma: offset_sigma_m } })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::ahead::Side;

    const WIDTH_M: f64 = 0.5;
    const SURE: Sureness = Sureness { heading_rad: 0.0005, icr_m: 0.02 };

    fn duct(by: Option<Fitting>, to_m: Option<f64>, turn_rad: f64, radius_m: f64) -> DuctRecord {
        DuctRecord {
            first_from_duct: [0.0; 3],
            width_m: WIDTH_M,
            width_deviation_m: Some(1e-4),
            begin_m: Some(0.0),
            end_m: to_m,
            from_m: 0.0,
            to_m,
            by,
            turn_rad,
            radius_m,
            met: Vec::new(),
        }
    }

    /// Drives 2.4 m along the middle towards a wall through a point, in this direction, with points of it off by up to 3 mm, and a
    /// twentieth of a pixel too far.
    fn driven(through: [f64; 2], direction_rad: f64, ducts: &[DuctRecord]) -> Ends {
        let mut ends = Ends::default();
        let (sin, cos) = libm::sincos(direction_rad);
        for frame in 0..300_i32 {
            let along_m = 0.008 * f64::from(frame);
            let place = DuctPlace { along_m, lateral_m: 0.0, heading_rad: 0.0, width_m: WIDTH_M };
            let point = |i: i32| {
                let u = 0.02 * f64::from(i);
                let (x, y) = (through[0] + u * cos - along_m, through[1] + u * sin);
                let range_m = libm::hypot(x, y);
                let longer = 1.0 + COMMON_1_M * range_m + 0.003 * f64::from((frame * 7 + i * 13) % 5 - 2) / 2.0 / range_m;
                RangePoint {
                    point_in_base: Point3::new(x * longer, y * longer, 0.1),
                    laser: 0,
                    block: i as usize,
                    upon: Upon::Upright,
                }
            };
            let ranges: Vec<RangePoint> = (0..35).map(point).collect();
            ends.take(&ducts[..1], &place, &SURE, &ranges);
        }
        let turning = DuctPlace { along_m: 3.1, lateral_m: 0.05, heading_rad: 0.7, width_m: WIDTH_M };
        ends.take(&ducts[..1], &turning, &Sureness { heading_rad: 0.02, ..SURE }, &[]);
        if ducts.len() > 1 {
            ends.take(ducts, &DuctPlace { along_m: -0.2, heading_rad: -0.8, ..turning }, &SURE, &[]);
        }
        ends
    }

    /// Elbows and branches of 88 and 60 degrees that the plan of the bend took for right and narrower: turn, end, and the next one's
    /// beginning are found, within what is said of them.
    #[test]
    fn a_turn_and_both_ends_come_back() {
        for (side, turn_deg) in [(1.0, 88.0_f64), (-1.0, 88.0), (1.0, 60.0)] {
            let turn_rad = side * turn_deg.to_radians();
            let (sin, cos) = libm::sincos(turn_rad);
            // The middles cross at 3 m.
            let corner_m = 3.0;
            let half_m = WIDTH_M / 2.0;
            let to_corner_m = -side * half_m * cos / sin - half_m / sin.abs();
            let outer = [corner_m - to_corner_m, -side * half_m];
            let outer = [corner_m + half_m / sin.abs() + (outer[1] / sin) * cos, outer[1]];
            let tangent_m = half_m * libm::tan(turn_rad.abs() / 2.0);
            // The plan: a degree too far, 10 mm too narrow.
            let planned = (turn_rad.abs() + 0.0175) * side;
            let radius_m = half_m - 0.005;
            let planned_m = radius_m * libm::tan(planned.abs() / 2.0);
            let by = Fitting::Elbow(if side > 0.0 { Side::Left } else { Side::Right });
            let log = [duct(Some(by), Some(corner_m + 0.003 - planned_m), planned, radius_m), duct(None, None, 0.0, 0.0)];
            let ends = driven(outer, turn_rad, &log);
            let (first, second) = (ends.of(&log, 0), ends.of(&log, 1));
            let is_near = |figure: Option<Figure>, truth: f64, most: f64| {
                figure.is_some_and(|f| (f.value - truth).abs() < 2.0 * f.sigma && f.sigma < most)
            };
            assert!(is_near(first.turn_rad, turn_rad, 0.01), "{turn_rad}: {first:?}");
            assert!(is_near(first.end_m, corner_m - tangent_m, 0.003), "{turn_rad}, {}: {first:?}", corner_m - tangent_m);
            // Where the exit's arc truly ends, seen from where the plan has it: farther, by its wider arc, and back with the corner.
            let begin_m = tangent_m - planned_m - 0.003 * cos;
            assert!(is_near(second.begin_m, begin_m, 0.025), "{turn_rad}, {begin_m}: {second:?}");
            assert_eq!((second.end_m, second.turn_rad), (None, None));
            assert!(first.length_sigma_m(2.75).is_some_and(|sigma_m| (0.0027..0.006).contains(&sigma_m)), "{first:?}");
            assert_eq!(second.length_sigma_m(1.0), None);
        }
    }

    /// A cap, before which it stands, and from which it goes back.
    #[test]
    fn a_dead_end_is_where_its_wall_stands() {
        let log = [duct(None, None, 0.0, 0.0)];
        let standing = [DuctRecord { end_m: Some(3.004), ..log[0].clone() }];
        let ends = driven([3.0, -0.2], FRAC_PI_2, &log);
        assert_eq!(ends.of(&log, 0).end_m, None, "nothing ends it yet");
        let end_m = ends.of(&standing, 0).end_m.expect("a wall");
        assert!((end_m.value - 3.0).abs() < 2.0 * end_m.sigma && end_m.sigma < 0.003, "{end_m:?}");
        let left = DuctRecord { by: Some(Fitting::DeadEnd), to_m: Some(2.7), turn_rad: PI, ..standing[0].clone() };
        let log = [left, duct(None, None, 0.0, 0.0)];
        let ends = driven([3.0, -0.2], FRAC_PI_2, &log);
        let begin_m = ends.of(&log, 1).begin_m.expect("the wall behind it");
        // Turning round about a point 20 mm ahead, as may be, it moves on by 40 mm.
        assert!((begin_m.value + 0.3).abs() < 0.005 && (begin_m.sigma - 0.04).abs() < 0.002, "{begin_m:?}");
    }

    /// An arc has a turn with a deviation, and no wall; a transition has neither.
    #[test]
    fn what_has_no_wall_has_no_ends() {
        for (by, turn_rad, radius_m) in [(Fitting::Elbow(Side::Left), 1.5, 0.6), (Fitting::Transition, 0.0, f64::INFINITY)] {
            let log = [duct(Some(by), Some(2.5), turn_rad, radius_m), duct(None, None, 0.0, 0.0)];
            let ends = driven([3.25, -0.25], FRAC_PI_2, &log);
            let first = ends.of(&log, 0);
            assert_eq!((first.end_m, ends.of(&log, 1).begin_m), (None, None), "{by:?}");
            let expected = (turn_rad != 0.0).then_some(Figure { value: turn_rad, sigma: 0.02 });
            assert_eq!(first.turn_rad, expected, "{by:?}");
        }
    }
}
