//! The floors of a network: which planes they lie in, and where.
//!
//! Floors that lie in one plane share it, so that a level network has one. Where there are more, what a wheel stands on is found
//! from the pieces of floor near it: a plane goes on beyond its own floors, through the air over a crest and over a hole.

use ductloop_duct::box_tree::Bounds;
use ductloop_duct::cell::{Beyond, Cell, CellId, FaceKind, Plane};
use ductloop_duct::network::Network;
use nalgebra::{Point3, Unit, Vector3};

use crate::opening::closed_parts;
use crate::walls::Sheet;

/// Planes and points nearer than this are the same: rounding of a long chain of transforms, and far below what a wheel could feel.
const SAME_M: f64 = 1e-6;
/// How far floors go on for wheels before an open end, in metres: a robot that leaves the network does not tip over its rim.
const BEFORE_END_M: f64 = 100.0;
/// How far above a floor a wheel is before its contact is of no account: more than the engine looks ahead.
const AHEAD_M: f64 = 5e-3;

/// A convex piece of floor.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorPart {
    /// Index of its plane.
    pub plane: usize,
    /// Its own plane, normal down, and outline.
    pub sheet: Sheet,
}

/// All floors of a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Floors {
    /// The planes that they lie in, normals down, out of the ducts.
    pub planes: Vec<Plane>,
    /// Their pieces, cell by cell.
    of_cell: Vec<Vec<FloorPart>>,
    /// Pieces that carry a wheel on before open ends, cell by cell.
    before_ends: Vec<Vec<FloorPart>>,
    /// Whether a floor has an opening.
    holed: bool,
}

/// The floors near a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Near {
    /// Their pieces.
    parts: Vec<FloorPart>,
    /// Their planes, ascending.
    pub planes: Vec<usize>,
}

/// How a wheel meets one of the planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touch {
    /// Not at all: there is no floor of that plane.
    Away,
    /// As it would if the plane had no end.
    Face,
    /// Over an edge: a crest or the rim of a hole.
    Edge {
        /// The point of the edge that is nearest to the wheel's centre.
        at: Point3<f64>,
        /// From there to the centre.
        normal: Unit<Vector3<f64>>,
    },
}

/// A wheel over the floors.
#[derive(Clone, Copy, Debug)]
pub struct Wheel {
    /// Its centre.
    pub centre: Point3<f64>,
    /// Direction of its axle.
    pub axle: Vector3<f64>,
    /// Its radius.
    pub radius_m: f64,
    /// Its width.
    pub width_m: f64,
}

impl Floors {
    /// Finds the floors of a network and their planes, in the order of the cells.
    pub fn new(network: &Network) -> Self {
        let mut planes: Vec<Plane> = Vec::new();
        let mut holed = false;
        let mut plane_of = |sheet: &Sheet| {
            let same = |plane: &Plane| {
                sheet.plane.normal.dot(&plane.normal) > 0.0 && sheet.outline.iter().all(|p| plane.distance(p).abs() <= SAME_M)
            };
            // A neighbour's is the likeliest.
            planes.iter().rposition(same).unwrap_or_else(|| {
                planes.push(sheet.plane);
                planes.len() - 1
            })
        };
        let (mut of_cell, mut before_ends) = (Vec::new(), Vec::new());
        for cell in &network.cells {
            let (mut parts, mut ends) = (Vec::new(), Vec::new());
            for face in cell.faces.iter().filter(|face| face.kind == FaceKind::Floor) {
                holed |= !face.portals.is_empty();
                for outline in closed_parts(face) {
                    let sheet = Sheet { plane: face.plane, outline };
                    let plane = plane_of(&sheet);
                    ends.extend(before_open_ends(cell, &sheet).map(|sheet| FloorPart { plane, sheet }));
                    parts.push(FloorPart { plane, sheet });
                }
            }
            of_cell.push(parts);
            before_ends.push(ends);
        }
        Self { planes, of_cell, before_ends, holed }
    }

    /// Whether all floors are one plane without holes: then it counts everywhere.
    pub fn are_plain(&self) -> bool {
        self.planes.len() == 1 && !self.holed
    }

    /// The pieces of a cell's floors.
    pub fn of_cell(&self, cell: CellId) -> &[FloorPart] {
        &self.of_cell[cell]
    }

    /// Floors at most `reach_m` from a cell, by their boxes, through portals.
    pub fn near(&self, network: &Network, cell: CellId, reach_m: f64) -> Near {
        let mut around = network.cells[cell].bounds();
        around.low -= Vector3::repeat(reach_m);
        around.high += Vector3::repeat(reach_m);
        let cells = cells_within(network, cell, &around);
        let parts: Vec<FloorPart> =
            cells.iter().flat_map(|id| self.of_cell[*id].iter().chain(&self.before_ends[*id]).cloned()).collect();
        let mut planes: Vec<usize> = parts.iter().map(|part| part.plane).collect();
        planes.sort_unstable();
        planes.dedup();
        Near { parts, planes }
    }

