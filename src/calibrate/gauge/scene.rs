//! The block at a depth: what the camera sees of a laser on it, and what is the case.

use ductloop_duct::cell::SurfaceId;
use ductloop_sensor::renderer::View;
use ductloop_sensor::truth::{CentrePoint, SceneTruth};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::file::GaugeFile;
use super::stripe::{self, Across};
use crate::closed_loop::RunError;
use crate::engine::Engine;
use crate::grey_image::GreyImage;
use crate::scenario::{Object, ObjectShape, Scenario};
use crate::viewpoint::still;

/// A point that was asked for and found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Its pixel: across the stripe as found, along it as the block's marks have it.
    pub(super) pixel_px: [f64; 2],
    /// In the gauge's frame, in millimetres.
    pub(super) actual_mm: Point3<f64>,
    pub(super) centre_error_px: f64,
}

/// Block, camera and room.
pub(super) struct Scene<'a> {
    file: &'a GaugeFile,
    engine: &'a Engine,
    threads: usize,
    world_from_gauge: Isometry3<f64>,
    world_from_camera: Isometry3<f64>,
    /// Images so far: each has its own noise.
    frames: u64,
}

/// Thickness of the block, in metres.
const THICK_M: f64 = 0.1;
/// A stripe's line of pixels must lie so near the height that was asked for: two lines lie a millimetre apart, about.
const BESIDE_MM: f64 = 2.0;
/// Pixels between a point and the image's edge.
const MARGIN_PX: f64 = 1.0;

