//! Which parts of the scenery a point sees, by following openings from its cell.
//!
//! Seen from a point, a convex opening is a pyramid; the cells beyond are seen within it, their own openings narrow it further.
//! No ray is cast: the answer is exact polygons, to rounding in double precision. A straight view of a network costs the same
//! however large the network is. Bodies within the cells do not narrow the beam: whoever uses it deals with them.

use ductloop_duct::cell::CellId;
use nalgebra::{Point3, Vector3};

use crate::Transform;
use crate::scenery::{Scenery, Sheet, clip};

/// How near a plane the apex may be and still count as in it, in metres.
const IN_PLANE_M: f64 = 1e-9;

/// A part of a sheet that the apex sees.
#[derive(Debug)]
pub struct Sight<'a> {
    /// The sheet.
    pub sheet: &'a Sheet,
    /// The visible part's outline in the apex' frame.
    pub outline: &'a [Point3<f64>],
    /// The cells that the beam passes from the apex' own to the sheet's, both included.
    pub path: &'a [CellId],
}

/// What a beam ends on.
#[derive(Debug)]
pub enum Met<'a> {
    /// A part of a sheet.
    Sheet(Sight<'a>),
    /// A part of an open end: its outline in the apex' frame.
    End(&'a [Point3<f64>]),
}

/// Working memory of the search, to be kept from one to the next.
#[derive(Debug, Default)]
pub struct Beam {
    points: Vec<Point3<f64>>,
    spare: Vec<Point3<f64>>,
    /// Normals of planes through the apex, pointing out of the beam.
    bounds: Vec<Vector3<f64>>,
    path: Vec<CellId>,
}

/// What does not change during a search.
struct Search<'a> {
    scenery: &'a Scenery,
    apex_from_world: &'a Transform,
    range_m: f64,
}

impl Beam {
    /// Visits every part of a sheet that is seen from the origin of the apex' frame, which lies in `cell`, within the planes
    /// through the apex whose outward normals are `bounds`, and not through openings whose middle is beyond `range_m`.
    ///
    /// A sheet seen along two ways is visited twice, each time with the part that is seen that way.
    pub fn trace(
        &mut self,
        scenery: &Scenery,
        apex_from_world: &Transform,
        cell: CellId,
        bounds: &[Vector3<f64>],
        range_m: f64,
        visit: &mut dyn FnMut(&Sight),
    ) {
        self.trace_to_ends(scenery, apex_from_world, cell, bounds, range_m, &mut |met| {
            if let Met::Sheet(sight) = met {
                visit(&sight);
            }
        });
    }

    /// As [`Self::trace`], and visits the open ends too.
    pub fn trace_to_ends(
        &mut self,
        scenery: &Scenery,
        apex_from_world: &Transform,
        cell: CellId,
        bounds: &[Vector3<f64>],
        range_m: f64,
        visit: &mut dyn FnMut(Met),
    ) {
        self.points.clear();
        self.path.clear();
        self.bounds.clear();
        self.bounds.extend_from_slice(bounds);
        self.enter(&Search { scenery, apex_from_world, range_m }, cell, 0, visit);
    }

    /// The beam bounded by `self.bounds[first_bound..]` within one cell and what lies beyond its openings.
    fn enter(&mut self, search: &Search, cell: CellId, first_bound: usize, visit: &mut dyn FnMut(Met)) {
        self.path.push(cell);
        let room = &search.scenery.rooms[cell];
        for sheet in &room.sheets {
            if sheet.plane.transformed(search.apex_from_world).offset_m > IN_PLANE_M {
                let start = self.push_clipped(search, &sheet.outline, first_bound);
                if self.points.len() >= start + 3 {
                    visit(Met::Sheet(Sight { sheet, outline: &self.points[start..], path: &self.path }));
                }
                self.points.truncate(start);
            }
        }
        for grille in &room.grilles {
            if grille.plane.transformed(search.apex_from_world).offset_m <= IN_PLANE_M {
                continue;
            }
            let start = self.push_clipped(search, &grille.outline, first_bound);
            if self.points.len() >= start + 3 {
                visit(Met::End(&self.points[start..]));
            }
            self.points.truncate(start);
        }
        for opening in &room.openings {
            // A ray crosses a convex cell at most once, so the beam never comes back.
            let distance_m = opening.plane.transformed(search.apex_from_world).offset_m;
            if self.path.contains(&opening.beyond) || distance_m < -IN_PLANE_M {
                continue;
            }
            let start = self.push_clipped(search, &opening.outline, first_bound);
            let corners = self.points.len() - start;
            let middle: Vector3<f64> =
                self.points[start..].iter().map(|p| p.coords).sum::<Vector3<f64>>() / corners.max(1) as f64;
            if distance_m <= IN_PLANE_M {
                // The apex stands in the opening's plane. All of the beam passes if it stands within the opening, else nothing.
                self.points.truncate(start);
                if search.scenery.cell_at(&(search.apex_from_world.inverse() * Point3::origin()), opening.beyond)
                    == Some(opening.beyond)
                {
                    self.enter(search, opening.beyond, first_bound, visit);
                }
            } else if corners >= 3 && middle.norm() <= search.range_m {
                let bound = self.bounds.len();
                for i in 0..corners {
                    let (a, b) = (self.points[start + i], self.points[start + (i + 1) % corners]);
                    if let Some(normal) = plane_of_edge(&a, &b) {
                        self.bounds.push(if normal.dot(&middle) > 0.0 { -normal } else { normal });
                    }
                }
                self.points.truncate(start);
                self.enter(search, opening.beyond, bound, visit);
                self.bounds.truncate(bound);
            } else {
                self.points.truncate(start);
            }
        }
        self.path.pop();
    }

    /// Puts the part of an outline within the beam on top of `self.points`, in the apex' frame; returns where it starts.
    fn push_clipped(&mut self, search: &Search, outline: &[Point3<f64>], first_bound: usize) -> usize {
        let start = self.points.len();
        self.points.extend(outline.iter().map(|p| search.apex_from_world * p));
        for i in first_bound..self.bounds.len() {
            clip_top(&mut self.points, start, &mut self.spare, |p| self.bounds[i].dot(&p.coords));
        }
        start
    }
}

/// Unit normal of the plane through the origin and an edge from `a` to `b`. None where the edge is in line with the origin, or so
/// short (1e-7 rad, a ten-thousandth of a pixel) that its ends are one corner that clipping made twice: its direction would be
/// rounding.
pub(crate) fn plane_of_edge(a: &Point3<f64>, b: &Point3<f64>) -> Option<Vector3<f64>> {
    const SAME_CORNER: f64 = 1e-7;
    a.coords.cross(&b.coords).try_normalize(SAME_CORNER * a.coords.norm() * b.coords.norm())
}

/// Clips the polygon `points[start..]` in place.
pub(crate) fn clip_top(
    points: &mut Vec<Point3<f64>>,
    start: usize,
    spare: &mut Vec<Point3<f64>>,
    outside: impl Fn(&Point3<f64>) -> f64,
) {
    spare.clear();
    clip(&points[start..], outside, spare);
    points.truncate(start);
    points.extend_from_slice(spare);
}
