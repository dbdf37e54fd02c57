//! Lateral and heading error from a wall's plane (equations 19 and 20).
//!
//! The paper writes them for a camera that looks along the duct, with y toward the measured wall and z forward; so the plane is
//! turned from the camera's frame, wherever the mount points, into the base frame first. Signs there are the paper's: both
//! errors positive toward the measured wall.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::wall_plane::WallPlane;
use super::{Wall, WallMeasurement};
use crate::rig::Transform;

/// The paper's errors, positive toward the measured wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperErrors {
    /// e_v: lateral error, in metres.
    pub e_v_m: f64,
    /// e_theta: heading error, in radians.
    pub e_theta_rad: f64,
}

/// Equations 19 and 20.
///
/// `k_y`, `k_z`: components of the wall's normal toward the wall and forward; `d_m`: distance of the wall from the camera;
/// `camera_ahead_m`: D_c, how far the camera stands ahead of the base's centre; `width_m`: W_d.
pub fn errors(k_y: f64, k_z: f64, d_m: f64, camera_ahead_m: f64, width_m: f64) -> PaperErrors {
    let e_theta_rad = libm::atan(k_z / k_y);
    PaperErrors { e_v_m: width_m / 2.0 - camera_ahead_m * libm::sin(e_theta_rad) - d_m, e_theta_rad }
}

/// The wall that this plane is, and what equations 19 and 20 say of it in this project's signs (left and anticlockwise
/// positive). The lateral error is stated as the wall's distance from the base, `W_d / 2 - e_v`, which needs no width.
///
/// `None` for a plane that is no side wall: more than `max_heading_rad` off the robot's own direction.
pub fn measure(
    plane: &WallPlane,
    base_from_camera: &Transform,
    points: usize,
    max_heading_rad: f64,
) -> Option<(Wall, WallMeasurement)> {
    let normal = base_from_camera.rotation * plane.normal.into_inner();
    let wall = if normal.y > 0.0 { Wall::Left } else { Wall::Right };
    let toward = if wall == Wall::Left { normal.y } else { -normal.y };
    if toward <= libm::cos(max_heading_rad.min(FRAC_PI_2 - 1e-6)) {
        return None;
    }
    let camera: Vector3<f64> = base_from_camera.translation.vector;
    // Equation 19 knows the camera's place along x only; how far it stands beside the robot's midplane comes off the distance.
    let beside_m = if wall == Wall::Left { camera.y } else { -camera.y };
    // Distance of the wall level with the camera, where the stripes are: the plane's tilt, which they show least well, stays out.
    let level = (normal.x * normal.x + normal.y * normal.y).sqrt();
    let paper = errors(toward, normal.x, plane.distance_m / level, camera.x, 0.0);
    let distance_m = -paper.e_v_m + beside_m * libm::cos(paper.e_theta_rad);
    let heading_rad = if wall == Wall::Left { paper.e_theta_rad } else { -paper.e_theta_rad };
    Some((wall, WallMeasurement { distance_m, heading_rad, points, deviation: None }))
}

/// Lateral error of the base, left positive, in a duct of width `width_m`; only side walls show it.
pub fn lateral_m(wall: Wall, measured: &WallMeasurement, width_m: f64) -> Option<f64> {
    match wall {
        Wall::Left => Some(width_m / 2.0 - measured.distance_m),
        Wall::Right => Some(measured.distance_m - width_m / 2.0),
        Wall::Floor | Wall::Ceiling | Wall::Ahead => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Mount, MountAngles};
    use nalgebra::{Point3, Unit};

    /// A camera anywhere on the robot, the robot anywhere in the duct, the walls' planes by plain geometry.
    #[test]
    fn a_wall_seen_from_any_mount_angle_gives_the_pose_of_the_base() {
        let width_m = 0.5;
        for (pan, tilt) in [(0.0, 0.0), (-0.87, 0.0), (0.5, 0.2)] {
            for (lateral, heading) in [(0.0, 0.0), (0.06, 0.1), (-0.1, -0.2)] {
                let mount =
                    Mount { position_in_base_m: Point3::new(0.12, 0.01, 0.1), roll_rad: 0.3, rest: MountAngles::default() };
                let base_from_camera = mount.base_from_camera(MountAngles { pan_rad: pan, tilt_rad: tilt });
                let (s, c) = libm::sincos(heading);
                for (wall, side) in [(Wall::Left, 1.0), (Wall::Right, -1.0)] {
                    // The wall's outward normal (0, side) in the duct, turned into the base; its distance from the base.
                    let normal_in_base = Vector3::new(side * s, side * c, 0.0);
                    let from_base = width_m / 2.0 - side * lateral;
                    let from_camera = from_base - normal_in_base.dot(&base_from_camera.translation.vector);
                    let normal = Unit::new_unchecked(base_from_camera.rotation.inverse() * normal_in_base);
                    let plane = WallPlane { normal, distance_m: from_camera };
                    let (seen, measured) = measure(&plane, &base_from_camera, 1, 0.6).expect("a side wall");
                    assert_eq!(seen, wall);
                    assert!((measured.distance_m - from_base).abs() < 1e-12, "{wall:?}: {measured:?}, expected {from_base}");
                    assert!((measured.heading_rad - heading).abs() < 1e-12, "{wall:?}: {measured:?}");
                    assert!((lateral_m(wall, &measured, width_m).expect("a side wall") - lateral).abs() < 1e-12);
                }
            }
        }
    }

    /// A wall that leans, or that the stripes make look so, is as far away as it is level with the camera.
    #[test]
    fn a_leaning_wall_is_measured_level_with_the_camera() {
        let mount = Mount { position_in_base_m: Point3::new(0.12, 0.0, 0.1), roll_rad: 0.0, rest: MountAngles::default() };
        let base_from_camera = mount.base_from_camera(mount.rest);
        for (wall, side) in [(Wall::Left, 1.0), (Wall::Right, -1.0)] {
            let (s, c) = libm::sincos(0.17);
            let normal_in_base = Vector3::new(0.0, side * c, s);
            // Through the point 0.25 m beside the camera, level with it.
            let distance_m = normal_in_base.dot(&Vector3::new(0.0, side * 0.25, 0.0));
            let normal = Unit::new_unchecked(base_from_camera.rotation.inverse() * normal_in_base);
            let (seen, measured) = measure(&WallPlane { normal, distance_m }, &base_from_camera, 1, 0.6).expect("a side wall");
            assert_eq!(seen, wall);
            assert!((measured.distance_m - 0.25).abs() < 1e-12, "{measured:?}");
        }
    }
}
