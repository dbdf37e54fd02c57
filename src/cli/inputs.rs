//! Files, folders and names to scenarios, all read and checked before anything runs.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use ductloop::scenario::{Diagnostics, FileKind, Overlays, near};
use ductloop::{Scenario, library};

use super::args::OverlayArgs;
use super::problem::{Problem, Problems};
use super::source::Source;

/// A scenario that was read without an error.
#[derive(Debug)]
pub(crate) struct Input {
    /// Where it comes from.
    pub(crate) source: Source,
    /// What it says.
    pub(crate) scenario: Scenario,
    /// Whether the command line changed it.
    pub(crate) changed: bool,
}

/// The folder in which a name is looked for before the library.
const HERE: &str = "scenarios";
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
    let mut sources = Vec::new();
    let mut problems = Problems::default();
    for input in inputs {
        match find(input) {
            Ok(found) => sources.extend(found),
            Err(problem) => problems.note(problem),
        }
    }
    // The same file named twice is one run.
    let mut seen = BTreeSet::new();
    sources.retain(|source| seen.insert(source.place()));
    let mut read = Vec::new();
    let mut wrong = Vec::new();
    for source in sources {
        match source.read(&overlays) {
            Ok(scenario) => read.push(Input { source, scenario, changed }),
            Err(diagnostics) => wrong.push(overlay.as_typed(diagnostics)),
        }
    }
    if !wrong.is_empty() {
        problems.note(Problem::in_files(wrong));
    }
    problems.or(read)
}

/// What an input names: the scenarios below a folder, a file, a scenario below `./scenarios`, or one of the library, looked for in this
/// order.
fn find(input: &Path) -> Result<Vec<Source>, Problem> {
    if !input.is_dir() {
        return one(input).map(|source| vec![source]);
    }
    let mut files = Vec::new();
    walk(input, &mut BTreeSet::new(), &mut files).map_err(|(folder, error)| {
        Problem::new(Problem::WRONG_INPUT, format!("cannot be read: {error}")).about(folder.display().to_string())
    })?;
    if files.is_empty() {
        let none = Problem::new(Problem::WRONG_INPUT, "no scenario file (*.toml) below this folder");
        return Err(none
            .about(input.display().to_string())
            .help("sweeps, studies, hidden files and the folders of runs are left alone; name a file to have it read"));
    }
    Ok(files.into_iter().map(Source::File).collect())
}

/// The one scenario that a file or name stands for.
///
/// # Errors
/// Where there is none, or several below `./scenarios` have the name.
pub(crate) fn one(input: &Path) -> Result<Source, Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(input.display().to_string());
    if input.exists() {
        return Ok(Source::File(input.to_owned()));
    }
    let is_name = input.components().count() == 1 && input.extension().is_none();
    let Some(name) = input.to_str().filter(|_| is_name) else {
        return Err(wrong("no such file".into()).help(not_there(input)));
    };
    let at_the_top = Path::new(HERE).join(name).with_extension("toml");
    let mut here = if at_the_top.exists() { vec![at_the_top] } else { below_here() };
    here.retain(|file| stem(file) == Some(name));
    match (&here[..], library::get(name)) {
        ([file], _) => Ok(Source::File(file.clone())),
        ([], Some(entry)) => Ok(Source::Library(entry)),
        ([], None) => {
            let message = format!("no such file or folder, no {name}.toml below ./{HERE}, and none of the library");
            Err(wrong(message).help(not_there(input)))
        }
        (several, _) => {
            let several: Vec<_> = several.iter().map(|file| file.display().to_string()).collect();
            Err(wrong(format!("{} scenarios have this name: {}", several.len(), several.join(", ")))
                .help("name one of the files"))
        }
    }
}

/// What helps where a name stands for nothing: what it is near to.
fn not_there(input: &Path) -> String {
    const ALL: &str = "`ductloop list` shows the library";
    let typed = stem(input).unwrap_or_default();
    if library::get(typed).is_some() {
        return format!("the library has a `{typed}`: give its name alone, without folder and ending");
    }
    let here = below_here();
    let known = here.iter().filter_map(|file| stem(file)).chain(library::all().iter().map(|entry| entry.name));
    match &near(typed, known)[..] {
        [] => format!("give the path of a scenario file, or a name; {ALL}"),
        near => format!("did you mean {}? {ALL}", near.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ")),
    }
}

fn stem(file: &Path) -> Option<&str> {
    file.file_stem()?.to_str()
}

/// Every scenario below `./scenarios`, as far as it can be read.
fn below_here() -> Vec<PathBuf> {
    let mut files = Vec::new();
    let _ = walk(Path::new(HERE), &mut BTreeSet::new(), &mut files);
    files
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
