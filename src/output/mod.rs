//! What a run writes: its folder, and the JUnit file of a call.
//!
//! - [`summary`]: verdict and figures, `summary.json`;
//! - [`manifest`]: what made them and where, `manifest.json`;
//! - [`frames`]: a row a frame, `frames.parquet`;
//! - [`key_frames`]: some frames as pictures, `frames/*.png`;
//! - [`words`]: figures, bounds and reasons as people read them;
//! - [`folder`]: the run's folder, whole or not at all;
//! - [`junit`]: all runs of a call for a CI server.
//!
//! The report's pages are made by [`crate::report`] from the same parts.

pub mod folder;
pub mod frames;
pub mod junit;
pub mod key_frames;
pub mod manifest;
pub mod summary;
mod whole_file;
pub mod words;

pub use folder::{FolderError, RunFolder, folder_name};
pub use junit::write_junit;
pub use manifest::Manifest;
pub use summary::Summary;
pub use whole_file::write as write_whole;

use crate::record::RunRecord;
use crate::report::{self, ReportError};
use crate::scenario::Scenario;

/// Why a run's folder could not be filled.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder would not take a file.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The table of frames could not be made.
    #[error("frames.parquet cannot be made: {0}")]
    Frames(#[from] parquet::errors::ParquetError),
    /// A picture could not be made.
    #[error("a picture of a frame cannot be made: {0}")]
    Picture(#[from] image::ImageError),
    /// A document could not be made.
    #[error("a JSON document cannot be made: {0}")]
    Json(#[from] serde_json::Error),
    /// The report could not be made.
    #[error("report.html cannot be made: {0}")]
    Report(#[from] ReportError),
}

/// Writes everything that a run leaves and puts the folder in its place, where it replaces an earlier one.
///
/// # Errors
/// When anything cannot be made or written; the folder is then as it was before.
pub fn write_run(
    folder: &RunFolder,
    scenario: &Scenario,
    run: &RunRecord,
    summary: &Summary,
    manifest: &Manifest,
) -> Result<(), WriteError> {
    folder.write("scenario.toml", scenario.to_toml().as_bytes())?;
    folder.write("manifest.json", manifest.to_json()?.as_bytes())?;
    folder.write("frames.parquet", &frames::parquet(&run.frames)?)?;
    for (name, picture) in key_frames::pictures(run, &scenario.rig.camera)? {
        folder.write(&name, &picture)?;
    }
    folder.write("report.html", report::html(scenario, run, summary, manifest)?.as_bytes())?;
    folder.write("summary.json", summary.to_json()?.as_bytes())?;
    Ok(folder.publish()?)
}
