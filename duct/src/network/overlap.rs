//! Whether pieces of a network occupy the same space.

use nalgebra::{Point3, Vector3};

use crate::box_tree::{Bounds, BoxTree};
use crate::cell::Cell;

/// How far two pieces may reach into each other, in metres: rounding, and less than sheet metal is thick.
const TOLERANCE_M: f64 = 1e-3;

/// A network's cells, prepared for the search. Cells whose boxes do not meet need no look at their shapes.
pub(super) struct Overlaps<'c> {
    cells: &'c [Cell],
    bounds: Vec<Bounds>,
    tree: BoxTree,
}

impl<'c> Overlaps<'c> {
    pub(super) fn new(cells: &'c [Cell]) -> Self {
        let bounds: Vec<Bounds> = cells.iter().map(Cell::bounds).collect();
        let tree = BoxTree::new(&bounds);
        Self { cells, bounds, tree }
    }

    /// The first pair of fittings whose insides intersect by more than a millimetre.
    pub(super) fn first(&self) -> Option<(usize, usize)> {
        self.cells.iter().zip(&self.bounds).enumerate().find_map(|(i, (a, bounds))| {
            let bites = |j: usize| a.fitting != self.cells[j].fitting && bite(a, &self.cells[j]);
            self.tree.first(i + 1, bounds, bites).map(|j| (a.fitting, self.cells[j].fitting))
        })
    }
}

/// Whether two convex cells intersect by more than the tolerance, whichever way one would push them apart. Convex bodies are apart
/// exactly when a plane parallel to a face of one of them, or to an edge of each, lies between them (separating axes).
fn bite(a: &Cell, b: &Cell) -> bool {
    let beyond_a_face =
        |a: &Cell, b: &Cell| a.faces.iter().any(|face| corners(b).all(|corner| face.plane.distance(corner) >= -TOLERANCE_M));
    if beyond_a_face(a, b) || beyond_a_face(b, a) {
        return false;
    }
    // Above level plans, with upright sides, an edge of each gives nothing that faces do not.
    if is_level(a) && is_level(b) {
        return true;
    }
    let edges = |cell: &Cell| -> Vec<Vector3<f64>> {
        let outlines = cell.faces.iter().map(|face| &face.outline);
        outlines.flat_map(|outline| (0..outline.len()).map(move |i| outline[(i + 1) % outline.len()] - outline[i])).collect()
    };
    let (edges_a, edges_b) = (edges(a), edges(b));
    !edges_a.iter().flat_map(|ea| edges_b.iter().map(move |eb| ea.cross(eb))).any(|axis| {
        let length = axis.norm();
        // Parallel edges span no plane.
        length > 1e-9 && {
            let axis = axis / length;
            let ([low_a, high_a], [low_b, high_b]) = (extent(a, &axis), extent(b, &axis));
            low_b - high_a >= -TOLERANCE_M || low_a - high_b >= -TOLERANCE_M
        }
    })
}

fn corners(cell: &Cell) -> impl Iterator<Item = &Point3<f64>> {
    cell.faces.iter().flat_map(|face| &face.outline)
}

fn extent(cell: &Cell, axis: &Vector3<f64>) -> [f64; 2] {
    corners(cell)
        .map(|corner| axis.dot(&corner.coords))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// Whether floor and ceiling, the first two faces, are level.
fn is_level(cell: &Cell) -> bool {
    cell.faces[..2].iter().all(|face| face.plane.normal.z.abs() == 1.0)
}
