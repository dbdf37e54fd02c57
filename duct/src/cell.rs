//! Convex cells: the one description from which colliders, images and ground truth are made.
//!
//! Every cell is the intersection of half-spaces. A ray inside it leaves through one face; where a portal covers that spot, the
//! portal names the cell that takes over. Faces need not be tiled by portals: a portal is any convex polygon within its face.

use nalgebra::{Point2, Point3, Unit, Vector3};

use crate::Transform;
use crate::box_tree::Bounds;

/// Index of a cell within its network.
pub type CellId = usize;

/// Which surface a face has. What it looks like and how it grips is decided by whoever renders it or drives on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SurfaceId(pub u16);

/// A plane n . p = d with unit normal n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal; of a face, it points out of the cell or out of the solid.
    pub normal: Unit<Vector3<f64>>,
    /// Distance from the origin along the normal, in metres.
    pub offset_m: f64,
}

/// What a portal leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// Another cell of the network.
    Cell(CellId),
    /// The open: an end of the network without a cap.
    Outside,
}

/// An opening in a face.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Convex outline within the face, anticlockwise seen from outside the cell.
    pub outline: Vec<Point3<f64>>,
    /// Planes through the outline's edges, square to the face, normals pointing away from the opening.
    pub edges: Vec<Plane>,
    /// Where it leads.
    pub beyond: Beyond,
}

/// What part of a duct a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceKind {
    /// Bottom.
    Floor,
    /// Top.
    Ceiling,
    /// Side, end cap, or the plane of a port.
    Wall,
}

/// A planar face of a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// The face's plane; its normal points out of the cell.
    pub plane: Plane,
    /// Convex outline, anticlockwise seen from outside the cell.
    pub outline: Vec<Point3<f64>>,
    /// Openings in it.
    pub portals: Vec<Portal>,
    /// Floor, ceiling or wall.
    pub kind: FaceKind,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// A convex body standing in a cell: flange bead, vane, screw, debris.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Its faces' planes, normals pointing out of the solid.
    pub planes: Vec<Plane>,
    /// Its corners.
    pub corners: Vec<Point3<f64>>,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// A convex piece of duct.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The faces that bound it.
    pub faces: Vec<Face>,
    /// What stands in it.
    pub solids: Vec<Solid>,
    /// Index of the fitting that it is a part of.
    pub fitting: usize,
}

/// A plane over the plan: z = z_m + slope_x x + slope_y y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slant {
    /// Height over the plan's origin, in metres.
    pub z_m: f64,
    /// Rise along x.
    pub slope_x: f64,
    /// Rise along y.
    pub slope_y: f64,
}

/// A side of a prism: solid sheet, or open over its whole area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Sheet metal.
    Wall,
    /// A portal as large as the side.
    Portal(Beyond),
}

impl Plane {
    /// The plane through three points, its normal along (b - a) x (c - a). The points must not be on one line.
    pub fn through(a: Point3<f64>, b: Point3<f64>, c: Point3<f64>) -> Self {
        let normal = Unit::new_normalize((b - a).cross(&(c - a)));
        Self { normal, offset_m: normal.dot(&a.coords) }
    }

    /// Signed distance of a point, positive on the side the normal points to, in metres.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset_m
    }

    /// The same plane with its normal the other way.
    fn flipped(&self) -> Self {
        // Not negated: a plane through the origin has the offset 0, not -0.
        Self { normal: -self.normal, offset_m: 0.0 - self.offset_m }
    }

    /// The plane moved along with its body: `self` in frame b becomes the same plane in frame a.
    pub fn transformed(&self, a_from_b: &Transform) -> Self {
        let normal = Unit::new_unchecked(a_from_b.rotation * self.normal.into_inner());
        Self { normal, offset_m: self.offset_m + normal.dot(&a_from_b.translation.vector) }
    }
}

impl Slant {
    /// A level plane at this height.
    pub const fn level(z_m: f64) -> Self {
        Self { z_m, slope_x: 0.0, slope_y: 0.0 }
    }

    /// A plane that rises along x from `z_m` at x = 0 to `end_z_m` at `length_m`.
    pub fn along(z_m: f64, end_z_m: f64, length_m: f64) -> Self {
        Self { z_m, slope_x: (end_z_m - z_m) / length_m, slope_y: 0.0 }
    }

    /// Its height over a point of the plan, in metres.
    pub fn z_m(&self, at: &Point2<f64>) -> f64 {
        self.z_m + self.slope_x * at.x + self.slope_y * at.y
    }

    /// The plane itself, its normal upward.
    fn plane(&self) -> Plane {
        let up = Vector3::new(0.0 - self.slope_x, 0.0 - self.slope_y, 1.0);
        let (normal, length) = Unit::new_and_get(up);
        Plane { normal, offset_m: self.z_m / length }
    }
}

impl Portal {
    /// An opening with this outline in a face with this plane.
    pub fn new(face: &Plane, outline: Vec<Point3<f64>>, beyond: Beyond) -> Self {
        let edges = (0..outline.len())
            .map(|i| {
                let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
                let normal = Unit::new_normalize((b - a).cross(&face.normal));
                Plane { normal, offset_m: normal.dot(&a.coords) }
            })
            .collect();
        Self { outline, edges, beyond }
    }

