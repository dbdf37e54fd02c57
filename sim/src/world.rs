//! The robot in its duct, tick by tick: the one type that users of this crate need.

use ductloop_duct::Transform;
use ductloop_duct::cell::{CellId, FaceKind};
use ductloop_duct::centreline::Centreline;
use ductloop_duct::network::Network;
use ductloop_nav::messages::{Counts, Sides, Tick};
use ductloop_nav::rig::MountAngles;
use nalgebra::{Point3, Vector3};
use rapier3d::math::Vector;
use rapier3d::prelude::{ColliderHandle, PhysicsWorld, RigidBodyHandle};

use crate::chassis::Chassis;
use crate::clearance::Outline;
use crate::colliders;
use crate::collision::{CollisionCounter, Collisions, Motion, touch};
use crate::contact_rules::ContactRules;
use crate::convert;
use crate::disturbance::{Disturbance, PushFrame};
use crate::drive::{Drive, GRAVITY_M_S2};
use crate::encoder;
use crate::floors::{Near, Wheel};
use crate::ground::Ground;
use crate::mount::{Gearing, PanTilt};
use crate::seams::SeamFilter;
use crate::settings;
use crate::spec::RobotSpec;
use crate::spec_check::SpecError;
use crate::truth::{self, Truth};
use crate::walls::{WallError, Walls};

/// Rates in Hz, to whose ends `tests/turning.rs` goes.
const PHYSICS_HZ: std::ops::RangeInclusive<u32> = 300..=4800;

