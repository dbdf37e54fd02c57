//! In the steady state the navigator allocates nothing.

mod common;

use common::{Pose, image, wide};
use ductloop_nav::control::koh_cho::{KohCho, KohChoParams};
use ductloop_nav::control::limits::Limits;
use ductloop_nav::course::CourseParams;
use ductloop_nav::exposure::{AutoExposure, ExposureParams};
use ductloop_nav::messages::{Counts, Frame};
use ductloop_nav::navigator::{DuctNavigator, Navigator, NavigatorParams, State};
use ductloop_nav::odometry::DriveModel;
use ductloop_nav::perception::Perception;
use ductloop_nav::perception::paper::{PaperParams, PaperPerception};
use ductloop_nav::perception::robust::{RobustParams, RobustPerception};
use ductloop_nav::rig::MountAngles;
use ductloop_nav::wheel_controller::{WheelController, WheelGains};

#[test]
fn no_allocation_after_the_first_frames() {
    let rig = wide();
    does_not_allocate(PaperPerception::new(rig.clone(), PaperParams::default()));
    does_not_allocate(RobustPerception::new(rig, RobustParams::default()));
}

fn does_not_allocate(perception: impl Perception) {
    let rig = wide();
    let poses = [0.0, 0.01, 0.02, -0.02].map(|lateral_m| Pose { lateral_m, heading_rad: 0.02, width_m: 0.5 });
    let mut images = poses.map(|pose| image(&rig, &pose, [true; 2])).to_vec();
    images.push(vec![8; 640 * 480]);
    let drive = DriveModel {
        wheel_radius_m: 0.04,
        effective_track_m: 0.325,
        counts_per_wheel_turn: 66_000.0,
        wheel_bandwidth_rad_s: 60.0,
    };
    let params = NavigatorParams {
        ticks_per_s: 1200.0,
        ticks_per_frame: 40,
        drive,
        coast_s: 0.5,
        frozen_frames: None,
        mount: MountAngles::default(),
        limits: Limits::default(),
        course: CourseParams::default(),
        duct_width_m: 0.5,
    };
    let exposure = ExposureParams { target_dn: 150.0, exposure_s: [1e-4, 1e-2], laser_power: [0.1, 1.0], first_exposure_s: 4e-3 };
    let law = KohCho::new(0.3, Limits::default(), KohChoParams::default());
    let mut navigator = DuctNavigator::new(params, perception, law).with_auto_exposure(AutoExposure::new(exposure, &rig));
    let mut wheels = WheelController::new(WheelGains::from_bandwidth(60.0, 31.2, 0.02), 0.005, 66_000.0);
    let mut step = |index: usize| {
        let frame = Frame::grey8(640, 480, &images[index % images.len()]);
        let counts = Counts { left: 2600 * index as i64, right: 2600 * index as i64 };
        let command = navigator.on_frame(&frame, counts, rig.mount.rest, 40 * index as u64);
        wheels.command(command.wheel_speed_rad_s);
        wheels.tick(counts);
        navigator.report().state
    };
    // Every image once: buffers grow to what the fullest needs.
    let states: Vec<State> = (0..5).map(&mut step).collect();
    assert_eq!(states, [State::Tracking, State::Tracking, State::Tracking, State::Tracking, State::Coasting]);
    let counted = allocation_counter::measure(|| {
        (5..30).for_each(|index| {
            step(index);
        });
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}
