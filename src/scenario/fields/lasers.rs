//! The laser slits, and what light there is.

use ductloop_sensor::optics::FanProfile;

use super::field::Slot;
use super::{Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] = &[
    TableRow {
        at_most_one: &["source_in_base_m", "source_in_camera_m"],
        ..TableRow::new(
            "sensor.laser.*",
            "A laser slit under a name of its own: a plane n . p = d in the camera frame (x right, y down, z ahead, metres).",
        )
    },
    TableRow::new("sensor.line", "How thick the slits' light is: full width at half maximum, growing with the distance."),
    TableRow::new("sensor.light", "How bright lasers, headlamp and surroundings are, and how their light is spread."),
];

/// Words for `sensor.light.fan_profile`.
const PROFILES: &[&str] = &["powell", "cylinder"];

/// Light at the edge of a Powell lens' fan, as a share of its middle, unless a file says otherwise.
const POWELL_EDGE: f64 = 0.8;

fn profile_word(profile: FanProfile) -> &'static str {
    match profile {
        FanProfile::Powell { .. } => "powell",
        FanProfile::Cylinder => "cylinder",
    }
}

fn profile(word: &str) -> FanProfile {
    if word == "cylinder" { FanProfile::Cylinder } else { FanProfile::Powell { edge: POWELL_EDGE } }
}

pub(super) const FIELDS: &[Field] = &[
    Field::of_element("sensor.laser.*.normal", Kind::Numbers { len: 3, min: -1.0, max: 1.0, single: false })
        .required("[0.0, 0.995, 0.0998]")
        .about("Unit normal n of the laser's plane, in the camera frame."),
    Field::of_element("sensor.laser.*.offset_m", Kind::Number { min: -2.0, max: 2.0 })
        .unit("m")
        .required("0.06")
        .about("Distance d of the plane from the camera's centre along the normal; a millimetre at least, either way."),
    Field::of_element("sensor.laser.*.fan_deg", Kind::Number { min: 1.0, max: 160.0 })
        .unit("degrees")
        .default("90.0")
        .about("Full opening angle of the fan; of a cylinder lens where its light is 1/e^2 of the middle's, and it goes on to 1.7 times that."),
    Field::of_element("sensor.laser.*.source_in_base_m", Kind::Numbers { len: 3, min: -3.0, max: 3.0, single: false })
        .unit("m")
        .or(super::Default::Absent("the foot of the perpendicular from the camera's centre to the plane"))
        .about("Where the fan starts, a point of its plane, in the base frame while the mount stands at zero pan and tilt."),
    Field::of_element("sensor.laser.*.source_in_camera_m", Kind::Numbers { len: 3, min: -3.0, max: 3.0, single: false })
        .unit("m")
        .or(super::Default::Absent("the foot of the perpendicular from the camera's centre to the plane"))
        .about("Where the fan starts, in the camera frame; it then goes where the camera goes."),
    Field::of_element("sensor.laser.*.power", Kind::Number { min: 0.0, max: 10.0 })
        .default("1.0")
        .about("Its power as a share of nominal, times what the navigator asks; 0 is off. The navigator is not told."),
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
        .about("Grey value above black (of 8 bits) of a stripe's peak on a matt wall of albedo 1/2 met squarely 0.3 m away."),
    Field::number("sensor.light.headlamp_peak_dn", 0.0, 1e5, |s| &mut s.optics.headlamp_peak_dn)
        .unit("DN")
        .default("20.0")
        .about("Grey value above black that the headlamp gives the same wall there; 0 switches it off."),
    Field::number("sensor.light.ambient_dn", 0.0, 1e5, |s| &mut s.optics.ambient_dn)
        .unit("DN")
        .default("0.0")
        .about("Grey value above black at which an open end is seen (daylight through a grille); 0 is a dark room."),
    Field::number("sensor.light.at_exposure_ms", 0.01, 1000.0, |s| &mut s.optics.exposure_s)
        .milli("ms")
        .default("4.0")
        .about("The exposure for which those grey values hold."),
    Field::word(
        "sensor.light.fan_profile",
        PROFILES,
        |s| profile_word(s.optics.fan_profile),
        |s, word| s.optics.fan_profile = profile(word),
    )
    .default("\"powell\"")
    .about("How the light is spread along the fan: nearly evenly by a Powell lens, as a Gaussian by a cylinder lens, which shines beyond fan_deg."),
    Field::new(
        "sensor.light.fan_edge",
        Kind::Number { min: 0.01, max: 1.0 },
        Slot::Part {
            get: |s| if let FanProfile::Powell { edge } = s.optics.fan_profile { Some(edge) } else { None },
            set: |s, value| {
                if let FanProfile::Powell { edge } = &mut s.optics.fan_profile {
                    *edge = value;
                }
            },
        },
    )
    .default("0.8")
    .about("Light at the edge of a Powell lens' fan as a share of its middle."),
    Field::number("sensor.light.speckle_contrast", 0.0, 1.0, |s| &mut s.optics.speckle_contrast)
        .default("0.12")
        .about("Standard deviation over mean of the lasers' speckle, a pixel; 0 switches it off."),
    Field::number("sensor.light.speckle_grain_px", 1.0, 16.0, |s| &mut s.optics.speckle_grain_px)
        .unit("px")
        .default("1.0")
        .about("Size of a speckle grain in the image."),
    Field::new("sensor.light.shadows", Kind::Flag, Slot::Flag(|s| &mut s.optics.shadows))
        .default("true")
        .about("Whether bodies standing in the duct cast shadows in the lasers' light; walls always do."),
    Field::new("sensor.light.ghosts", Kind::Flag, Slot::Flag(|s| &mut s.optics.ghosts))
        .default("false")
        .about("Whether stripes are seen again where a wall mirrors them."),
    Field::new("sensor.light.bounce", Kind::Flag, Slot::Flag(|s| &mut s.optics.bounce))
        .default("false")
        .about("Whether stripes light up the walls about them (one bounce): the glow in corners."),
];
