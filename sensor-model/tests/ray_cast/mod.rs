//! Light worked out one ray at a time with `Network::cast`: knows nothing of beams, strips and edges, and so can judge them.
#![allow(dead_code, unreachable_pub)] // each binary that includes this uses its own part

use ductloop_duct::cell::SurfaceId;
use ductloop_duct::network::{Hit, Network};
use ductloop_nav::rig::Rig;
use ductloop_sensor::Transform;
use ductloop_sensor::frame_geometry::{FrameGeometry, GLOW_SPACING_PX, Sweep};
use ductloop_sensor::lens::Projection;
use ductloop_sensor::light::{FWHM_PER_SIGMA, Fan, laser_strength};
use ductloop_sensor::optics::Optics;
use ductloop_sensor::renderer::MAX_LASERS;
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::strip::{PixelRay, Strip};
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Unit, Vector3};

/// What is looked at, and from where. Surfaces are matt but for mirrors.
pub struct View<'a> {
    pub network: &'a Network,
    pub rig: &'a Rig,
    pub optics: &'a Optics,
    pub looks: &'a [Look],
    pub world_from_camera: Transform,
}

impl View<'_> {
    pub fn projection(&self) -> Projection {
        Projection { camera: self.rig.camera.clone() }
    }

    /// The frame's geometry with only this laser on.
    pub fn geometry(&self, laser: usize) -> FrameGeometry {
        let scenery = Scenery::new(self.network, self.looks).expect("sound looks");
        let mut geometry = FrameGeometry::new(self.rig, self.optics).expect("a sound lens");
        let mut power = [0.0; MAX_LASERS];
        power[laser] = 1.0;
        geometry.build(&scenery, &Sweep::still(self.world_from_camera), &power).expect("the camera is in the duct");
        geometry
    }

    /// Unit direction in the world that is seen at a pixel.
    pub fn way(&self, pixel: [f64; 2]) -> Unit<Vector3<f64>> {
        let [x, y] = self.projection().ray(pixel);
        Unit::new_normalize(self.world_from_camera.rotation * Vector3::new(x, y, 1.0))
    }

    pub fn cast(&self, from: &Point3<f64>, way: &Unit<Vector3<f64>>) -> Option<Hit> {
        // A little along, so as not to start in a wall's own plane.
        let origin = from + way.into_inner() * 1e-7;
        let cell = self.network.cell_at(&origin, 0)?;
        self.network.cast(cell, &origin, way, 50.0)
    }

    /// What a laser's ray meets first.
    fn light(&self, from: &Point3<f64>, way: &Unit<Vector3<f64>>) -> Option<Hit> {
        if self.optics.shadows {
            return self.cast(from, way);
        }
        // The walls alone.
        let mut walls = self.network.clone();
        walls.cells.iter_mut().for_each(|cell| cell.solids.clear());
        View { network: &walls, ..*self }.cast(from, way)
    }

    pub fn seen(&self, pixel: [f64; 2]) -> Option<Hit> {
        self.cast(&Point3::from(self.world_from_camera.translation.vector), &self.way(pixel))
    }

    /// Distance of a point of the world from a laser's plane.
    pub fn off_plane(&self, laser: usize, point: &Point3<f64>) -> f64 {
        let laser = &self.rig.lasers[laser];
        laser.normal_in_camera.dot(&self.world_from_camera.inverse_transform_point(point).coords) - laser.offset_m
    }

    pub fn source(&self, laser: usize) -> Point3<f64> {
        self.world_from_camera * self.rig.lasers[laser].source_in_camera
    }

    pub fn strength(&self) -> f64 {
        laser_strength(self.optics, &self.rig.line)
    }

    /// Share of the fan's light toward a point of the world.
    pub fn fan(&self, laser: usize, point: &Point3<f64>) -> f64 {
        let fan = Fan::of(&self.rig.lasers[laser], self.optics.fan_profile);
        let way = self.world_from_camera.inverse_transform_vector(&(point - self.source(laser)));
        fan.profile(libm::atan2(fan.across.dot(&way), fan.along.dot(&way)))
    }

    /// Grey value of a matt point under the light of a laser, shadows included, the lens' fall-off not.
    pub fn lit(&self, laser: usize, hit: &Hit) -> f64 {
        let source = self.source(laser);
        let way = hit.point - source;
        let distance_m = way.norm();
        let sigma_m = self.rig.line.at(distance_m) / FWHM_PER_SIGMA;
        let off = self.off_plane(laser, &hit.point) / sigma_m;
        let cos_light = -hit.normal.dot(&way) / distance_m;
        if cos_light <= 0.0 || off.abs() > 6.0 {
            return 0.0;
        }
        let met = self.light(&source, &Unit::new_normalize(way));
        // What is behind the point, where light passes through bodies, shades nothing.
        if met.is_some_and(|met| (met.point - source).norm() < distance_m - 1e-5) {
            return 0.0;
        }
        self.strength() / (distance_m * sigma_m * FWHM_PER_SIGMA)
            * libm::exp(-off * off / 2.0)
            * self.fan(laser, &hit.point)
            * cos_light
            * self.albedo(hit.surface)
    }

    pub fn albedo(&self, surface: SurfaceId) -> f64 {
        self.looks[usize::from(surface.0)].albedo
    }

    /// cos^4 at a pixel.
    pub fn falloff(&self, pixel: [f64; 2]) -> f64 {
        let [x, y] = self.projection().ray(pixel);
        1.0 / ((1.0 + x * x + y * y) * (1.0 + x * x + y * y))
    }

    /// Light of a laser in a window of `size` pixels from pixel `first` on, row by row: each pixel sampled `fine` times along each side,
    /// spread by the lens, integrated over the pixel.
    pub fn image(&self, laser: usize, first: [usize; 2], size: [usize; 2], fine: usize) -> Vec<f64> {
        let sigma = self.optics.lens.psf_sigma_px * fine as f64;
        let pad = 4 * fine;
        let [columns, rows] = size.map(|n| n * fine + 2 * pad);
        let at = |first: usize, i: usize| first as f64 - 0.5 + (i as f64 + 0.5 - pad as f64) / fine as f64;
        let mut samples = vec![0.0; columns * rows];
        for row in 0..rows {
            for column in 0..columns {
                let pixel = [at(first[0], column), at(first[1], row)];
                if let Some(hit) = self.seen(pixel) {
                    samples[row * columns + column] = self.lit(laser, &hit) * self.falloff(pixel);
                }
            }
        }
        let taps: Vec<f64> =
            (0..=2 * pad).map(|i| i as f64 - pad as f64).map(|x| libm::exp(-x * x / (2.0 * sigma * sigma))).collect();
        let sum: f64 = taps.iter().sum();
        // Along rows, then along columns, each for the samples of the window itself.
        let mut across = vec![0.0; size[0] * fine * rows];
        for row in 0..rows {
            for column in 0..size[0] * fine {
                let near = &samples[row * columns + column..][..taps.len()];
                across[row * size[0] * fine + column] = near.iter().zip(&taps).map(|(a, b)| a * b).sum::<f64>() / sum;
            }
        }
        let mut image = vec![0.0; size[0] * size[1]];
        let whole = sum * (fine * fine) as f64;
        for row in 0..size[1] * fine {
            for column in 0..size[0] * fine {
                let value: f64 = (0..taps.len()).map(|i| taps[i] * across[(row + i) * size[0] * fine + column]).sum();
                image[row / fine * size[0] + column / fine] += value / whole;
            }
        }
        image
    }
}

