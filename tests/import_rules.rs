//! Who may import whom: what each crate's dependency tree may contain, and what the two mathematical crates may not touch.

use std::collections::BTreeSet;
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, PackageId};

/// Everything that nalgebra, libm and thiserror stand on, with the features that any member of the workspace asks of them:
/// mathematics, macros that run at build time, and nothing else.
const MATHEMATICS: &[&str] = &[
    "approx",
    "autocfg",
    "bytemuck",
    "bytemuck_derive",
    "glam",
    "libm",
    "matrixmultiply",
    "nalgebra",
    "nalgebra-macros",
    "num-bigint",
    "num-complex",
    "num-integer",
    "num-rational",
    "num-traits",
    "paste",
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

fn metadata() -> Metadata {
    MetadataCommand::new().other_options(["--locked".to_owned()]).exec().expect("cargo metadata of this workspace")
}

/// Names of everything that `root` stands on, itself left out; development and build dependencies do not count.
fn tree(metadata: &Metadata, root: &str) -> BTreeSet<String> {
    let resolve = metadata.resolve.as_ref().expect("a resolved graph");
    let name = |id: &PackageId| metadata[id].name.to_string();
    let start = resolve.nodes.iter().find(|node| name(&node.id) == root).expect("a member of the workspace");
    let (mut found, mut open) = (BTreeSet::new(), vec![&start.id]);
    while let Some(id) = open.pop() {
        let node = resolve.nodes.iter().find(|node| node.id == *id).expect("a node of the graph");
        for dep in &node.deps {
            let normal = dep.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal);
            if normal && found.insert(name(&dep.pkg)) {
                open.push(&dep.pkg);
            }
        }
    }
    found
}

#[test]
fn the_mathematical_crates_stand_on_mathematics_only() {
    let metadata = metadata();
    for member in ["ductloop-nav", "ductloop-duct"] {
        let allowed: BTreeSet<String> = MATHEMATICS.iter().map(ToString::to_string).collect();
        let strangers: Vec<_> = tree(&metadata, member).difference(&allowed).cloned().collect();
        assert!(strangers.is_empty(), "{member} has come to depend on {strangers:?}");
    }
}

#[test]
fn physics_and_light_do_not_know_each_other() {
    let metadata = metadata();
    let (sim, sensor) = (tree(&metadata, "ductloop-sim"), tree(&metadata, "ductloop-sensor"));
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
