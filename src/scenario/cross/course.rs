//! Start, finish and the settling distance, in the duct as it was assembled.

use ductloop_duct::Transform;
use ductloop_duct::centreline::Segment;
use ductloop_duct::network::{End, Network};
use ductloop_nav::angle::rotation_about_z;
use ductloop_sim::spec::RobotSpec;
use nalgebra::{Point3, Translation3};

use super::{Cross, FREE_M, up_mm};

/// The robot's plan is looked at in points this far apart.
const STEP_M: f64 = 0.01;

/// The rectangles, in the base frame, that a robot's plan is made of: (rear, front, half width), in metres.
fn plan(robot: &RobotSpec) -> [(f64, f64, f64); 2] {
    let axle = robot.wheelbase_m / 2.0 + robot.wheel_radius_m;
    let [length_m, width_m, _] = robot.chassis_m;
    [(robot.nose_m - length_m, robot.nose_m, width_m / 2.0), (-axle, axle, (robot.track_m + robot.wheel_width_m) / 2.0)]
}

/// Points on the outline of the robot's plan with [`FREE_M`] around it, in the base frame.
fn outline(robot: &RobotSpec) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for (rear, front, half) in plan(robot) {
        let (rear, front, half) = (rear - FREE_M, front + FREE_M, half + FREE_M);
        let steps = |length: f64| (length / STEP_M).ceil().max(1.0) as usize;
        let along = steps(front - rear);
        let across = steps(2.0 * half);
        for i in 0..=along {
            let x = rear + (front - rear) * i as f64 / along as f64;
            points.extend([[x, half], [x, -half]]);
        }
        for i in 0..=across {
            let y = -half + 2.0 * half * i as f64 / across as f64;
            points.extend([[rear, y], [front, y]]);
        }
    }
    points
}

