//! The robot as a rigid body: what its motors do to the chassis, against Newton's laws.

mod common;

use common::{HZ, fitting, pose};
use ductloop_duct::Transform;
use ductloop_duct::fitting::Shape;
use ductloop_duct::network::{End, Network};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};
use nalgebra::{Translation3, Vector3};

const G: f64 = 9.806_65;
const DT: f64 = 1.0 / HZ as f64;

/// In a room of 8 x 8 x 3 m.
fn in_a_room(grip: f64, start: &Transform) -> World {
    let mut room = fitting(Shape::Straight { length_m: 8.0 });
    (room.width_m, room.height_m) = (8.0, 3.0);
    let network = Network::from_run(&[room], End::Cap, End::Cap).expect("a room");
    World::new(&network, &RobotSpec::incra1(), &Ground::uniform(grip), start, MountAngles::default(), HZ).expect("world")
}

/// INCRA I's moments of inertia about its centre of mass, which is amidships: (pitch, yaw) of the whole robot and of a wheel
/// about its own axle, in kg m2. Bodies are a uniform box and four discs, whose inertia across the axle is a disc's along it.
fn inertia(robot: &RobotSpec) -> (f64, f64, f64) {
    let [length, width, height] = robot.chassis_m;
    let [_, com_z] = robot.centre_of_mass_m;
    let chassis_kg = robot.mass_kg - 4.0 * robot.wheel_mass_kg;
    let wheel = robot.wheel_mass_kg * robot.wheel_radius_m * robot.wheel_radius_m / 2.0;
    let (below, ahead, beside) = (com_z - robot.wheel_radius_m, robot.wheelbase_m / 2.0, robot.track_m / 2.0);
    // The chassis' centre is above the robot's as the wheels' are below it.
    let above = 4.0 * robot.wheel_mass_kg * below / chassis_kg;
    let pitch = chassis_kg * ((length * length + height * height) / 12.0 + above * above)
        + 4.0 * (wheel + robot.wheel_mass_kg * (below * below + ahead * ahead));
    let yaw = chassis_kg * (length * length + width * width) / 12.0
        + 4.0 * (wheel + robot.wheel_mass_kg * (ahead * ahead + beside * beside));
    (pitch, yaw, wheel)
}

#[test]
fn wheels_that_spin_up_in_the_air_turn_the_chassis_the_other_way() {
    let robot = RobotSpec::incra1();
    let start = Transform::from_parts(Translation3::new(4.0, 0.0, 1.0), pose(0.0, 0.0, 0.0).rotation);
    let mut world = in_a_room(0.7, &start);
    world.set_gravity(Vector3::zeros());
    let centre = |world: &World| {
        let [x, z] = robot.centre_of_mass_m;
        world.truth().world_from_base * nalgebra::Point3::new(x, 0.0, z)
    };
    let from = centre(&world);
    let mut wheel_rad = 0.0;
    for _ in 0..HZ / 2 {
        world.step(Sides { left: 1.0, right: 1.0 }).expect("finite");
        let speed = world.truth().wheel_speed_rad_s;
        wheel_rad += DT * (speed.left + speed.right) / 2.0;
    }
    let ahead = world.truth().world_from_base.rotation * Vector3::x();
    // Positive with the nose down, as the wheels turn.
    let pitch = libm::atan2(-ahead.z, ahead.x);
    // Angular momentum stays zero: I pitch' + 4 I_w wheel' = 0, wheels relative to the chassis.
    let (whole, _, wheel) = inertia(&robot);
    let expected = -4.0 * wheel / whole * wheel_rad;
    println!("pitch {pitch:.6} rad, closed form {expected:.6}; centre moved {:.2e} m", (centre(&world) - from).norm());
    assert!(expected < -0.1, "the wheels must have turned: {wheel_rad} rad");
    // The sum over ticks is off by half a tick of the last speed, 0.08 %. Measured 0.04 %.
    assert!((pitch / expected - 1.0).abs() < 2e-3);
    // Nothing pushes from outside: rounding, measured 2e-11 m.
    assert!((centre(&world) - from).norm() < 1e-9);
}

#[test]
fn slipping_wheels_spin_the_robot_up_as_fast_as_its_yaw_inertia_lets_them() {
    // Nearly ice: the wheels spin in opposite directions from the first ticks, and each drags with its whole friction.
    const SLIPPERY: f64 = 0.02;
    let robot = RobotSpec::incra1();
    let mut world = in_a_room(SLIPPERY, &pose(4.0, 0.0, 0.0));
    for _ in 0..HZ / 4 {
        world.step(Sides::default()).expect("finite");
    }
    let (_, yaw_inertia, _) = inertia(&robot);
    let (ahead, beside) = (robot.wheelbase_m / 2.0, robot.track_m / 2.0);
    let mut expected = 0.0;
    for _ in 0..HZ / 2 {
        world.step(Sides { left: -0.5, right: 0.5 }).expect("finite");
        let wheels = world.truth().wheel_speed_rad_s;
        // Slip of a right wheel's lowest point: backward, and sideways because the robot turns about its middle.
        let back = robot.wheel_radius_m * (wheels.right - wheels.left) / 2.0 - expected * beside;
        let side = expected * ahead;
        let lever = (back * beside - side * ahead) / (back * back + side * side).sqrt();
        expected += DT * SLIPPERY * robot.mass_kg * G * lever / yaw_inertia;
    }
    let actual = world.truth().yaw_rate_rad_s;
    println!("yaw rate {actual:.5} rad/s, closed form {expected:.5}");
    assert!(expected > 0.5, "it must have turned");
    // Half a tick of the 600 is 0.1 %; the wheels' loads differ by what sideways drag does at the height of the centre of mass.
    // Measured 0.02 %.
    assert!((actual / expected - 1.0).abs() < 5e-3);
}
