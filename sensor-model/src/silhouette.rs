//! The outline of a convex body as seen from a point: the planes through the point that just touch the body.

use nalgebra::{Point3, Vector3};

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
