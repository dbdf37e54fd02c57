//! A navigator that comes into a bend and sees nothing from there on.

use std::sync::{Arc, Mutex};

use super::plan::{AT_M, WIDTH_M, elbow, scan};
use ductloop_nav::control::limits::Limits;
use ductloop_nav::control::{ControlLaw, PathState, Twist};
use ductloop_nav::course::CourseParams;
use ductloop_nav::messages::{Counts, Frame};
use ductloop_nav::navigator::{DuctNavigator, Navigator, NavigatorParams, Reason, State};
use ductloop_nav::odometry::DriveModel;
use ductloop_nav::perception::{Measurement, Perception, RangePoint, Stages};
use ductloop_nav::rig::MountAngles;

/// Shows ranges and, where there are any, a robot in the middle of its duct.
struct Shown {
    next: Arc<Mutex<Vec<RangePoint>>>,
    ranges: Vec<RangePoint>,
}

impl Perception for Shown {
    fn perceive(&mut self, _frame: &Frame<'_>, _mount: MountAngles) -> Measurement {
        self.ranges = self.next.lock().map(|next| next.clone()).unwrap_or_default();
        let seen = (!self.ranges.is_empty()).then_some(0.0);
        Measurement { lateral_m: seen, heading_rad: seen, width_m: seen.map(|_| WIDTH_M), ..Measurement::default() }
    }

    fn stages(&self) -> Stages<'_> {
        Stages { ranges: &self.ranges, ..Stages::default() }
    }
}

/// Straight on.
struct On;

impl ControlLaw for On {
    fn twist(&mut self, _state: &PathState) -> Twist {
        Twist { speed_m_s: 0.3, yaw_rate_rad_s: 0.0 }
    }

    fn reset(&mut self, _travelled_m: f64) {}
}

const DRIVE: DriveModel =
    DriveModel { wheel_radius_m: 0.04, effective_track_m: 0.325, counts_per_wheel_turn: 66_000.0, wheel_bandwidth_rad_s: 1e4 };
const STEP_M: f64 = 0.01;

/// In the bend of half a circle the lights go out, and the wheels turn on against its wall without turning the robot: by them it would be
/// in the bend for ever. After four metres it stands.
#[test]
fn by_its_wheels_alone_it_goes_four_metres() {
    let (walls, _) = elbow(std::f64::consts::PI, 0.375);
    let next = Arc::new(Mutex::new(Vec::new()));
    let params = NavigatorParams {
        ticks_per_s: 1200.0,
        ticks_per_frame: 40,
        drive: DRIVE,
        coast_s: 0.2,
        frozen_frames: None,
        mount: MountAngles::default(),
        limits: Limits::default(),
        course: CourseParams::default(),
        duct_width_m: WIDTH_M,
    };
    let mut navigator = DuctNavigator::new(params, Shown { next: Arc::clone(&next), ranges: Vec::new() }, On);
    let counts_a_frame = STEP_M / DRIVE.metres_per_count();
    let (mut dark_m, mut stopped_m) = (0.0, None);
    for frame in 0..1200_u64 {
        let x = STEP_M * frame as f64;
        if x > AT_M + 0.1 {
            dark_m += STEP_M;
        }
        *next.lock().expect("no test panics while it holds this") =
            if dark_m > 0.0 { Vec::new() } else { scan(&walls, [x, 0.0, 0.0], 0.2) };
        let count = (counts_a_frame * frame as f64).round() as i64;
        let _ = navigator.on_frame(
            &Frame::grey8(1, 1, &[0]),
            Counts { left: count, right: count },
            MountAngles::default(),
            40 * frame,
        );
        let report = navigator.report();
        if report.state == State::Stopped {
            assert_eq!(report.reason, Some(Reason::CoastedTooLong));
            stopped_m = Some(dark_m);
            break;
        }
    }
    // The 0.85 m and more before the bend it has gone by its wheels already; and it coasts for six frames more.
    assert!(stopped_m.is_some_and(|stopped_m| (3.0..3.4).contains(&stopped_m)), "{stopped_m:?} of {dark_m} m in the dark");
}
