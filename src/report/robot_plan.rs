//! The robot from above.

use ductloop_sim::outline::wheel_centres_m;
use ductloop_sim::spec::RobotSpec;

/// A rectangle in the base frame, corners in order, in metres.
pub(super) type Rectangle = [[f64; 2]; 4];

fn rectangle(centre: [f64; 2], size: [f64; 2]) -> Rectangle {
    let ([x, y], [a, b]) = (centre, size.map(|s| s / 2.0));
    [[x + a, y + b], [x - a, y + b], [x - a, y - b], [x + a, y - b]]
}

/// Wheels, then chassis, then mast.
pub(super) fn parts(robot: &RobotSpec) -> Vec<(&'static str, Rectangle)> {
    let wheel = [2.0 * robot.wheel_radius_m, robot.wheel_width_m];
    let wheels = wheel_centres_m(robot).map(|[x, y, _]| ("wheel", rectangle([x, y], wheel)));
    let [length, width, _] = robot.chassis_m;
    let chassis = ("chassis", rectangle([robot.nose_m - length / 2.0, 0.0], [length, width]));
    let mast = ("mast", rectangle([robot.mast_x_m, 0.0], [robot.mast_width_m; 2]));
    wheels.into_iter().chain([chassis, mast]).collect()
}

/// Every corner of every part.
pub(super) fn corners(robot: &RobotSpec) -> Vec<[f64; 2]> {
    parts(robot).into_iter().flat_map(|(_, corners)| corners).collect()
}
