//! A run's folder: checked before anything simulates, filled aside, then put in place at once.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::xxh3_64;

use super::whole_file::{beginning, beside, flush_folder, try_in, write_flushed};

/// The file that makes a folder a run's folder.
const SCENARIO: &str = "scenario.toml";

/// A run's folder in the making. Nothing of it is seen under its name until [`RunFolder::publish`]; what was written until
/// then goes when this is dropped. A process that is killed leaves a hidden `.NAME.tmp-PID`, which nothing reads.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    stage: PathBuf,
    scenario_toml: String,
    force: bool,
}

/// Why a run's folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The name is not one of a folder.
    #[error("`{0}` cannot be the name of a run's folder")]
    Name(String),
    /// There is a file of that name.
    #[error("{} is a file; the run's folder would have that name", .0.display())]
    NotAFolder(PathBuf),
    /// There is a folder with other things in it.
    #[error(
        "{} is not empty and holds no {SCENARIO}, so it is not a run's folder and is left alone: move it away, or choose another folder with --out",
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

impl RunFolder {
    /// Makes sure that `out/name` can be written and may be replaced, and leaves everything as it was.
    ///
    /// `scenario_toml` is the resolved scenario. A folder that holds the same one is replaced, another run's only with `force`,
    /// and one that is not a run's never.
    ///
    /// # Errors
    /// Where the folder cannot be made, written or replaced.
    pub fn prepare(out: &Path, name: &str, scenario_toml: &str, force: bool) -> Result<Self, FolderError> {
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\', '\0']) {
            return Err(FolderError::Name(name.to_owned()));
        }
        let path = out.join(name);
        let folder = Self { stage: beside(&path, "tmp"), path, scenario_toml: scenario_toml.to_owned(), force };
        folder.clear_up_after_the_dead(out);
        folder.check_replaceable()?;
        folder.try_out(out)?;
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

    /// Removes what processes that were killed have left beside the folder. One that was killed between the two renames of
    /// [`Self::publish`] has left the earlier run under another name: it gets its own back.
    ///
    /// Which processes live is read from `/proc`; where there is none, everything is left alone.
    fn clear_up_after_the_dead(&self, out: &Path) {
        let alive = |process: &str| Path::new("/proc").join(process).exists();
        let Ok(entries) = fs::read_dir(out) else { return };
        if !alive("self") {
            return;
        }
        let [tmp, old] = ["tmp", "old"].map(|what| beginning(&self.path, what));
        for entry in entries.flatten() {
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            let dead =
                |of: &String| name.strip_prefix(of).is_some_and(|process| process.parse::<u32>().is_ok() && !alive(process));
            if dead(&old) && !self.path.exists() {
                let _ = fs::rename(entry.path(), &self.path);
            } else if dead(&tmp) || dead(&old) {
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }

    /// Creates, writes and removes, where the run will.
    fn try_out(&self, out: &Path) -> Result<(), FolderError> {
        try_in(
            out,
            |created| system("create", out, created),
            || {
                // An earlier process of the same number may have left one.
                let _ = fs::remove_dir_all(&self.stage);
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

    /// No process has this number: Linux stops at 2^22.
    const DEAD: &str = "4294967295";

    #[test]
    #[cfg(target_os = "linux")]
    fn what_the_dead_have_left_is_cleared_up_and_what_they_moved_away_comes_back() {
        let out = tempfile::tempdir().expect("a folder");
        let at = |name: String| out.path().join(name);
        let leave = |name: String| {
            fs::create_dir(at(name.clone())).expect("a folder");
            fs::write(at(name).join(SCENARIO), "a").expect("a file");
        };
        leave(format!(".straight.tmp-{DEAD}"));
        leave(format!(".straight.old-{DEAD}"));
        leave(format!(".straight.tmp-{}", std::process::id() + 1_000_000_000));
        leave(format!(".other.tmp-{DEAD}"));
        leave(".straight.tmp-1".into());
        RunFolder::prepare(out.path(), "straight", "a", false).expect("its own run");
        let mut left: Vec<_> = fs::read_dir(out.path()).expect("it").flatten().map(|e| e.file_name()).collect();
        left.sort();
        // The first process lives; of other runs nothing is touched.
        assert_eq!(left, [".other.tmp-4294967295", ".straight.tmp-1", "straight"]);
        assert_eq!(fs::read_to_string(at("straight".into()).join(SCENARIO)).expect("it came back"), "a");
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
