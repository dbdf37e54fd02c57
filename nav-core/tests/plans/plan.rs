//! Plans of ducts as walls, and what a line scanner sees of them.

use ductloop_nav::ahead::{Fitting, Side};
use ductloop_nav::perception::{RangePoint, Upon};
use nalgebra::Point3;

/// A wall from one point to another, in metres.
pub(crate) type Wall = [[f64; 2]; 2];

pub(crate) const WIDTH_M: f64 = 0.5;
pub(crate) const HALF_M: f64 = WIDTH_M / 2.0;
/// The camera stands so far ahead of the base's origin, in metres, and sees so far to each side, in radians.
pub(crate) const CAMERA_M: f64 = 0.12;
pub(crate) const VIEW_RAD: f64 = 0.7;
pub(crate) const BLOCKS: usize = 160;
/// Range at which a laser that rises meets the ceiling, in metres.
pub(crate) const CEILING_M: f64 = 2.6;
/// The junctions begin here, in metres.
pub(crate) const AT_M: f64 = 3.0;

/// What a scanner at a pose of the duct (along, left, heading) sees, with ranges off by up to `noise` of a pixel's worth.
pub(crate) fn scan(walls: &[Wall], pose: [f64; 3], noise: f64) -> Vec<RangePoint> {
    let (sin, cos) = libm::sincos(pose[2]);
    let from = [pose[0] + cos * CAMERA_M, pose[1] + sin * CAMERA_M];
    let mut points = Vec::new();
    for block in 0..BLOCKS {
        // Blocks are equally wide in the image, from the left.
        let tangent = libm::tan(VIEW_RAD) * (1.0 - 2.0 * (block as f64 + 0.5) / BLOCKS as f64);
        let bearing = libm::atan(tangent);
        let (way_y, way_x) = libm::sincos(pose[2] + bearing);
        let hit = |wall: &Wall| {
            let [a, b] = *wall;
            let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
            let determinant = way_y * ex - way_x * ey;
            if determinant.abs() < 1e-12 {
                return None;
            }
            let (dx, dy) = (a[0] - from[0], a[1] - from[1]);
            let range = (dy * ex - dx * ey) / determinant;
            let share = (dy * way_x - dx * way_y) / determinant;
            (range > 1e-6 && (0.0..=1.0).contains(&share)).then_some(range)
        };
        let range = walls.iter().filter_map(hit).fold(CEILING_M, f64::min);
        // Depth is 22.7 / row: a pixel is worth depth squared over 22.7.
        let sway = libm::sin(12.9898 * block as f64 + 78.233 * pose[0]) * noise;
        let range = range + sway * range * range / 22.7;
        let (x, y) = (CAMERA_M + libm::cos(bearing) * range, libm::sin(bearing) * range);
        points.push(RangePoint { point_in_base: Point3::new(x, y, 0.1), laser: 0, block, upon: Upon::Upright });
    }
    points
}

pub(crate) fn side_wall(y: f64, from_m: f64, to_m: f64) -> Wall {
    [[from_m, y], [to_m, y]]
}

pub(crate) fn across(s: f64, from_y: f64, to_y: f64) -> Wall {
    [[s, from_y], [s, to_y]]
}

/// The walls' offsets become these over 0.3 m.
fn transition(left_m: f64, right_m: f64) -> Vec<Wall> {
    let end = AT_M + 0.3;
    vec![
        side_wall(HALF_M, 0.0, AT_M),
        side_wall(-HALF_M, 0.0, AT_M),
        [[AT_M, HALF_M], [end, left_m]],
        [[AT_M, -HALF_M], [end, -right_m]],
        side_wall(left_m, end, 12.0),
        side_wall(-right_m, end, 12.0),
    ]
}

