//! One bounce: the lasers' stripes, as lines that light up the walls about them.
//!
//! On a sheet, a laser's stripe is a straight line; h is its distance from the source, l the way along it from the point nearest to
//! the source. Across the line the stripe's light adds up, whatever its width and slant, to
//!
//! ```text
//! lambda(l) = P sqrt(2 pi) / 2.3548 * fan(angle) * h / (h^2 + l^2)                 DN m, for P of light.rs
//! ```
//!
//! (the integral of its Gaussian over the sheet, `P / (r w) cos(i) * sqrt(2 pi) w / 2.3548 / sin(psi)`, psi between the planes, with
//! cos(i) = sin(psi) h / r), so that the stripes of a laser have together P sqrt(2 pi) / 2.3548 times the integral of fan over the
//! angle, wherever they fall. The sheet scatters albedo times that evenly: on a point x with normal m it gives the irradiance
//!
//! ```text
//! E = albedo / pi * integral of lambda cos cos / r^2 dl = albedo (n.w) / pi * integral of lambda (a + b s) / (d^2 + s^2)^2 ds
//! ```
//!
//! with n the sheet's normal, w from the foot on the line to x, d = |w|, s along the line from the foot, a = -m.w and b = m.t along the
//! line's direction t. lambda is interpolated linearly between knots, as close as lambda bends; the integral is then exact
//! ([`crate::line_light`]). Near the line it would grow without bound, where a stripe of the width that it has does not: d^2 is taken
//! as |w|^2 plus the variance of the stripe's light across its line on the sheet.
//!
//! Left out: what surfaces mirror (that is a ghost), what comes back from bodies, and the shadows of bodies in this light; a body's own
//! surface is lit. Light met more than [`REACH_M`] from the source, and lines that give a piece of wall less than [`FAINT_DN`] each.

use std::ops::Range;

use ductloop_duct::cell::CellId;
use ductloop_nav::rig::{LineWidth, Rig};
use nalgebra::{Point3, Translation3, Vector3};

use crate::Transform;
use crate::beam::{Beam, Sight};
use crate::light::{FAN_FADE_RAD, FWHM_PER_SIGMA, Fan, laser_strength};
use crate::optics::Optics;
use crate::renderer::MAX_LASERS;
use crate::scenery::Scenery;
use crate::strip::SQRT_TAU;

/// Stripes are followed so far from their source, in metres: there a stripe along a wall 0.25 m beside the source has 1/250 of the
/// light that it has at its brightest.
pub(crate) const REACH_M: f64 = 4.0;

/// Lines that can give no point of a piece of wall more than this are passed over for it, in DN before its own albedo.
pub(crate) const FAINT_DN: f64 = 2e-3;

/// Distance of knots along a line, as a difference of asinh(l / h): lambda between them is right to 1.2 % of its largest value.
const KNOT_STEP: f64 = 0.22;

/// The lasers of a rig and their stripes in a frame. Kept from frame to frame for its memory.
#[derive(Debug)]
pub(crate) struct Bounce {
    lasers: Vec<Emitter>,
    beam: Beam,
    /// The frame's stripes.
    pub(crate) lines: Vec<Line>,
    /// Their knots.
    pub(crate) knots: Vec<Knot>,
}

/// A laser.
#[derive(Debug)]
struct Emitter {
    source: Vector3<f64>,
    normal: Vector3<f64>,
    fan: Fan,
    line: LineWidth,
    /// Outward normals of the fan's two edges, where its light has faded to a half.
    bounds: [Vector3<f64>; 2],
    /// P sqrt(2 pi) / 2.3548, in DN m^2.
    strength: f64,
}

/// A stripe on a sheet, in the camera's frame.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Its two ends.
    pub(crate) ends: [Point3<f64>; 2],
    /// Unit direction from the first to the second.
    pub(crate) along: Vector3<f64>,
    /// Unit normal of the sheet, into the duct.
    pub(crate) normal: Vector3<f64>,
    /// The sheet's cell.
    pub(crate) cell: CellId,
    /// Variance of the light across the line on the sheet, in square metres.
    pub(crate) width_m2: f64,
    /// albedo / pi times the integral of lambda, in DN m^2.
    pub(crate) power: f64,
    /// In [`Bounce::knots`].
    pub(crate) knots: Range<usize>,
}

