//! Parameters of Koh and Cho's path-tracking law.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] = &[TableRow::new(
    "control.koh-cho",
    "Koh and Cho's law: the robot lands on the tangent of a target that moves along the path, accelerations bounded.",
)];

pub(super) const FIELDS: &[Field] = &[
    Field::number("control.koh-cho.landing", 0.001, 1.0, |s| &mut s.control.koh_cho.landing)
        .default("0.0126")
        .about("m of C = m alpha_max / (6 v^2), how steeply the robot lands on the path; 0.1 and below converge."),
    Field::number("control.koh-cho.linear_heading_deg", 0.01, 90.0, |s| &mut s.control.koh_cho.linear_heading_rad)
        .degrees()
        .default("38.7")
        .about("Heading error within which steering is linear."),
    Field::number("control.koh-cho.linear_lateral_mm", 0.01, 1000.0, |s| &mut s.control.koh_cho.linear_lateral_m)
        .milli("mm")
        .default("6.91")
        .about("Lateral error within which the landing curve's slope is linear."),
    Field::number("control.koh-cho.linear_along_m", 0.001, 10.0, |s| &mut s.control.koh_cho.linear_along_m)
        .unit("m")
        .default("0.05")
        .about("Distance to the target within which the speed law is linear."),
];
