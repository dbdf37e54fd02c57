//! Where results go, looked at before anything runs.

use std::path::{Path, PathBuf};

use ductloop::output::{FileError, try_whole};

use super::problem::Problem;

/// Makes sure that there is, or can be, a folder of this name, as far as names tell.
///
/// # Errors
/// Where something else stands in its place or on the way to it.
pub(crate) fn folder(option: &str, path: &Path) -> Result<(), Problem> {
    way_is_clear(path).map_err(|message| refused(option, path, message))
}

/// Makes sure that a file of this name can be written; leaves everything as it was.
///
/// # Errors
/// Where it cannot.
pub(crate) fn file(option: &str, path: &Path) -> Result<(), Problem> {
    let bytes = path.as_os_str().as_encoded_bytes();
    if bytes.ends_with(b"/") || bytes.ends_with(b"/.") || (cfg!(windows) && bytes.ends_with(b"\\")) {
        return Err(wrong(option, path, "this is the name of a folder".into()).help("name a file in it"));
    }
    path.parent().map_or(Ok(()), way_is_clear).map_err(|message| refused(option, path, message))?;
    try_whole(path).map_err(|error| match error {
        FileError::NotAFile(_) if path.is_dir() => wrong(option, path, error.to_string()).help("name a file in it"),
        FileError::NotAFile(_) => wrong(option, path, format!("{error}, and only a regular file is replaced"))
            .help("name a regular file, or one that is not there yet; what it then holds can be passed on"),
        FileError::System(_) => refused(option, path, error.to_string()),
    })
}

/// Makes sure that a file which is to be written is none of those that are read.
///
/// # Errors
/// Where it is one, by whatever name or link.
pub(crate) fn is_no_input<'p>(option: &str, path: &Path, mut inputs: impl Iterator<Item = &'p PathBuf>) -> Result<(), Problem> {
    let Ok(place) = path.canonicalize() else { return Ok(()) };
    match inputs.find(|input| input.canonicalize().is_ok_and(|input| input == place)) {
        Some(input) => Err(refused(option, path, format!("this would replace {}, which is read", input.display()))),
        None => Ok(()),
    }
}

/// That nothing can be written there.
pub(crate) fn refused(option: &str, path: &Path, message: String) -> Problem {
    wrong(option, path, message).help("choose another place")
}

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
