//! Pixels to rays through a lens that distorts, and back.
//!
//! [`Distortion`] has the formula (Brown 1971); this module evaluates it, with its derivatives, and inverts it by Newton's method.
//! Where the lens folds the image back on itself (beyond the radius at which r' has its maximum) there is no inverse; the result is
//! then whatever the last step gave, finite for finite input, and far from anything seen.

use nalgebra::{Matrix2, Vector2, Vector3};

use crate::rig::{Camera, Distortion};

/// A camera as a map between pixels (u, v) and rays (x/z, y/z, 1).
#[derive(Clone, Debug)]
pub struct Lens {
    focal_px: [f64; 2],
    centre_px: [f64; 2],
    distortion: Option<Distortion>,
}

/// Newton's steps: five reach rounding for any lens whose image does not fold.
const STEPS: usize = 8;
/// Steps shorter than this, as x/z, end the search.
const SETTLED: f64 = 1e-13;

impl Lens {
    /// The lens of a camera.
    pub fn new(camera: &Camera) -> Self {
        let distortion = (camera.distortion != Distortion::NONE).then_some(camera.distortion);
        Self { focal_px: camera.focal_px, centre_px: camera.centre_px, distortion }
    }

    /// Whether straight lines stay straight.
    pub fn is_pinhole(&self) -> bool {
        self.distortion.is_none()
    }

    /// Focal lengths along u and v, in pixels.
    pub fn focal_px(&self) -> [f64; 2] {
        self.focal_px
    }

    /// The ray (x/z, y/z, 1) that pixel (u, v) sees.
    pub fn ray(&self, u_px: f64, v_px: f64) -> Vector3<f64> {
        let seen = Vector2::new((u_px - self.centre_px[0]) / self.focal_px[0], (v_px - self.centre_px[1]) / self.focal_px[1]);
        let Some(distortion) = &self.distortion else { return seen.push(1.0) };
        let mut at = seen;
        for _ in 0..STEPS {
            let (bent, slope) = bend(distortion, at);
            let Some(inverse) = slope.try_inverse() else { break };
            let step = inverse * (seen - bent);
            // Half an image at most: a lens near its fold throws Newton far.
            let length = step.norm();
            at += if length > 0.5 { step * (0.5 / length) } else { step };
            if length < SETTLED {
                break;
            }
        }
        at.push(1.0)
    }

    /// The pixel (u, v) at which a ray is seen; `ray.z` must be positive.
    pub fn pixel(&self, ray: &Vector3<f64>) -> [f64; 2] {
        let at = Vector2::new(ray.x / ray.z, ray.y / ray.z);
        let seen = self.distortion.as_ref().map_or(at, |distortion| bend(distortion, at).0);
        [self.centre_px[0] + self.focal_px[0] * seen.x, self.centre_px[1] + self.focal_px[1] * seen.y]
    }

    /// How the ray changes by u and by v at the ray `ray`, a pixel each.
    pub fn ray_by_pixel(&self, ray: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let inverse = match &self.distortion {
            None => Matrix2::identity(),
            Some(distortion) => bend(distortion, Vector2::new(ray.x, ray.y)).1.try_inverse().unwrap_or_else(Matrix2::identity),
        };
        [0, 1].map(|axis| {
            let column = inverse.column(axis) / self.focal_px[axis];
            Vector3::new(column[0], column[1], 0.0)
        })
    }
}

