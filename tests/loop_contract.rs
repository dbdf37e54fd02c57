//! What the loop hands to the camera and to the navigator, without any image: the renderer only notes what it was asked for.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

use ductloop::closed_loop::{Pace, RunError, run_with};
use ductloop::record::{EndState, RunRecord};
use ductloop::{Command, Counts, Frame, GreyImage, MountAngles, Navigator, Pilot, Pixels, Scenario, Sides, Tick};
use ductloop_nav::navigator::{Report, State};
use ductloop_sensor::renderer::{ImageMut, Motion, RenderError, Renderer, View};
use nalgebra::Vector3;

/// Notes every view; the image is grey.
#[derive(Default)]
struct Noting(Vec<View>);

impl Renderer for Noting {
    fn render(&mut self, view: &View, image: ImageMut<'_>) -> Result<(), RenderError> {
        self.0.push(view.clone());
        match image {
            ImageMut::Grey8(values) => values.fill(7),
            ImageMut::Grey16(values) => values.fill(7),
        }
        Ok(())
    }
}

/// What a navigator was given: counts, mount angles, tick.
type Given = Arc<Mutex<Vec<(Counts, MountAngles, Tick)>>>;

/// Does what a function of the frame's number says.
struct Scripted<F> {
    script: F,
    state: State,
    given: Given,
}

impl<F: FnMut(usize) -> Command + Send> Navigator for Scripted<F> {
    fn on_frame(&mut self, _frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command {
        let mut given = self.given.lock().expect("one thread at a time");
        given.push((counts, mount, tick));
        (self.script)(given.len() - 1)
    }

    fn report(&self) -> Report<'_> {
        Report { state: self.state, ..Report::default() }
    }
}

fn scenario(more: &str) -> Scenario {
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"t\"\ntime_limit_s = 3.0\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\n\
         height_m = 0.3\nrun = [{{ straight_m = 6.0 }}]\n{more}"
    );
    Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
}

fn stand(_: usize) -> Command {
    Command::stop(MountAngles::default())
}

fn wheels(left: f64, right: f64) -> Command {
    Command { wheel_speed_rad_s: Sides { left, right }, ..stand(0) }
}

/// Runs the script; returns the record, the views, and what the navigator was given.
fn run(
    scenario: &Scenario,
    state: State,
    script: impl FnMut(usize) -> Command + Send + 'static,
) -> (RunRecord, Vec<View>, Vec<(Counts, MountAngles, Tick)>) {
    let given = Given::default();
    let pilot = Pilot::from(Scripted { script, state, given: Arc::clone(&given) });
    let mut renderer = Noting::default();
    let record = run_with(scenario, pilot, &mut renderer, Pace::Overlapped, |_, _| ControlFlow::Continue(())).expect("a run");
    let given = given.lock().expect("the run is over").clone();
    (record, renderer.0, given)
}

#[test]
fn a_command_takes_effect_one_frame_after_its_exposure() {
    // Full speed ahead is commanded on frame 10, and on no other.
    let (record, _, given) = run(&scenario(""), State::Unknown, |frame| wheels(if frame == 10 { 5.0 } else { 0.0 }, 0.0));
    assert!(given[..=11].iter().all(|(counts, ..)| counts.left.abs() <= 1), "{:?}", &given[..=11]);
    assert!(given[12].0.left > 500, "{:?}", given[12]);
    assert!(given.iter().enumerate().all(|(i, (.., tick))| *tick == 40 * i as u64));
    assert_eq!(record.end, EndState::TimeLimit);
}

#[test]
fn exposure_and_laser_power_are_the_navigators_to_choose() {
    let script = |frame| {
        let asked = (frame == 3).then_some((0.008, 0.25));
        Command { exposure_s: asked.map(|a| a.0), laser_power: asked.map(|a| a.1), ..stand(0) }
    };
    let (_, views, _) = run(&scenario("[sensor.light]\n"), State::Unknown, script);
    for (frame, view) in views.iter().enumerate() {
        let (exposure_s, power) = if frame <= 3 { (0.004, 1.0) } else { (0.008, 0.25) };
        assert_eq!((view.exposure_s, view.laser_power[0], view.laser_power[1]), (exposure_s, power, power), "frame {frame}");
        assert_eq!(view.frame, frame as u64);
    }
}

