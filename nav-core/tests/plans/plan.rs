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
/// The laser that falls meets a level floor so far ahead of the base, in metres, and falls by so much over that: 0.16 of a height of 0.17
/// m.
pub(crate) const FLOOR_M: f64 = 1.06;
const FALL: f64 = 0.16;
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

/// A floor that is no longer level from some place on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Floor {
    /// A hole from here to there.
    Hole { from_m: f64, to_m: f64 },
    /// It falls away by this slope from here on.
    Crest { from_m: f64, slope: f64 },
}

/// What [`scan`] shows, and what a laser that falls shows of the floor between these walls. A robot beyond a crest stands on what falls.
pub(crate) fn scan_with_floor(walls: &[Wall], floor: Floor, pose: [f64; 3], noise: f64) -> Vec<RangePoint> {
    let mut points = scan(walls, pose, noise);
    let level = |x: f64, upon: Upon| (x, upon);
    for block in 0..BLOCKS {
        let upright = points[block].point_in_base;
        let tangent = libm::tan(VIEW_RAD) * (1.0 - 2.0 * (block as f64 + 0.5) / BLOCKS as f64);
        let (x, upon) = match floor {
            Floor::Hole { from_m, to_m } if (from_m..to_m).contains(&(pose[0] + FLOOR_M)) => level(FLOOR_M, Upon::Nothing),
            // The plane of the light and that of the floor behind the crest meet farther on.
            Floor::Crest { from_m, slope } if pose[0] < from_m && pose[0] + FLOOR_M > from_m => {
                let over_m = pose[0] + FLOOR_M - from_m;
                let x = from_m - pose[0] + over_m * FALL / (FALL - slope);
                points.push(below(x, tangent, block, upright.x));
                level(FLOOR_M, Upon::Nothing)
            }
            Floor::Hole { .. } | Floor::Crest { .. } => level(FLOOR_M, Upon::Floor),
        };
        // A wall that stands nearer has the light.
        if x < upright.x {
            let point_in_base = Point3::new(x, (x - CAMERA_M) * tangent, 0.0);
            points.push(RangePoint { point_in_base, laser: 1, block, upon });
        }
    }
    points
}

/// Light on a floor that falls away, or none where a wall stands nearer.
fn below(x: f64, tangent: f64, block: usize, wall_m: f64) -> RangePoint {
    let upon = if x < wall_m { Upon::Below } else { Upon::Air };
    RangePoint { point_in_base: Point3::new(x.min(wall_m), (x.min(wall_m) - CAMERA_M) * tangent, -0.02), laser: 1, block, upon }
}

/// A wye whose legs leave a duct of 0.5 m by this angle, each of this width: its walls, and the middle line of the left leg (a point and
/// the heading).
pub(crate) fn wye(turn_rad: f64, leg_m: f64) -> (Vec<Wall>, [f64; 3]) {
    let (sin, cos) = libm::sincos(turn_rad);
    let along = |[x, y]: [f64; 2]| [[x, y], [x + 6.0 * cos, y + 6.0 * sin]];
    // The crotch: on the middle, where the leg's inner wall crosses it.
    let inner = [AT_M + leg_m * sin, HALF_M - leg_m * cos];
    let crotch = [inner[0] - inner[1] * cos / sin, 0.0];
    let mirrored = |[[ax, ay], [bx, by]]: Wall| [[ax, -ay], [bx, -by]];
    let left = [side_wall(HALF_M, 0.0, AT_M), along([AT_M, HALF_M]), along(crotch)];
    let walls = left.into_iter().chain(left.into_iter().map(mirrored)).collect();
    (walls, [AT_M + leg_m / 2.0 * sin, HALF_M - leg_m / 2.0 * cos, turn_rad])
}

/// A branch to the left with a shoe of 45 degrees, this long, on the near or on the far side of its opening: the middle of the branch is
/// at the second figure.
pub(crate) fn shoed(shoe_m: f64, is_near: bool) -> (Vec<Wall>, f64) {
    let (from, to) = if is_near { (AT_M + shoe_m, AT_M + shoe_m + WIDTH_M) } else { (AT_M, AT_M + WIDTH_M) };
    let end = if is_near { to } else { to + shoe_m };
    let (near_y, far_y) = if is_near { (HALF_M + shoe_m, HALF_M) } else { (HALF_M, HALF_M + shoe_m) };
    let walls = vec![
        side_wall(-HALF_M, 0.0, 9.0),
        side_wall(HALF_M, 0.0, AT_M),
        [[AT_M, HALF_M], [from, near_y]],
        across(from, near_y, 9.0),
        across(to, far_y, 9.0),
        [[to, far_y], [end, HALF_M]],
        side_wall(HALF_M, end, 9.0),
    ];
    (walls, (from + to) / 2.0)
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
