//! What a navigator's program is told before the first frame: what a robot's own navigator knows, nothing of the truth.

use ductloop_nav::rig::{Laser, Rig};
use ductloop_sensor::optics::Bits;
use serde_json::{Value, json};

use super::protocol::VERSION;
use crate::pilot;
use crate::scenario::Scenario;

/// The document of the first message. All SI and radians.
pub(super) fn hello(scenario: &Scenario) -> Value {
    let Scenario { rates, robot, rig, .. } = scenario;
    let limits = pilot::limits(scenario);
    json!({
        "protocol": VERSION,
        "ticks_per_s": rates.physics_hz,
        "ticks_per_frame": rates.ticks_per_frame(),
        "speed_m_s": scenario.speed_m_s,
        "duct_width_m": scenario.navigation.width_m,
        "first_exposure_s": scenario.first_exposure_s(),
        "drive": {
            "wheel_radius_m": robot.wheel_radius_m,
            "track_m": robot.track_m,
            "effective_track_m": limits.effective_track_m,
            "counts_per_wheel_turn": robot.drive.counts_per_wheel_turn(),
            "max_speed_m_s": limits.max_speed_m_s,
            "max_acceleration_m_s2": limits.max_acceleration_m_s2,
            "max_yaw_acceleration_rad_s2": limits.max_yaw_acceleration_rad_s2,
            "max_wheel_acceleration_m_s2": limits.max_wheel_acceleration_m_s2,
        },
        "camera": camera(rig, scenario),
        "mount": {
            "position_in_base_m": rig.mount.position_in_base_m.coords.as_slice(),
            "roll_rad": rig.mount.roll_rad,
            "rest_pan_rad": rig.mount.rest.pan_rad,
            "rest_tilt_rad": rig.mount.rest.tilt_rad,
        },
        "lasers": lasers(rig),
    })
}

fn camera(rig: &Rig, scenario: &Scenario) -> Value {
    let camera = &rig.camera;
    let distortion = &camera.distortion;
    json!({
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "bits": bits(scenario.optics.ccd.bits),
        "focal_px": camera.focal_px,
        "centre_px": camera.centre_px,
        "distortion": { "k1": distortion.k1, "k2": distortion.k2, "p1": distortion.p1, "p2": distortion.p2, "k3": distortion.k3 },
    })
}

fn bits(bits: Bits) -> u32 {
    match bits {
        Bits::Eight => 8,
        Bits::Ten => 10,
        Bits::Twelve => 12,
    }
}

fn lasers(rig: &Rig) -> Vec<Value> {
    let laser = |laser: &Laser| {
        json!({
            "name": laser.name,
            "normal_in_camera": laser.normal_in_camera.as_slice(),
            "offset_m": laser.offset_m,
            "source_in_camera_m": laser.source_in_camera.coords.as_slice(),
            "fan_rad": laser.fan_rad,
        })
    };
    rig.lasers.iter().map(laser).collect()
}
