//! Triangles in the image: polygons and bands as the device draws them, in pixels, a lens' distortion included.

use nalgebra::{Point3, Vector2, Vector3};

use crate::band::BandPoint;
use crate::lens::Projection;

/// `Corner` of `camera.wgsl`: a corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    pub(crate) pixel: [f32; 2],
    /// 1 / z.
    pub(crate) inverse_m: f32,
    /// The region or strip that it is a corner of.
    pub(crate) item: u32,
}

/// `SoftPixel` of `soft_edge.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct PointVertex {
    pub(crate) pixel: [f32; 2],
    pub(crate) light_dn: f32,
}

/// How much larger than they are polygons are drawn, in pixels, so that no pixel falls between neighbours: twice this is more than
/// what devices round corners to (1/256) and what edges may be bent together. What is behind what is decided by depth.
const EXPANSION_PX: f64 = 1.0 / 128.0;

/// How far the bent image of a straight edge may be from the edge that is drawn, in pixels: within a polygon, and on its outline.
/// Within, it shows only where a polygon is thinner than that.
const BEND_MAX_PX: [f64; 2] = [0.5, 0.01];

/// Most times that a triangle is divided: a pixel of an image of 8192.
const DIVISIONS_MAX: u32 = 13;

/// A place in the image before distortion, in units of the focal lengths.
type Ray = Vector2<f64>;

/// Triangles, and room to make them in.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<Vertex>,
    outline: Vec<Ray>,
    undivided: Vec<Piece>,
}

/// A triangle that may have to be divided; edge i runs from corner i to the next, and is on the polygon's outline or not.
#[derive(Clone, Copy, Debug)]
struct Piece {
    corners: [Ray; 3],
    outer: [bool; 3],
    divisions: u32,
}

impl Mesh {
    /// Adds a convex polygon in the camera's frame; `plane` is its (n / o), by which 1 / z follows from a ray.
    pub(crate) fn add_polygon(&mut self, corners: &[Point3<f64>], plane: &Vector3<f64>, projection: &Projection, item: u32) {
        self.expand(corners, projection);
        let Some((first, rest)) = self.outline.split_first() else { return };
        self.undivided.clear();
        let last = rest.len() - 1;
        self.undivided.extend(rest.windows(2).zip(1..).map(|(pair, i)| Piece {
            corners: [*first, pair[0], pair[1]],
            outer: [i == 1, true, i == last],
            divisions: 0,
        }));
        while let Some(piece) = self.undivided.pop() {
            let bends = if projection.is_pinhole() || piece.divisions == DIVISIONS_MAX {
                [false; 3]
            } else {
                [0, 1, 2].map(|i| piece.is_bent(i, projection))
            };
            if bends == [false; 3] {
                self.vertices.extend(piece.corners.map(|ray| {
                    let inverse_m = plane.x * ray.x + plane.y * ray.y + plane.z;
                    Vertex { pixel: projection.pixel(ray.into()).map(|v| v as f32), inverse_m: inverse_m as f32, item }
                }));
            } else {
                piece.divide(&bends, |part| self.undivided.push(part));
            }
        }
    }

    /// Adds a band as a chain of quadrilaterals that share their borders, as few as follow it.
    pub(crate) fn add_band(&mut self, band: &[BandPoint], item: u32) {
        let vertex = |pixel: Vector2<f64>| Vertex { pixel: [pixel.x as f32, pixel.y as f32], inverse_m: 0.0, item };
        let mut first = 0;
        while first + 1 < band.len() {
            let mut last = first + 1;
            while last + 1 < band.len() && follows(&band[first..=last + 1]) {
                last += 1;
            }
            let ([a, b], [c, d]) = (band[first].borders(), band[last].borders());
            self.vertices.extend([a, b, c, c, b, d].map(vertex));
            first = last;
        }
    }

