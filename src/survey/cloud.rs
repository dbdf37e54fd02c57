//! The lit points of a run in the world, from believed poses.
//!
//! Of each voxel of 10 mm one point is kept, the first: memory grows with what was seen, not with the time that it took. Voxels are in a
//! tree, so their order is that of their places. Where two stripes cross, a frame may take one laser's light for another's, and its points lie
//! on no surface. The next frame, from elsewhere, does not show them again: points count where several frames lit their surroundings.

use std::collections::BTreeMap;

use ductloop_duct::Transform;
use ductloop_nav::angle::rotation_about_z;
use ductloop_nav::mapping::floor::THINNEST_M;
use ductloop_nav::mapping::{Closure, Deposit};
use ductloop_nav::navigator::Report;
use ductloop_nav::perception::{RangePoint, Upon};
use ductloop_nav::planar::{compose, inverse};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::notes::Notes;

/// Edge of a voxel, in metres.
pub const VOXEL_M: f64 = 0.01;
/// Edge of the cubes that are a point's surroundings, in metres, and the frames that must have lit one.
const AROUND_M: f64 = 0.05;
const FEWEST_FRAMES: u32 = 6;
/// A point this near to a side wall's line is that wall's, in metres.
const ON_WALL_M: f64 = 0.04;
/// Points farther from the base, seen from above, are left out, in metres: at 1.5 m a range is good for 20 mm.
const FARTHEST_M: f64 = 1.5;

/// What a point is on, as far as the robot can tell. Of two verdicts on a voxel the greater holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Beyond the lines of the walls: seen through an opening, or in a bend.
    Beyond,
    /// Between the walls: what stands in the duct or across it, and the ceiling.
    Inside,
    /// A side wall of a duct, by the duct's number in the log.
    Wall(usize),
    /// The floor.
    Floor,
    /// What lies on the floor.
    Deposit,
}

/// Where the robot believes to stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// In the frame of the first duct: along, left, heading.
    pub pose: [f64; 3],
    /// The duct's number in the log.
    pub duct: usize,
    /// Offset to the left of the duct's middle, in metres, heading, in radians, and width, in metres; `None` where nothing estimates them.
    pub in_duct: Option<[f64; 3]>,
}

/// A point and what it is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Where, in the world, in metres.
    pub in_world_m: [f32; 3],
    /// On what.
    pub class: Class,
    /// From which duct it was seen, by the duct's number in the log.
    pub duct: usize,
}

/// The points.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    world_from_first: Transform,
    points: BTreeMap<[i32; 3], CloudPoint>,
    /// Of each cube: the last frame that lit it, and how many did.
    lit: BTreeMap<[i32; 3], (u64, u32)>,
    frames: u64,
}

impl Standing {
    /// As the navigator reports it.
    pub fn of(report: &Report<'_>, pose: [f64; 3]) -> Self {
        let in_duct = report.estimate.map(|estimate| [estimate.lateral_m, estimate.heading_rad, estimate.width_m]);
        Self { pose, duct: report.ducts.len().saturating_sub(1), in_duct }
    }

    /// What a point of the base frame is on.
    fn class(&self, point: &RangePoint) -> Class {
        if point.upon == Upon::Floor {
            return Class::Floor;
        }
        let Some([lateral_m, heading_rad, width_m]) = self.in_duct else { return Class::Inside };
        let (sin, cos) = libm::sincos(heading_rad);
        let aside_m = (lateral_m + sin * point.point_in_base.x + cos * point.point_in_base.y).abs() - width_m / 2.0;
        if aside_m > ON_WALL_M {
            Class::Beyond
        } else if aside_m < -ON_WALL_M {
            Class::Inside
        } else {
            Class::Wall(self.duct)
        }
    }
}

impl Cloud {
    /// An empty one. `world_from_first` is the frame of the first duct: where the run began, on the middle of the duct.
    pub fn new(world_from_first: Transform) -> Self {
        Self { world_from_first, points: BTreeMap::new(), lit: BTreeMap::new(), frames: 0 }
    }

    /// Takes in the lit points of a frame.
    pub fn add(&mut self, standing: &Standing, ranges: &[RangePoint]) {
        let world_from_base = world_from_believed(&self.world_from_first, standing.pose);
        self.frames += 1;
        let is_lit = |point: &&RangePoint| matches!(point.upon, Upon::Floor | Upon::Upright);
        let is_near = |point: &&RangePoint| point.point_in_base.coords.xy().norm() <= FARTHEST_M;
        for point in ranges.iter().filter(is_lit).filter(is_near) {
            let class = standing.class(point);
            let place = world_from_base * point.point_in_base;
            let kept = self.points.entry(cube(&place, VOXEL_M)).or_insert(CloudPoint {
                in_world_m: single(&place),
                class,
                duct: standing.duct,
            });
            kept.class = kept.class.max(class);
            let (last, count) = self.lit.entry(cube(&place, AROUND_M)).or_insert((0, 0));
            if *last < self.frames {
                (*last, *count) = (self.frames, count.saturating_add(1));
            }
        }
    }

    /// The points that count, in the order of their voxels, as they are delivered: those on deposits are so called, and each is moved with
    /// its duct where loops were closed.
    pub fn surveyed(&self, notes: &Notes, closure: &Closure, deposits: &[Deposit]) -> Vec<CloudPoint> {
        self.points().map(|point| self.delivered(point, notes, closure, deposits)).collect()
    }

