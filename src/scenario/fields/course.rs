//! Where the run starts and where it ends.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("start", "Where the robot's base stands when the run begins, at rest."),
    TableRow::new("finish", "The line that completes the run when the robot's base passes it."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::number("start.distance_m", 0.0, 1e5, |s| &mut s.start.distance_m)
        .unit("m")
        .default("0.5")
        .about("Distance of the base along the duct's centreline."),
    Field::number("start.lateral_m", -5.0, 5.0, |s| &mut s.start.lateral_m)
        .unit("m")
        .default("0.0")
        .about("Offset of the base from the centreline, left positive."),
    Field::number("start.heading_deg", -90.0, 90.0, |s| &mut s.start.heading_rad)
        .degrees()
        .default("0.0")
        .about("Heading against the centreline, anticlockwise positive."),
    Field::number("finish.before_end_m", 0.0, 1e5, |s| &mut s.finish.before_end_m)
        .unit("m")
        .default("0.5")
        .about("How far before the end of the duct's centreline the line is."),
];
