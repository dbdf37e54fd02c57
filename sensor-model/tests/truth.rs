//! The truth about a frame against closed forms: a straight duct is six planes, a stripe on a wall a straight line.

mod common;

use common::{base_at, duct, incra1, square_on, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_nav::rig::{Distortion, Rig};
use ductloop_sensor::Transform;
use ductloop_sensor::renderer::RenderError;
use ductloop_sensor::truth::{CentrePoint, FrameTruth, OPEN, SceneTruth};
use nalgebra::{Point3, Vector3};

/// Half the width, the height and the length of the duct, in metres.
const HALF_M: f64 = 0.25;
const HEIGHT_M: f64 = 0.3;
const LENGTH_M: f64 = 6.0;

/// Rounding of a point some metres away, in metres, and of its pixel.
const ROUNDING: f64 = 1e-9;
/// What is left of a bisected crossing, in pixels: where a stripe is seen nearly end on, rounding of the point is worth more.
const CROSSING_PX: f64 = 1e-7;

fn truth(network: &ductloop_duct::network::Network, rig: &Rig, base: &Transform) -> FrameTruth {
    SceneTruth::new(network, rig).of(&view(rig, base).world_from_camera).expect("the camera is in the duct")
}

fn pose(rig: &Rig, base: &Transform) -> Transform {
    view(rig, base).world_from_camera
}

/// Where a ray from a point inside the straight duct leaves it: the nearest of its planes, and the inward normal. None at the open end.
fn leaves(from: &Point3<f64>, way: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
    let planes = [
        (Vector3::y(), HALF_M),
        (-Vector3::y(), HALF_M),
        (Vector3::z(), HEIGHT_M),
        (-Vector3::z(), 0.0),
        (Vector3::x(), LENGTH_M),
        (-Vector3::x(), 0.0),
    ];
    let hits = planes.iter().filter(|(n, _)| n.dot(way) > 0.0).map(|(n, d)| ((d - n.dot(&from.coords)) / n.dot(way), *n));
    let (t, n) = hits.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a plane is ahead");
    (n != -Vector3::x()).then_some((t, -n))
}

/// Brown and Conrady's formula as it is printed in the documentation of `Distortion`.
fn seen_at(rig: &Rig, point: &[f64; 3]) -> [f64; 2] {
    let (x, y) = (point[0] / point[2], point[1] / point[2]);
    let Distortion { k1, k2, p1, p2, k3 } = rig.camera.distortion;
    let r2 = x * x + y * y;
    let radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    let (xd, yd) =
        (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
    [rig.camera.focal_px[0] * xd + rig.camera.centre_px[0], rig.camera.focal_px[1] * yd + rig.camera.centre_px[1]]
}

#[test]
fn depth_and_normal_are_those_of_the_nearest_plane() {
    let rig = wide();
    let network = duct(&[straight(1.9, 0.5, 0.3), straight(4.1, 0.5, 0.3)]);
    for (x, heading_deg) in [(1.5, 0.0), (1.0, 25.0), (1.2, 170.0)] {
        let base = base_at(x, 0.04, heading_deg);
        let frame = truth(&network, &rig, &base);
        let world_from_camera = pose(&rig, &base);
        let from = Point3::from(world_from_camera.translation.vector);
        let mut open = 0;
        for (i, depth_m) in frame.depth_m.iter().enumerate() {
            let ray = Vector3::new(((i % 640) as f64 - 319.5) / 378.4, ((i / 640) as f64 - 239.5) / 378.4, 1.0);
            match leaves(&from, &(world_from_camera.rotation * ray)) {
                None => {
                    assert!(depth_m.is_infinite() && frame.surface[i] == OPEN, "pixel {i}");
                    open += 1;
                }
                Some((z, normal)) => {
                    // Depths are in single precision.
                    assert!((f64::from(*depth_m) / z - 1.0).abs() < 1e-7 && frame.surface[i] == 0, "pixel {i}");
                    let seen = world_from_camera.rotation * Vector3::from(frame.normal[i].map(f64::from));
                    assert!((seen - normal).norm() < 1e-6, "pixel {i}");
                }
            }
        }
        assert_eq!(open > 0, heading_deg > 90.0, "{open} pixels look out of the open end");
    }
}

/// What must hold of every centre: on the laser's plane, on the duct, seen where the lens shows it, in the middle of a column or row.
fn assert_sound(rig: &Rig, world_from_camera: &Transform, point: &CentrePoint) {
    let laser = &rig.lasers[point.laser];
    let place = Point3::from(point.point_in_camera_m);
    assert!((laser.normal_in_camera.dot(&place.coords) - laser.offset_m).abs() < ROUNDING, "{point:?} is off the laser's plane");
    let [u, v] = seen_at(rig, &point.point_in_camera_m);
    assert!((u - point.u_px).abs() + (v - point.v_px).abs() < CROSSING_PX, "{point:?} is seen at ({u}, {v})");
    assert!(point.u_px.fract() == 0.0 || point.v_px.fract() == 0.0, "{point:?}");
    assert!(point.fan_rad.abs() <= laser.fan_rad / 2.0, "{point:?}");
    // The fan's angle from its own geometry: the cosine with the projection of the view onto the plane.
    let n = laser.normal_in_camera.into_inner();
    let middle = (Vector3::z() - n * n.z).normalize();
    let cosine = (place - laser.source_in_camera).normalize().dot(&middle);
    assert!((libm::cos(point.fan_rad) - cosine).abs() < 1e-9, "{point:?}");
    // From the source, nothing is nearer in an empty convex duct; from the camera neither.
    for from in [Point3::origin(), laser.source_in_camera] {
        let (from, to) = (world_from_camera * from, world_from_camera * place);
        let (t, _) = leaves(&from, &(to - from)).expect("light falls on a wall");
        assert!((t - 1.0).abs() < 1e-7, "{point:?} is not where the ray leaves the duct but at {t}");
    }
}

#[test]
fn every_centre_is_on_the_lasers_plane_and_on_the_duct_with_any_lens() {
    let bent = Distortion { k1: -0.18, k2: 0.04, p1: 0.001, p2: -0.0005, k3: -0.002 };
    let mut distorted = wide();
    distorted.camera.distortion = bent;
    let network = duct(&[straight(1.9, 0.5, 0.3), straight(4.1, 0.5, 0.3)]);
    for (rig, base) in
        [(wide(), base_at(1.5, 0.06, 6.0)), (distorted, base_at(1.4, -0.05, -8.0)), (incra1(), base_at(1.5, 0.02, 0.0))]
    {
        let frame = truth(&network, &rig, &base);
        assert!(frame.centres.len() > 400, "{} centres", frame.centres.len());
        let world_from_camera = pose(&rig, &base);
        for point in &frame.centres {
            assert_sound(&rig, &world_from_camera, point);
        }
    }
}

/// On a side wall X = -+ 1/4 of the camera looking straight along the duct, a laser's plane n . p = d gives
/// v(u) = fy y / z + v0 with x = (u - u0) / f, z = X / x, y = (d - n_x X - n_z z) / n_y: a straight line in the image.
#[test]
fn on_a_side_wall_every_column_has_its_centre_in_closed_form() {
    let rig = wide();
    let network = duct(&[straight(LENGTH_M, 0.5, 0.3)]);
    let frame = truth(&network, &rig, &base_at(1.5, 0.0, 0.0));
    // The camera is 0.1 m above the floor and 1.62 m from the entry.
    let (above_m, ahead_m) = (0.1, LENGTH_M - 1.62);
    for (index, laser) in rig.lasers.iter().enumerate() {
        let n = laser.normal_in_camera;
        let mut expected = 0;
        for u in 0..640 {
            let x = (f64::from(u) - 319.5) / 378.4;
            let side = HALF_M.copysign(x);
            let z = side / x;
            let y = (laser.offset_m - n.x * side - n.z * z) / n.y;
            let v = 378.4 * y / z + 239.5;
            // v is linear in 1/z, so in u: its slope is that of the pieces above.
            let slope = (laser.offset_m - n.x * side) / n.y / side;
            let way = Point3::new(side, y, z) - laser.source_in_camera;
            let middle = (Vector3::z() - n.into_inner() * n.z).normalize();
            let angle = libm::acos(way.normalize().dot(&middle));
            // Below the ceiling, above the floor (y points down), before the cap, within fan and image; not flatter than 45 degrees.
            let on_wall = y < above_m && y > above_m - HEIGHT_M && z < ahead_m;
            let in_view = angle < laser.fan_rad / 2.0 && (-0.5..479.5).contains(&v) && slope.abs() <= 1.0;
            let found: Vec<_> =
                frame.centres.iter().filter(|p| p.laser == index && p.u_px == f64::from(u) && p.v_px.fract() != 0.0).collect();
            if on_wall && in_view {
                expected += 1;
                let nearest = found.iter().map(|p| (p.v_px - v).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest < CROSSING_PX, "laser {index}, column {u}: {v} is missing, {found:?}");
            } else {
                // What is there is on another face.
                assert!(found.iter().all(|p| (p.point_in_camera_m[0].abs() - HALF_M).abs() > ROUNDING), "column {u}: {found:?}");
            }
        }
        assert!(expected > 300, "laser {index}: {expected} columns have their stripe on a wall");
    }
}

/// The share of the way from `from` to `to` at which it enters a box, if it does, by slabs.
fn enters(from: &Point3<f64>, to: &Point3<f64>, low: [f64; 3], high: [f64; 3]) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let step = to[axis] - from[axis];
        let (a, b) = ((low[axis] - from[axis]) / step, (high[axis] - from[axis]) / step);
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    (first < last).then_some(first)
}

#[test]
fn a_box_hides_and_shades_what_is_behind_it_and_carries_light_itself() {
    let rig = wide();
    let empty = duct(&[straight(LENGTH_M, 0.5, 0.3)]);
    let (low, high) = ([2.2, 0.02, 0.0], [2.28, 0.08, 0.14]);
    let mut boxed = empty.clone();
    let stand = Transform::translation(2.24, 0.05, 0.0);
    boxed.add_solid(&Solid::cuboid(&stand, Vector3::new(0.08, 0.06, 0.14), SurfaceId(1)));
    let base = base_at(1.5, 0.0, 0.0);
    let world_from_camera = pose(&rig, &base);
    let (without, with) = (truth(&empty, &rig, &base), truth(&boxed, &rig, &base));
    let same = |a: &CentrePoint, b: &CentrePoint| {
        a.laser == b.laser && (a.u_px - b.u_px).abs() < CROSSING_PX && (a.v_px - b.v_px).abs() < CROSSING_PX
    };
    let (mut kept, mut lost) = (0, 0);
    for point in &without.centres {
        let place = world_from_camera * Point3::from(point.point_in_camera_m);
        let source = world_from_camera * rig.lasers[point.laser].source_in_camera;
        let blocked = [source, world_from_camera * Point3::origin()].iter().any(|from| enters(from, &place, low, high).is_some());
        if blocked {
            assert!(!with.centres.iter().any(|p| same(p, point)), "{point:?} should be in shadow or hidden");
            lost += 1;
        } else if !with.centres.iter().any(|p| same(p, point)) {
            // Within a pixel of the box' outline a crossing may be lost: both ends of its column's step must not see the wall.
            let near = |du: f64, dv: f64| {
                let ray = Vector3::new((point.u_px + du - 319.5) / 378.4, (point.v_px + dv - 239.5) / 378.4, 1.0);
                let to = world_from_camera * Point3::from(ray * 3.0);
                enters(&(world_from_camera * Point3::origin()), &to, low, high).is_some()
            };
            assert!([-1.0, 1.0].iter().any(|d| near(*d, 0.0) || near(0.0, *d)), "{point:?} is lost");
        } else {
            kept += 1;
        }
    }
    assert!(kept > 300 && lost > 20, "{kept} kept, {lost} lost");
    let mut on_box = 0;
    for point in with.centres.iter().filter(|p| p.surface == 1) {
        // On the face toward the robot or the side toward the middle, where a ray from the source enters the box.
        let place = world_from_camera * Point3::from(point.point_in_camera_m);
        let source = world_from_camera * rig.lasers[point.laser].source_in_camera;
        let beyond = source + (place - source) * 2.0;
        assert!((enters(&source, &beyond, low, high).unwrap() - 0.5).abs() < 1e-7, "{point:?}");
        on_box += 1;
    }
    assert!(on_box > 10, "{on_box} centres on the box");
}

#[test]
fn without_shadows_a_box_only_hides() {
    let rig = wide();
    let empty = duct(&[straight(LENGTH_M, 0.5, 0.3)]);
    let (low, high) = ([2.2, 0.02, 0.0], [2.28, 0.08, 0.14]);
    let mut boxed = empty.clone();
    boxed.add_solid(&Solid::cuboid(&Transform::translation(2.24, 0.05, 0.0), Vector3::new(0.08, 0.06, 0.14), SurfaceId(1)));
    let base = base_at(1.5, 0.0, 0.0);
    let world_from_camera = pose(&rig, &base);
    let without = SceneTruth::new(&boxed, &rig).without_shadows().of(&world_from_camera).expect("the camera is in the duct");
    let mut in_light_through_the_box = 0;
    for point in without.centres.iter().filter(|p| p.surface == 0) {
        let place = world_from_camera * Point3::from(point.point_in_camera_m);
        assert!(enters(&(world_from_camera * Point3::origin()), &place, low, high).is_none_or(|share| share > 1.0), "{point:?}");
        let source = world_from_camera * rig.lasers[point.laser].source_in_camera;
        in_light_through_the_box += usize::from(enters(&source, &place, low, high).is_some_and(|share| share < 1.0));
    }
    assert!(in_light_through_the_box > 5, "{in_light_through_the_box}");
    // On the box itself nothing changes: what is turned away from a laser stays dark.
    let on_box = |frame: &FrameTruth| frame.centres.iter().filter(|p| p.surface == 1).copied().collect::<Vec<_>>();
    assert_eq!(on_box(&without), on_box(&truth(&boxed, &rig, &base)));
}

#[test]
fn what_cannot_be_seen_is_refused() {
    let network = duct(&[straight(LENGTH_M, 0.5, 0.3)]);
    let scene = SceneTruth::new(&network, &wide());
    assert!(matches!(scene.of(&pose(&wide(), &base_at(1.5, 0.4, 0.0))), Err(RenderError::OutsideNetwork { .. })));
    let mut folded = wide();
    folded.camera.distortion.k1 = -0.9;
    let refused = SceneTruth::new(&network, &folded).of(&pose(&folded, &base_at(1.5, 0.0, 0.0)));
    assert!(matches!(refused, Err(RenderError::Distortion { .. })));
}

/// The image ends half a pixel beyond the middle of its last row, and begins half a pixel before that of the first.
#[test]
fn stripes_in_the_outer_halves_of_the_border_pixels_are_seen() {
    const WALL_M: f64 = 0.12;
    let network = duct(&[straight(1.0 + 0.12 + WALL_M, 0.5, 0.3)]);
    for (row, is_seen) in [(479.3, true), (479.49, true), (479.6, false), (-0.3, true), (-0.6, false)] {
        let mut rig = square_on();
        // Level, and parallel to the line of sight.
        let height_m = (row - 239.5) / 378.4 * WALL_M;
        rig.lasers[0].source_in_camera = Point3::new(0.0, height_m, 0.0);
        rig.lasers[0].offset_m = height_m;
        let centres = truth(&network, &rig, &base_at(1.0, 0.0, 0.0)).centres;
        let on_wall: Vec<_> = centres.iter().filter(|c| (c.point_in_camera_m[2] - WALL_M).abs() < 1e-9).collect();
        // The fan of half a radian to each side reaches 378.4 tan(0.5) = 206.7 px from the middle, which is between two columns.
        assert_eq!(on_wall.len(), if is_seen { 2 * 207 } else { 0 }, "row {row}");
        assert!(on_wall.iter().all(|centre| (centre.v_px - row).abs() < 1e-9), "row {row}");
    }
}