/// A place on a line where its brightness is given; in between it is linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    /// Way from the line's first end, in metres.
    pub(crate) at_m: f32,
    /// albedo / pi * lambda, in DN m.
    pub(crate) light: f32,
    /// The slope before less the slope after, each 0 outside the line, in DN.
    pub(crate) bend: f32,
}

impl Bounce {
    /// For the lasers of a rig.
    pub(crate) fn new(rig: &Rig, optics: &Optics) -> Self {
        let emitter = |laser| {
            let fan = Fan::of(laser, optics.fan_profile);
            let (s, c) = libm::sincos(fan.reach_rad + FAN_FADE_RAD / 2.0);
            Emitter {
                source: laser.source_in_camera.coords,
                normal: laser.normal_in_camera.into_inner(),
                fan,
                line: rig.line,
                bounds: [fan.across * c - fan.along * s, -fan.across * c - fan.along * s],
                strength: laser_strength(optics, &rig.line) * SQRT_TAU / FWHM_PER_SIGMA,
            }
        };
        Self { lasers: rig.lasers.iter().map(emitter).collect(), beam: Beam::default(), lines: Vec::new(), knots: Vec::new() }
    }

    /// Finds the frame's stripes, seen by the camera or not; the camera stands in `cell`.
    pub(crate) fn find(
        &mut self,
        scenery: &Scenery,
        camera_from_world: &Transform,
        cell: CellId,
        laser_power: &[f64; MAX_LASERS],
    ) {
        self.lines.clear();
        self.knots.clear();
        let world_from_camera = camera_from_world.inverse();
        for (emitter, power) in self.lasers.iter().zip(laser_power) {
            let source_in_world = world_from_camera * Point3::from(emitter.source);
            if *power > 0.0
                && let Some(source_cell) = scenery.cell_at(&source_in_world, cell)
            {
                let source_from_world = Translation3::from(-emitter.source) * camera_from_world;
                let (lines, knots) = (&mut self.lines, &mut self.knots);
                self.beam.trace(scenery, &source_from_world, source_cell, &emitter.bounds, REACH_M, &mut |sight| {
                    emitter.add_line(scenery, &source_from_world, sight, *power, lines, knots);
                });
            }
        }
    }
}

