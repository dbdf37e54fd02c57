//! Outcomes as a Parquet file that tells when it was damaged: a hash of all of its bytes stands in its metadata. It is looked at before
//! anything else is, as readers of Parquet may panic over damaged files.

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
const SEAL: &str = "ductloop.seal";
/// What stands before its digits.
const MARK: &[u8] = b"xxh3-128:";
/// The digits while they are not known, and where the hash is taken.
const BLANK: [u8; 32] = [b'0'; 32];

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
    /// It is not what was written.
    #[error("it is cut or damaged: its hash is not that of what was written")]
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
        .set_key_value_metadata(Some(vec![KeyValue::new(
            SEAL.to_owned(),
            String::from_utf8_lossy(&[MARK, &BLANK].concat()).into_owned(),
        )]))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))?;
    writer.write(&batch)?;
    writer.close()?;
    if let Some(digits) = digits(&bytes) {
        let seal = format!("{:032x}", xxh3_128(&bytes));
        bytes[digits].copy_from_slice(seal.as_bytes());
    }
    Ok(bytes)
}

/// Reads a part back.
///
/// # Errors
/// Where any bit of it is not what was written.
pub fn read(bytes: Bytes) -> Result<Vec<Outcome>, PartError> {
    if !is_whole(&bytes) {
        return Err(PartError::Damaged);
    }
    let mut outcomes = Vec::new();
    for batch in ParquetRecordBatchReaderBuilder::try_new(bytes)?.build()? {
        rows(&batch?, &mut outcomes)?;
    }
    Ok(outcomes)
}

/// Where the digits of the hash stand: behind the last mark.
fn digits(bytes: &[u8]) -> Option<std::ops::Range<usize>> {
    let mark = bytes.windows(MARK.len()).rposition(|window| window == MARK)?;
    let from = mark + MARK.len();
    (from + BLANK.len() <= bytes.len()).then(|| from..from + BLANK.len())
}

/// Whether a part's bytes are those that were written.
fn is_whole(bytes: &[u8]) -> bool {
    let Some(digits) = digits(bytes) else { return false };
    let mut blank = bytes.to_vec();
    blank[digits.clone()].copy_from_slice(&BLANK);
    bytes[digits] == *format!("{:032x}", xxh3_128(&blank)).as_bytes()
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
        /// A bit that has changed, wherever, or a file that was cut gives an error, and no panic.
        #[test]
        fn damage_is_noticed(at in 0_usize..100_000, bit in 0_u8..8, cut in any::<bool>()) {
            let whole = write(&outcomes()).expect("it can be written");
            let at = at % whole.len();
            let mut bytes = whole;
            if cut { bytes.truncate(at) } else { bytes[at] ^= 1 << bit }
            prop_assert!(matches!(read(bytes.into()), Err(PartError::Damaged)));
        }
    }
}
