//! Floors that are not one plane: slopes with their kinks, holes, seams.

mod common;

use std::f64::consts::PI;

use common::{G, GRIP, HZ, SpeedLoop, fitting, ideal, pose, run, straight, world};
use ductloop_duct::fitting::Shape;
use ductloop_duct::network::{End, Network};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, Truth, World};
use nalgebra::Point3;

const TEN_DEG: f64 = 10.0 * PI / 180.0;

fn even(wheel_rad_s: f64) -> Sides {
    Sides { left: wheel_rad_s, right: wheel_rad_s }
}

fn straight_of(length_m: f64) -> ductloop_duct::fitting::Fitting {
    fitting(Shape::Straight { length_m })
}

fn slope_of(length_m: f64, angle_rad: f64) -> ductloop_duct::fitting::Fitting {
    fitting(Shape::Slope { length_m, angle_rad })
}

/// 1 m level, 2 m of slope seen from above, 1 m level.
fn over_a_slope(angle_rad: f64) -> Network {
    run(&[straight_of(1.0), slope_of(2.0, angle_rad), straight_of(1.0)])
}

/// Drives straight ahead until the truth says to stop; calls `each` after every tick.
fn drive(world: &mut World, robot: &RobotSpec, speed_m_s: f64, mut go_on: impl FnMut(&Truth) -> bool) {
    let mut hold = SpeedLoop::new();
    while go_on(&world.truth()) {
        hold.step(world, even(speed_m_s / robot.wheel_radius_m));
        assert!(world.tick() < 60 * u64::from(HZ), "{:?}", world.truth());
    }
}

/// Height of the lowest place that a wheel's centre can have at x over a floor of these corners: a circle rolls over it.
fn rolls_at_m(floor: &[[f64; 2]], x_m: f64, radius_m: f64) -> f64 {
    let mut height_m = f64::NEG_INFINITY;
    for edge in floor.windows(2) {
        let ([x0, z0], [x1, z1]) = (edge[0], edge[1]);
        let long_m = ((x1 - x0) * (x1 - x0) + (z1 - z0) * (z1 - z0)).sqrt();
        let (c, s) = ((x1 - x0) / long_m, (z1 - z0) / long_m);
        // The edge, moved off by the radius.
        if (x0 - radius_m * s..=x1 - radius_m * s).contains(&x_m) {
            height_m = height_m.max(z0 + radius_m * c + (x_m - x0 + radius_m * s) * s / c);
        }
    }
    for [x, z] in floor {
        let off_m = (x_m - x).abs();
        if off_m <= radius_m {
            height_m = height_m.max(z + (radius_m * radius_m - off_m * off_m).sqrt());
        }
    }
    height_m
}

/// Largest distance of any wheel's centre from where it rolls.
fn off_the_floor_m(floor: &[[f64; 2]], truth: &Truth, robot: &RobotSpec) -> f64 {
    ductloop_sim::outline::wheel_centres_m(robot)
        .into_iter()
        .map(|centre| truth.world_from_base * Point3::from(centre))
        .map(|centre| (centre.z - rolls_at_m(floor, centre.x, robot.wheel_radius_m)).abs())
        .fold(0.0, f64::max)
}

#[test]
fn up_a_slope_it_takes_the_torque_that_lifts_it() {
    let robot = ideal();
    for angle in [TEN_DEG, -TEN_DEG, 0.05] {
        let network = over_a_slope(angle);
        let mut world = world(&network, &robot, &pose(0.4, 0.0, 0.0));
        drive(&mut world, &robot, 0.25, |truth| truth.distance_m < 2.5);
        let truth = world.truth();
        assert_eq!(truth.fitting, 1);
        let motor_n_m = robot.mass_kg * G * libm::sin(angle) * robot.wheel_radius_m / 2.0 / robot.drive.gear_ratio;
        let expected_a = motor_n_m / robot.drive.motor_constant;
        println!(
            "{angle:.3} rad: {:.4} m/s, {:.4} A, closed form {expected_a:.4} A",
            truth.speed_m_s, truth.motor_current_a.left
        );
        // Contacts creep by some tenths of a percent under load, and the loop's integral is still settling.
        assert!((truth.speed_m_s - 0.25).abs() < 0.01 * 0.25);
        assert!((truth.motor_current_a.left - expected_a).abs() < 0.02 * expected_a.abs(), "{truth:?}");
        let pitch = libm::asin((truth.world_from_base.rotation * nalgebra::Vector3::x()).z);
        assert!((pitch - angle).abs() < 1e-3, "{pitch}");
        assert_eq!(world.collisions().count, 0);
    }
}