    /// Puts a polygon's rays into `outline`, moved outward.
    fn expand(&mut self, corners: &[Point3<f64>], projection: &Projection) {
        /// Corners nearer to each other than this are one, in pixels.
        const SAME_PX: f64 = 1e-6;
        /// Farthest that a sharp corner is moved, over the expansion.
        const MITRE_MAX: f64 = 4.0;
        let [fx, fy] = projection.camera.focal_px;
        let at = |corner: &Point3<f64>| Vector2::new(corner.x / corner.z * fx, corner.y / corner.z * fy);
        self.outline.clear();
        for corner in corners {
            let place = at(corner);
            if self.outline.last().is_none_or(|last| (place - last).norm() > SAME_PX) {
                self.outline.push(place);
            }
        }
        while self.outline.len() > 1 && (self.outline[0] - self.outline[self.outline.len() - 1]).norm() <= SAME_PX {
            self.outline.pop();
        }
        let count = self.outline.len();
        if count < 3 {
            self.outline.clear();
            return;
        }
        let doubled_area: f64 = (0..count).map(|i| self.outline[i].perp(&self.outline[(i + 1) % count])).sum();
        let side = EXPANSION_PX.copysign(doubled_area);
        // Each corner moves by the mitre of its edges' outward normals; the edge before it is that before any moved.
        let outward = |a: Ray, b: Ray| Vector2::new(b.y - a.y, a.x - b.x).normalize();
        let first = self.outline[0];
        let mut before = outward(self.outline[count - 1], first);
        for i in 0..count {
            let next = if i + 1 == count { first } else { self.outline[i + 1] };
            let after = outward(self.outline[i], next);
            let mitre = (before + after) / (1.0 + before.dot(&after)).max(1e-3);
            self.outline[i] += mitre.cap_magnitude(MITRE_MAX) * side;
            before = after;
        }
        for place in &mut self.outline {
            *place = Vector2::new(place.x / fx, place.y / fy);
        }
    }
}

/// Whether a quadrilateral between the ends of a band holds all of it, and little else: a device needs longer for a small triangle than
/// for some hundred pixels. Half a pixel may be cut off, of the whole one that bands are wider than their light.
fn follows(band: &[BandPoint]) -> bool {
    const CUT_PX: f64 = 0.5;
    let (first, last) = (&band[0], &band[band.len() - 1]);
    let chord = last.pixel - first.pixel;
    let square = chord.norm_squared();
    band[1..band.len() - 1].iter().all(|point| {
        let to = point.pixel - first.pixel;
        let share = to.dot(&chord) / square;
        let off_px = (to - chord * share).norm();
        let half_px = first.half_px + (last.half_px - first.half_px) * share;
        off_px + point.half_px - half_px < CUT_PX && half_px < 1.3 * point.half_px + 1.0
    })
}

impl Piece {
    /// Whether the image of edge i bends too far away from the chord of its ends.
    fn is_bent(&self, i: usize, projection: &Projection) -> bool {
        let (a, b) = (self.corners[i], self.corners[(i + 1) % 3]);
        let image = |ray: Ray| Vector2::from(projection.pixel(ray.into()));
        let (first, last) = (image(a), image(b));
        let chord = last - first;
        let bend_max_px = BEND_MAX_PX[usize::from(self.outer[i])];
        // At two places: an edge may bend one way and then the other.
        [1.0 / 3.0, 2.0 / 3.0].into_iter().any(|share| {
            let off = image(a + (b - a) * share) - first;
            chord.perp(&off).abs() > bend_max_px * chord.norm()
        })
    }

    /// Divides it at the middles of its bent edges.
    fn divide(&self, bends: &[bool; 3], mut part: impl FnMut(Self)) {
        let (corner, outer) = (|i: usize| self.corners[i % 3], |i: usize| self.outer[i % 3]);
        let middle = |i: usize| (corner(i) + corner(i + 1)) / 2.0;
        let mut add = |corners: [Ray; 3], outer: [bool; 3]| part(Self { corners, outer, divisions: self.divisions + 1 });
        match bends.iter().filter(|bent| **bent).count() {
            3 => {
                add([middle(0), middle(1), middle(2)], [false; 3]);
                for i in 0..3 {
                    add([corner(i), middle(i), middle(i + 2)], [outer(i), false, outer(i + 2)]);
                }
            }
            2 => {
                // The corner between the two bent edges is cut off; the rest is a quadrilateral.
                let a = bends.iter().position(|bent| !bent).unwrap_or(0);
                let (right, left) = (middle(a + 1), middle(a + 2));
                add([corner(a + 2), left, right], [outer(a + 2), false, outer(a + 1)]);
                add([corner(a), corner(a + 1), right], [outer(a), outer(a + 1), false]);
                add([corner(a), right, left], [false, false, outer(a + 2)]);
            }
            _ => {
                let a = bends.iter().position(|bent| *bent).unwrap_or(0);
                add([corner(a), middle(a), corner(a + 2)], [outer(a), false, outer(a + 2)]);
                add([middle(a), corner(a + 1), corner(a + 2)], [outer(a), outer(a + 1), false]);
            }
        }
    }
}
