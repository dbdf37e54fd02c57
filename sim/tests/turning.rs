//! Skid steering against its closed form: four point contacts, isotropic Coulomb friction.

mod common;

use std::f64::consts::TAU;

use common::{GRIP, HZ, SpeedLoop, pose, room, straight, with_aspect};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};

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

/// What is asked for is 3 %. At 1200 Hz it is 0.02 to 0.09 %, which grows with the mass: the wheels' sinking-in (0.03 mm of 40 mm
/// under 5 kg) makes them that much smaller. Three times the worst of it leaves room for another engine version.
const AT_1200_HZ: f64 = 3e-3;

fn assert_chi(turn: &Turn, theory: f64, tolerance: f64, what: &str) {
    let ratio = turn.chi / theory;
    println!("{what}: chi {:.4}, theory {theory:.4}, ratio {ratio:.5}, ripple {:.1e}", turn.chi, turn.ripple);
    assert!((ratio - 1.0).abs() < tolerance, "{what}");
    // A friction box instead of a cone would show as tens of percent, four times a turn. Measured: 1e-11 and less, rounding;
    // 1e-7 at 300 Hz. A millionth leaves room for another engine version.
    assert!(turn.ripple < 1e-6, "{what}: ripple {:.1e}", turn.ripple);
}

#[test]
fn yaw_rate_is_that_of_the_ideal_drive_over_chi() {
    for ratio in [0.5, 0.16 / 0.19, 1.2] {
        let robot = with_aspect(ratio);
        for speeds in [[4.0, 6.0], [-2.0, 2.0], [0.0, 3.0]] {
            assert_chi(
                &turn(&robot, GRIP, HZ, speeds),
                robot.chi(),
                AT_1200_HZ,
                &format!("L/W {ratio:.3}, wheels {speeds:?} rad/s"),
            );
        }
    }
}

#[test]
fn chi_depends_neither_on_grip_nor_load() {
    for ratio in [0.4, 0.6, 0.16 / 0.19, 1.0, 1.2, 1.5] {
        for (grip, mass_kg) in [(0.3, 5.0), (0.9, 5.0), (GRIP, 2.5), (GRIP, 12.0)] {
            let mut robot = with_aspect(ratio);
            robot.mass_kg = mass_kg;
            let what = format!("L/W {ratio:.3}, mu {grip}, {mass_kg} kg");
            assert_chi(&turn(&robot, grip, HZ, [-2.0, 2.0]), robot.chi(), AT_1200_HZ, &what);
        }
    }
}

#[test]
fn chi_does_not_depend_on_the_rate() {
    let robot = RobotSpec::incra1();
    // Contacts are as stiff as the tick allows: four times softer at half the rate, and the sinking-in with them. Measured: 0.58,
    // 0.15, 0.009, 0.002 %.
    for (hz, tolerance) in [(300, 0.01), (600, 4e-3), (2400, 5e-4), (4800, 1e-4)] {
        assert_chi(&turn(&robot, GRIP, hz, [-2.0, 2.0]), robot.chi(), tolerance, &format!("{hz} Hz"));
    }
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
