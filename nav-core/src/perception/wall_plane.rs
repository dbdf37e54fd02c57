//! A wall's plane from the stripes on it (section 4.2, equations 15 to 18), in the camera frame.
//!
//! Two ways. The paper's: two 3D lines, their cross product as the normal. And a joint fit of all points of both stripes,
//! because the cross product multiplies direction noise by the inverse sine of the angle between the lines (seventeen times
//! for INCRA I).
//!
//! The joint fit works in the image, where the noise is. Write the wall as m . p = 1, so m = k / d. A point seen along the ray
//! r = (x/z, y/z, 1) on the laser's plane n . p = o lies at p = r / s with s = n . r / o (equation 1), so it lies on the wall if
//!
//! m . r = n . r / o,
//!
//! which is linear in m. An error of one pixel across the stripe changes the two sides' difference by the same amount all
//! along a stripe, |(n / o - m)| across it over the focal length; with that as the weight, least squares over m is the
//! maximum-likelihood estimate for centres with equal, independent errors.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// A 3D line x = g + t h (equation 15).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line3 {
    /// A point of it.
    pub point: Point3<f64>,
    /// Its direction.
    pub direction: Vector3<f64>,
}

/// A plane k . x = d (equation 17) with unit normal pointing away from the camera, so that d > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPlane {
    /// Unit normal k.
    pub normal: Unit<Vector3<f64>>,
    /// Distance d from the frame's origin, in metres.
    pub distance_m: f64,
}

impl Line3 {
    /// The line through two points (equation 16: L: x = g + t h).
    pub fn through(a: Point3<f64>, b: Point3<f64>) -> Self {
        Self { point: a, direction: b - a }
    }
}

impl WallPlane {
    /// Equation 18, k = h1 x h2, and d by equation 16 in 17. The two lines never meet exactly in noise; d is the mean of both.
    ///
    /// `None` where the lines are parallel or the plane passes through the camera.
    pub fn from_lines(l1: &Line3, l2: &Line3) -> Option<Self> {
        let cross = l1.direction.normalize().cross(&l2.direction.normalize());
        let normal = Unit::try_new(cross, 1e-9)?;
        let distance = (normal.dot(&l1.point.coords) + normal.dot(&l2.point.coords)) / 2.0;
        Self::away_from_camera(normal, distance)
    }

    /// The plane m . p = 1.
    pub fn from_inverse(m: &Vector3<f64>) -> Option<Self> {
        let norm = m.norm();
        (norm > 1e-9 && norm.is_finite()).then(|| Self { normal: Unit::new_unchecked(m / norm), distance_m: 1.0 / norm })
    }

    fn away_from_camera(normal: Unit<Vector3<f64>>, distance_m: f64) -> Option<Self> {
        match distance_m {
            d if !d.is_finite() || d.abs() < 1e-9 => None,
            d if d > 0.0 => Some(Self { normal, distance_m }),
            d => Some(Self { normal: -normal, distance_m: -d }),
        }
    }
}

/// Normal equations of the joint fit.
#[derive(Clone, Copy, Debug)]
pub struct JointFit {
    information: Matrix3<f64>,
    right_side: Vector3<f64>,
}

impl Default for JointFit {
    fn default() -> Self {
        Self { information: Matrix3::zeros(), right_side: Vector3::zeros() }
    }
}

impl JointFit {
    /// Adds a point: its ray (x/z, y/z, 1), its inverse depth s = n . r / o, and a weight, the inverse of the standard deviation
    /// of m . r - s.
    pub fn add(&mut self, ray: &Vector3<f64>, inverse_depth: f64, weight: f64) {
        let weighted = ray * (weight * weight);
        self.information += weighted * ray.transpose();
        self.right_side += weighted * inverse_depth;
    }

    /// m of the plane m . p = 1; `None` where the points do not span a plane.
    pub fn solve(&self) -> Option<Vector3<f64>> {
        let scale = self.information.trace();
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        let m = (self.information / scale).cholesky()?.solve(&(self.right_side / scale));
        m.iter().all(|value| value.is_finite()).then_some(m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_give_back_the_plane_that_exact_lines_lie_on() {
        let normal = Unit::new_normalize(Vector3::new(0.9, 0.1, 0.4));
        let distance_m = 0.35;
        let lasers = [(Vector3::new(0.0, 0.99, 0.14), 0.06), (Vector3::new(0.05, -0.97, 0.2), 0.055)];
        let point = |n: &Vector3<f64>, o: f64, along: f64| {
            // A point of both planes, moved along their line of intersection.
            let direction = n.cross(&normal);
            let matrix = Matrix3::from_rows(&[n.transpose(), normal.transpose(), direction.transpose()]);
            let on_both = matrix.lu().solve(&Vector3::new(o, distance_m, 0.0)).expect("planes that meet");
            Point3::from(on_both + direction * along)
        };
        let lines = lasers.map(|(n, o)| Line3::through(point(&n, o, 0.3), point(&n, o, 0.9)));
        let crossed = WallPlane::from_lines(&lines[0], &lines[1]).expect("lines that cross");
        let mut fit = JointFit::default();
        for (n, o) in &lasers {
            for i in 0..20 {
                let p = point(n, *o, 0.2 + 0.05 * f64::from(i));
                let ray = p.coords / p.z;
                fit.add(&ray, n.dot(&ray) / o, 1.0);
            }
        }
        let joint = WallPlane::from_inverse(&fit.solve().expect("a plane")).expect("not at infinity");
        for plane in [crossed, joint] {
            assert!((plane.normal.into_inner() - normal.into_inner()).norm() < 1e-9, "{plane:?}");
            assert!((plane.distance_m - distance_m).abs() < 1e-9, "{plane:?}");
        }
    }
}
