//! What comes from outside or breaks: a wheel that loses its grip, a push, a motor that weakens. Faults of a run are made of these.

use ductloop_nav::messages::Sides;
use nalgebra::Vector3;

/// All that disturbs the robot at present. The default is nothing, with which results are the same to the bit as without.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Friction under each wheel as a share of what the floor there gives: dust, grease, a wet patch. In the order of
    /// [`crate::outline::wheels`]: front left, rear left, front right, rear right. Negative is as 0; above 1 is stickier.
    pub grip_scale: [f64; 4],
    /// A force on the chassis.
    pub push: Option<Push>,
    /// Share of the supply that reaches each side's motor, clamped to [0, 1].
    ///
    /// Between 0 and 1 the motor is weak as on a flat battery: duty d puts d times this share of the supply on a winding that stays
    /// closed, so that the motor still brakes by its back-EMF, and at duty 0 a weak motor brakes like a sound one. 0 is dead: the
    /// winding is open (a broken wire, a driver that has switched off), no current flows, and the motor neither drives nor
    /// brakes; gear and bearings drag on. The two differ because they happen differently: a supply sags by degrees, a wire
    /// breaks. So 0 is not the limit of small values: that would be a short circuit, which is a brake.
    pub motor_strength: Sides,
}

/// A force on the chassis, at the point of its midplane above the base's origin and as high as the centre of mass: it shifts the
/// robot and, sideways, loads the wheels of one side, but it does not by itself turn a robot that is balanced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// In N.
    pub force_n: Vector3<f64>,
    /// What its axes are.
    pub frame: PushFrame,
}

/// The axes of a push.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushFrame {
    /// The world's: a force that keeps its direction whatever the robot does.
    World,
    /// The base's: x forward, y left, z up.
    Base,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self { grip_scale: [1.0; 4], push: None, motor_strength: Sides { left: 1.0, right: 1.0 } }
    }
}

impl Disturbance {
    pub(crate) fn is_finite(&self) -> bool {
        let push = self.push.map_or(Vector3::zeros(), |push| push.force_n);
        let strength = [self.motor_strength.left, self.motor_strength.right];
        self.grip_scale.iter().chain(push.iter()).chain(&strength).all(|value| value.is_finite())
    }
}
