//! The side walls from where they begin to where they end, from ranges: what the robot goes by before and behind a bend.
//!
//! The pipeline's own walls are planes fitted to all that may be on them; where a wall bends away a part of it is easily taken for the
//! whole. Here only points beside the lines where the walls are known to be count, and only where the duct is straight. Both walls are
//! parallel: two offsets and one direction by linear least squares.

use nalgebra::{Matrix3, Vector3};

use super::strip::DuctPlace;
use crate::perception::side_walls::SideWalls;

/// Standard deviation of a point across the wall, in metres.
const POINT_M: f64 = 0.004;
/// What all points of a wall have in common is added: standard deviations, in metres and radians.
const COMMON_M: f64 = 0.002;
const COMMON_RAD: f64 = 0.004;
/// The same where the place is only roughly known: a corner's points may be among a wall's.
const ROUGH_COMMON_M: f64 = 0.008;
const ROUGH_COMMON_RAD: f64 = 0.017;
/// A wall's points are chosen anew about the line found, each time within this share of the distance before: three times.
const CLOSER: f64 = 0.6;
const CHOICES: usize = 3;
/// Fewest points of a wall, and the shortest piece of it, in metres.
const FEWEST: u32 = 8;
const SHORTEST_M: f64 = 0.15;

/// Where the side walls of a duct are straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// From where to where along the duct, for the left and the right wall, in metres.
    pub along_m: [[f64; 2]; 2],
    /// Points farther off a wall's line than this are not its own, in metres.
    pub near_m: f64,
    /// Whether the robot's place in the duct is only roughly known, as right behind a bend: then the lines are sought first.
    pub is_rough: bool,
}

/// Where the place is only roughly known: headings and offsets against it within which the walls are sought, and their steps, in degrees and
/// metres.
const HEADINGS_DEG: [i32; 2] = [14, 2];
const OFFSETS_MM: [i32; 2] = [120, 20];
/// Points this near are a line's own in that search, in metres, and as many of them as this are lost for the farthest place sought.
const LINE_M: f64 = 0.02;
const FARTHEST_COSTS: f64 = 6.0;

/// The place at which most points are on the lines of the walls.
fn sought(points: impl Iterator<Item = [f64; 2]> + Clone, place: &DuctPlace, stretch: &Stretch) -> DuctPlace {
    let steps = |[most, step]: [i32; 2]| {
        (-most..=most).step_by(step as usize).map(move |at| (f64::from(at), f64::from(at) / f64::from(most)))
    };
    let half_m = place.width_m / 2.0;
    let mut best = (f64::NEG_INFINITY, *place);
    for (turn_deg, turn_share) in steps(HEADINGS_DEG) {
        let heading_rad = place.heading_rad + turn_deg.to_radians();
        let (sin, cos) = libm::sincos(heading_rad);
        for (aside_mm, aside_share) in steps(OFFSETS_MM) {
            let lateral_m = place.lateral_m + 1e-3 * aside_mm;
            let own = points.clone().filter(|[x, y]| {
                let (along, across) = (place.along_m + cos * x - sin * y, lateral_m + sin * x + cos * y);
                let [from_m, to_m] = stretch.along_m[usize::from(across < 0.0)];
                (across.abs() - half_m).abs() < LINE_M && (from_m..=to_m).contains(&along)
            });
            let score = own.count() as f64 - FARTHEST_COSTS * (turn_share * turn_share + aside_share * aside_share);
            if score > best.0 {
                best = (score, DuctPlace { heading_rad, lateral_m, ..*place });
            }
        }
    }
    best.1
}

/// Lines fitted to the points beside them.
#[derive(Clone, Copy, Debug)]
struct Fit {
    /// Slope against the place's heading, then where the left and the right wall pass the base, in metres to the left.
    lines: Vector3<f64>,
    /// Inverse of the normal matrix, of points with a deviation of one.
    inverse: Matrix3<f64>,
    /// Whether the left and the right wall are seen.
    seen: [bool; 2],
}

/// Fits both walls to the points within `near_m` of these lines, in a frame with the place's heading.
fn fit(
    points: impl Iterator<Item = [f64; 2]>,
    place: &DuctPlace,
    stretch: &Stretch,
    lines: &Vector3<f64>,
    near_m: f64,
) -> Option<Fit> {
    let (sin, cos) = libm::sincos(place.heading_rad);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let (mut counts, mut spans) = ([0_u32; 2], [[f64::INFINITY, f64::NEG_INFINITY]; 2]);
    for [x, y] in points {
        let (along, across) = (cos * x - sin * y, sin * x + cos * y);
        let side = usize::from(across + place.lateral_m < 0.0);
        let expected = lines[1 + side] + lines[0] * along;
        let [from_m, to_m] = stretch.along_m[side];
        if (across - expected).abs() > near_m || !(from_m..=to_m).contains(&(along + place.along_m)) {
            continue;
        }
        counts[side] += 1;
        spans[side] = [spans[side][0].min(along), spans[side][1].max(along)];
        let mut row = Vector3::new(along, 0.0, 0.0);
        row[1 + side] = 1.0;
        normal += row * row.transpose();
        right += row * across;
    }
    let seen = [0, 1].map(|side| counts[side] >= FEWEST && spans[side][1] - spans[side][0] >= SHORTEST_M);
    if seen == [false; 2] {
        return None;
    }
    // A wall that is not seen has no say.
    for side in (0..2).filter(|side| counts[*side] == 0) {
        normal[(1 + side, 1 + side)] = 1.0;
    }
    let inverse = normal.try_inverse()?;
    Some(Fit { lines: inverse * right, inverse, seen })
}

