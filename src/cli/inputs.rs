//! Files, folders and names to scenarios, all read and checked before anything runs.

use std::path::{Path, PathBuf};

use ductloop::Scenario;
use ductloop::scenario::{FileKind, Overlays};

use super::args::OverlayArgs;
use super::problem::Problem;

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

impl OverlayArgs {
    fn overlays(&self) -> Overlays {
        let mut set = self.set.clone();
        set.extend(self.seed.map(|seed| format!("seed={seed}")));
        set.extend(self.perception.as_ref().map(|pipeline| format!("perception.pipeline={pipeline}")));
        Overlays { with: self.with.clone(), set }
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
    let mut problems: Option<Problem> = None;
    let mut note = |problem: Problem| {
        problems = Some(match problems.take() {
            Some(before) => before.and(problem),
            None => problem,
        });
    };
    for input in inputs {
        match find(input) {
            Ok(found) => files.extend(found),
            Err(problem) => note(problem),
        }
    }
    // The same file named twice is one run.
    let mut seen = std::collections::BTreeSet::new();
    files.retain(|file| seen.insert(file.canonicalize().unwrap_or_else(|_| file.clone())));
    let mut read = Vec::new();
    let mut wrong = Vec::new();
    for file in files {
        match Scenario::read(&file, &overlays) {
            Ok(scenario) => read.push(Input { file, scenario, changed }),
            Err(diagnostics) => wrong.push(diagnostics),
        }
    }
    if !wrong.is_empty() {
        note(Problem::in_files(wrong));
    }
    problems.map_or(Ok(read), Err)
}

/// The files that an input names.
fn find(input: &Path) -> Result<Vec<PathBuf>, Problem> {
    let about = || input.display().to_string();
    if input.is_dir() {
        let mut files = Vec::new();
        walk(input, &mut files).map_err(|(folder, error)| {
            Problem::new(Problem::WRONG_INPUT, format!("cannot be read: {error}")).about(folder.display().to_string())
        })?;
        if files.is_empty() {
            return Err(Problem::new(Problem::WRONG_INPUT, "no scenario file (*.toml) below this folder").about(about()));
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

/// Every scenario below a folder, in the order of their paths. Sweeps and studies are left alone; a file whose kind cannot be
/// told is taken, so that what is wrong with it is said.
fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), (PathBuf, std::io::Error)> {
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let mut paths: Vec<PathBuf> = entries.map_err(|error| (folder.to_owned(), error))?.iter().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            walk(&path, files)?;
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            let kind = std::fs::read_to_string(&path).ok().and_then(|text| FileKind::of(&text));
            if !matches!(kind, Some(FileKind::Sweep | FileKind::Study)) {
                files.push(path);
            }
        }
    }
    Ok(())
}

/// Names that would be found.
fn names() -> Vec<String> {
    let mut files = Vec::new();
    let _ = walk(Path::new(LIBRARY), &mut files);
    files.iter().filter_map(|file| Some(file.file_stem()?.to_str()?.to_owned())).collect()
}
