//! The duct's sheet metal as the robot meets it: the floors' planes, and a convex slab behind every other closed piece of face.
//!
//! Wheels meet planes, as seams between pieces of floor would trip them. Where the floors are not one plane, chassis and mast meet
//! slabs behind the floors, as they would hang on a plane that goes on beyond its floor.
//!
//! A slab's inner side is the piece of face itself; its outer side stands [`THICKNESS_M`] further out and is drawn in, so that
//! the slabs of two walls that meet in an inner corner as sharp as 60 degrees (a mitre of 120 degrees) stay out of each
//! other's duct. Where there is no room behind a wall (two ducts share one sheet), the slab is made thinner, and where even
//! [`THINNEST_M`] reaches into another cell the network is refused: the robot would bump into a wall that is not there.

use ductloop_duct::box_tree::{Bounds, BoxTree};
use ductloop_duct::cell::{Cell, CellId, FaceKind, Plane, Solid};
use ductloop_duct::network::Network;
use nalgebra::{Point3, Vector3};
use rapier3d::geometry::SharedShape;
use rapier3d::math::Vector;

use crate::convert;
use crate::floors::Floors;
use crate::opening::closed_parts;

/// Thickness of a slab where there is room: ten ticks of travel at 1.2 m/s, so nothing passes through it.
pub const THICKNESS_M: f64 = 10e-3;
/// Thinnest slab: two ticks of travel, still deeper than any penetration.
pub const THINNEST_M: f64 = 2.5e-3;
/// How far a slab may reach into a cell: the overlap that a network itself allows.
const OVERLAP_M: f64 = 1e-3;
/// 1 / tan(30 degrees), half the sharpest inner corner.
const DRAWN_IN: f64 = 1.75;

/// Something that the robot can bump into, in world coordinates.
#[derive(Clone)]
pub struct Obstacle {
    /// Convex shape, its points in the world frame.
    pub shape: SharedShape,
    /// The inner side, if it is a piece of a face.
    pub sheet: Option<Sheet>,
    /// Middle of its corners.
    pub centre: Point3<f64>,
    /// Distance of its farthest corner from the middle.
    pub radius_m: f64,
}

/// A closed piece of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Its plane, normal out of the cell.
    pub plane: Plane,
    /// Its convex outline.
    pub outline: Vec<Point3<f64>>,
}

/// Everything of a network that a robot can touch.
#[derive(Clone)]
pub struct Walls {
    /// The floors.
    pub floors: Floors,
    /// Walls, ceilings and solids of each cell.
    pub of_cell: Vec<Vec<Obstacle>>,
    /// What the chassis meets of the floors of each cell, where they are not one plane.
    pub floor_slabs: Vec<Vec<Obstacle>>,
}

/// Why a network cannot be driven in.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WallError {
    /// A wall's slab would stand in another duct.
    #[error("there is no room behind a wall of fitting {fitting}: less than {} mm to the inside of fitting {other}", THINNEST_M * 1e3)]
    NoRoom {
        /// The wall's fitting, from 0.
        fitting: usize,
        /// The fitting that it would reach into.
        other: usize,
    },
    /// A face or solid has no volume to collide with.
    #[error("a face or solid of fitting {fitting} is degenerate")]
    Degenerate {
        /// The fitting, from 0.
        fitting: usize,
    },
}

impl Walls {
    /// Makes the floors and the obstacles of a network.
    ///
    /// # Errors
    /// What about the network cannot be driven in.
    pub fn new(network: &Network) -> Result<Self, WallError> {
        let floors = Floors::new(network);
        // A network without any floor has no cells either.
        if floors.planes.is_empty() {
            return Err(WallError::Degenerate { fitting: 0 });
        }
        let boxes: Vec<Bounds> = network.cells.iter().map(Cell::bounds).collect();
        let tree = BoxTree::new(&boxes);
        let of_cell = network
            .cells
            .iter()
            .enumerate()
            .map(|(id, cell)| {
                let mut obstacles = Vec::new();
                for face in cell.faces.iter().filter(|face| face.kind != FaceKind::Floor) {
                    for outline in closed_parts(face) {
                        obstacles.push(slab(network, &tree, id, Sheet { plane: face.plane, outline })?);
                    }
                }
                for solid in &cell.solids {
                    obstacles.push(solid_obstacle(solid).ok_or(WallError::Degenerate { fitting: cell.fitting })?);
                }
                Ok(obstacles)
            })
            .collect::<Result<_, _>>()?;
        let slabs = |id: CellId| floors.of_cell(id).iter().map(|part| slab(network, &tree, id, part.sheet.clone())).collect();
        let floor_slabs = if floors.are_plain() {
            vec![Vec::new(); network.cells.len()]
        } else {
            (0..network.cells.len()).map(slabs).collect::<Result<_, _>>()?
        };
        Ok(Self { floors, of_cell, floor_slabs })
    }
}

