//! Files that appear whole or not at all.

use std::fs::{self, File, FileType};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::stage_name::{beside, is_of_the_dead};

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Something stands there that a file must not replace: a folder, a named pipe, a device.
    #[error("is {0}")]
    NotAFile(&'static str),
    /// The system refused.
    #[error("cannot be written: {0}")]
    System(#[from] io::Error),
}

/// Writes a file aside, flushes it to disk and renames it. Folders above it are made. A link stays: what it leads to is
/// written. A process that is killed meanwhile leaves a hidden file `.NAME.tmp-…`, which the next [`try_out`] takes away.
///
/// # Errors
/// Where something other than a regular file stands there, which is left alone, or the system refuses.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let path = behind_links(path)?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let aside = beside(&path, "tmp");
    let written = write_flushed(&aside, bytes).and_then(|()| fs::rename(&aside, &path));
    if written.is_err() {
        // What went wrong with the file itself is what the caller needs to hear of.
        let _ = fs::remove_file(&aside);
    }
    Ok(written?)
}

/// The place that a name leads to, where there is a regular file or nothing.
fn behind_links(path: &Path) -> Result<PathBuf, FileError> {
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => return Err(FileError::NotAFile(kind(found.file_type()))),
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    // Step by step, as the last link may lead to what is not there yet. As many as Linux follows.
    let mut place = path.to_owned();
    for _ in 0..40 {
        match fs::read_link(&place) {
            Ok(to) => place = place.parent().unwrap_or(Path::new("")).join(to),
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("too many links").into())
}

/// What it is that is no regular file.
fn kind(found: FileType) -> &'static str {
    if found.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if found.is_fifo() {
            return "a named pipe";
        } else if found.is_socket() {
            return "a socket";
        } else if found.is_char_device() || found.is_block_device() {
            return "a device";
        }
    }
    "not a regular file"
}

/// Creates what is missing of a folder, tries what is to be done in it, and takes away again what was created: permissions
/// alone do not tell (read-only disks, quotas).
pub(super) fn try_in<E>(
    folder: &Path,
    create: impl FnOnce(io::Result<()>) -> Result<(), E>,
    attempt: impl FnOnce() -> Result<(), E>,
) -> Result<(), E> {
    let missing: Vec<&Path> = folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists()).collect();
    let tried = create(fs::create_dir_all(folder)).and_then(|()| attempt());
    for made in missing {
        // Only what is empty goes, and it did not exist before.
        let _ = fs::remove_dir(made);
    }
    tried
}

/// Makes sure that a file can be written, and leaves everything as it was, but for what processes that were killed have left of
/// this file: that goes.
///
/// # Errors
/// As [`write()`].
pub fn try_out(path: &Path) -> Result<(), FileError> {
    let path = behind_links(path)?;
    clear_up_after_the_dead(&path);
    let aside = beside(&path, "probe");
    let tried = try_in(
        path.parent().unwrap_or(Path::new("")),
        |created| created,
        || write_flushed(&aside, b"probe").and_then(|()| fs::remove_file(&aside)),
    );
    Ok(tried?)
}

/// Removes the files beside `path` that [`write()`] and [`try_out`] had begun in processes that are dead.
fn clear_up_after_the_dead(path: &Path) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let dead = |what| name.to_str().is_some_and(|name| is_of_the_dead(name, path, what));
        if dead("tmp") || dead("probe") {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Writes a file and flushes it to disk.
pub(super) fn write_flushed(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Flushes a folder's entries to disk, where the system can.
pub(super) fn flush_folder(path: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(path)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn what_the_dead_have_begun_is_taken_away_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frame.png");
        // No process has this number: Linux stops at 2^22.
        let as_of_the_dead = |path: PathBuf| {
            let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
            path.with_file_name(name.replace(&format!("-{}-", std::process::id()), "-4294967295-"))
        };
        let gone = ["tmp", "probe"].map(|what| as_of_the_dead(beside(&path, what)));
        let other = as_of_the_dead(beside(&folder.path().join("frame.json"), "tmp"));
        let kept = [path.clone(), beside(&path, "tmp"), other, folder.path().join(".frame.png.tmp-elsewhere-4294967295-0")];
        for file in gone.iter().chain(&kept) {
            fs::write(file, "begun").expect("a file");
        }
        try_out(&path).expect("a file can be written there");
        assert!(gone.iter().all(|file| !file.exists()), "{gone:?}");
        assert!(kept.iter().all(|file| file.exists()), "{kept:?}");
        assert_eq!(fs::read_dir(folder.path()).expect("it").count(), kept.len());
    }
}