impl Emitter {
    /// Adds the stripe on a lit piece of a sheet; `sight` is in the camera's axes, seen from the source.
    fn add_line(
        &self,
        scenery: &Scenery,
        source_from_world: &Transform,
        sight: &Sight,
        power: f64,
        lines: &mut Vec<Line>,
        knots: &mut Vec<Knot>,
    ) {
        /// No laser is nearer to a wall than half its housing, in metres.
        const NEAR_MIN_M: f64 = 5e-3;
        /// Squared sine of the angle between plane and sheet below which their line is rounding.
        const PARALLEL: f64 = 1e-6;
        let albedo = scenery.look(sight.sheet).albedo;
        let plane = sight.sheet.plane.transformed(source_from_world);
        let away = plane.normal.into_inner();
        let cosine = away.dot(&self.normal);
        let slant2 = 1.0 - cosine * cosine;
        if albedo == 0.0 || sight.sheet.body.is_some() || slant2 < PARALLEL {
            return;
        }
        let along = away.cross(&self.normal) / slant2.sqrt();
        // The point of the line nearest to the source, and its distance.
        let foot = (away - self.normal * cosine) * (plane.offset_m / slant2);
        let near_m = (plane.offset_m / slant2.sqrt()).max(NEAR_MIN_M);
        if near_m >= REACH_M {
            return;
        }
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, a) in sight.outline.iter().enumerate() {
            let b = &sight.outline[(i + 1) % sight.outline.len()];
            let (off_a, off_b) = (self.normal.dot(&a.coords), self.normal.dot(&b.coords));
            if (off_a < 0.0) != (off_b < 0.0) {
                let at = (a + (b - a) * (off_a / (off_a - off_b))).coords.dot(&along);
                (from, to) = (from.min(at), to.max(at));
            }
        }
        let reach_m = (REACH_M * REACH_M - near_m * near_m).sqrt();
        (from, to) = (from.max(-reach_m), to.min(reach_m));
        // A nanometre of line gives no light and has no direction.
        if to - from < 1e-9 {
            return;
        }
        let first = knots.len();
        let emitted = self.add_knots(&foot, &along, near_m, [from, to], power * albedo / std::f64::consts::PI, knots);
        let end = |at: f64| Point3::from(self.source + foot + along * at);
        let sigma_m = self.line.at(near_m) / FWHM_PER_SIGMA;
        lines.push(Line {
            ends: [end(from), end(to)],
            along,
            normal: -away,
            cell: sight.sheet.cell,
            width_m2: sigma_m * sigma_m / slant2,
            power: emitted,
            knots: first..knots.len(),
        });
    }

    /// Adds the knots of the line `foot + along l`, l within a range, for light times `scale`; returns the integral of the light.
    fn add_knots(
        &self,
        foot: &Vector3<f64>,
        along: &Vector3<f64>,
        near_m: f64,
        [from, to]: [f64; 2],
        scale: f64,
        knots: &mut Vec<Knot>,
    ) -> f64 {
        let fan = |l: f64| {
            let way = foot + along * l;
            let angle = libm::atan2(self.fan.across.dot(&way), self.fan.along.dot(&way));
            libm::exp(self.fan.exponent * angle * angle)
        };
        let (low, high) = (libm::asinh(from / near_m), libm::asinh(to / near_m));
        let steps = ((high - low) / KNOT_STEP).ceil().max(1.0);
        let place = |i: f64| near_m * libm::sinh(low + (high - low) * (i / steps));
        let scale = scale * self.strength;
        let first = knots.len();
        let (mut emitted, mut linear) = (0.0, 0.0);
        let mut before = (0.0, 0.0);
        for i in 0..=steps as usize {
            let l = place(i as f64);
            let light = scale * fan(l) * near_m / (near_m * near_m + l * l);
            if i > 0 {
                // The fan over the angle between the two places, by Simpson's rule.
                let span = libm::atan(l / near_m) - libm::atan(before.0 / near_m);
                let middle = near_m * libm::tan((libm::atan(l / near_m) + libm::atan(before.0 / near_m)) / 2.0);
                emitted += scale * span * (fan(before.0) + 4.0 * fan(middle) + fan(l)) / 6.0;
                linear += (l - before.0) * (light + before.1) / 2.0;
            }
            knots.push(Knot { at_m: (l - from) as f32, light: light as f32, bend: 0.0 });
            before = (l, light);
        }
        // The straight pieces hold a little more light than what they stand for, which bends: all of it is scaled back.
        let exact = if linear > 0.0 { (emitted / linear) as f32 } else { 0.0 };
        let knots = &mut knots[first..];
        knots.iter_mut().for_each(|knot| knot.light *= exact);
        let mut slope_before = 0.0;
        for i in 0..knots.len() {
            let slope = knots.get(i + 1).map_or(0.0, |next| (next.light - knots[i].light) / (next.at_m - knots[i].at_m));
            knots[i].bend = slope_before - slope;
            slope_before = slope;
        }
        emitted
    }
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::SurfaceId;
    use ductloop_duct::fitting::{Fitting, Shape};
    use ductloop_duct::network::{End, Network};
    use ductloop_nav::rig::{Camera, Distortion, Laser, Mount, MountAngles};
    use nalgebra::Unit;

    use super::*;
    use crate::optics::FanProfile;
    use crate::surface::Look;

    fn rig(source: [f64; 3], normal: [f64; 3]) -> Rig {
        let (source_in_camera, normal) = (Point3::from(source), Unit::new_normalize(Vector3::from(normal)));
        Rig {
            camera: Camera {
                width_px: 640,
                height_px: 480,
                focal_px: [400.0; 2],
                centre_px: [319.5, 239.5],
                distortion: Distortion::NONE,
            },
            mount: Mount { position_in_base_m: Point3::origin(), roll_rad: 0.0, rest: MountAngles::default() },
            lasers: vec![Laser {
                name: "slit".into(),
                normal_in_camera: normal,
                offset_m: normal.dot(&source_in_camera.coords),
                source_in_camera,
                fan_rad: 1.8,
            }],
            line: LineWidth { width_m: 2e-3, growth_rad: 4e-3 },
        }
    }

    /// In a closed box all light of a fan falls on walls: together the stripes scatter albedo times its power, however it falls.
    #[test]
    fn the_stripes_hold_all_the_light_of_the_laser() {
        let piece = Fitting { shape: Shape::Straight { length_m: 1.5 }, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) };
        let network = Network::from_run(&[piece, piece], End::Cap, End::Cap).unwrap();
        let scenery = Scenery::new(&network, &[Look::matt(0.6)]).unwrap();
        // Looking along the duct from (0.8, 0.05, 0.12).
        let rest = MountAngles { pan_rad: 0.1, tilt_rad: -0.05 };
        let mount = Mount { position_in_base_m: Point3::new(0.8, 0.05, 0.12), roll_rad: 0.3, rest };
        let camera_from_world = mount.base_from_camera(rest).inverse();
        for fan_profile in [FanProfile::Powell { edge: 0.3 }, FanProfile::Cylinder] {
            for normal in [[-0.03, 0.99, 0.1], [0.9, 0.2, -0.3]] {
                let rig = rig([0.01, 0.06, 0.0], normal);
                let optics = Optics { fan_profile, ..Optics::default() };
                let mut bounce = Bounce::new(&rig, &optics);
                bounce.find(&scenery, &camera_from_world, 0, &[0.5; MAX_LASERS]);
                // The fan's integral by many steps, the fade at its ends included; 0.3456 DN m^2 is P of the default optics.
                let fan = Fan::of(&rig.lasers[0], fan_profile);
                let integral: f64 = (0..200_000).map(|i| fan.profile(-1.6 + f64::from(i) * 1.6e-5) * 1.6e-5).sum();
                let expected = 0.5 * 0.3456 * SQRT_TAU / FWHM_PER_SIGMA * integral * 0.6 / std::f64::consts::PI;
                let powers: f64 = bounce.lines.iter().map(|line| line.power).sum();
                // Simpson's rule over steps of a fifth of a radian, and the fade taken as a sharp edge in its middle.
                assert!((powers / expected - 1.0).abs() < 1e-4, "{powers} against {expected}");
                // And so do the straight pieces between the knots.
                let between = |line: &Line| {
                    let knots = bounce.knots[line.knots.clone()].windows(2);
                    knots.map(|k| f64::from((k[1].at_m - k[0].at_m) * (k[0].light + k[1].light) / 2.0)).sum::<f64>()
                };
                let linear: f64 = bounce.lines.iter().map(between).sum();
                assert!((linear / expected - 1.0).abs() < 1e-4, "{linear} against {expected}");
            }
        }
    }

    /// On a sheet that the light meets aslant a stripe is thicker than across its own plane: by one over the sine of the angle between.
    #[test]
    fn a_stripe_is_as_thick_as_its_light_on_the_sheet() {
        let piece = Fitting { shape: Shape::Straight { length_m: 1.5 }, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) };
        let network = Network::from_run(&[piece], End::Cap, End::Cap).unwrap();
        let scenery = Scenery::new(&network, &[Look::matt(0.6)]).unwrap();
        let rest = MountAngles { pan_rad: 0.1, tilt_rad: -0.05 };
        let mount = Mount { position_in_base_m: Point3::new(0.3, 0.05, 0.12), roll_rad: 0.3, rest };
        let rig = rig([0.01, 0.06, 0.0], [-0.5, 0.7, 0.4]);
        let mut bounce = Bounce::new(&rig, &Optics::default());
        bounce.find(&scenery, &mount.base_from_camera(rest).inverse(), 0, &[1.0; MAX_LASERS]);
        let laser = &rig.lasers[0];
        let mut slants = Vec::new();
        for line in &bounce.lines {
            // A step on the sheet square to the line, and how far it leads off the laser's plane.
            let across = line.normal.cross(&line.along);
            let off = laser.normal_in_camera.dot(&across).abs();
            let way = laser.source_in_camera - line.ends[0];
            let near_m = (way - line.along * way.dot(&line.along)).norm();
            let sigma_m = rig.line.at(near_m) / FWHM_PER_SIGMA / off;
            assert!((line.width_m2 / (sigma_m * sigma_m) - 1.0).abs() < 1e-9, "{} m^2 for {sigma_m} m", line.width_m2);
            slants.push(off);
        }
        assert!(slants.iter().any(|off| *off < 0.8), "some are met aslant: {slants:?}");
    }
}
