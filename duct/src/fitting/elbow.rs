//! Elbows and S-bends: gores of arcs, wedges of mitres.

use std::f64::consts::PI;

use nalgebra::Point2;

use super::parts::{Part, Role};
use super::port::PortName;
use crate::Transform;
use crate::centreline::start_from_along;

/// Widest angle of a gore, in radians (7.5 degrees). Between its seams a gore's outer wall stands inside the true cylinder by
/// R (1 - cos(3.75 degrees)), 2.1 mm for R = 1 m.
const GORE_MAX_RAD: f64 = PI / 24.0;

/// Curvature of an elbow's centreline, positive to the left.
pub(super) fn curvature_1_m(angle_rad: f64, throat_radius_m: f64, width_m: f64) -> f64 {
    angle_rad.signum() / (throat_radius_m + width_m / 2.0)
}

/// Length of an elbow's centreline.
pub(super) fn length_m(angle_rad: f64, curvature_1_m: f64) -> f64 {
    angle_rad.abs() / curvature_1_m.abs()
}

/// Seams of an arc's gores, from its start to its end.
pub(super) fn gore_seams(angle_rad: f64, curvature_1_m: f64) -> Vec<Transform> {
    let gores = (angle_rad.abs() / GORE_MAX_RAD - 1e-9).ceil().max(1.0) as usize;
    let length_m = length_m(angle_rad, curvature_1_m);
    (0..=gores).map(|i| start_from_along(curvature_1_m, length_m * i as f64 / gores as f64)).collect()
}

/// Radius of an offset's two arcs along their middle. The chord of each is half the way from `in` to `out`, and each turns by twice
/// the angle of that chord.
pub(super) fn offset_radius_m(length_m: f64, aside_m: f64) -> f64 {
    (length_m * length_m + aside_m * aside_m) / (4.0 * aside_m.abs())
}

/// By how much each arc of an offset turns; the first one to the offset's side.
pub(super) fn offset_angle_rad(length_m: f64, aside_m: f64) -> f64 {
    2.0 * libm::atan2(aside_m.abs(), length_m)
}

/// Seams of an offset's gores.
pub(super) fn offset_seams(length_m: f64, aside_m: f64) -> Vec<Transform> {
    let angle_rad = offset_angle_rad(length_m, aside_m);
    let curvature_1_m = aside_m.signum() / offset_radius_m(length_m, aside_m);
    let mut seams = gore_seams(angle_rad, curvature_1_m);
    let Some(middle) = seams.last().copied() else { return seams };
    seams.extend(gore_seams(angle_rad, -curvature_1_m).iter().skip(1).map(|seam| middle * seam));
    // Where the port is, without the rounding of the way there.
    if let Some(end) = seams.last_mut() {
        *end = Transform::translation(length_m, aside_m, 0.0);
    }
    seams
}

/// The two cells of a mitred elbow. Their common edge is the inner corner; they meet in the plane from it to the outer corner.
pub(super) fn wedges(angle_rad: f64, width_m: f64, height_m: f64, entry_from_exit: &Transform) -> Vec<Part> {
    let (side, half) = (angle_rad.signum(), width_m / 2.0);
    let inner = Point2::new(0.0, side * half);
    let outer = Point2::new(width_m * libm::tan(angle_rad.abs() / 2.0), -side * half);
    let heel_in = Point2::new(0.0, -side * half);
    let heel_out = (entry_from_exit * nalgebra::Point3::new(0.0, -side * half, 0.0)).xy();
    let (entry, exit) = (Role::Port(PortName::In), Role::Port(PortName::Out));
    // Anticlockwise for a turn to the left.
    let [first, second] = [
        [(inner, entry), (heel_in, Role::Wall), (outer, Role::Part(1))],
        [(inner, Role::Part(0)), (outer, Role::Wall), (heel_out, exit)],
    ];
    [first, second].map(|sides| if side > 0.0 { Part::level(&sides, height_m) } else { turned(&sides, height_m) }).into()
}

/// A plan of three sides given clockwise, made anticlockwise: the same sides from the same corners.
fn turned([a, b, c]: &[(Point2<f64>, Role); 3], height_m: f64) -> Part {
    Part::level(&[(c.0, b.1), (b.0, a.1), (a.0, c.1)], height_m)
}
