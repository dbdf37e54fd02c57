//! What holds a wheel: a rigid bearing, or one that gives up and down as the wheel's rim would.
//!
//! A compliant wheel is modelled where it is simplest: the wheel stays a rigid ball, and its axle moves up and down in the
//! chassis on a spring with the stiffness of the rim. To the chassis that is the same as a rim pressed flat; the wheel's own mass
//! is on the other side of the spring, which matters only above its own resonance (about 50 Hz and up). Preloaded so that the
//! robot stands level, at its nominal height, on a level floor.
//!
//! It is not a tyre: no lateral or circumferential give, no slip angle, no change of the rolling radius with the load.

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::Vector;
use rapier3d::prelude::{GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, MotorModel, RevoluteJointBuilder};

use crate::convert;
use crate::drive::GRAVITY_M_S2;
use crate::spec::RobotSpec;

/// The joint between chassis (first body, base frame) and a wheel whose centre is at `centre_m` in the base frame.
pub(crate) fn joint(robot: &RobotSpec, centre_m: &Vector3<f64>) -> GenericJoint {
    if robot.wheel_compliance_m_n == 0.0 {
        return RevoluteJointBuilder::new(Vector::Y)
            .local_anchor1(convert::vector(centre_m))
            .local_anchor2(Vector::ZERO)
            .contacts_enabled(false)
            .build()
            .into();
    }
    let stiffness_n_m = 1.0 / robot.wheel_compliance_m_n;
    let damping_n_s_m = 2.0 * robot.wheel_damping_ratio * (stiffness_n_m * robot.mass_kg / 4.0).sqrt();
    let [front_n, rear_n] = robot.wheel_loads_n();
    let load_n = if centre_m.x > 0.0 { front_n } else { rear_n };
    // What the spring carries: the load without the wheel's own weight.
    let preload_m = (load_n - robot.wheel_mass_kg * GRAVITY_M_S2) / stiffness_n_m;
    // The joint's frame: x along the axle, to the left, z up.
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[Vector3::y(), -Vector3::x(), Vector3::z()]));
    let turn = UnitQuaternion::from_rotation_matrix(&turn);
    let frame = |at: Vector3<f64>| convert::pose(&ductloop_duct::Transform::from_parts(Translation3::from(at), turn));
    GenericJointBuilder::new(JointAxesMask::LIN_X | JointAxesMask::LIN_Y | JointAxesMask::ANG_Y | JointAxesMask::ANG_Z)
        .local_frame1(frame(*centre_m))
        .local_frame2(frame(Vector3::zeros()))
        .contacts_enabled(false)
        .motor_model(JointAxis::LinZ, MotorModel::ForceBased)
        .motor_position(JointAxis::LinZ, -preload_m, stiffness_n_m, damping_n_s_m)
        .build()
}
