//! A camera at its place: lasers' fans followed from it, ray by ray, to what they meet and where that is seen.

use ductloop_duct::Transform;
use ductloop_duct::network::Hit;
use ductloop_nav::perception::Wall;
use ductloop_sensor::light::Fan;
use nalgebra::{Point3, Unit, Vector3};

use super::truth::{Scan, StageTruth, TrueCentre, TruePlane, TruthScene};

/// Rays of a fan: a pixel or so apart in the image.
const RAYS: usize = 1024;

/// A ray of a fan that met something which the camera sees.
#[derive(Clone, Copy)]
struct Seen {
    pixel: [f64; 2],
    plane: usize,
}

/// A camera at its place.
pub(super) struct Station<'a> {
    pub(super) scene: &'a TruthScene,
    pub(super) world_from_base: &'a Transform,
    pub(super) world_from_camera: &'a Transform,
    pub(super) camera: Point3<f64>,
    /// The cell that it is in.
    pub(super) cell: usize,
}

impl Station<'_> {
    /// Follows a laser's fan.
    pub(super) fn follow(&self, index: usize, truth: &mut StageTruth) {
        let laser = &self.scene.rig.lasers[index];
        let source = self.world_from_camera * laser.source_in_camera;
        let Some(cell) = self.scene.lit.cell_at(&source, self.cell) else { return };
        let fan = Fan::of(laser, self.scene.profile);
        let half_rad = laser.fan_rad / 2.0;
        let mut before: Option<Seen> = None;
        for ray in 0..=RAYS {
            let (sin, cos) = libm::sincos(half_rad * (2.0 * ray as f64 / RAYS as f64 - 1.0));
            let way = self.world_from_camera.rotation * (fan.along * cos + fan.across * sin);
            let hit = self.scene.lit.cast(cell, &source, &Unit::new_normalize(way), f64::INFINITY);
            let here = hit.and_then(|hit| self.seen(&hit, truth));
            if let (Some(a), Some(b)) = (before, here)
                && a.plane == b.plane
            {
                self.cross(index, a, b, &mut truth.centres);
            }
            before = here;
        }
    }

    /// The pixel at which the camera sees a lit point, if it does.
    fn seen(&self, hit: &Hit, truth: &mut StageTruth) -> Option<Seen> {
        /// Nothing nearer to the image's plane is seen, in metres.
        const NEAREST_M: f64 = 1e-3;
        /// What the view meets this near to the point is the point, in metres.
        const SAME_M: f64 = 1e-7;
        let in_camera = self.world_from_camera.inverse_transform_point(&hit.point);
        let toward = self.camera - hit.point;
        if in_camera.z < NEAREST_M || hit.normal.dot(&toward) <= 0.0 {
            return None;
        }
        let pixel = self.scene.projection.pixel_of(&in_camera);
        // Within one convex cell nothing is in the way but bodies.
        let is_clear = hit.cell == self.cell && self.scene.network.cells[self.cell].solids.is_empty();
        let hidden = || {
            let ray = Unit::new_normalize(-toward);
            let met = self.scene.network.cast(self.cell, &self.camera, &ray, f64::INFINITY);
            met.is_some_and(|met| met.distance_m < toward.norm() - SAME_M)
        };
        if !is_clear && hidden() {
            return None;
        }
        Some(Seen { pixel, plane: self.plane(hit, truth) })
    }

    /// The index of the plane that was hit.
    fn plane(&self, hit: &Hit, truth: &mut StageTruth) -> usize {
        /// Planes this much alike are one.
        const SAME: f64 = 1e-6;
        let away = -hit.normal.into_inner();
        let normal_in_camera = self.world_from_camera.rotation.inverse() * away;
        let camera_distance_m = away.dot(&(hit.point - self.camera));
        let same = |plane: &TruePlane| {
            (plane.normal_in_camera.into_inner() - normal_in_camera).norm() < SAME
                && (plane.camera_distance_m - camera_distance_m).abs() < SAME
                && plane.surface == hit.surface
        };
        if let Some(index) = truth.planes.iter().position(same) {
            return index;
        }
        let normal_in_base = self.world_from_base.rotation.inverse() * away;
        let of_duct = self.scene.network.cells[hit.cell].faces.iter().any(|face| face.plane.distance(&hit.point).abs() < SAME);
        truth.planes.push(TruePlane {
            wall: wall(&normal_in_base).filter(|_| of_duct),
            normal_in_camera: Unit::new_unchecked(normal_in_camera),
            camera_distance_m,
            normal_in_base: Unit::new_unchecked(normal_in_base),
            distance_m: away.dot(&(hit.point.coords - self.world_from_base.translation.vector)),
            surface: hit.surface,
        });
        truth.planes.len() - 1
    }

    /// Appends where a stripe from `a` to `b` crosses the middles of columns and rows.
    fn cross(&self, laser: usize, a: Seen, b: Seen, centres: &mut Vec<TrueCentre>) {
        let camera = &self.scene.rig.camera;
        for (scan, along, sizes) in
            [(Scan::Column, 0, [camera.width_px, camera.height_px]), (Scan::Row, 1, [camera.height_px, camera.width_px])]
        {
            let (from, to) = if a.pixel[along] <= b.pixel[along] { (a, b) } else { (b, a) };
            let run = to.pixel[along] - from.pixel[along];
            // Half-open, so that the pieces of a stripe share no column.
            let first = from.pixel[along].ceil().max(0.0);
            let end = to.pixel[along].ceil().min(sizes[0] as f64);
            if run <= 0.0 || first >= end {
                continue;
            }
            let slope = (to.pixel[1 - along] - from.pixel[1 - along]) / run;
            for line in first as usize..end as usize {
                let at_px = from.pixel[1 - along] + slope * (line as f64 - from.pixel[along]);
                if (-0.5..sizes[1] as f64 - 0.5).contains(&at_px) {
                    centres.push(TrueCentre { scan, line, at_px, slope, laser, plane: a.plane });
                }
            }
        }
    }
}

/// What a plane is to the robot, by its normal in the base frame, which points away from the robot.
fn wall(normal_in_base: &Vector3<f64>) -> Option<Wall> {
    /// Cosine of 45 degrees: what is nearest to a direction belongs to it.
    const TOWARD: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let n = normal_in_base;
    [(n.y, Wall::Left), (-n.y, Wall::Right), (-n.z, Wall::Floor), (n.z, Wall::Ceiling), (n.x, Wall::Ahead)]
        .into_iter()
        .find(|(toward, _)| *toward > TOWARD)
        .map(|(_, wall)| wall)
}
