//! Fittings joined port to port: which cell holds a point, and what a ray meets.
//!
//! - `assembly`: pieces joined by name, placed, and refused where they do not fit;
//! - `overlap`: whether two of them occupy the same space;
//! - `route`: the path that a turn at each junction makes;
//! - `exploration`: the route that sees every branch.

mod assembly;
mod exploration;
mod overlap;
mod route;

pub use assembly::{Attached, Join, NetworkError, Piece, PortRef};
pub use route::{RouteError, Turn};

use nalgebra::{Point3, Unit, Vector3};

use crate::Transform;
use crate::cell::{Beyond, Cell, CellId, Face, Plane, Solid, SurfaceId};
use crate::centreline::Centreline;
use crate::fitting::Fitting;
use crate::fitting::port::PortName;

/// How an end of a network is finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Open: rays leave the network there.
    Open,
    /// Closed by a flat cap.
    Cap,
}

/// A duct network in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// Its cells, in the order of their fittings.
    pub cells: Vec<Cell>,
    /// Its fittings, in the order given.
    pub fittings: Vec<Fitting>,
    /// What each fitting is called.
    pub names: Vec<String>,
    /// Where each fitting's own frame lies.
    pub world_from_fitting: Vec<Transform>,
    /// What each port of each fitting leads to.
    attached: Vec<Vec<(PortName, Attached)>>,
    /// The reference path: the one straight through, unless another is put in its place.
    pub centreline: Centreline,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where, in the world.
    pub point: Point3<f64>,
    /// How far along the ray, in metres.
    pub distance_m: f64,
    /// Normal of what was met, pointing toward the side that the ray came from.
    pub normal: Unit<Vector3<f64>>,
    /// What it is made of.
    pub surface: SurfaceId,
    /// The cell in which it was met.
    pub cell: CellId,
}

impl Network {
    /// Indices of a fitting's cells. Cells are in the order of their fittings.
    pub fn cells_of(&self, fitting: usize) -> std::ops::Range<CellId> {
        let start = self.cells.partition_point(|cell| cell.fitting < fitting);
        start..self.cells.partition_point(|cell| cell.fitting <= fitting)
    }

    /// Each join once, in the order of the later fitting, then of its ports: the port of the earlier fitting, then that of the later.
    pub fn joined_ports(&self) -> Vec<(PortRef, PortRef)> {
        let mut joins = Vec::new();
        for (piece, ports) in self.attached.iter().enumerate() {
            for (name, what) in ports {
                if let Attached::Port(other) = *what
                    && other < (piece, *name)
                {
                    joins.push((other, (piece, *name)));
                }
            }
        }
        joins
    }

    /// Pose of a port in the world, x out of its fitting; `None` if there is no such port.
    pub fn world_from_port(&self, (piece, port): PortRef) -> Option<Transform> {
        Some(self.world_from_fitting.get(piece)? * self.fittings[piece].port(port)?.entry_from_port)
    }

    /// Puts a solid, given in the world frame, into every cell that it reaches into.
    pub fn add_solid(&mut self, solid: &Solid) {
        for cell in self.cells.iter_mut().filter(|cell| cell.is_reached_by(solid)) {
            cell.solids.push(solid.clone());
        }
    }

    /// The cell that holds a point, looked for from `near` through portals; `None` outside the network. All cells are gone
    /// through only for a point that is outside, or not a few cells away from `near`.
    pub fn cell_at(&self, point: &Point3<f64>, near: CellId) -> Option<CellId> {
        /// Cells after which going through all of them costs less than walking on.
        const WALK_CELLS: usize = 16;
        const TOLERANCE_M: f64 = 1e-9;
        let holds = |id: &CellId| self.cells.get(*id).is_some_and(|cell| cell.contains(point, TOLERANCE_M));
        let mut at = near;
        for _ in 0..WALK_CELLS {
            if holds(&at) {
                return Some(at);
            }
            let faces = &self.cells.get(at)?.faces;
            if let Some(id) = faces.iter().flat_map(beyond).find(holds) {
                return Some(id);
            }
            // On through the face that has the point farthest on its other side.
            let ahead = faces
                .iter()
                .filter_map(|face| Some((face.plane.distance(point), beyond(face).next()?)))
                .filter(|(distance_m, _)| *distance_m > TOLERANCE_M)
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, next)) = ahead else { break };
            at = next;
        }
        (0..self.cells.len()).find(holds)
    }

    /// What a ray from a point inside `cell` meets, walls and solids; `None` when it leaves the network or goes further than
    /// `max_m`.
    pub fn cast(&self, cell: CellId, origin: &Point3<f64>, direction: &Unit<Vector3<f64>>, max_m: f64) -> Option<Hit> {
        let mut id = cell;
        // A ray crosses each cell at most once; the bound guards against a malformed network.
        for _ in 0..=self.cells.len() {
            let cell = &self.cells[id];
            let (leave_m, face) = cell
                .faces
                .iter()
                .filter_map(|face| {
                    let approach = face.plane.normal.dot(direction);
                    (approach > 1e-15).then(|| (-face.plane.distance(origin) / approach, face))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0))?;
            let hit = |distance_m: f64, normal, surface| {
                (distance_m <= max_m).then(|| Hit {
                    point: origin + direction.into_inner() * distance_m,
                    distance_m,
                    normal,
                    surface,
                    cell: id,
                })
            };
            let nearest = cell
                .solids
                .iter()
                .filter_map(|solid| enter(solid, origin, direction).map(|(t, plane)| (t, plane, solid.surface)))
                .filter(|(t, ..)| *t <= leave_m)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((distance_m, plane, surface)) = nearest {
                return hit(distance_m, plane.normal, surface);
            }
            let exit_point = origin + direction.into_inner() * leave_m;
            match face.portals.iter().find(|portal| portal.contains(&exit_point)).map(|p| p.beyond) {
                None => return hit(leave_m, -face.plane.normal, face.surface),
                Some(Beyond::Outside) => return None,
                Some(Beyond::Cell(_)) if leave_m > max_m => return None,
                Some(Beyond::Cell(next)) => id = next,
            }
        }
        None
    }
}

/// The cells behind a face's portals.
fn beyond(face: &Face) -> impl Iterator<Item = CellId> {
    face.portals.iter().filter_map(|portal| match portal.beyond {
        Beyond::Cell(id) => Some(id),
        Beyond::Outside => None,
    })
}

/// Where a ray enters a solid from outside, and through which plane.
fn enter<'s>(solid: &'s Solid, origin: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> Option<(f64, &'s Plane)> {
    let (mut enter_m, mut leave_m, mut through) = (0.0, f64::INFINITY, None);
    for plane in &solid.planes {
        let approach = plane.normal.dot(direction);
        let distance = plane.distance(origin);
        if approach.abs() < 1e-15 {
            if distance > 0.0 {
                return None;
            }
        } else if approach < 0.0 {
            let t = -distance / approach;
            if t > enter_m {
                (enter_m, through) = (t, Some(plane));
            }
        } else {
            leave_m = f64::min(leave_m, -distance / approach);
        }
    }
    through.filter(|_| enter_m < leave_m).map(|plane| (enter_m, plane))
}