/// A laser's own power multiplies what the navigator asks; a fault takes away all of it.
#[test]
fn a_lasers_own_power_multiplies_what_is_asked() {
    let lasers = "[sensor.laser.low]\npower = 0.0\n[sensor.laser.high]\npower = 1.5\n\
                  [[fault]]\nkind = \"laser-off\"\nlaser = \"high\"\nat_s = 1.0\n";
    let script = |_| Command { laser_power: Some(0.25), ..stand(0) };
    let (record, views, _) = run(&scenario(lasers), State::Unknown, script);
    for (frame, view) in views.iter().enumerate() {
        // What is asked for with frame 0 acts at frame 1.
        let asked = if frame == 0 { 1.0 } else { 0.25 };
        let high = if frame < 30 { 1.5 * asked } else { 0.0 };
        assert_eq!(view.laser_power[..2], [0.0, high], "frame {frame}");
        assert_eq!(record.frames[frame].laser_power, asked);
    }
}

/// Motion blur rests on this: the camera moves as the base and the mount do at the exposure.
#[test]
fn the_view_moves_as_the_robot_and_its_mount_do() {
    // The mount sets out for 0.5 rad to the left with frame 30; its rate is limited.
    let script = |frame| Command {
        mount: MountAngles { pan_rad: if frame >= 30 { 0.5 } else { 0.0 }, tilt_rad: 0.0 },
        ..wheels(4.0, 5.0)
    };
    let scenario = scenario("[start]\nheading_deg = 20.0\n");
    let (record, views, given) = run(&scenario, State::Unknown, script);
    assert_eq!(views[0].motion, Motion::default(), "at rest");
    let mut turned = 0;
    for (i, (frame, view)) in record.frames.iter().zip(&views).enumerate() {
        assert_eq!(&frame.view, view);
        let truth = &frame.truth;
        let ahead = truth.world_from_base.rotation * Vector3::x();
        let to_camera = view.world_from_camera.translation.vector - truth.world_from_base.translation.vector;
        let turn = truth.world_from_base.rotation * Vector3::new(0.0, 0.0, truth.yaw_rate_rad_s);
        let linear = ahead * truth.speed_m_s + turn.cross(&to_camera);
        assert!((view.motion.linear_m_s - linear).norm() < 1e-9, "frame {i}: {:?} {linear}", view.motion);
        // The mount's own turning, as the angles handed to the navigator show it: still, at its rate, still.
        let pan_rate = (view.motion.angular_rad_s - turn).dot(&(truth.world_from_base.rotation * Vector3::z()));
        let moves = i > 0 && given[i].1 != given[i - 1].1 && given[i].1.pan_rad < 0.5 - 1e-9;
        let expected = if moves { scenario.robot.mount_rate_rad_s } else { 0.0 };
        turned += usize::from(moves);
        if given[i].1.pan_rad == 0.0 || moves {
            assert!((pan_rate - expected).abs() < 1e-6, "frame {i}: {pan_rate} {:?}", given[i].1);
        }
    }
    // 0.5 rad at 2 rad/s are seven and a half frames.
    assert!((6..=8).contains(&turned), "{turned}");
}

#[test]
fn a_deeper_ccd_gives_deeper_frames() {
    for (bits, max_dn) in [(8, 255), (10, 1023), (12, 4095)] {
        let scenario = scenario(&format!("[sensor.ccd]\nbits = {bits}\n"));
        let told = Arc::new(Mutex::new(Vec::new()));
        let pilot = Pilot::from(Depths(Arc::clone(&told)));
        let mut renderer = Noting::default();
        let record = run_with(&scenario, pilot, &mut renderer, Pace::Alone, |_, _| ControlFlow::Break(())).expect("a run");
        assert_eq!(*told.lock().expect("the run is over"), [(bits > 8, max_dn)]);
        assert_eq!(record.key_frames.spread()[0].image.bits().count(), bits);
    }
}

