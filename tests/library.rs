//! Every scenario of the library is run and passes, theme by theme. Straights, widths and faults are in `broken_chain`.
#![cfg(feature = "cli")]

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Runs a folder of the library, two runs at a time.
#[track_caller]
fn assert_passes(theme: &str) {
    let out = tempfile::tempdir().expect("a temporary folder");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(theme);
    let mut command = Command::new(env!("CARGO_BIN_EXE_ductloop"));
    command.arg("run").arg(folder).args(["--jobs", "2", "--renderer", "cpu", "--out"]).arg(out.path());
    let ran = command.output().expect("the program");
    let [told, errors] = [&ran.stdout, &ran.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert_eq!(ran.status.code(), Some(0), "{theme}\n{told}\n{errors}");
    // Each has its row, so none was left out.
    let missing = |name: &&str| !told.lines().any(|line| line.split_whitespace().next() == Some(*name));
    let of_theme = ductloop::library::all().iter().filter(|entry| entry.theme == theme).map(|entry| entry.name);
    assert_eq!(of_theme.filter(missing).collect::<Vec<_>>(), [""; 0], "{theme}\n{told}");
}

#[test]
fn every_fitting_is_driven_through_or_stopped_at() {
    assert_passes("fittings");
}

#[test]
fn every_narrow_place_is_passed() {
    assert_passes("narrow");
}

#[test]
fn every_obstacle_is_passed_or_stopped_at() {
    assert_passes("obstacles");
}

#[test]
fn every_network_is_driven_to_the_end_of_its_route() {
    assert_passes("networks");
}

#[test]
fn no_theme_is_forgotten() {
    let themes: BTreeSet<_> = ductloop::library::all().iter().map(|entry| entry.theme).collect();
    let here = ["fittings", "narrow", "obstacles", "networks"];
    let in_broken_chain = ["basics", "widths", "faults"];
    assert_eq!(themes, here.into_iter().chain(in_broken_chain).collect());
}
