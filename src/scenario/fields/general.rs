//! What the file is, its name and seed, and the rates.

use super::field::Slot;
use super::{Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("rates", "How often each part acts. Physics ticks are the only clock: the other two rates divide theirs.")];

/// The path of the format's version.
pub(in crate::scenario) const FORMAT: &str = "format";
/// The path of the kind of file.
pub(in crate::scenario) const KIND: &str = "kind";

pub(super) const FIELDS: &[Field] = &[
    Field::new(FORMAT, Kind::Integer { min: 1, max: 1 }, Slot::Fixed("1"))
        .required("1")
        .about("Version of the file format; this program reads format 1."),
    Field::new(KIND, Kind::Word(&["scenario"]), Slot::Fixed("\"scenario\""))
        .required("\"scenario\"")
        .refuse(&[
            ("sweep", "this file is a sweep, a list of many runs: `ductloop sweep FILE` carries it out"),
            ("study", "this file is a study, a search over many runs, and cannot be read as one scenario"),
            ("accuracy", "this file is an accuracy study, a grid of poses: `ductloop accuracy FILE` carries it out"),
            ("gauge", "this file is an experiment with a block gauge: `ductloop calibrate --gauge FILE` carries it out"),
        ])
        .about("What the file describes."),
    Field::new("name", Kind::Name, Slot::Text(|s| &mut s.name))
        .required("\"straight\"")
        .about("Name of the run and of its folder: letters, digits, `-` and `_`."),
    Field::new("about", Kind::Text, Slot::Text(|s| &mut s.about)).default("\"\"").about("What the run is for, in one sentence."),
    Field::new("seed", Kind::Integer { min: 0, max: i64::MAX }, Slot::U64(|s| &mut s.seed))
        .default("1")
        .about("Feeds every random stream: the same seed gives the same run."),
    Field::number("time_limit_s", 0.1, 36_000.0, |s| &mut s.time_limit_s)
        .unit("s")
        .default("60.0")
        .about("Simulated time after which the run is stopped and has failed."),
    Field::count("rates.physics_hz", 100, 20_000, |s| &mut s.rates.physics_hz)
        .unit("Hz")
        .default("1200")
        .about("Physics steps a second."),
    Field::count("rates.wheel_control_hz", 10, 20_000, |s| &mut s.rates.wheel_control_hz)
        .unit("Hz")
        .default("200")
        .about("How often the wheel controller reads the encoders and sets the motors; divides the physics rate."),
    Field::count("rates.camera_hz", 1, 1_000, |s| &mut s.rates.camera_hz)
        .unit("Hz")
        .default("30")
        .about("Frames a second, each followed by a decision of the command controller; divides the physics rate."),
];