/// Why a world cannot be made, or cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimError {
    /// A number of the robot cannot be.
    #[error("the robot cannot be built: {0}")]
    Spec(#[from] SpecError),
    /// The network cannot be driven in.
    #[error(transparent)]
    Walls(#[from] WallError),
    /// The physics rate is out of range.
    #[error("physics at {hz} Hz; it must be from {} to {} Hz", PHYSICS_HZ.start(), PHYSICS_HZ.end())]
    Rate {
        /// The rate asked for.
        hz: u32,
    },
    /// A floor has a surface whose grip was not given.
    #[error("surface {0} has no friction coefficient; each floor's needs one, zero or more")]
    NoFriction(u16),
    /// The robot does not start inside the ducts.
    #[error("the robot starts at ({x_m:.3}, {y_m:.3}), outside the ducts")]
    StartOutside {
        /// Where, in the world.
        x_m: f64,
        /// Where, in the world.
        y_m: f64,
    },
    /// The robot starts where something stands.
    #[error("the robot starts at ({x_m:.3}, {y_m:.3}), where it touches a wall, the ceiling or an object")]
    StartBlocked {
        /// Where, in the world.
        x_m: f64,
        /// Where, in the world.
        y_m: f64,
    },
    /// The state is not finite any more, or a motor's duty was not.
    #[error("the state of the physics stopped being finite at tick {tick}")]
    NonFinite {
        /// The tick that could not be made.
        tick: Tick,
    },
}

/// A robot in a duct network.
pub struct World {
    network: Network,
    walls: Walls,
    rules: ContactRules,
    outline: Outline,
    /// What truth is measured against.
    path: Centreline,
    robot: RobotSpec,
    ground: Ground,
    physics: PhysicsWorld,
    chassis: Chassis,
    /// Left, right.
    drives: [Drive; 2],
    mount: PanTilt,
    counter: CollisionCounter,
    tick: Tick,
    cell: CellId,
    segment: usize,
    /// How far along the path the base has come so far, in metres.
    farthest_m: f64,
    /// Colliders of the floors' planes.
    floors: Vec<ColliderHandle>,
    /// Floors near the robot's cell, where the network has several.
    near: Near,
    wheel_cells: [CellId; 4],
    /// Friction of the floor under each wheel; its ball collider has this times the disturbance's share.
    grip: [f64; 4],
    disturbance: Disturbance,
    /// Whether the floors differ, so that grip must be looked up.
    floors_differ: bool,
}

impl World {
    /// Puts a robot at rest at `start`, its base's pose in the world, with its mount at `rest`. A tick is 1 / `physics_hz` s.
    ///
    /// # Errors
    /// If the robot, the network, the rate or the start cannot be.
    pub fn new(
        network: &Network,
        robot: &RobotSpec,
        ground: &Ground,
        start: &Transform,
        rest: MountAngles,
        physics_hz: u32,
    ) -> Result<Self, SimError> {
        robot.validate()?;
        if !PHYSICS_HZ.contains(&physics_hz) {
            return Err(SimError::Rate { hz: physics_hz });
        }
        let floors_differ = check_grip(network, ground)?;
        let walls = Walls::new(network)?;
        let (x_m, y_m) = (start.translation.x, start.translation.y);
        let cell = network.cell_at(&within(robot, start), 0).ok_or(SimError::StartOutside { x_m, y_m })?;
        let outline = Outline::new(robot);
        if outline.clearance_m(network, &walls, cell, start) <= 0.0 {
            return Err(SimError::StartBlocked { x_m, y_m });
        }

        let mut physics = PhysicsWorld { gravity: Vector::new(0.0, 0.0, -GRAVITY_M_S2), ..PhysicsWorld::default() };
        physics.integration_parameters = settings::parameters(physics_hz);
        let floors = colliders::insert(&walls, &mut physics.colliders);
        let grip = floor_grip(network, ground, cell).ok_or(SimError::NoFriction(0))?;
        let chassis =
            Chassis::build(robot, start, grip, &mut physics.bodies, &mut physics.colliders, &mut physics.impulse_joints);
        let drive = Drive::new(robot, physics_hz);
        let rules = ContactRules {
            seams: SeamFilter::new(network, &walls),
            treads: chassis.treads.iter().map(|tread| (*tread, Vec::new())).collect(),
            radius_m: robot.wheel_radius_m,
        };
        let mut world = Self {
            network: network.clone(),
            rules,
            path: network.centreline.clone(),
            walls,
            outline,
            robot: robot.clone(),
            ground: ground.clone(),
            physics,
            chassis,
            drives: [drive.clone(), drive],
            mount: PanTilt::new(rest, robot.mount_rate_rad_s),
            counter: CollisionCounter::new(physics_hz),
            tick: 0,
            cell,
            segment: network.centreline.segment_of(network.cells[cell].fitting),
            floors,
            near: Near::default(),
            farthest_m: 0.0,
            wheel_cells: [cell; 4],
            grip: [grip; 4],
            disturbance: Disturbance::default(),
            floors_differ,
        };
        world.look_around();
        Ok(world)
    }

    /// From now on truth is measured against this path, such as that of a route, instead of the network's own. The robot is taken to
    /// be on the first pass through the fitting that it is in.
    pub fn follow(&mut self, path: &Centreline) {
        self.segment = path.segment_of(self.network.cells[self.cell].fitting);
        self.path = path.clone();
    }

    /// Sets gravity, in the world frame, in m/s2: a duct that slopes is a level one with gravity leaning.
    pub fn set_gravity(&mut self, gravity_m_s2: Vector3<f64>) {
        self.physics.gravity = convert::vector(&gravity_m_s2);
    }

    /// From now on, until it is called again, this disturbs the robot. It takes the place of all that did before.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        if disturbance == self.disturbance {
            return;
        }
        self.disturbance = disturbance;
        for wheel in 0..4 {
            self.set_friction(wheel);
        }
        let Sides { left, right } = self.disturbance.motor_strength;
        self.drives[0].set_strength(left);
        self.drives[1].set_strength(right);
        self.physics.bodies[self.chassis.body].reset_forces(false);
    }

    /// What disturbs the robot.
    pub fn disturbance(&self) -> &Disturbance {
        &self.disturbance
    }

    /// Lets one tick pass with this duty on the motors, in [-1, 1] of the supply (clamped).
    ///
    /// # Errors
    /// If the state stops being finite.
    pub fn step(&mut self, duty: Sides) -> Result<(), SimError> {
        let tick = self.tick + 1;
        if !(duty.left.is_finite() && duty.right.is_finite() && self.disturbance.is_finite()) {
            return Err(SimError::NonFinite { tick });
        }
        self.drive(duty);
        self.push();
        if self.floors_differ {
            self.grip();
        }
        self.meet_floors();
        let before: [Motion; 6] = std::array::from_fn(|i| {
            let body = if i < 2 { self.chassis.body } else { self.chassis.wheels[i - 2] };
            Motion::of(body, &self.physics.bodies)
        });
        self.physics.step_with_events(&self.rules, &());
        // Rapier takes a body that is not finite out of the simulation and goes on without it.
        if !self.physics.quarantine().is_empty() {
            return Err(SimError::NonFinite { tick });
        }
        self.tick = tick;
        let Self { physics, chassis, .. } = self;
        self.counter.note(tick, touch(&physics.narrow_phase, &physics.colliders, &chassis.shell, &before));
        self.mount.step(physics.integration_parameters.dt);
        let pose = chassis.world_from_base(&physics.bodies);
        let inside = within(&self.robot, &pose);
        let cell = self.network.cell_at(&inside, self.cell).unwrap_or(self.cell);
        if cell != self.cell {
            self.cell = cell;
            self.look_around();
        }
        let at = self.path.project_facing(&inside, &(pose.rotation * Vector3::x()), self.segment, self.farthest_m);
        (self.segment, self.farthest_m) = (at.segment, self.farthest_m.max(at.distance_m));
        Ok(())
    }

    /// Enables the planes of the floors near the robot's cell, and no others.
    fn look_around(&mut self) {
        if self.walls.floors.are_plain() {
            return;
        }
        let near = self.walls.floors.near(&self.network, self.cell, self.outline.reach_m());
        let mut set = |plane: &usize, enabled| {
            if let Some(collider) = self.physics.colliders.get_mut(self.floors[*plane]) {
                collider.set_enabled(enabled);
            }
        };
        self.near.planes.iter().filter(|plane| !near.planes.contains(plane)).for_each(|plane| set(plane, false));
        near.planes.iter().filter(|plane| !self.near.planes.contains(plane)).for_each(|plane| set(plane, true));
        self.near = near;
    }

    /// Finds how each wheel meets each of the floors near the robot, where there are several.
    fn meet_floors(&mut self) {
        if self.walls.floors.are_plain() {
            return;
        }
        let axle = convert::from_vector(self.chassis.axle(&self.physics.bodies));
        for (wheel, (_, touches)) in self.chassis.wheels.iter().zip(&mut self.rules.treads) {
            let centre = convert::from_vector(self.physics.bodies[*wheel].translation()).into();
            let Self { robot, near, walls, .. } = self;
            let wheel = Wheel { centre, axle, radius_m: robot.wheel_radius_m, width_m: robot.wheel_width_m };
            touches.clear();
            touches.extend(near.planes.iter().map(|plane| (*plane, walls.floors.touch(near, *plane, &wheel))));
        }
    }

    /// Puts the motors' torques on wheels and chassis.
    fn drive(&mut self, duty: Sides) {
        let Self { physics, chassis, drives, .. } = self;
        let [front_left, rear_left, front_right, rear_right] = chassis.wheel_speeds(&physics.bodies);
        let left = drives[0].step(duty.left, [front_left, rear_left]);
        let right = drives[1].step(duty.right, [front_right, rear_right]);
        let axle = chassis.axle(&physics.bodies);
        let torques = [left[0], left[1], right[0], right[1]];
        for (wheel, torque) in chassis.wheels.iter().zip(torques) {
            let wheel = &mut physics.bodies[*wheel];
            wheel.reset_torques(false);
            wheel.add_torque(axle * torque, false);
        }
        let body = &mut physics.bodies[chassis.body];
        body.reset_torques(false);
        body.add_torque(axle * -torques.iter().sum::<f64>(), false);
    }

    /// Puts the push, if there is one, on the chassis.
    fn push(&mut self) {
        let Some(push) = self.disturbance.push else { return };
        let body = &mut self.physics.bodies[self.chassis.body];
        let force = convert::vector(&push.force_n);
        let force = match push.frame {
            PushFrame::World => force,
            PushFrame::Base => body.rotation() * force,
        };
        let at = body.translation() + body.rotation() * Vector::new(0.0, 0.0, self.robot.centre_of_mass_m[1]);
        body.reset_forces(false);
        // Adds to the torque that `drive` has just set anew.
        body.add_force_at_point(force, at, false);
    }

    /// Gives a wheel's ball its friction.
    fn set_friction(&mut self, wheel: usize) {
        let friction = self.grip[wheel] * self.disturbance.grip_scale[wheel].max(0.0);
        self.physics.colliders[self.chassis.treads[wheel]].set_friction(friction);
    }

    /// Gives each wheel the friction of the floor under it.
    fn grip(&mut self) {
        for i in 0..4 {
            let centre = Point3::from(convert::from_vector(self.physics.bodies[self.chassis.wheels[i]].translation()));
            let near = self.wheel_cells[i];
            let cell = self.network.cell_at(&centre, near).unwrap_or(near);
            self.wheel_cells[i] = cell;
            if let Some(friction) = floor_grip(&self.network, &self.ground, cell)
                && friction != self.grip[i]
            {
                self.grip[i] = friction;
                self.set_friction(i);
            }
        }
    }

    /// Ticks since the start.
    pub fn tick(&self) -> Tick {
        self.tick
    }

    /// What the encoders have counted.
    pub fn counts(&self) -> Counts {
        let [left, right] = self.drives.each_ref().map(|drive| encoder::counts(&self.robot.drive, drive.angle_rad()));
        Counts { left, right }
    }

    /// Where the mount points.
    pub fn mount(&self) -> MountAngles {
        self.mount.angles()
    }

    /// What the mount's encoders read.
    pub fn mount_reading(&self) -> MountAngles {
        self.mount.reading()
    }

    /// Gives the mount play and encoders other than perfect ones.
    pub fn fit_mount(&mut self, gearing: Gearing) {
        self.mount.fit(gearing);
    }

    /// Points the mount; it goes there at its own rate.
    pub fn point_mount(&mut self, to: MountAngles) {
        self.mount.point(to);
    }

    /// What is really the case.
    pub fn truth(&self) -> Truth {
        let bodies = &self.physics.bodies;
        let world_from_base = self.chassis.world_from_base(bodies);
        let ahead = world_from_base.rotation * Vector3::x();
        let at = self.path.project_facing(&world_from_base.translation.vector.into(), &ahead, self.segment, self.farthest_m);
        let up = world_from_base.rotation * Vector3::z();
        let [front_left, rear_left, front_right, rear_right] = self.chassis.wheel_speeds(bodies);
        let [left, right] = &self.drives;
        Truth {
            world_from_base,
            cell: self.cell,
            fitting: self.network.cells[self.cell].fitting,
            segment: at.segment,
            distance_m: at.distance_m,
            lateral_m: at.lateral_m,
            heading_rad: truth::heading_rad(&world_from_base, &at.forward, &at.left),
            clearance_m: self.outline.clearance_m(&self.network, &self.walls, self.cell, &world_from_base),
            speed_m_s: self.chassis.velocity(bodies).dot(&ahead),
            yaw_rate_rad_s: convert::from_vector(bodies[self.chassis.body].angvel()).dot(&up),
            wheel_speed_rad_s: Sides { left: (front_left + rear_left) / 2.0, right: (front_right + rear_right) / 2.0 },
            motor_current_a: Sides { left: left.current_a(), right: right.current_a() },
        }
    }

    /// Energy of the robot: of its motion, its height (0 at the world's origin), links and windings, in J. What contacts, joints and
    /// the springs of compliant wheels store, which the engine does not tell, is left out.
    pub fn energy_j(&self) -> f64 {
        let Self { physics, chassis, drives, .. } = self;
        let mechanical = |handle: RigidBodyHandle| {
            let body = &physics.bodies[handle];
            body.kinetic_energy() - body.mass() * physics.gravity.dot(body.center_of_mass())
        };
        let bodies = mechanical(chassis.body) + chassis.wheels.iter().map(|wheel| mechanical(*wheel)).sum::<f64>();
        let [front_left, rear_left, front_right, rear_right] = chassis.wheel_speeds(&physics.bodies);
        let [left, right] = drives;
        bodies + left.energy_j([front_left, rear_left]) + right.energy_j([front_right, rear_right])
    }

    /// What the robot has bumped into so far.
    pub fn collisions(&self) -> Collisions {
        self.counter.collisions()
    }
}

/// A point inside the duct above the base's origin, which itself lies on the floor's plane.
fn within(robot: &RobotSpec, world_from_base: &Transform) -> Point3<f64> {
    world_from_base * Point3::new(0.0, 0.0, robot.wheel_radius_m)
}

/// Friction on the floor of a cell.
fn floor_grip(network: &Network, ground: &Ground, cell: CellId) -> Option<f64> {
    let floor = network.cells[cell].faces.iter().find(|face| face.kind == FaceKind::Floor)?;
    ground.friction(floor.surface)
}

/// Checks that every floor has a friction coefficient; says whether they differ.
fn check_grip(network: &Network, ground: &Ground) -> Result<bool, SimError> {
    let mut first = None;
    let mut differ = false;
    for face in network.cells.iter().flat_map(|cell| &cell.faces).filter(|face| face.kind == FaceKind::Floor) {
        let grip = ground.friction(face.surface).ok_or(SimError::NoFriction(face.surface.0))?;
        differ |= *first.get_or_insert(grip) != grip;
    }
    Ok(differ)
}
