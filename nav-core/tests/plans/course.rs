//! A robot follows its route through drawn plans: it sees what a line scanner would, goes by wheels that are a little off, and ends up in
//! the duct that the route names.

use super::plan::{AT_M, HALF_M, WIDTH_M, Wall, across, elbow, plans, scan, shoed, side_wall, wye};
use ductloop_nav::ahead::{self, DuctPlace, Fitting, Side};
use ductloop_nav::course::route::Turn;
use ductloop_nav::course::{Course, CourseParams, End, Mission};

const PERIOD_S: f64 = 1.0 / 30.0;
/// Share by which its turns differ from what its wheels say.
const TURN_OFF: f64 = 0.03;

/// A robot that does at once what it is told.
struct Robot {
    /// Where it is: x, y, heading, in the plan.
    pose: [f64; 3],
    /// Where it believes to be in its duct: lateral offset, heading, width.
    lateral_m: f64,
    heading_rad: f64,
    width_m: f64,
    course: Course,
    /// Farthest off the path that it believed to be on, in metres.
    farthest_m: f64,
}

impl Robot {
    fn new(route: &[Turn]) -> Self {
        let params = CourseParams { mission: Mission::Route(route.to_vec()), speed_m_s: 0.25, ..CourseParams::default() };
        let mut course = Course::new(params);
        course.advance(0.5);
        Self { pose: [0.5, 0.0, 0.0], lateral_m: 0.0, heading_rad: 0.0, width_m: WIDTH_M, course, farthest_m: 0.0 }
    }

    fn place(&self) -> DuctPlace {
        let (lateral_m, heading_rad) = (self.lateral_m, self.heading_rad);
        DuctPlace { along_m: self.course.along_m(), lateral_m, heading_rad, width_m: self.width_m }
    }

    fn frame(&mut self, walls: &[Wall]) {
        let ranges = scan(walls, self.pose, 0.2);
        if self.course.believes(self.heading_rad) {
            let stretch = self.course.straight().unwrap_or(ahead::Stretch {
                along_m: [[f64::NEG_INFINITY, self.course.along_m() + 1.2]; 2],
                near_m: 0.06,
                is_rough: false,
            });
            if let Some(walls) = ahead::side_walls(&ranges, &self.place(), &stretch) {
                self.heading_rad += 0.3 * (walls.heading_rad - self.heading_rad);
                let offsets =
                    [walls.left_m.map(|left| self.width_m / 2.0 - left), walls.right_m.map(|right| right - self.width_m / 2.0)];
                let seen: Vec<f64> = offsets.into_iter().flatten().collect();
                let mean = seen.iter().sum::<f64>() / seen.len() as f64;
                self.lateral_m += 0.3 * (mean - self.lateral_m);
            }
        }
        if let Some(entered) = self.course.look(&self.place(), &ranges) {
            (self.lateral_m, self.heading_rad, self.width_m) = (entered.lateral_m[0], entered.heading_rad[0], entered.width_m[0]);
        }
        let here = self.course.path(0.0, self.lateral_m, self.heading_rad);
        self.farthest_m = self.farthest_m.max(here.on_path.lateral_m.abs());
        let (speed, turn) = match self.course.manoeuvre(self.heading_rad) {
            Some(twist) => (twist.speed_m_s, twist.yaw_rate_rad_s),
            None => {
                let speed = 0.25 * (1.0 - here.slowing);
                (speed, speed * (here.on_path.curvature_1_m - 20.0 * here.on_path.lateral_m - 6.0 * here.on_path.heading_rad))
            }
        };
        let (way, turned) = (speed * PERIOD_S, turn * PERIOD_S);
        let (sin, cos) = libm::sincos(self.heading_rad + turned / 2.0);
        self.course.advance(way * cos);
        self.lateral_m += way * sin;
        self.heading_rad += turned;
        let (sin, cos) = libm::sincos(self.pose[2] + turned / 2.0);
        self.pose = [self.pose[0] + way * cos, self.pose[1] + way * sin, self.pose[2] + turned * (1.0 + TURN_OFF)];
    }

    /// Goes on until this is so, for half a minute at most.
    fn until(&mut self, walls: &[Wall], is_so: impl Fn(&Self) -> bool) -> bool {
        (0..900).any(|_| {
            self.frame(walls);
            is_so(self)
        })
    }
}

