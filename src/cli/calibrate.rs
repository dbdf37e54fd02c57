//! `ductloop calibrate`: pixels of known position to the sensor's geometry.

use std::path::{Path, PathBuf};

use clap::Args;
use ductloop::calibrate::linear::Applied;
use ductloop::calibrate::matrix;
use ductloop::calibrate::points::Points;
use ductloop::output::write_whole;
use ductloop::scenario::Diagnostics;
use serde_json::Value;

use super::destination;
use super::problem::Problem;
use super::streams::{note, print, print_json};

/// What may be typed behind `calibrate`.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop calibrate right.csv                                 equation 14: the matrix T of one laser, and how well it is known
  ductloop calibrate right.csv --out T.csv                     the same, written as a table
  ductloop calibrate left.csv --apply T.csv --laser left       positions and misses by a given T

POINTS.csv has the columns u_px,v_px,x_mm,y_mm,z_mm: pixels, and their positions on a gauge. Others are left alone; lines that
begin with # are comments. At least four points are needed of which no three lie on a line.")]
pub(crate) struct CalibrateArgs {
    /// Table of pixels and positions of one laser
    #[arg(value_name = "POINTS.csv")]
    pub(crate) points: PathBuf,
    /// Triangulate with the T of this file instead of solving for one
    #[arg(long, value_name = "T.csv")]
    pub(crate) apply: Option<PathBuf>,
    /// Which T of the file of --apply; with --out, the name that T is written under
    #[arg(long, value_name = "NAME")]
    pub(crate) laser: Option<String>,
    /// Write T as a table, for --apply
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Carries it out.
///
/// # Errors
/// Files that cannot be read or written, and points that determine nothing.
pub(crate) fn command(args: &CalibrateArgs) -> Result<u8, Problem> {
    if let Some(out) = &args.out {
        destination::file("--out", out)?;
    }
    let points = Points::read(&args.points).map_err(in_file)?;
    let applied = match &args.apply {
        Some(file) => Applied::apply(matrix::read(file, args.laser.as_deref()).map_err(in_file)?, &points),
        None => Applied::solve(&points).map_err(in_file)?,
    };
    let name = args.laser.clone().unwrap_or_else(|| stem(&args.points));
    finish(args, &applied.to_json(&points), &applied.to_text(&points), || matrix::to_csv(&name, &applied.t))
}

/// Writes the file and tells the result.
fn finish(args: &CalibrateArgs, document: &Value, text: &str, file: impl FnOnce() -> String) -> Result<u8, Problem> {
    if let Some(out) = &args.out {
        let lost = |error| Problem::new(Problem::CANNOT_GO_ON, format!("{error}")).about(out.display().to_string());
        write_whole(out, file().as_bytes()).map_err(lost)?;
        note(&format!("written: {}", out.display()));
    }
    if args.json { print_json(document)? } else { print(text)? }
    Ok(0)
}

fn in_file(diagnostics: Diagnostics) -> Problem {
    Problem::in_files(vec![diagnostics])
}

/// A file's name without folder and ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}