#[test]
fn over_kinks_wheels_go_where_circles_roll() {
    let robot = RobotSpec::incra1();
    for angle in [TEN_DEG, -TEN_DEG] {
        let network = over_a_slope(angle);
        let rise_m = 2.0 * libm::tan(angle);
        let floor = [[0.0, 0.0], [1.0, 0.0], [3.0, rise_m], [4.0, rise_m]];
        let mut world = world(&network, &robot, &pose(0.4, 0.0, 0.0));
        let (mut off_m, mut at_m): (f64, f64) = (0.0, 0.0);
        drive(&mut world, &robot, 0.25, |truth| {
            let here_m = off_the_floor_m(&floor, truth, &robot);
            if here_m > off_m {
                (off_m, at_m) = (here_m, truth.distance_m);
            }
            truth.distance_m < 3.6
        });
        let truth = world.truth();
        println!("{angle:.3} rad: at most {:.3} mm off at {at_m:.3} m, lateral {:.2e} m", off_m * 1e3, truth.lateral_m);
        // At rest a wheel sinks by 0.03 mm; where it meets the upward plane at 0.25 m/s, a tick carries it 0.04 mm into it.
        assert!(off_m < 0.2e-3, "{off_m} m at {at_m} m");
        assert!(truth.lateral_m.abs() < 1e-4 && truth.heading_rad.abs() < 1e-4, "{truth:?}");
        assert_eq!(world.collisions().count, 0);
    }
}

#[test]
fn askew_over_kinks_no_wheel_sinks_in() {
    let robot = RobotSpec::incra1();
    for angle in [TEN_DEG, -TEN_DEG] {
        let wide = [straight_of(1.0), slope_of(2.0, angle), straight_of(2.0)].map(|mut fitting| {
            fitting.width_m = 4.0;
            fitting
        });
        let rise_m = 2.0 * libm::tan(angle);
        let floor = [[-1.0, 0.0], [1.0, 0.0], [3.0, rise_m], [5.0, rise_m]];
        let mut world = world(&run(&wide), &robot, &pose(0.4, -1.4, 0.7));
        let (mut sunk_m, mut lifted_m): (f64, f64) = (0.0, 0.0);
        drive(&mut world, &robot, 0.25, |truth| {
            for centre in ductloop_sim::outline::wheel_centres_m(&robot) {
                let centre = truth.world_from_base * Point3::from(centre);
                let off_m = centre.z - rolls_at_m(&floor, centre.x, robot.wheel_radius_m);
                (sunk_m, lifted_m) = (sunk_m.max(-off_m), lifted_m.max(off_m));
            }
            truth.world_from_base.translation.x < 3.5
        });
        println!("{angle:.3} rad askew: at most {:.3} mm in, {:.1} mm off", sunk_m * 1e3, lifted_m * 1e3);
        // Four wheels of a rigid robot cannot all stand on two planes: one lifts off, by the track times the sine of the angle at most.
        assert!(sunk_m < 0.3e-3, "{sunk_m}");
        assert!(lifted_m > 1e-3 && lifted_m < robot.track_m * libm::sin(TEN_DEG), "{lifted_m}");
        assert_eq!(world.collisions().count, 0);
    }
}

#[test]
fn seams_in_a_plane_are_not_felt() {
    let robot = RobotSpec::incra1();
    // The slope at the end makes each plane a rule of its own; before it, and on it, there are 30 seams.
    let level: Vec<_> = std::iter::repeat_n(straight_of(0.3), 31).chain([slope_of(1.0, 0.1)]).collect();
    let mut world_of = world(&run(&level), &robot, &pose(0.3, 0.0, 0.0));
    let mut most_m: f64 = 0.0;
    drive(&mut world_of, &robot, 0.3, |truth| {
        most_m = most_m.max(truth.world_from_base.translation.z.abs());
        truth.distance_m < 9.1
    });
    let truth = world_of.truth();
    println!("level: lateral {:.2e} m, heading {:.2e}, height {most_m:.2e} m", truth.lateral_m, truth.heading_rad);
    assert!(truth.lateral_m.abs() < 2e-4 && most_m < 0.1e-3, "{truth:?}");
    assert_eq!(world_of.collisions().count, 0);

    let slope: Vec<_> =
        [straight_of(1.0)].into_iter().chain(std::iter::repeat_n(slope_of(0.2, 0.1), 30)).chain([straight_of(1.0)]).collect();
    let network = run(&slope);
    let mut world_of = world(&network, &robot, &network.centreline.pose_at(1.4));
    let mut most_m: f64 = 0.0;
    drive(&mut world_of, &robot, 0.3, |truth| {
        let pitch = libm::asin((truth.world_from_base.rotation * nalgebra::Vector3::x()).z);
        if truth.distance_m > 1.5 {
            most_m = most_m.max((pitch - 0.1).abs() * robot.wheelbase_m);
        }
        truth.distance_m < 6.8
    });
    let truth = world_of.truth();
    println!("slope: lateral {:.2e} m, heading {:.2e}, front against rear {most_m:.2e} m", truth.lateral_m, truth.heading_rad);
    assert!(truth.lateral_m.abs() < 2e-4 && most_m < 0.1e-3, "{truth:?}");
    assert_eq!(world_of.collisions().count, 0);
}

