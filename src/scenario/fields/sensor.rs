//! Camera, mount, lasers, light and CCD, and how the true rig differs from the nominal one.

use super::field::Slot;
use super::{Field, Kind, Scale, TableRow};
use crate::scenario::presets;

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("sensor", "The structured-light sensor: a preset, and what differs from it."),
    TableRow::new("sensor.camera", "The camera, a pinhole, and where it stands on the robot."),
    TableRow::new("sensor.mount", "The pan-tilt mount; camera and lasers turn with it."),
    TableRow {
        at_most_one: &["source_in_base_m", "source_in_camera_m"],
        ..TableRow::new(
            "sensor.laser.*",
            "A laser slit under a name of its own: a plane n . p = d in the camera frame (x right, y down, z ahead, metres).",
        )
    },
    TableRow::new("sensor.line", "How thick the slits' light is: full width at half maximum, growing with the distance."),
    TableRow::new("sensor.light", "How bright lasers and headlamp are, and how the lens spreads them."),
    TableRow::new("sensor.ccd", "The CCD, after EMVA 1288."),
    TableRow::new("sensor.error", "How the true rig, which makes the images, differs from the nominal one, which reads them."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::new("sensor.preset", Kind::Word(presets::SENSORS), Slot::Fixed("\"none\""))
        .default("\"wide\"")
        .about("Where the rig's numbers come from; with \"none\" camera, mount, lasers and line must be given."),
    Field::number("sensor.exposure", 0.01, 1000.0, |s| &mut s.exposure_s)
        .milli("ms")
        .default("4.0")
        .refuse(&[("auto", "automatic exposure is not in this version yet")])
        .about("Exposure of every frame."),
    Field::new("sensor.noise", Kind::Flag, Slot::Flag(|s| &mut s.optics.noise))
        .default("true")
        .about("Whether shot noise, read noise, unequal pixels and speckle are applied."),
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
    Field::of_element("sensor.laser.*.normal", Kind::Numbers { len: 3, min: -1.0, max: 1.0, single: false })
        .required("[0.0, 0.995, 0.0998]")
        .about("Unit normal n of the laser's plane, in the camera frame."),
    Field::of_element("sensor.laser.*.offset_m", Kind::Number { min: -2.0, max: 2.0 })
        .unit("m")
        .required("0.06")
        .about("Distance d of the plane from the camera's centre along the normal; a millimetre at least, either way."),
    Field::of_element("sensor.laser.*.fan_deg", Kind::Number { min: 1.0, max: 170.0 })
        .unit("degrees")
        .default("90.0")
        .about("Full opening angle of the fan."),
    Field::of_element("sensor.laser.*.source_in_base_m", Kind::Numbers { len: 3, min: -3.0, max: 3.0, single: false })
        .unit("m")
        .or(super::Default::Absent("the foot of the perpendicular from the camera's centre to the plane"))
        .about("Where the fan starts, a point of its plane, in the base frame while the mount stands at zero pan and tilt."),
    Field::of_element("sensor.laser.*.source_in_camera_m", Kind::Numbers { len: 3, min: -3.0, max: 3.0, single: false })
        .unit("m")
        .or(super::Default::Absent("the foot of the perpendicular from the camera's centre to the plane"))
        .about("Where the fan starts, in the camera frame; it then goes where the camera goes."),
    Field::number("sensor.line.width_mm", 0.05, 50.0, |s| &mut s.rig.line.width_m)
        .milli("mm")
        .preset()
        .about("Full width at half maximum at the laser."),
    Field::number("sensor.line.growth_mrad", 0.0, 100.0, |s| &mut s.rig.line.growth_rad)
        .milli("mrad")
        .preset()
        .about("Growth of that width with the distance from the laser."),
    Field::number("sensor.light.stripe_peak_dn", 0.0, 1e5, |s| &mut s.optics.stripe_peak_dn)
        .unit("DN")
        .default("180.0")
        .about("Grey value above black of a stripe's peak on a wall of albedo 1/2 met squarely 0.3 m away."),
    Field::number("sensor.light.headlamp_peak_dn", 0.0, 1e5, |s| &mut s.optics.headlamp_peak_dn)
        .unit("DN")
        .default("20.0")
        .about("Grey value above black that the headlamp gives the same wall there; 0 switches it off."),
    Field::number("sensor.light.at_exposure_ms", 0.01, 1000.0, |s| &mut s.optics.exposure_s)
        .milli("ms")
        .default("4.0")
        .about("The exposure for which those two grey values hold."),
    Field::number("sensor.light.fan_edge", 0.01, 1.0, |s| &mut s.optics.fan_edge)
        .default("0.8")
        .about("Light at the fan's edge as a share of its middle; 0.8 is a Powell lens."),
    Field::number("sensor.light.psf_sigma_px", 0.0, 1.2, |s| &mut s.optics.psf_sigma_px)
        .unit("px")
        .default("0.6")
        .about("Standard deviation of the lens' point spread."),
    Field::number("sensor.light.speckle_contrast", 0.0, 1.0, |s| &mut s.optics.speckle_contrast)
        .default("0.12")
        .about("Standard deviation over mean of the lasers' speckle, a pixel; 0 switches it off."),
    Field::number("sensor.ccd.full_well_e", 100.0, 1e6, |s| &mut s.optics.ccd.full_well_e)
        .unit("electrons")
        .default("30000.0")
        .about("Electrons at which a pixel is full and reads 255."),
    Field::number("sensor.ccd.read_noise_e", 0.0, 1e4, |s| &mut s.optics.ccd.read_noise_e)
        .unit("electrons")
        .default("15.0")
        .about("Standard deviation of the read noise."),
    Field::number("sensor.ccd.black_level_dn", 0.0, 200.0, |s| &mut s.optics.ccd.black_level_dn)
        .unit("DN")
        .default("8.0")
        .about("Grey value of no light."),
    Field::number("sensor.ccd.prnu", 0.0, 0.2, |s| &mut s.optics.ccd.prnu)
        .default("0.01")
        .about("Standard deviation of the pixels' gains over their mean."),
    Field::number("sensor.error.pan_deg", -45.0, 45.0, |s| &mut s.rig_error.pan_rad)
        .degrees()
        .default("0.0")
        .about("True pan less the pan that the mount reports."),
    Field::number("sensor.error.tilt_deg", -45.0, 45.0, |s| &mut s.rig_error.tilt_rad)
        .degrees()
        .default("0.0")
        .about("True tilt less the tilt that the mount reports."),
    Field::number("sensor.error.roll_deg", -45.0, 45.0, |s| &mut s.rig_error.roll_rad)
        .degrees()
        .default("0.0")
        .about("True roll of the camera less its nominal roll."),
    Field::new(
        "sensor.error.laser_plane_deg",
        Kind::List { min: -45.0, max: 45.0 },
        Slot::List(|s| &mut s.rig_error.laser_plane_rad, Scale::Degrees),
    )
    .degrees()
    .or(super::Default::Computed("a zero for each laser"))
    .about("How far each laser's plane is turned about the camera's x axis through its source, in the lasers' order."),
];
