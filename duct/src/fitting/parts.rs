//! The plans of a fitting's cells.

use nalgebra::{Point2, Point3};

use super::port::PortName;
use super::{Fitting, Shape, elbow, junction, transition};
use crate::Transform;
use crate::cell::Slant;

/// What a side of a cell's plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Sheet metal.
    Wall,
    /// A port of the fitting.
    Port(PortName),
    /// The way into another part, by its index.
    Part(usize),
}

/// A cell of a fitting: a convex plan, anticlockwise, between floor and ceiling.
pub(super) struct Part {
    pub(super) corners: Vec<Point2<f64>>,
    pub(super) roles: Vec<Role>,
    pub(super) slants: [Slant; 2],
}

impl Part {
    /// Sides given by the corner that each starts at; level floor and ceiling.
    pub(super) fn level(sides: &[(Point2<f64>, Role)], height_m: f64) -> Self {
        let (corners, roles) = sides.iter().copied().unzip();
        Self { corners, roles, slants: [Slant::level(0.0), Slant::level(height_m)] }
    }

    /// A four-sided cell between two seams, each given as (left, right).
    pub(super) fn between(entry: [Point2<f64>; 2], exit: [Point2<f64>; 2], [before, after]: [Role; 2], height_m: f64) -> Self {
        let sides = [(entry[0], before), (entry[1], Role::Wall), (exit[1], after), (exit[0], Role::Wall)];
        Self::level(&sides, height_m)
    }

    /// The same on the other side of the duct's middle.
    pub(super) fn mirrored(self) -> Self {
        let n = self.corners.len();
        let swapped = |role: Role| match role {
            Role::Port(PortName::Left) => Role::Port(PortName::Right),
            Role::Port(PortName::Right) => Role::Port(PortName::Left),
            other => other,
        };
        Self {
            corners: self.corners.iter().rev().map(|c| Point2::new(c.x, -c.y)).collect(),
            roles: (0..n).map(|i| swapped(self.roles[(2 * n - 2 - i) % n])).collect(),
            slants: self.slants,
        }
    }
}

/// A chain of cells between seams; each seam is the middle of the duct there, x along it.
pub(super) fn chain(seams: &[Transform], width_m: f64, height_m: f64) -> Vec<Part> {
    let half = width_m / 2.0;
    let ends = |seam: &Transform| [half, -half].map(|y| (seam * Point3::new(0.0, y, 0.0)).xy());
    let count = seams.len() - 1;
    (0..count)
        .map(|i| {
            let before = if i == 0 { Role::Port(PortName::In) } else { Role::Part(i - 1) };
            let after = if i + 1 == count { Role::Port(PortName::Out) } else { Role::Part(i + 1) };
            Part::between(ends(&seams[i]), ends(&seams[i + 1]), [before, after], height_m)
        })
        .collect()
}

impl Fitting {
    /// Plans of the cells that lie between its ports; shafts below a floor are not among them.
    pub(super) fn parts(&self) -> Vec<Part> {
        let (width_m, height_m) = (self.width_m, self.height_m);
        match self.shape {
            Shape::Straight { length_m }
            | Shape::Damper { length_m, .. }
            | Shape::Grille { length_m, .. }
            | Shape::Drop { length_m, .. } => {
                chain(&[Transform::identity(), Transform::translation(length_m, 0.0, 0.0)], width_m, height_m)
            }
            Shape::RadiusElbow { angle_rad, .. } => chain(&elbow::gore_seams(angle_rad, self.curvature_1_m()), width_m, height_m),
            Shape::MitredElbow { angle_rad } | Shape::VanedElbow { angle_rad } => {
                elbow::wedges(angle_rad, width_m, height_m, &self.entry_from_exit())
            }
            Shape::Offset { length_m, aside_m } => chain(&elbow::offset_seams(length_m, aside_m), width_m, height_m),
            Shape::Transition { .. } | Shape::Slope { .. } => vec![transition::part(self)],
            Shape::Tee { hand, branch_width_m } => junction::tee(hand, width_m, height_m, branch_width_m),
            Shape::BullheadTee { branch_width_m } => junction::bullhead(width_m, height_m, branch_width_m),
            Shape::SideBranch { hand, branch_width_m, shoe_m } => {
                junction::side_branch(hand, [width_m, height_m], branch_width_m, shoe_m)
            }
            Shape::Wye { half_angle_rad, branch_width_m } => {
                junction::WyePlan::new(width_m, branch_width_m, half_angle_rad).parts(height_m)
            }
            Shape::Cross { branch_width_m } => junction::cross(width_m, height_m, branch_width_m),
        }
    }
}
