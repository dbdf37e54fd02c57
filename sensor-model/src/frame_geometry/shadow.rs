//! Shadows and silhouettes of bodies, as holes in strips.

use std::ops::Range;

use ductloop_duct::cell::Plane;
use nalgebra::{Point3, Vector3};

use super::Frame;
use super::slit::mirrored_point;
use crate::Transform;
use crate::coverage::Edge;
use crate::scenery::Body;
use crate::silhouette::{self, Outline};

/// What throws shadows, and on what: set by [`Shadows::aim`]. Its memory is kept from one to the next.
#[derive(Debug, Default)]
pub(super) struct Shadows {
    apex: Vector3<f64>,
    camera_from_world: Transform,
    /// Bodies are seen mirrored in this.
    mirror: Option<Plane>,
    outline: Outline,
    corners: Vec<Point3<f64>>,
    cone: Vec<Vector3<f64>>,
    /// Outward unit normals of the pyramid from the apex to the piece.
    pyramid: Vec<Vector3<f64>>,
    /// Ways from the apex to the piece's corners.
    ways: Vec<Vector3<f64>>,
}

impl Shadows {
    /// Prepares for shadows thrown on a piece of a sheet in the light of, or seen from, `apex`, by bodies seen in `mirror`, if any. All in
    /// the camera's frame.
    pub(super) fn aim(&mut self, frame: &Frame, apex: &Vector3<f64>, mirror: Option<&Plane>, piece: &[Point3<f64>]) {
        self.apex = *apex;
        self.camera_from_world = frame.camera_from_world;
        self.mirror = mirror.copied();
        // Where the apex is among the real bodies.
        let real = self.mirror.map_or(Point3::from(*apex), |mirror| mirrored_point(&Point3::from(*apex), &mirror));
        self.outline.look_from(frame.camera_from_world.inverse_transform_point(&real));
        self.ways.clear();
        self.ways.extend(piece.iter().map(|p| p.coords - apex));
        let middle: Vector3<f64> = self.ways.iter().sum();
        self.pyramid.clear();
        self.pyramid.extend((0..self.ways.len()).filter_map(|i| {
            let normal = self.ways[i].cross(&self.ways[(i + 1) % self.ways.len()]).try_normalize(1e-14)?;
            Some(if normal.dot(&middle) > 0.0 { -normal } else { normal })
        }));
    }

    /// Adds the shadow that a body throws on a plane as a hole. A body that cannot shadow the piece aimed at is passed over.
    pub(super) fn add(&mut self, body: &Body, plane: &Plane, edges: &mut Vec<Edge>, holes: &mut Vec<Range<usize>>) {
        /// A body's own face is no nearer to the apex than itself: this much of it, in metres, is rounding.
        const ROUNDING_M: f64 = 1e-9;
        let place = |corner: &Point3<f64>| {
            let placed = self.camera_from_world * corner;
            self.mirror.map_or(placed, |mirror| mirrored_point(&placed, &mirror))
        };
        let apex = &self.apex;
        let (middle, radius_m) = &body.ball;
        let middle = place(middle);
        if self.pyramid.iter().any(|outward| outward.dot(&(middle.coords - apex)) > *radius_m) {
            return;
        }
        // Seen from the apex, piece and body are convex: if they do not overlap, a line along an edge of one of the two parts them.
        self.corners.clear();
        self.corners.extend(body.corners.iter().map(place));
        let beside = |outward: &Vector3<f64>| self.corners.iter().all(|corner| outward.dot(&(corner.coords - apex)) > 0.0);
        if self.pyramid.iter().any(beside) {
            return;
        }
        let parts = |q: &Vector3<f64>| self.ways.iter().all(|way| q.dot(way) <= 0.0);
        self.cone.clear();
        self.outline.cone(body, apex, &self.corners, &mut self.cone);
        if self.cone.len() < 3 || self.cone.iter().any(parts) {
            return;
        }
        // Only what is on the near side of the plane throws a shadow on it.
        let beyond = |p: &Point3<f64>| plane.distance(p) >= -ROUNDING_M;
        if self.corners.iter().any(beyond) {
            cut_off(&mut self.corners, body, plane, beyond);
            self.cone.clear();
            silhouette::cone(apex, &self.corners, &mut self.cone);
            if self.cone.len() < 3 || self.cone.iter().any(parts) {
                return;
            }
        }
        let first = edges.len();
        edges.extend(self.cone.iter().filter_map(|q| trace(q, apex, plane)));
        holes.push(first..edges.len());
    }
}

/// Replaces a body's corners by those of its part on the near side of a plane.
fn cut_off(corners: &mut Vec<Point3<f64>>, body: &Body, plane: &Plane, beyond: impl Fn(&Point3<f64>) -> bool) {
    let count = corners.len();
    for [a, b] in &body.edges {
        let (from, to) = (corners[*a], corners[*b]);
        let (d_from, d_to) = (plane.distance(&from), plane.distance(&to));
        // By the same rule as below: a corner that rounding puts on the plane is replaced by where its edge meets it.
        if beyond(&from) != beyond(&to) {
            corners.push(from + (to - from) * (d_from / (d_from - d_to)).clamp(0.0, 1.0));
        }
    }
    let mut index = 0;
    corners.retain(|p| {
        index += 1;
        index > count || !beyond(p)
    });
    // A body that touches the plane from beyond leaves nothing but corners on it.
    if corners.iter().all(beyond) {
        corners.clear();
    }
}

/// The trace on a plane n . X = o of the plane through `apex` with normal q, as a line in the image, inside where q . (X - apex) > 0:
/// q . (r o / (n . r) - apex) = (o q - (q . apex) n) . r / (n . r). None where it is nowhere in the image.
pub(super) fn trace(q: &Vector3<f64>, apex: &Vector3<f64>, plane: &Plane) -> Option<Edge> {
    (q * plane.offset_m - plane.normal.into_inner() * q.dot(apex)).try_normalize(1e-14)
}
