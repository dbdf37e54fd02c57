//! Pixels to points in the camera frame (equation 1): s (x, y, z, 1) = T (u, v, 1).
//!
//! Equation 12 is T for a laser plane that contains the camera's y direction. For any plane n . p = d the same derivation
//! gives, with the ray r = K^-1 (u, v, 1) and the intersection p = r d / (n . r),
//!
//! T = [ K^-1 ; (n / d) K^-1 ],    s = n . r / d = 1 / z.
//!
//! (Equation 12 prints the sign of its u0 / (D k_u) wrongly; it follows from this form with a plus.)

use nalgebra::{Matrix3, Matrix4x3, Point3, Vector3, Vector4};

use crate::rig::{Camera, Laser};

/// The matrix T of one laser: 4 x 3, pixels to metres, scaled so that s = 1 / z.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulation {
    /// T itself.
    pub matrix: Matrix4x3<f64>,
}

/// K^-1: pixel (u, v, 1) to the ray (x / z, y / z, 1).
pub fn ray_from_pixel(camera: &Camera) -> Matrix3<f64> {
    let [fx, fy] = camera.focal_px;
    let [u0, v0] = camera.centre_px;
    Matrix3::new(1.0 / fx, 0.0, -u0 / fx, 0.0, 1.0 / fy, -v0 / fy, 0.0, 0.0, 1.0)
}

impl Triangulation {
    /// T from the geometry of a rig.
    pub fn from_rig(camera: &Camera, laser: &Laser) -> Self {
        let ray = ray_from_pixel(camera);
        let depth = (laser.normal_in_camera.into_inner() / laser.offset_m).transpose() * ray;
        let mut matrix = Matrix4x3::zeros();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&ray);
        matrix.fixed_view_mut::<1, 3>(3, 0).copy_from(&depth);
        Self { matrix }
    }

    /// Equation 1: the point in the camera frame that the stripe's pixel (u, v) shows, in the units of T.
    ///
    /// `None` where the ray runs along the laser's plane or meets it behind the camera.
    pub fn point(&self, u_px: f64, v_px: f64) -> Option<Point3<f64>> {
        let h: Vector4<f64> = self.matrix * Vector3::new(u_px, v_px, 1.0);
        (h.w > 1e-9).then(|| Point3::new(h.x / h.w, h.y / h.w, h.z / h.w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equation 10 in its own notation: laser plane z = (D + x) tan(theta), ideal camera with f = 1.
    #[test]
    fn the_general_matrix_is_equation_12_for_the_papers_geometry() {
        let (d, theta) = (0.08, 1.2_f64);
        let tan = libm::tan(theta);
        // z - x tan = D tan, as unit normal and offset:
        let normal = nalgebra::Unit::new_normalize(Vector3::new(-tan, 0.0, 1.0));
        let norm = (1.0 + tan * tan).sqrt();
        let laser = Laser {
            name: "slit".into(),
            normal_in_camera: normal,
            offset_m: d * tan / norm,
            source_in_camera: Point3::new(-d, 0.0, 0.0),
            fan_rad: 1.0,
        };
        let (f, u0, v0) = (1000.0, 321.0, 239.0);
        let distortion = crate::rig::Distortion::NONE;
        let camera = Camera { width_px: 640, height_px: 480, focal_px: [f, f], centre_px: [u0, v0], distortion };
        let t = Triangulation::from_rig(&camera, &laser).matrix;
        // Equation 12 with k_u = f (pixels a unit of the image plane at f = 1), its last row's sign mended.
        let expected = [-1.0 / (d * f), 0.0, u0 / (d * f) + 1.0 / (d * tan)];
        for (column, value) in expected.iter().enumerate() {
            assert!((t[(3, column)] - value).abs() < 1e-9, "t4{}: {} {}", column + 1, t[(3, column)], value);
        }
        // Equations 7 to 9 for one pixel.
        let (x_image, y_image) = (0.1, -0.05);
        let point = Triangulation { matrix: t }.point(u0 + f * x_image, v0 + f * y_image).expect("in front of the camera");
        let z = d * tan / (1.0 - x_image * tan);
        assert!((point - Point3::new(x_image * z, y_image * z, z)).norm() < 1e-12);
    }
}
