//! The build id: a hash of all that a result follows from, sources, presets and lock file. A case of a sweep is named with it, so that
//! results of another program never mix in. And the library: every scenario below `scenarios/`, as texts in the program.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::Xxh3;

/// Folders and files of the workspace that go into the build id. Scenarios do not: a case is named with its whole scenario.
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
/// What becomes the library.
const SCENARIOS: &str = "scenarios";

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    println!("cargo::rustc-env=DUCTLOOP_BUILD_ID={:032x}", build_id(&root));
    let written = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default()).join("library.rs");
    if let Err(error) = library(&root).and_then(|text| fs::write(&written, text)) {
        println!("cargo::error=the scenarios cannot be taken into the program: {error}");
    }
}

fn build_id(root: &Path) -> u128 {
    let mut hash = Xxh3::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        for file in files(&root.join(source)) {
            // By its name within the workspace, and without the carriage returns that some checkouts put in.
            let name = name(root, &file);
            let text: Vec<u8> = fs::read(&file).unwrap_or_default().into_iter().filter(|byte| *byte != b'\r').collect();
            for part in [name.as_bytes(), &text] {
                hash.update(&(part.len() as u64).to_le_bytes());
                hash.update(part);
            }
        }
    }
    hash.digest128()
}

/// The library as an array of `("fittings/elbow-left.toml", its text)`, in the order of the paths. Sweeps, studies and gauges are left
/// out by what they say they are, as `ductloop run DIR` leaves them out.
fn library(root: &Path) -> Result<String, std::io::Error> {
    println!("cargo::rerun-if-changed={SCENARIOS}");
    let folder = root.join(SCENARIOS);
    let mut text = "[\n".to_owned();
    for file in files(&folder).into_iter().filter(|file| file.extension().is_some_and(|ending| ending == "toml")) {
        let is_scenario = fs::read_to_string(&file)?.lines().any(|line| line.trim_end() == "kind = \"scenario\"");
        if is_scenario {
            let _ = writeln!(text, "    ({:?}, include_str!({:?})),", name(&folder, &file), file.display().to_string());
        }
    }
    Ok(text + "]\n")
}

/// A file's path below a folder, with the same slashes everywhere.
fn name(folder: &Path, file: &Path) -> String {
    file.strip_prefix(folder).unwrap_or(file).to_string_lossy().replace('\\', "/")
}

/// Every file below a path, or the path itself, in the order of their paths.
fn files(path: &Path) -> Vec<PathBuf> {
    fn walk(path: &Path, files: &mut Vec<PathBuf>) {
        match fs::read_dir(path) {
            Ok(entries) => entries.flatten().for_each(|entry| walk(&entry.path(), files)),
            Err(_) => files.push(path.to_owned()),
        }
    }
    let mut found = Vec::new();
    walk(path, &mut found);
    found.sort();
    found
}
