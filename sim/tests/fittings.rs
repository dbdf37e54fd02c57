//! Elbows can be driven through: no collider stands in a portal, and the truth follows the path.

mod common;

use std::f64::consts::FRAC_PI_2;

use common::{HZ, SpeedLoop, fitting, pose, run, straight, world};
use ductloop_duct::fitting::Shape;
use ductloop_duct::network::{End, Network};
use ductloop_nav::messages::Sides;
use ductloop_sim::walls::WallError;
use ductloop_sim::{RobotSpec, SimError, Truth, World};

/// Steers on the truth: to `lateral_m` beside the path, at 0.3 m/s, turning with it.
fn follow(world: &mut World, hold: &mut SpeedLoop, network: &Network, robot: &RobotSpec, lateral_m: f64) -> Truth {
    let truth = world.truth();
    let speed = 0.3;
    let curvature = network.centreline.segment_at(truth.distance_m).curvature_1_m;
    let yaw_rate = speed * (curvature - 12.0 * (truth.lateral_m - lateral_m) - 6.0 * truth.heading_rad);
    let half = robot.chi() * robot.track_m / 2.0 * yaw_rate;
    let wheels = Sides { left: (speed - half) / robot.wheel_radius_m, right: (speed + half) / robot.wheel_radius_m };
    hold.step(world, wheels);
    truth
}

#[test]
fn mitred_and_radius_elbows_are_driven_through() {
    let length = |length_m| fitting(Shape::Straight { length_m });
    let network = run(&[
        length(1.5),
        fitting(Shape::MitredElbow { angle_rad: FRAC_PI_2 }),
        length(1.5),
        fitting(Shape::RadiusElbow { angle_rad: -FRAC_PI_2, throat_radius_m: 0.375 }),
        length(1.5),
        fitting(Shape::MitredElbow { angle_rad: -1.2 }),
        length(1.5),
    ]);
    let robot = RobotSpec::incra1();
    let mut world = world(&network, &robot, &pose(0.3, 0.0, 0.0));
    let mut hold = SpeedLoop::new();
    let end = network.centreline.length_m() - 0.4;
    let (mut before, mut least): (Truth, f64) = (world.truth(), f64::INFINITY);
    while before.distance_m < end {
        let truth = follow(&mut world, &mut hold, &network, &robot, 0.0);
        least = least.min(truth.clearance_m);
        // At 0.3 m/s a tick is 0.25 mm; lateral offset scales it in a curve. No jump, no way back.
        let step = truth.distance_m - before.distance_m;
        assert!((-1e-5..1e-3).contains(&step), "{step} m at {} m", truth.distance_m);
        assert!(truth.lateral_m.abs() < 0.1 && truth.heading_rad.abs() < 0.7, "{truth:?}");
        assert_eq!(
            network.cells[truth.cell].fitting,
            network
                .centreline
                .project(&truth.world_from_base.translation.vector.into(), network.cells[truth.cell].fitting)
                .segment
        );
        before = truth;
        assert!(world.tick() < 60 * u64::from(HZ));
    }
    println!("least clearance {least:.4} m in {:.1} s", world.tick() as f64 / f64::from(HZ));
    assert_eq!(world.collisions().count, 0);
    assert!(least > 0.0);
}

#[test]
fn leaning_on_throat_or_heel_it_slides_along() {
    let network = run(&[
        fitting(Shape::Straight { length_m: 1.0 }),
        fitting(Shape::RadiusElbow { angle_rad: FRAC_PI_2, throat_radius_m: 0.375 }),
        fitting(Shape::Straight { length_m: 1.0 }),
    ]);
    let robot = RobotSpec::incra1();
    for lateral_m in [0.18, -0.18] {
        let mut world = world(&network, &robot, &pose(0.3, 0.0, 0.0));
        let mut hold = SpeedLoop::new();
        while world.truth().distance_m < 2.4 && world.tick() < 20 * u64::from(HZ) {
            follow(&mut world, &mut hold, &network, &robot, lateral_m);
        }
        let (truth, collisions) = (world.truth(), world.collisions());
        println!(
            "{lateral_m}: {collisions:?}, {:?} after {:.2} s",
            [truth.distance_m, truth.lateral_m, truth.heading_rad],
            world.tick() as f64 / f64::from(HZ)
        );
        assert!(truth.distance_m >= 2.4 && collisions.count > 0);
        // It meets the walls at a slant; stopped dead by the end of a slab it would be 0.3 m/s.
        assert!(collisions.contact_speed_max_m_s < 0.15, "{collisions:?}");
    }
}

#[test]
fn clearance_in_a_straight_duct_is_what_the_drawing_says() {
    let network = run(&[fitting(Shape::Straight { length_m: 0.1 }), fitting(Shape::Straight { length_m: 3.9 })]);
    let robot = RobotSpec::incra1();
    for (lateral, expected) in [(0.0, 0.125), (0.1, 0.25 - 0.1 - 0.1075), (-0.1, 0.25 - 0.1 - 0.1075)] {
        let world = world(&network, &robot, &pose(2.0, lateral, 0.0));
        // Decimal fractions and, where a wheel's round side faces the wall, nothing to approximate.
        assert!((world.truth().clearance_m - expected).abs() < 1e-9, "{lateral}");
    }
    // Across the seam of the two ducts: the rear end, 0.1 m behind the base, is 0.05 m from the cap; the rear wheels, 0.12 m
    // behind it, 0.03 m.
    let near_cap = world(&network, &robot, &pose(0.15, 0.0, 0.0));
    assert!((near_cap.truth().clearance_m - 0.03).abs() < 1e-9);
}

#[test]
fn a_wall_without_room_behind_it_is_refused() {
    // Two mitres one after the other: the way back shares its inner sheet with the way there.
    let network = run(&[
        fitting(Shape::Straight { length_m: 1.0 }),
        fitting(Shape::MitredElbow { angle_rad: FRAC_PI_2 }),
        fitting(Shape::MitredElbow { angle_rad: FRAC_PI_2 }),
        fitting(Shape::Straight { length_m: 1.0 }),
    ]);
    let refused = World::new(
        &network,
        &RobotSpec::incra1(),
        &ductloop_sim::Ground::uniform(0.7),
        &pose(0.5, 0.0, 0.0),
        ductloop_nav::rig::MountAngles::default(),
        HZ,
    );
    assert_eq!(refused.err(), Some(SimError::Walls(WallError::NoRoom { fitting: 0, other: 3 })));
}

#[test]
fn sharp_mitres_and_tight_throats_have_room() {
    let sharp = run(&[
        fitting(Shape::Straight { length_m: 1.0 }),
        fitting(Shape::MitredElbow { angle_rad: 2.0 * FRAC_PI_2 / 1.5 }),
        fitting(Shape::Straight { length_m: 0.5 }),
        fitting(Shape::RadiusElbow { angle_rad: -3.0, throat_radius_m: 0.05 }),
        fitting(Shape::Straight { length_m: 0.5 }),
    ]);
    let open = Network::from_run(&sharp.fittings, End::Open, End::Open).expect("the same duct, open");
    for network in [sharp, open, straight(2.0)] {
        assert_eq!(world(&network, &RobotSpec::incra1(), &pose(0.5, 0.0, 0.0)).collisions().count, 0);
    }
}
