//! What a scenario puts into the duct is there for the physics, for the truth and for the report.

use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, run_with};
use ductloop::record::{EndState, RunRecord};
use ductloop::{Command, Counts, Frame, MountAngles, Navigator, Pilot, Scenario, Sides, Tick};
use ductloop_duct::cell::Solid;
use ductloop_nav::navigator::Report;
use ductloop_sensor::renderer::{ImageMut, RenderError, Renderer, View};

/// Images are no part of this.
struct Blind;

impl Renderer for Blind {
    fn render(&mut self, _view: &View, _image: ImageMut<'_>) -> Result<(), RenderError> {
        Ok(())
    }
}

/// Straight ahead, whatever comes.
struct Ahead;

impl Navigator for Ahead {
    fn on_frame(&mut self, _frame: &Frame<'_>, _counts: Counts, _mount: MountAngles, _tick: Tick) -> Command {
        // 0.3 m/s on wheels of 40 mm.
        Command { wheel_speed_rad_s: Sides { left: 7.5, right: 7.5 }, ..Command::stop(MountAngles::default()) }
    }

    fn report(&self) -> Report<'_> {
        Report::default()
    }
}

fn scenario(duct: &str) -> Scenario {
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"t\"\ntime_limit_s = 8.0\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
         run = [{{ straight_m = 1.5 }}, {{ straight_m = 1.0 }}]\n{duct}"
    );
    Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
}

fn drive(scenario: &Scenario) -> RunRecord {
    run_with(scenario, Pilot::from(Ahead), &mut Blind, Pace::Alone, |_, _| ControlFlow::Continue(())).expect("a run")
}

fn least_clearance_m(record: &RunRecord) -> f64 {
    record.frames.iter().map(|frame| frame.truth.clearance_m).fold(f64::INFINITY, f64::min)
}

#[test]
fn an_object_in_the_way_is_hit_and_one_beside_it_is_passed() {
    let free = drive(&scenario(""));
    assert_eq!((free.end, free.collisions.count), (EndState::Finished, 0));

    let met = drive(&scenario("[[duct.object]]\nat_m = 1.4\nsize_m = [0.1, 0.1, 0.1]\n"));
    assert_eq!(met.end, EndState::TimeLimit);
    assert!(met.collisions.count >= 1);
    assert!((met.collisions.contact_speed_max_m_s - 0.3).abs() < 0.02, "{:?}", met.collisions);
    // The nose, 0.16 m ahead of the base, stops at 1.35 m: the base has gone 1.35 - 0.16 - 0.5 m.
    assert!((met.distance_m - 0.69).abs() < 5e-3, "{}", met.distance_m);
    assert_eq!(least_clearance_m(&met), 0.0);

    // Flush with the right wall, over the joint: 0.05 m thick, so 0.2 m from the middle; the wheels reach out to 0.1075 m.
    let beside = "[[duct.object]]\nname = \"brick\"\nat_m = 1.5\nleft_m = -0.225\nsize_m = [0.2, 0.05, 0.1]\n";
    let passed = drive(&scenario(beside));
    assert_eq!((passed.end, passed.collisions.count), (EndState::Finished, 0));
    assert!((least_clearance_m(&passed) - 0.0925).abs() < 1e-3, "{}", least_clearance_m(&passed));
    // The mast under the ceiling.
    assert!((least_clearance_m(&free) - 0.125).abs() < 1e-3, "{}", least_clearance_m(&free));
}

/// The mast is 175 mm high, the chassis 75 mm, with 25 mm below it.
#[test]
fn what_hangs_above_the_robot_or_lies_between_its_wheels_is_passed() {
    for (above_m, high_m, expected_m) in [(0.2, 0.1, Some(0.025)), (0.0, 0.015, Some(0.01)), (0.15, 0.1, None)] {
        let record =
            drive(&scenario(&format!("[[duct.object]]\nat_m = 1.4\nabove_m = {above_m}\nsize_m = [0.05, 0.05, {high_m}]\n")));
        let least_m = least_clearance_m(&record);
        match expected_m {
            Some(expected_m) => {
                assert_eq!((record.end, record.collisions.count), (EndState::Finished, 0), "{above_m}");
                // The wheels sink in by some hundredths of a millimetre.
                assert!((least_m - expected_m).abs() < 2e-4, "{above_m}: {least_m}");
            }
            None => assert!(record.collisions.count > 0 && record.end == EndState::TimeLimit, "{above_m}: {:?}", record.end),
        }
    }
}

#[test]
fn beads_stand_at_the_joint_and_are_felt() {
    let beaded = scenario("bead_mm = 3.0\nbead_width_mm = 16.0\n");
    let network = beaded.duct.network().expect("valid");
    let corners: Vec<_> = network.cells.iter().flat_map(|cell| &cell.solids).flat_map(|solid: &Solid| &solid.corners).collect();
    let reach = |low: f64, value: fn(&f64) -> f64, axis: usize| corners.iter().map(|c| value(&c[axis])).fold(low, f64::max);
    assert!((reach(0.0, |x| *x, 0) - 1.508).abs() < 1e-12 && (reach(-9.0, |x| -x, 0) + 1.492).abs() < 1e-12);
    assert!(network.cells.iter().flat_map(|cell| &cell.solids).all(|solid| solid.surface == beaded.duct.surface));
    let record = drive(&beaded);
    assert_eq!(record.end, EndState::Finished, "it climbs over them");
    assert!(record.collisions.count > 0, "{:?}", record.collisions);
    assert!(scenario("").duct.network().expect("valid").cells.iter().all(|cell| cell.solids.is_empty()));
}

/// A box turned about its own middle, behind an elbow, stands where the path goes on.
#[test]
fn an_object_stands_beside_the_path_as_it_says() {
    let object = "[[duct.object]]\nat_m = 3.0\nleft_m = 0.1\nabove_m = 0.05\nturned_deg = 90.0\n\
                  size_m = [0.2, 0.1, 0.04]\nsurface = \"rubber\"\n";
    let scenario = Scenario::from_toml_str(&format!(
        "format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
         run = [{{ straight_m = 1.5 }}, {{ mitre_deg = 90 }}, {{ straight_m = 2.0 }}]\n{object}"
    ))
    .unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
    let network = scenario.duct.network().expect("valid");
    let solid = scenario.duct.objects[0].solid(&network.centreline);
    // The second straight runs along y from (1.75, 0.25) on; the path through the mitre is a quarter circle of 0.25 m.
    let y_m = 0.25 + 3.0 - 1.5 - 0.25 * std::f64::consts::FRAC_PI_2;
    // Left of the path is -x; turned by a quarter, the 0.2 m lie across.
    for (axis, low, high) in [(0, 1.75 - 0.1 - 0.1, 1.75 - 0.1 + 0.1), (1, y_m - 0.05, y_m + 0.05), (2, 0.05, 0.09)] {
        let least = solid.corners.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
        let most = solid.corners.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
        assert!((least - low).abs() < 1e-9 && (most - high).abs() < 1e-9, "axis {axis}: {least} to {most}");
    }
    let rubber = scenario.surfaces.iter().position(|surface| surface.name == "rubber");
    assert_eq!(rubber, Some(usize::from(solid.surface.0)));
    assert_eq!(network.cells.iter().filter(|cell| cell.solids.contains(&solid)).count(), 1);
}
