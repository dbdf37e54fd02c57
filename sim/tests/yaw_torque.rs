//! What it takes to turn on the spot: the axle torque of a side, from the current of its motor.

mod common;

use common::{G, HZ, SpeedLoop, ideal, pose, room};
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, World};

#[test]
fn turning_takes_the_torque_of_four_sliding_contacts() {
    for (aspect, grip, mass_kg) in
        [(0.5, 0.7, 5.0), (0.16 / 0.19, 0.3, 5.0), (0.16 / 0.19, 0.7, 5.0), (0.16 / 0.19, 0.7, 10.0), (1.2, 0.9, 5.0)]
    {
        let mut robot = ideal();
        robot.track_m = robot.wheelbase_m / aspect;
        robot.chassis_m[1] = robot.chassis_m[1].min(robot.track_m - robot.wheel_width_m);
        robot.mass_kg = mass_kg;
        let ground = Ground::uniform(grip);
        let mut world = World::new(&room(), &robot, &ground, &pose(4.0, 0.0, 0.0), MountAngles::default(), HZ).expect("world");
        let mut hold = SpeedLoop::new();
        let wheels = Sides { left: -2.0, right: 2.0 };
        hold.hold(&mut world, wheels, 3.0);
        let mut current = Sides::default();
        for _ in 0..HZ {
            hold.step(&mut world, wheels);
            current.left += world.truth().motor_current_a.left / f64::from(HZ);
            current.right += world.truth().motor_current_a.right / f64::from(HZ);
        }
        // Nothing is lost in the gear: the axle torque is n k i. Both sides' forces, a track apart, balance the yaw resistance.
        let per_ampere = robot.drive.gear_ratio * robot.drive.motor_constant;
        let axle_n_m = per_ampere * (current.right - current.left) / 2.0;
        let yaw_n_m = axle_n_m / robot.wheel_radius_m * robot.track_m;
        let (l, w) = (robot.wheelbase_m, robot.track_m);
        let expected = grip * mass_kg * G * l * w / (2.0 * (l * l + w * w).sqrt());
        println!("yaw torque at L/W {aspect:.3}, mu {grip}, {mass_kg} kg: {yaw_n_m:.5} N m, closed form {expected:.5}");
        // Measured 0.04 to 0.07 %: the wheels roll on a radius that much smaller, sunk in.
        assert!((yaw_n_m / expected - 1.0).abs() < 5e-3);
        // Left and right alike.
        assert!((current.left + current.right).abs() < 1e-3 * current.right);
    }
}
