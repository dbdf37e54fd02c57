//! The outer wall of a radius elbow: an arc that leaves the far side wall tangentially, and the straight wall behind it.
//!
//! Two unknowns, where the arc begins and its radius, are fitted to the points by Gauss and Newton's method from the best of a coarse grid;
//! then the angle at which the wall goes on straight is the one that explains most points.

use super::outlook::Side;
use super::strip::DuctPlace;

/// The wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterArc {
    /// Where it begins to turn, in metres along the duct.
    pub start_m: f64,
    /// Its radius, in metres.
    pub radius_m: f64,
    /// The bend's angle, positive to the left, in radians. Until the straight wall behind the arc is seen it is taken to be square.
    pub turn_rad: f64,
    /// Points that it rests on, as a share of all that stand off the duct's own walls.
    pub share: f64,
}

/// Radii and beginnings that are tried, in metres; the latter against where the inner wall is seen to leave its line.
const RADII_M: [f64; 3] = [0.25, 2.2, 0.1];
const STARTS_M: [f64; 3] = [-0.5, 0.2, 0.05];
/// Points within this of the wall are its own, in metres.
const NEAR_M: f64 = 0.03;
/// Points that are looked at, at most: every n-th is taken.
const MOST: usize = 240;
const FEWEST: usize = 40;
/// Angles at which the wall may go on straight, in degrees.
const TURNS_DEG: [f64; 3] = [20.0, 180.0, 5.0];
/// A straight wall behind the arc must explain so many more points than the arc alone.
const BETTER: f64 = 1.03;

/// Finds it among points of the duct, for a bend to `side` whose inner wall is seen to end at `ends_m`.
pub(super) fn find(points: &[[f64; 2]], place: &DuctPlace, side: Side, ends_m: f64) -> Option<OuterArc> {
    let half_m = place.width_m / 2.0;
    let stride = points.len().div_ceil(MOST).max(1);
    // From the far wall's line, inwards, for a bend to the left.
    let own: Vec<[f64; 2]> = points.iter().step_by(stride).map(|[s, y]| [s - ends_m, y * side.sign() + half_m]).collect();
    if own.len() < FEWEST {
        return None;
    }
    let off = |[s, y]: &[f64; 2], start: f64, radius: f64| {
        let (dx, dy) = (s - start, radius - y);
        (dx * dx + dy * dy).sqrt() - radius
    };
    let near = |start: f64, radius: f64| own.iter().filter(|p| p[0] > start && off(p, start, radius).abs() < NEAR_M).count();
    let grid = |[from, to, step]: [f64; 3]| (0..=((to - from) / step).round() as usize).map(move |i| from + step * i as f64);
    let (_, mut start, mut radius) = grid(RADII_M)
        .flat_map(|radius| grid(STARTS_M).map(move |start| (start, radius)))
        .map(|(start, radius)| (near(start, radius), start, radius))
        .max_by(|a, b| a.0.cmp(&b.0).then(b.2.total_cmp(&a.2)))?;
    for _ in 0..6 {
        // Normal equations of the residual's derivatives by start and radius.
        let (mut a, mut b) = ([0.0; 3], [0.0; 2]);
        for p in own.iter().filter(|p| p[0] > start && off(p, start, radius).abs() < 2.0 * NEAR_M) {
            let (dx, dy) = (p[0] - start, radius - p[1]);
            let rho = (dx * dx + dy * dy).sqrt().max(1e-6);
            let (by_start, by_radius, rest) = (-dx / rho, dy / rho - 1.0, rho - radius);
            a = [a[0] + by_start * by_start, a[1] + by_start * by_radius, a[2] + by_radius * by_radius];
            b = [b[0] - by_start * rest, b[1] - by_radius * rest];
        }
        let determinant = a[0] * a[2] - a[1] * a[1];
        if determinant.abs() < 1e-9 {
            return None;
        }
        start += (a[2] * b[0] - a[1] * b[1]) / determinant;
        radius += (a[0] * b[1] - a[1] * b[0]) / determinant;
        if !(RADII_M[0] / 2.0..=2.0 * RADII_M[1]).contains(&radius) || !(-1.0..=1.0).contains(&start) {
            return None;
        }
    }
    let explained = |turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        let end = [start + radius * sin, radius * (1.0 - cos)];
        let is_own = |p: &&[f64; 2]| {
            let (dx, dy) = (p[0] - start, radius - p[1]);
            if dx <= 0.0 {
                return false;
            }
            let off = if libm::atan2(dx, dy) <= turn {
                (dx * dx + dy * dy).sqrt() - radius
            } else {
                sin * (p[0] - end[0]) - cos * (p[1] - end[1])
            };
            off.abs() < NEAR_M
        };
        own.iter().filter(is_own).count()
    };
    let square = explained(std::f64::consts::FRAC_PI_2);
    let best = grid(TURNS_DEG)
        .map(|turn| (explained(turn.to_radians()), turn))
        .max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)))?;
    let (count, turn) = if best.0 as f64 > BETTER * square as f64 {
        (best.0, best.1.to_radians())
    } else {
        (square, std::f64::consts::FRAC_PI_2)
    };
    Some(OuterArc {
        start_m: start + ends_m,
        radius_m: radius,
        turn_rad: turn * side.sign(),
        share: count as f64 / own.len() as f64,
    })
}