/// Which turns a fitting offers.
fn offers(fitting: Fitting) -> Vec<Turn> {
    match fitting {
        Fitting::Elbow(Side::Left) => vec![Turn::Left],
        Fitting::Elbow(Side::Right) => vec![Turn::Right],
        Fitting::Branch(Side::Left) => vec![Turn::Left, Turn::Straight],
        Fitting::Branch(Side::Right) => vec![Turn::Right, Turn::Straight],
        Fitting::BullheadTee => vec![Turn::Left, Turn::Right],
        Fitting::Cross => vec![Turn::Left, Turn::Straight, Turn::Right],
        Fitting::DeadEnd => vec![Turn::TurnBack],
        Fitting::Transition | Fitting::Offset(_) => vec![Turn::Straight],
        Fitting::Unknown | Fitting::Straight | Fitting::Obstacle | Fitting::Drop => vec![],
    }
}

/// Where the middle of the duct behind a transition lies.
fn middle_behind(index: usize) -> f64 {
    match index {
        10 => (HALF_M - 0.35) / 2.0,
        11 => (0.15 - HALF_M) / 2.0,
        _ => 0.0,
    }
}

/// Every turn that a fitting offers is taken, along the middle of both ducts.
#[test]
fn the_way_that_the_route_names_is_taken() {
    for (index, (fitting, walls)) in plans().into_iter().enumerate() {
        for turn in offers(fitting) {
            // An elbow is no choice.
            let route =
                if matches!(fitting, Fitting::Elbow(_) | Fitting::Transition | Fitting::Offset(_)) { vec![] } else { vec![turn] };
            let mut robot = Robot::new(&route);
            let case = format!("{index}, {fitting:?}, {turn:?}");
            let (x, y) = (|robot: &Robot| robot.pose[0], |robot: &Robot| robot.pose[1]);
            let arrived = match turn {
                Turn::Left => robot.until(&walls, |robot| y(robot) > 1.5),
                Turn::Right => robot.until(&walls, |robot| y(robot) < -1.5),
                Turn::Straight => robot.until(&walls, |robot| x(robot) > AT_M + 1.5),
                Turn::TurnBack | Turn::Stop => robot.until(&walls, |robot| x(robot) < 1.5 && robot.pose[2].abs() > 3.0),
            };
            assert!(arrived, "{case}: {:?} {:?}", robot.pose, robot.course.outlook());
            assert!(robot.farthest_m < 0.06, "{case}: {} m off its path", robot.farthest_m);
            // In the middle of the duct that it is in, whatever it believes.
            let radius_elbow = matches!(index, 2 | 3);
            let middle = if radius_elbow { AT_M + 0.75 * WIDTH_M + HALF_M } else { AT_M + HALF_M };
            let off_m = match turn {
                Turn::Left | Turn::Right => robot.pose[0] - middle,
                _ => robot.pose[1] - middle_behind(index),
            };
            let found = robot.course.first_from_base(robot.lateral_m, robot.heading_rad);
            let drift_m = libm::hypot(found[0] - robot.pose[0], found[1] - robot.pose[1]);
            assert!(drift_m < 0.08, "{case}: {drift_m} m of drift, {found:?} {:?}", robot.pose);
            assert!(off_m.abs() < 0.01, "{case}: {off_m} m off the middle");
        }
    }
}

/// Elbows of any angle are driven through, mitred and curved.
#[test]
fn elbows_of_any_angle_are_driven_through() {
    for turn_deg in [30.0_f64, 45.0, 60.0, 90.0, 120.0] {
        for throat_m in [0.0, 0.25, 0.375, 0.75] {
            let (walls, [x, y, turn_rad]) = elbow(turn_deg.to_radians(), throat_m);
            let mut robot = Robot::new(&[]);
            // Along the middle of the duct behind it, and beside it.
            let behind = |robot: &Robot| {
                let (sin, cos) = libm::sincos(turn_rad);
                let (dx, dy) = (robot.pose[0] - x, robot.pose[1] - y);
                [cos * dx + sin * dy, cos * dy - sin * dx]
            };
            let arrived = robot.until(&walls, |robot| behind(robot)[0] > 1.0 && robot.pose[2] > 0.5 * turn_rad);
            let case = format!("{turn_deg} degrees, {throat_m} m");
            assert!(arrived, "{case}: {:?} {:?}", robot.pose, robot.course.outlook());
            let [_, aside_m] = behind(&robot);
            assert!(
                aside_m.abs() < 0.01 && (robot.pose[2] - turn_rad).abs() < 0.03,
                "{case}: {aside_m} m aside, {:?}",
                robot.pose
            );
            assert!(robot.farthest_m < 0.08, "{case}: {} m off its path", robot.farthest_m);
        }
    }
}

