//! Fittings: each made of convex cells between an entry and an exit port, with its piece of the centreline.
//!
//! In a fitting's own frame the entry port lies in the plane x = 0, centred on y = 0, with the floor at z = 0.

use std::f64::consts::PI;

use nalgebra::Point2;

use crate::Transform;
use crate::cell::{Beyond, Cell, Side, SurfaceId};
use crate::centreline::start_from_along;

/// Widest angle of a gore, in radians (7.5 degrees). Between its seams a gore's outer wall stands inside the true cylinder by
/// R (1 - cos(3.75 degrees)), 2.1 mm for R = 1 m.
const GORE_MAX_RAD: f64 = PI / 24.0;

/// What a fitting is. Angles are positive for a turn to the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight duct.
    Straight {
        /// Its length, in metres.
        length_m: f64,
    },
    /// An elbow with curved throat and heel, made as a chain of gores.
    RadiusElbow {
        /// Turn, in radians, within (0, pi] either way.
        angle_rad: f64,
        /// Radius of the inner wall, in metres.
        throat_radius_m: f64,
    },
    /// An elbow of two straight ducts cut and joined at half the angle. The reference path through it is the arc about the
    /// inner corner, tangent to both centrelines, of half the width as radius.
    MitredElbow {
        /// Turn, in radians, within (0, 2 pi / 3] either way.
        angle_rad: f64,
    },
}

/// A fitting with its cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitting {
    /// What it is.
    pub shape: Shape,
    /// Inside width, in metres.
    pub width_m: f64,
    /// Inside height, in metres.
    pub height_m: f64,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// Why a fitting cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FittingError {
    /// A length that must be positive is not.
    #[error("{what} is {value_m} m; it must be positive and finite")]
    NotPositive {
        /// Which length.
        what: &'static str,
        /// Its value.
        value_m: f64,
    },
    /// An angle outside what the fitting can turn.
    #[error("a turn of {angle_deg} degrees; it must be between 1 and {max_deg} degrees either way")]
    Angle {
        /// The angle asked for.
        angle_deg: f64,
        /// The largest that this fitting can have.
        max_deg: f64,
    },
}

impl Fitting {
    /// Checks that the fitting can be made.
    ///
    /// # Errors
    /// The first dimension that is impossible.
    pub fn validate(&self) -> Result<(), FittingError> {
        let positive = |what, value_m: f64| {
            if value_m > 0.0 && value_m.is_finite() { Ok(()) } else { Err(FittingError::NotPositive { what, value_m }) }
        };
        let turn = |angle_rad: f64, max_deg: f64| {
            let angle_deg = angle_rad.to_degrees();
            if (1.0 - 1e-9..=max_deg + 1e-9).contains(&angle_deg.abs()) {
                Ok(())
            } else {
                Err(FittingError::Angle { angle_deg, max_deg })
            }
        };
        positive("the width", self.width_m)?;
        positive("the height", self.height_m)?;
        match self.shape {
            Shape::Straight { length_m } => positive("the length", length_m),
            Shape::RadiusElbow { angle_rad, throat_radius_m } => {
                positive("the throat radius", throat_radius_m)?;
                turn(angle_rad, 180.0)
            }
            Shape::MitredElbow { angle_rad } => turn(angle_rad, 120.0),
        }
    }

    /// Length of the reference path through it, in metres.
    pub fn length_m(&self) -> f64 {
        match self.shape {
            Shape::Straight { length_m } => length_m,
            Shape::RadiusElbow { angle_rad, .. } | Shape::MitredElbow { angle_rad } => {
                angle_rad.abs() / self.curvature_1_m().abs()
            }
        }
    }

    /// Curvature of the reference path, in 1/m, positive to the left.
    pub fn curvature_1_m(&self) -> f64 {
        match self.shape {
            Shape::Straight { .. } => 0.0,
            Shape::RadiusElbow { angle_rad, throat_radius_m } => angle_rad.signum() / (throat_radius_m + self.width_m / 2.0),
            Shape::MitredElbow { angle_rad } => angle_rad.signum() / (self.width_m / 2.0),
        }
    }

