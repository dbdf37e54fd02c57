//! Keeps the robot from tripping over the seams between slabs.
//!
//! A part that leans on a wall is a few micrometres in it. Sliding on, it meets the *end* of the next slab there, and the
//! engine stops it dead although the wall goes on smoothly (a ghost collision: without this module, a robot sliding along a
//! wall of 0.3 m pieces is thrown off it seam after seam). So each contact's normal is held against the wall's shape: away from
//! the sheet's own normal it may tilt only over an edge where the duct's wall really turns away, and only as far as it turns.

use std::f64::consts::FRAC_PI_2;

use ductloop_duct::cell::{Beyond, CellId, Plane};
use ductloop_duct::network::Network;
use nalgebra::{Point3, Vector3};
use rapier3d::math::Vector;
use rapier3d::prelude::{ContactModificationContext, ModifiableContacts, PhysicsHooks};

use crate::convert;
use crate::walls::{Obstacle, Sheet, Walls};

/// Edges nearer than this are the same: the rounding of a long chain of transforms.
const SAME_M: f64 = 1e-6;
/// Play of a normal that is legitimate: 5 degrees. A ghost's is off by tens of degrees.
const PLAY_RAD: f64 = 0.087;

/// What a contact's normal may be on one slab.
#[derive(Clone, Debug, PartialEq)]
struct Limits {
    /// Normal of the sheet, into the duct.
    inward: Vector,
    edges: Vec<EdgeLimit>,
}

/// How far a normal may tilt over an edge.
#[derive(Clone, Debug, PartialEq)]
struct EdgeLimit {
    /// Within the sheet, square to the edge, away from the sheet.
    outward: Vector,
    /// Sine and cosine of the largest tilt.
    sin_cos: (f64, f64),
}

/// The hook that drops ghost contacts. A wall's collider carries in its user data its place here plus one; zero is no wall.
#[derive(Clone, Debug, Default)]
pub struct SeamFilter {
    limits: Vec<Limits>,
}

impl SeamFilter {
    /// Finds how the sheets of all cells meet. Limits are in the order of the walls, cell by cell, and then of the floors' slabs.
    pub fn new(network: &Network, walls: &Walls) -> Self {
        let sheets_of = |obstacles: &[Vec<Obstacle>]| -> Vec<Vec<Sheet>> {
            obstacles.iter().map(|cell| cell.iter().filter_map(|obstacle| obstacle.sheet.clone()).collect()).collect()
        };
        let (walls_of, floors_of) = (sheets_of(&walls.of_cell), sheets_of(&walls.floor_slabs));
        let mut limits = Vec::new();
        for (cell, sheets) in walls_of.iter().enumerate() {
            limits.extend(sheets.iter().enumerate().map(|(index, sheet)| {
                Limits::new(sheet, |middle| {
                    // The turn over the edge; `None` until something adjoins there. A wall that stands on a floor turns nowhere.
                    let around = cells_around(network, cell, middle);
                    let on_floor =
                        around.iter().flat_map(|at| walls.floors.of_cell(*at)).any(|floor| floor.is_level_with(middle));
                    let adjoining = around.iter().flat_map(|at| {
                        let others = walls_of[*at].iter().enumerate();
                        others.filter(move |(other, _)| (*at, *other) != (cell, index)).map(|(_, other)| other)
                    });
                    adjoining.fold(on_floor.then_some(0.0), |turn, other| turn_over(sheet, middle, other, turn))
                })
            }));
        }
        for (cell, sheets) in floors_of.iter().enumerate() {
            limits.extend(sheets.iter().map(|sheet| {
                Limits::new(sheet, |middle| {
                    let around = cells_around(network, cell, middle);
                    let adjoining = around.iter().flat_map(|at| walls_of[*at].iter().chain(&floors_of[*at]));
                    adjoining.filter(|other| *other != sheet).fold(None, |turn, other| turn_over(sheet, middle, other, turn))
                })
            }));
        }
        Self { limits }
    }
}

