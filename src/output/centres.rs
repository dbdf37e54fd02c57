//! `*.centres.parquet`: the middles of the stripes as they truly are, a row a point.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt16Array};
use ductloop_sensor::truth::CentrePoint;
use parquet::errors::ParquetError;

use super::frames::to_parquet;

/// The table: `laser` (its name), `u_px`, `v_px` (pixel (0, 0) is the centre of the first), the point in the camera frame
/// `x_m`, `y_m`, `z_m`, the number of its `surface`, and the angle `fan_rad` from the middle of the laser's fan.
///
/// # Errors
/// None that is known of: the file is made in memory.
pub fn parquet(centres: &[CentrePoint], lasers: &[&str]) -> Result<Vec<u8>, ParquetError> {
    let number =
        |value: fn(&CentrePoint) -> f64| -> ArrayRef { Arc::new(Float64Array::from_iter_values(centres.iter().map(value))) };
    let names = centres.iter().map(|c| lasers.get(c.laser).copied().unwrap_or("?"));
    let columns: [(&str, ArrayRef); 8] = [
        ("laser", Arc::new(StringArray::from_iter_values(names))),
        ("u_px", number(|c| c.u_px)),
        ("v_px", number(|c| c.v_px)),
        ("x_m", number(|c| c.point_in_camera_m[0])),
        ("y_m", number(|c| c.point_in_camera_m[1])),
        ("z_m", number(|c| c.point_in_camera_m[2])),
        ("surface", Arc::new(UInt16Array::from_iter_values(centres.iter().map(|c| c.surface)))),
        ("fan_rad", number(|c| c.fan_rad)),
    ];
    to_parquet(&RecordBatch::try_from_iter(columns)?)
}
