//! A laser's light before it meets anything, and its image in a mirror.

use ductloop_duct::cell::Plane;
use ductloop_nav::rig::{LineWidth, Rig};
use nalgebra::{Point3, Unit, Vector3};

use crate::light::{CUT_SIGMAS, FAN_FADE_RAD, FWHM_PER_SIGMA, Fan};
use crate::optics::Optics;

/// A laser's light, in the camera's frame.
#[derive(Clone, Debug)]
pub(crate) struct Slit {
    pub(crate) source: Vector3<f64>,
    /// The laser's plane.
    pub(crate) plane: Plane,
    pub(crate) fan: Fan,
    pub(crate) line: LineWidth,
    /// Outward normals of the fan's two edges.
    pub(crate) bounds: [Vector3<f64>; 2],
    /// Half the thickness of the light at the source, and what it grows by with each metre along the fan.
    half_m: f64,
    growth: f64,
}

impl Slit {
    pub(crate) fn new(rig: &Rig, index: usize, optics: &Optics) -> Self {
        let laser = &rig.lasers[index];
        let fan = Fan::of(laser, optics.fan_profile);
        let (s, c) = libm::sincos(fan.reach_rad + FAN_FADE_RAD);
        let per_width = CUT_SIGMAS / FWHM_PER_SIGMA;
        Self {
            source: laser.source_in_camera.coords,
            plane: Plane { normal: laser.normal_in_camera, offset_m: laser.offset_m },
            fan,
            line: rig.line,
            bounds: [fan.across * c - fan.along * s, -fan.across * c - fan.along * s],
            half_m: per_width * rig.line.width_m,
            // Within the fan, distance from the source is at most the distance along its middle over the cosine of half its angle.
            growth: per_width * rig.line.growth_rad / c,
        }
    }

    /// How far outside the slit's light, the cut Gaussian that widens along the fan, a point is, on each of its two sides; not positive
    /// inside.
    pub(crate) fn outside(&self, point: &Point3<f64>) -> [f64; 2] {
        let way = point.coords - self.source;
        let (off, allowed) = (self.plane.normal.dot(&way), self.half_m + self.growth * self.fan.along.dot(&way));
        [off - allowed, -off - allowed]
    }

    /// Its image in a mirror.
    pub(crate) fn mirrored(&self, mirror: &Plane) -> Self {
        let way = |v: &Vector3<f64>| mirrored_way(v, mirror);
        let fan = Fan { along: way(&self.fan.along), across: way(&self.fan.across), ..self.fan };
        Self {
            source: mirrored_point(&Point3::from(self.source), mirror).coords,
            plane: mirrored_plane(&self.plane, mirror),
            fan,
            bounds: self.bounds.map(|bound| way(&bound)),
            ..*self
        }
    }

    /// The same with light that a lobe of this standard deviation, in radians, scatters to both sides.
    pub(crate) fn scattered(mut self, lobe_rad: f64) -> Self {
        let (_, c) = libm::sincos(self.fan.reach_rad + FAN_FADE_RAD);
        self.growth += CUT_SIGMAS * lobe_rad / c;
        self
    }
}

/// The mirror image of a direction.
pub(super) fn mirrored_way(v: &Vector3<f64>, mirror: &Plane) -> Vector3<f64> {
    let m = mirror.normal.into_inner();
    v - m * (2.0 * m.dot(v))
}

/// The mirror image of a point.
pub(super) fn mirrored_point(p: &Point3<f64>, mirror: &Plane) -> Point3<f64> {
    p - mirror.normal.into_inner() * (2.0 * mirror.distance(p))
}

/// The mirror image of a plane: n . X = o seen in m . X = d is n' . X = o - 2 d (m . n) with n' = n - 2 (m . n) m.
pub(super) fn mirrored_plane(plane: &Plane, mirror: &Plane) -> Plane {
    let cosine = mirror.normal.dot(&plane.normal);
    Plane {
        normal: Unit::new_unchecked(mirrored_way(&plane.normal, mirror)),
        offset_m: plane.offset_m - 2.0 * mirror.offset_m * cosine,
    }
}
