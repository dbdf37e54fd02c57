//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A name beside `path` for what is not finished yet: hidden, and of this process only.
pub(super) fn beside(path: &Path, what: &str) -> PathBuf {
    path.with_file_name(format!("{}{}", beginning(path, what), std::process::id()))
}

/// What such a name begins with; the number of the process follows.
pub(super) fn beginning(path: &Path, what: &str) -> String {
    format!(".{}.{what}-", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Writes a file aside, flushes it to disk and renames it. Folders above it are made.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let aside = beside(path, "tmp");
    let written = write_flushed(&aside, bytes).and_then(|()| fs::rename(&aside, path));
    if written.is_err() {
        // What went wrong with the file itself is what the caller needs to hear of.
        let _ = fs::remove_file(&aside);
    }
    written
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

/// Makes sure that a file can be written, and leaves everything as it was.
pub fn try_out(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let aside = beside(path, "probe");
    try_in(
        path.parent().unwrap_or(Path::new("")),
        |created| created,
        || write_flushed(&aside, b"probe").and_then(|()| fs::remove_file(&aside)),
    )
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
