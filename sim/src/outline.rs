//! The robot's convex parts: what can touch a wall, and what has a clearance.

use ductloop_duct::Transform;
use nalgebra::{Translation3, UnitQuaternion};
use rapier3d::geometry::SharedShape;

use crate::spec::RobotSpec;

/// A convex part of the robot, fixed to the base frame.
#[derive(Clone)]
pub struct Part {
    /// What it is.
    pub name: &'static str,
    /// Where it is. A wheel's axis is y.
    pub base_from_part: Transform,
    /// Its shape about its own centre.
    pub shape: SharedShape,
}

/// Places of the wheels' centres in the base frame, in the order of [`wheels`]: front left, rear left, front right, rear right.
pub fn wheel_centres_m(robot: &RobotSpec) -> [[f64; 3]; 4] {
    let (x, y, z) = (robot.wheelbase_m / 2.0, robot.track_m / 2.0, robot.wheel_radius_m);
    [[x, y, z], [-x, y, z], [x, -y, z], [-x, -y, z]]
}

/// The four wheels, as cylinders as thin as they are.
pub fn wheels(robot: &RobotSpec) -> [Part; 4] {
    let names = ["front left wheel", "rear left wheel", "front right wheel", "rear right wheel"];
    let centres = wheel_centres_m(robot);
    std::array::from_fn(|i| Part {
        name: names[i],
        base_from_part: at(centres[i]),
        shape: SharedShape::cylinder(robot.wheel_width_m / 2.0, robot.wheel_radius_m),
    })
}

/// Chassis box and mast.
pub fn body(robot: &RobotSpec) -> [Part; 2] {
    let [length_m, width_m, height_m] = robot.chassis_m;
    let roof_m = robot.ground_clearance_m + height_m;
    let mast_m = robot.highest_m - roof_m;
    [
        Part {
            name: "chassis",
            base_from_part: at([robot.nose_m - length_m / 2.0, 0.0, robot.ground_clearance_m + height_m / 2.0]),
            shape: SharedShape::cuboid(length_m / 2.0, width_m / 2.0, height_m / 2.0),
        },
        Part {
            name: "mast",
            base_from_part: at([robot.mast_x_m, 0.0, roof_m + mast_m / 2.0]),
            shape: SharedShape::cuboid(robot.mast_width_m / 2.0, robot.mast_width_m / 2.0, mast_m / 2.0),
        },
    ]
}

fn at(centre_m: [f64; 3]) -> Transform {
    let [x, y, z] = centre_m;
    Transform::from_parts(Translation3::new(x, y, z), UnitQuaternion::identity())
}
