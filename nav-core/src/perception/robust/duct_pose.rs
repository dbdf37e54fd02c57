//! From walls in the camera frame to where the robot stands in the duct, each figure with its standard deviation.
//!
//! An upright wall is the line a x + b y = 1 in the level plane through the camera, (a, b) being m turned into the base frame. With
//! the camera at (cx, cy), its distance from the base's origin is (1 + a cx + b cy) / |(a, b)|, and the robot's heading against it
//! atan(a / b) for a side wall and atan(-b / a) for one ahead. The covariance of m goes through the derivatives.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix4, Matrix4x3, Vector2, Vector3, Vector4};

use super::super::side_walls::SideWalls;
use super::super::{Deviation, Measurement, Wall, WallDeviation, WallMeasurement};
use super::plane_fit::Plane;
use super::proposal::Upright;

/// An upright wall: distance from the base's origin and heading against it, with their covariance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) distance_m: f64,
    pub(super) heading_rad: f64,
    pub(super) covariance: Matrix2<f64>,
    pub(super) points: usize,
}

impl Side {
    pub(super) fn of(wall: Wall, plane: &Plane, upright: &Upright) -> Self {
        let rotation = upright.base_from_camera.rotation;
        let turn: Matrix3<f64> = *rotation.to_rotation_matrix().matrix();
        let (m, covariance) = (turn * plane.m, turn * plane.covariance * turn.transpose());
        let camera = upright.base_from_camera.translation.vector;
        let (a, b) = (m.x, m.y);
        let level2 = a * a + b * b;
        let level = level2.sqrt();
        let distance_m = (1.0 + a * camera.x + b * camera.y) / level;
        let heading_rad = match wall {
            Wall::Ahead => libm::atan(-b / a),
            _ => libm::atan(a / b),
        };
        // Both headings have the same derivatives.
        let jacobian = Matrix2x3::new(
            camera.x / level - distance_m * a / level2,
            camera.y / level - distance_m * b / level2,
            0.0,
            b / level2,
            -a / level2,
            0.0,
        );
        let covariance = jacobian * covariance * jacobian.transpose();
        Self { distance_m, heading_rad, covariance, points: plane.counts.iter().sum() }
    }

    fn measurement(&self) -> WallMeasurement {
        WallMeasurement {
            distance_m: self.distance_m,
            heading_rad: self.heading_rad,
            points: self.points,
            deviation: Some(WallDeviation {
                distance_m: self.covariance[(0, 0)].max(0.0).sqrt(),
                heading_rad: self.covariance[(1, 1)].max(0.0).sqrt(),
            }),
        }
    }
}

/// A level wall: its height above the base's origin and the deviation of that.
fn level(plane: &Plane, upright: &Upright) -> (f64, f64) {
    // m . p = 1 straight above or below the camera: h = 1 / (m . up).
    let along = plane.m.dot(&upright.up);
    let variance = upright.up.dot(&(plane.covariance * upright.up));
    (upright.height_m + 1.0 / along, variance.max(0.0).sqrt() / (along * along))
}

