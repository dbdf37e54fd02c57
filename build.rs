//! The build id: a hash of all that a result follows from, sources, presets and lock file. A case of a sweep is named with it, so that
//! results of another program never mix in.

use std::fs;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::Xxh3;

/// Folders and files of the workspace that go into the program.
const SOURCES: [&str; 12] = [
    "Cargo.lock",
    "Cargo.toml",
    "duct/Cargo.toml",
    "duct/src",
    "nav-core/Cargo.toml",
    "nav-core/src",
    "presets",
    "sensor-model/Cargo.toml",
    "sensor-model/src",
    "sim/Cargo.toml",
    "sim/src",
    "src",
];

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let mut hash = Xxh3::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        let mut files = Vec::new();
        walk(&root.join(source), &mut files);
        files.sort();
        for file in files {
            // By its name within the workspace, and without the carriage returns that some checkouts put in.
            let name = file.strip_prefix(&root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
            let text: Vec<u8> = fs::read(&file).unwrap_or_default().into_iter().filter(|byte| *byte != b'\r').collect();
            for part in [name.as_bytes(), &text] {
                hash.update(&(part.len() as u64).to_le_bytes());
                hash.update(part);
            }
        }
    }
    println!("cargo::rustc-env=DUCTLOOP_BUILD_ID={:032x}", hash.digest128());
}

fn walk(path: &Path, files: &mut Vec<PathBuf>) {
    match fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| walk(&entry.path(), files)),
        Err(_) => files.push(path.to_owned()),
    }
}
