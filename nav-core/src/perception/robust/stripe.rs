//! Where a laser's stripe on a plane is in the image, and how thick.
//!
//! With the wall m . p = 1 and the laser's plane n . p = o, a ray r meets the wall at p = r / (m . r), off the laser's plane by
//!
//! d = n . p - o,  zero where l . r = 0,  l = n / o - m.
//!
//! So the middle of the stripe is the image of the line l . r = 0. A step across it by one pixel, r' = dr/dy, moves d by
//! z o (l . r') at the depth z = 1 / (m . r). The light is a Gaussian of standard deviation w across its plane; so the stripe is one
//! of standard deviation w / |z o (l . r')| down a column. Lens and pixel spread it square to itself; a stripe that runs at a slope
//! is crossed by a column at an angle, which stretches that spread.

use nalgebra::{Point3, Vector3};

use super::super::lens::Lens;
use super::super::scan::Across;
use crate::rig::{Laser, LineWidth, Rig};

/// What projection needs of a rig, in scan coordinates.
#[derive(Clone, Debug)]
pub(super) struct Projector {
    pub(super) across: Across,
    pub(super) lens: Lens,
    pub(super) lasers: Vec<Light>,
    line: LineWidth,
    /// Logarithm of the light at the fan's ends over that in its middle.
    log_edge: f64,
    /// Variance of what the lens and the pixel spread, in px^2.
    blur_px2: f64,
    /// Columns and rows in scan coordinates.
    pub(super) size: [usize; 2],
}

/// A laser's plane.
#[derive(Clone, Debug)]
pub(super) struct Light {
    /// n / o: a ray's inverse depth on the plane is its product with the ray.
    pub(super) inverse_plane: Vector3<f64>,
    offset_m: f64,
    source: Point3<f64>,
    /// Middle of the fan, and the direction of the plane square to it.
    middle: Vector3<f64>,
    sideways: Vector3<f64>,
    half_fan_rad: f64,
    cos_half_fan: f64,
}

/// A point on the middle of a stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StripePoint {
    /// Its row in scan coordinates.
    pub(super) y_px: f64,
    /// Its ray.
    pub(super) ray: Vector3<f64>,
    /// How l . r changes down the column, a pixel.
    pub(super) by_y: f64,
    /// Standard deviation of its light down the column, in pixels.
    pub(super) sigma_px: f64,
    /// Where it is, in the camera frame, in metres.
    pub(super) point: Point3<f64>,
}

/// 2 sqrt(2 ln 2).
const FWHM_PER_SIGMA: f64 = 2.354_820_045_030_949;
/// Variance of a pixel's square along any direction, in px^2.
const PIXEL_VARIANCE: f64 = 1.0 / 12.0;
/// A fan's light ends softly; beyond its nominal end by this it is no longer counted on, in radians.
const FAN_SLACK_RAD: f64 = 0.01;

impl Light {
    fn new(laser: &Laser) -> Self {
        let normal = laser.normal_in_camera.into_inner();
        let in_plane = |axis: Vector3<f64>| axis - normal * normal.dot(&axis);
        let middle = in_plane(Vector3::z()).try_normalize(1e-6).unwrap_or_else(|| in_plane(Vector3::x()).normalize());
        Self {
            inverse_plane: normal / laser.offset_m,
            offset_m: laser.offset_m,
            source: laser.source_in_camera,
            middle,
            sideways: normal.cross(&middle),
            half_fan_rad: laser.fan_rad / 2.0,
            cos_half_fan: libm::cos((laser.fan_rad / 2.0 + FAN_SLACK_RAD).min(std::f64::consts::PI)),
        }
    }

    /// Whether the fan reaches a point of its plane.
    fn reaches(&self, point: &Point3<f64>) -> bool {
        let way = point - self.source;
        way.dot(&self.middle) >= self.cos_half_fan * way.norm()
    }
}

impl Projector {
    pub(super) fn new(rig: &Rig, psf_sigma_px: f64, fan_edge: f64) -> Self {
        let across = Across::of(rig);
        let (width, height) = (rig.camera.width_px, rig.camera.height_px);
        Self {
            across,
            lens: Lens::new(&rig.camera),
            lasers: rig.lasers.iter().map(Light::new).collect(),
            line: rig.line,
            log_edge: libm::log(fan_edge),
            blur_px2: psf_sigma_px * psf_sigma_px + PIXEL_VARIANCE,
            size: match across {
                Across::V => [width, height],
                Across::U => [height, width],
            },
        }
    }

    /// The ray at scan coordinates.
    pub(super) fn ray(&self, x: f64, y: f64) -> Vector3<f64> {
        let [u, v] = self.across.pixel(x, y);
        self.lens.ray(u, v)
    }

    /// How a ray changes along the stripes and across them, a pixel each.
    pub(super) fn ray_by_scan(&self, ray: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let [by_u, by_v] = self.lens.ray_by_pixel(ray);
        match self.across {
            Across::V => [by_u, by_v],
            Across::U => [by_v, by_u],
        }
    }

