//! The wall that a bend turns along: the outer wall of an elbow, the far wall of a branch, the wall across a bull-head tee's stem.
//!
//! It is found among points of many frames by a Hough transform over its direction and place (R. O. Duda, P. E. Hart, CACM 15, 1972), and
//! then fitted by total least squares. Its direction is that of the duct behind the bend; the corner where the near wall ends lies on that
//! duct's other wall, so its distance from this one is the duct's width.

use super::features::Opening;
use super::outlook::Side;
use super::strip::DuctPlace;

/// A straight wall, in the coordinates of the duct before the bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterWall {
    /// Direction along the wall, out of the bend, against the duct's: the bend's angle, positive to the left, in radians.
    pub turn_rad: f64,
    /// A point on it: along the duct and to the left, in metres.
    pub point_m: [f64; 2],
    /// Distance of the inner corner from it: the width of the duct behind the bend, in metres.
    pub width_m: f64,
    /// Points that it rests on.
    pub points: usize,
    /// RMS distance of these, in metres.
    pub rms_m: f64,
    /// These as a share of all that stand off the duct's own walls.
    pub share: f64,
}

/// Turns that are sought, in degrees, and their step.
const TURNS_DEG: [i32; 2] = [15, 150];
const STEP_DEG: i32 = 3;
/// Width of a cell in the wall's place, in metres.
const CELL_M: f64 = 0.025;
/// Cells to each side of the inner corner.
const CELLS: usize = 128;
/// Points within this of the wall are its own, in metres, in the first fit and in the last.
const NEAR_M: [f64; 3] = [0.05, 0.03, 0.025];
/// Fewest points.
const FEWEST: usize = 60;
/// Points this far before the end of the near wall may still be of the outer one, in metres.
const BEFORE_M: f64 = 0.3;
/// A bend's outer wall is within so many widths of the end of the near wall, as far as it is in this duct.
const BEHIND_WIDTHS: f64 = 2.5;
/// Least and greatest width of the duct behind a bend, in widths of the one before it.
const WIDTHS: [f64; 2] = [0.45, 2.2];
/// Points this near the side wall's line are taken for it, in metres.
const ON_SIDE_M: f64 = 0.04;

/// Points that are not of this duct's own side walls: what a bend to `side` turns along. `opening` is where the near wall ends.
pub(super) fn off_the_walls(
    points: impl Iterator<Item = [f64; 2]>,
    place: &DuctPlace,
    side: Side,
    opening: &Opening,
) -> Vec<[f64; 2]> {
    let (sign, half_m) = (side.sign(), place.width_m / 2.0);
    let own = points.filter(|[s, y]| {
        let y = y * sign;
        let on_far_side = (y + half_m).abs() < ON_SIDE_M;
        let on_near_side = (y - half_m).abs() < ON_SIDE_M && (*s < opening.from_m || opening.to_m.is_some_and(|to| *s > to));
        let before = y > half_m && *s < opening.from_m;
        // What stands in the duct behind the bend's own far side is another fitting's.
        let beyond_m = opening.to_m.map_or(opening.from_m + BEHIND_WIDTHS * place.width_m, |to| to + ON_SIDE_M);
        let behind = y.abs() < half_m && *s > beyond_m;
        *s > opening.from_m - BEFORE_M && !on_far_side && !on_near_side && !before && !behind
    });
    own.collect()
}

/// Finds it. `opening` is where the near wall ends.
pub(super) fn find(points: &[[f64; 2]], place: &DuctPlace, side: Side, opening: &Opening) -> Option<OuterWall> {
    let (sign, half_m) = (side.sign(), place.width_m / 2.0);
    let corner = [opening.from_m, half_m];
    // Mirrored so that the bend is to the left.
    let points = points.iter().map(|[s, y]| [*s, y * sign]);
    let steps = ((TURNS_DEG[1] - TURNS_DEG[0]) / STEP_DEG) as usize + 1;
    let mut votes = vec![0_u16; steps * CELLS];
    for step in 0..steps {
        let turn = f64::from(TURNS_DEG[0] + STEP_DEG * step as i32).to_radians();
        let (sin, cos) = libm::sincos(turn);
        for [s, y] in points.clone() {
            // Distance to the right of the line through the corner in this direction.
            let off = sin * (s - corner[0]) - cos * (y - corner[1]);
            let cell = libm::floor(off / CELL_M);
            if (0.0..CELLS as f64).contains(&cell) {
                votes[step * CELLS + cell as usize] += 1;
            }
        }
    }
    let (best, count) = votes.iter().enumerate().max_by_key(|(index, votes)| (**votes, std::cmp::Reverse(*index)))?;
    if usize::from(*count) < FEWEST / 2 {
        return None;
    }
    let mut turn = f64::from(TURNS_DEG[0] + STEP_DEG * (best / CELLS) as i32).to_radians();
    let mut off_m = ((best % CELLS) as f64 + 0.5) * CELL_M;
    let mut fit = (0, [0.0; 2], 0.0);
    for near_m in NEAR_M {
        let (sin, cos) = libm::sincos(turn);
        let own = points.clone().filter(|[s, y]| (sin * (s - corner[0]) - cos * (y - corner[1]) - off_m).abs() < near_m);
        let (n, sum) = own.clone().fold((0_u32, [0.0; 2]), |(n, sum), [s, y]| (n + 1, [sum[0] + s, sum[1] + y]));
        if (n as usize) < FEWEST {
            return None;
        }
        let mean = sum.map(|sum| sum / f64::from(n));
        let [ss, sy, yy] = own.fold([0.0; 3], |[ss, sy, yy], [s, y]| {
            let (s, y) = (s - mean[0], y - mean[1]);
            [ss + s * s, sy + s * y, yy + y * y]
        });
        // The direction of the largest spread; the bend's sense tells it from its opposite.
        let axis = 0.5 * libm::atan2(2.0 * sy, ss - yy);
        turn = if axis < 0.0 { axis + std::f64::consts::PI } else { axis };
        let (sin, cos) = libm::sincos(turn);
        off_m = sin * (mean[0] - corner[0]) - cos * (mean[1] - corner[1]);
        let across = sin * sin * ss - 2.0 * sin * cos * sy + cos * cos * yy;
        fit = (n as usize, mean, (across / f64::from(n)).max(0.0).sqrt());
    }
    // Ducts behind bends are about as wide as those before them: half, or twice.
    if !(WIDTHS[0] * place.width_m..=WIDTHS[1] * place.width_m).contains(&off_m) {
        return None;
    }
    let all = points.len();
    let (points, mean, rms_m) = fit;
    Some(OuterWall {
        turn_rad: turn * sign,
        point_m: [mean[0], mean[1] * sign],
        width_m: off_m,
        points,
        rms_m,
        share: points as f64 / all as f64,
    })
}
