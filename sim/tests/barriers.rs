//! What stands in fittings stops the robot: a shut damper, turning vanes, a grille's bars. What is open does not.

mod common;

use std::f64::consts::FRAC_PI_2;

use common::{HZ, fitting, pose, run, world};
use ductloop_duct::fitting::port::PortName;
use ductloop_duct::fitting::{Blade, GrilleSide, Hand, Shape};
use ductloop_duct::network::{Join, Network, Piece};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Collisions, Ground, RobotSpec, Truth, World};
use nalgebra::Point3;

/// Drives a robot ahead for so long, from (x, y) and a heading, in a straight of 1 m, a fitting, and a straight.
fn after(shape: Shape, [x_m, y_m, heading]: [f64; 3], seconds: u32) -> (Truth, Collisions) {
    let straight = fitting(Shape::Straight { length_m: 1.0 });
    let mut world = world(&run(&[straight, fitting(shape), straight]), &RobotSpec::incra1(), &pose(x_m, y_m, heading));
    for _ in 0..seconds * HZ {
        world.step(Sides { left: 0.25, right: 0.25 }).expect("finite");
    }
    (world.truth(), world.collisions())
}

#[test]
fn a_shut_damper_and_turning_vanes_stop_it() {
    let (truth, collisions) = after(Shape::Damper { length_m: 0.4, blade: Blade::Shut }, [0.4, 0.0, 0.0], 5);
    println!("{truth:?} {collisions:?}");
    // The curtain stands at x = 1.2 m, the nose 0.16 m before the base.
    assert!(truth.world_from_base.translation.x < 1.2 - 0.16 && truth.world_from_base.translation.x > 1.0, "{truth:?}");
    assert!(collisions.count > 0 && truth.clearance_m < 1e-3);

    let (truth, collisions) = after(Shape::VanedElbow { angle_rad: FRAC_PI_2 }, [0.4, 0.0, 0.0], 5);
    println!("{truth:?} {collisions:?}");
    // The mitre goes from (1, 0.25) to (1.5, -0.25); the vanes reach out from it.
    assert!(collisions.count > 0 && truth.clearance_m < 1e-3);
    assert!(truth.world_from_base.translation.x < 1.25 - 0.16 && truth.speed_m_s.abs() < 0.01, "{truth:?}");
}

#[test]
fn every_fitting_has_room_for_its_walls() {
    let junctions = [0.25, 0.35, 0.5, 0.8].into_iter().flat_map(|branch_width_m| {
        [Hand::Left, Hand::Right].into_iter().flat_map(move |hand| {
            [
                Shape::Tee { hand, branch_width_m },
                Shape::SideBranch { hand, branch_width_m, shoe_m: 0.15 },
                Shape::BullheadTee { branch_width_m },
                Shape::Cross { branch_width_m },
                Shape::Wye { half_angle_rad: 0.524, branch_width_m },
                Shape::Wye { half_angle_rad: 1.047, branch_width_m },
            ]
        })
    });
    let others = [
        Shape::Offset { length_m: 1.2, aside_m: -0.4 },
        Shape::VanedElbow { angle_rad: -1.0 },
        Shape::Drop { length_m: 1.0, hole_length_m: 1.0, hole_width_m: 0.5, depth_m: 0.05 },
        Shape::Drop { length_m: 1.0, hole_length_m: 0.1, hole_width_m: 0.02, depth_m: 2.0 },
        Shape::Grille { length_m: 0.8, side: GrilleSide::Ceiling, opening_length_m: 0.8, opening_height_m: 0.5 },
    ];
    for shape in junctions.chain(others) {
        // The fitting, with a straight of 1 m at each of its ports.
        let middle = fitting(shape);
        let mut pieces = vec![Piece { fitting: middle, name: "middle".to_owned() }];
        let mut joins = Vec::new();
        for port in middle.ports() {
            let mut straight = fitting(Shape::Straight { length_m: 1.0 });
            (straight.width_m, straight.height_m) = (port.width_m, port.height_m);
            joins.push(Join { a: (0, port.name), b: (pieces.len(), PortName::In) });
            pieces.push(Piece { fitting: straight, name: port.name.to_string() });
        }
        let network = Network::assemble(&pieces, &joins, &[]).unwrap_or_else(|error| panic!("{shape:?}: {error}"));
        let made =
            World::new(&network, &RobotSpec::incra1(), &Ground::uniform(0.7), &pose(-0.5, 0.0, 0.0), MountAngles::default(), HZ);
        assert!(made.is_ok(), "{shape:?}: {:?}", made.err());
    }
}

#[test]
fn an_open_damper_lets_it_pass() {
    let (truth, collisions) = after(Shape::Damper { length_m: 0.4, blade: Blade::Open }, [0.4, 0.0, 0.0], 5);
    assert!(truth.world_from_base.translation.x > 1.5, "{truth:?}");
    assert_eq!(collisions.count, 0);
}

#[test]
fn bars_of_a_grille_hold_it() {
    for (side, sign) in [(GrilleSide::Left, 1.0), (GrilleSide::Right, -1.0)] {
        // The opening is as high as the duct: there is nothing but bars, 12 mm deep.
        let shape = Shape::Grille { length_m: 0.8, side, opening_length_m: 0.7, opening_height_m: 0.3 };
        let (truth, collisions) = after(shape, [1.4, 0.0, sign * FRAC_PI_2], 3);
        let nose = truth.world_from_base * Point3::new(0.16, 0.0, 0.05);
        println!("nose at {nose}, {collisions:?}");
        assert!(collisions.count > 0);
        assert!(nose.y * sign < 0.25 - 0.012 + 1e-3 && nose.y * sign > 0.2, "{nose}");
    }
}
