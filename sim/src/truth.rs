//! What is really the case: the pose of the robot and where it stands in its duct. No navigator sees this.

use ductloop_duct::Transform;
use ductloop_duct::cell::CellId;
use ductloop_nav::messages::Sides;
use nalgebra::Vector3;

/// The state of the robot at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Pose of the base.
    pub world_from_base: Transform,
    /// The cell that holds the robot, or the last one that did.
    pub cell: CellId,
    /// Index of the fitting that this cell is a part of.
    pub fitting: usize,
    /// Index of the segment of the reference path that the base is beside. Where the path comes by a place again, it tells the pass.
    pub segment: usize,
    /// Distance along the reference path, in m.
    pub distance_m: f64,
    /// Offset of the base from the reference path, left positive, in m.
    pub lateral_m: f64,
    /// Direction of the robot against that of the path, anticlockwise positive, in (-pi, pi].
    pub heading_rad: f64,
    /// Smallest distance of the robot's outline to a wall, ceiling or solid, in m; zero when it touches.
    pub clearance_m: f64,
    /// Speed of the base along its own x axis, in m/s.
    pub speed_m_s: f64,
    /// Turn rate about the base's z axis, in rad/s.
    pub yaw_rate_rad_s: f64,
    /// Speed of the wheels, mean of front and rear, in rad/s.
    pub wheel_speed_rad_s: Sides,
    /// Current in each motor, in A.
    pub motor_current_a: Sides,
}

/// Angle from `forward` to the robot's x axis about `forward` x `left`, in (-pi, pi].
pub fn heading_rad(world_from_base: &Transform, forward: &Vector3<f64>, left: &Vector3<f64>) -> f64 {
    let ahead = world_from_base.rotation * Vector3::x();
    libm::atan2(ahead.dot(left), ahead.dot(forward))
}
