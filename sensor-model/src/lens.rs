//! Where in the image a direction is seen, and back: pinhole and distortion after Brown and Conrady.
//!
//! This is the renderers' own code; the navigator has another, and both share nothing but the camera's parameters.

use ductloop_nav::rig::{Camera, Distortion};
use nalgebra::{Matrix2, Point3, Vector2};

use crate::renderer::RenderError;

/// Pixels and rays of a camera. A ray is (x, y), the direction (x, y, 1) in the camera frame; a pixel is (u, v).
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// The camera.
    pub camera: Camera,
}

impl Projection {
    /// The projection of a camera whose distortion can be undone all over the image, a margin of `margin_px` about it included.
    ///
    /// # Errors
    /// [`RenderError::Distortion`] where a pixel has no ray, or more than one: the distortion folds the image.
    pub fn new(camera: &Camera, margin_px: f64) -> Result<Self, RenderError> {
        let projection = Self { camera: camera.clone() };
        let last = [camera.width_px, camera.height_px].map(|n| n as f64 - 1.0 + margin_px);
        /// Places along each border that are looked at.
        const STEPS: usize = 32;
        for i in 0..=STEPS {
            let along = |axis: usize| -margin_px + (last[axis] + margin_px) * i as f64 / STEPS as f64;
            for pixel in [[along(0), -margin_px], [along(0), last[1]], [-margin_px, along(1)], [last[0], along(1)]] {
                if !projection.is_sound_up_to(pixel) {
                    return Err(RenderError::Distortion { u_px: pixel[0], v_px: pixel[1] });
                }
            }
        }
        Ok(projection)
    }

    /// Whether the distortion is bent nowhere too far on the way from the middle to a pixel's ray.
    fn is_sound_up_to(&self, pixel: [f64; 2]) -> bool {
        let ray = self.ray(pixel);
        let back = self.pixel(ray);
        let found = (back[0] - pixel[0]).abs().max((back[1] - pixel[1]).abs()) < 1e-6;
        found
            && (0..=16).all(|i| {
                let share = f64::from(i) / 16.0;
                let slope = self.pixels_per_ray([ray[0] * share, ray[1] * share]);
                let [fx, fy] = self.camera.focal_px;
                slope.determinant() > 0.05 * fx * fy && slope.m11 > 0.0
            })
    }

    /// Whether straight lines stay straight.
    pub fn is_pinhole(&self) -> bool {
        self.camera.distortion == Distortion::NONE
    }

    /// Pixel at which a ray is seen.
    pub fn pixel(&self, ray: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.distorted(ray);
        let Camera { focal_px, centre_px, .. } = &self.camera;
        [focal_px[0] * x + centre_px[0], focal_px[1] * y + centre_px[1]]
    }

    /// Pixel at which a point of the camera frame with positive z is seen.
    pub fn pixel_of(&self, point: &Point3<f64>) -> [f64; 2] {
        self.pixel([point.x / point.z, point.y / point.z])
    }

    /// Ray that is seen at a pixel, by Newton's method from the pinhole's.
    pub fn ray(&self, pixel: [f64; 2]) -> [f64; 2] {
        let Camera { focal_px, centre_px, .. } = &self.camera;
        let sought = Vector2::new((pixel[0] - centre_px[0]) / focal_px[0], (pixel[1] - centre_px[1]) / focal_px[1]);
        if self.is_pinhole() {
            return sought.into();
        }
        let mut ray = sought;
        // Quadratic convergence: a handful of steps ends in rounding; a distortion that folds does not converge and is refused.
        for _ in 0..20 {
            let miss = Vector2::from(self.distorted(ray.into())) - sought;
            let Some(inverse) = self.slope(ray.into()).try_inverse() else { break };
            let step = inverse * miss;
            ray -= step;
            if step.norm() < 1e-15 {
                break;
            }
        }
        ray.into()
    }

    /// Derivative of the pixel by the ray, d(u, v) / d(x, y), in pixels.
    pub fn pixels_per_ray(&self, ray: [f64; 2]) -> Matrix2<f64> {
        let slope = self.slope(ray);
        let [fx, fy] = self.camera.focal_px;
        Matrix2::new(fx * slope.m11, fx * slope.m12, fy * slope.m21, fy * slope.m22)
    }