impl Limits {
    /// Limits of a sheet; `turn` says by how much the wall turns away over an edge with this middle, `None` if nothing adjoins.
    fn new(sheet: &Sheet, turn: impl Fn(&Point3<f64>) -> Option<f64>) -> Self {
        let edge = |edge| EdgeLimit {
            outward: convert::vector(&sheet.edge_outward(edge)),
            // A free edge, at an open end, is a corner.
            sin_cos: libm::sincos(turn(&sheet.edge_middle(edge)).unwrap_or(FRAC_PI_2) + PLAY_RAD),
        };
        Self { inward: -convert::vector(&sheet.plane.normal), edges: (0..sheet.outline.len()).map(edge).collect() }
    }

    /// Whether a contact can push along `normal`, a unit vector away from the slab.
    fn allow(&self, normal: Vector) -> bool {
        let up = normal.dot(self.inward);
        // sin(tilt - largest tilt) <= 0
        self.edges.iter().all(|edge| normal.dot(edge.outward) * edge.sin_cos.1 <= up * edge.sin_cos.0)
    }
}

/// The greater of `turn` and the turn over the edge with this middle where `neighbour` adjoins it.
fn turn_over(sheet: &Sheet, middle: &Point3<f64>, neighbour: &Sheet, turn: Option<f64>) -> Option<f64> {
    if neighbour.touches(middle) { Some(turn.unwrap_or(0.0).max(turn_rad(&sheet.plane, neighbour))) } else { turn }
}

/// By how much the wall turns away behind a sheet where `neighbour` adjoins it: zero where it goes on flat or turns inward.
fn turn_rad(plane: &Plane, neighbour: &Sheet) -> f64 {
    let behind = neighbour.outline.iter().any(|corner| plane.distance(corner) > SAME_M);
    if behind { libm::acos(plane.normal.dot(&neighbour.plane.normal).clamp(-1.0, 1.0)) } else { 0.0 }
}

/// The cells that a point of a cell's boundary belongs to, through portals.
fn cells_around(network: &Network, cell: CellId, point: &Point3<f64>) -> Vec<CellId> {
    let mut around = vec![cell];
    let mut next = 0;
    while let Some(&id) = around.get(next) {
        next += 1;
        for portal in network.cells[id].faces.iter().flat_map(|face| &face.portals) {
            if let Beyond::Cell(beyond) = portal.beyond
                && !around.contains(&beyond)
                && network.cells[beyond].contains(point, SAME_M)
            {
                around.push(beyond);
            }
        }
    }
    around
}

impl Sheet {
    fn edge(&self, edge: usize) -> [Point3<f64>; 2] {
        [self.outline[edge], self.outline[(edge + 1) % self.outline.len()]]
    }

    fn edge_middle(&self, edge: usize) -> Point3<f64> {
        let [a, b] = self.edge(edge);
        nalgebra::center(&a, &b)
    }

    /// Within the plane, away from the sheet; the outline is anticlockwise about the plane's normal.
    fn edge_outward(&self, edge: usize) -> Vector3<f64> {
        let [a, b] = self.edge(edge);
        (b - a).cross(&self.plane.normal).normalize()
    }

    /// Whether a point lies on the sheet or its rim.
    pub(crate) fn touches(&self, point: &Point3<f64>) -> bool {
        self.plane.distance(point).abs() < SAME_M
            && (0..self.outline.len()).all(|edge| self.edge_outward(edge).dot(&(point - self.outline[edge])) < SAME_M)
    }
}

impl PhysicsHooks for SeamFilter {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let ModifiableContacts::Rigid(contacts) = &mut context.contacts else { return };
        // Normals point from the first collider to the second.
        for (collider, away) in [(context.collider1, 1.0), (context.collider2, -1.0)] {
            let limits = (context.colliders[collider].user_data as usize).checked_sub(1).and_then(|at| self.limits.get(at));
            if limits.is_some_and(|limits| !limits.allow(*contacts.normal * away)) {
                contacts.solver_contacts.clear();
            }
        }
    }
}
