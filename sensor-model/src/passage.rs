//! Which way light goes from cell to cell near the camera, and what the openings on it hide.
//!
//! The cells within reach form a tree, grown from the camera's cell through openings; light between two cells takes the tree's
//! way. In a network with loops that is one of the shortest ways, and light along others is left out.
//!
//! Whether the straight way from a point x to a point p passes an edge AB of an opening on its inner side is the sign of the volume
//! of the tetrahedron x, A, B, p. The volume is linear in each of its corners, so that for a whole polygon of points x and a whole
//! polygon of points p its sign at the corners decides.

use std::ops::Range;

use ductloop_duct::cell::CellId;
use nalgebra::{Point3, Vector3};

use crate::Transform;
use crate::scenery::Scenery;

/// Smaller volumes than this are rounding, in cubic metres.
const ROUNDING_M3: f64 = 1e-12;

/// An edge of an opening, in the camera's frame, in the order in which [`volume`] is positive for light that comes to x inside it.
pub(crate) type Rim = [Vector3<f64>; 2];

/// The cells near the camera. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Passages {
    places: Vec<Place>,
    rims: Vec<Rim>,
}

/// A cell of the tree.
#[derive(Debug)]
struct Place {
    cell: CellId,
    parent: usize,
    depth: usize,
    /// Edges of the opening from the parent, for light on its way out of the parent.
    rims: Range<usize>,
}

/// What of one polygon is seen from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// All of it from everywhere.
    Clear,
    /// Some of it from somewhere: the rims that hide something have been noted.
    Partial,
    /// Nothing from anywhere.
    Blocked,
}

/// Six times the volume of the tetrahedron of a point x, a rim and `to`, as (constant, slope): `constant + slope . x`. It is
/// `(A - x) x (B - x) . (to - x)`, in which all products of x with itself cancel.
pub(crate) fn volume([a, b]: &Rim, to: &Vector3<f64>) -> (f64, Vector3<f64>) {
    (a.cross(b).dot(to), -(a.cross(b) + b.cross(to) + to.cross(a)))
}

impl Passages {
    /// Grows the tree from the camera's cell, through openings whose middle is at most `range_m` from the camera.
    pub(crate) fn explore(&mut self, scenery: &Scenery, camera_from_world: &Transform, cell: CellId, range_m: f64) {
        self.places.clear();
        self.rims.clear();
        self.places.push(Place { cell, parent: 0, depth: 0, rims: 0..0 });
        let mut next = 0;
        while next < self.places.len() {
            let Place { cell, depth, .. } = self.places[next];
            for opening in &scenery.rooms[cell].openings {
                if self.places.iter().any(|place| place.cell == opening.beyond) {
                    continue;
                }
                let corner = |i: usize| (camera_from_world * opening.outline[i % opening.outline.len()]).coords;
                let corners = opening.outline.len();
                let middle: Vector3<f64> = (0..corners).map(corner).sum::<Vector3<f64>>() / corners as f64;
                if middle.norm() > range_m {
                    continue;
                }
                let first = self.rims.len();
                let outward = camera_from_world.rotation * opening.plane.normal.into_inner();
                self.rims.extend((0..corners).map(|i| {
                    let (a, b) = (corner(i), corner(i + 1));
                    if (b - a).cross(&(middle - a)).dot(&outward) > 0.0 { [a, b] } else { [b, a] }
                }));
                self.places.push(Place { cell: opening.beyond, parent: next, depth: depth + 1, rims: first..self.rims.len() });
            }
            next += 1;
        }
    }

    /// The cells of the tree.
    pub(crate) fn cells(&self) -> impl Iterator<Item = CellId> {
        self.places.iter().map(|place| place.cell)
    }

    /// Looks along the way from cell to cell, for light between any point of polygon `to` and any point of polygon `from`. Notes in
    /// `hiding` the rims that hide something, in the order in which volumes (`from`, rim, `to`) are positive where light passes.
    pub(crate) fn look(
        &self,
        (from_cell, from): (CellId, &[Point3<f64>]),
        (to_cell, to): (CellId, &[Point3<f64>]),
        hiding: &mut Vec<Rim>,
    ) -> Passage {
        hiding.clear();
        let place = |cell: CellId| self.places.iter().position(|place| place.cell == cell);
        let (Some(mut here), Some(mut there)) = (place(from_cell), place(to_cell)) else { return Passage::Blocked };
        while here != there {
            // Up from the deeper end.
            let backward = self.places[here].depth >= self.places[there].depth;
            let end = if backward { &mut here } else { &mut there };
            let Place { parent, rims, .. } = &self.places[*end];
            for [a, b] in &self.rims[rims.clone()] {
                let rim = if backward { [*b, *a] } else { [*a, *b] };
                let (mut hides, mut passes) = (false, false);
                for p in to {
                    let (constant, slope) = volume(&rim, &p.coords);
                    for x in from {
                        let volume = constant + slope.dot(&x.coords);
                        hides |= volume < -ROUNDING_M3;
                        passes |= volume > ROUNDING_M3;
                    }
                }
                if !passes {
                    return Passage::Blocked;
                }
                if hides {
                    hiding.push(rim);
                }
            }
            *end = *parent;
        }
        if hiding.is_empty() { Passage::Clear } else { Passage::Partial }
    }
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::SurfaceId;
    use ductloop_duct::fitting::{Fitting, Shape};
    use ductloop_duct::network::{End, Network};

    use super::*;
    use crate::surface::Look;

    /// Light between two points of a duct of three cells about a bend, against a ray cast through the network.
    #[test]
    fn a_way_is_clear_where_a_ray_finds_it_so() {
        let piece = |shape| Fitting { shape, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) };
        let mitre = piece(Shape::MitredElbow { angle_rad: 1.2 });
        let straight = piece(Shape::Straight { length_m: 1.0 });
        let network = Network::from_run(&[straight, mitre, straight], End::Open, End::Open).unwrap();
        let scenery = Scenery::new(&network, &[Look::matt(0.5)]).unwrap();
        let mut passages = Passages::default();
        passages.explore(&scenery, &Transform::identity(), 1, 10.0);
        assert_eq!(passages.cells().count(), 4);
        // Points of each cell by a lattice in its box.
        let inside = |cell: usize| {
            let corners: Vec<_> = network.cells[cell].faces.iter().flat_map(|face| face.outline.clone()).collect();
            let middle = corners.iter().map(|c| c.coords).sum::<Vector3<f64>>() / corners.len() as f64;
            corners.iter().map(|c| Point3::from(c.coords * 0.9 + middle * 0.1)).collect::<Vec<_>>()
        };
        let mut hiding = Vec::new();
        let mut seen = [0; 2];
        for (from_cell, to_cell) in [(0, 3), (3, 0), (0, 2), (1, 3), (2, 0), (0, 1), (2, 2)] {
            for x in inside(from_cell) {
                for p in inside(to_cell) {
                    let clear = passages.look((from_cell, &[x]), (to_cell, &[p]), &mut hiding) == Passage::Clear;
                    let way = nalgebra::Unit::try_new(p - x, 1e-9);
                    let met = way.and_then(|way| network.cast(from_cell, &x, &way, f64::INFINITY));
                    let free = met.is_none_or(|hit| hit.distance_m > (p - x).norm());
                    assert_eq!(clear, free, "from {x} in {from_cell} to {p} in {to_cell}");
                    seen[usize::from(clear)] += 1;
                }
            }
        }
        assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
    }
}
