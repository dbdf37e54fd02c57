//! What `World` promises: the same bits for the same inputs, and an error instead of nonsense.

mod common;

use common::{HZ, pose, straight, world};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, SimError, Truth, World};
use nalgebra::Vector3;

/// Drives a course of changing duties, into walls too, and notes every 10th state.
fn course() -> (Vec<Truth>, World) {
    let mut world = world(&straight(6.0), &RobotSpec::incra1(), &pose(1.0, 0.05, 0.1));
    let mut states = Vec::new();
    for tick in 0..6000 {
        let t = f64::from(tick) / f64::from(HZ);
        let duty = Sides { left: 0.4 + 0.2 * libm::sin(2.0 * t), right: 0.35 - 0.1 * libm::cos(3.0 * t) };
        world.step(duty).expect("finite");
        if tick % 10 == 0 {
            states.push(world.truth());
        }
    }
    (states, world)
}

#[test]
fn the_same_run_twice_gives_the_same_bits() {
    let (first, second) = (course(), course());
    for (a, b) in first.0.iter().zip(&second.0) {
        let bits = |t: &Truth| {
            let p = t.world_from_base;
            let q = p.rotation.coords;
            [p.translation.x, p.translation.y, p.translation.z, q.x, q.y, q.z, q.w, t.clearance_m, t.motor_current_a.left]
                .map(f64::to_bits)
        };
        assert_eq!(bits(a), bits(b));
    }
    assert_eq!(first.1.counts(), second.1.counts());
    assert_eq!(first.1.collisions(), second.1.collisions());
    assert!(first.1.collisions().count > 0, "the course must include a collision to be worth comparing");
}

#[test]
fn the_mount_goes_where_it_is_pointed() {
    let rest = MountAngles { pan_rad: -0.3, tilt_rad: 0.1 };
    let network = straight(2.0);
    let ground = Ground::uniform(0.7);
    let mut world = World::new(&network, &RobotSpec::incra1(), &ground, &pose(1.0, 0.0, 0.0), rest, HZ).expect("world");
    assert_eq!(world.mount(), rest);
    let aim = MountAngles { pan_rad: 0.2, tilt_rad: 0.1 };
    world.point_mount(aim);
    for _ in 0..HZ / 8 {
        world.step(Sides::default()).expect("finite");
    }
    // 0.125 s at 2 rad/s, in 150 additions: rounding.
    assert!((world.mount().pan_rad - -0.05).abs() < 1e-12);
    for _ in 0..HZ / 8 + 1 {
        world.step(Sides::default()).expect("finite");
    }
    assert_eq!(world.mount(), aim);
}

#[test]
fn what_cannot_be_is_refused() {
    let network = straight(2.0);
    let robot = RobotSpec::incra1();
    let new = |robot: &RobotSpec, ground: Ground, start, hz| {
        World::new(&network, robot, &ground, &start, MountAngles::default(), hz).err()
    };
    let middle = pose(1.0, 0.0, 0.0);
    let grip = || Ground::uniform(0.7);
    let mut heavy_wheels = robot.clone();
    heavy_wheels.wheel_mass_kg = 2.0;
    assert!(matches!(new(&heavy_wheels, grip(), middle, HZ), Some(SimError::Spec(e)) if e.field == "mass_kg"));
    assert_eq!(new(&robot, grip(), middle, 100), Some(SimError::Rate { hz: 100 }));
    for ground in [Ground::new(vec![]), Ground::uniform(-0.1), Ground::uniform(f64::NAN)] {
        assert_eq!(new(&robot, ground, middle, HZ), Some(SimError::NoFriction(0)));
    }
    assert!(matches!(new(&robot, grip(), pose(3.0, 0.0, 0.0), HZ), Some(SimError::StartOutside { .. })));
    assert!(matches!(new(&robot, grip(), pose(1.0, 0.2, 0.0), HZ), Some(SimError::StartBlocked { .. })));
    assert!(matches!(new(&robot, grip(), pose(0.05, 0.0, 0.0), HZ), Some(SimError::StartBlocked { .. })));
    assert_eq!(new(&robot, grip(), middle, HZ), None);
}

#[test]
fn a_state_that_is_not_finite_is_an_error() {
    let mut spoiled = world(&straight(2.0), &RobotSpec::incra1(), &pose(1.0, 0.0, 0.0));
    spoiled.step(Sides::default()).expect("finite");
    assert_eq!(spoiled.step(Sides { left: f64::NAN, right: 0.0 }), Err(SimError::NonFinite { tick: 2 }));
    spoiled.set_gravity(Vector3::new(0.0, f64::NAN, -9.8));
    assert_eq!(spoiled.step(Sides::default()), Err(SimError::NonFinite { tick: 2 }));
}
