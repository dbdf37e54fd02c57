//! Where a fitting can be joined to another.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{Fitting, Hand, Shape, elbow, junction, transition};
use crate::Transform;
use crate::centreline::{half_turn, start_from_along, turn_about_z};

/// Name of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PortName {
    /// Where the fitting's own frame is.
    In,
    /// Where the duct goes on.
    Out,
    /// The branch on the left, seen from `in`.
    Left,
    /// The branch on the right, seen from `in`.
    Right,
}

/// A port of a fitting: an upright rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Which one.
    pub name: PortName,
    /// Its pose in the fitting's frame: in the middle of its floor, x out of the fitting, z up.
    pub entry_from_port: Transform,
    /// Inside width, in metres.
    pub width_m: f64,
    /// Inside height, in metres.
    pub height_m: f64,
}

impl PortName {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::In, Self::Out, Self::Left, Self::Right];

    /// The port of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|port| port.as_str() == name)
    }

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::In => "in",
            Self::Out => "out",
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

impl Port {
    /// The port's pose turned to look into the fitting: where a way in starts.
    pub fn entry_from_inward(&self) -> Transform {
        // `in` is the fitting's own frame: two half turns would change the sign of its quaternion.
        if self.name == PortName::In { Transform::identity() } else { self.entry_from_port * half_turn() }
    }
}

impl std::fmt::Display for PortName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Fitting {
    /// Its ports: `in`, and of `out`, `left` and `right` those that it has, in this order.
    pub fn ports(&self) -> Vec<Port> {
        PortName::ALL.into_iter().filter_map(|name| self.port(name)).collect()
    }

    /// The port of this name.
    pub fn port(&self, name: PortName) -> Option<Port> {
        let (width_m, height_m) = (self.width_m, self.height_m);
        let port = |entry_from_port, width_m, height_m| Some(Port { name, entry_from_port, width_m, height_m });
        match name {
            PortName::In => port(half_turn(), width_m, height_m),
            PortName::Out => match self.shape {
                Shape::BullheadTee { .. } | Shape::Wye { .. } => None,
                Shape::Transition { to_width_m, to_height_m, .. } => {
                    port(transition::entry_from_exit(self), to_width_m, to_height_m)
                }
                _ => port(self.entry_from_out(), width_m, height_m),
            },
            PortName::Left => self.branch(Hand::Left).and_then(|(at, branch_m)| port(at, branch_m, height_m)),
            PortName::Right => self.branch(Hand::Right).and_then(|(at, branch_m)| port(at, branch_m, height_m)),
        }
    }

    /// Where the duct goes on with the same section.
    fn entry_from_out(&self) -> Transform {
        let ahead = |length_m| Transform::translation(length_m, 0.0, 0.0);
        match self.shape {
            Shape::RadiusElbow { angle_rad, .. } | Shape::MitredElbow { angle_rad } | Shape::VanedElbow { angle_rad } => {
                let curvature_1_m = self.curvature_1_m();
                start_from_along(curvature_1_m, elbow::length_m(angle_rad, curvature_1_m))
            }
            Shape::Offset { length_m, aside_m } => Transform::translation(length_m, aside_m, 0.0),
            Shape::Slope { length_m, angle_rad } => Transform::translation(length_m, 0.0, length_m * libm::tan(angle_rad)),
            Shape::Straight { length_m }
            | Shape::Damper { length_m, .. }
            | Shape::Grille { length_m, .. }
            | Shape::Drop { length_m, .. } => start_from_along(0.0, length_m),
            Shape::Tee { branch_width_m, .. } | Shape::Cross { branch_width_m } => ahead(branch_width_m),
            Shape::SideBranch { branch_width_m, shoe_m, .. } => ahead(shoe_m + branch_width_m),
            Shape::Transition { .. } | Shape::BullheadTee { .. } | Shape::Wye { .. } => Transform::identity(),
        }
    }

    /// Pose and width of the branch on this side.
    fn branch(&self, side: Hand) -> Option<(Transform, f64)> {
        // Square to the duct, x_m along it, the port beside_m from its middle.
        let square = |x_m, beside_m: f64| {
            let at = Vector3::new(x_m, side.sign() * beside_m, 0.0);
            Transform::from_parts(at.into(), turn_about_z(side.sign() * FRAC_PI_2))
        };
        let half_m = self.width_m / 2.0;
        match self.shape {
            Shape::Tee { hand, branch_width_m } if hand == side => Some((square(branch_width_m / 2.0, half_m), branch_width_m)),
            Shape::SideBranch { hand, branch_width_m, shoe_m } if hand == side => {
                Some((square(shoe_m + branch_width_m / 2.0, half_m + shoe_m), branch_width_m))
            }
            Shape::BullheadTee { branch_width_m } | Shape::Cross { branch_width_m } => {
                Some((square(branch_width_m / 2.0, half_m), branch_width_m))
            }
            Shape::Wye { half_angle_rad, branch_width_m } => {
                let at = junction::WyePlan::new(self.width_m, branch_width_m, half_angle_rad).port_middle();
                let at = Vector3::new(at.x, side.sign() * at.y, 0.0);
                Some((Transform::from_parts(at.into(), turn_about_z(side.sign() * half_angle_rad)), branch_width_m))
            }
            _ => None,
        }
    }
}
