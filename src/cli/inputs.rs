//! Files, folders and names to scenarios, all read and checked before anything runs.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use ductloop::Scenario;
use ductloop::scenario::{Diagnostics, FileKind, Overlays};

use super::args::OverlayArgs;
use super::problem::{Problem, Problems};

/// A scenario that was read without an error.
#[derive(Debug)]
pub(crate) struct Input {
    /// The file.
    pub(crate) file: PathBuf,
    /// What it says.
    pub(crate) scenario: Scenario,
    /// Whether the command line changed it.
    pub(crate) changed: bool,
}

/// Where a name is looked for.
const LIBRARY: &str = "scenarios";
/// The field that `--perception` sets.
const PIPELINE: &str = "perception.pipeline";
/// How much of a file is read to tell its kind.
const KIND_WITHIN_BYTES: u64 = 1 << 20;

impl OverlayArgs {
    pub(crate) fn overlays(&self) -> Overlays {
        let mut set = self.set.clone();
        set.extend(self.seed.map(|seed| format!("seed={seed}")));
        set.extend(self.perception.as_ref().map(|pipeline| format!("{PIPELINE}={pipeline}")));
        Overlays { with: self.with.clone(), set }
    }

    /// Names the argument that was typed, where an error is in the setting made of it.
    pub(crate) fn as_typed(&self, mut diagnostics: Diagnostics) -> Diagnostics {
        if let Some(pipeline) = &self.perception {
            let set = format!("--set {PIPELINE}={pipeline}");
            for diagnostic in diagnostics.0.iter_mut().filter(|diagnostic| diagnostic.file == set) {
                diagnostic.file = format!("--perception {pipeline}");
                diagnostic.place = None;
            }
        }
        diagnostics
    }
}

/// Reads every scenario that the inputs name.
///
/// # Errors
/// Everything that is wrong with any of them, and inputs that name nothing.
pub(crate) fn read(inputs: &[PathBuf], overlay: &OverlayArgs) -> Result<Vec<Input>, Problem> {
    let overlays = overlay.overlays();
    let changed = overlays != Overlays::default();
    let mut files = Vec::new();
    let mut problems = Problems::default();
    for input in inputs {
        match find(input) {
            Ok(found) => files.extend(found),
            Err(problem) => problems.note(problem),
        }
    }
    // The same file named twice is one run.
    let mut seen = BTreeSet::new();
    files.retain(|file| seen.insert(file.canonicalize().unwrap_or_else(|_| file.clone())));
    let mut read = Vec::new();
    let mut wrong = Vec::new();
    for file in files {
        match Scenario::read(&file, &overlays) {
            Ok(scenario) => read.push(Input { file, scenario, changed }),
            Err(diagnostics) => wrong.push(overlay.as_typed(diagnostics)),
        }
    }
    if !wrong.is_empty() {
        problems.note(Problem::in_files(wrong));
    }
    problems.or(read)
}

/// The files that an input names.
fn find(input: &Path) -> Result<Vec<PathBuf>, Problem> {
    let about = || input.display().to_string();
    if input.is_dir() {
        let mut files = Vec::new();
        walk(input, &mut BTreeSet::new(), &mut files).map_err(|(folder, error)| {
            Problem::new(Problem::WRONG_INPUT, format!("cannot be read: {error}")).about(folder.display().to_string())
        })?;
        if files.is_empty() {
            let none = Problem::new(Problem::WRONG_INPUT, "no scenario file (*.toml) below this folder").about(about());
            return Err(
                none.help("sweeps, studies, hidden files and the folders of runs are left alone; name a file to have it read")
            );
        }
        return Ok(files);
    }
    if input.exists() {
        return Ok(vec![input.to_owned()]);
    }
    let named = Path::new(LIBRARY).join(input).with_extension("toml");
    let is_name = input.components().count() == 1 && input.extension().is_none();
    if is_name && named.exists() {
        return Ok(vec![named]);
    }
    let looked = if is_name { format!("no such file or folder, and no {}", named.display()) } else { "no such file".into() };
    let known = names();
    let help =
        if known.is_empty() { "give the path of a scenario file".into() } else { format!("names here: {}", known.join(", ")) };
    Err(Problem::new(Problem::WRONG_INPUT, looked).about(about()).help(help))
}

/// Every scenario below a folder, in the order of their paths. Sweeps, studies and gauges are left alone, and so are hidden files and
/// folders, and below the folder that was named the folders of runs, whose scenarios stand elsewhere already. A file whose kind
/// cannot be told is taken, so that what is wrong with it is said. `seen` holds the folders walked so far: links may go round in
/// circles.
fn walk(folder: &Path, seen: &mut BTreeSet<PathBuf>, files: &mut Vec<PathBuf>) -> Result<(), (PathBuf, std::io::Error)> {
    let here = folder.canonicalize().map_err(|error| (folder.to_owned(), error))?;
    let first = seen.is_empty();
    if !seen.insert(here) || (!first && is_run(folder)) {
        return Ok(());
    }
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let mut paths: Vec<PathBuf> = entries.map_err(|error| (folder.to_owned(), error))?.iter().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b".")) {
            continue;
        }
        if path.is_dir() {
            walk(&path, seen, files)?;
        } else if path.extension().is_some_and(|ending| ending == "toml")
            // Nothing but a file: a named pipe would be waited for.
            && (path.is_file() || !path.exists())
            && !matches!(kind(&path), Some(FileKind::Sweep | FileKind::Study | FileKind::Accuracy | FileKind::Gauge))
        {
            files.push(path);
        }
    }
    Ok(())
}

/// Whether this is the folder of a run.
fn is_run(folder: &Path) -> bool {
    ["scenario.toml", "manifest.json", "summary.json"].iter().all(|file| folder.join(file).is_file())
}

/// What a file says it is.
pub(crate) fn kind(path: &Path) -> Option<FileKind> {
    let mut bytes = Vec::new();
    File::open(path).ok()?.take(KIND_WITHIN_BYTES).read_to_end(&mut bytes).ok()?;
    FileKind::of(&String::from_utf8_lossy(&bytes))
}

/// Names that would be found.
fn names() -> Vec<String> {
    let mut files = Vec::new();
    let _ = walk(Path::new(LIBRARY), &mut BTreeSet::new(), &mut files);
    files.iter().filter_map(|file| Some(file.file_stem()?.to_str()?.to_owned())).collect()
}