    /// Row at which column `x` crosses the image line `l . r = 0`, and the ray there; `guess_px` is where the search begins (a
    /// pinhole needs none). `None` where the line runs down the column or is not met.
    pub(super) fn row_of_line(&self, l: &Vector3<f64>, x: f64, guess_px: f64) -> Option<(f64, Vector3<f64>, f64)> {
        let mut y = guess_px;
        let mut ray = self.ray(x, y);
        for _ in 0..if self.lens.is_pinhole() { 1 } else { 6 } {
            let by_y = l.dot(&self.ray_by_scan(&ray)[1]);
            if by_y.abs() < 1e-9 * l.norm() {
                return None;
            }
            let step = -l.dot(&ray) / by_y;
            y += step;
            if !y.is_finite() || y.abs() > 1e5 {
                return None;
            }
            ray = self.ray(x, y);
            if step.abs() < 1e-7 {
                break;
            }
        }
        let by_y = l.dot(&self.ray_by_scan(&ray)[1]);
        Some((y, ray, by_y))
    }

    /// The stripe of laser `laser` on the plane m . p = 1 in column `x`; `None` where there is none.
    pub(super) fn stripe(&self, laser: usize, m: &Vector3<f64>, x: f64, guess_px: f64) -> Option<StripePoint> {
        let light = &self.lasers[laser];
        let l = light.inverse_plane - m;
        let (y_px, ray, by_y) = self.row_of_line(&l, x, guess_px)?;
        let inverse_depth = m.dot(&ray);
        if inverse_depth < 1e-2 {
            return None;
        }
        let point = Point3::from(ray / inverse_depth);
        if !light.reaches(&point) {
            return None;
        }
        let sigma_px = self.sigma(light, &l, &ray, by_y, inverse_depth, &point)?;
        Some(StripePoint { y_px, ray, by_y, sigma_px, point })
    }

    fn sigma(
        &self,
        light: &Light,
        l: &Vector3<f64>,
        ray: &Vector3<f64>,
        by_y: f64,
        inverse_depth: f64,
        point: &Point3<f64>,
    ) -> Option<f64> {
        let width_m = self.line.at((point - light.source).norm()) / FWHM_PER_SIGMA;
        let off_by_y = light.offset_m.abs() * by_y.abs() / inverse_depth;
        if off_by_y < 1e-9 {
            return None;
        }
        let spread = width_m / off_by_y;
        let slope = l.dot(&self.ray_by_scan(ray)[0]) / by_y;
        let sigma = (spread * spread + self.blur_px2 * (1.0 + slope * slope)).sqrt();
        (sigma < 60.0).then_some(sigma)
    }

    /// Where in the camera frame scan coordinates (x, y) see the light of laser `laser`; `None` where its fan does not reach.
    pub(super) fn point(&self, laser: usize, x: f64, y: f64) -> Option<Point3<f64>> {
        let light = &self.lasers[laser];
        let ray = self.ray(x, y);
        let inverse_depth = light.inverse_plane.dot(&ray);
        let point = Point3::from(ray / inverse_depth);
        (inverse_depth > 1e-2 && light.reaches(&point)).then_some(point)
    }

    /// Standard deviation down the column that the stripe of laser `laser` at scan coordinates (x, y) would have on a surface that
    /// contains the direction across: the least it has on anything (a side wall, for slits that lie level). `None` where that laser
    /// cannot be seen between `range_m`.
    pub(super) fn upright_sigma(&self, laser: usize, x: f64, y: f64, range_m: [f64; 2]) -> Option<f64> {
        let light = &self.lasers[laser];
        let ray = self.ray(x, y);
        let inverse_depth = light.inverse_plane.dot(&ray);
        if !(inverse_depth * range_m[0] <= 1.0 && inverse_depth * range_m[1] >= 1.0) {
            return None;
        }
        let point = Point3::from(ray / inverse_depth);
        let by_y = light.inverse_plane.dot(&self.ray_by_scan(&ray)[1]);
        self.sigma(light, &light.inverse_plane, &ray, by_y, inverse_depth, &point)
    }
}

impl Projector {
    /// Logarithm of the light of laser `laser` on the matt wall m . p = 1 that scan coordinates (x, y) see, up to a constant: falling
    /// off with the distance along the fan and with its width across (both spread the light), toward the fan's ends, with the cosine of
    /// incidence, with the fourth power of the cosine of the view, and as a Gaussian across the laser's plane.
    pub(super) fn log_light(&self, laser: usize, m: &Vector3<f64>, x: f64, y: f64) -> f64 {
        let light = &self.lasers[laser];
        let ray = self.ray(x, y);
        let point = Point3::from(ray / m.dot(&ray));
        let way = point - light.source;
        let distance = way.norm();
        let width = self.line.at(distance);
        let off = light.offset_m * (light.inverse_plane.dot(&point.coords) - 1.0) * FWHM_PER_SIGMA / width;
        let incidence = (m.dot(&way) / distance).abs();
        let angle = libm::atan2(way.dot(&light.sideways), way.dot(&light.middle)) / light.half_fan_rad;
        libm::log(incidence / (distance * width)) + self.log_edge * angle * angle
            - 2.0 * libm::log(ray.norm_squared())
            - off * off / 2.0
    }
}
