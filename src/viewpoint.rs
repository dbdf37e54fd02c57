//! Where the camera is at an exposure, and how it moves meanwhile.
//!
//! A frame is exposed about its tick: the shutter is open from half the exposure before to half the exposure after it. Over that
//! time the camera moves evenly, with the velocity that it has at the tick.

use ductloop_duct::Transform;
use ductloop_nav::angle::rotation_about_z;
use ductloop_nav::rig::{Mount, MountAngles, Rig};
use ductloop_sensor::renderer::{MAX_LASERS, Motion, View};
use ductloop_sim::truth::Truth;
use nalgebra::Vector3;

use crate::scenario::Scenario;

/// What a camera sees that stands still, all lights on at their nominal power: frame 0.
pub fn still(world_from_camera: Transform, exposure_s: f64) -> View {
    View {
        world_from_camera,
        motion: Motion::default(),
        frame: 0,
        exposure_s,
        laser_power: [1.0; MAX_LASERS],
        headlamp_power: 1.0,
    }
}

/// Pose of the camera: of the true rig, whose mount points elsewhere than it reports by `error`.
pub fn world_from_camera(rig: &Rig, world_from_base: &Transform, reported: MountAngles, error: MountAngles) -> Transform {
    let angles = MountAngles { pan_rad: reported.pan_rad + error.pan_rad, tilt_rad: reported.tilt_rad + error.tilt_rad };
    world_from_base * rig.mount.base_from_camera(angles)
}

/// Pose of a scenario's camera at the start of a run; `None` where there is no duct.
pub fn world_from_start_camera(scenario: &Scenario) -> Option<Transform> {
    let (network, rig) = (scenario.duct.network().ok()?, scenario.actual_rig());
    Some(world_from_camera(&rig, &scenario.world_from_start(&network), rig.mount.rest, MountAngles::default()))
}

/// Lasers of the true rig, by number, whose source is outside the duct: they light nothing in it.
pub fn lasers_outside(scenario: &Scenario, world_from_camera: &Transform) -> Vec<usize> {
    let Ok(network) = scenario.duct.network() else { return Vec::new() };
    let sources = scenario.actual_rig().lasers.into_iter().map(|laser| world_from_camera * laser.source_in_camera);
    sources.enumerate().filter(|(_, source)| network.cell_at(source, 0).is_none()).map(|(laser, _)| laser).collect()
}

/// Velocity of a camera on a base that moves as `truth` says (along its own x axis, turning about its own z axis), on a mount
/// that points to `angles` and turns at `rates`, in rad/s. The mount's axes meet in the camera's centre, so its turning moves the
/// centre nowhere.
pub fn motion(truth: &Truth, mount: &Mount, angles: MountAngles, rates: MountAngles) -> Motion {
    let world_from_base = truth.world_from_base.rotation;
    let turn = Vector3::new(0.0, 0.0, truth.yaw_rate_rad_s);
    let linear_in_base = Vector3::new(truth.speed_m_s, 0.0, 0.0) + turn.cross(&mount.position_in_base_m.coords);
    let tilt_axis = rotation_about_z(angles.pan_rad) * Vector3::y();
    let angular_in_base = turn + Vector3::z() * rates.pan_rad + tilt_axis * rates.tilt_rad;
    Motion { linear_m_s: world_from_base * linear_in_base, angular_rad_s: world_from_base * angular_in_base }
}

#[cfg(test)]
mod tests {
    use ductloop_nav::messages::Sides;
    use nalgebra::{Point3, Translation3, UnitQuaternion};

    use super::*;

    /// Against differences of the pose: base and mount moved by hand for a microsecond.
    #[test]
    fn the_velocity_is_the_derivative_of_the_pose() {
        let camera = Mount { position_in_base_m: Point3::new(0.12, 0.03, 0.1), roll_rad: 0.4, rest: MountAngles::default() };
        let start = Transform::from_parts(Translation3::new(2.0, 0.1, 0.0), UnitQuaternion::from_euler_angles(0.02, -0.03, 0.5));
        let truth = Truth {
            world_from_base: start,
            cell: 0,
            fitting: 0,
            segment: 0,
            distance_m: 0.0,
            lateral_m: 0.0,
            heading_rad: 0.0,
            clearance_m: 0.0,
            speed_m_s: 0.3,
            yaw_rate_rad_s: -0.7,
            wheel_speed_rad_s: Sides::default(),
            motor_current_a: Sides::default(),
        };
        let (angles, rates) = (MountAngles { pan_rad: 0.6, tilt_rad: -0.3 }, MountAngles { pan_rad: 1.1, tilt_rad: -1.7 });
        let moved = motion(&truth, &camera, angles, rates);
        let pose = |time_s: f64| {
            let turn = rotation_about_z(truth.yaw_rate_rad_s * time_s);
            let base = start * Transform::from_parts(Translation3::new(truth.speed_m_s * time_s, 0.0, 0.0), turn.into());
            let at = |angle: f64, rate: f64| angle + rate * time_s;
            base * camera.base_from_camera(MountAngles {
                pan_rad: at(angles.pan_rad, rates.pan_rad),
                tilt_rad: at(angles.tilt_rad, rates.tilt_rad),
            })
        };
        const STEP_S: f64 = 1e-6;
        let (before, after) = (pose(-STEP_S), pose(STEP_S));
        let linear = (after.translation.vector - before.translation.vector) / (2.0 * STEP_S);
        let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * STEP_S);
        // Central differences: rounding, 1e-16 m / 1e-6 s, is what remains.
        assert!((linear - moved.linear_m_s).norm() < 1e-9, "{linear} {}", moved.linear_m_s);
        assert!((angular - moved.angular_rad_s).norm() < 1e-9, "{angular} {}", moved.angular_rad_s);
    }
}