/// Where the route is over, or names what is not there, the robot stands before the wall and says why.
#[test]
fn it_stands_where_its_route_ends() {
    let plan = |fitting: Fitting| plans().into_iter().find(|(own, _)| *own == fitting).expect("a plan").1;
    for (fitting, route, end) in [
        (Fitting::DeadEnd, vec![], End::DeadEnd),
        (Fitting::DeadEnd, vec![Turn::Stop], End::Route),
        (Fitting::DeadEnd, vec![Turn::Left], End::NoSuchWay),
        (Fitting::Obstacle, vec![], End::Obstacle),
        (Fitting::BullheadTee, vec![], End::NoSuchWay),
        (Fitting::BullheadTee, vec![Turn::Straight], End::NoSuchWay),
        // Before a junction, not in it.
        (Fitting::BullheadTee, vec![Turn::Stop], End::Route),
        (Fitting::Branch(Side::Left), vec![Turn::Stop], End::Route),
        (Fitting::Cross, vec![Turn::Stop], End::Route),
    ] {
        let walls = plan(fitting);
        let mut robot = Robot::new(&route);
        assert!(robot.until(&walls, |robot| robot.course.end().is_some()), "{fitting:?} {route:?}: {:?}", robot.pose);
        assert_eq!(robot.course.end(), Some(end), "{fitting:?} {route:?}");
        let front_m = if end == End::NoSuchWay && fitting == Fitting::BullheadTee { AT_M + WIDTH_M } else { AT_M };
        assert!((0.2..0.3).contains(&(front_m - robot.pose[0])), "{fitting:?} {route:?}: {:?}", robot.pose);
    }
}

/// A box from one corner to another, with the duct's walls.
fn with_boxes(boxes: &[[[f64; 2]; 2]]) -> Vec<Wall> {
    let round = |[[x, y], [to_x, to_y]]: [[f64; 2]; 2]| {
        [[[x, y], [to_x, y]], [[to_x, y], [to_x, to_y]], [[to_x, to_y], [x, to_y]], [[x, to_y], [x, y]]]
    };
    let sides = [HALF_M, -HALF_M].map(|y| [[0.0, y], [12.0, y]]);
    sides.into_iter().chain(boxes.iter().copied().flat_map(round)).collect()
}

/// How much is free between a box and a robot that reaches 0.16 m ahead of its origin, 0.12 m behind it and 0.1075 m to both sides; 0 if
/// they touch.
fn clearance_m(pose: [f64; 3], [from, to]: [[f64; 2]; 2]) -> f64 {
    let (sin, cos) = libm::sincos(pose[2]);
    let mut least_m = f64::INFINITY;
    for step in 0..=20 {
        let share = f64::from(step) / 20.0;
        for [x, y] in [[-0.12 + 0.28 * share, 0.1075], [-0.12 + 0.28 * share, -0.1075], [0.16, 0.215 * share - 0.1075]] {
            let [x, y] = [pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y];
            let [dx, dy] = [(from[0] - x).max(x - to[0]).max(0.0), (from[1] - y).max(y - to[1]).max(0.0)];
            least_m = least_m.min(libm::hypot(dx, dy));
        }
    }
    least_m
}

/// Boxes that leave 0.3 m at one side are passed there, in the middle of what is free, and the robot is in the duct's middle behind them.
#[test]
fn what_leaves_room_is_passed() {
    for (right_m, left_m, long_m) in [(-HALF_M, -0.05, 0.25), (0.05, HALF_M, 0.25), (-HALF_M, -0.07, 0.6), (0.05, 0.2, 0.1)] {
        let thing = [[AT_M, right_m], [AT_M + long_m, left_m]];
        let walls = with_boxes(&[thing]);
        let mut robot = Robot::new(&[]);
        let mut least_m = f64::INFINITY;
        let arrived = (0..1500).any(|_| {
            robot.frame(&walls);
            let at_wall_m = HALF_M - robot.pose[1].abs() - 0.1075;
            least_m = least_m.min(clearance_m(robot.pose, thing)).min(at_wall_m);
            robot.pose[0] > AT_M + long_m + 1.5
        });
        let case = format!("{right_m} to {left_m}, {long_m} m long");
        assert!(arrived, "{case}: {:?} {:?} {:?}", robot.pose, robot.course.end(), robot.course.outlook());
        // 42 mm are free at both sides in the middle, less where it is known by pieces of the width.
        assert!(least_m > 0.02, "{case}: {least_m} m");
        assert!(robot.pose[1].abs() < 0.01 && robot.pose[2].abs() < 0.03, "{case}: {:?}", robot.pose);
        let met: Vec<_> =
            robot.course.log().ducts()[0].met.iter().map(|met| (met.fitting, (met.at_m - AT_M).abs() < 0.05)).collect();
        assert_eq!(met, [(Fitting::Obstacle, true)], "{case}");
    }
}