/// Notes whether frames are of 16 bits, and their largest value.
struct Depths(Arc<Mutex<Vec<(bool, u16)>>>);

impl Navigator for Depths {
    fn on_frame(&mut self, frame: &Frame<'_>, _counts: Counts, _mount: MountAngles, _tick: Tick) -> Command {
        self.0.lock().expect("one thread at a time").push((matches!(frame.pixels, Pixels::Grey16(_)), frame.max_dn));
        stand(0)
    }
}

#[test]
fn the_true_mount_points_where_its_error_says_and_reports_otherwise() {
    let error = "[sensor.error]\npan_deg = 3.0\ntilt_deg = 5.0\nroll_deg = 7.0\n";
    let (_, views, given) = run(&scenario(error), State::Unknown, stand);
    let camera = views[0].world_from_camera.rotation;
    // Positive pan looks left, positive tilt looks down.
    let sight = camera * Vector3::z();
    assert!((libm::atan2(sight.y, sight.x).to_degrees() - 3.0).abs() < 1e-3, "{sight}");
    assert!((libm::asin(-sight.z).to_degrees() - 5.0).abs() < 1e-3, "{sight}");
    // The image's rows are level but for the roll, about the line of sight.
    let rows = camera * Vector3::x();
    assert!((libm::asin(-rows.z / libm::cos(5.0_f64.to_radians())).to_degrees() - 7.0).abs() < 1e-3, "{rows}");
    assert_eq!(given[0].1, MountAngles::default());
}

#[test]
fn a_laser_that_is_off_is_the_one_that_was_named_and_only_for_its_time() {
    let fault = |kind: &str| format!("[[fault]]\nat_s = 0.5\nfor_s = 1.0\nkind = {kind}\n");
    let during = |view: &View| (15..45).contains(&view.frame);
    for (name, index) in [("low", 0), ("high", 1)] {
        let (_, views, _) = run(&scenario(&fault(&format!("\"laser-off\"\nlaser = \"{name}\""))), State::Unknown, stand);
        for view in &views {
            let mut expected = [1.0, 1.0];
            expected[index] = if during(view) { 0.0 } else { 1.0 };
            assert_eq!(view.laser_power[..2], expected, "{name}, frame {}", view.frame);
            assert_eq!(view.headlamp_power, 1.0);
        }
    }
    let (record, views, _) = run(&scenario(&fault("\"frame-blank\"")), State::Unknown, stand);
    for (view, frame) in views.iter().zip(&record.frames) {
        let dark = view.laser_power[..2] == [0.0, 0.0] && view.headlamp_power == 0.0;
        assert_eq!((dark, frame.faults == 1), (during(view), during(view)), "frame {}", view.frame);
    }
}

#[test]
fn swapped_wheels_turn_the_other_way() {
    let turn =
        |more: &str| run(&scenario(more), State::Unknown, |_| wheels(1.0, 2.0)).0.frames.last().map(|f| f.truth.heading_rad);
    let (right_way, swapped) = (turn(""), turn("[[fault]]\nat_s = 0.0\nkind = \"wheels-swapped\"\n"));
    assert!(right_way > Some(0.1) && swapped < Some(-0.1), "{right_way:?} {swapped:?}");
}

#[test]
fn a_navigator_that_has_stopped_ends_the_run_a_second_later() {
    let (record, ..) = run(&scenario(""), State::Stopped, stand);
    assert_eq!(record.end, EndState::Stopped);
    assert!((1.0..1.1).contains(&record.sim_time_s), "{}", record.sim_time_s);
    // As long as it rolls it has not stopped.
    let (record, ..) = run(&scenario(""), State::Stopped, |_| wheels(1.0, 1.0));
    assert_eq!(record.end, EndState::TimeLimit);
}

