//! Fittings joined port to port: which cell holds a point, and what a ray meets.

use nalgebra::{Point3, Unit, Vector3};

use crate::Transform;
use crate::box_tree::{Bounds, BoxTree};
use crate::cell::{Beyond, Cell, CellId, Face, Plane, Side, Solid, SurfaceId};
use crate::centreline::{Centreline, Segment};
use crate::fitting::{Fitting, FittingError};

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
    /// Its cells.
    pub cells: Vec<Cell>,
    /// Its fittings, in order along the reference path.
    pub fittings: Vec<Fitting>,
    /// The reference path.
    pub centreline: Centreline,
}

/// Why a network cannot be assembled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// There is nothing to assemble.
    #[error("the duct has no fittings")]
    Empty,
    /// A fitting is impossible.
    #[error("fitting {index}: {error}")]
    Fitting {
        /// Its place in the run, from 0.
        index: usize,
        /// What is wrong with it.
        #[source]
        error: FittingError,
    },
    /// Two fittings that are not neighbours occupy the same space.
    #[error("fittings {first} and {second} overlap")]
    Overlap {
        /// The earlier of the two, from 0.
        first: usize,
        /// The later.
        second: usize,
    },
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
    /// Joins fittings one after the other, the first one's entry at the world's origin.
    ///
    /// # Errors
    /// If there is none, one is impossible, or two overlap.
    pub fn from_run(fittings: &[Fitting], entry: End, exit: End) -> Result<Self, NetworkError> {
        if fittings.is_empty() {
            return Err(NetworkError::Empty);
        }
        let end = |end| match end {
            End::Open => Side::Portal(Beyond::Outside),
            End::Cap => Side::Wall,
        };
        let mut network = Self { cells: Vec::new(), fittings: fittings.to_vec(), centreline: Centreline::default() };
        let mut world_from_entry = Transform::identity();
        let mut start_m = 0.0;
        for (index, fitting) in fittings.iter().enumerate() {
            fitting.validate().map_err(|error| NetworkError::Fitting { index, error })?;
            let first = network.cells.len();
            let count = fitting.cells(first, index, Side::Wall, Side::Wall).len();
            let before = if index == 0 { end(entry) } else { Side::Portal(Beyond::Cell(first - 1)) };
            let after = if index + 1 == fittings.len() { end(exit) } else { Side::Portal(Beyond::Cell(first + count)) };
            let cells = fitting.cells(first, index, before, after);
            network.cells.extend(cells.iter().map(|cell| cell.transformed(&world_from_entry)));
            network.centreline.segments.push(Segment {
                world_from_start: world_from_entry,
                length_m: fitting.length_m(),
                curvature_1_m: fitting.curvature_1_m(),
                width_m: fitting.width_m,
                height_m: fitting.height_m,
                start_m,
            });
            start_m += fitting.length_m();
            world_from_entry *= fitting.entry_from_exit();
        }
        match network.overlap() {
            Some((first, second)) => Err(NetworkError::Overlap { first, second }),
            None => Ok(network),
        }
    }

    /// The first pair of fittings whose insides intersect by more than a millimetre.
    ///
    /// Cells are prisms on one floor, so two are apart exactly when a wall's plane of one of them has the other wholly on its
    /// outside (separating axes in the plan). Cells whose boxes do not meet need no look at their planes.
    fn overlap(&self) -> Option<(usize, usize)> {
        const TOLERANCE_M: f64 = 1e-3;
        let apart = |a: &Cell, b: &Cell| {
            a.faces
                .iter()
                .any(|face| b.faces.iter().flat_map(|f| &f.outline).all(|corner| face.plane.distance(corner) >= -TOLERANCE_M))
        };
        let bounds: Vec<Bounds> = self.cells.iter().map(Cell::bounds).collect();
        let tree = BoxTree::new(&bounds);
        self.cells.iter().zip(&bounds).enumerate().find_map(|(i, (a, bounds))| {
            let bites = |j: usize| {
                let b = &self.cells[j];
                a.fitting != b.fitting && !apart(a, b) && !apart(b, a)
            };
            tree.first(i + 1, bounds, bites).map(|j| (a.fitting, self.cells[j].fitting))
        })
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
