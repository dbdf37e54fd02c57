//! A run's folder: checked before anything simulates, filled aside, then put in place at once.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::xxh3_64;

use super::stage_name::{beside, is_of_the_dead};
use super::whole_file::{flush_folder, try_in, write_flushed};

/// The file that makes a folder a run's folder.
const SCENARIO: &str = "scenario.toml";

/// A run's folder in the making. Nothing of it is seen under its name until [`RunFolder::publish`]; what was written until
/// then goes when this is dropped. A process that is killed leaves a hidden folder `.NAME.tmp-…`, which nothing reads.
#[derive(Debug)]
pub struct RunFolder {
    name: String,
    path: PathBuf,
    stage: PathBuf,
    scenario_toml: String,
    force: bool,
}

/// The folder that runs' folders are put into, read once for all runs of a call: of a hundred thousand each would read it anew.
#[derive(Debug)]
pub struct OutFolder {
    out: PathBuf,
    force: bool,
    /// Hidden things in it, which processes that were killed may have left.
    hidden: Vec<PathBuf>,
}

/// Why a run's folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The name is not one of a folder.
    #[error("`{0}` cannot be the name of a run's folder")]
    Name(String),
    /// There is a file of that name.
    #[error("{} is a file, and the run's folder would have that name: move it away, or choose another folder with --out", .0.display())]
    NotAFolder(PathBuf),
    /// There is a folder with other things in it.
    #[error(
        "{} is not empty and holds no {SCENARIO}, so it is not a run's folder and is left alone: move it away, or choose another \
         folder with --out",
        .0.display()
    )]
    NotARun(PathBuf),
    /// There is a run of another scenario.
    #[error(
        "{} holds a run of a different scenario (its {SCENARIO} differs): replace it with --force, or choose another folder with --out",
        .0.display()
    )]
    OtherScenario(PathBuf),
    /// The system refused.
    #[error("cannot {doing} {}: {error}", path.display())]
    System {
        /// What was tried.
        doing: &'static str,
        /// On what.
        path: PathBuf,
        /// What the system said.
        #[source]
        error: io::Error,
    },
}

/// Puts an action and a path to what the system says of it.
fn system<T>(doing: &'static str, path: &Path, result: io::Result<T>) -> Result<T, FolderError> {
    result.map_err(|error| FolderError::System { doing, path: path.to_owned(), error })
}

/// The name of a run's folder: the scenario's; with its seed and eight digits of a hash of the resolved scenario where the
/// command line `changed` the file.
pub fn folder_name(scenario_name: &str, changed: bool, seed: u64, scenario_toml: &str) -> String {
    if changed {
        // The upper half: eight of the sixteen digits.
        format!("{scenario_name}-s{seed}-{:08x}", xxh3_64(scenario_toml.as_bytes()) >> 32)
    } else {
        scenario_name.to_owned()
    }
}

impl OutFolder {
    /// Reads it. One that is not there yet, or cannot be read, holds nothing that is known of. With `force` runs of other scenarios
    /// may be replaced.
    pub fn read(out: &Path, force: bool) -> Self {
        let entries = fs::read_dir(out).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_hidden = |path: &PathBuf| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        Self { out: out.to_owned(), force, hidden: entries.filter(is_hidden).collect() }
    }

    /// The folder of a run in it, of which `scenario_toml` is the resolved scenario. Nothing is looked at yet.
    pub fn folder(&self, name: &str, scenario_toml: &str) -> RunFolder {
        let path = self.out.join(name);
        let (stage, scenario_toml) = (beside(&path, "tmp"), scenario_toml.to_owned());
        RunFolder { name: name.to_owned(), path, stage, scenario_toml, force: self.force }
    }

    /// Makes sure that what stands in the folder's place may be replaced.
    ///
    /// # Errors
    /// Where it may not, or the name is not one of a folder.
    pub fn look(&self, folder: &RunFolder) -> Result<(), FolderError> {
        let name = &folder.name;
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\', '\0']) {
            return Err(FolderError::Name(name.clone()));
        }
        self.clear_up_after_the_dead(&folder.path);
        folder.check_replaceable()
    }

    /// The same, and makes sure that the folder can be written: creates, writes and takes away again. What it finds holds for other
    /// folders with names that are no longer.
    ///
    /// # Errors
    /// As [`OutFolder::look`], and where the system refuses.
    pub fn try_out(&self, folder: &RunFolder) -> Result<(), FolderError> {
        self.look(folder)?;
        folder.try_out(&self.out)
    }

    /// Removes what processes that were killed have left beside a run's folder. One that was killed between the two renames of
    /// [`RunFolder::publish`] has left the earlier run under another name: it gets its own back.
    /// What may be of a process that lives is left alone ([`is_of_the_dead`]).
    fn clear_up_after_the_dead(&self, run: &Path) {
        for left in &self.hidden {
            let name = left.file_name().and_then(|name| name.to_str());
            let dead = |what| name.is_some_and(|name| is_of_the_dead(name, run, what));
            if dead("old") && !run.exists() {
                let _ = fs::rename(left, run);
            } else if dead("tmp") || dead("old") {
                let _ = fs::remove_dir_all(left);
            }
        }
    }
}