/// Light of those strips that `counts` in the same window, by the model.
pub fn of_strips(view: &View, geometry: &FrameGeometry, pixel: [f64; 2], counts: impl Fn(&Strip) -> bool) -> f64 {
    let ray = PixelRay::of(geometry.projection(), geometry.projection().ray(pixel).into());
    let strips = geometry.strips.iter().filter(|strip| counts(strip) && strip.plane.normal.dot(&ray.ray) > 1e-6);
    strips.map(|strip| view.strength() * strip.light(&ray, geometry.blur(), &geometry.edges, &geometry.holes)).sum()
}

/// What the nodes of the region of this surface with this normal (in the camera's frame, to within rounding) give a pixel.
pub fn of_glow(geometry: &FrameGeometry, pixel: [f64; 2], toward: &Vector3<f64>) -> f64 {
    let [x, y] = geometry.projection().ray(pixel);
    let ray = Vector3::new(x, y, 1.0);
    let inside = |outline: &[Point3<f64>]| {
        let middle: Vector3<f64> = outline.iter().map(|p| p.coords).sum();
        (0..outline.len()).all(|i| {
            let side = outline[i].coords.cross(&outline[(i + 1) % outline.len()].coords);
            side.dot(&ray) * side.dot(&middle) >= 0.0
        })
    };
    let region = geometry
        .regions
        .iter()
        .find(|region| region.plane.normal.dot(toward) < -0.999 && inside(&geometry.corners[region.outline.clone()]))
        .expect("a region at the pixel");
    let Some(patch) = region.glow else { return 0.0 };
    let spacing = GLOW_SPACING_PX as f64;
    let (u, v) = (pixel[0] / spacing - f64::from(patch.column), pixel[1] / spacing - f64::from(patch.row));
    let (i, j) = (u.floor(), v.floor());
    let node = |i: f64, j: f64| f64::from(geometry.glow[patch.first + j as usize * patch.columns + i as usize]);
    let (a, b) = (u - i, v - j);
    (node(i, j) * (1.0 - a) + node(i + 1.0, j) * a) * (1.0 - b) + (node(i, j + 1.0) * (1.0 - a) + node(i + 1.0, j + 1.0) * a) * b
}