#[test]
fn locked_wheels_hold_on_a_slope_above_its_tangent_and_slide_below() {
    let mut robot = RobotSpec::incra1();
    robot.drive.coulomb_friction_n_m = 1e3;
    let network = run(&[straight_of(1.0), slope_of(6.0, TEN_DEG), straight_of(1.0)]);
    for (grip, lateral_heading) in [(0.9 * 0.1763, 0.0), (1.1 * 0.1763, 0.0), (1.1 * 0.1763, 1.0)] {
        let start = network.centreline.pose_at(5.0) * pose(0.0, 0.0, lateral_heading);
        let mut world = World::new(&network, &robot, &Ground::uniform(grip), &start, MountAngles::default(), HZ).expect("world");
        let mut speed_after = |seconds: f64| {
            for _ in 0..(seconds * f64::from(HZ)) as usize {
                world.step(Sides::default()).expect("finite");
            }
            let from = world.truth().world_from_base.translation.vector;
            world.step(Sides::default()).expect("finite");
            (world.truth().world_from_base.translation.vector - from).norm() * f64::from(HZ)
        };
        let (before, after) = (speed_after(0.3), speed_after(0.3));
        let expected = (G * (libm::sin(TEN_DEG) - grip * libm::cos(TEN_DEG))).max(0.0);
        println!("mu {grip:.4}: {:.4} m/s2, closed form {expected:.4}", (after - before) / 0.3);
        if expected > 0.0 {
            assert!(((after - before) / 0.3 - expected).abs() < 0.05 * expected, "{before} {after}");
        } else {
            assert!(after < 1e-6, "{after} m/s");
        }
    }
}

fn with_hole(hole_length_m: f64, hole_width_m: f64) -> Network {
    let hole = fitting(Shape::Drop { length_m: 1.0, hole_length_m, hole_width_m, depth_m: 0.6 });
    run(&[straight_of(1.0), hole, straight_of(1.0)])
}

#[test]
fn over_a_hole_it_falls_and_comes_to_lie_in_the_shaft() {
    let robot = RobotSpec::incra1();
    for (width_m, heading) in [(0.5, 0.0), (0.4, 0.0), (0.5, 0.3)] {
        let network = with_hole(0.45, width_m);
        let mut world = world(&network, &robot, &pose(0.7, 0.0, heading));
        for _ in 0..6 * HZ {
            let duty = if world.truth().world_from_base.translation.z < -0.1 { 0.0 } else { 0.2 };
            world.step(even(duty)).expect("finite");
        }
        let truth = world.truth();
        println!("{width_m} m wide: {truth:?}, {:?}", world.collisions());
        assert!(truth.world_from_base.translation.z < -0.3, "{truth:?}");
        assert_eq!((truth.fitting, truth.cell), (1, 2));
        // It lies on the shaft's floor, whichever way up.
        assert!(truth.world_from_base.translation.z > -0.6 - 1e-3, "{truth:?}");
        assert!(truth.speed_m_s.abs() < 0.02, "{truth:?}");
        assert!(world.collisions().count > 0);
    }
}

#[test]
fn before_a_hole_it_stands_and_beside_it_it_passes() {
    let robot = RobotSpec::incra1();
    // The hole begins at x = 1.275 m; at the end the front wheels touch down 45 mm before it.
    let mut before = world(&with_hole(0.45, 0.5), &robot, &pose(0.7, 0.0, 0.0));
    drive(&mut before, &robot, 0.25, |truth| truth.distance_m < 1.15);
    for _ in 0..HZ {
        before.step(Sides::default()).expect("finite");
    }
    let truth = before.truth();
    assert!(truth.world_from_base.translation.z.abs() < 0.1e-3 && truth.distance_m < 1.2, "{truth:?}");
    assert_eq!(before.collisions().count, 0);

    // Between the wheels: the track is 0.19 m.
    let mut beside = world(&with_hole(0.45, 0.1), &robot, &pose(0.7, 0.0, 0.0));
    let mut most_m: f64 = 0.0;
    drive(&mut beside, &robot, 0.25, |truth| {
        most_m = most_m.max(truth.world_from_base.translation.z.abs());
        // The ceiling is nearest: what is below the floor is nothing to be near to.
        assert!((truth.clearance_m - 0.125).abs() < 0.1e-3, "{truth:?}");
        truth.distance_m < 2.4
    });
    assert!(most_m < 0.1e-3, "{most_m}");
    assert_eq!(beside.collisions().count, 0);
}

