//! `accuracy.parquet`: a row a pose and pipeline of an accuracy study; what was not seen or stated is null.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use ductloop_nav::perception::Wall;
use parquet::errors::ParquetError;

use super::frames::to_parquet;
use crate::accuracy::Trials;
use crate::accuracy::trial::{Reading, SIDES, Trial};
use crate::scenario::accuracy_file::AccuracyFile;
use crate::stage_scores::WallScore;

type Row<'a> = (&'a Trial, &'a Reading);

/// The table: `cell` and `label` of the grid, `pose` (its number, which is its frame's), `pipeline`; the pose itself; then what was
/// measured less what is, with the stated standard deviation of each. Of walls: their true distance from the base, how many columns
/// of stripe they show, and errors.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn parquet(file: &AccuracyFile, trials: &Trials) -> Result<Vec<u8>, ParquetError> {
    let rows: Vec<Row> =
        trials.list.iter().flat_map(|trial| trial.readings.iter().map(move |reading| (trial, reading))).collect();
    let labels: Vec<String> = file.cells.iter().map(|cell| cell.label()).collect();
    let mut columns: Vec<(String, ArrayRef, bool)> = vec![
        ("cell".into(), Arc::new(UInt32Array::from_iter_values(rows.iter().map(|(trial, _)| trial.cell as u32))), false),
        ("label".into(), Arc::new(StringArray::from_iter_values(rows.iter().map(|(trial, _)| &labels[trial.cell]))), false),
        ("pose".into(), Arc::new(UInt64Array::from_iter_values(rows.iter().map(|(trial, _)| trial.index))), false),
        ("pipeline".into(), Arc::new(StringArray::from_iter_values(rows.iter().map(|(_, r)| r.pipeline.word()))), false),
    ];
    let mut seen = |name: &str, value: &dyn Fn(&Row) -> Option<f64>| {
        columns.push((name.into(), Arc::new(rows.iter().map(value).collect::<Float64Array>()), true));
    };
    seen("width_m", &|(trial, _)| Some(trial.pose.width_m));
    seen("distance_m", &|(trial, _)| Some(trial.pose.distance_m));
    seen("lateral_m", &|(trial, _)| Some(trial.pose.lateral_m));
    seen("heading_rad", &|(trial, _)| Some(trial.pose.heading_rad));
    seen("lateral_error_m", &|(_, r)| r.score.lateral_error_m);
    seen("lateral_sigma_m", &|(_, r)| r.score.lateral_sigma_m);
    seen("heading_error_rad", &|(_, r)| r.score.heading_error_rad);
    seen("heading_sigma_rad", &|(_, r)| r.score.heading_sigma_rad);
    seen("lateral_bound_m", &|(trial, _)| trial.bounds.lateral_m);
    seen("heading_bound_rad", &|(trial, _)| trial.bounds.heading_rad);
    for (side, wall) in SIDES.iter().enumerate() {
        let word = wall.word();
        seen(&format!("{word}_wall_bound_m"), &|(trial, _)| trial.bounds.walls[side].map(|bound| bound.distance_m));
        seen(&format!("{word}_wall_heading_bound_rad"), &|(trial, _)| trial.bounds.walls[side].map(|bound| bound.heading_rad));
    }
    seen("centres_precision", &|(_, r)| r.score.centres.precision());
    seen("centres_recall", &|(_, r)| r.score.centres.recall());
    seen("centres_rms_px", &|(_, r)| r.score.centres.rms_px());
    seen("centres_nees", &|(_, r)| r.score.centres.mean_nees());
    seen("lines_rms_px", &|(_, r)| r.score.lines.rms_px());
    for wall in Wall::ALL {
        let of = |value: fn(&WallScore) -> Option<f64>| move |(_, r): &Row| r.score.wall(wall).and_then(value);
        let word = wall.word();
        seen(&format!("{word}_wall_m"), &of(|w| Some(w.distance_m)));
        seen(&format!("{word}_wall_from_camera_m"), &of(|w| Some(w.camera_distance_m)));
        seen(&format!("{word}_wall_columns"), &of(|w| Some(w.columns as f64)));
        seen(&format!("{word}_wall_error_m"), &of(|w| w.distance_error_m));
        seen(&format!("{word}_wall_sigma_m"), &of(|w| w.distance_sigma_m));
        seen(&format!("{word}_wall_heading_error_rad"), &of(|w| w.heading_error_rad));
        seen(&format!("{word}_wall_heading_sigma_rad"), &of(|w| w.heading_sigma_rad));
        seen(&format!("{word}_wall_normal_error_rad"), &of(|w| w.normal_error_rad));
    }
    to_parquet(&RecordBatch::try_from_iter_with_nullable(columns)?)
}
