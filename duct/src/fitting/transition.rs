//! Fittings whose section moves or changes evenly along them: transitions and slopes.

use nalgebra::Point2;

use super::parts::{Part, Role};
use super::port::PortName;
use super::{AcrossAlign, Fitting, Shape, UprightAlign};
use crate::Transform;
use crate::cell::Slant;

/// Where a transition's exit lies: its middle aside, and its floor.
fn exit_aside_and_z_m(fitting: &Fitting) -> [f64; 2] {
    match fitting.shape {
        Shape::Transition { to_width_m, to_height_m, across, upright, .. } => {
            let narrower_m = (fitting.width_m - to_width_m) / 2.0;
            let aside_m = match across {
                AcrossAlign::Concentric => 0.0,
                AcrossAlign::Left => narrower_m,
                AcrossAlign::Right => -narrower_m,
            };
            let z_m = match upright {
                UprightAlign::FlatBottom => 0.0,
                UprightAlign::Concentric => (fitting.height_m - to_height_m) / 2.0,
            };
            [aside_m, z_m]
        }
        Shape::Slope { length_m, angle_rad } => [0.0, length_m * libm::tan(angle_rad)],
        _ => [0.0; 2],
    }
}

/// Pose of the exit.
pub(super) fn entry_from_exit(fitting: &Fitting) -> Transform {
    let [aside_m, z_m] = exit_aside_and_z_m(fitting);
    let (length_m, ..) = exit(fitting);
    Transform::translation(length_m, aside_m, z_m)
}

/// Length along the duct, and width and height at the exit.
fn exit(fitting: &Fitting) -> (f64, f64, f64) {
    match fitting.shape {
        Shape::Transition { length_m, to_width_m, to_height_m, .. } => (length_m, to_width_m, to_height_m),
        Shape::Slope { length_m, .. } => (length_m, fitting.width_m, fitting.height_m),
        _ => (fitting.length_m(), fitting.width_m, fitting.height_m),
    }
}

/// By how much the side that moves most moves along the fitting.
pub(super) fn most_drawn_in_m(fitting: &Fitting) -> f64 {
    let [aside_m, z_m] = exit_aside_and_z_m(fitting);
    let (_, to_width_m, to_height_m) = exit(fitting);
    let (half, to_half) = (fitting.width_m / 2.0, to_width_m / 2.0);
    let moved = [half - (aside_m + to_half), half + (aside_m - to_half), z_m, fitting.height_m - (z_m + to_height_m)];
    moved.iter().fold(0.0, |most: f64, moved| most.max(moved.abs()))
}

/// Its one cell.
pub(super) fn part(fitting: &Fitting) -> Part {
    let [aside_m, z_m] = exit_aside_and_z_m(fitting);
    let (length_m, to_width_m, to_height_m) = exit(fitting);
    let (half, to_half) = (fitting.width_m / 2.0, to_width_m / 2.0);
    let entry = [Point2::new(0.0, half), Point2::new(0.0, -half)];
    let exit = [Point2::new(length_m, aside_m + to_half), Point2::new(length_m, aside_m - to_half)];
    let roles = [Role::Port(PortName::In), Role::Port(PortName::Out)];
    let slants = [Slant::along(0.0, z_m, length_m), Slant::along(fitting.height_m, z_m + to_height_m, length_m)];
    Part { slants, ..Part::between(entry, exit, roles, fitting.height_m) }
}