    /// How a wheel meets one of the planes near it.
    ///
    /// Over a piece of floor it meets the plane. Beside all of them it meets the nearest edge, if nothing is behind that edge or the
    /// floor falls away there; where it rises, the rising floor's plane holds the wheel off.
    pub fn touch(&self, near: &Near, plane: usize, wheel: &Wheel) -> Touch {
        let above_m = -self.planes[plane].distance(&wheel.centre);
        if !(0.0..wheel.radius_m + AHEAD_M).contains(&above_m) {
            return Touch::Away;
        }
        let Some((at, off_m)) = near.nearest(plane, &self.foot(plane, &wheel.centre)) else { return Touch::Away };
        if off_m < SAME_M {
            return Touch::Face;
        }
        let (normal, far_m) = Unit::new_and_get(wheel.centre - at);
        // The ball under a wheel is wider than the wheel.
        if far_m > wheel.radius_m + AHEAD_M || (at - wheel.centre).dot(&wheel.axle).abs() > wheel.width_m / 2.0 {
            return Touch::Away;
        }
        for other in near.parts.iter().filter(|part| part.plane != plane && part.sheet.touches(&at)) {
            let rises = other.sheet.outline.iter().any(|corner| self.planes[plane].distance(corner) < -SAME_M);
            let beyond = || near.nearest(other.plane, &self.foot(other.plane, &wheel.centre));
            // The edge of two planes counts once.
            if rises || other.plane < plane || beyond().is_some_and(|(_, off_m)| off_m < SAME_M) {
                return Touch::Away;
            }
        }
        Touch::Edge { at, normal }
    }

    /// The foot of a point on a plane.
    fn foot(&self, plane: usize, point: &Point3<f64>) -> Point3<f64> {
        let plane = &self.planes[plane];
        point - plane.normal.into_inner() * plane.distance(point)
    }
}

impl FloorPart {
    /// Whether a point lies in its plane.
    pub fn is_level_with(&self, point: &Point3<f64>) -> bool {
        self.sheet.plane.distance(point).abs() < SAME_M
    }
}

impl Near {
    /// The nearest point of this plane's floors to a point of the plane, and its distance; `None` if none is near.
    fn nearest(&self, plane: usize, point: &Point3<f64>) -> Option<(Point3<f64>, f64)> {
        let parts = self.parts.iter().filter(|part| part.plane == plane);
        parts.map(|part| part.sheet.nearest(point)).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl Sheet {
    /// The nearest point of the sheet to a point of its plane, and its distance.
    fn nearest(&self, point: &Point3<f64>) -> (Point3<f64>, f64) {
        if self.covers(point) {
            return (*point, 0.0);
        }
        let n = self.outline.len();
        let on_edges = (0..n).map(|i| {
            let (a, way) = (self.outline[i], self.outline[(i + 1) % n] - self.outline[i]);
            let at = a + way * ((point - a).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            (at, (point - at).norm())
        });
        on_edges.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((*point, f64::INFINITY))
    }
}

/// What goes on beyond those edges of a piece of floor that are at an open end.
fn before_open_ends<'a>(cell: &'a Cell, floor: &'a Sheet) -> impl Iterator<Item = Sheet> + 'a {
    let n = floor.outline.len();
    let open = cell.faces.iter().flat_map(|face| face.portals.iter().map(move |portal| (face, portal)));
    let open: Vec<_> = open.filter(|(face, portal)| face.kind == FaceKind::Wall && portal.beyond == Beyond::Outside).collect();
    (0..n).filter_map(move |i| {
        let (a, b) = (floor.outline[i], floor.outline[(i + 1) % n]);
        let at_end = open.iter().any(|(face, portal)| {
            [a, b]
                .iter()
                .all(|p| face.plane.distance(p).abs() < SAME_M && portal.edges.iter().all(|edge| edge.distance(p) < SAME_M))
        });
        let on = (b - a).cross(&floor.plane.normal).normalize() * BEFORE_END_M;
        at_end.then(|| Sheet { plane: floor.plane, outline: vec![a, a + on, b + on, b] })
    })
}

/// Cells whose boxes meet this box, from one of them through portals.
fn cells_within(network: &Network, cell: CellId, around: &Bounds) -> Vec<CellId> {
    let beyond = |cell: &Cell| -> Vec<CellId> {
        let portals = cell.faces.iter().flat_map(|face| &face.portals);
        portals
            .filter_map(|portal| match portal.beyond {
                Beyond::Cell(id) => Some(id),
                Beyond::Outside => None,
            })
            .collect()
    };
    let mut within = vec![cell];
    let mut next = 0;
    while let Some(&id) = within.get(next) {
        next += 1;
        for id in beyond(&network.cells[id]) {
            if !within.contains(&id) && network.cells[id].bounds().meets(around) {
                within.push(id);
            }
        }
    }
    within
}
