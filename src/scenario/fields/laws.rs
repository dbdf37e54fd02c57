//! Parameters of the path-tracking laws beside Koh and Cho's.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("control.pure-pursuit", "Pure pursuit: the arc to a point of the path ahead."),
    TableRow::new("control.stanley", "Stanley's law: towards the path at an angle that grows with the distance from it."),
    TableRow::new("control.kanayama", "Kanayama's law: a stable tracking of a target that moves along the path."),
    TableRow::new("control.samson", "Samson's law in chained form: the same trace along the path at any speed."),
    TableRow::new("control.lqr", "A linear-quadratic regulator; the three are deviations that cost the same."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::number("control.pure-pursuit.lookahead_m", 0.02, 10.0, |s| &mut s.control.pure_pursuit.lookahead_m)
        .unit("m")
        .default("0.3")
        .about("Shortest look-ahead distance."),
    Field::number("control.pure-pursuit.lookahead_s", 0.0, 10.0, |s| &mut s.control.pure_pursuit.lookahead_s)
        .unit("s")
        .default("0.9")
        .about("Look-ahead in time: what is covered in it at `robot.speed_m_s` is looked ahead, if that is more."),
    Field::number("control.stanley.heading_gain_1_s", 0.01, 100.0, |s| &mut s.control.stanley.heading_gain_1_s)
        .unit("1/s")
        .default("3.0")
        .about("k_th: yaw rate for a radian of heading error."),
    Field::number("control.stanley.lateral_gain_1_s", 0.01, 100.0, |s| &mut s.control.stanley.lateral_gain_1_s)
        .unit("1/s")
        .default("3.0")
        .about("k_y: yaw rate for a radian of the angle towards the path."),
    Field::number("control.stanley.decay_1_s", 0.01, 100.0, |s| &mut s.control.stanley.decay_1_s)
        .unit("1/s")
        .default("0.7")
        .about("k: how fast the lateral error is to decay."),
    Field::number("control.stanley.softening_m_s", 0.0, 10.0, |s| &mut s.control.stanley.softening_m_s)
        .unit("m/s")
        .default("0.05")
        .about("k_soft: added to the speed in the angle towards the path, so that it stays small at low speed."),
    Field::number("control.kanayama.along_gain_1_s", 0.0, 100.0, |s| &mut s.control.kanayama.along_gain_1_s)
        .unit("1/s")
        .default("2.0")
        .about("K_x: speed for a metre to the target."),
    Field::number("control.kanayama.lateral_gain_1_m2", 0.01, 10_000.0, |s| &mut s.control.kanayama.lateral_gain_1_m2)
        .unit("1/m2")
        .default("25.0")
        .about("K_y: curvature for a metre beside the path."),
    Field::number("control.kanayama.heading_gain_1_m", 0.01, 1000.0, |s| &mut s.control.kanayama.heading_gain_1_m)
        .unit("1/m")
        .default("10.0")
        .about("K_th: curvature for a radian of heading error; critical damping at K_th^2 = 4 K_y."),
    Field::number("control.samson.lateral_gain_1_m2", 0.01, 10_000.0, |s| &mut s.control.samson.lateral_gain_1_m2)
        .unit("1/m2")
        .default("25.0")
        .about("k_2: curvature for a metre beside the path."),
    Field::number("control.samson.heading_gain_1_m", 0.01, 1000.0, |s| &mut s.control.samson.heading_gain_1_m)
        .unit("1/m")
        .default("10.0")
        .about("k_3: curvature for a slope of one against the path; critical damping at k_3^2 = 4 k_2."),
    Field::number("control.lqr.lateral_mm", 1.0, 1000.0, |s| &mut s.control.lqr.lateral_m)
        .milli("mm")
        .default("60.0")
        .about("l: offset from the path that costs one."),
    Field::number("control.lqr.heading_deg", 0.1, 180.0, |s| &mut s.control.lqr.heading_rad)
        .degrees()
        .default("11.459155902616464")
        .about("h: heading error that costs one; the default is 0.2 rad."),
    Field::number("control.lqr.yaw_rate_rad_s", 0.01, 10.0, |s| &mut s.control.lqr.yaw_rate_rad_s)
        .unit("rad/s")
        .default("0.4")
        .about("r: yaw rate that costs one."),
];
