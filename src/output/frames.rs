//! `frames.parquet`: a row a frame; columns are named with their units, and what was not seen is null.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use arrow_schema::{ArrowError, SchemaRef};
use ductloop_nav::estimation::{Estimate, Outcome};
use ductloop_nav::navigator::State;
use ductloop_nav::perception::Wall;
use ductloop_nav::wheel_controller::silence::Hearing;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;

use crate::reason_words::reason_word;
use crate::record::FrameRecord;

/// The word for a navigator's state, in tables and reports.
pub fn state_word(state: State) -> &'static str {
    match state {
        State::Unknown => "unknown",
        State::Tracking => "tracking",
        State::Degraded => "degraded",
        State::Coasting => "coasting",
        State::Stopped => "stopped",
    }
}

/// The word for what a wheel controller does about its commands.
pub fn hearing_word(hearing: Hearing) -> &'static str {
    match hearing {
        Hearing::Commanded => "commanded",
        Hearing::RampingDown => "ramping-down",
        Hearing::Down => "down",
        Hearing::CutOff => "cut-off",
    }
}

/// The frames as a table.
///
/// # Errors
/// None that is known of: all columns have a row a frame.
pub fn table(frames: &[FrameRecord]) -> Result<RecordBatch, ArrowError> {
    let mut columns = Columns { frames, list: Vec::new() };
    columns.whole("frame", |f| f.frame);
    columns.whole("tick", |f| f.tick);
    columns.number("time_s", |f| f.time_s);
    truth(&mut columns);
    columns.signed("counts_left", |f| f.counts.left);
    columns.signed("counts_right", |f| f.counts.right);
    columns.number("pan_rad", |f| f.mount.pan_rad);
    columns.number("tilt_rad", |f| f.mount.tilt_rad);
    columns.number("camera_pan_rad", |f| f.body.mount.pan_rad);
    columns.number("camera_tilt_rad", |f| f.body.mount.tilt_rad);
    columns.push("wheel_control", false, |frames| StringArray::from_iter_values(frames.map(|f| hearing_word(f.body.hearing))));
    columns.number("duty_left", |f| f.body.duty.left);
    columns.number("duty_right", |f| f.body.duty.right);
    columns.whole("link_lost", |f| f.body.link.lost);
    columns.whole("link_dropped", |f| f.body.link.dropped);
    columns.number("exposure_s", |f| f.view.exposure_s);
    columns.number("laser_power", |f| f.laser_power);
    columns.push("state", false, |frames| StringArray::from_iter_values(frames.map(|f| state_word(f.state))));
    columns.push("ahead", true, |frames| frames.map(|f| f.outlook.map(|o| o.fitting.word())).collect::<StringArray>());
    columns.seen("ahead_at_m", |f| Some(f.outlook?.distance_m));
    columns.seen("ahead_confidence", |f| Some(f.outlook?.confidence));
    columns.push("true_ahead", true, |frames| frames.map(|f| f.true_ahead.map(|a| a.fitting.word())).collect::<StringArray>());
    columns.seen("true_ahead_at_m", |f| f.true_ahead.map(|ahead| ahead.distance_m).filter(|distance_m| distance_m.is_finite()));
    columns.seen("believed_x_m", |f| Some(f.believed_pose?[0]));
    columns.seen("believed_y_m", |f| Some(f.believed_pose?[1]));
    columns.seen("believed_heading_rad", |f| Some(f.believed_pose?[2]));
    columns.whole("ducts", |f| f.ducts as u64);
    columns.push("state_reason", true, |frames| frames.map(|f| f.reason.map(reason_word)).collect::<StringArray>());
    columns.count("lines", |f| f.lines as u32);
    estimates(&mut columns);
    filter(&mut columns);
    stages(&mut columns);
    columns.number("command_left_rad_s", |f| f.command.wheel_speed_rad_s.left);
    columns.number("command_right_rad_s", |f| f.command.wheel_speed_rad_s.right);
    columns.number("command_pan_rad", |f| f.command.mount.pan_rad);
    columns.number("command_tilt_rad", |f| f.command.mount.tilt_rad);
    columns.seen("command_exposure_s", |f| f.command.exposure_s);
    columns.seen("command_laser_power", |f| f.command.laser_power);
    // Bit i is fault i of the scenario.
    columns.count("faults", |f| f.faults);
    RecordBatch::try_from_iter_with_nullable(columns.list)
}

