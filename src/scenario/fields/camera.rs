//! Camera and mount.

use ductloop_nav::rig::Distortion;

use super::field::Slot;
use super::{Field, Kind, Scale, TableRow};

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("sensor.camera", "The camera, and where it stands on the robot."),
    TableRow::new("sensor.mount", "The pan-tilt mount; camera and lasers turn with it."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::size("sensor.camera.width_px", 16, 8192, |s| &mut s.rig.camera.width_px)
        .unit("px")
        .preset()
        .about("Columns of the image."),
    Field::size("sensor.camera.height_px", 16, 8192, |s| &mut s.rig.camera.height_px)
        .unit("px")
        .preset()
        .about("Rows of the image."),
    Field::new(
        "sensor.camera.focal_px",
        Kind::Numbers { len: 2, min: 1.0, max: 1e5, single: true },
        Slot::Numbers(|s| &mut s.rig.camera.focal_px, Scale::Si),
    )
    .unit("px")
    .preset()
    .about("Focal length, one for square pixels or [along u, along v]."),
    Field::numbers("sensor.camera.centre_px", 2, -1e4, 1e4, |s| &mut s.rig.camera.centre_px)
        .unit("px")
        .preset()
        .about("Principal point [u, v]; (0, 0) is the centre of the first pixel."),
    Field::new(
        "sensor.camera.distortion",
        Kind::Numbers { len: 5, min: -10.0, max: 10.0, single: false },
        Slot::Values {
            get: |s| {
                let d = s.rig.camera.distortion;
                vec![d.k1, d.k2, d.p1, d.p2, d.k3]
            },
            set: |s, values| {
                if let [k1, k2, p1, p2, k3] = *values {
                    s.rig.camera.distortion = Distortion { k1, k2, p1, p2, k3 };
                }
            },
        },
    )
    .default("[0.0, 0.0, 0.0, 0.0, 0.0]")
    .about("The lens' distortion after Brown and Conrady, [k1, k2, p1, p2, k3] as OpenCV orders them."),
    Field::number("sensor.camera.roll_deg", -180.0, 180.0, |s| &mut s.rig.mount.roll_rad)
        .degrees()
        .preset()
        .about("How the camera is turned about its own line of sight."),
    Field::numbers("sensor.camera.position_in_base_m", 3, -3.0, 3.0, |s| s.rig.mount.position_in_base_m.coords.as_mut_slice())
        .unit("m")
        .preset()
        .about("The camera's centre in the base frame (x forward, y left, z up from the floor)."),
    Field::number("sensor.mount.pan_deg", -180.0, 180.0, |s| &mut s.rig.mount.rest.pan_rad)
        .degrees()
        .preset()
        .about("Where the mount points, anticlockwise from above: negative looks right."),
    Field::number("sensor.mount.tilt_deg", -90.0, 90.0, |s| &mut s.rig.mount.rest.tilt_rad)
        .degrees()
        .preset()
        .about("Where the mount points: positive looks down."),
];
