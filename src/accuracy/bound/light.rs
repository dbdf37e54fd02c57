//! The profile that a stripe truly has in a column: the sensor model's equations (`docs/sensor-model.md`, sections 1, 2, 4 and 5) at
//! one point of it.

use ductloop_nav::rig::Laser;
use ductloop_sensor::light::{FWHM_PER_SIGMA, Fan, headlamp_strength, laser_strength};
use ductloop_sensor::optics::Optics;
use ductloop_sensor::surface::Look;
use nalgebra::Vector3;

use super::column::Stripe;
use crate::scenario::{Scenario, Surface};
use crate::stage_scores::{Scan, StageTruth, TrueCentre, TruthScene};

/// What shines at an exposure.
pub struct Light<'a> {
    scene: &'a TruthScene,
    optics: &'a Optics,
    surfaces: &'a [Surface],
    fans: Vec<Fan>,
    powers: Vec<f64>,
    /// Exposure over the nominal one.
    exposure: f64,
}

impl<'a> Light<'a> {
    /// Of a scenario, its lasers at these shares of nominal power.
    pub fn new(scenario: &'a Scenario, scene: &'a TruthScene, laser_power: &[f64]) -> Self {
        let optics = &scenario.optics;
        let lasers = &scene.rig().lasers;
        Self {
            scene,
            optics,
            surfaces: &scenario.surfaces,
            fans: lasers.iter().map(|laser| Fan::of(laser, optics.fan_profile)).collect(),
            powers: (0..lasers.len()).map(|i| laser_power.get(i).copied().unwrap_or(1.0)).collect(),
            exposure: scenario.first_exposure_s() / optics.exposure_s,
        }
    }

    /// The stripe at a true centre; `None` where it is dark.
    pub fn stripe(&self, truth: &StageTruth, centre: &TrueCentre) -> Option<Stripe> {
        let rig = self.scene.rig();
        let laser = &rig.lasers[centre.laser];
        let plane = &truth.planes[centre.plane];
        let look = &self.surfaces.get(usize::from(plane.surface.0))?.look;
        let [x, y] = self.scene.projection().ray(centre.pixel());
        let ray = Vector3::new(x, y, 1.0);
        let (n, o) = (plane.normal_in_camera.into_inner(), plane.camera_distance_m);
        let point = ray * (o / n.dot(&ray));
        let cos4 = if self.optics.lens.vignetting { 1.0 / (ray.norm_squared() * ray.norm_squared()) } else { 1.0 };

        // Across the stripe: how far a pixel moves from the laser's plane.
        let g = laser.normal_in_camera.into_inner() * o - n * laser.offset_m;
        let by_pixel = self.scene.projection().rays_per_pixel([x, y]).transpose() * (g / n.dot(&ray)).xy();
        let metres_per_px = by_pixel.norm();
        let across = by_pixel / metres_per_px;
        let cosine = if centre.scan == Scan::Column { across.y } else { across.x }.abs();
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();

        let way = point - laser.source_in_camera.coords;
        let width_m = rig.line.at(way.norm());
        let ridge_px = width_m / FWHM_PER_SIGMA / metres_per_px;
        let spread_px = self.spread_px(point.z);
        let shorter_px = cosine.min(sine);
        let sigma_px = (ridge_px * ridge_px + spread_px * spread_px + shorter_px * shorter_px / 12.0).sqrt();

        let amplitude_dn = self.amplitude_dn(centre.laser, laser, &point, &n, &way, width_m, look) * cos4 * self.exposure;
        let headlamp = headlamp_strength(self.optics) * self.even(&n, &ray, o, look) * cos4 * self.exposure;
        let light_dn_px = amplitude_dn * (2.0 * std::f64::consts::PI).sqrt() * ridge_px;
        (light_dn_px > 0.0).then_some(Stripe { centre_px: centre.at_px, light_dn_px, sigma_px, cosine, background_dn: headlamp })
    }

    /// Standard deviation of what the lens spreads: point spread and defocus (section 1), in pixels.
    fn spread_px(&self, depth_m: f64) -> f64 {
        let lens = &self.optics.lens;
        let focal_px = self.scene.rig().camera.focal_px[0];
        let disc_px = lens.aperture_m * focal_px / 4.0 * (1.0 / depth_m - 1.0 / lens.focus_m);
        (lens.psf_sigma_px * lens.psf_sigma_px + disc_px * disc_px).sqrt()
    }

    /// Section 2: light of the stripe's middle, in DN of 8 bits, before lens and exposure.
    #[expect(clippy::too_many_arguments, reason = "the symbols of one equation")]
    fn amplitude_dn(
        &self,
        index: usize,
        laser: &Laser,
        point: &Vector3<f64>,
        normal: &Vector3<f64>,
        way: &Vector3<f64>,
        width_m: f64,
        look: &Look,
    ) -> f64 {
        let fan = &self.fans[index];
        let angle_rad = libm::atan2(way.dot(&fan.across), way.dot(&fan.along));
        let (light, view) = (-way.normalize(), -point.normalize());
        // The plane's normal points away from the camera, the surface's toward it.
        let (cos_light, cos_view) = (-normal.dot(&light), -normal.dot(&view));
        if cos_light <= 0.0 || cos_view <= 0.0 {
            return 0.0;
        }
        let half = (light + view).normalize();
        let reflected = look.reflectance(cos_light, cos_view, -normal.dot(&half), view.dot(&half));
        let strength = laser_strength(self.optics, &self.scene.rig().line) * self.powers[index];
        debug_assert!((laser.normal_in_camera.dot(point) - laser.offset_m).abs() < 1e-3);
        strength * fan.profile(angle_rad) * cos_light * reflected / (way.norm() * width_m)
    }

    /// Section 5: the headlamp's light on a plane, a share of its strength.
    fn even(&self, normal: &Vector3<f64>, ray: &Vector3<f64>, o: f64, look: &Look) -> f64 {
        let cosine = normal.dot(ray) / ray.norm();
        let reflected = look.reflectance(cosine, cosine, cosine, 1.0);
        reflected * cosine * cosine * cosine / (o * o)
    }
}
