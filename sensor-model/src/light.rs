//! Constants of the light model, derived once and used by every renderer.
//!
//! Light is counted in grey values (DN) above black at nominal exposure. On a point p of a wall with albedo `a`, met at an angle
//! of incidence `i` at the distance r from the laser's source and the signed distance d from its plane, a slit gives
//!
//! ```text
//! P / (r w(r)) * exp(-d^2 / (2 s^2)) * fan(angle) * cos(i) * a,   s = w(r) / 2.3548,   w = LineWidth::at
//! ```
//!
//! since the power of the slit spreads over r along the fan and over w(r) across it; the headlamp, a point at the camera, gives
//! `H / r^2 * cos(i) * a`. [`laser_strength`] is P and [`headlamp_strength`] is H.
//!
//! The width w(r) is linear in the distance (assumption): the waist and the spread simply add. A Gaussian beam with the same waist
//! w0 and the same spread far away is w0 sqrt(1 + (r / rR)^2), which is narrower everywhere between, by a factor sqrt(2) at
//! r = rR (0.5 m for a line of 2 mm + 4 mrad). A surface that is not matt has its reflectance B ([`crate::surface`]) in place of `a`.

use ductloop_nav::rig::{Laser, LineWidth};
use nalgebra::Vector3;

use crate::optics::{FanProfile, Optics, REFERENCE_ALBEDO, REFERENCE_M};

/// Full width at half maximum of a Gaussian over its standard deviation, 2 sqrt(2 ln 2).
pub const FWHM_PER_SIGMA: f64 = 2.354_820_045_030_949_3;

/// Where the Gaussian across a slit is cut, in standard deviations: 4e-5 of its peak, a hundredth of a grey value.
pub const CUT_SIGMAS: f64 = 4.5;

/// Width of the fan's edge, beyond `fan_rad / 2`, over which its light fades to nothing: half a degree (assumption).
pub const FAN_FADE_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// Widest fan, in degrees.
pub const FAN_MAX_DEG: f64 = 160.0;

/// Light is not followed through openings whose middle is farther away than this, in metres. With the default optics a stripe
/// met squarely there is 0.07 DN.
pub const RANGE_M: f64 = 25.0;

/// Half the number of taps of the point spread, without the middle one.
pub const PSF_RADIUS: usize = 3;

/// Widest standard deviation to which light without stripes is spread out of focus, in pixels: three of them are twelve taps.
pub const DEFOCUS_SIGMA_MAX_PX: f64 = 4.0;

/// P of the slits' formula, in DN m^2: [`Optics::stripe_peak_dn`] is reached at the reference.
pub fn laser_strength(optics: &Optics, line: &LineWidth) -> f64 {
    optics.stripe_peak_dn * REFERENCE_M * line.at(REFERENCE_M) / REFERENCE_ALBEDO
}

/// H of the headlamp's formula, in DN m^2.
pub fn headlamp_strength(optics: &Optics) -> f64 {
    optics.headlamp_peak_dn * REFERENCE_M * REFERENCE_M / REFERENCE_ALBEDO
}

/// Weights of the point spread at 0, 1, 2, 3 pixels from the middle, along rows and along columns alike: the Gaussian integrated
/// over each pixel, scaled so that all seven sum to one.
pub fn psf_taps(sigma_px: f64) -> [f64; PSF_RADIUS + 1] {
    if sigma_px == 0.0 {
        return [1.0, 0.0, 0.0, 0.0];
    }
    let below = |x_px: f64| 0.5 * libm::erfc(-x_px / (sigma_px * std::f64::consts::SQRT_2));
    let mut taps = [0.0; PSF_RADIUS + 1];
    for (i, tap) in taps.iter_mut().enumerate() {
        *tap = below(i as f64 + 0.5) - below(i as f64 - 0.5);
    }
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.map(|tap| tap / sum)
}

/// A fan of laser light, in the camera's axes: at an angle from its middle it has the share
/// `exp(exponent angle^2) * clamp(1 - (|angle| - reach) / FAN_FADE_RAD, 0, 1)` of the middle's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// Middle of the fan: the direction in the plane nearest to the line of sight.
    pub along: Vector3<f64>,
    /// The direction in the plane square to it.
    pub across: Vector3<f64>,
    /// Of the Gaussian along the fan, in 1/rad^2; not positive.
    pub exponent: f64,
    /// Angle from the middle at which the light begins to fade to nothing, in radians.
    pub reach_rad: f64,
}

impl Fan {
    /// The fan of a laser. A plane square to the line of sight, in which no direction is nearest, takes the camera's x.
    pub fn of(laser: &Laser, profile: FanProfile) -> Self {
        /// `fan_rad` is the width at 1/e^2. Beyond this many half angles a cylinder lens' Gaussian is below 0.3 % of its middle.
        const CYLINDER_REACH: f64 = 1.7;
        const REACH_MAX_RAD: f64 = FAN_MAX_DEG / 2.0 * std::f64::consts::PI / 180.0;
        let normal = laser.normal_in_camera.into_inner();
        let in_plane = |axis: Vector3<f64>| axis - normal * normal.dot(&axis);
        let along = in_plane(Vector3::z()).try_normalize(1e-6).unwrap_or_else(|| in_plane(Vector3::x()).normalize());
        let half_rad = laser.fan_rad / 2.0;
        let (edge_log, reach_rad) = match profile {
            FanProfile::Powell { edge } => (libm::log(edge), half_rad),
            FanProfile::Cylinder => (-2.0, (CYLINDER_REACH * half_rad).min(REACH_MAX_RAD)),
        };
        Self { along, across: normal.cross(&along), exponent: edge_log / (half_rad * half_rad), reach_rad }
    }

    /// Share of the middle's light at an angle from it, in radians.
    pub fn profile(&self, angle_rad: f64) -> f64 {
        let fade = (1.0 - (angle_rad.abs() - self.reach_rad) / FAN_FADE_RAD).clamp(0.0, 1.0);
        libm::exp(self.exponent * angle_rad * angle_rad) * fade
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Unit};

    use super::*;

    /// A Powell lens keeps the share that it is given at the fan's ends, a cylinder lens e^-2: there its Gaussian has fallen to 1/e^2,
    /// which is what the width of a laser's beam means.
    #[test]
    fn a_fans_ends_have_their_share_of_its_middle() {
        let laser = Laser {
            name: "slit".into(),
            normal_in_camera: Unit::new_normalize(Vector3::new(0.1, 1.0, -0.2)),
            offset_m: 0.0,
            source_in_camera: Point3::origin(),
            fan_rad: 1.2,
        };
        for (profile, share) in [(FanProfile::Powell { edge: 0.3 }, 0.3), (FanProfile::Cylinder, libm::exp(-2.0))] {
            let fan = Fan::of(&laser, profile);
            assert!((fan.profile(0.0) - 1.0).abs() < 1e-15 && fan.along.dot(&fan.across).abs() < 1e-15);
            for end_rad in [-0.6, 0.6] {
                assert!((fan.profile(end_rad) - share).abs() < 1e-12, "{profile:?}: {}", fan.profile(end_rad));
            }
        }
    }
}
