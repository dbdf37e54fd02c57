//! What the tests share: a straight duct, and a speed loop that the robot itself does not have.
#![allow(dead_code, reason = "no test uses all of it")]

use ductloop_duct::Transform;
use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{End, Network};
use ductloop_nav::angle::rotation_about_z;
use ductloop_nav::messages::Sides;
use ductloop_nav::rig::MountAngles;
use ductloop_sim::{Ground, RobotSpec, World};
use nalgebra::Vector3;

/// The default physics rate.
pub(crate) const HZ: u32 = 1200;

/// A fitting of an 0.5 x 0.3 m duct.
pub(crate) fn fitting(shape: Shape) -> Fitting {
    Fitting { shape, width_m: 0.5, height_m: 0.3, surface: SurfaceId(0) }
}

/// A straight duct, closed at both ends.
pub(crate) fn straight(length_m: f64) -> Network {
    run(&[fitting(Shape::Straight { length_m })])
}

/// Fittings one after the other, closed at both ends.
pub(crate) fn run(fittings: &[Fitting]) -> Network {
    Network::from_run(fittings, End::Cap, End::Cap).expect("the test's duct")
}

/// A room wide enough to drive circles in.
pub(crate) fn room() -> Network {
    let mut room = fitting(Shape::Straight { length_m: 8.0 });
    room.width_m = 8.0;
    run(&[room])
}

/// INCRA I without friction in gear and bearings, gear loss and rolling resistance.
pub(crate) fn ideal() -> RobotSpec {
    let mut robot = RobotSpec::incra1();
    robot.rolling_resistance = 0.0;
    robot.drive.coulomb_friction_n_m = 0.0;
    robot.drive.gear_efficiency = 1.0;
    robot
}

/// INCRA I with another ratio of wheelbase to track.
pub(crate) fn with_aspect(ratio: f64) -> RobotSpec {
    let mut robot = RobotSpec::incra1();
    robot.track_m = robot.wheelbase_m / ratio;
    robot.chassis_m[1] = robot.chassis_m[1].min(robot.track_m - robot.wheel_width_m);
    robot
}

/// Gravity of a floor that rises toward +x by this angle.
pub(crate) fn slope(angle_rad: f64) -> Vector3<f64> {
    Vector3::new(-G * libm::sin(angle_rad), 0.0, -G * libm::cos(angle_rad))
}

/// Standard gravity, in m/s2.
pub(crate) const G: f64 = 9.806_65;

/// A pose on the floor.
pub(crate) fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Transform {
    Transform::from_parts(nalgebra::Translation3::new(x_m, y_m, 0.0), rotation_about_z(heading_rad).into())
}

/// Friction of that floor.
pub(crate) const GRIP: f64 = 0.7;

/// A robot on a floor of [`GRIP`].
pub(crate) fn world(network: &Network, robot: &RobotSpec, start: &Transform) -> World {
    World::new(network, robot, &Ground::uniform(GRIP), start, MountAngles::default(), HZ).expect("the test's world")
}

/// Holds wheel speeds by PI on the true ones.
pub(crate) struct SpeedLoop {
    integral: Sides,
}

impl SpeedLoop {
    /// With nothing integrated yet.
    pub(crate) fn new() -> Self {
        Self { integral: Sides::default() }
    }

    /// One tick.
    pub(crate) fn step(&mut self, world: &mut World, wheel_rad_s: Sides) {
        // Duty for 1 rad/s of INCRA I unloaded is 0.032; the integral's time constant is 1 / 40 s.
        const GAIN: f64 = 0.1;
        const RATE: f64 = 40.0 / HZ as f64;
        let actual = world.truth().wheel_speed_rad_s;
        let error = Sides { left: wheel_rad_s.left - actual.left, right: wheel_rad_s.right - actual.right };
        self.integral.left += GAIN * RATE * error.left;
        self.integral.right += GAIN * RATE * error.right;
        let duty = Sides { left: GAIN * error.left + self.integral.left, right: GAIN * error.right + self.integral.right };
        world.step(duty).expect("finite");
    }

    /// Many ticks.
    pub(crate) fn hold(&mut self, world: &mut World, wheel_rad_s: Sides, seconds: f64) {
        for _ in 0..(seconds * f64::from(HZ)).round() as usize {
            self.step(world, wheel_rad_s);
        }
    }
}
