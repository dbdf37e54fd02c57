//! Why the wheels are balls on the floor: the same robot on cylinders turns and drives otherwise than theory says.

mod common;

use common::{G, GRIP, HZ, pose, with_aspect};
use ductloop_sim::RobotSpec;
use ductloop_sim::chassis::{Chassis, FLOOR, TREAD, groups};
use ductloop_sim::settings;
use nalgebra::Vector3;
use rapier3d::math::Vector;
use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder, PhysicsWorld, SharedShape};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Tread {
    Ball,
    Cylinder,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    HalfSpace,
    Box,
}

/// The robot alone, with its wheels' speeds held by torques.
struct Bare {
    physics: PhysicsWorld,
    chassis: Chassis,
    integral: [f64; 2],
}

impl Bare {
    fn new(robot: &RobotSpec, tread: Tread, floor: Floor) -> Self {
        let mut physics = PhysicsWorld { gravity: Vector::new(0.0, 0.0, -G), ..PhysicsWorld::default() };
        physics.integration_parameters = settings::parameters(HZ);
        let shape = match floor {
            Floor::HalfSpace => SharedShape::halfspace(Vector::Z),
            Floor::Box => SharedShape::cuboid(30.0, 30.0, 0.5),
        };
        let depth = if floor == Floor::Box { -0.5 } else { 0.0 };
        physics.colliders.insert(
            ColliderBuilder::new(shape)
                .translation(Vector::new(0.0, 0.0, depth))
                .friction(1.0)
                .friction_combine_rule(CoefficientCombineRule::Multiply)
                .collision_groups(groups(FLOOR, TREAD)),
        );
        let start = pose(0.0, 0.0, 0.0);
        let PhysicsWorld { bodies, colliders, impulse_joints, .. } = &mut physics;
        let chassis = Chassis::build(robot, &start, GRIP, bodies, colliders, impulse_joints);
        if tread == Tread::Cylinder {
            for ball in chassis.treads {
                // A wheel's axle is its y, as a cylinder's.
                colliders[ball].set_shape(SharedShape::cylinder(robot.wheel_width_m / 2.0, robot.wheel_radius_m));
            }
        }
        Self { physics, chassis, integral: [0.0; 2] }
    }

    /// One tick with wheel speeds held by PI, the same torque on both wheels of a side.
    fn step(&mut self, wheel_rad_s: [f64; 2]) {
        let Self { physics, chassis, integral } = self;
        let [fl, rl, fr, rr] = chassis.wheel_speeds(&physics.bodies);
        let axle = chassis.axle(&physics.bodies);
        let mut reaction = 0.0;
        for (side, actual) in [(fl + rl) / 2.0, (fr + rr) / 2.0].into_iter().enumerate() {
            let error = wheel_rad_s[side] - actual;
            integral[side] += error / f64::from(HZ);
            let torque = 0.05 * error + 2.0 * integral[side];
            // Wheels of a side are linked: what is between their speeds is taken away.
            let speeds = if side == 0 { [fl, rl] } else { [fr, rr] };
            for (i, speed) in speeds.into_iter().enumerate() {
                let torque = torque + 0.05 * (actual - speed);
                reaction += torque;
                let wheel = &mut physics.bodies[chassis.wheels[2 * side + i]];
                wheel.reset_torques(false);
                wheel.add_torque(axle * torque, false);
            }
        }
        let body = &mut physics.bodies[chassis.body];
        body.reset_torques(false);
        body.add_torque(axle * -reaction, false);
        physics.step();
    }

    /// chi of a turn on the spot, over 10 s after 3 s.
    fn chi(&mut self, robot: &RobotSpec) -> f64 {
        let (mut turned, mut ideal) = (0.0, 0.0);
        for tick in 0..13 * HZ {
            self.step([-2.0, 2.0]);
            if tick >= 3 * HZ {
                let [fl, rl, fr, rr] = self.chassis.wheel_speeds(&self.physics.bodies);
                turned += self.physics.bodies[self.chassis.body].angvel().z;
                ideal += robot.wheel_radius_m * ((fr + rr) - (fl + rl)) / 2.0 / robot.track_m;
            }
        }
        ideal / turned
    }

    /// Sideways drift over 10 m, in m.
    fn drift(&mut self) -> f64 {
        for _ in 0..HZ {
            self.step([7.5, 7.5]);
        }
        let from = self.chassis.world_from_base(&self.physics.bodies);
        let ticks = (10.0 / 0.3 * f64::from(HZ)) as u32;
        for _ in 0..ticks {
            self.step([7.5, 7.5]);
        }
        let to = self.chassis.world_from_base(&self.physics.bodies);
        (from.inverse() * to).translation.vector.dot(&Vector3::y())
    }
}

#[test]
fn balls_turn_as_point_contacts_do_and_cylinders_do_not() {
    for ratio in [0.5, 0.16 / 0.19, 1.2] {
        let robot = with_aspect(ratio);
        let [ball, cylinder] = [Tread::Ball, Tread::Cylinder].map(|tread| Bare::new(&robot, tread, Floor::HalfSpace).chi(&robot));
        let theory = robot.chi();
        // A cylinder that touched on its outer edge only.
        let outer = robot.track_m + robot.wheel_width_m;
        let edge = (outer * outer + robot.wheelbase_m * robot.wheelbase_m) / (outer * robot.track_m);
        println!(
            "chi at L/W {ratio:.3}: balls {ball:.4}, cylinders {cylinder:.4}, closed form {theory:.4}; cylinders on their outer edges \\
             would have {edge:.4}"
        );
        assert!((ball / theory - 1.0).abs() < 3e-3);
        assert!((cylinder / theory - 1.0).abs() > 0.01, "cylinders are as good: say so in docs/physics.md");
    }
}

#[test]
fn balls_drive_straight_on_any_floor() {
    let robot = RobotSpec::incra1();
    for floor in [Floor::HalfSpace, Floor::Box] {
        for tread in [Tread::Ball, Tread::Cylinder] {
            let drift = Bare::new(&robot, tread, floor).drift();
            println!("drift of {tread:?}s on a {floor:?}: {:.4} mm in 10 m", drift * 1e3);
            if tread == Tread::Ball {
                assert!(drift.abs() < 1e-3);
            }
        }
    }
}
