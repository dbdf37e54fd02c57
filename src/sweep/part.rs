//! Outcomes as a Parquet file that tells when it was damaged: a hash of its rows stands in its metadata.

use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use xxhash_rust::xxh3::xxh3_128;

use super::outcome::Outcome;
use super::store::Bytes;
use crate::metrics::{Metrics, Verdict};

/// The key of the hash in the file's metadata.
const ROWS_HASH: &str = "ductloop.rows_xxh3_128";

/// Why a part cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// It is no Parquet file any more, or not yet.
    #[error("it is no whole Parquet file: {0}")]
    Parquet(#[from] ParquetError),
    /// A batch of it cannot be read.
    #[error("its rows cannot be read: {0}")]
    Rows(#[from] arrow_schema::ArrowError),
    /// A column is missing or has another type.
    #[error("it has no column `{0}` of the type that it should have")]
    Column(&'static str),
    /// A cell holds what it cannot.
    #[error("row {row} has `{value}` in column `{column}`")]
    Cell {
        /// The row, from 0.
        row: usize,
        /// The column.
        column: &'static str,
        /// What stands there.
        value: String,
    },
    /// Its rows are not those that were written.
    #[error("its rows are not those that were written: their hash differs")]
    Damaged,
}

/// Writes a part.
///
/// # Errors
/// None that is known of: it is made in memory.
pub fn write(outcomes: &[Outcome]) -> Result<Vec<u8>, ParquetError> {
    let text = |value: &dyn Fn(&Outcome) -> Option<String>| -> ArrayRef {
        Arc::new(outcomes.iter().map(value).collect::<StringArray>())
    };
    let number =
        |value: &dyn Fn(&Outcome) -> Option<f64>| -> ArrayRef { Arc::new(outcomes.iter().map(value).collect::<Float64Array>()) };
    let mut columns: Vec<(&str, ArrayRef, bool)> = vec![
        ("hash", text(&|o| Some(format!("{:032x}", o.hash))), false),
        ("verdict", text(&|o| Some(o.verdict.word().to_owned())), false),
        ("reasons", text(&|o| Some(o.reasons.clone())), false),
        ("end_state", text(&|o| o.end_state.clone()), true),
        ("run_hash", text(&|o| o.run_hash.clone()), true),
        ("error", text(&|o| o.error.clone()), true),
        ("host", text(&|o| Some(o.host.clone())), false),
        ("wall_time_s", number(&|o| Some(o.wall_time_s)), false),
    ];
    for (index, name) in Metrics::NUMBERS.iter().enumerate() {
        columns.push((name, number(&|o| o.metrics[index]), true));
    }
    let batch = RecordBatch::try_from_iter_with_nullable(columns)?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(vec![KeyValue::new(ROWS_HASH.to_owned(), rows_hash(outcomes))]))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))?;
    writer.write(&batch)?;
    writer.close()?;
    Ok(bytes)
}

/// Reads a part back.
///
/// # Errors
/// Where any bit of it is not what was written.
pub fn read(bytes: Bytes) -> Result<Vec<Outcome>, PartError> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(bytes)?;
    let metadata = builder.metadata().file_metadata().key_value_metadata();
    let told = metadata.into_iter().flatten().find(|pair| pair.key == ROWS_HASH).and_then(|pair| pair.value.clone());
    let mut outcomes = Vec::new();
    for batch in builder.build()? {
        rows(&batch?, &mut outcomes)?;
    }
    if told.as_deref() == Some(rows_hash(&outcomes).as_str()) { Ok(outcomes) } else { Err(PartError::Damaged) }
}

/// A hash of the rows as JSON, whose numbers are the shortest that read back as they were.
fn rows_hash(outcomes: &[Outcome]) -> String {
    // Everything in an outcome can be written as JSON.
    let text = serde_json::to_string(outcomes).unwrap_or_default();
    format!("{:032x}", xxh3_128(text.as_bytes()))
}

fn rows(batch: &RecordBatch, outcomes: &mut Vec<Outcome>) -> Result<(), PartError> {
    let text = |name: &'static str| {
        let column = batch.column_by_name(name).and_then(|column| column.as_string_opt::<i32>());
        column.ok_or(PartError::Column(name))
    };
    let number = |name: &'static str| {
        let column = batch.column_by_name(name).and_then(|column| column.as_primitive_opt::<Float64Type>());
        column.ok_or(PartError::Column(name))
    };
    let (hash, verdict, reasons) = (text("hash")?, text("verdict")?, text("reasons")?);
    let (end_state, run_hash, error, host) = (text("end_state")?, text("run_hash")?, text("error")?, text("host")?);
    let wall_time_s = number("wall_time_s")?;
    let mut metrics = Vec::new();
    for name in Metrics::NUMBERS {
        metrics.push(number(name)?);
    }
    for row in 0..batch.num_rows() {
        let wrong = |column, value: &str| PartError::Cell { row, column, value: value.to_owned() };
        let some = |column: &StringArray| (!column.is_null(row)).then(|| column.value(row).to_owned());
        outcomes.push(Outcome {
            hash: u128::from_str_radix(hash.value(row), 16).map_err(|_| wrong("hash", hash.value(row)))?,
            verdict: Verdict::of(verdict.value(row)).ok_or_else(|| wrong("verdict", verdict.value(row)))?,
            reasons: reasons.value(row).to_owned(),
            end_state: some(end_state),
            metrics: std::array::from_fn(|i| (!metrics[i].is_null(row)).then(|| metrics[i].value(row))),
            run_hash: some(run_hash),
            error: some(error),
            wall_time_s: wall_time_s.value(row),
            host: host.value(row).to_owned(),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn outcomes() -> Vec<Outcome> {
        let one = Outcome {
            hash: 0x0123_4567_89ab_cdef_0123_4567_89ab_cdef,
            verdict: Verdict::Pass,
            reasons: String::new(),
            end_state: Some("finished".into()),
            metrics: std::array::from_fn(|i| (i % 3 != 0).then_some(0.1 * i as f64)),
            run_hash: Some("ab".into()),
            error: None,
            wall_time_s: 1.25,
            host: "a host".into(),
        };
        let other = Outcome {
            hash: 1,
            verdict: Verdict::Error,
            reasons: "lateral_rms_m, collisions".into(),
            end_state: None,
            metrics: Default::default(),
            run_hash: None,
            error: Some("no\n\"duct\"".into()),
            ..one.clone()
        };
        vec![one, other]
    }

    #[test]
    fn what_was_written_comes_back() {
        let bytes = write(&outcomes()).expect("it can be written");
        assert_eq!(read(bytes.into()).expect("it can be read"), outcomes());
        assert_eq!(read(write(&[]).expect("none").into()).expect("none"), []);
    }

    proptest! {
        /// A bit that has changed, or a file that was cut, gives an error or the same rows: never others, and no panic.
        #[test]
        fn damage_is_noticed(at in 0_usize..100_000, bit in 0_u8..8, cut in any::<bool>()) {
            let whole = write(&outcomes()).expect("it can be written");
            let at = at % whole.len();
            let mut bytes = whole;
            if cut { bytes.truncate(at) } else { bytes[at] ^= 1 << bit }
            if let Ok(read) = read(bytes.into()) {
                prop_assert_eq!(read, outcomes());
            }
        }
    }
}