    /// Pose of the exit port in the fitting's frame, x pointing out of it.
    pub fn entry_from_exit(&self) -> Transform {
        start_from_along(self.curvature_1_m(), self.length_m())
    }

    /// The cells, in the fitting's frame, numbered from `first`. `before` and `after` say what lies beyond the ports.
    pub fn cells(&self, first: usize, fitting: usize, before: Side, after: Side) -> Vec<Cell> {
        let plans = self.plans();
        let count = plans.len();
        plans
            .into_iter()
            .enumerate()
            .map(|(i, plan)| {
                let entry = if i == 0 { before } else { Side::Portal(Beyond::Cell(first + i - 1)) };
                let exit = if i + 1 == count { after } else { Side::Portal(Beyond::Cell(first + i + 1)) };
                let sides: Vec<Side> = plan
                    .sides
                    .iter()
                    .map(|role| match role {
                        Role::Entry => entry,
                        Role::Exit => exit,
                        Role::Wall => Side::Wall,
                    })
                    .collect();
                Cell::prism(&plan.corners, self.height_m, &sides, self.surface, fitting)
            })
            .collect()
    }

    /// Plans of the cells from entry to exit, each anticlockwise.
    fn plans(&self) -> Vec<Plan> {
        let half = self.width_m / 2.0;
        match self.shape {
            Shape::Straight { length_m } => vec![Plan::between(
                [Point2::new(0.0, half), Point2::new(0.0, -half)],
                [Point2::new(length_m, half), Point2::new(length_m, -half)],
            )],
            Shape::RadiusElbow { angle_rad, .. } => {
                let gores = (angle_rad.abs() / GORE_MAX_RAD - 1e-9).ceil().max(1.0) as usize;
                let seam = |i: usize| {
                    let pose = start_from_along(self.curvature_1_m(), self.length_m() * i as f64 / gores as f64);
                    [half, -half].map(|y| (pose * nalgebra::Point3::new(0.0, y, 0.0)).xy())
                };
                (0..gores).map(|i| Plan::between(seam(i), seam(i + 1))).collect()
            }
            Shape::MitredElbow { angle_rad } => {
                // Two wedges. Their common edge is the inner corner; they meet in the plane from it to the outer corner.
                let side = angle_rad.signum();
                let inner = Point2::new(0.0, side * half);
                let outer = Point2::new(self.width_m * libm::tan(angle_rad.abs() / 2.0), -side * half);
                let heel_in = Point2::new(0.0, -side * half);
                let heel_out = (self.entry_from_exit() * nalgebra::Point3::new(0.0, -side * half, 0.0)).xy();
                let first = Plan { corners: vec![inner, heel_in, outer], sides: vec![Role::Entry, Role::Wall, Role::Exit] };
                let second = Plan { corners: vec![inner, outer, heel_out], sides: vec![Role::Entry, Role::Wall, Role::Exit] };
                if side > 0.0 { vec![first, second] } else { vec![first.mirrored(), second.mirrored()] }
            }
        }
    }
}

/// What a side of a cell's plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Entry,
    Wall,
    Exit,
}

struct Plan {
    corners: Vec<Point2<f64>>,
    sides: Vec<Role>,
}

impl Plan {
    /// A four-sided cell between two seams, each given as (left, right).
    fn between(entry: [Point2<f64>; 2], exit: [Point2<f64>; 2]) -> Self {
        Self { corners: vec![entry[0], entry[1], exit[1], exit[0]], sides: vec![Role::Entry, Role::Wall, Role::Exit, Role::Wall] }
    }

    /// Reverses a clockwise plan into an anticlockwise one; the sides keep their roles.
    fn mirrored(self) -> Self {
        let n = self.corners.len();
        Self {
            corners: self.corners.into_iter().rev().collect(),
            sides: (0..n).map(|i| self.sides[(2 * n - 2 - i) % n]).collect(),
        }
    }
}