    /// Whether a point of the face lies within the opening.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        self.edges.iter().all(|edge| edge.distance(point) <= 0.0)
    }

    fn transformed(&self, a_from_b: &Transform) -> Self {
        Self {
            outline: self.outline.iter().map(|p| a_from_b * p).collect(),
            edges: self.edges.iter().map(|e| e.transformed(a_from_b)).collect(),
            beyond: self.beyond,
        }
    }
}

impl Solid {
    /// A box with edges of `size_m` along its own axes, standing at `frame_from_box` (the centre of its bottom).
    pub fn cuboid(frame_from_box: &Transform, size_m: Vector3<f64>, surface: SurfaceId) -> Self {
        let half = size_m / 2.0;
        let mut corners = Vec::with_capacity(8);
        for x in [-half.x, half.x] {
            for y in [-half.y, half.y] {
                for z in [0.0, size_m.z] {
                    corners.push(frame_from_box * Point3::new(x, y, z));
                }
            }
        }
        let planes = [
            (Vector3::x(), half.x),
            (-Vector3::x(), half.x),
            (Vector3::y(), half.y),
            (-Vector3::y(), half.y),
            (Vector3::z(), size_m.z),
            (-Vector3::z(), 0.0),
        ]
        .map(|(normal, offset_m)| Plane { normal: Unit::new_unchecked(normal), offset_m }.transformed(frame_from_box));
        Self { planes: planes.into(), corners, surface }
    }

    pub(crate) fn transformed(&self, a_from_b: &Transform) -> Self {
        Self {
            planes: self.planes.iter().map(|p| p.transformed(a_from_b)).collect(),
            corners: self.corners.iter().map(|p| a_from_b * p).collect(),
            surface: self.surface,
        }
    }
}

impl Cell {
    /// An upright prism over a convex plan, from z = 0 to `height_m`.
    ///
    /// `plan` is anticlockwise seen from above; side i runs from corner i to corner i + 1.
    pub fn prism(plan: &[Point2<f64>], height_m: f64, sides: &[Side], surface: SurfaceId, fitting: usize) -> Self {
        Self::upright(plan, [Slant::level(0.0), Slant::level(height_m)], sides, surface, fitting)
    }

    /// A body with upright sides over a convex plan, between two planes that may slope: floor and ceiling. Its first two faces are
    /// floor and ceiling, the sides follow in order.
    ///
    /// `plan` is anticlockwise seen from above; side i runs from corner i to corner i + 1. Over every corner of the plan the ceiling
    /// must be above the floor.
    pub fn upright(plan: &[Point2<f64>], slants: [Slant; 2], sides: &[Side], surface: SurfaceId, fitting: usize) -> Self {
        debug_assert_eq!(plan.len(), sides.len());
        let [floor, ceiling] = slants;
        let on = |slant: Slant, corner: Point2<f64>| Point3::new(corner.x, corner.y, slant.z_m(&corner));
        let face = |plane, outline, kind| Face { plane, outline, portals: Vec::new(), kind, surface };
        let bottom = plan.iter().rev().map(|c| on(floor, *c)).collect();
        let top = plan.iter().map(|c| on(ceiling, *c)).collect();
        let mut faces =
            vec![face(floor.plane().flipped(), bottom, FaceKind::Floor), face(ceiling.plane(), top, FaceKind::Ceiling)];
        for (i, side) in sides.iter().enumerate() {
            let (a, b) = (plan[i], plan[(i + 1) % plan.len()]);
            let outline = vec![on(floor, a), on(floor, b), on(ceiling, b), on(ceiling, a)];
            let plane = Plane::through(outline[0], outline[1], outline[2]);
            let portals = match side {
                Side::Wall => Vec::new(),
                Side::Portal(beyond) => vec![Portal::new(&plane, outline.clone(), *beyond)],
            };
            faces.push(Face { plane, outline, portals, kind: FaceKind::Wall, surface });
        }
        Self { faces, solids: Vec::new(), fitting }
    }

    /// Whether the point lies inside or on the boundary, within `tolerance_m`.
    pub fn contains(&self, point: &Point3<f64>, tolerance_m: f64) -> bool {
        self.faces.iter().all(|face| face.plane.distance(point) <= tolerance_m)
    }

    /// Whether a solid may reach into it: no face has all of the solid on its outside.
    pub(crate) fn is_reached_by(&self, solid: &Solid) -> bool {
        !self.faces.iter().any(|face| solid.corners.iter().all(|corner| face.plane.distance(corner) > 0.0))
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.faces.iter().flat_map(|face| &face.outline))
    }

    /// The same cell in another frame.
    pub fn transformed(&self, a_from_b: &Transform) -> Self {
        Self {
            faces: self
                .faces
                .iter()
                .map(|face| Face {
                    plane: face.plane.transformed(a_from_b),
                    outline: face.outline.iter().map(|p| a_from_b * p).collect(),
                    portals: face.portals.iter().map(|p| p.transformed(a_from_b)).collect(),
                    ..*face
                })
                .collect(),
            solids: self.solids.iter().map(|s| s.transformed(a_from_b)).collect(),
            fitting: self.fitting,
        }
    }
}