impl<'a> Scene<'a> {
    pub(super) fn new(file: &'a GaugeFile, engine: &'a Engine, threads: usize) -> Self {
        let gauge = &file.gauge;
        // x up, y right, z along the duct.
        let axes = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0));
        let world_from_gauge = Isometry3::from_parts(Translation3::from(Vector3::from(gauge.origin_m)), axes.into());
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(gauge.turn_rad));
        let camera_from_gauge = Isometry3::from_parts(Translation3::from(Vector3::from(gauge.shift_mm) / 1e3), turn);
        let world_from_camera = world_from_gauge * camera_from_gauge.inverse();
        Self { file, engine, threads, world_from_gauge, world_from_camera, frames: 0 }
    }

    /// Measures a laser's stripe at heights and depths [x, z]; how many of them the camera does not see, besides.
    pub(super) fn measure(&mut self, laser: &str, points_mm: &[[f64; 2]]) -> Result<(Vec<Found>, usize), RunError> {
        let mut depths: Vec<f64> = points_mm.iter().map(|[_, z]| *z).collect();
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        let index = self.file.scenario.rig.lasers.iter().position(|known| known.name == laser).unwrap_or(0);
        // In the order that they were asked in.
        let mut found = vec![None; points_mm.len()];
        for depth in depths {
            let scenario = self.scenario(depth);
            let image = self.image(&scenario, index)?;
            let centres = self.truth(&scenario, index)?;
            for (slot, [x, _]) in found.iter_mut().zip(points_mm).filter(|(_, [_, z])| *z == depth) {
                *slot = self.find(&image, &centres, *x);
            }
        }
        let unseen = found.iter().filter(|point| point.is_none()).count();
        Ok((found.into_iter().flatten().collect(), unseen))
    }

    /// The room with the block's face at a depth.
    fn scenario(&self, depth_mm: f64) -> Scenario {
        let gauge = &self.file.gauge;
        let [across_m, upright_m] = gauge.size_mm.map(|size| size / 1e3);
        let [x_m, y_m, z_m] = gauge.origin_m;
        let mut scenario = self.file.scenario.clone();
        let surface = scenario.surfaces.iter().position(|surface| surface.name == gauge.surface).unwrap_or(0);
        scenario.duct.objects.push(Object {
            name: String::new(),
            shape: ObjectShape::Box { size_m: [THICK_M, across_m, upright_m] },
            at_m: x_m + depth_mm / 1e3 + THICK_M / 2.0,
            left_m: y_m,
            above_m: z_m - upright_m / 2.0,
            turned_rad: 0.0,
            surface: SurfaceId(surface as u16),
        });
        scenario
    }

    fn image(&mut self, scenario: &Scenario, laser: usize) -> Result<GreyImage, RunError> {
        let mut renderer = self.engine.renderer(scenario, self.threads)?;
        let mut laser_power = scenario.laser_powers(1.0);
        laser_power.iter_mut().enumerate().filter(|(other, _)| *other != laser).for_each(|(_, power)| *power = 0.0);
        let view = View {
            laser_power,
            headlamp_power: 0.0,
            frame: self.frames,
            ..still(self.world_from_camera, scenario.first_exposure_s())
        };
        self.frames += 1;
        let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        renderer.render(&view, image.room())?;
        Ok(image)
    }

    /// Where the middle of the laser's light truly is on the block.
    fn truth(&self, scenario: &Scenario, laser: usize) -> Result<Vec<CentrePoint>, RunError> {
        let truth = SceneTruth::new(&scenario.duct.network()?, &scenario.actual_rig()).of(&self.world_from_camera)?;
        let block = scenario.duct.objects.last().map_or(0, |object| object.surface.0);
        Ok(truth.centres.into_iter().filter(|centre| centre.laser == laser && centre.surface == block).collect())
    }

    fn in_gauge_mm(&self, centre: &CentrePoint) -> Point3<f64> {
        let in_world = self.world_from_camera * Point3::from(centre.point_in_camera_m);
        self.world_from_gauge.inverse_transform_point(&in_world) * 1e3
    }

    /// The centre nearest to a height, as found in the image.
    fn find(&self, image: &GreyImage, centres: &[CentrePoint], height_mm: f64) -> Option<Found> {
        let [width, height] = image.size_px().map(|size| size as f64);
        let inside = |centre: &&CentrePoint| {
            let within = |at: f64, size: f64| at >= MARGIN_PX && at <= size - 1.0 - MARGIN_PX;
            within(centre.u_px, width) && within(centre.v_px, height)
        };
        let away = |centre: &CentrePoint| (self.in_gauge_mm(centre).x - height_mm).abs();
        let nearest = centres.iter().filter(inside).min_by(|a, b| away(a).total_cmp(&away(b)))?;
        if away(nearest) > BESIDE_MM {
            return None;
        }
        let across = if nearest.u_px.fract() == 0.0 { Across::Columns } else { Across::Rows };
        let (line, truly) = match across {
            Across::Columns => (nearest.u_px, nearest.v_px),
            Across::Rows => (nearest.v_px, nearest.u_px),
        };
        let found = stripe::centre(image, across, line as usize, self.file.gauge.window_px)?;
        // The stripe's own slope carries a mark's error with it: the mark moves along the stripe.
        let mark = self.file.gauge.mark_sigma_px
            * gaussian(self.file.scenario.seed.wrapping_mul(1009).wrapping_add(self.frames), line as u64);
        let along = self.direction(centres, nearest, across);
        let pixel_px = match across {
            Across::Columns => [line + mark * along[0], found.at_px + mark * along[1]],
            Across::Rows => [found.at_px + mark * along[0], line + mark * along[1]],
        };
        Some(Found { pixel_px, actual_mm: self.in_gauge_mm(nearest), centre_error_px: found.at_px - truly })
    }

    /// Unit direction (u, v) of the stripe at a centre, by the neighbouring lines' centres.
    fn direction(&self, centres: &[CentrePoint], at: &CentrePoint, across: Across) -> [f64; 2] {
        let line = |centre: &CentrePoint| if across == Across::Columns { centre.u_px } else { centre.v_px };
        let next = centres.iter().find(|other| (line(other) - line(at)).abs() == 1.0);
        next.map_or([0.0; 2], |next| {
            let (du, dv) = (next.u_px - at.u_px, next.v_px - at.v_px);
            let length = (du * du + dv * dv).sqrt();
            [du / length, dv / length]
        })
    }
}

/// A number of a Gaussian of deviation one, from a hash of two (Box and Muller).
fn gaussian(a: u64, b: u64) -> f64 {
    let unit = |salt: u64| {
        let mut x = (a << 32 | b).wrapping_add(salt).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    (-2.0 * libm::log(unit(1))).sqrt() * libm::cos(2.0 * std::f64::consts::PI * unit(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_scatter_as_a_gaussian_does() {
        let numbers: Vec<_> = (0..20_000).map(|i| gaussian(i / 100, i % 100)).collect();
        let mean = numbers.iter().sum::<f64>() / 2e4;
        let variance = numbers.iter().map(|x| x * x).sum::<f64>() / 2e4;
        // Four standard deviations of each: 1/sqrt(N) and sqrt(2/N).
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
    }
}
