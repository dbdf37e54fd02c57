//! Every scenario of the library passes with a whole chain, and fails, with exit code 1, when a link of it is broken.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use ductloop::scenario::Overlays;
use ductloop::{Pilot, Scenario, Verdict};

/// A scenario of the library, or a folder of it.
fn file(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name);
    if path.is_dir() { path } else { path.with_extension("toml") }
}

/// Runs the program on a scenario of the library with these settings.
fn ductloop(name: &str, settings: &[&str]) -> Output {
    let out = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_ductloop"));
    command.arg("run").arg(file(name)).arg("--out").arg(out.path());
    for setting in settings {
        command.args(["--set", setting]);
    }
    command.output().expect("the program")
}

#[track_caller]
fn assert_exit(name: &str, settings: &[&str], code: i32) {
    let output = ductloop(name, settings);
    let told = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{name} {settings:?}\n{told}\n{errors}");
    let word = if code == 0 { "pass" } else { "fail" };
    assert!(told.contains(word), "{name} {settings:?}\n{told}\n{errors}");
}

/// Also says that no scenario is forgotten here.
#[test]
fn every_scenario_passes_with_a_whole_chain() {
    let folder = file("straight");
    let mut names: Vec<_> = std::fs::read_dir(folder.parent().expect("a folder"))
        .expect("the library")
        .filter_map(|entry| Some(entry.ok()?.path()).filter(|path| path.is_file())?.file_stem()?.to_str().map(str::to_owned))
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "straight",
            "straight-consistent",
            "straight-fast",
            "straight-incra1",
            "straight-narrow",
            "straight-offset",
            "straight-wide"
        ]
    );
    names.iter().for_each(|name| assert_exit(name, &[], 0));
}

/// What is to become of each fault is in its scenario; narrow and wide ducts are passed.
#[test]
fn every_fault_ends_as_stated_and_every_width_is_passed() {
    assert_exit("faults", &[], 0);
    assert_exit("widths", &[], 0);
}

#[test]
fn blank_images_fail() {
    assert_exit("straight-offset", &["fault=[{at_s = 0.0, kind = \"frame-blank\"}]"], 1);
}

#[test]
fn images_that_go_blank_on_the_way_fail() {
    for name in ["straight", "straight-incra1"] {
        assert_exit(name, &["fault=[{at_s = 4.0, kind = \"frame-blank\"}]"], 1);
    }
}

#[test]
fn swapped_wheels_fail() {
    assert_exit("straight-offset", &["fault=[{at_s = 0.0, kind = \"wheels-swapped\"}]"], 1);
    // Started in the middle there is nothing to correct but noise, and it fails all the same.
    assert_exit("straight", &["fault=[{at_s = 0.0, kind = \"wheels-swapped\"}]"], 1);
}

#[test]
fn a_laser_plane_off_by_two_degrees_fails() {
    for name in ["straight-offset", "straight-incra1"] {
        for error in ["sensor.error.laser_plane_deg=[2.0, 0.0]", "sensor.error.laser_plane_deg=[0.0, -2.0]"] {
            assert_exit(name, &[error], 1);
        }
    }
}

/// The paper's chain needs both stripes of a wall.
#[test]
fn one_laser_alone_fails_with_the_papers_chain() {
    assert_exit("straight-offset", &[PAPER, "fault=[{at_s = 0.0, kind = \"laser-off\", laser = \"high\"}]"], 1);
}

const PAPER: &str = "perception.pipeline=paper";

/// The navigator believes that each laser shines downward where it shines upward, and the other way round; the images are right. No file can say that, for a
/// scenario's true rig is its nominal one with an error: the pilot is built from one scenario, the body from another.
#[test]
fn signs_flipped_in_the_nominal_rig_fail() {
    let right = Scenario::read(&file("straight-offset"), &Overlays::default()).unwrap_or_else(|wrong| panic!("{wrong}"));
    let mut believed = right.clone();
    for laser in &mut believed.rig.lasers {
        let mut normal = laser.normal_in_camera.into_inner();
        normal.z = -normal.z;
        laser.normal_in_camera = nalgebra::Unit::new_normalize(normal);
    }
    let outcome = ductloop::run(&right, Pilot::of(&believed)).expect("a run that ends");
    assert_eq!(outcome.verdict, Verdict::Fail, "{:?} {:#?}", outcome.reasons, outcome.metrics);
    assert_eq!(outcome.verdict.exit_code(), 1);
}
