//! `ductloop schema`: the file formats as JSON Schema.

use clap::{Args, ValueEnum};
use ductloop::calibrate::gauge;
use ductloop::scenario::{self, accuracy_file, study_file, sweep_file};

use super::problem::Problem;
use super::streams::print_json;

/// What may be typed.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop schema > scenario.schema.json                    of scenarios
  ductloop schema --kind accuracy > accuracy.schema.json    of accuracy studies

An editor takes the schema that a file's first line names (Taplo, Even Better TOML): `#:schema ./scenario.schema.json`.")]
pub(crate) struct SchemaArgs {
    /// Of which kind of file: what its `kind` says
    #[arg(long, value_enum, default_value_t = Kind::Scenario)]
    pub(crate) kind: Kind,
}

/// Kinds of files that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// A run
    Scenario,
    /// A grid of poses, each rendered and estimated: `ductloop accuracy`
    Accuracy,
    /// A design of experiments: `ductloop sweep`
    Sweep,
    /// A search over many runs: `ductloop tune`
    Study,
    /// A calibration with a simulated block gauge: `ductloop calibrate --gauge`
    Gauge,
}

/// Prints it.
///
/// # Errors
/// Where nothing can be written to standard output.
pub(crate) fn command(args: &SchemaArgs) -> Result<u8, Problem> {
    let schema = match args.kind {
        Kind::Scenario => scenario::schema(),
        Kind::Accuracy => accuracy_file::schema(),
        Kind::Sweep => sweep_file::schema(),
        Kind::Study => study_file::schema(),
        Kind::Gauge => gauge::schema(),
    };
    print_json(&schema).map(|()| 0)
}