    fn delivered(&self, point: &CloudPoint, notes: &Notes, closure: &Closure, deposits: &[Deposit]) -> CloudPoint {
        let Some(duct) = notes.ducts.get(point.duct) else { return *point };
        let in_first = self.world_from_first.inverse_transform_point(&Point3::from(point.in_world_m.map(f64::from)));
        let [along_m, left_m, _] = compose(inverse(duct.first_from_duct), [in_first.x, in_first.y, 0.0]);
        let is_within = |[from_m, to_m]: [f64; 2], at_m: f64| (from_m..=to_m).contains(&at_m);
        let lies_on = |deposit: &Deposit| {
            let is_high = is_within([THINNEST_M, 2.0 * deposit.largest_m], in_first.z);
            deposit.duct == point.duct && is_high && is_within(deposit.along_m, along_m) && is_within(deposit.left_m, left_m)
        };
        let is_deposit = matches!(point.class, Class::Floor | Class::Inside) && deposits.iter().any(lies_on);
        let class = if is_deposit { Class::Deposit } else { point.class };
        if closure.loops.is_empty() {
            return CloudPoint { class, ..*point };
        }
        let [x, y, _] = notes.moved(closure, point.duct, [in_first.x, in_first.y, 0.0]);
        let in_world_m = single(&(self.world_from_first * Point3::new(x, y, in_first.z)));
        CloudPoint { in_world_m, class, ..*point }
    }

    /// The points that count, in the order of their voxels.
    pub fn points(&self) -> impl Iterator<Item = &CloudPoint> {
        let is_lit = |point: &&CloudPoint| {
            let place = Point3::from(point.in_world_m.map(f64::from));
            self.lit.get(&cube(&place, AROUND_M)).is_some_and(|(_, count)| *count >= FEWEST_FRAMES)
        };
        self.points.values().filter(is_lit)
    }
}

/// Pose of the base in the world, from what is believed in the frame of the first duct. The robot believes that floors are level.
pub fn world_from_believed(world_from_first: &Transform, [along_m, left_m, heading_rad]: [f64; 3]) -> Transform {
    let heading = UnitQuaternion::from(rotation_about_z(heading_rad));
    world_from_first * Isometry3::from_parts(Vector3::new(along_m, left_m, 0.0).into(), heading)
}

/// The cube of this edge that holds a place, by its number along each axis.
fn cube(place: &Point3<f64>, edge_m: f64) -> [i32; 3] {
    [place.x, place.y, place.z].map(|x| libm::floor(x / edge_m) as i32)
}

fn single(place: &Point3<f64>) -> [f32; 3] {
    [place.x as f32, place.y as f32, place.z as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, z: f64, upon: Upon) -> RangePoint {
        RangePoint { point_in_base: Point3::new(x, y, z), laser: 0, block: 0, upon }
    }

    #[test]
    fn a_voxel_keeps_its_first_point_and_the_best_verdict_on_it() {
        let mut cloud = Cloud::new(Transform::identity());
        let standing = |duct, width_m| Standing { pose: [1.0, 0.0, 0.0], duct, in_duct: Some([0.0, 0.0, width_m]) };
        // 0.245 m to the left: inside a duct of 0.7 m, on the wall of one of 0.5 m.
        cloud.add(&standing(0, 0.7), &[point(0.501, 0.245, 0.101, Upon::Upright)]);
        (0..FEWEST_FRAMES).for_each(|_| cloud.add(&standing(0, 0.7), &[point(0.501, 0.245, 0.101, Upon::Upright)]));
        cloud.add(&standing(1, 0.5), &[point(0.502, 0.246, 0.102, Upon::Upright)]);
        cloud.add(&standing(0, 0.3), &[point(0.503, 0.246, 0.102, Upon::Upright)]);
        let kept: Vec<_> = cloud.points().copied().collect();
        assert_eq!(kept, [CloudPoint { in_world_m: [1.501, 0.245, 0.101], class: Class::Wall(1), duct: 0 }]);
    }

    #[test]
    fn what_is_no_light_and_what_is_far_is_left_out() {
        let mut cloud = Cloud::new(Transform::identity());
        let standing = Standing { pose: [0.0; 3], duct: 0, in_duct: None };
        cloud.add(
            &standing,
            &[point(0.5, 0.0, 0.0, Upon::Air), point(0.5, 0.1, 0.0, Upon::Nothing), point(2.0, 0.0, 0.0, Upon::Floor)],
        );
        assert!(cloud.points.is_empty());
        let floor = [point(0.512, 0.012, 0.002, Upon::Floor), point(0.513, 0.013, 0.003, Upon::Floor)];
        // Once is not enough, however many points.
        (1..FEWEST_FRAMES).for_each(|_| cloud.add(&standing, &floor));
        assert_eq!((cloud.points.len(), cloud.points().count()), (1, 0));
        cloud.add(&standing, &floor);
        assert_eq!((cloud.points.len(), cloud.points().count()), (1, 1));
    }

    /// Half a metre ahead of a robot that stands at (1, 2) and looks to the left of the first duct, which runs along world y.
    #[test]
    fn points_go_from_the_base_into_the_world() {
        let quarter = UnitQuaternion::from(rotation_about_z(std::f64::consts::FRAC_PI_2));
        let mut cloud = Cloud::new(Isometry3::from_parts(Vector3::new(10.0, 0.0, 0.0).into(), quarter));
        let standing = Standing { pose: [1.0, 2.0, std::f64::consts::FRAC_PI_2], duct: 0, in_duct: None };
        cloud.add(&standing, &[point(0.5, 0.0, 0.1, Upon::Upright)]);
        let [at] = cloud.points.values().map(|point| point.in_world_m).collect::<Vec<_>>()[..] else { panic!("one point") };
        assert!((at[0] - 7.5).abs() < 1e-5 && (at[1] - 1.0).abs() < 1e-5 && (at[2] - 0.1).abs() < 1e-6, "{at:?}");
    }
}
