//! How wheels and walls become one place: the estimator, its noises, its gate.

use super::{Field, TableRow};
use crate::scenario::model::EstimatorKind;

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("estimation", "How what the wheels turned and what the walls looked like become one place.")];

pub(super) const FIELDS: &[Field] = &[
    Field::word(
        "estimation.kind",
        &["kalman", "none"],
        |s| s.estimation.kind.word(),
        |s, word| s.estimation.kind = if word == "none" { EstimatorKind::None } else { EstimatorKind::Kalman },
    )
    .default("\"kalman\"")
    .about(
        "\"kalman\" weighs wheels and walls by how sure each is, \"none\" takes the last measurement for exact, as the paper does. \
         Perception \"truth\" needs no estimate and has none.",
    ),
    Field::number("estimation.wheel_slip_mm", 0.0, 1000.0, |s| &mut s.estimation.params.wheel_slip_m)
        .milli("mm")
        .default("0.05")
        .about("Deviation of a side's way on the floor from what its wheels turned, after one metre; grows with the way's root."),
    Field::number("estimation.side_slip_mm", 0.0, 1000.0, |s| &mut s.estimation.params.side_slip_m)
        .milli("mm")
        .default("0.03")
        .about("Deviation of the base's drift sideways after one metre; grows with the way's root."),
    Field::number("estimation.turn_slip_deg", 0.0, 90.0, |s| &mut s.estimation.params.turn_slip_rad)
        .degrees()
        .default("0.25")
        .about("Deviation of the heading after a turn of one radian that the effective track does not explain; grows with its root."),
    Field::number("estimation.width_mm", 0.001, 1000.0, |s| &mut s.estimation.params.width_m)
        .milli("mm")
        .default("20.0")
        .about("Deviation of the duct's width from navigation.width_m."),
    Field::number("estimation.width_walk_mm", 0.0, 1000.0, |s| &mut s.estimation.params.width_walk_m)
        .milli("mm")
        .default("0.01")
        .about("Deviation by which the width changes in one metre; grows with the way's root."),
    Field::number("estimation.track_ratio", 0.0, 1.0, |s| &mut s.estimation.params.track_ratio)
        .default("0.05")
        .about("Deviation of the effective track from the robot's own, as a share of it."),
    Field::number("estimation.track_walk_ratio", 0.0, 1.0, |s| &mut s.estimation.params.track_walk_ratio)
        .default("0.01")
        .about("Deviation by which the effective track changes in one metre, as a share of the robot's own."),
    Field::number("estimation.icr_mm", 0.0, 1000.0, |s| &mut s.estimation.params.icr_m)
        .milli("mm")
        .default("20.0")
        .about("Deviation of the centre of rotation, along the robot, from the base's origin."),
    Field::number("estimation.icr_walk_mm", 0.0, 1000.0, |s| &mut s.estimation.params.icr_walk_m)
        .milli("mm")
        .default("1.0")
        .about("Deviation by which the centre of rotation moves in one metre; grows with the way's root."),
    Field::number("estimation.correlation_m", 1e-3, 1e4, |s| &mut s.estimation.params.correlation_m)
        .unit("m")
        .default("10.0")
        .about("Way after which the part of the walls' errors that is not new in every frame has a correlation of 1/e."),
    Field::number("estimation.correlated_share", 0.0, 0.99, |s| &mut s.estimation.params.correlated_share)
        .default("0.25")
        .about("Share of the variance of the walls' errors that persists from frame to frame."),
    Field::number("estimation.stated_ratio", 0.01, 100.0, |s| &mut s.estimation.params.stated_ratio)
        .default("1.0")
        .about("Factor on the deviations that perception states."),
    Field::number("estimation.unstated_distance_mm", 1e-3, 1000.0, |s| &mut s.estimation.params.unstated_distance_m)
        .milli("mm")
        .default("0.5")
        .about("Deviation of a wall's distance from a perception that states none, as the paper's."),
    Field::number("estimation.unstated_heading_deg", 1e-3, 90.0, |s| &mut s.estimation.params.unstated_heading_rad)
        .degrees()
        .default("0.1")
        .about("Deviation of the heading from a perception that states none."),
    Field::number("estimation.gate_probability", 0.5, 0.999_999, |s| &mut s.estimation.params.gate_probability)
        .default("0.999")
        .about("Probability with which the gate lets through a measurement that is no outlier (chi-square)."),
    Field::size("estimation.gate_run", 1, 1000, |s| &mut s.estimation.params.gate_run)
        .default("5")
        .about("So many measurements refused in succession, and the filter begins anew from the next."),
    Field::number("estimation.uncertain_lateral_mm", 1e-3, 1000.0, |s| &mut s.estimation.params.uncertain_lateral_m)
        .milli("mm")
        .default("20.0")
        .about("Deviation of the estimated offset beyond which the navigator's state is \"degraded\"."),
    Field::number("estimation.uncertain_heading_deg", 1e-3, 90.0, |s| &mut s.estimation.params.uncertain_heading_rad)
        .degrees()
        .default("3.0")
        .about("Deviation of the estimated heading beyond which the navigator's state is \"degraded\"."),
];
