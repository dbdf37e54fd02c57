//! Skid steering against its closed form: four point contacts, isotropic Coulomb friction.

mod common;

use std::f64::consts::TAU;

use common::{GRIP, HZ, SpeedLoop, fitting, pose, run, straight};
use ductloop_duct::fitting::Shape;
use ductloop_duct::network::Network;
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};

/// A room wide enough to drive circles in.
fn room() -> Network {
    let mut room = fitting(Shape::Straight { length_m: 8.0 });
    room.width_m = 8.0;
    run(&[room])
}

/// INCRA I with another ratio of wheelbase to track.
fn with_aspect(ratio: f64) -> RobotSpec {
    let mut robot = RobotSpec::incra1();
    robot.track_m = robot.wheelbase_m / ratio;
    robot.chassis_m[1] = robot.chassis_m[1].min(robot.track_m - robot.wheel_width_m);
    robot
}

struct Turn {
    /// Yaw rate of the ideal differential drive over the robot's.
    chi: f64,
    /// (largest - smallest) / mean yaw rate.
    ripple: f64,
}

/// Drives one full turn at steady wheel speeds, after 2 s to settle.
fn turn(robot: &RobotSpec, grip: f64, physics_hz: u32, speeds: [f64; 2]) -> Turn {
    let start = pose(4.0, 0.0, 0.3);
    let mut world =
        World::new(&room(), robot, &Ground::uniform(grip), &start, MountAngles::default(), physics_hz).expect("world");
    let wheels = Sides { left: speeds[0], right: speeds[1] };
    let mut hold = SpeedLoop::new();
    for _ in 0..2 * physics_hz {
        hold.step(&mut world, wheels);
    }
    let (mut turned, mut difference, mut ticks) = (0.0, 0.0, 0_u32);
    let (mut slowest, mut fastest) = (f64::INFINITY, f64::NEG_INFINITY);
    while turned < TAU {
        hold.step(&mut world, wheels);
        let truth = world.truth();
        turned += truth.yaw_rate_rad_s / f64::from(physics_hz);
        difference += truth.wheel_speed_rad_s.right - truth.wheel_speed_rad_s.left;
        slowest = slowest.min(truth.yaw_rate_rad_s);
        fastest = fastest.max(truth.yaw_rate_rad_s);
        ticks += 1;
        assert!(ticks < 60 * physics_hz, "it does not turn: {truth:?}");
    }
    let mean = turned * f64::from(physics_hz) / f64::from(ticks);
    let ideal = robot.wheel_radius_m * difference / f64::from(ticks) / robot.track_m;
    assert_eq!(world.collisions().count, 0);
    Turn { chi: ideal / mean, ripple: (fastest - slowest) / mean }
}

fn assert_chi(turn: &Turn, theory: f64, what: &str) {
    let ratio = turn.chi / theory;
    println!("{what}: chi {:.4}, theory {theory:.4}, ratio {ratio:.5}, ripple {:.1e}", turn.chi, turn.ripple);
    // What is asked for is 3 %. Measured at 1200 Hz: 0.05 %, most of it the wheels' sinking-in (0.03 mm of 40 mm); 0.24 % with
    // 60 % of the load in front, against a theory printed to 0.04 %.
    assert!((ratio - 1.0).abs() < 0.03, "{what}");
}

#[test]
fn yaw_rate_is_that_of_the_ideal_drive_over_chi() {
    for ratio in [0.16 / 0.19, 0.5, 1.2] {
        let robot = with_aspect(ratio);
        for speeds in [[4.0, 6.0], [-2.0, 2.0], [0.0, 3.0]] {
            assert_chi(&turn(&robot, GRIP, HZ, speeds), robot.chi(), &format!("L/W {ratio:.3}, wheels {speeds:?} rad/s"));
        }
    }
}

#[test]
fn chi_depends_neither_on_grip_nor_mass_nor_rate() {
    let robot = RobotSpec::incra1();
    let mut heavy = RobotSpec::incra1();
    heavy.mass_kg = 12.0;
    assert_chi(&turn(&robot, 0.25, HZ, [-2.0, 2.0]), robot.chi(), "mu 0.25");
    assert_chi(&turn(&heavy, GRIP, HZ, [-2.0, 2.0]), robot.chi(), "12 kg");
    for hz in [300, 600, 4800] {
        assert_chi(&turn(&robot, GRIP, hz, [-2.0, 2.0]), robot.chi(), &format!("{hz} Hz"));
    }
}

#[test]
fn a_load_shifted_forward_turns_easier() {
    // Published solutions of the same four contacts at L/W = 2/3 for 50, 55, 60 % of the weight on the front axle.
    for (front, theory) in [(0.5, 1.444), (0.55, 1.395), (0.6, 1.210)] {
        let mut robot = with_aspect(2.0 / 3.0);
        robot.centre_of_mass_m[0] = (front - 0.5) * robot.wheelbase_m;
        assert_chi(&turn(&robot, GRIP, HZ, [-2.0, 2.0]), theory, &format!("{:.0} % in front", front * 100.0));
    }
}

#[test]
fn spinning_on_the_spot_is_smooth() {
    let spin = turn(&RobotSpec::incra1(), GRIP, HZ, [-2.0, 2.0]);
    // A friction box instead of a cone would show as tens of percent, four times a turn. Measured: 5e-13 of the mean, which is
    // rounding; a millionth leaves room for another engine version.
    assert!(spin.ripple < 1e-6, "ripple {:.1e}", spin.ripple);
}

#[test]
fn equal_wheel_speeds_drive_straight() {
    let mut world = common::world(&straight(12.0), &RobotSpec::incra1(), &pose(0.5, 0.0, 0.0));
    let mut hold = SpeedLoop::new();
    let wheels = Sides { left: 7.5, right: 7.5 };
    hold.hold(&mut world, wheels, 1.0);
    let start = world.truth();
    hold.hold(&mut world, wheels, 10.0 / 0.3);
    let end = world.truth();
    let travelled = end.distance_m - start.distance_m;
    let drift = end.lateral_m - start.lateral_m - start.heading_rad * travelled;
    println!("drift {:.4} mm in {travelled:.3} m", drift * 1e3);
    // Asked for: 1 mm. Measured: 0.014 mm; the order in which the solver takes the wheels is not symmetric.
    assert!(drift.abs() < 1e-3);
    // Sinking in by 0.03 mm shortens the arc by less than a part in a thousand; measured 0.04 %.
    let arc = 0.04 * 7.5 * 10.0 / 0.3;
    assert!((travelled / arc - 1.0).abs() < 1e-3, "{travelled}");
}
