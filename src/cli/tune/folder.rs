//! A study's folder, which is its own, for one call at a time.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use ductloop::output::{folder_name, write_whole};
use ductloop::scenario::study_file::StudyFile;

use super::args::{Driver, TuneArgs};
use super::optimiser;
use crate::cli::destination;
use crate::cli::problem::Problem;

/// The study as it was begun, beside its results.
const STUDY: &str = "study.json";
/// Held by the call that is at work.
const LOCK: &str = "lock";
/// The results' table of runs.
pub(super) const RUNS: &str = "runs";
/// What a study leaves.
pub(super) const BEST: &str = "best.toml";
pub(super) const TRIALS: &str = "trials.parquet";
pub(super) const SUMMARY: &str = "summary.json";
pub(super) const REPORT: &str = "report.html";
/// Overlays of the front, where there are several objectives.
pub(super) const FRONT: &str = "front";

/// The folder, which nobody else works in.
pub(super) struct Folder {
    pub(super) path: PathBuf,
    /// What is to stand in [`STUDY`].
    text: String,
    _lock: File,
}

impl Folder {
    /// Makes it, or finds it.
    ///
    /// # Errors
    /// Where it is another study's and `--force` is not given, somebody else's, cannot be written, or another call is at work in it.
    pub(super) fn open(study: &StudyFile, driver: Option<&Driver>, args: &TuneArgs) -> Result<Self, Problem> {
        destination::folder("--out", &args.out)?;
        let text = serde_json::to_string_pretty(study).unwrap_or_default() + "\n";
        // Who else proposes has a folder beside the study's own.
        let (name, changed) = match driver {
            None => (study.name.clone(), false),
            Some(Driver::Optuna { .. }) => (format!("{}-optuna", study.name), false),
            Some(Driver::Command(_)) => (study.name.clone(), true),
        };
        let changed = changed || args.overlay.overlays() != Default::default();
        let path = args.out.join(folder_name(&name, changed, study.seed, &text));
        let refused = |error: std::io::Error| destination::refused("--out", &args.out, format!("{}: {error}", path.display()));
        let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message);
        let elsewhere = "choose another folder with --out";
        if !path.join(STUDY).exists() && holds_other_things(&path) && !args.force {
            let message =
                format!("{} is not empty and holds no {STUDY}, so it is not a study's and is left alone", path.display());
            return Err(wrong(message).help(format!("move it away, or {elsewhere}")));
        }
        std::fs::create_dir_all(&path).map_err(refused)?;
        let lock = File::create(path.join(LOCK)).map_err(refused)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let message = format!("another call is at work in {}", path.display());
                return Err(wrong(message).help(format!("wait for its end, or {elsewhere}")));
            }
            // A file system that knows no locks.
            Err(TryLockError::Error(_)) => {}
        }
        match std::fs::read_to_string(path.join(STUDY)) {
            Ok(there) if there == text => {}
            Ok(_) if !args.force => {
                let message = format!("{} holds another study, or this one as it was before its files changed", path.display());
                return Err(
                    wrong(message).help(format!("replace it with --force (runs that both have are kept), or {elsewhere}"))
                );
            }
            // What was proposed and found in another one is none of this one's.
            Ok(_) | Err(_) => clear(&path).map_err(refused)?,
        }
        Ok(Self { path, text, _lock: lock })
    }

    /// Says which study is at work in it.
    ///
    /// # Errors
    /// Where that cannot be written.
    pub(super) fn begin(&self, args: &TuneArgs) -> Result<(), Problem> {
        write_whole(&self.path.join(STUDY), self.text.as_bytes())
            .map_err(|error| destination::refused("--out", &args.out, error.to_string()))
    }
}

/// Whether there is something in a folder that no study leaves before it has begun.
fn holds_other_things(folder: &Path) -> bool {
    let known = [RUNS, LOCK, optimiser::JOURNAL, optimiser::LOG, optimiser::OPTUNA_NAME];
    let mut entries = folder.read_dir().into_iter().flatten().flatten();
    entries.any(|entry| !known.iter().any(|name| entry.file_name() == *name))
}

/// Removes what a study leaves but its runs, and the study last.
fn clear(folder: &Path) -> std::io::Result<()> {
    for name in [optimiser::JOURNAL, BEST, TRIALS, SUMMARY, REPORT, STUDY] {
        gone(std::fs::remove_file(folder.join(name)))?;
    }
    gone(std::fs::remove_dir_all(folder.join(FRONT)))
}

/// What was not there is gone, too.
fn gone(removed: std::io::Result<()>) -> std::io::Result<()> {
    match removed {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