fn truth(columns: &mut Columns<'_>) {
    columns.number("x_m", |f| f.truth.world_from_base.translation.x);
    columns.number("y_m", |f| f.truth.world_from_base.translation.y);
    columns.number("z_m", |f| f.truth.world_from_base.translation.z);
    columns.number("qx", |f| f.truth.world_from_base.rotation.i);
    columns.number("qy", |f| f.truth.world_from_base.rotation.j);
    columns.number("qz", |f| f.truth.world_from_base.rotation.k);
    columns.number("qw", |f| f.truth.world_from_base.rotation.w);
    columns.count("cell", |f| f.truth.cell as u32);
    columns.number("distance_m", |f| f.truth.distance_m);
    columns.number("lateral_m", |f| f.truth.lateral_m);
    columns.number("heading_rad", |f| f.truth.heading_rad);
    columns.number("width_m", |f| f.width_m);
    columns.number("clearance_m", |f| f.truth.clearance_m);
    columns.number("speed_m_s", |f| f.truth.speed_m_s);
    columns.number("yaw_rate_rad_s", |f| f.truth.yaw_rate_rad_s);
    columns.number("wheel_speed_left_rad_s", |f| f.truth.wheel_speed_rad_s.left);
    columns.number("wheel_speed_right_rad_s", |f| f.truth.wheel_speed_rad_s.right);
    columns.number("motor_current_left_a", |f| f.truth.motor_current_a.left);
    columns.number("motor_current_right_a", |f| f.truth.motor_current_a.right);
    columns.count("collisions", |f| f.collisions.count);
    columns.number("contact_speed_max_m_s", |f| f.collisions.contact_speed_max_m_s);
}

fn estimates(columns: &mut Columns<'_>) {
    columns.seen("lateral_estimate_m", |f| f.measurement.lateral_m);
    columns.seen("lateral_sigma_m", |f| f.measurement.deviation.lateral_m);
    columns.seen("heading_estimate_rad", |f| f.measurement.heading_rad);
    columns.seen("heading_sigma_rad", |f| f.measurement.deviation.heading_rad);
    columns.seen("width_estimate_m", |f| f.measurement.width_m);
    columns.seen("width_sigma_m", |f| f.measurement.deviation.width_m);
    columns.seen("height_estimate_m", |f| f.measurement.height_m);
    columns.seen("height_sigma_m", |f| f.measurement.deviation.height_m);
    for wall in Wall::ALL {
        let word = wall.word();
        let measured = move |f: &FrameRecord| f.measurement.wall(wall).copied();
        let stated = move |f: &FrameRecord| measured(f).and_then(|wall| wall.deviation);
        columns.seen(&format!("{word}_wall_distance_m"), move |f| measured(f).map(|wall| wall.distance_m));
        columns.seen(&format!("{word}_wall_sigma_m"), move |f| stated(f).map(|wall| wall.distance_m));
        columns.seen(&format!("{word}_wall_heading_rad"), move |f| measured(f).map(|wall| wall.heading_rad));
        columns.seen(&format!("{word}_wall_heading_sigma_rad"), move |f| stated(f).map(|wall| wall.heading_rad));
        columns.push(&format!("{word}_wall_points"), true, |frames| {
            frames.map(|f| measured(f).map(|wall| wall.points as u32)).collect::<UInt32Array>()
        });
    }
}

/// What the estimator believes; null without one.
fn filter(columns: &mut Columns<'_>) {
    type Value = fn(&Estimate) -> f64;
    let values: [(&str, &str, Value); 5] = [
        ("filter_lateral", "m", |e| e.lateral_m),
        ("filter_heading", "rad", |e| e.heading_rad),
        ("filter_width", "m", |e| e.width_m),
        ("filter_track", "m", |e| e.effective_track_m),
        ("filter_icr", "m", |e| e.icr_m),
    ];
    for (i, (name, unit, value)) in values.into_iter().enumerate() {
        columns.seen(&format!("{name}_{unit}"), move |f| f.estimate.as_ref().map(value));
        columns.seen(&format!("{name}_sigma_{unit}"), move |f| f.estimate.map(|e| e.deviation(i)));
    }
    let looked = |f: &FrameRecord| match f.estimate?.outcome {
        Outcome::Taken { nis, freedom } | Outcome::Refused { nis, freedom } => Some((nis, freedom)),
        Outcome::None | Outcome::Begun | Outcome::Useless => None,
    };
    columns.seen("filter_nis", move |f| looked(f).map(|(nis, _)| nis));
    columns.seen("filter_nis_freedom", move |f| looked(f).map(|(_, freedom)| freedom as f64));
    columns.seen("filter_nees", |f| f.estimate?.nees(f.truth.lateral_m, f.truth.heading_rad, f.width_m));
    columns.seen("filter_refused", |f| f.estimate.map(|e| f64::from(e.refused)));
    columns.seen("filter_begun_anew", |f| f.estimate.map(|e| f64::from(e.begun_anew)));
}

