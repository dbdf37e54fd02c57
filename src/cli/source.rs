//! Where a scenario comes from: a file, or the library that is built into the program.

use std::fmt;
use std::path::PathBuf;

use ductloop::Scenario;
use ductloop::library::Entry;
use ductloop::scenario::{Diagnostics, Overlays};

/// Where a scenario comes from. Shown as errors call it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A file.
    File(PathBuf),
    /// A scenario of the library.
    Library(&'static Entry),
}

impl Source {
    /// Reads it, with everything that is laid over it.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub(crate) fn read(&self, overlays: &Overlays) -> Result<Scenario, Diagnostics> {
        match self {
            Self::File(path) => Scenario::read(path, overlays),
            Self::Library(entry) => entry.read(overlays),
        }
    }

    /// The text itself.
    ///
    /// # Errors
    /// What keeps a file from being read.
    pub(crate) fn text(&self) -> Result<String, String> {
        match self {
            Self::File(path) => std::fs::read_to_string(path).map_err(|error| format!("cannot be read: {error}")),
            Self::Library(entry) => Ok(entry.text.to_owned()),
        }
    }

    /// What two names of one scenario have in common.
    pub(crate) fn place(&self) -> PathBuf {
        match self {
            Self::File(path) => path.canonicalize().unwrap_or_else(|_| path.clone()),
            // No file is called so.
            Self::Library(entry) => PathBuf::from(format!("library:/{}", entry.name)),
        }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => path.display().fmt(f),
            Self::Library(entry) => f.write_str(&entry.label()),
        }
    }
}
