//! The Cramer-Rao bound: how accurate any unbiased reading of one frame can be at best.
//!
//! The derivation is in `docs/perception.md`. In data-flow order: [`light`] says what profile a stripe truly has in a column, from the
//! rig, the surface and the optics; [`mod@column`] what the pixels of a column say of the stripes' middles in it; here that becomes what
//! all columns say of the walls, and of where the robot stands between them.
//!
//! Nothing is shared with the perception that it judges: true rig, true planes, true middles. Taken as known: the rig, the stripes'
//! width and the shape of their profile, that walls stand upright and are flat. Not known: the amplitude of each stripe in each
//! column, the background of each column, and of each wall distance and heading. Ghosts, bounce, daylight, spangle and seams are not
//! in it: they do not blur what the bound measures, they mislead.

pub mod column;
pub mod light;

use ductloop_nav::perception::Wall;
use nalgebra::{Matrix2, Matrix3, Matrix4, Matrix4x2, Matrix4x3, Vector2, Vector3};

use super::trial::SIDES;
use crate::scenario::Scenario;
use crate::stage_scores::{Scan, StageTruth, TrueCentre, TruthScene};
use column::{MOST_STRIPES, Noise, Stripe};
use light::Light;

/// Least standard deviations that any unbiased reading of a frame can have; `None` where nothing of it shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Of each side wall, left and right: from its own columns, and, where both count, from those of the other, since parallel walls share
    /// the heading that carries a distance from where the stripes lie to the base.
    pub walls: [Option<WallBound>; 2],
    /// Heading, in radians: walls that count, taken as parallel.
    pub heading_rad: Option<f64>,
    /// Lateral offset, in metres: half the difference of both distances, or the width less the one.
    pub lateral_m: Option<f64>,
}

/// The bound of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallBound {
    /// Of the distance from the base's origin, in metres.
    pub distance_m: f64,
    /// Of the heading relative to it, in radians.
    pub heading_rad: f64,
}

/// What the columns say of (distance, heading) of the left wall and of the right one.
pub type WallsInformation = Matrix4<f64>;

impl Bounds {
    /// Of a frame. `counts` says of which side walls, left and right, lateral offset and heading may be read.
    pub fn of(scenario: &Scenario, scene: &TruthScene, truth: &StageTruth, laser_power: &[f64], counts: [bool; 2]) -> Self {
        Self::from_information(&information(scenario, scene, truth, laser_power), counts)
    }

    /// From what the columns say.
    pub fn from_information(information: &WallsInformation, counts: [bool; 2]) -> Self {
        let block = |side: usize| -> Matrix2<f64> { information.fixed_view::<2, 2>(2 * side, 2 * side).into() };
        let wall = |side: usize| {
            let covariance = inverse2(&block(side))?;
            Some(WallBound { distance_m: covariance.m11.sqrt(), heading_rad: covariance.m22.sqrt() })
        };
        let mut walls = [wall(0), wall(1)];
        let (lateral_m, heading_rad) = match counts {
            [true, true] => match both(information) {
                Some(covariance) => {
                    let [heading_rad, left_m, right_m] = [0, 1, 2].map(|i| covariance[(i, i)].sqrt());
                    walls = [left_m, right_m].map(|distance_m| Some(WallBound { distance_m, heading_rad }));
                    let lateral = Vector3::new(0.0, -0.5, 0.5);
                    (Some(lateral.dot(&(covariance * lateral)).sqrt()), Some(heading_rad))
                }
                None => (None, None),
            },
            [true, false] => (walls[0].map(|wall| wall.distance_m), walls[0].map(|wall| wall.heading_rad)),
            [false, true] => (walls[1].map(|wall| wall.distance_m), walls[1].map(|wall| wall.heading_rad)),
            [false, false] => (None, None),
        };
        Self { walls, heading_rad, lateral_m }
    }
}

/// Covariance of (heading, distance left, distance right) from both walls.
fn both(information: &WallsInformation) -> Option<Matrix3<f64>> {
    // (distance, heading) left and right by (heading, distance left, distance right).
    let mut by = Matrix4x3::zeros();
    (by[(0, 1)], by[(1, 0)], by[(2, 2)], by[(3, 0)]) = (1.0, 1.0, 1.0, 1.0);
    let joint: Matrix3<f64> = by.transpose() * information * by;
    // Radians and metres weigh alike enough for an inverse in doubles.
    joint.try_inverse()
}

fn inverse2(information: &Matrix2<f64>) -> Option<Matrix2<f64>> {
    information.try_inverse().filter(|covariance| covariance.m11 > 0.0 && covariance.m22 > 0.0)
}

