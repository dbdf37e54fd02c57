//! The command controller with a perception and a law that say what they are told: what it remembers, predicts and gives up.

use std::sync::{Arc, Mutex};

use ductloop_nav::control::limits::Limits;
use ductloop_nav::control::{ControlLaw, PathState, Twist};
use ductloop_nav::course::CourseParams;
use ductloop_nav::messages::{Counts, Frame, Pixels, Sides};
use ductloop_nav::navigator::{DuctNavigator, Navigator, NavigatorParams, Reason, State};
use ductloop_nav::odometry::DriveModel;
use ductloop_nav::perception::{Measurement, Perception};
use ductloop_nav::rig::MountAngles;

/// Shows what the frame's first two pixels say: nothing, or lateral in mm and heading in mrad.
struct Told;

impl Perception for Told {
    fn perceive(&mut self, frame: &Frame<'_>, _mount: MountAngles) -> Measurement {
        let Pixels::Grey8(pixels) = frame.pixels else { return Measurement::default() };
        let seen = (pixels[0] > 0).then(|| (f64::from(pixels[0]) * 1e-3, f64::from(pixels[1]) * 1e-3));
        Measurement { lateral_m: seen.map(|s| s.0), heading_rad: seen.map(|s| s.1), ..Measurement::default() }
    }
}

/// Remembers what it was asked, and always drives straight on.
struct Noted(Arc<Mutex<Vec<PathState>>>);

impl ControlLaw for Noted {
    fn twist(&mut self, state: &PathState) -> Twist {
        self.0.lock().expect("no test panics while it holds this").push(*state);
        Twist { speed_m_s: 0.3, yaw_rate_rad_s: 0.0 }
    }

    fn reset(&mut self, _travelled_m: f64) {}
}

const DRIVE: DriveModel =
    DriveModel { wheel_radius_m: 0.04, effective_track_m: 0.325, counts_per_wheel_turn: 66_000.0, wheel_bandwidth_rad_s: 1e4 };
/// Counts in a frame period at 0.3 m/s.
const COUNTS_A_FRAME: f64 = 0.3 / 0.04 / std::f64::consts::TAU * 66_000.0 / 30.0;

/// Frames as (lateral in mm or 0 for unseen, heading in mrad); returns the states, and what the law was asked.
fn drive(frames: &[[u8; 2]], speed_m_s: f64) -> (Vec<State>, Vec<f64>, Vec<PathState>) {
    let asked = Arc::default();
    let params = NavigatorParams {
        ticks_per_s: 1200.0,
        ticks_per_frame: 40,
        drive: DRIVE,
        coast_s: 0.2,
        frozen_frames: None,
        mount: MountAngles::default(),
        limits: Limits::default(),
        course: CourseParams::default(),
        duct_width_m: 0.5,
    };
    let mut navigator = DuctNavigator::new(params, Told, Noted(Arc::clone(&asked)));
    let (mut states, mut wheels) = (Vec::new(), Vec::new());
    for (i, pixels) in frames.iter().enumerate() {
        let counts = (COUNTS_A_FRAME * speed_m_s / 0.3 * i as f64).round() as i64;
        let frame = Frame::grey8(2, 1, pixels);
        let command = navigator.on_frame(&frame, Counts { left: counts, right: counts }, MountAngles::default(), 40 * i as u64);
        states.push(navigator.report().state);
        wheels.push(command.wheel_speed_rad_s.left);
    }
    let asked = asked.lock().expect("no test panics while it holds this").clone();
    (states, wheels, asked)
}

#[test]
fn without_ever_seeing_a_wall_it_does_not_move() {
    let (states, wheels, asked) = drive(&[[0, 0]; 20], 0.0);
    assert!(states.iter().all(|s| *s == State::Unknown) && wheels.iter().all(|w| *w == 0.0) && asked.is_empty());
}

#[test]
fn it_coasts_for_as_long_as_it_may_and_then_stands() {
    let mut frames = vec![[10, 0]; 3];
    frames.extend([[0, 0]; 12]);
    frames.extend([[10, 0]; 2]);
    let (states, wheels, _) = drive(&frames, 0.3);
    // 0.2 s are six frames: the first unseen frame and six more.
    let expected = |i: usize| match i {
        0..3 | 15.. => State::Tracking,
        3..10 => State::Coasting,
        _ => State::Stopped,
    };
    for (i, (state, wheel)) in states.iter().zip(&wheels).enumerate() {
        assert_eq!(*state, expected(i), "frame {i}: {states:?}");
        assert_eq!(*wheel == 0.0, *state == State::Stopped, "frame {i}");
    }
}

#[test]
fn while_coasting_the_wheels_carry_the_errors_on() {
    // Seen once at 10 mm and 100 mrad to the left, then nothing while it drives straight on at 0.3 m/s.
    let (_, _, asked) = drive(&[[10, 100], [0, 0], [0, 0], [0, 0]], 0.3);
    let step = 0.3 / 30.0;
    for (i, state) in asked.iter().enumerate() {
        // Each is advanced by one period from exposure to actuation; on the first frame nothing is commanded yet.
        let periods = i as f64 + f64::from(u8::from(i > 0));
        assert!((state.lateral_m - (0.010 + periods * step * libm::sin(0.1))).abs() < 1e-6, "{i}: {state:?}");
        assert!((state.travelled_m - periods * step * libm::cos(0.1)).abs() < 1e-6, "{i}: {state:?}");
        assert!((state.heading_rad - 0.1).abs() < 1e-9);
    }
    assert_eq!(asked.len(), 4);
}

