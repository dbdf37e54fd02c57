//! The outline of a convex body as seen from a point: the planes through the point that just touch the body.

use nalgebra::{Point3, Vector3};

use crate::scenery::Body;

/// Outlines of whole bodies, by their edges: quicker than [`cone`], which needs corners only.
#[derive(Debug, Default)]
pub struct Outline {
    apex_in_world: Point3<f64>,
    facing: Vec<bool>,
}

impl Outline {
    /// Bodies are to be seen from this point of the world.
    pub fn look_from(&mut self, apex_in_world: Point3<f64>) {
        self.apex_in_world = apex_in_world;
    }

    /// As [`cone`], of a body of the world: an edge is in the outline if of its two faces one faces the point. `apex` and `corners` are the
    /// point and the body's corners in any frame, mirrored or not.
    pub fn cone(&mut self, body: &Body, apex: &Vector3<f64>, corners: &[Point3<f64>], cone: &mut Vec<Vector3<f64>>) {
        self.facing.clear();
        self.facing.extend(body.planes.iter().map(|plane| plane.distance(&self.apex_in_world) > 0.0));
        let middle = corners.iter().map(|corner| corner.coords - apex).sum::<Vector3<f64>>();
        for ([a, b], [one, other]) in body.edges.iter().zip(&body.sides) {
            if self.facing[*one] != self.facing[*other] {
                let normal = (corners[*a].coords - apex).cross(&(corners[*b].coords - apex));
                if let Some(normal) = normal.try_normalize(1e-14) {
                    cone.push(if normal.dot(&middle) < 0.0 { -normal } else { normal });
                }
            }
        }
    }
}

/// How far off a plane through the apex a corner may be and still count as on it, as the sine of an angle.
const ROUNDING: f64 = 1e-9;

/// Unit normals q of the planes through `apex` that bound the cone of sight to the corners: a point p is within the cone where
/// q . (p - apex) >= 0 for all of them. Appended to `cone`; nothing is where the apex is inside the body, or fewer than three corners
/// are given.
///
/// Each pair of corners spans a plane; those with all other corners on one side bound the cone. n corners cost n^3 / 2 products: bodies
/// have eight or so.
pub fn cone(apex: &Vector3<f64>, corners: &[Point3<f64>], cone: &mut Vec<Vector3<f64>>) {
    let start = cone.len();
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[i + 1..] {
            let (a, b) = (a.coords - apex, b.coords - apex);
            let Some(normal) = a.cross(&b).try_normalize(1e-14) else { continue };
            let mut sides = [false; 2];
            for corner in corners {
                let way = corner.coords - apex;
                let off = normal.dot(&way);
                if off.abs() > ROUNDING * way.norm() {
                    sides[usize::from(off < 0.0)] = true;
                }
            }
            let normal = match sides {
                [true, false] => normal,
                [false, true] => -normal,
                _ => continue,
            };
            if cone[start..].iter().all(|other| other.dot(&normal) < 1.0 - 1e-12) {
                cone.push(normal);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_seen_square_on_has_four_edges_and_from_a_corner_six() {
        let corners: Vec<_> = (0..8)
            .map(|i| Point3::new(f64::from(i & 1) * 2.0 - 1.0, f64::from(i >> 1 & 1) * 2.0 - 1.0, f64::from(i >> 2) * 2.0 - 1.0))
            .collect();
        let mut found = Vec::new();
        cone(&Vector3::new(5.0, 0.0, 0.0), &corners, &mut found);
        assert_eq!(found.len(), 4);
        // The nearest face, at x = 1, is 4 away and reaches 1 to each side.
        let inside =
            |p: Vector3<f64>, found: &[Vector3<f64>]| found.iter().all(|q| q.dot(&(p - Vector3::new(5.0, 0.0, 0.0))) >= 0.0);
        assert!(inside(Vector3::new(1.0, 0.99, -0.99), &found) && !inside(Vector3::new(1.0, 1.01, 0.0), &found));
        found.clear();
        cone(&Vector3::new(5.0, 5.0, 5.0), &corners, &mut found);
        assert_eq!(found.len(), 6);
        found.clear();
        cone(&Vector3::zeros(), &corners, &mut found);
        assert!(found.is_empty(), "from within there is no outline");
    }
}