fn slab(network: &Network, tree: &BoxTree, cell: usize, sheet: Sheet) -> Result<Obstacle, WallError> {
    let fitting = network.cells[cell].fitting;
    let mut thickness_m = THICKNESS_M;
    loop {
        let corners = slab_corners(&sheet, thickness_m);
        let reached = tree.first(0, &Bounds::around(&corners), |id| {
            // Apart, if a face of the other cell has the slab outside or the sheet has that cell inside.
            let faces = &network.cells[id].faces;
            let beyond_face = || faces.iter().any(|face| corners.iter().all(|corner| face.plane.distance(corner) >= -OVERLAP_M));
            let behind = |corner| sheet.plane.distance(corner) <= OVERLAP_M;
            id != cell && !beyond_face() && !faces.iter().flat_map(|face| &face.outline).all(behind)
        });
        match reached {
            None => {
                let shape = slab_shape(&corners).ok_or(WallError::Degenerate { fitting })?;
                return Ok(obstacle(shape, &corners, Some(sheet)));
            }
            Some(id) if thickness_m <= THINNEST_M => {
                return Err(WallError::NoRoom { fitting, other: network.cells[id].fitting });
            }
            Some(_) => thickness_m /= 2.0,
        }
    }
}

fn slab_corners(sheet: &Sheet, thickness_m: f64) -> Vec<Point3<f64>> {
    let Sheet { plane, outline } = sheet;
    let n = outline.len();
    let middle = centre(outline);
    // Unit normals within the face, inward, of the edge from corner i to i + 1.
    let inward: Vec<Vector3<f64>> =
        (0..n).map(|i| plane.normal.cross(&(outline[(i + 1) % n] - outline[i])).normalize()).collect();
    let inradius = (0..n).map(|i| inward[i].dot(&(middle - outline[i]))).fold(f64::INFINITY, f64::min);
    // Drawn in by less than half the inradius, so that no edge is drawn in beyond the middle.
    let drawn_in_m = (DRAWN_IN * thickness_m).min(0.45 * inradius);
    let outer = (0..n).map(|i| {
        let (a, b) = (inward[(i + n - 1) % n], inward[i]);
        outline[i] + (a + b) * (drawn_in_m / (1.0 + a.dot(&b))) + plane.normal.into_inner() * thickness_m
    });
    outline.iter().copied().chain(outer).collect()
}

/// The slab with these corners, inner side first. Its triangles are known, so that it does not depend on the tolerances of a
/// search for the hull, which fails for a slab of 1000 m. `None` if it has no volume.
fn slab_shape(corners: &[Point3<f64>]) -> Option<SharedShape> {
    let n = corners.len() as u32 / 2;
    let mut triangles = Vec::with_capacity(4 * n as usize - 4);
    for i in 1..n - 1 {
        triangles.push([0, i + 1, i]);
        triangles.push([n, n + i, n + i + 1]);
    }
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.push([i, next, n + next]);
        triangles.push([i, n + next, n + i]);
    }
    SharedShape::convex_mesh(corners.iter().map(convert::point).collect(), &triangles)
}

/// A solid. `None` if its corners span no volume.
pub(crate) fn solid_obstacle(solid: &Solid) -> Option<Obstacle> {
    let corners: Vec<Vector> = solid.corners.iter().map(convert::point).collect();
    Some(obstacle(SharedShape::convex_hull(&corners)?, &solid.corners, None))
}

fn obstacle(shape: SharedShape, corners: &[Point3<f64>], sheet: Option<Sheet>) -> Obstacle {
    let centre = centre(corners);
    let radius_m = corners.iter().map(|c| (c - centre).norm()).fold(0.0, f64::max);
    Obstacle { shape, sheet, centre, radius_m }
}

fn centre(points: &[Point3<f64>]) -> Point3<f64> {
    let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    (sum / points.len() as f64).into()
}

impl Sheet {
    /// Whether a point's foot on the plane lies within the outline.
    pub fn covers(&self, point: &Point3<f64>) -> bool {
        let n = self.outline.len();
        (0..n).all(|i| {
            let (a, b) = (self.outline[i], self.outline[(i + 1) % n]);
            self.plane.normal.cross(&(b - a)).dot(&(point - a)) >= 0.0
        })
    }
}
