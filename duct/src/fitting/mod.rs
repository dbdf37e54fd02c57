//! Fittings: each made of convex cells between its ports, with the paths that lead through it.
//!
//! - `shape`: what fittings there are, and their dimensions;
//! - `validity`: which dimensions can be made;
//! - [`port`]: where and how wide a fitting's ports are;
//! - `parts`, with `elbow`, `transition` and `junction`: the plans of the cells, family by family;
//! - `furniture`: vanes, curtains, louvres and holes;
//! - [`passage`]: the reference path from one port to another.
//!
//! In a fitting's own frame the port `in` lies in the plane x = 0, centred on y = 0, with the floor at z = 0; x points into the
//! fitting. Ports always stand upright; between them floor and ceiling may slope.

mod elbow;
mod furniture;
mod junction;
mod parts;
pub mod passage;
pub mod port;
mod shape;
mod transition;
mod validity;

pub use shape::{AcrossAlign, Blade, GrilleSide, Hand, Shape, UprightAlign};
pub use validity::FittingError;

use crate::Transform;
use crate::cell::{Beyond, Cell, Side, SurfaceId};
use parts::Role;
use port::PortName;

/// A fitting with its cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitting {
    /// What it is.
    pub shape: Shape,
    /// Inside width at the port `in`, in metres.
    pub width_m: f64,
    /// Inside height at the port `in`, in metres.
    pub height_m: f64,
    /// What it is made of.
    pub surface: SurfaceId,
}

impl Fitting {
    /// Length of the reference path from `in` straight through to `out`, in metres; zero without such a way.
    pub fn length_m(&self) -> f64 {
        self.passage(PortName::In, PortName::Out).map_or(0.0, |path| path.iter().map(|piece| piece.length_m).sum())
    }

    /// Curvature of the reference path where it leaves `in` for `out`, in 1/m, positive to the left.
    pub fn curvature_1_m(&self) -> f64 {
        match self.shape {
            Shape::RadiusElbow { angle_rad, throat_radius_m } => elbow::curvature_1_m(angle_rad, throat_radius_m, self.width_m),
            Shape::MitredElbow { angle_rad } | Shape::VanedElbow { angle_rad } => {
                elbow::curvature_1_m(angle_rad, 0.0, self.width_m)
            }
            _ => 0.0,
        }
    }

    /// Pose of the port `out` in the fitting's frame, x pointing out of it; of a fitting without one, where it would be.
    pub fn entry_from_exit(&self) -> Transform {
        self.port(PortName::Out).map_or_else(Transform::identity, |port| port.entry_from_port)
    }

    /// Whether a robot can drive through it: not past turning vanes or a shut damper, nor over a hole in the floor.
    pub fn is_passable(&self) -> bool {
        !matches!(self.shape, Shape::VanedElbow { .. } | Shape::Damper { blade: Blade::Shut, .. } | Shape::Drop { .. })
    }

    /// Whether it has more than two ports, so that a route must say which way to take.
    pub fn is_junction(&self) -> bool {
        self.ports().len() > 2
    }

    /// The cells, in the fitting's frame, numbered from `first`; `at_port` says what lies beyond a port.
    pub fn cells(&self, first: usize, fitting: usize, at_port: impl Fn(PortName) -> Side) -> Vec<Cell> {
        let side = |role: &Role| match role {
            Role::Wall => Side::Wall,
            Role::Port(name) => at_port(*name),
            Role::Part(part) => Side::Portal(Beyond::Cell(first + part)),
        };
        let parts = self.parts();
        let build = |part: &parts::Part| {
            let sides: Vec<Side> = part.roles.iter().map(side).collect();
            Cell::upright(&part.corners, part.slants, &sides, self.surface, fitting)
        };
        let mut cells = parts.iter().map(build).collect();
        self.furnish(&mut cells, first);
        cells
    }

    /// How many cells it has, and which of them, counted from 0, ends at this port.
    pub(crate) fn cell_at_port(&self, port: PortName) -> (usize, usize) {
        let parts = self.parts();
        let at = parts.iter().position(|part| part.roles.contains(&Role::Port(port))).unwrap_or(0);
        (parts.len() + self.cells_below(), at)
    }
}