    /// Derivative of the ray by the pixel, d(x, y) / d(u, v): the inverse of [`Self::pixels_per_ray`].
    pub fn rays_per_pixel(&self, ray: [f64; 2]) -> Matrix2<f64> {
        let m = self.pixels_per_ray(ray);
        let determinant = m.m11 * m.m22 - m.m12 * m.m21;
        Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / determinant
    }

    fn distorted(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Distortion { k1, k2, p1, p2, k3 } = self.camera.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        [x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y]
    }

    /// Derivative of the distorted ray by the ray.
    fn slope(&self, [x, y]: [f64; 2]) -> Matrix2<f64> {
        let Distortion { k1, k2, p1, p2, k3 } = self.camera.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        // d radial / d r2
        let bend = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let mixed = 2.0 * x * y * bend + 2.0 * p1 * x + 2.0 * p2 * y;
        Matrix2::new(
            radial + 2.0 * x * x * bend + 2.0 * p1 * y + 6.0 * p2 * x,
            mixed,
            mixed,
            radial + 2.0 * y * y * bend + 6.0 * p1 * y + 2.0 * p2 * x,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(distortion: Distortion) -> Camera {
        Camera { width_px: 640, height_px: 480, focal_px: [378.4, 380.0], centre_px: [319.5, 239.5], distortion }
    }

    /// Against what `cv2.projectPoints` of OpenCV 5.0.0 (opencv-python-headless) gave for these numbers.
    #[test]
    fn points_are_seen_where_opencv_sees_them() {
        let bent = Distortion { k1: -0.28, k2: 0.07, p1: 0.001, p2: -0.0005, k3: -0.008 };
        let projection = Projection { camera: camera(bent) };
        for (point_m, pixel) in [
            ([0.5, -0.3, 1.0], [491.8872278656, 135.72075724799998]),
            ([-0.7, 0.45, 1.0], [97.23738055663, 383.165835494625]),
            ([0.02, 0.6, 1.0], [326.3110159285088, 446.88568650581607]),
            ([-1.2, -1.0, 2.0], [125.71239524992006, 77.65588112]),
            ([0.9, 0.1, 1.5], [525.2198824817988, 262.6005976041994]),
            ([0.0, 0.0, 1.0], [319.5, 239.5]),
        ] {
            let [u, v] = projection.pixel_of(&Point3::from(point_m));
            assert!((u - pixel[0]).abs() < 1e-9 && (v - pixel[1]).abs() < 1e-9, "{point_m:?}: {u} {v}");
        }
    }

    #[test]
    fn rays_and_pixels_undo_each_other_and_slopes_are_slopes() {
        let bent = Distortion { k1: -0.18, k2: 0.04, p1: 0.001, p2: -0.0005, k3: -0.002 };
        let projection = Projection::new(&camera(bent), 4.0).expect("a usual lens");
        for pixel in [[-3.0, -3.0], [320.0, 240.0], [642.0, 100.0], [10.5, 481.0]] {
            let ray = projection.ray(pixel);
            let back = projection.pixel(ray);
            assert!((back[0] - pixel[0]).abs() + (back[1] - pixel[1]).abs() < 1e-9);
            let product = projection.pixels_per_ray(ray) * projection.rays_per_pixel(ray);
            assert!((product - Matrix2::identity()).norm() < 1e-12);
            const STEP: f64 = 1e-6;
            let slope = projection.pixels_per_ray(ray);
            for axis in 0..2 {
                let at = |step: f64| projection.pixel([0, 1].map(|i| ray[i] + if i == axis { step } else { 0.0 }));
                let (ahead, behind) = (at(STEP), at(-STEP));
                for i in 0..2 {
                    let difference = (ahead[i] - behind[i]) / (2.0 * STEP);
                    assert!((difference - slope[(i, axis)]).abs() < 1e-4, "{pixel:?}: {difference} for {slope}");
                }
            }
        }
    }

    #[test]
    fn a_lens_that_folds_the_image_is_refused() {
        let folded = Distortion { k1: -0.9, ..Distortion::NONE };
        assert!(matches!(Projection::new(&camera(folded), 4.0), Err(RenderError::Distortion { .. })));
    }
}