/// The walls that `points` (of the base frame) show of a duct in which the robot is about at `place`.
pub(super) fn find(points: impl Iterator<Item = [f64; 2]> + Clone, place: &DuctPlace, stretch: &Stretch) -> Option<SideWalls> {
    let place = &if stretch.is_rough { sought(points.clone(), place, stretch) } else { *place };
    let half_m = place.width_m / 2.0;
    let mut near_m = stretch.near_m;
    let mut found =
        fit(points.clone(), place, stretch, &Vector3::new(0.0, half_m - place.lateral_m, -half_m - place.lateral_m), near_m)?;
    for _ in 1..CHOICES {
        near_m *= CLOSER;
        match fit(points.clone(), place, stretch, &found.lines, near_m) {
            Some(closer) if closer.seen == found.seen => found = closer,
            _ => break,
        }
    }
    let Fit { lines, inverse, seen } = found;
    let turned = libm::atan(lines[0]);
    let cos = libm::cos(turned);
    let [common_m, common_rad] = if stretch.is_rough { [ROUGH_COMMON_M, ROUGH_COMMON_RAD] } else { [COMMON_M, COMMON_RAD] };
    let covariance = inverse * (POINT_M * POINT_M)
        + Matrix3::from_diagonal(&Vector3::new(common_rad * common_rad, common_m * common_m, common_m * common_m));
    // Distances are to the left and to the right; the heading falls as the walls' direction grows.
    let sign = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0));
    Some(SideWalls {
        heading_rad: place.heading_rad - turned,
        left_m: seen[0].then_some(lines[1] * cos),
        right_m: seen[1].then_some(-lines[2] * cos),
        covariance: sign * covariance * sign,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls of a duct, seen by a robot beside its middle and turned, come back; what bends away beyond the end is left out.
    #[test]
    fn walls_come_back() {
        let truth = DuctPlace { along_m: 2.0, lateral_m: 0.03, heading_rad: 0.05, width_m: 0.5 };
        let to_base = |s: f64, y: f64| {
            let (sin, cos) = libm::sincos(-truth.heading_rad);
            let (ds, dy) = (s - truth.along_m, y - truth.lateral_m);
            [cos * ds - sin * dy, sin * ds + cos * dy]
        };
        let wall = |side: f64| {
            (0..40).map(move |i| {
                let s = 2.3 + 0.02 * f64::from(i);
                // From 2.8 on it bends to the left.
                let bent = (s - 2.8).max(0.0);
                [s, side * 0.25 + 0.5 * bent * bent]
            })
        };
        let points: Vec<[f64; 2]> = wall(1.0).chain(wall(-1.0)).map(|[s, y]| to_base(s, y)).collect();
        let stretch = |to_m: f64| Stretch { along_m: [[2.0, to_m]; 2], near_m: 0.04, is_rough: false };
        let believed = DuctPlace { lateral_m: 0.02, heading_rad: 0.07, ..truth };
        let walls = find(points.iter().copied(), &believed, &stretch(2.8)).expect("both walls");
        assert!((walls.heading_rad - 0.05).abs() < 1e-9, "{walls:?}");
        assert!((walls.left_m.unwrap() - 0.22).abs() < 1e-9 && (walls.right_m.unwrap() - 0.28).abs() < 1e-9, "{walls:?}");
        let bent = find(points.iter().copied(), &believed, &stretch(3.2)).expect("both walls");
        assert!((bent.heading_rad - 0.05).abs() > 1e-3, "the bend counts: {bent:?}");
        assert!(find(std::iter::empty(), &believed, &stretch(2.8)).is_none());
        // From a place that is far off: nothing near it is a wall's, unless the lines are sought.
        let rough = DuctPlace { lateral_m: -0.05, heading_rad: 0.2, ..truth };
        let walls = find(points.iter().copied(), &rough, &Stretch { is_rough: true, ..stretch(2.8) }).expect("both walls");
        assert!((walls.heading_rad - 0.05).abs() < 1e-9 && (walls.left_m.unwrap() - 0.22).abs() < 1e-9, "{walls:?}");
    }
}
