//! The rig that this pipeline's own tests look through.

use nalgebra::{Point3, Unit, Vector3};

use crate::rig::{Camera, Distortion, Laser, LineWidth, Mount, MountAngles, Rig};

/// Two lasers above and below a camera that looks down a duct.
pub(super) fn rig() -> Rig {
    let laser = |name: &str, y_m: f64, slant: f64| {
        let source = Point3::new(0.0, y_m, 0.0);
        let normal_in_camera = Unit::new_normalize(Vector3::new(0.0, 1.0, slant));
        let offset_m = normal_in_camera.dot(&source.coords);
        Laser { name: name.into(), normal_in_camera, offset_m, source_in_camera: source, fan_rad: 2.0 }
    };
    Rig {
        camera: Camera {
            width_px: 640,
            height_px: 480,
            focal_px: [400.0; 2],
            centre_px: [319.5, 239.5],
            distortion: Distortion::NONE,
        },
        mount: Mount { position_in_base_m: Point3::new(0.12, 0.0, 0.1), roll_rad: 0.0, rest: MountAngles::default() },
        lasers: vec![laser("low", 0.06, 0.1), laser("high", -0.06, -0.1)],
        line: LineWidth { width_m: 0.002, growth_rad: 0.004 },
    }
}
