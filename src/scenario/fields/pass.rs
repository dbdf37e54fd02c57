//! What a run must achieve. Numbers are maxima unless the key says `min`.

use super::field::Slot;
use super::{Default, Field, Kind, Scale, TableRow};
use crate::reason_words::STOPS;
use crate::record::EndState;

pub(super) const TABLES: &[TableRow] = &[TableRow::new("pass", "What the run must achieve; without any criterion it passes.")];

/// A bound on a metric of the summary.
const fn criterion(path: &'static str, max: f64, metric: &'static str) -> Field {
    Field::new(path, Kind::Number { min: 0.0, max }, Slot::Criterion(metric, Scale::Si)).or(Default::Absent("not looked at"))
}

pub(super) const FIELDS: &[Field] = &[
    Field::new("pass.completed", Kind::Flag, Slot::Criterion("completed", Scale::Si))
        .or(Default::Absent("not looked at"))
        .about("Whether the base must pass the finish line, or must not."),
    Field::new("pass.end_state", Kind::Word(&EndState::WORDS), Slot::Criterion("end_state", Scale::Si))
        .or(Default::Absent("not looked at"))
        .about("How the run must end, exactly."),
    Field::new("pass.stop_reason", Kind::Word(&STOPS), Slot::Criterion("stop_reason", Scale::Si))
        .or(Default::Absent("not looked at"))
        .about("What the navigator must have stopped for, which ended the run."),
    Field::new("pass.collisions", Kind::Integer { min: 0, max: 1_000_000 }, Slot::Criterion("collisions", Scale::Si))
        .or(Default::Absent("not looked at"))
        .about("Most contacts with anything but the floor."),
    criterion("pass.contact_speed_max_m_s", 10.0, "contact_speed_max_m_s").unit("m/s").about("Highest speed of such a contact."),
    criterion("pass.min_clearance_mm", 1e4, "min_clearance_m")
        .milli("mm")
        .about("Least distance that must remain between the robot and any wall."),
    criterion("pass.lateral_rms_mm", 1e4, "lateral_rms_m").milli("mm").about("RMS offset from the centreline after settling."),
    criterion("pass.lateral_max_mm", 1e4, "lateral_max_m")
        .milli("mm")
        .about("Largest offset from the centreline after settling."),
    criterion("pass.heading_rms_deg", 180.0, "heading_rms_rad").degrees().about("RMS heading error after settling."),
    criterion("pass.heading_max_deg", 180.0, "heading_max_rad").degrees().about("Largest heading error after settling."),
    criterion("pass.lateral_estimate_rms_mm", 1e4, "lateral_estimate_rms_m")
        .milli("mm")
        .about("RMS difference between estimated and true offset."),
    criterion("pass.heading_estimate_rms_deg", 180.0, "heading_estimate_rms_rad")
        .degrees()
        .about("RMS difference between estimated and true heading."),
    criterion("pass.estimates_valid_min", 1.0, "estimates_valid").about("Least share of frames with a valid estimate."),
    criterion("pass.sim_time_s", 36_000.0, "sim_time_s").unit("s").about("Longest simulated time."),
    criterion("pass.distance_min_m", 1e5, "distance_m").unit("m").about("Least distance covered along the centreline."),
    Field::new(
        "pass.junctions_taken_min",
        Kind::Integer { min: 0, max: 1_000_000 },
        Slot::Criterion("junctions_taken", Scale::Si),
    )
    .or(Default::Absent("not looked at"))
    .about("Least number of junctions passed as the route names them."),
    criterion("pass.survey_drift_share", 1.0, "survey_drift_share")
        .about("Largest distance between believed and true place at the end, over the way."),
    criterion("pass.survey_length_error_max", 1.0, "survey_length_error_max")
        .about("Largest error of a surveyed length of at least a metre, as a share of it."),
    criterion("pass.survey_width_error_max_mm", 1e4, "survey_width_error_max_m")
        .milli("mm")
        .about("Largest error of a surveyed width, in ducts driven along for at least a metre."),
    Field::new(
        "pass.survey_deposits_missed",
        Kind::Integer { min: 0, max: 1_000_000 },
        Slot::Criterion("survey_deposits_missed", Scale::Si),
    )
    .or(Default::Absent("not looked at"))
    .about("Most objects on the floor that the sensor resolves as deposits and that may stay unfound."),
    Field::new(
        "pass.survey_deposits_false",
        Kind::Integer { min: 0, max: 1_000_000 },
        Slot::Criterion("survey_deposits_false", Scale::Si),
    )
    .or(Default::Absent("not looked at"))
    .about("Most deposits that may be found where nothing lies on the floor."),
    criterion("pass.survey_deposit_error_max_mm", 1e4, "survey_deposit_error_max_m")
        .milli("mm")
        .about("Largest error of the mean thickness of a deposit that the sensor resolves."),
    criterion("pass.ahead_named_share_min", 1.0, "ahead_named_share")
        .about("Least share of fittings, obstacles and ends that must be named rightly before the robot enters them."),
    criterion("pass.ahead_detection_widths_min", 100.0, "ahead_detection_widths_min").about(
        "Least distance, in widths of the duct, from which on elbows, tees, crosses and dead ends must have their right name.",
    ),
    criterion("pass.ahead_latency_max_s", 36_000.0, "ahead_latency_max_s")
        .unit("s")
        .about("Longest time from when a fitting can be seen to when it has its right name."),
    criterion("pass.ahead_distance_error_max_mm", 1e4, "ahead_distance_error_max_m")
        .milli("mm")
        .about("Largest error of the distance to a fitting that has its right name."),
    Field::new(
        "pass.ahead_false_alarms",
        Kind::Integer { min: 0, max: 1_000_000 },
        Slot::Criterion("ahead_false_alarms", Scale::Si),
    )
    .or(Default::Absent("not looked at"))
    .about("Most often that something may be named where the duct goes straight on as far as can be seen."),
    criterion("pass.control_effort", 1e6, "control_effort").about("Largest control effort, in the summary's own measure."),
    Field::number("pass.settle_m", 0.0, 1e5, |s| &mut s.pass.settle_m)
        .unit("m")
        .default("0.0")
        .about("Distance from the start over which the robot may settle: metrics of tracking leave it out."),
];
