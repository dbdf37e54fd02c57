//! Objects that stand in the way, wherever the path comes by them.

use ductloop_duct::centreline::{Centreline, Segment};
use ductloop_nav::ahead::Fitting;
use ductloop_sim::outline::wheel_centres_m;
use ductloop_sim::spec::RobotSpec;
use nalgebra::{Point3, Vector3};

/// An object leaves no way past it that is worth the name where the gaps at its sides are narrower than this, in metres.
const GAP_M: f64 = 0.05;

/// An object on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InTheWay {
    /// What eyes see in it: something between the walls, or a wall across.
    pub(super) fitting: Fitting,
    /// Where its near and its far face are, in metres along the path.
    pub(super) at_m: [f64; 2],
}

/// How a robot fills a duct: half its width, and its height, in metres.
pub(super) fn half_width_and_height_m(robot: &RobotSpec) -> [f64; 2] {
    let wheels = wheel_centres_m(robot).iter().map(|[_, y, _]| y.abs() + robot.wheel_width_m / 2.0).fold(0.0, f64::max);
    let [_, width_m, _] = robot.chassis_m;
    [wheels.max(width_m / 2.0), robot.highest_m]
}

/// The object with these corners on a segment of the path; `None` where it is elsewhere, beside the robot's way, or above the robot.
pub(super) fn on_segment(segment: &Segment, corners: &[Point3<f64>], [half_m, high_m]: [f64; 2]) -> Option<InTheWay> {
    let alone = Centreline { segments: vec![segment.clone()] };
    let sum = corners.iter().fold(Vector3::zeros(), |sum, corner| sum + corner.coords);
    let middle = alone.project(&Point3::from(sum / corners.len().max(1) as f64), 0);
    let within_m = segment.start_m..segment.start_m + segment.length_m;
    let floor_m = segment.pose_at(middle.distance_m - segment.start_m).translation.z;
    let (mut along, mut across, mut bottom_m) =
        ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY], f64::INFINITY);
    for corner in corners {
        let at = alone.project(corner, 0);
        along = [along[0].min(at.distance_m), along[1].max(at.distance_m)];
        across = [across[0].min(at.lateral_m), across[1].max(at.lateral_m)];
        bottom_m = bottom_m.min(corner.z - floor_m);
    }
    let duct_half_m = segment.width_at_m(middle.distance_m - segment.start_m) / 2.0;
    let is_here = within_m.contains(&middle.distance_m) && middle.lateral_m.abs() < duct_half_m && bottom_m > -segment.height_m;
    let is_in_the_way = across[0] < half_m && across[1] > -half_m && bottom_m < high_m;
    let closes = across[0] < GAP_M - duct_half_m && across[1] > duct_half_m - GAP_M;
    (is_here && is_in_the_way)
        .then_some(InTheWay { fitting: if closes { Fitting::DeadEnd } else { Fitting::Obstacle }, at_m: along })
}
