//! The robot as Rapier bodies: a chassis and four wheels on revolute joints.
//!
//! The chassis body's own frame *is* the base frame, so its pose needs no conversion. A wheel carries two colliders: a ball
//! that touches floors only (a point contact, for which skid steering has a closed form) and a cylinder as thin as the wheel
//! that touches walls and solids only.

use ductloop_duct::Transform;
use nalgebra::Vector3;
use rapier3d::math::Vector;
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderHandle, ColliderSet, Group, ImpulseJointSet, InteractionGroups,
    InteractionTestMode, MassProperties, RigidBodyBuilder, RigidBodyHandle, RigidBodySet,
};

use crate::axle;
use crate::convert;
use crate::drive::wheel_spin_inertia;
use crate::outline::{self, Part};
use crate::spec::RobotSpec;

/// Floors.
pub const FLOOR: Group = Group::GROUP_1;
/// Walls, ceilings and solids.
pub const WALL: Group = Group::GROUP_2;
/// The balls on which the robot drives.
pub const TREAD: Group = Group::GROUP_3;
/// The wheels as walls meet them.
pub const FLANK: Group = Group::GROUP_4;
/// Chassis and mast.
pub const BODY: Group = Group::GROUP_5;

/// What belongs to `members` and meets `others`.
pub const fn groups(members: Group, others: Group) -> InteractionGroups {
    InteractionGroups::new(members, others, InteractionTestMode::And)
}

/// Handles of the robot's bodies and colliders. Wheels are in the order of [`outline::wheels`].
#[derive(Clone, Debug)]
pub struct Chassis {
    /// The chassis; its frame is the base frame.
    pub body: RigidBodyHandle,
    /// The wheels.
    pub wheels: [RigidBodyHandle; 4],
    /// The wheels' balls.
    pub treads: [ColliderHandle; 4],
    /// All that may collide with something: chassis, mast, the wheels' cylinders.
    pub shell: Vec<ColliderHandle>,
}

/// Mass properties of the chassis without its wheels, so that the whole robot has the mass and centre of mass of its spec.
/// Its inertia is that of a uniform box of the chassis' size about that centre (an assumption).
pub fn chassis_mass(robot: &RobotSpec) -> MassProperties {
    let mass_kg = robot.mass_kg - 4.0 * robot.wheel_mass_kg;
    let [x_m, z_m] = robot.centre_of_mass_m;
    let centre = Vector::new(
        robot.mass_kg * x_m / mass_kg,
        0.0,
        (robot.mass_kg * z_m - 4.0 * robot.wheel_mass_kg * robot.wheel_radius_m) / mass_kg,
    );
    let [l, w, h] = robot.chassis_m;
    MassProperties::new(centre, mass_kg, Vector::new(w * w + h * h, l * l + h * h, l * l + w * w) * (mass_kg / 12.0))
}

/// Mass properties of a wheel: the spin inertia of a uniform disc, about every axis.
///
/// About the axes across, a disc has half of that. But Rapier's friction leans toward the direction in which the wheel alone is
/// harder to move: its sliding friction points along (m_x s_x, m_y s_y), s the slip and m the wheel's apparent masses at the
/// contact, 1 / (1/m + r^2/I). A disc's are m/3 ahead and m/5 sideways, and chi - 1 comes out 32 % low; equal inertias make
/// the friction isotropic. The yaw inertia of the whole robot changes by 0.5 %.
pub fn wheel_mass(robot: &RobotSpec) -> MassProperties {
    MassProperties::new(Vector::ZERO, robot.wheel_mass_kg, Vector::splat(wheel_spin_inertia(robot)))
}

impl Chassis {
    /// Puts the robot at rest at `world_from_base`. Its wheels grip with a friction coefficient of `friction`.
    pub fn build(
        robot: &RobotSpec,
        world_from_base: &Transform,
        friction: f64,
        bodies: &mut RigidBodySet,
        colliders: &mut ColliderSet,
        joints: &mut ImpulseJointSet,
    ) -> Self {
        let rigid = |pose: &Transform, mass: MassProperties| {
            RigidBodyBuilder::dynamic().pose(convert::pose(pose)).additional_mass_properties(mass).can_sleep(false)
        };
        let body = bodies.insert(rigid(world_from_base, chassis_mass(robot)));
        // Without density: the bodies' masses are given as a whole.
        let shell_of = |part: &Part, members: Group, others: Group| {
            ColliderBuilder::new(part.shape.clone())
                .density(0.0)
                .friction(robot.body_friction)
                .friction_combine_rule(CoefficientCombineRule::Multiply)
                .collision_groups(groups(members, others))
        };
        let mut shell = Vec::with_capacity(6);
        for part in outline::body(robot) {
            let collider = shell_of(&part, BODY, FLOOR | WALL).position(convert::pose(&part.base_from_part));
            shell.push(colliders.insert_with_parent(collider, body, bodies));
        }
        let wheels = outline::wheels(robot).map(|part| {
            let wheel = bodies.insert(rigid(&(world_from_base * part.base_from_part), wheel_mass(robot)));
            shell.push(colliders.insert_with_parent(shell_of(&part, FLANK, WALL), wheel, bodies));
            joints.insert(body, wheel, axle::joint(robot, &part.base_from_part.translation.vector), true);
            wheel
        });
        let treads = wheels.map(|wheel| {
            let ball = ColliderBuilder::ball(robot.wheel_radius_m)
                .density(0.0)
                .friction(friction)
                .friction_combine_rule(CoefficientCombineRule::Multiply)
                .collision_groups(groups(TREAD, FLOOR));
            colliders.insert_with_parent(ball, wheel, bodies)
        });
        Self { body, wheels, treads, shell }
    }

    /// Pose of the base.
    pub fn world_from_base(&self, bodies: &RigidBodySet) -> Transform {
        convert::from_pose(bodies[self.body].position())
    }

    /// Direction of the axles in the world, to the left: a wheel that rolls forward turns about it by the right-hand rule.
    pub fn axle(&self, bodies: &RigidBodySet) -> Vector {
        bodies[self.body].rotation() * Vector::Y
    }

    /// Speeds of the wheels relative to the chassis, forward positive, in rad/s.
    pub fn wheel_speeds(&self, bodies: &RigidBodySet) -> [f64; 4] {
        let axle = self.axle(bodies);
        let chassis = bodies[self.body].angvel();
        self.wheels.map(|wheel| (bodies[wheel].angvel() - chassis).dot(axle))
    }

    /// Velocity of the base, in the world, in m/s.
    pub fn velocity(&self, bodies: &RigidBodySet) -> Vector3<f64> {
        let body = &bodies[self.body];
        convert::from_vector(body.velocity_at_point(body.translation()))
    }
}