/// Elbows to the left of any angle: their walls, and where the middle of the duct behind them begins, with its heading. A throat of radius
/// zero is a mitre's.
pub(crate) fn elbow(turn_rad: f64, throat_m: f64) -> (Vec<Wall>, [f64; 3]) {
    let long_m = 6.0;
    let (sin, cos) = libm::sincos(turn_rad);
    let on = |radius: f64, angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        [AT_M + radius * sin, HALF_M + throat_m - radius * cos]
    };
    let along = |[x, y]: [f64; 2]| [[x, y], [x + long_m * cos, y + long_m * sin]];
    let mut walls = vec![side_wall(HALF_M, 0.0, AT_M)];
    let heel_m = throat_m + WIDTH_M;
    if throat_m == 0.0 {
        let corner = [AT_M + WIDTH_M * libm::tan(turn_rad / 2.0), -HALF_M];
        walls.extend([[[0.0, -HALF_M], corner], along(corner)]);
    } else {
        let steps = 12;
        walls.push(side_wall(-HALF_M, 0.0, AT_M));
        for radius in [throat_m, heel_m] {
            let at = |i: usize| on(radius, turn_rad * i as f64 / steps as f64);
            walls.extend((0..steps).map(|i| [at(i), at(i + 1)]));
        }
        walls.push(along(on(heel_m, turn_rad)));
    }
    walls.push(along(on(throat_m, turn_rad)));
    let [x, y] = on(throat_m + HALF_M, turn_rad);
    (walls, [x, y, turn_rad])
}

/// Fittings at [`AT_M`], with branches as wide as the duct and long.
pub(crate) fn plans() -> Vec<(Fitting, Vec<Wall>)> {
    let (w, far) = (WIDTH_M, 9.0);
    let (left, right) = (HALF_M, -HALF_M);
    let whole = |y| side_wall(y, 0.0, far);
    let elbow =
        vec![side_wall(left, 0.0, AT_M), side_wall(right, 0.0, AT_M + w), across(AT_M, left, far), across(AT_M + w, right, far)];
    // A radius elbow with a throat of 3/4 of its width.
    let (throat, heel) = (0.75 * w, 1.75 * w);
    let arc = |radius: f64| {
        let at = move |i: usize| {
            let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_2 * i as f64 / 12.0);
            [AT_M + radius * sin, left + throat - radius * cos]
        };
        (0..12).map(move |i| [at(i), at(i + 1)])
    };
    let radius_elbow: Vec<Wall> = [side_wall(left, 0.0, AT_M), side_wall(right, 0.0, AT_M)]
        .into_iter()
        .chain(arc(throat))
        .chain(arc(heel))
        .chain([across(AT_M + throat, left + throat, far), across(AT_M + heel, left + throat, far)])
        .collect();
    let branch = |sign: f64| {
        let (near, other) = (sign * HALF_M, -sign * HALF_M);
        vec![
            side_wall(near, 0.0, AT_M),
            side_wall(near, AT_M + w, far),
            across(AT_M, near, sign * far),
            across(AT_M + w, near, sign * far),
            whole(other),
        ]
    };
    let stem = [side_wall(left, 0.0, AT_M), side_wall(right, 0.0, AT_M)];
    let bullhead: Vec<Wall> =
        stem.into_iter().chain([across(AT_M + w, -far, far), across(AT_M, left, far), across(AT_M, right, -far)]).collect();
    let cross: Vec<Wall> =
        branch(1.0).into_iter().chain(branch(-1.0)).filter(|wall| *wall != whole(left) && *wall != whole(right)).collect();
    let mirrored = |walls: &[Wall]| walls.iter().map(|[a, b]| [[a[0], -a[1]], [b[0], -b[1]]]).collect::<Vec<Wall>>();
    vec![
        (Fitting::Elbow(Side::Right), mirrored(&elbow)),
        (Fitting::Elbow(Side::Left), elbow),
        (Fitting::Elbow(Side::Right), mirrored(&radius_elbow)),
        (Fitting::Elbow(Side::Left), radius_elbow),
        (Fitting::Branch(Side::Left), branch(1.0)),
        (Fitting::Branch(Side::Right), branch(-1.0)),
        (Fitting::BullheadTee, bullhead),
        (Fitting::Cross, cross),
        (Fitting::Transition, transition(0.3, 0.3)),
        (Fitting::Transition, transition(0.2, 0.2)),
        // Flush on one side.
        (Fitting::Transition, transition(HALF_M, 0.35)),
        (Fitting::Transition, transition(0.15, HALF_M)),
        (Fitting::Obstacle, vec![whole(left), whole(right), across(AT_M, -0.1, 0.12)]),
        (Fitting::DeadEnd, stem.into_iter().chain([across(AT_M, right, left)]).collect()),
    ]
}