/// What the walls say. `width_m` stands in for the wall that is not seen.
pub(super) fn measure(planes: &[(Wall, Plane)], upright: &Upright, width_m: f64) -> Measurement {
    let of = |wall: Wall| planes.iter().find(|(w, _)| *w == wall).map(|(_, plane)| plane);
    let side = |wall: Wall| of(wall).map(|plane| Side::of(wall, plane, upright));
    let alone = (side(Wall::Left), side(Wall::Right));
    let level_wall = |wall: Wall| {
        let plane = of(wall)?;
        let (height_m, sigma_m) = level(plane, upright);
        let distance_m = if wall == Wall::Floor { -height_m } else { height_m };
        let deviation = Some(WallDeviation { distance_m: sigma_m, heading_rad: 0.0 });
        Some(WallMeasurement { distance_m, heading_rad: 0.0, points: plane.counts.iter().sum(), deviation })
    };
    let (floor, ceiling) = (level_wall(Wall::Floor), level_wall(Wall::Ceiling));
    // The base stands on the floor: without sight of it, its height is zero.
    let height_m = ceiling.map(|ceiling| ceiling.distance_m);
    let height_sigma = ceiling.and_then(|ceiling| ceiling.deviation).map(|deviation| deviation.distance_m);
    let (left, right) = match alone {
        (Some(left), Some(right)) => together(&left, &right),
        one => one,
    };
    let walls = Measurement {
        height_m,
        left: left.as_ref().map(Side::measurement),
        right: right.as_ref().map(Side::measurement),
        floor,
        ceiling,
        ahead: side(Wall::Ahead).as_ref().map(Side::measurement),
        ..Measurement::default()
    };
    let pose = match (&alone.0, &alone.1) {
        (None, None) => return Measurement { deviation: Deviation { height_m: height_sigma, ..Deviation::default() }, ..walls },
        (Some(one), None) => single(Wall::Left, one, width_m / 2.0 - one.distance_m),
        (None, Some(one)) => single(Wall::Right, one, one.distance_m - width_m / 2.0),
        (Some(left), Some(right)) => both(left, right),
    };
    Measurement {
        lateral_m: Some(pose.lateral_m[0]),
        heading_rad: Some(pose.heading_rad[0]),
        width_m: pose.width_m.map(|width| width[0]),
        deviation: Deviation {
            lateral_m: Some(pose.lateral_m[1]),
            heading_rad: Some(pose.heading_rad[1]),
            width_m: pose.width_m.map(|width| width[1]),
            height_m: height_sigma,
        },
        side_walls: Some(pose.side_walls),
        ..walls
    }
}

/// Values and their standard deviations.
struct Pose {
    lateral_m: [f64; 2],
    heading_rad: [f64; 2],
    width_m: Option<[f64; 2]>,
    side_walls: SideWalls,
}

fn single(which: Wall, wall: &Side, lateral_m: f64) -> Pose {
    let sigma = |i: usize| wall.covariance[(i, i)].max(0.0).sqrt();
    let row = if which == Wall::Left { 1 } else { 2 };
    let mut covariance = Matrix3::zeros();
    covariance[(0, 0)] = wall.covariance[(1, 1)];
    covariance[(row, row)] = wall.covariance[(0, 0)];
    (covariance[(0, row)], covariance[(row, 0)]) = (wall.covariance[(1, 0)], wall.covariance[(0, 1)]);
    let seen = |wanted: Wall| (which == wanted).then_some(wall.distance_m);
    let side_walls =
        SideWalls { heading_rad: wall.heading_rad, left_m: seen(Wall::Left), right_m: seen(Wall::Right), covariance };
    Pose { lateral_m: [lateral_m, sigma(0)], heading_rad: [wall.heading_rad, sigma(1)], width_m: None, side_walls }
}

/// Both walls of a duct whose walls are parallel: (distance left, distance right, heading), their covariance, and the chi-square (one
/// degree of freedom) of the two headings' difference.
fn parallel(left: &Side, right: &Side) -> Option<(Vector3<f64>, Matrix3<f64>, f64)> {
    let mut weight = Matrix4::zeros();
    for (i, side) in [left, right].into_iter().enumerate() {
        weight.fixed_view_mut::<2, 2>(2 * i, 2 * i).copy_from(&side.covariance.try_inverse()?);
    }
    let design = Matrix4x3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let seen = Vector4::new(left.distance_m, left.heading_rad, right.distance_m, right.heading_rad);
    let covariance = (design.transpose() * weight * design).try_inverse()?;
    let found = covariance * (design.transpose() * (weight * seen));
    let off = seen - design * found;
    Some((found, covariance, off.dot(&(weight * off))))
}

/// Headings that differ by more than five standard deviations are not those of parallel walls.
const PARALLEL_CHI2: f64 = 25.0;
/// Up to three standard deviations they differ by chance.
const CHANCE_CHI2: f64 = 9.0;