/// What leaves 0.25 m is not passed; nor is a thing behind which another one stands in the way back to the middle.
#[test]
fn what_leaves_too_little_is_not_passed() {
    let box_at = |x: f64, right_m: f64, left_m: f64| [[x, right_m], [x + 0.25, left_m]];
    for boxes in [
        vec![box_at(AT_M, -HALF_M, 0.0)],
        vec![box_at(AT_M, -0.125, 0.125)],
        vec![box_at(AT_M, -HALF_M, -0.05), box_at(AT_M + 0.3, 0.05, HALF_M)],
        vec![box_at(AT_M, -HALF_M, -0.05), box_at(AT_M + 0.8, 0.05, HALF_M)],
        vec![box_at(AT_M, -HALF_M, -0.05), box_at(AT_M + 1.0, -HALF_M, 0.05)],
    ] {
        let walls = with_boxes(&boxes);
        let mut robot = Robot::new(&[]);
        let mut least_m = f64::INFINITY;
        let stopped = (0..1500).any(|_| {
            robot.frame(&walls);
            least_m = boxes.iter().map(|thing| clearance_m(robot.pose, *thing)).fold(least_m, f64::min);
            robot.course.end().is_some()
        });
        assert!(stopped && robot.course.end() == Some(End::Obstacle), "{boxes:?}: {:?} {:?}", robot.pose, robot.course.end());
        assert!(least_m > 0.02, "{boxes:?}: {least_m} m, {:?}", robot.pose);
    }
}

/// Straight on past a junction, with a stop next: it drives on at its usual speed.
#[test]
fn a_stop_behind_a_junction_is_not_at_it() {
    for fitting in [Fitting::Branch(Side::Left), Fitting::Cross] {
        let walls = plans().into_iter().find(|(own, _)| *own == fitting).expect("a plan").1;
        let mut robot = Robot::new(&[Turn::Straight, Turn::Stop]);
        assert!(robot.until(&walls, |robot| robot.course.junctions() == 1), "{fitting:?}");
        while robot.pose[0] < AT_M + WIDTH_M {
            robot.frame(&walls);
            let here = robot.course.path(0.0, robot.lateral_m, robot.heading_rad);
            assert!(here.slowing < 0.01 && robot.course.end().is_none(), "{fitting:?} at {:?}: {here:?}", robot.pose);
        }
    }
}

/// Behind a box that is passed the duct ends: the robot stands before its wall, whatever is left of the way back into the middle.
#[test]
fn the_end_of_a_duct_behind_a_thing_is_seen() {
    let thing = [[AT_M, -HALF_M], [AT_M + 0.25, -0.05]];
    for end_m in [AT_M + 0.9, AT_M + 1.1, AT_M + 1.6] {
        let mut walls = with_boxes(&[thing]);
        walls.push([[end_m, HALF_M], [end_m, -HALF_M]]);
        let mut robot = Robot::new(&[Turn::Stop]);
        let mut least_m = f64::INFINITY;
        let stopped = (0..1500).any(|_| {
            robot.frame(&walls);
            least_m = least_m.min(clearance_m(robot.pose, thing));
            robot.course.end().is_some()
        });
        assert!(stopped && least_m > 0.02, "{end_m}: {:?} {:?}, {least_m} m", robot.pose, robot.course.outlook());
        let left_m = end_m - robot.pose[0];
        assert!((0.19..0.32).contains(&left_m), "{end_m}: {left_m} m left, {:?}", robot.course.end());
    }
}