impl RunFolder {
    /// Makes sure that `out/name` can be written and may be replaced, and leaves everything as it was.
    ///
    /// `scenario_toml` is the resolved scenario. A folder that holds the same one is replaced, another run's only with `force`,
    /// and one that is not a run's never.
    ///
    /// # Errors
    /// Where the folder cannot be made, written or replaced.
    pub fn prepare(out: &Path, name: &str, scenario_toml: &str, force: bool) -> Result<Self, FolderError> {
        let all = OutFolder::read(out, force);
        let folder = all.folder(name, scenario_toml);
        all.try_out(&folder)?;
        Ok(folder)
    }

    /// Where the folder will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file, `frames/000123.png` say, into the folder in the making.
    ///
    /// # Errors
    /// Where the system refuses, a full disk for one.
    pub fn write(&self, file: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let path = self.stage.join(file);
        if let Some(folder) = path.parent() {
            system("create", folder, fs::create_dir_all(folder))?;
        }
        system("write", &path, write_flushed(&path, bytes))
    }

    /// Puts the folder in its place. Of an earlier run nothing remains.
    ///
    /// # Errors
    /// Where somebody else has put another thing there meanwhile, or the system refuses; the earlier run is then still there.
    pub fn publish(&self) -> Result<(), FolderError> {
        self.check_replaceable()?;
        system("flush", &self.stage, flush_folder(&self.stage))?;
        if fs::symlink_metadata(&self.path).is_err() {
            return system("create", &self.path, fs::rename(&self.stage, &self.path));
        }
        let old = beside(&self.path, "old");
        system("move away", &self.path, fs::rename(&self.path, &old))?;
        if let Err(error) = fs::rename(&self.stage, &self.path) {
            system("put back", &self.path, fs::rename(&old, &self.path))?;
            return system("replace", &self.path, Err(error));
        }
        system("remove", &old, fs::remove_dir_all(&old))
    }

    /// Whether what stands in the folder's place may go.
    fn check_replaceable(&self) -> Result<(), FolderError> {
        let path = &self.path;
        match fs::metadata(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return system("look at", path, Err(error)),
            Ok(found) if !found.is_dir() => return Err(FolderError::NotAFolder(path.clone())),
            Ok(_) => {}
        }
        match fs::read(path.join(SCENARIO)) {
            Ok(there) if there == self.scenario_toml.as_bytes() || self.force => Ok(()),
            Ok(_) => Err(FolderError::OtherScenario(path.clone())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let empty = system("look into", path, fs::read_dir(path))?.next().is_none();
                if empty { Ok(()) } else { Err(FolderError::NotARun(path.clone())) }
            }
            Err(error) => system("read", &path.join(SCENARIO), Err(error)),
        }
    }

    /// Creates, writes and removes, where the run will.
    fn try_out(&self, out: &Path) -> Result<(), FolderError> {
        try_in(
            out,
            |created| system("create", out, created),
            || {
                system("create", &self.stage, fs::create_dir(&self.stage))?;
                let probes = [self.stage.join("probe"), self.path.join(".ductloop-probe")];
                let count = if self.path.exists() { 2 } else { 1 };
                let tried = probes[..count].iter().try_for_each(|probe| {
                    system("write", probe, write_flushed(probe, b"probe").and_then(|()| fs::remove_file(probe)))
                });
                let _ = fs::remove_dir_all(&self.stage);
                tried
            },
        )
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        // After `publish` it is no longer there.
        let _ = fs::remove_dir_all(&self.stage);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn what_the_dead_have_left_is_cleared_up_and_what_they_moved_away_comes_back() {
        let out = tempfile::tempdir().expect("a folder");
        let leave = |path: PathBuf| {
            fs::create_dir(&path).expect("a folder");
            fs::write(path.join(SCENARIO), "a").expect("a file");
        };
        let living = |run: &str, what: &str| beside(&out.path().join(run), what);
        // No process has this number: Linux stops at 2^22.
        let as_of_the_dead = |path: PathBuf| {
            let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
            path.with_file_name(name.replace(&format!("-{}-", std::process::id()), "-4294967295-"))
        };
        for what in ["tmp", "old"] {
            leave(as_of_the_dead(living("straight", what)));
        }
        // A living process's, another run's, and those of a machine that is not this one.
        let mut kept = vec![living("straight", "tmp"), as_of_the_dead(living("other", "tmp"))];
        kept.extend(["tmp", "old"].map(|what| out.path().join(format!(".straight.{what}-elsewhere-4294967295-0"))));
        kept.iter().cloned().for_each(leave);
        RunFolder::prepare(out.path(), "straight", "a", false).expect("its own run");
        kept.push(out.path().join("straight"));
        let mut left: Vec<_> = fs::read_dir(out.path()).expect("it").flatten().map(|entry| entry.path()).collect();
        left.sort();
        kept.sort();
        assert_eq!(left, kept);
        assert_eq!(fs::read_to_string(out.path().join("straight").join(SCENARIO)).expect("it came back"), "a");
    }

    #[test]
    fn a_changed_scenario_gets_a_name_of_its_own() {
        assert_eq!(folder_name("straight", false, 1, "a"), "straight");
        let changed = folder_name("straight", true, 7, "a");
        let digits = changed.strip_prefix("straight-s7-").expect(&changed);
        assert!(digits.len() == 8 && digits.chars().all(|c| c.is_ascii_hexdigit()), "{changed}");
        assert_ne!(changed, folder_name("straight", true, 7, "b"));
    }
}
