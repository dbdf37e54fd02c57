//! A duct network as light sees it: sheets that it falls on, openings that it passes, bodies that cast shadows.
//!
//! Made once from a network, in world coordinates: faces lose the areas of their portals, the solids' faces are cut to the cells
//! that list them, so that every visible piece of surface is in exactly one sheet.

use std::collections::BTreeMap;

use ductloop_duct::cell::{Beyond, Cell, CellId, Face, Plane, Solid, SurfaceId};
use ductloop_duct::network::Network;
use nalgebra::{Point3, Vector3};

use crate::renderer::RenderError;
use crate::surface::Look;

/// Smaller pieces of surface than this are left out, in square metres: they are rounding, not geometry.
const AREA_MIN_M2: f64 = 1e-10;

/// A convex piece of surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Its place among all sheets of the scenery.
    pub id: SheetId,
    /// Its outline.
    pub outline: Vec<Point3<f64>>,
    /// Its plane; the normal points away from the side that can be seen.
    pub plane: Plane,
    /// What it is made of.
    pub surface: SurfaceId,
    /// The body whose face it is, an index into [`Scenery::bodies`]; `None` for a wall.
    pub body: Option<usize>,
    /// The cell that it is in.
    pub cell: CellId,
    /// Its area over its greatest extent, in metres.
    pub breadth_m: f64,
}

/// Number of a sheet.
pub type SheetId = usize;

/// A way from a cell into the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Its outline.
    pub outline: Vec<Point3<f64>>,
    /// Plane of the face that it is in; the normal points out of the cell.
    pub plane: Plane,
    /// The cell beyond.
    pub beyond: CellId,
}

/// An end of the network without a cap.
#[derive(Clone, Debug, PartialEq)]
pub struct Grille {
    /// Its outline.
    pub outline: Vec<Point3<f64>>,
    /// Plane of the face that it is in; the normal points out of the cell.
    pub plane: Plane,
}

/// A body that casts shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Middle and radius, in metres, of a ball that holds it.
    pub ball: (Point3<f64>, f64),
    /// Its faces' planes, normals pointing out of it.
    pub planes: Vec<Plane>,
    /// Its corners.
    pub corners: Vec<Point3<f64>>,
    /// Pairs of corners that an edge joins.
    pub edges: Vec<[usize; 2]>,
    /// The two faces that meet in each edge, as indices into `planes`.
    pub sides: Vec<[usize; 2]>,
}

/// A cell as light sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// What light falls on.
    pub sheets: Vec<Sheet>,
    /// What it passes through into other cells.
    pub openings: Vec<Opening>,
    /// Where it comes in from the open, and is lost to it: outlines whose planes' normals point out of the cell.
    pub grilles: Vec<Grille>,
    /// Indices into [`Scenery::bodies`].
    pub bodies: Vec<usize>,
}

/// The whole network, in world coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenery {
    /// A room for each cell.
    pub rooms: Vec<Room>,
    /// The solids of all cells, one that reaches into several cells once.
    pub bodies: Vec<Body>,
    /// Number of sheets in all rooms.
    pub sheets: usize,
    /// What surfaces look like, by their numbers.
    pub looks: Vec<Look>,
    network: Network,
}

impl Body {
    fn of(solid: &Solid) -> Self {
        /// Distance up to which a corner belongs to a plane, in metres.
        const ON_PLANE_M: f64 = 1e-7;
        let on = |corner: &Point3<f64>, plane: &Plane| plane.distance(corner).abs() < ON_PLANE_M;
        let corners = &solid.corners;
        let pairs = (0..corners.len()).flat_map(|a| (a + 1..corners.len()).map(move |b| [a, b]));
        let (edges, sides) = pairs
            .filter_map(|[a, b]| {
                let mut shared = (0..solid.planes.len()).filter(|i| [a, b].iter().all(|c| on(&corners[*c], &solid.planes[*i])));
                Some(([a, b], [shared.next()?, shared.next()?]))
            })
            .unzip();
        let middle = Point3::from(corners.iter().map(|c| c.coords).sum::<Vector3<f64>>() / corners.len().max(1) as f64);
        let radius_m = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        Self { ball: (middle, radius_m), planes: solid.planes.clone(), corners: corners.clone(), edges, sides }
    }
}