/// Into a leg of a wye and into branches with shoes, along the middle.
#[test]
fn wyes_and_shoed_branches_are_driven_into() {
    let legs = [30.0_f64, 45.0].map(|turn_deg| wye(turn_deg.to_radians(), 0.9 * WIDTH_M));
    let shoes = [(0.125, true), (0.125, false), (0.25, false)].map(|(shoe_m, is_near)| {
        let (walls, middle_m) = shoed(shoe_m, is_near);
        (walls, [middle_m, HALF_M, std::f64::consts::FRAC_PI_2])
    });
    for (index, (walls, [x, y, turn_rad])) in legs.into_iter().chain(shoes).enumerate() {
        let mut robot = Robot::new(&[Turn::Left]);
        let (sin, cos) = libm::sincos(turn_rad);
        // Along the middle behind it, and beside it.
        let behind = |robot: &Robot| {
            let (dx, dy) = (robot.pose[0] - x, robot.pose[1] - y);
            [cos * dx + sin * dy, cos * dy - sin * dx]
        };
        let arrived = robot.until(&walls, |robot| behind(robot)[0] > 1.8 && robot.pose[2] > 0.5 * turn_rad);
        assert!(arrived, "{index}: {:?} {:?} {:?}", robot.pose, robot.course.end(), robot.course.outlook());
        let [_, aside_m] = behind(&robot);
        assert!(aside_m.abs() < 0.015 && (robot.pose[2] - turn_rad).abs() < 0.03, "{index}: {aside_m} m aside, {:?}", robot.pose);
        assert_eq!(robot.course.junctions(), 1, "{index}");
    }
}

/// A wall before which it came to rest, and that turns out to stand farther off: it drives up to it, and the log has it there. (Over the
/// last metre it sees a wall half a metre nearer, which is gone when it stands.)
#[test]
fn what_turns_out_to_be_farther_off_is_driven_up_to() {
    let capped = |at_m: f64| vec![side_wall(HALF_M, 0.0, at_m), side_wall(-HALF_M, 0.0, at_m), across(at_m, -HALF_M, HALF_M)];
    let mut robot = Robot::new(&[]);
    let stands = |robot: &Robot| robot.course.end() == Some(End::DeadEnd);
    let stood = (0..900).any(|_| {
        let at_m = if robot.pose[0] > AT_M - 1.0 { AT_M - 0.5 } else { AT_M };
        robot.frame(&capped(at_m));
        stands(&robot)
    });
    assert!(stood && robot.pose[0] < AT_M - 0.5, "{:?}", robot.pose);
    assert!(robot.until(&capped(AT_M), |robot| !stands(robot)), "it stays at {:?}: {:?}", robot.pose, robot.course.outlook());
    assert!(robot.until(&capped(AT_M), stands), "{:?}", robot.pose);
    assert!((0.2..0.3).contains(&(AT_M - robot.pose[0])), "{:?}", robot.pose);
    let met: Vec<_> = robot.course.log().ducts()[0].met.iter().map(|met| (met.fitting, (met.at_m - AT_M).abs() < 0.05)).collect();
    assert_eq!(met, [(Fitting::DeadEnd, true)]);
}

/// A robot that believed to stand 0.25 rad askew, until the walls put it right: what it saw from there is forgotten, so that a dead end
/// is told at once again for what it is. Without that the rays of both places contradict each other.
#[test]
fn rays_of_a_place_that_was_wrong_are_forgotten() {
    let walls = plans().into_iter().find(|(own, _)| *own == Fitting::DeadEnd).expect("a plan").1;
    for off_rad in [-0.25, 0.25] {
        let mut course = Course::new(CourseParams { speed_m_s: 0.25, ..CourseParams::default() });
        course.advance(0.5);
        let mut seen = Vec::new();
        for step in 0..200 {
            let along_m = 0.5 + 0.01 * f64::from(step);
            let wrong_rad = if step < 100 { off_rad } else { 0.0 };
            if step == 100 {
                course.corrected(0.0, -off_rad);
            }
            let place = DuctPlace { along_m, lateral_m: 0.0, heading_rad: wrong_rad, width_m: WIDTH_M };
            let _ = course.look(&place, &scan(&walls, [along_m, 0.0, 0.0], 0.2));
            course.advance(0.01);
            seen.push((along_m, course.outlook().fitting, course.outlook().at_m));
        }
        let soon = &seen[125..];
        assert!(
            soon.iter().all(|(_, fitting, at_m)| *fitting == Fitting::DeadEnd && (at_m - AT_M).abs() < 0.03),
            "{off_rad}: {soon:?}"
        );
    }
}
