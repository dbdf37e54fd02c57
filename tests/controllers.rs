//! Wheel and mount controller in the loop, behind their link: what a robot does whose commands come late, or not at all, and what
//! the navigator is told of a mount that has play. No images: the renderer only notes what it was asked for.

use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, run_with};
use ductloop::record::{EndState, FrameRecord, RunRecord};
use ductloop::viewpoint::world_from_camera;
use ductloop::{GreyImage, Pilot, Scenario};
use ductloop_nav::rig::MountAngles;
use ductloop_nav::wheel_controller::silence::Hearing;
use ductloop_sensor::renderer::{ImageMut, RenderError, Renderer, View};

/// Makes no image.
struct Blind;

impl Renderer for Blind {
    fn render(&mut self, _view: &View, image: ImageMut<'_>) -> Result<(), RenderError> {
        match image {
            ImageMut::Grey8(values) => values.fill(7),
            ImageMut::Grey16(values) => values.fill(7),
        }
        Ok(())
    }
}

/// Steers by the truth at 0.3 m/s through 6 m of duct.
fn scenario(more: &str) -> Scenario {
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"t\"\ntime_limit_s = 40.0\n[perception]\npipeline = \"truth\"\n[sensor]\n\
         preset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{{ straight_m = 6.0 }}]\n{more}"
    );
    Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
}

fn run_at(scenario: &Scenario, pace: Pace) -> RunRecord {
    let watch = |_: &FrameRecord, _: &GreyImage| ControlFlow::Continue(());
    run_with(scenario, Pilot::of(scenario), &mut Blind, pace, watch).expect("a run")
}

fn run(more: &str) -> RunRecord {
    run_at(&scenario(more), Pace::Alone)
}

fn heard(record: &RunRecord, hearing: Hearing) -> usize {
    record.frames.iter().filter(|frame| frame.body.hearing == hearing).count()
}

/// Lateral RMS over the frames from this distance on, in metres.
fn rms_m(record: &RunRecord, from_m: f64) -> f64 {
    let settled: Vec<f64> = record.frames.iter().filter(|f| f.truth.distance_m >= from_m).map(|f| f.truth.lateral_m).collect();
    (settled.iter().map(|x| x * x).sum::<f64>() / settled.len() as f64).sqrt()
}

/// The last command that is heard left a frame before the link went. From it on: 0.5 s at speed, then 1 m/s2 down to standstill. At
/// 4 s the robot has come to its speed, whichever of the two.
#[test]
fn a_link_lost_for_ever_brings_the_robot_to_rest_within_the_stated_distance() {
    for (arithmetic, speed_m_s) in [("fixed", 0.3), ("float", 0.3), ("fixed", 0.8)] {
        let record = run(&format!(
            "[robot]\nspeed_m_s = {speed_m_s}\n[wheel_control]\narithmetic = \"{arithmetic}\"\n\
             [[fault]]\nkind = \"link-lost\"\nat_s = 4.0\n"
        ));
        assert_eq!(record.end, EndState::Stopped, "{arithmetic} {speed_m_s}");
        let at = record.frames.iter().find(|frame| frame.time_s >= 4.0).expect("four seconds").truth.distance_m;
        let end = record.frames.last().expect("frames");
        let stated_m = speed_m_s * (0.5 - 1.0 / 30.0) + speed_m_s * speed_m_s / 2.0;
        let went_m = end.truth.distance_m - at;
        // A tick of the wheel controller and the loop's lag of a sixtieth of a second.
        let slack_m = speed_m_s * 0.02;
        assert!((went_m - stated_m).abs() < slack_m, "{arithmetic} at {speed_m_s} m/s: {went_m} m, not {stated_m} m");
        assert!(end.truth.speed_m_s.abs() < 1e-3 && end.truth.lateral_m.abs() < 5e-3, "{:?}", end.truth);
        assert!(heard(&record, Hearing::RampingDown) > 0 && end.body.hearing == Hearing::Down);
        assert!(end.body.link.lost > 0);
    }
}

#[test]
fn a_short_gap_is_driven_through_and_a_longer_one_only_slows_the_robot_down() {
    let gap = |for_s: f64| run(&format!("[[fault]]\nkind = \"link-lost\"\nat_s = 3.0\nfor_s = {for_s}\n"));
    let short = gap(0.4);
    assert_eq!((short.end, heard(&short, Hearing::RampingDown)), (EndState::Finished, 0));
    // 0.5 s go by, 0.3 s it slows down, the rest it stands; less than a second of that, so the run goes on.
    let long = gap(1.2);
    assert_eq!(long.end, EndState::Finished);
    assert!(heard(&long, Hearing::RampingDown) >= 8 && heard(&long, Hearing::Down) >= 8);
    assert!(long.frames.iter().any(|f| f.time_s > 3.9 && f.time_s < 4.2 && f.truth.speed_m_s.abs() < 0.01));
    // The law's target has gone on meanwhile, and the robot catches up with it.
    assert!(long.sim_time_s >= short.sim_time_s, "{} {}", long.sim_time_s, short.sim_time_s);
}

/// A link that never carries anything: the robot never moves, and the run ends.
#[test]
fn a_link_that_is_dead_from_the_start_ends_the_run_where_it_began() {
    let record = run("[link]\nloss = 1.0\n");
    assert_eq!(record.end, EndState::Stopped);
    assert!(record.distance_m.abs() < 1e-3 && record.sim_time_s < 2.0, "{} {}", record.distance_m, record.sim_time_s);
}

