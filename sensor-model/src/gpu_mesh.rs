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

/// How much larger than they are polygons are drawn, in pixels, so that no pixel falls between neighbours: twice this is more than
/// what devices round corners to (1/256) and `BEND_MAX_PX` together. What is behind what is decided by depth.
const EXPANSION_PX: f64 = 1.0 / 64.0;

/// How far the bent image of a straight edge may be from the edge that is drawn, in pixels.
const BEND_MAX_PX: f64 = 0.02;

/// Most times that a triangle is divided: a pixel of an image of 8192.
const DIVISIONS_MAX: u32 = 13;

/// A place in the image before distortion, in units of the focal lengths.
type Ray = Vector2<f64>;

/// Triangles, and room to make them in.
#[derive(Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<Vertex>,
    outline: Vec<Ray>,
    undivided: Vec<([Ray; 3], u32)>,
}

impl Mesh {
    /// Adds a convex polygon in the camera's frame; `plane` is its (n / o), by which 1 / z follows from a ray.
    pub(crate) fn add_polygon(&mut self, corners: &[Point3<f64>], plane: &Vector3<f64>, projection: &Projection, item: u32) {
        self.expand(corners, projection);
        let Some((first, rest)) = self.outline.split_first() else { return };
        self.undivided.clear();
        self.undivided.extend(rest.windows(2).map(|pair| ([*first, pair[0], pair[1]], 0)));
        while let Some((triangle, depth)) = self.undivided.pop() {
            let bent = |i: usize| {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                depth < DIVISIONS_MAX && !projection.is_pinhole() && is_bent(&a, &b, projection)
            };
            let bends = [bent(0), bent(1), bent(2)];
            if bends == [false; 3] {
                self.vertices.extend(triangle.map(|ray| {
                    let inverse_m = plane.x * ray.x + plane.y * ray.y + plane.z;
                    Vertex { pixel: projection.pixel(ray.into()).map(|v| v as f32), inverse_m: inverse_m as f32, item }
                }));
            } else {
                divide(&triangle, &bends, |part| self.undivided.push((part, depth + 1)));
            }
        }
    }

    /// Adds a band as a chain of quadrilaterals that share their borders.
    pub(crate) fn add_band(&mut self, band: &[BandPoint], item: u32) {
        let vertex = |pixel: Vector2<f64>| Vertex { pixel: [pixel.x as f32, pixel.y as f32], inverse_m: 0.0, item };
        for pair in band.windows(2) {
            let ([a, b], [c, d]) = (pair[0].borders(), pair[1].borders());
            self.vertices.extend([a, b, c, c, b, d].map(vertex));
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

/// Whether the image of an edge bends away from the chord of its ends.
fn is_bent(a: &Ray, b: &Ray, projection: &Projection) -> bool {
    let [first, last, middle] = [*a, *b, (a + b) / 2.0].map(|ray| Vector2::from(projection.pixel(ray.into())));
    (middle - (first + last) / 2.0).norm() > BEND_MAX_PX
}

/// Divides a triangle at the middles of its bent edges; edge i runs from corner i to the next. Neighbours divide an edge alike.
fn divide(triangle: &[Ray; 3], bends: &[bool; 3], mut part: impl FnMut([Ray; 3])) {
    let middle = |i: usize| (triangle[i] + triangle[(i + 1) % 3]) / 2.0;
    match bends.iter().filter(|bent| **bent).count() {
        3 => {
            let middles = [middle(0), middle(1), middle(2)];
            part(middles);
            for i in 0..3 {
                part([triangle[i], middles[i], middles[(i + 2) % 3]]);
            }
        }
        2 => {
            // The corner between the two bent edges is cut off; the rest is a quadrilateral.
            let straight = bends.iter().position(|bent| !bent).unwrap_or(0);
            let [a, b, tip] = [straight, (straight + 1) % 3, (straight + 2) % 3];
            let (right, left) = (middle(b), middle(tip));
            part([triangle[tip], left, right]);
            part([triangle[a], triangle[b], right]);
            part([triangle[a], right, left]);
        }
        _ => {
            let bent = bends.iter().position(|bent| *bent).unwrap_or(0);
            let [a, b, tip] = [bent, (bent + 1) % 3, (bent + 2) % 3];
            let cut = middle(bent);
            part([triangle[a], cut, triangle[tip]]);
            part([cut, triangle[b], triangle[tip]]);
        }
    }
}
