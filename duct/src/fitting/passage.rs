//! The reference path through a fitting: lines and arcs from one port to another.
//!
//! Where it turns in a junction it is the arc tangent to both centrelines, its radius half the narrower of the two widths. Elbows have
//! the arc that they are made about, offsets two arcs, and so have transitions that are not concentric. Floors that slope pitch it; in a
//! transition that is concentric upright but not across, two arcs rise evenly along their length, the floor evenly along the duct, and
//! the path lies up to tenths of a millimetre off the floor.

use super::port::{Port, PortName};
use super::{Fitting, Shape, elbow};
use crate::Transform;
use crate::centreline::start_from_along;

/// What is shorter than this is rounding, and no piece of path.
const ROUNDING_M: f64 = 1e-9;

/// A line or an arc of a passage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPiece {
    /// Where it starts, in the fitting's frame: x along the path seen from above, z up.
    pub entry_from_start: Transform,
    /// Its length along the path, in metres.
    pub length_m: f64,
    /// Curvature seen from above, in 1/m, positive to the left.
    pub curvature_1_m: f64,
    /// By how much it rises against the horizontal, in radians.
    pub pitch_rad: f64,
    /// Width of the duct at its start and at its end, in metres.
    pub width_m: [f64; 2],
    /// Height of the duct at its start and at its end, in metres.
    pub height_m: [f64; 2],
}

/// A line or an arc as it is seen from above: (length, curvature).
type Course = (f64, f64);

impl Fitting {
    /// The path from one port to another; `None` if the fitting has not both, or they are the same.
    pub fn passage(&self, from: PortName, to: PortName) -> Option<Vec<PathPiece>> {
        let (from, to) = (self.port(from)?, self.port(to)?);
        if from.name == to.name {
            return None;
        }
        let start = from.entry_from_inward();
        let courses = self.courses(&from, &to, &start)?;
        let level_m: f64 = courses.iter().map(|(length_m, _)| length_m).sum();
        let rise_m = to.entry_from_port.translation.z - from.entry_from_port.translation.z;
        let pitch_rad = if rise_m == 0.0 { 0.0 } else { libm::atan2(rise_m, level_m) };
        let stretch = if rise_m == 0.0 { 1.0 } else { (level_m * level_m + rise_m * rise_m).sqrt() / level_m };
        let mut at_m = 0.0;
        let mut pose = start;
        let share = |a: f64, b: f64, at_m: f64| if a == b { a } else { a + (b - a) * (at_m / level_m) };
        let pieces = courses.iter().map(|&(length_m, curvature_1_m)| {
            let end_m = at_m + length_m;
            let mut entry_from_start = pose;
            entry_from_start.translation.z += rise_m * (at_m / level_m);
            let piece = PathPiece {
                entry_from_start,
                length_m: length_m * stretch,
                curvature_1_m,
                pitch_rad,
                width_m: [at_m, end_m].map(|at_m| share(from.width_m, to.width_m, at_m)),
                height_m: [at_m, end_m].map(|at_m| share(from.height_m, to.height_m, at_m)),
            };
            pose *= start_from_along(curvature_1_m, length_m);
            at_m = end_m;
            piece
        });
        Some(pieces.collect())
    }

    fn courses(&self, from: &Port, to: &Port, start: &Transform) -> Option<Vec<Course>> {
        let way = if from.name == PortName::In { 1.0 } else { -1.0 };
        match self.shape {
            Shape::RadiusElbow { angle_rad, .. } | Shape::MitredElbow { angle_rad } | Shape::VanedElbow { angle_rad } => {
                let curvature_1_m = self.curvature_1_m();
                Some(vec![(elbow::length_m(angle_rad, curvature_1_m), way * curvature_1_m)])
            }
            Shape::Straight { length_m }
            | Shape::Slope { length_m, .. }
            | Shape::Damper { length_m, .. }
            | Shape::Grille { length_m, .. }
            | Shape::Drop { length_m, .. } => Some(vec![(length_m, 0.0)]),
            _ => joined(&(start.inverse() * to.entry_from_port), from.width_m.min(to.width_m) / 2.0),
        }
    }
}

/// Line, arc and line that leave the origin along x and end at this pose along its x; for a pose that is not turned, a line or two
/// arcs. `None` where the two lines do not meet between the ports.
fn joined(end: &Transform, radius_m: f64) -> Option<Vec<Course>> {
    let (forward, at) = (end.rotation * nalgebra::Vector3::x(), end.translation.vector);
    if forward.y.abs() < ROUNDING_M && forward.x > 0.0 {
        if at.y.abs() < ROUNDING_M {
            return Some(vec![(at.x, 0.0)]);
        }
        let curvature_1_m = at.y.signum() / elbow::offset_radius_m(at.x, at.y);
        let length_m = elbow::length_m(elbow::offset_angle_rad(at.x, at.y), curvature_1_m);
        return Some(vec![(length_m, curvature_1_m), (length_m, -curvature_1_m)]);
    }
    let turn_rad = libm::atan2(forward.y, forward.x);
    let after_m = at.y / forward.y;
    let before_m = at.x - after_m * forward.x;
    let half_tan = libm::tan(turn_rad.abs() / 2.0);
    let radius_m = radius_m.min(before_m.min(after_m) / half_tan);
    if radius_m <= ROUNDING_M {
        return None;
    }
    let tangent_m = radius_m * half_tan;
    let courses =
        [(before_m - tangent_m, 0.0), (turn_rad.abs() * radius_m, turn_rad.signum() / radius_m), (after_m - tangent_m, 0.0)];
    Some(courses.into_iter().filter(|(length_m, _)| *length_m > ROUNDING_M).collect())
}