/// Brown's formula at (x/z, y/z), and its derivatives.
fn bend(distortion: &Distortion, at: Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
    let Distortion { k1, k2, p1, p2, k3 } = *distortion;
    let (x, y) = (at.x, at.y);
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let by_r2 = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
    let bent = Vector2::new(
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    );
    let mixed = 2.0 * x * y * by_r2 + 2.0 * p1 * x + 2.0 * p2 * y;
    let slope = Matrix2::new(
        radial + 2.0 * x * x * by_r2 + 2.0 * p1 * y + 6.0 * p2 * x,
        mixed,
        mixed,
        radial + 2.0 * y * y * by_r2 + 6.0 * p1 * y + 2.0 * p2 * x,
    );
    (bent, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera(distortion: Distortion) -> Camera {
        Camera { width_px: 640, height_px: 480, focal_px: [514.41205, 685.92876], centre_px: [329.83671, 237.71471], distortion }
    }

    proptest! {
        /// Any moderate lens: ray and pixel are inverses, and the derivative is the difference quotient.
        #[test]
        fn there_and_back(
            k1 in -0.35..0.3f64, k2 in -0.05..0.15f64, p1 in -2e-3..2e-3f64, p2 in -2e-3..2e-3f64,
            u in -0.5..639.5f64, v in -0.5..479.5f64,
        ) {
            let lens = Lens::new(&camera(Distortion { k1, k2, p1, p2, k3: 0.0 }));
            let ray = lens.ray(u, v);
            let [back_u, back_v] = lens.pixel(&ray);
            prop_assert!((back_u - u).abs() < 1e-8 && (back_v - v).abs() < 1e-8, "{back_u} {back_v}");
            let [by_u, by_v] = lens.ray_by_pixel(&ray);
            let h = 1e-3;
            let (du, dv) = ((lens.ray(u + h, v) - lens.ray(u - h, v)) / (2.0 * h), (lens.ray(u, v + h) - lens.ray(u, v - h)) / (2.0 * h));
            // Central differences of a smooth function over a thousandth of a pixel: rounding is what remains.
            prop_assert!((by_u - du).norm() < 1e-9 && (by_v - dv).norm() < 1e-9, "{by_u} {du} {by_v} {dv}");
        }
    }

    /// What OpenCV 5.0.0 makes of the same lens: `undistortPoints`, iterated until it settles, and `projectPoints`.
    #[test]
    fn opencv_agrees() {
        let lens = Lens::new(&camera(Distortion { k1: -0.350373, k2: 0.158447, p1: 0.000735, p2: -0.000231, k3: 0.0 }));
        for (pixel, ray) in [
            ([0.0, 0.0], [-0.779596687648045, -0.422187669983236]),
            ([639.0, 479.0], [0.721863153097407, 0.421772744932293]),
            ([100.25, 400.5], [-0.491910901830187, 0.261360038868194]),
            ([620.0, 20.0], [0.664616370627201, -0.374394779729702]),
            ([333.3, 111.1], [0.00682483648905825, -0.186921455303409]),
        ] {
            let seen = lens.ray(pixel[0], pixel[1]);
            assert!((seen.x - ray[0]).abs() < 1e-11 && (seen.y - ray[1]).abs() < 1e-11, "{pixel:?}: {seen}");
        }
        let lens = Lens::new(&camera(Distortion { k1: 0.12, k2: -0.05, p1: 0.002, p2: -0.003, k3: 0.01 }));
        for (ray, pixel) in [
            ([0.3, -0.2], [485.83889833064654, 99.03679269106854]),
            ([-0.6, 0.4], [3.261372306441615, 528.0233791310643]),
            ([0.05, 0.55], [355.96453332821693, 628.2707904540406]),
        ] {
            let [u, v] = lens.pixel(&Vector3::new(ray[0], ray[1], 1.0));
            assert!((u - pixel[0]).abs() < 1e-10 && (v - pixel[1]).abs() < 1e-10, "{ray:?}: {u} {v}");
        }
    }

    /// Worked out by hand from the formula for x = 0.3, y = -0.2: r^2 = 0.13, radial = 1 + 0.013 + 0.000845 = 1.013845.
    #[test]
    fn the_formula_is_browns() {
        let lens = Lens::new(&camera(Distortion { k1: 0.1, k2: 0.05, p1: 0.01, p2: -0.02, k3: 0.0 }));
        let [u, v] = lens.pixel(&Vector3::new(0.3, -0.2, 1.0));
        let x = 0.3 * 1.013_845 + 2.0 * 0.01 * 0.3 * -0.2 - 0.02 * (0.13 + 2.0 * 0.09);
        let y = -0.2 * 1.013_845 + 0.01 * (0.13 + 2.0 * 0.04) + 2.0 * -0.02 * 0.3 * -0.2;
        assert!((u - (329.83671 + 514.41205 * x)).abs() < 1e-9 && (v - (237.71471 + 685.92876 * y)).abs() < 1e-9, "{u} {v}");
    }
}