/// By how much variances grow for headings that disagree by this chi-square: by what chance does not explain. Were they to grow from 1 on
/// (the Birge ratio), those of walls that are parallel would be half as large again as they should, in the mean.
fn doubt(chi2: f64) -> f64 {
    1.0 + (chi2 - CHANCE_CHI2).max(0.0)
}

/// Each wall with what the other says of the heading, where they are parallel: a wall's distance is measured at the base, its stripes
/// lie ahead, and the heading carries the one to the other.
fn together(left: &Side, right: &Side) -> (Option<Side>, Option<Side>) {
    match parallel(left, right) {
        Some((found, covariance, chi2)) if chi2 < PARALLEL_CHI2 => {
            let covariance = covariance * doubt(chi2);
            let side = |i: usize, alone: &Side| Side {
                distance_m: found[i],
                heading_rad: found[2],
                covariance: Matrix2::new(covariance[(i, i)], covariance[(i, 2)], covariance[(2, i)], covariance[(2, 2)]),
                points: alone.points,
            };
            (Some(side(0, left)), Some(side(1, right)))
        }
        _ => (Some(*left), Some(*right)),
    }
}

/// Lateral offset, heading and width from both walls. Where the two headings differ by more than chance allows, all deviations
/// grow by as much: the walls are not parallel, or one of them is not what it seems.
fn both(left: &Side, right: &Side) -> Pose {
    let Some((found, covariance, chi2)) = parallel(left, right) else {
        let spread = (left.covariance[(0, 0)] + right.covariance[(0, 0)]).max(0.0).sqrt();
        let pose = single(Wall::Left, left, (right.distance_m - left.distance_m) / 2.0);
        return Pose { lateral_m: [pose.lateral_m[0], spread / 2.0], ..pose };
    };
    let covariance = covariance * doubt(chi2);
    let ends = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let sigma = |by: Vector2<f64>| by.dot(&(ends * by)).max(0.0).sqrt();
    Pose {
        lateral_m: [(found[1] - found[0]) / 2.0, sigma(Vector2::new(-0.5, 0.5))],
        heading_rad: [found[2], covariance[(2, 2)].max(0.0).sqrt()],
        width_m: Some([found[0] + found[1], sigma(Vector2::new(1.0, 1.0))]),
        side_walls: SideWalls {
            heading_rad: found[2],
            left_m: Some(found[0]),
            right_m: Some(found[1]),
            // In the order (heading, left, right).
            covariance: Matrix3::from_fn(|i, j| covariance[((i + 2) % 3, (j + 2) % 3)]),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMA_M: f64 = 1e-4;
    const SIGMA_RAD: f64 = 2e-4;

    fn side(heading_rad: f64) -> Side {
        let covariance = Matrix2::new(SIGMA_M * SIGMA_M, 0.0, 0.0, SIGMA_RAD * SIGMA_RAD);
        Side { distance_m: 0.25, heading_rad, covariance, points: 300 }
    }

    /// Headings off by `apart` deviations of their difference: the stated deviation of the heading.
    fn stated(apart: f64) -> f64 {
        let (left, right) = (side(0.0), side(apart * SIGMA_RAD * 2.0_f64.sqrt()));
        both(&left, &right).heading_rad[1]
    }

    /// Of two headings of one deviation the mean has 1 / sqrt(2) of it, whatever chance makes them differ by; beyond three deviations the
    /// variance grows by the chi-square that is above nine, so at four deviations (sixteen) by seven.
    #[test]
    fn deviations_grow_only_with_what_chance_does_not_explain() {
        let usual = SIGMA_RAD / 2.0_f64.sqrt();
        for apart in [0.0, 1.0, 2.0, 2.99] {
            assert!((stated(apart) / usual - 1.0).abs() < 1e-9, "{apart}: {}", stated(apart));
        }
        assert!((stated(4.0) / usual - 8.0_f64.sqrt()).abs() < 1e-6, "{}", stated(4.0));
    }
}