/// How far each stage is from the truth ([`crate::stage_scores`]): errors are what was found less what is.
fn stages(columns: &mut Columns<'_>) {
    columns.seen("centres_precision", |f| f.score.centres.precision());
    columns.seen("centres_recall", |f| f.score.centres.recall());
    columns.seen("centres_rms_px", |f| f.score.centres.rms_px());
    columns.seen("centres_nees", |f| f.score.centres.mean_nees());
    columns.seen("lines_rms_px", |f| f.score.lines.rms_px());
    for wall in Wall::ALL {
        let word = wall.word();
        let score = move |f: &FrameRecord| f.score.wall(wall).copied();
        columns.seen(&format!("{word}_wall_columns"), move |f| score(f).map(|wall| wall.columns as f64));
        columns.seen(&format!("{word}_wall_error_m"), move |f| score(f)?.distance_error_m);
        columns.seen(&format!("{word}_wall_heading_error_rad"), move |f| score(f)?.heading_error_rad);
        columns.seen(&format!("{word}_wall_normal_error_rad"), move |f| score(f)?.normal_error_rad);
    }
    columns.seen("lateral_error_m", |f| f.score.lateral_error_m);
    columns.seen("heading_error_rad", |f| f.score.heading_error_rad);
    columns.seen("nees", |f| f.score.nees());
}

/// The table as a Parquet file, compressed with Snappy.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn parquet(frames: &[FrameRecord]) -> Result<Vec<u8>, ParquetError> {
    to_parquet(&table(frames)?)
}

/// A table as a Parquet file, compressed with Snappy.
pub(crate) fn to_parquet(table: &RecordBatch) -> Result<Vec<u8>, ParquetError> {
    let mut writer = table_writer(table.schema())?;
    writer.write(table)?;
    writer.into_inner()
}

/// A Parquet file in the making, compressed with Snappy.
pub(crate) fn table_writer(schema: SchemaRef) -> Result<ArrowWriter<Vec<u8>>, ParquetError> {
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    ArrowWriter::try_new(Vec::new(), schema, Some(properties))
}

/// The columns so far.
struct Columns<'a> {
    frames: &'a [FrameRecord],
    list: Vec<(String, ArrayRef, bool)>,
}

impl<'a> Columns<'a> {
    fn push<A>(&mut self, name: &str, nullable: bool, column: impl FnOnce(std::slice::Iter<'a, FrameRecord>) -> A)
    where
        A: arrow_array::Array + 'static,
    {
        self.list.push((name.to_owned(), Arc::new(column(self.frames.iter())), nullable));
    }

    fn number(&mut self, name: &str, value: impl Fn(&FrameRecord) -> f64) {
        self.push(name, false, |frames| Float64Array::from_iter_values(frames.map(value)));
    }

    fn seen(&mut self, name: &str, value: impl Fn(&FrameRecord) -> Option<f64>) {
        self.push(name, true, |frames| frames.map(value).collect::<Float64Array>());
    }

    fn count(&mut self, name: &str, value: impl Fn(&FrameRecord) -> u32) {
        self.push(name, false, |frames| UInt32Array::from_iter_values(frames.map(value)));
    }

    fn whole(&mut self, name: &str, value: impl Fn(&FrameRecord) -> u64) {
        self.push(name, false, |frames| UInt64Array::from_iter_values(frames.map(value)));
    }

    fn signed(&mut self, name: &str, value: impl Fn(&FrameRecord) -> i64) {
        self.push(name, false, |frames| Int64Array::from_iter_values(frames.map(value)));
    }
}