/// Fisher information of the side walls: the sum over all columns of both stripes, of what each says of the stripes' middles, through
/// how these move with the wall.
pub fn information(scenario: &Scenario, scene: &TruthScene, truth: &StageTruth, laser_power: &[f64]) -> WallsInformation {
    let light = Light::new(scenario, scene, laser_power);
    let noise = Noise::of(&scenario.optics, scenario.first_exposure_s());
    let mut total = WallsInformation::zeros();
    for columns in truth.centres.chunk_by(|a, b| (a.scan, a.line) == (b.scan, b.line)) {
        let mut seen: Vec<(&TrueCentre, Stripe)> =
            columns.iter().filter(|centre| centre.counts()).filter_map(|c| Some((c, light.stripe(truth, c)?))).collect();
        seen.sort_by(|a, b| a.1.centre_px.total_cmp(&b.1.centre_px));
        // Stripes whose light overlaps are read together.
        for group in seen.chunk_by(|a, b| b.1.centre_px - a.1.centre_px < a.1.reach_px() + b.1.reach_px()) {
            for part in group.chunks(MOST_STRIPES) {
                add(scene, truth, part, &noise, &mut total);
            }
        }
    }
    total
}

fn add(scene: &TruthScene, truth: &StageTruth, group: &[(&TrueCentre, Stripe)], noise: &Noise, total: &mut WallsInformation) {
    let side = |centre: &TrueCentre| SIDES.iter().position(|wall| truth.planes[centre.plane].wall == Some(*wall));
    if group.iter().all(|(centre, _)| side(centre).is_none()) {
        return;
    }
    let stripes: Vec<Stripe> = group.iter().map(|(_, stripe)| *stripe).collect();
    let sought: Vec<bool> = group.iter().map(|(centre, _)| side(centre).is_some()).collect();
    let said = column::information(&stripes, &sought, noise);
    // How each middle moves with (distance, heading) of its wall.
    let moves: Vec<Option<(usize, Vector2<f64>)>> =
        group.iter().map(|(centre, _)| Some((side(centre)?, motion(scene, truth, centre)))).collect();
    for (i, a) in moves.iter().enumerate() {
        for (j, b) in moves.iter().enumerate() {
            let (Some((side_a, by_a)), Some((side_b, by_b))) = (a, b) else { continue };
            let mut block = total.fixed_view_mut::<2, 2>(2 * side_a, 2 * side_b);
            block += by_a * by_b.transpose() * said[(i, j)];
        }
    }
}

/// How far a stripe's middle moves along its column (or row), in pixels, with a metre of the wall's distance from the base and with
/// a radian of heading.
///
/// On the wall m . p = 1, m = n / o, and on the laser's plane l . p = L the stripe is where f = (m - l / L) . r = 0; and n and o
/// move with the heading as the base turns: dn = -z x n, and with distance D and camera position t o = D - n . t.
pub fn motion(scene: &TruthScene, truth: &StageTruth, centre: &TrueCentre) -> Vector2<f64> {
    let plane = &truth.planes[centre.plane];
    let laser = &scene.rig().lasers[centre.laser];
    let [x, y] = scene.projection().ray(centre.pixel());
    let ray = Vector3::new(x, y, 1.0);
    let (n, o) = (plane.normal_in_camera.into_inner(), plane.camera_distance_m);
    let by_ray = n / o - laser.normal_in_camera.into_inner() / laser.offset_m;
    let by_pixel = scene.projection().rays_per_pixel([x, y]).transpose() * by_ray.xy();
    let along = if centre.scan == Scan::Column { by_pixel.y } else { by_pixel.x };
    let n_base = plane.normal_in_base.into_inner();
    let turned_base = -Vector3::z().cross(&n_base);
    // The base's axes in the camera's: the mount of the true rig at rest.
    let base_from_camera = scene.rig().mount.base_from_camera(scene.rig().mount.rest);
    let turned = base_from_camera.rotation.inverse() * turned_base;
    let by_distance = -n.dot(&ray) / (o * o);
    let by_heading = turned.dot(&ray) / o + n.dot(&ray) * turned_base.dot(&base_from_camera.translation.vector) / (o * o);
    Vector2::new(-by_distance / along, -by_heading / along)
}

/// Of (distance, heading) of one wall alone, from [`information`].
pub fn wall_block(information: &WallsInformation, wall: Wall) -> Option<Matrix2<f64>> {
    let side = SIDES.iter().position(|side| *side == wall)?;
    let mut pick = Matrix4x2::zeros();
    (pick[(2 * side, 0)], pick[(2 * side + 1, 1)]) = (1.0, 1.0);
    Some(pick.transpose() * information * pick)
}