impl Cross<'_> {
    pub(super) fn course(&mut self, network: &Network) {
        let length_m = network.centreline.length_m();
        let finish_m = self.scenario.finish_m(network);
        let start = self.scenario.start;
        if !self.checked.is_sound(&["start", "finish"]) {
            return;
        }
        if start.distance_m >= length_m {
            self.wrong_with(
                &["start.distance_m", "duct.run"],
                format!("the start is at {} m, but the duct ends at {length_m:.3} m", start.distance_m),
                "a distance within the duct",
                self.way_at(network, length_m).into_iter().collect(),
            );
        } else if finish_m <= start.distance_m {
            let places = [self.field_at("start.distance_m"), self.way_at(network, length_m)];
            self.wrong_with(
                &["finish.before_end_m", "start.distance_m", "duct.run"],
                format!(
                    "the finish is at {finish_m:.3} m, before the start at {} m: the duct is {length_m:.3} m long",
                    start.distance_m
                ),
                "a longer duct, or less of `start.distance_m` and `finish.before_end_m`",
                places.into_iter().flatten().collect(),
            );
        } else {
            self.start(network);
            self.start_among(network);
            self.start_view(network);
            self.finish();
            self.passable(network, start.distance_m, finish_m);
            self.settle(finish_m - start.distance_m);
        }
    }

    /// Where the path leads, every fitting is wider and higher than the robot.
    fn passable(&mut self, network: &Network, from_m: f64, to_m: f64) {
        if !self.checked.is_sound(&["robot", "duct"]) {
            return;
        }
        let robot_m = self.scenario.robot.smallest_duct_m();
        let needs_m = [robot_m[0] + 2.0 * FREE_M, robot_m[1] + FREE_M];
        let on_the_way = |segment: &&Segment| segment.start_m < to_m && segment.start_m + segment.length_m > from_m;
        let too_small = |segment: &Segment| {
            let has_m = [segment.width_m.min(segment.end_width_m), network.fittings[segment.fitting].clear_height_m()];
            let axis = (0..2).find(|axis| has_m[*axis] < needs_m[*axis])?;
            Some((segment.fitting, axis, has_m[axis]))
        };
        let found = network.centreline.segments.iter().filter(on_the_way).find_map(too_small);
        let Some((fitting, axis, has_m)) = found else { return };
        let (name, path) = self.fitting_at(fitting).unwrap_or_default();
        let word = ["wide", "high"][axis];
        self.wrong(
            &[&path],
            format!("on the way `{name}` is {has_m:.3} m {word}, and the robot {:.3} m", robot_m[axis]),
            format!(
                "{:.3} m or more, a millimetre of it free on each side; or a route that does not lead there",
                up_mm(needs_m[axis])
            ),
        );
    }

    /// The robot stands free at the start.
    fn start(&mut self, network: &Network) {
        if !self.checked.is_sound(&["robot", "duct"]) {
            return;
        }
        let (robot, start) = (&self.scenario.robot, self.scenario.start);
        let [width_m, height_m] = network.centreline.section_at_m(start.distance_m);
        let turn = rotation_about_z(start.heading_rad);
        let base_from_plan = Transform::from_parts(Translation3::new(0.0, start.lateral_m, 0.0), turn.into());
        let world_from_plan = network.centreline.pose_at(start.distance_m) * base_from_plan;
        let outline: Vec<_> = outline(robot).into_iter().map(|[x, y]| Point3::new(x, y, height_m / 2.0)).collect();
        let outside = |p: &&Point3<f64>| network.cell_at(&(world_from_plan * **p), 0).is_none();
        if outline.iter().find(outside).is_none() {
            return;
        }
        // Relative to the centreline, as if the duct were straight there.
        let reach = |axis: usize| outline.iter().map(move |p| (base_from_plan.rotation * p)[axis]);
        let rear_m = reach(0).fold(0.0, f64::min);
        let (right_m, left_m) = reach(1).fold((0.0, 0.0), |(low, high), y| (f64::min(low, y), f64::max(high, y)));
        let half_m = width_m / 2.0;
        let here: Vec<_> = self.way_at(network, start.distance_m).into_iter().collect();
        if start.distance_m + rear_m < 0.0 {
            self.wrong_with(
                &["start.distance_m", "start"],
                format!("at the start, {} m along the duct, the robot's rear is outside", start.distance_m),
                &format!("{:.3} m or more", up_mm(-rear_m)),
                here,
            );
        } else if left_m - right_m > width_m {
            self.wrong_with(
                &["start.heading_deg", "start"],
                "at the start the robot touches a wall, wherever between them it stands".to_owned(),
                &format!("at this heading it is {:.3} m wide", left_m - right_m),
                here,
            );
        } else {
            self.wrong_with(
                &["start.lateral_m", "start.heading_deg", "start.distance_m", "start"],
                "at the start the robot touches a wall".to_owned(),
                &format!(
                    "at this heading, in a straight, `start.lateral_m` may be {:.3} to {:.3}",
                    up_mm(-half_m - right_m),
                    -up_mm(left_m - half_m)
                ),
                here,
            );
        }
    }

    /// A cap leaves room for the nose.
    fn finish(&mut self) {
        let nose_m = self.scenario.robot.nose_m.max(plan(&self.scenario.robot)[1].1) + FREE_M;
        let (duct, finish) = (&self.scenario.duct, self.scenario.finish);
        if self.checked.is_sound(&["robot", "duct"]) && duct.exit == End::Cap && finish.before_end_m < nose_m {
            self.wrong(
                &["finish.before_end_m", "duct.exit"],
                format!("the finish is {} m before the duct's cap, which the robot's nose meets first", finish.before_end_m),
                format!("{:.3} m or more", up_mm(nose_m)),
            );
        }
    }

    fn settle(&mut self, run_m: f64) {
        let settle_m = self.scenario.pass.settle_m;
        if self.checked.is_sound(&["pass.settle_m"]) && settle_m >= run_m {
            self.wrong(
                &["pass.settle_m", "pass"],
                format!("`pass.settle_m` is {settle_m} m, but the run is only {run_m:.3} m long: nothing is left to judge"),
                format!("less than {run_m:.3}"),
            );
        }
    }
}