impl Scenery {
    /// Prepares a network; `looks` is indexed by surface.
    ///
    /// # Errors
    /// [`RenderError::NoLook`] for a surface without an entry, [`RenderError::Look`] for one out of bounds.
    pub fn new(network: &Network, looks: &[Look]) -> Result<Self, RenderError> {
        for (index, look) in looks.iter().enumerate() {
            if let Some((field, value, bound)) = look.fault() {
                return Err(RenderError::Look { index, field, value, bound });
            }
        }
        let known = |surface: SurfaceId| match looks.get(usize::from(surface.0)) {
            Some(_) => Ok(surface),
            None => Err(RenderError::NoLook { surface, looks: looks.len() }),
        };
        let mut bodies: Vec<Body> = Vec::new();
        let mut rooms = Vec::with_capacity(network.cells.len());
        // A solid is the same in all cells that list it, to the bit.
        let mut known_bodies: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
        let key = |solid: &Solid| solid.corners.iter().flat_map(|corner| corner.coords.iter().map(|c| c.to_bits())).collect();
        let mut sheets = 0;
        let mut id = || {
            sheets += 1;
            sheets - 1
        };
        for (cell_id, cell) in network.cells.iter().enumerate() {
            let mut room = Room { sheets: Vec::new(), openings: Vec::new(), grilles: Vec::new(), bodies: Vec::new() };
            for face in &cell.faces {
                let surface = known(face.surface)?;
                let plane = face.plane;
                room.sheets.extend(closed_parts(face).into_iter().map(|outline| Sheet {
                    id: id(),
                    breadth_m: breadth_m(&outline),
                    outline,
                    plane,
                    surface,
                    body: None,
                    cell: cell_id,
                }));
                for portal in &face.portals {
                    let outline = portal.outline.clone();
                    match portal.beyond {
                        Beyond::Outside => room.grilles.push(Grille { outline, plane }),
                        Beyond::Cell(beyond) => room.openings.push(Opening { outline, plane, beyond }),
                    }
                }
            }
            for solid in &cell.solids {
                let surface = known(solid.surface)?;
                let body = *known_bodies.entry(key(solid)).or_insert_with(|| {
                    bodies.push(Body::of(solid));
                    bodies.len() - 1
                });
                room.bodies.push(body);
                let body = Some(body);
                room.sheets.extend(faces_within(solid, cell).map(|(plane, outline)| Sheet {
                    id: id(),
                    breadth_m: breadth_m(&outline),
                    outline,
                    plane,
                    surface,
                    body,
                    cell: cell_id,
                }));
            }
            rooms.push(room);
        }
        Ok(Self { rooms, bodies, sheets, looks: looks.to_vec(), network: network.clone() })
    }

    /// What a sheet looks like.
    pub fn look(&self, sheet: &Sheet) -> &Look {
        &self.looks[usize::from(sheet.surface.0)]
    }

    /// The cell that holds a point, looked for from `near` through portals; `None` outside the network.
    pub fn cell_at(&self, point_in_world: &Point3<f64>, near: CellId) -> Option<CellId> {
        self.network.cell_at(point_in_world, near)
    }
}

