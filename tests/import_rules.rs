//! Who may import whom: what each crate's dependency tree may contain, and what the two mathematical crates may not touch.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Everything that nalgebra, libm and thiserror stand on: mathematics, macros that run at build time, and nothing else.
const MATHEMATICS: &[&str] = &[
    "approx",
    "bytemuck",
    "libm",
    "matrixmultiply",
    "nalgebra",
    "num-complex",
    "num-integer",
    "num-rational",
    "num-traits",
    "proc-macro2",
    "quote",
    "rawpointer",
    "safe_arch",
    "simba",
    "syn",
    "thiserror",
    "thiserror-impl",
    "typenum",
    "unicode-ident",
    "wide",
];

/// Names of everything that `root` stands on, itself left out, with the features that it asks for itself; development and build
/// dependencies do not count.
fn tree(root: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--no-dedupe", "--prefix", "none", "--edges", "normal", "--format", "{p}", "--package", root])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names");
    let names = text.lines().filter_map(|line| line.split(' ').next());
    names.filter(|name| !name.is_empty() && *name != root).map(str::to_owned).collect()
}

#[test]
fn the_mathematical_crates_stand_on_mathematics_only() {
    for member in ["ductloop-nav", "ductloop-duct"] {
        let allowed: BTreeSet<String> = MATHEMATICS.iter().map(ToString::to_string).collect();
        let strangers: Vec<_> = tree(member).difference(&allowed).cloned().collect();
        assert!(strangers.is_empty(), "{member} has come to depend on {strangers:?}");
    }
}

#[test]
fn physics_and_light_do_not_know_each_other() {
    let (sim, sensor) = (tree("ductloop-sim"), tree("ductloop-sensor"));
    for stranger in ["ductloop-sensor", "wgpu", "ductloop"] {
        assert!(!sim.contains(stranger), "ductloop-sim depends on {stranger}");
    }
    for stranger in ["ductloop-sim", "rapier3d-f64", "parry3d-f64", "ductloop"] {
        assert!(!sensor.contains(stranger), "ductloop-sensor depends on {stranger}");
    }
    for both in ["ductloop-duct", "ductloop-nav"] {
        assert!(sim.contains(both) && sensor.contains(both), "the trees were not read: {sim:?} {sensor:?}");
    }
}

/// Projection and triangulation share a rig's parameters, never code.
#[test]
fn the_sensor_model_takes_only_the_contract_from_the_navigator() {
    for file in sources("sensor-model/src").into_iter().chain(sources("sim/src")) {
        let text = std::fs::read_to_string(&file).expect("a source file");
        for (number, line) in text.lines().enumerate() {
            let inside = line.contains("ductloop_nav::");
            let contract =
                ["ductloop_nav::rig", "ductloop_nav::messages", "ductloop_nav::angle"].iter().any(|m| line.contains(m));
            assert!(!inside || contract, "{}:{}: {line}", file.display(), number + 1);
        }
    }
}

#[test]
fn the_mathematical_crates_have_no_clock_no_files_no_threads_no_randomness() {
    for file in sources("nav-core/src").into_iter().chain(sources("duct/src")) {
        let text = std::fs::read_to_string(&file).expect("a source file");
        for banned in ["std::time", "std::fs", "std::io", "std::net", "std::env", "std::thread", "std::process", "rand"] {
            let word = |line: &&str| {
                line.match_indices(banned).any(|(at, _)| {
                    let letter = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
                    !letter(line[..at].chars().next_back()) && !letter(line[at + banned.len()..].chars().next())
                })
            };
            let found = text.lines().find(word);
            assert_eq!(found, None, "{} uses {banned}", file.display());
        }
    }
}

fn sources(folder: &str) -> Vec<std::path::PathBuf> {
    fn walk(folder: &Path, files: &mut Vec<std::path::PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                files.push(path);
            }
        }
    }
    let mut files = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut files);
    assert!(!files.is_empty(), "no sources in {folder}");
    files
}