#[test]
fn steering_by_the_truth_is_told_offset_heading_and_width() {
    let narrow = scenario(
        "[start]\nlateral_m = 0.03\nheading_deg = 4.0\n[perception]\npipeline = \"truth\"\n[finish]\nbefore_end_m = 5.0\n",
    );
    let narrow = Scenario { duct: ductloop::scenario::Duct { width_m: 0.4, ..narrow.duct.clone() }, ..narrow };
    let mut renderer = Noting::default();
    let record =
        run_with(&narrow, Pilot::of(&narrow), &mut renderer, Pace::Alone, |_, _| ControlFlow::Continue(())).expect("a run");
    for frame in &record.frames {
        let told = &frame.measurement;
        assert_eq!((told.lateral_m, told.heading_rad), (Some(frame.truth.lateral_m), Some(frame.truth.heading_rad)));
        assert_eq!(told.width_m, Some(0.4));
    }
}

#[test]
fn pace_makes_no_difference() {
    let scenario = scenario("[start]\nlateral_m = 0.03\n[perception]\npipeline = \"truth\"\n");
    let run = |pace| {
        let watch = |_: &_, _: &GreyImage| ControlFlow::Continue(());
        run_with(&scenario, Pilot::of(&scenario), &mut Noting::default(), pace, watch).expect("a run")
    };
    let (alone, overlapped) = (run(Pace::Alone), run(Pace::Overlapped));
    assert_eq!(alone.frames, overlapped.frames);
    assert_eq!(alone.run_hash, overlapped.run_hash);
}

/// A number that is none ends the run before it reaches wheels, mount or camera, whatever the wheel loop reckons in; the frames until
/// then are kept, and tick and number are named.
#[test]
fn a_command_that_is_none_ends_the_run_and_is_named() {
    let nan = f64::NAN;
    let good = wheels(4.0, 4.0);
    let pan = |pan_rad: f64| MountAngles { pan_rad, ..good.mount };
    for arithmetic in ["fixed", "float"] {
        for (bad, named) in [
            (wheels(nan, 4.0), "the left wheels' speed is NaN"),
            (wheels(4.0, f64::NEG_INFINITY), "the right wheels' speed is -inf"),
            (wheels(4.0, 1e5), "the right wheels' speed is 100000"),
            (Command { mount: pan(nan), ..good }, "pan is NaN"),
            (Command { exposure_s: Some(0.0), ..good }, "the exposure is 0"),
            (Command { laser_power: Some(nan), ..good }, "the laser power is NaN"),
        ] {
            let scenario = scenario(&format!("[wheel_control]\narithmetic = \"{arithmetic}\"\n"));
            let script = move |frame| if frame == 20 { bad } else { good };
            let pilot = Pilot::from(Scripted { script, state: State::Tracking, given: Given::default() });
            let watch = |_: &_, _: &GreyImage| ControlFlow::Continue(());
            let failure = run_with(&scenario, pilot, &mut Noting::default(), Pace::Alone, watch).expect_err(named);
            assert!(matches!(failure.error, RunError::Command { tick: 800, .. }), "{failure}");
            assert!(failure.to_string().contains(named) && failure.to_string().contains("tick 800"), "{failure}");
            let record = failure.record.expect("the frames until then");
            assert_eq!((record.frames.len(), record.end), (20, EndState::Failed));
            let last = record.frames[19].truth;
            assert!(last.speed_m_s > 0.1 && last.clearance_m > 0.0, "{last:?}");
        }
    }
}

/// Wheel speeds that no motor reaches are no nonsense: the wheel controller gives what there is, and the physics stays sound.
#[test]
fn commands_beyond_the_motors_reach_are_limited() {
    for arithmetic in ["fixed", "float"] {
        let flips = |frame: usize| wheels(1e4, if frame.is_multiple_of(2) { 1e4 } else { -1e4 });
        let scenario = scenario(&format!("[wheel_control]\narithmetic = \"{arithmetic}\"\n"));
        let (record, ..) = run(&scenario, State::Unknown, flips);
        for frame in &record.frames {
            let duty = frame.body.duty;
            assert!(duty.left.abs() <= 1.0 && duty.right.abs() <= 1.0, "{duty:?}");
            assert!(frame.truth.speed_m_s.abs() < 2.0 && frame.truth.yaw_rate_rad_s.is_finite(), "{:?}", frame.truth);
        }
    }
}
