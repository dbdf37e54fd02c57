//! Where results go, looked at before anything runs.

use std::path::Path;

use ductloop::output::try_whole;

use super::problem::Problem;

/// Makes sure that there is, or can be, a folder of this name, as far as names tell.
///
/// # Errors
/// Where something else stands in its place or on the way to it.
pub(crate) fn folder(option: &str, path: &Path) -> Result<(), Problem> {
    way_is_clear(path).map_err(|message| wrong(option, path, message).help(ELSEWHERE))
}

/// Makes sure that a file of this name can be written; leaves everything as it was.
///
/// # Errors
/// Where it cannot.
pub(crate) fn file(option: &str, path: &Path) -> Result<(), Problem> {
    if path.is_dir() {
        return Err(wrong(option, path, "is a folder".into()).help("name a file in it"));
    }
    path.parent()
        .map_or(Ok(()), way_is_clear)
        .and_then(|()| try_whole(path).map_err(|error| format!("cannot be written: {error}")))
        .map_err(|message| wrong(option, path, message).help(ELSEWHERE))
}

const ELSEWHERE: &str = "choose another place";

/// Names what is not a folder and would have to be one.
fn way_is_clear(folder: &Path) -> Result<(), String> {
    match folder.ancestors().find(|part| part.exists()).filter(|part| !part.is_dir()) {
        Some(other) => Err(format!("{} is not a folder", other.display())),
        None => Ok(()),
    }
}

fn wrong(option: &str, path: &Path, message: String) -> Problem {
    Problem::new(Problem::WRONG_INPUT, message).about(format!("{option} {}", path.display()))
}
