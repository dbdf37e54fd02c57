//! Every file that a run leaves, made and put into its folder.

use crate::output::{FolderError, Manifest, RunFolder, Summary, frames, key_frames};
use crate::record::RunRecord;
use crate::report::{self, ReportError};
use crate::scenario::Scenario;
use crate::survey::{Survey, ply};

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
    for (name, picture) in key_frames::pictures(run)? {
        folder.write(&name, &picture)?;
    }
    if let Some(survey) = Survey::of(scenario, run) {
        folder.write("survey.json", survey.to_json()?.as_bytes())?;
    }
    if let Some(cloud) = ply::bytes(&run.notes) {
        folder.write("survey.ply", &cloud)?;
    }
    folder.write("report.html", report::html(scenario, run, summary, manifest)?.as_bytes())?;
    folder.write("summary.json", summary.to_json()?.as_bytes())?;
    Ok(folder.publish()?)
}
