//! Limits of body and wheels, the same for every path-tracking law.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("control.limits", "What no path-tracking law may exceed, whichever is chosen.")];

pub(super) const FIELDS: &[Field] = &[
    Field::number("control.limits.max_speed_m_s", 0.01, 10.0, |s| &mut s.control.limits.max_speed_m_s)
        .unit("m/s")
        .default("1.25")
        .about("Largest forward speed that is commanded; a `robot.speed_m_s` above it is held at it."),
    Field::number("control.limits.max_acceleration_m_s2", 0.01, 20.0, |s| &mut s.control.limits.max_acceleration_m_s2)
        .unit("m/s2")
        .default("0.5")
        .about("Largest forward acceleration, a_max."),
    Field::number("control.limits.max_yaw_acceleration_rad_s2", 0.01, 100.0, |s| {
        &mut s.control.limits.max_yaw_acceleration_rad_s2
    })
    .unit("rad/s2")
    .default("2.81")
    .about("Largest yaw acceleration, alpha_max."),
    Field::number("control.limits.max_wheel_acceleration_m_s2", 0.01, 20.0, |s| {
        &mut s.control.limits.max_wheel_acceleration_m_s2
    })
    .unit("m/s2")
    .default("1.49")
    .about("Largest acceleration of a wheel's rim, which bounds the other two together."),
];
