//! Files that appear whole or not at all.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A name beside `path` for what is not finished yet: hidden, and of this process only.
pub(super) fn beside(path: &Path, what: &str) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{what}-{}", std::process::id()));
    path.with_file_name(name)
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