/// A law goes on by the time that has passed: with every other frame lost it is told of two periods, and after a long gap of no more
/// than the robot may coast.
#[test]
fn lost_frames_do_not_slow_the_law_down() {
    let asked = Arc::default();
    let params = NavigatorParams {
        ticks_per_s: 1200.0,
        ticks_per_frame: 40,
        drive: DRIVE,
        coast_s: 0.2,
        frozen_frames: None,
        mount: MountAngles::default(),
        limits: Limits::default(),
        course: CourseParams::default(),
        duct_width_m: 0.5,
    };
    let mut navigator = DuctNavigator::new(params, Told, Noted(Arc::clone(&asked)));
    for tick in [0, 40, 120, 160, 1600] {
        let frame = Frame::grey8(2, 1, &[10, 0]);
        let _ = navigator.on_frame(&frame, Counts::default(), MountAngles::default(), tick);
    }
    let periods: Vec<f64> =
        asked.lock().expect("no test panics while it holds this").iter().map(|state| state.period_s * 30.0).collect();
    let expected = [1.0, 1.0, 2.0, 1.0, 6.0];
    assert!(periods.iter().zip(expected).all(|(told, truly)| (told - truly).abs() < 1e-12) && periods.len() == 5, "{periods:?}");
}

/// Three frames in a row that are the same as the one before are a frozen camera: it coasts, and then stands, and says why.
#[test]
fn a_frozen_camera_is_not_believed() {
    let params = NavigatorParams {
        ticks_per_s: 1200.0,
        ticks_per_frame: 40,
        drive: DRIVE,
        coast_s: 0.1,
        frozen_frames: Some(3),
        mount: MountAngles::default(),
        limits: Limits::default(),
        course: CourseParams::default(),
        duct_width_m: 0.5,
    };
    let mut navigator = DuctNavigator::new(params, Told, Noted(Arc::default()));
    let mut told = Vec::new();
    for (i, lateral_mm) in [10, 11, 12, 12, 12, 12, 12, 12, 12, 12, 12, 13].into_iter().enumerate() {
        let pixels = [lateral_mm, 0];
        let frame = Frame::grey8(2, 1, &pixels);
        let _ = navigator.on_frame(&frame, Counts::default(), MountAngles::default(), 40 * i as u64);
        told.push((navigator.report().state, navigator.report().reason));
    }
    let frozen = Some(Reason::FrozenCamera);
    // 0.1 s are three frames: the first that is not believed, and three more.
    let expected = |i: usize| match i {
        0..5 | 11 => (State::Tracking, None),
        5..9 => (State::Coasting, frozen),
        _ => (State::Stopped, frozen),
    };
    for (i, told) in told.iter().enumerate() {
        assert_eq!(*told, expected(i), "frame {i}");
    }
}

/// Always turns to the left.
struct Turning;

impl ControlLaw for Turning {
    fn twist(&mut self, _state: &PathState) -> Twist {
        Twist { speed_m_s: 0.3, yaw_rate_rad_s: 0.5 }
    }

    fn reset(&mut self, _travelled_m: f64) {}
}

/// Wheels that turn the robot the other way than they are told stop it for good; obedient ones do not.
#[test]
fn exchanged_wheels_stop_it() {
    for exchanged in [false, true] {
        let params = NavigatorParams {
            ticks_per_s: 1200.0,
            ticks_per_frame: 40,
            drive: DRIVE,
            coast_s: 0.2,
            frozen_frames: None,
            mount: MountAngles::default(),
            limits: Limits::default(),
            course: CourseParams::default(),
            duct_width_m: 0.5,
        };
        let mut navigator = DuctNavigator::new(params, Told, Turning);
        let (mut wheels, mut turned, mut said) = ([0.0; 2], [0.0; 2], Vec::new());
        for frame in 0..20u64 {
            // Counts of a frame period under the command that took effect at its beginning.
            let scale = COUNTS_A_FRAME / (0.3 / 0.04);
            (0..2).for_each(|side| turned[side] += wheels[side] * scale);
            let counts = Counts { left: turned[0].round() as i64, right: turned[1].round() as i64 };
            let command = navigator.on_frame(&Frame::grey8(2, 1, &[10, 0]), counts, MountAngles::default(), 40 * frame);
            // It takes effect at the next frame.
            let Sides { left, right } = command.wheel_speed_rad_s;
            let report = navigator.report();
            said.push((report.state, report.reason, left));
            wheels = if exchanged { [right, left] } else { [left, right] };
        }
        let (state, reason, left) = said[19];
        if exchanged {
            assert_eq!((state, reason, left), (State::Stopped, Some(Reason::WheelsSwapped), 0.0), "{said:?}");
            // Told for the first time with frame 0; six frames of it.
            let first = said.iter().position(|(state, ..)| *state == State::Stopped);
            assert_eq!(first, Some(7), "{said:?}");
        } else {
            assert!(said.iter().all(|(state, ..)| *state == State::Tracking), "{said:?}");
        }
    }
}