/// The part of a convex polygon where `outside` is not positive, appended to `kept`. `outside` must be linear.
///
/// A corner is never computed from the end that is cut off: two polygons that share an edge get the same new corner from the
/// same pair, whichever way round each runs.
pub fn clip(polygon: &[Point3<f64>], outside: impl Fn(&Point3<f64>) -> f64, kept: &mut Vec<Point3<f64>>) {
    let Some(mut from) = polygon.last() else { return };
    let mut from_outside = outside(from);
    for to in polygon {
        let to_outside = outside(to);
        let between = |a: &Point3<f64>, da: f64, b: &Point3<f64>, db: f64| a + (b - a) * (da / (da - db));
        if from_outside <= 0.0 && to_outside > 0.0 {
            kept.push(between(from, from_outside, to, to_outside));
        } else if from_outside > 0.0 && to_outside <= 0.0 {
            kept.push(between(to, to_outside, from, from_outside));
        }
        if to_outside <= 0.0 {
            kept.push(*to);
        }
        (from, from_outside) = (to, to_outside);
    }
}

fn clipped(polygon: &[Point3<f64>], outside: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    clip(polygon, outside, &mut kept);
    kept
}

fn area(polygon: &[Point3<f64>]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let doubled: Vector3<f64> = polygon.windows(2).map(|edge| (edge[0] - first).cross(&(edge[1] - first))).sum();
    doubled.norm() / 2.0
}

fn breadth_m(polygon: &[Point3<f64>]) -> f64 {
    let extent = polygon.iter().flat_map(|a| polygon.iter().map(move |b| (b - a).norm())).fold(0.0, f64::max);
    area(polygon) / extent
}

/// A face without its portals, in convex pieces: each portal's edges cut off one piece after the other.
fn closed_parts(face: &Face) -> Vec<Vec<Point3<f64>>> {
    let mut pieces = vec![face.outline.clone()];
    for portal in &face.portals {
        let mut closed = Vec::new();
        for mut rest in pieces {
            for edge in &portal.edges {
                closed.push(clipped(&rest, |p| -edge.distance(p)));
                rest = clipped(&rest, |p| edge.distance(p));
            }
        }
        closed.retain(|piece| area(piece) > AREA_MIN_M2);
        pieces = closed;
    }
    pieces
}

/// The faces of a solid as far as they are within a cell, each with the plane whose normal points away from the viewer.
fn faces_within(solid: &Solid, cell: &Cell) -> impl Iterator<Item = (Plane, Vec<Point3<f64>>)> {
    /// Distance up to which a corner belongs to a plane, in metres.
    const ON_PLANE_M: f64 = 1e-7;
    solid.planes.iter().filter_map(|plane| {
        let mut outline: Vec<_> = solid.corners.iter().copied().filter(|c| plane.distance(c).abs() < ON_PLANE_M).collect();
        let middle = Point3::from(outline.iter().map(|c| c.coords).sum::<Vector3<f64>>() / outline.len().max(1) as f64);
        let x = (outline.first()? - middle).try_normalize(0.0)?;
        let y = plane.normal.cross(&x);
        let angle = |c: &Point3<f64>| libm::atan2((c - middle).dot(&y), (c - middle).dot(&x));
        outline.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        for face in &cell.faces {
            outline = clipped(&outline, |p| face.plane.distance(p));
        }
        let away = Plane { normal: -plane.normal, offset_m: -plane.offset_m };
        (area(&outline) > AREA_MIN_M2).then_some((away, outline))
    })
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::Portal;

    use super::*;

    #[test]
    fn a_face_with_a_portal_in_its_middle_keeps_the_rest_of_its_area() {
        let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let plane = Plane { normal: Vector3::z_axis(), offset_m: 0.0 };
        let square = |r: f64| vec![at(-r, -r), at(r, -r), at(r, r), at(-r, r)];
        let mut face = Face {
            plane,
            outline: square(0.5),
            portals: vec![Portal::new(&plane, square(0.2), Beyond::Cell(1))],
            kind: ductloop_duct::cell::FaceKind::Wall,
            surface: SurfaceId(0),
        };
        let parts = closed_parts(&face);
        assert_eq!(parts.len(), 4);
        assert!((parts.iter().map(|p| area(p)).sum::<f64>() - (1.0 - 0.16)).abs() < 1e-12);
        face.portals = vec![Portal::new(&plane, square(0.5), Beyond::Cell(1))];
        assert!(closed_parts(&face).is_empty());
    }
}
