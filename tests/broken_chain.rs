//! The loop must notice when a link of it is broken: each of these runs has to fail, with exit code 1.
//!
//! The scenario is `straight-offset`, whose criteria a whole chain meets.

use std::path::Path;

use ductloop::{Pilot, Scenario, Verdict};

fn scenario(settings: &[&str]) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/straight-offset.toml");
    let overlays = ductloop::scenario::Overlays {
        set: settings.iter().map(ToString::to_string).chain(["time_limit_s=30.0".to_owned()]).collect(),
        ..Default::default()
    };
    Scenario::read(&file, &overlays).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
}

#[track_caller]
fn verdict_of(scenario: &Scenario) -> (Verdict, String) {
    let outcome = ductloop::run(scenario, Pilot::of(scenario)).expect("a run that ends");
    let told = format!("{:?}: {:?} {:#?}", outcome.verdict, outcome.reasons, outcome.metrics);
    (outcome.verdict, told)
}

#[track_caller]
fn must_fail(scenario: &Scenario) {
    let (verdict, told) = verdict_of(scenario);
    assert_eq!(verdict, Verdict::Fail, "{told}");
    assert_eq!(verdict.exit_code(), 1);
}

#[test]
fn the_whole_chain_passes() {
    let (verdict, told) = verdict_of(&scenario(&[]));
    assert_eq!(verdict, Verdict::Pass, "{told}");
}

/// The navigator believes that `low` shines downward where it shines upward; the images are right.
#[test]
fn a_sign_flipped_in_the_nominal_rig_fails() {
    let mut scenario = scenario(&[]);
    let actual = scenario.actual_rig();
    let laser = &mut scenario.rig.lasers[0];
    let mut normal = laser.normal_in_camera.into_inner();
    normal.z = -normal.z;
    laser.normal_in_camera = nalgebra::Unit::new_normalize(normal);
    must_fail_with_actual(scenario, actual);
}

/// Runs `scenario` with its nominal rig as it is and `actual` as the rig that makes the images.
#[track_caller]
fn must_fail_with_actual(scenario: Scenario, actual: ductloop_nav::rig::Rig) {
    // Navigate by the wrong rig, render by the right one: the pilot is built from one scenario, the body from another.
    let pilot = Pilot::of(&scenario);
    let body = Scenario { rig: actual, ..scenario };
    let outcome = ductloop::run(&body, pilot).expect("a run that ends");
    assert_eq!(outcome.verdict, Verdict::Fail, "{:?} {:#?}", outcome.reasons, outcome.metrics);
    assert_eq!(outcome.verdict.exit_code(), 1);
}

#[test]
fn blank_images_fail() {
    must_fail(&scenario(&["fault=[{at_s = 0.0, kind = \"frame-blank\"}]"]));
}

#[test]
fn images_that_go_blank_on_the_way_fail() {
    must_fail(&scenario(&["fault=[{at_s = 4.0, kind = \"frame-blank\"}]"]));
}

#[test]
fn swapped_wheels_fail() {
    must_fail(&scenario(&["fault=[{at_s = 0.0, kind = \"wheels-swapped\"}]"]));
}

#[test]
fn a_laser_plane_off_by_two_degrees_fails() {
    must_fail(&scenario(&["sensor.error.laser_plane_deg=[2.0, 0.0]"]));
}