#[test]
fn into_a_gap_a_wheel_dips_as_deep_as_its_circle() {
    let robot = RobotSpec::incra1();
    let mut world = world(&with_hole(0.02, 0.5), &robot, &pose(0.7, 0.0, 0.0));
    let (gap, end) = (1.49, 1.51);
    let floor = [[0.0, 0.0], [gap, 0.0]];
    let behind = [[end, 0.0], [3.0, 0.0]];
    let (mut off_m, mut dip_m): (f64, f64) = (0.0, 0.0);
    drive(&mut world, &robot, 0.1, |truth| {
        for centre in ductloop_sim::outline::wheel_centres_m(&robot) {
            let centre = truth.world_from_base * Point3::from(centre);
            let rolls_m = [&floor, &behind].map(|floor| rolls_at_m(floor, centre.x, robot.wheel_radius_m));
            off_m = off_m.max((centre.z - rolls_m[0].max(rolls_m[1])).abs());
            dip_m = dip_m.max(robot.wheel_radius_m - centre.z);
        }
        truth.distance_m < 1.8
    });
    let expected_m = 0.04 - (0.04_f64 * 0.04 - 0.01 * 0.01).sqrt();
    println!("dips {:.3} mm, a circle {:.3} mm, off by at most {:.3} mm", dip_m * 1e3, expected_m * 1e3, off_m * 1e3);
    assert!((dip_m - expected_m).abs() < 0.15e-3, "{dip_m}");
    assert!(off_m < 0.3e-3, "{off_m}");
    assert_eq!(world.collisions().count, 0);
}

#[test]
fn out_of_an_open_end_it_rolls_on() {
    let fittings = [slope_of(1.0, -0.1), straight_of(1.0)];
    let network = Network::from_run(&fittings, End::Cap, End::Open).expect("a duct");
    let robot = RobotSpec::incra1();
    let mut world = world(&network, &robot, &network.centreline.pose_at(1.5));
    drive(&mut world, &robot, 0.25, |truth| truth.distance_m < 2.6);
    assert!((world.truth().world_from_base.translation.z - -libm::tan(0.1)).abs() < 0.1e-3, "{:?}", world.truth());
}

#[test]
fn a_floor_that_rises_to_a_smaller_section_is_driven_over() {
    use ductloop_duct::fitting::{AcrossAlign, UprightAlign};
    let narrower = Shape::Transition {
        length_m: 0.8,
        to_width_m: 0.4,
        to_height_m: 0.25,
        across: AcrossAlign::Left,
        upright: UprightAlign::Concentric,
    };
    let mut after = straight_of(1.0);
    (after.width_m, after.height_m) = (0.4, 0.25);
    let network = run(&[straight_of(1.0), fitting(narrower), after]);
    let robot = RobotSpec::incra1();
    // The right wall draws in; 50 mm to the left of the middle is the middle behind it.
    let mut world = world(&network, &robot, &pose(0.4, 0.05, 0.0));
    let floor = [[0.0, 0.0], [1.0, 0.0], [1.8, 0.025], [2.8, 0.025]];
    let mut off_m: f64 = 0.0;
    drive(&mut world, &robot, 0.25, |truth| {
        off_m = off_m.max(off_the_floor_m(&floor, truth, &robot));
        truth.world_from_base.translation.x < 2.4
    });
    assert!(off_m < 0.2e-3, "{off_m}");
    let truth = world.truth();
    assert!(truth.lateral_m.abs() < 1e-3, "{truth:?}");
    assert_eq!(world.collisions().count, 0);
    // The ceiling of 0.25 m is nearer than the walls: its highest point is at 0.175 m.
    assert!((truth.clearance_m - 0.075).abs() < 1e-4, "{truth:?}");
}

#[test]
fn a_level_network_is_one_plane_whatever_it_is_made_of() {
    let many = run(&vec![straight_of(0.3); 20]);
    let one = straight(6.0);
    let mut ends = [many, one].map(|network| {
        let robot = RobotSpec::incra1();
        let mut world = World::new(&network, &robot, &Ground::uniform(GRIP), &pose(0.5, 0.0, 0.0), MountAngles::default(), HZ)
            .expect("world");
        for tick in 0..4 * HZ {
            world.step(Sides { left: 0.2 + 1e-5 * f64::from(tick), right: 0.2 }).expect("finite");
        }
        world.truth().world_from_base
    });
    ends.sort_by(|a, b| a.translation.x.total_cmp(&b.translation.x));
    assert_eq!(ends[0], ends[1]);
}
