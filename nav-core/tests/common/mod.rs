//! Images of a straight duct, made by plain geometry: nothing here is shared with the renderer or with the code under test.
#![allow(dead_code, reason = "each test file uses a part of this")]

use ductloop_nav::rig::{Camera, Distortion, Laser, LineWidth, Mount, MountAngles, Rig};
use nalgebra::{Point3, Unit, Vector3};

/// A rig like the preset `wide`: two nearly level slits that cross in side view, a short lens looking ahead.
pub(crate) fn wide() -> Rig {
    let laser = |name: &str, normal: [f64; 3], below_camera_m: f64| {
        let source = Point3::new(0.0, below_camera_m, 0.0);
        let normal = Unit::new_normalize(Vector3::from(normal));
        Laser {
            name: name.into(),
            normal_in_camera: normal,
            offset_m: normal.dot(&source.coords),
            source_in_camera: source,
            fan_rad: 100.0_f64.to_radians(),
        }
    };
    Rig {
        camera: Camera {
            width_px: 640,
            height_px: 480,
            focal_px: [378.4; 2],
            centre_px: [319.5, 239.5],
            distortion: Distortion::NONE,
        },
        mount: Mount { position_in_base_m: Point3::new(0.12, 0.0, 0.10), roll_rad: 0.0, rest: MountAngles::default() },
        lasers: vec![laser("low", [-0.029838, 0.994594, 0.099459], 0.06), laser("high", [-0.029610, -0.987007, 0.157921], -0.06)],
        line: LineWidth { width_m: 0.002, growth_rad: 0.004 },
    }
}

/// Where the robot stands in a straight duct.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) lateral_m: f64,
    pub(crate) heading_rad: f64,
    pub(crate) width_m: f64,
}

/// The grey image that a camera sees in a straight duct 0.3 m high: both stripes on all four walls over a dim background, light
/// falling off along the fan. `lit` says which lasers are on.
pub(crate) fn image(rig: &Rig, pose: &Pose, lit: [bool; 2]) -> Vec<u8> {
    const HEIGHT_M: f64 = 0.3;
    let base_from_camera = rig.mount.base_from_camera(rig.mount.rest);
    let (s, c) = libm::sincos(pose.heading_rad);
    let turn = |v: Vector3<f64>| Vector3::new(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
    let camera = turn(base_from_camera.translation.vector) + Vector3::new(0.0, pose.lateral_m, 0.0);
    let mut pixels = vec![0; rig.camera.width_px * rig.camera.height_px];
    for v in 0..rig.camera.height_px {
        for u in 0..rig.camera.width_px {
            let ray = Vector3::new(
                (u as f64 - rig.camera.centre_px[0]) / rig.camera.focal_px[0],
                (v as f64 - rig.camera.centre_px[1]) / rig.camera.focal_px[1],
                1.0,
            );
            let direction = turn(base_from_camera.rotation * ray);
            let half = pose.width_m / 2.0;
            let reach = |position: f64, speed: f64, low: f64, high: f64| {
                if speed > 0.0 { (high - position) / speed } else { (low - position) / speed }
            };
            let to_side = reach(camera.y, direction.y, -half, half);
            let to_level = reach(camera.z, direction.z, 0.0, HEIGHT_M);
            let depth = to_side.min(to_level);
            // Beyond that nothing is lit; along the duct's axis the depth is infinite or not a number.
            if depth.is_nan() || depth >= 4.0 {
                continue;
            }
            let point = Point3::from(ray * depth);
            let facing = (if to_side < to_level { direction.y } else { direction.z }).abs() / direction.norm();
            let mut grey = 8.0 + 2.0 * facing / (depth * depth);
            for (laser, _) in rig.lasers.iter().zip(lit).filter(|(_, on)| *on) {
                let from_source = point - laser.source_in_camera;
                let distance = from_source.norm();
                let fwhm = rig.line.at(distance);
                let sigma = fwhm / 2.354_820_045;
                let off = (laser.normal_in_camera.dot(&point.coords) - laser.offset_m) / sigma;
                grey += 180.0 * (0.3 * 0.0032) / (distance * fwhm) * facing * libm::exp(-off * off / 2.0);
            }
            pixels[v * rig.camera.width_px + u] = grey.round().clamp(0.0, 255.0) as u8;
        }
    }
    pixels
}