/// A poor link: 20 ms and up to 40 ms more, every fifth command lost, every tenth twice. From 60 mm aside the robot still lands on the
/// centreline, and every run of it is the same.
#[test]
fn a_poor_link_is_driven_and_is_the_same_every_time() {
    let poor =
        "[link]\nlatency_ms = 20.0\njitter_ms = 40.0\nloss = 0.2\nrepeat = 0.1\n[start]\nlateral_m = 0.06\nheading_deg = 6.0\n";
    let record = run(poor);
    let counts = record.frames.last().expect("frames").body.link;
    assert_eq!(record.end, EndState::Finished);
    // Two commands a frame, 600 frames: 240 lost, 100 repeated.
    assert!(counts.lost > 150 && counts.dropped > 50, "{counts:?}");
    // Measured 4.8e-6 m, on an ideal link 2.1e-6 m; ten times that, for other seeds and laws.
    assert!(rms_m(&record, 2.5) < 5e-5, "{}", rms_m(&record, 2.5));
    let again = run_at(&scenario(poor), Pace::Overlapped);
    assert_eq!((again.run_hash, &again.frames), (record.run_hash, &record.frames));
    assert_ne!(run(&format!("{poor}distance_m = 0.31\n")).run_hash, record.run_hash);
    let other = Scenario { seed: 2, ..scenario(poor) };
    assert_ne!(run_at(&other, Pace::Alone).run_hash, record.run_hash);
}

/// Integers and an 8-bit PWM make no difference that could be seen on the way.
#[test]
fn fixed_and_float_drive_alike() {
    let landing = |arithmetic: &str| {
        run(&format!("[wheel_control]\narithmetic = \"{arithmetic}\"\n[start]\nlateral_m = 0.06\nheading_deg = 6.0\n"))
    };
    let (fixed, float) = (landing("fixed"), landing("float"));
    assert_eq!((fixed.end, float.end), (EndState::Finished, EndState::Finished));
    assert_ne!(fixed.run_hash, float.run_hash);
    let apart = fixed.frames.iter().zip(&float.frames).map(|(a, b)| (a.truth.lateral_m - b.truth.lateral_m).abs());
    let apart_m = apart.fold(0.0, f64::max);
    // Measured 7e-6 m. One place of the PWM is 4.9 mm/s of wheel speed, over a tick of 5 ms 24 um: two of those.
    assert!(apart_m < 5e-5, "{apart_m}");
}

/// The mount swings by 0.1 rad every 2 s with 1 degree of play and an encoder of 0.25 degrees: the navigator is told the encoder's
/// angle, the picture is taken from the camera's, half the play behind while it swings.
#[test]
fn the_navigator_is_told_the_encoders_angle_and_the_picture_shows_the_true_one() {
    let scenario = scenario(
        "[mount_control]\nbacklash_deg = 1.0\nencoder_step_deg = 0.25\nsweep_pan_deg = 6.0\nsweep_period_s = 2.0\n\
         [finish]\nbefore_end_m = 3.0\n",
    );
    let record = run_at(&scenario, Pace::Alone);
    assert_eq!(record.end, EndState::Finished);
    let (play, step) = (1.0_f64.to_radians(), 0.25_f64.to_radians());
    let rig = scenario.actual_rig();
    let (mut widest, mut behind) = (0.0_f64, 0);
    for frame in &record.frames {
        let (told, camera) = (frame.mount, frame.body.mount);
        let counts = told.pan_rad / step;
        assert!((counts - counts.round()).abs() < 1e-9, "frame {}: {counts} counts", frame.frame);
        let gap = (told.pan_rad - camera.pan_rad).abs();
        assert!(gap <= play / 2.0 + step / 2.0 + 1e-9, "frame {}: {gap}", frame.frame);
        behind += usize::from(gap > play / 2.0 - step);
        let seen_from = world_from_camera(&rig, &frame.truth.world_from_base, camera, MountAngles::default());
        assert!((seen_from.to_homogeneous() - frame.view.world_from_camera.to_homogeneous()).norm() < 1e-12);
        widest = widest.max(camera.pan_rad.abs());
    }
    // The camera's swing is the motor's less half the play.
    assert!((widest - (6.0_f64.to_radians() - play / 2.0)).abs() < 1e-3, "{}", widest.to_degrees());
    assert!(behind * 2 > record.frames.len(), "{behind} of {}", record.frames.len());
}

/// What makes no sense is refused where it stands.
#[test]
fn what_the_controllers_cannot_be_is_refused() {
    for (more, path) in [
        ("[rates]\nwheel_control_hz = 10\n", "16-bit integers"),
        ("[wheel_control]\nsilence_s = 0.02\n", "a command comes only every"),
        ("[mount_control]\nsweep_pan_deg = 60.0\nsweep_period_s = 1.0\n", "cannot follow a swing"),
        ("[mount_control]\nacceleration_rad_s2 = 1.0\nsweep_tilt_deg = 6.0\nsweep_period_s = 1.0\n", "cannot follow a swing"),
        ("[wheel_control]\npwm_bits = 3\n", "wheel_control.pwm_bits"),
        ("[link]\nloss = 1.5\n", "link.loss"),
    ] {
        let text = format!(
            "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
             run = [{{ straight_m = 6.0 }}]\n{more}"
        );
        let wrong = Scenario::from_toml_str(&text).expect_err(more);
        assert_eq!(wrong.0.len(), 1, "{more}: {}", wrong.render(false));
        assert!(wrong.0[0].message.contains(path), "{more}: {}", wrong.render(false));
    }
    // A slow encoder rate is no trouble in floating point, nor a slow camera: silence is five frames then.
    let slow = scenario("[rates]\nwheel_control_hz = 10\n[wheel_control]\narithmetic = \"float\"\n");
    assert_eq!(slow.wheel_control.silence_s, 0.5);
    assert_eq!(scenario("[rates]\ncamera_hz = 2\n").wheel_control.silence_s, 2.5);
}
