//! The reference path through a network, and where a point stands relative to it.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use crate::Transform;

/// A piece of the reference path: seen from above a line or an arc, rising or falling evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Pose of the segment's start: x along the path seen from above, y left, z *up*, also where the path is pitched.
    pub world_from_start: Transform,
    /// Length along the path, in metres.
    pub length_m: f64,
    /// Curvature seen from above, in 1/m: zero for a line, positive for a left turn.
    pub curvature_1_m: f64,
    /// By how much the path rises against the horizontal, in radians.
    pub pitch_rad: f64,
    /// Inside width of the duct at the start, in metres.
    pub width_m: f64,
    /// Inside height of the duct at the start, in metres.
    pub height_m: f64,
    /// Inside width at the end; between the two it changes evenly.
    pub end_width_m: f64,
    /// Inside height at the end.
    pub end_height_m: f64,
    /// Distance of the segment's start along the whole path, in metres.
    pub start_m: f64,
    /// Index of the fitting that it runs through.
    pub fitting: usize,
    /// Whether the path turns round on the spot where this segment starts: it leads back over what the one before went along.
    pub turns_back: bool,
}

/// Where a point stands relative to the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Index of the segment.
    pub segment: usize,
    /// Distance along the whole path, in metres. Before the start it is negative, past the end it goes on growing.
    pub distance_m: f64,
    /// Offset to the left of the path, in metres.
    pub lateral_m: f64,
    /// Direction of the path there: a unit vector in the world.
    pub forward: Vector3<f64>,
    /// Left of it: a unit vector in the world.
    pub left: Vector3<f64>,
}

/// The reference path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Centreline {
    /// Its pieces, each starting where the one before ends.
    pub segments: Vec<Segment>,
}

impl Segment {
    /// Pose at `along_m` from the segment's start: x along the path, pitched with it.
    pub fn pose_at(&self, along_m: f64) -> Transform {
        self.world_from_start * start_from_pitched(self.curvature_1_m, self.pitch_rad, along_m)
    }

    /// Inside width of the duct at `along_m`, in metres.
    pub fn width_at_m(&self, along_m: f64) -> f64 {
        self.between(along_m, self.width_m, self.end_width_m)
    }

    /// Inside height of the duct at `along_m`, in metres.
    pub fn height_at_m(&self, along_m: f64) -> f64 {
        self.between(along_m, self.height_m, self.end_height_m)
    }

    fn between(&self, along_m: f64, start: f64, end: f64) -> f64 {
        // Not computed where it is the same: rounding.
        if start == end { start } else { start + (end - start) * (along_m / self.length_m).clamp(0.0, 1.0) }
    }

    /// The first `length_m` of it.
    fn shortened(&self, length_m: f64) -> Self {
        Self { length_m, end_width_m: self.width_at_m(length_m), end_height_m: self.height_at_m(length_m), ..self.clone() }
    }

    /// The same piece of path, gone along the other way.
    fn reversed(&self) -> Self {
        let end = self.world_from_start * upright(start_from_pitched(self.curvature_1_m, self.pitch_rad, self.length_m));
        Self {
            world_from_start: end * half_turn(),
            curvature_1_m: 0.0 - self.curvature_1_m,
            pitch_rad: 0.0 - self.pitch_rad,
            width_m: self.end_width_m,
            height_m: self.end_height_m,
            end_width_m: self.width_m,
            end_height_m: self.height_m,
            turns_back: false,
            ..self.clone()
        }
    }

    /// (distance along this segment, lateral offset) of a point, both seen from above, not limited to the segment's own length.
    fn project(&self, point: &Point3<f64>) -> (f64, f64) {
        let p = self.world_from_start.inverse() * point;
        let (level_m, lateral_m) = project_level(self.curvature_1_m, self.length_m * libm::cos(self.pitch_rad), &p);
        if self.pitch_rad == 0.0 { (level_m, lateral_m) } else { (level_m / libm::cos(self.pitch_rad), lateral_m) }
    }
}

/// Distance along and offset from a level line or arc of this length that starts at the origin along x. Of an arc's circle, what is nearer
/// to its end than to its start is beyond it.
fn project_level(curvature_1_m: f64, length_m: f64, p: &Point3<f64>) -> (f64, f64) {
    if curvature_1_m == 0.0 {
        return (p.x, p.y);
    }
    // The arc's centre lies at y = radius, signed. Seen from there, measured from the start toward the path's direction:
    let radius = 1.0 / curvature_1_m;
    let side = radius.signum();
    let (dx, dy) = (p.x, radius - p.y);
    let seen = libm::atan2(dx, side * dy);
    let middle = length_m / radius.abs() / 2.0;
    let angle = if seen < middle - PI { seen + 2.0 * PI } else { seen };
    (angle * radius.abs(), side * (radius.abs() - (dx * dx + dy * dy).sqrt()))
}

/// Half a turn about z, exact.
pub(crate) fn half_turn() -> Transform {
    let rotation = nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(0.0, 0.0, 0.0, 1.0));
    Transform::from_parts(nalgebra::Translation3::identity(), rotation)
}

/// A pose that is turned about z and pitched, without the pitch: x stays where it points, seen from above.
fn upright(pose: Transform) -> Transform {
    let forward = pose.rotation * Vector3::x();
    Transform::from_parts(pose.translation, turn_about_z(libm::atan2(forward.y, forward.x)))
}

pub(crate) fn turn_about_z(angle_rad: f64) -> nalgebra::UnitQuaternion<f64> {
    let (half_s, half_c) = libm::sincos(angle_rad / 2.0);
    nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(half_c, 0.0, 0.0, half_s))
}

/// Pose at `along_m` on a line or arc that starts at the origin along x and rises evenly.
fn start_from_pitched(curvature_1_m: f64, pitch_rad: f64, along_m: f64) -> Transform {
    if pitch_rad == 0.0 {
        return start_from_along(curvature_1_m, along_m);
    }
    let (s, c) = libm::sincos(pitch_rad);
    let (half_s, half_c) = libm::sincos(pitch_rad / 2.0);
    let level = start_from_along(curvature_1_m, along_m * c);
    // Up is a negative turn about y.
    let nose_up = nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(half_c, 0.0, -half_s, 0.0));
    let translation = level.translation.vector + Vector3::new(0.0, 0.0, along_m * s);
    Transform::from_parts(translation.into(), level.rotation * nose_up)
}

/// Pose at `along_m` on a line or arc that starts at the origin along x.
pub fn start_from_along(curvature_1_m: f64, along_m: f64) -> Transform {
    let angle = curvature_1_m * along_m;
    let (s, c) = libm::sincos(angle);
    let translation =
        if curvature_1_m == 0.0 { Vector3::new(along_m, 0.0, 0.0) } else { Vector3::new(s, 1.0 - c, 0.0) / curvature_1_m };
    Transform::from_parts(translation.into(), turn_about_z(angle))
}

impl Centreline {
    /// Length of the whole path, in metres.
    pub fn length_m(&self) -> f64 {
        self.segments.last().map_or(0.0, |s| s.start_m + s.length_m)
    }

    /// The segment that holds this distance along the path; the first or last beyond the ends.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn segment_at(&self, distance_m: f64) -> &Segment {
        let next = self.segments.partition_point(|s| s.start_m <= distance_m);
        &self.segments[next.max(1) - 1]
    }

    /// Pose on the path at this distance along it.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn pose_at(&self, distance_m: f64) -> Transform {
        let segment = self.segment_at(distance_m);
        segment.pose_at(distance_m - segment.start_m)
    }

    /// The first segment that runs through this fitting; the path's first if none does.
    pub fn segment_of(&self, fitting: usize) -> usize {
        self.segments.iter().position(|segment| segment.fitting == fitting).unwrap_or(0)
    }

    /// Inside width and height of the duct at this distance along the path, in metres.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn section_at_m(&self, distance_m: f64) -> [f64; 2] {
        let segment = self.segment_at(distance_m);
        let along_m = distance_m - segment.start_m;
        [segment.width_at_m(along_m), segment.height_at_m(along_m)]
    }

    /// Where a point stands relative to the path, seen from above. The search starts at segment `near` and follows the path from
    /// there, so its cost does not grow with the network, and where the path comes by the same place again it stays on its own pass;
    /// a point must not move by more than a segment between two calls. Where the path turns back, the way back begins for a point
    /// that has come as far as the path goes, and a point past the turn stands before the start of the way back.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn project(&self, point: &Point3<f64>, near: usize) -> PathPoint {
        let mut index = near.min(self.segments.len() - 1);
        // Forward while past the end, then backward while before the start; never both, so it ends.
        while index + 1 < self.segments.len() && self.segments[index].project(point).0 > self.segments[index].length_m {
            index += 1;
        }
        while index > 0 && !self.segments[index].turns_back && self.segments[index].project(point).0 < 0.0 {
            index -= 1;
        }
        let segment = &self.segments[index];
        let (along, lateral_m) = segment.project(point);
        let pose = segment.pose_at(along);
        PathPoint {
            segment: index,
            distance_m: segment.start_m + along,
            lateral_m,
            forward: pose.rotation * Vector3::x(),
            left: pose.rotation * Vector3::y(),
        }
    }

    /// As [`Self::project`] for something that faces along `facing`, in the world: in a dead end it is on the way back as soon as it
    /// faces back, although it has not come as far as the path goes. What has been in the dead end (`farthest_m`, how far along the path it has
    /// come so far, is nearly the turn's place), has come out of it backwards and goes on from the junction before it is on the way out once
    /// it is outside the duct by which the path leads in.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn project_facing(&self, point: &Point3<f64>, facing: &Vector3<f64>, near: usize, farthest_m: f64) -> PathPoint {
        /// More than 120 degrees off the path's direction is facing back.
        const FACING_BACK: f64 = -0.5;
        let at = self.project(point, near);
        // First what costs least: looking for the way back goes along the path.
        let faces_back = at.forward.dot(facing) < FACING_BACK * facing.norm();
        let is_outside = at.lateral_m.abs() > self.section_at_m(at.distance_m)[0] / 2.0;
        let there = if faces_back {
            self.same_place_on_the_way_back(at.segment)
        } else if is_outside {
            self.holding_on_the_way_back(point, at.segment, farthest_m)
        } else {
            None
        };
        there.map_or(at, |segment| self.project(point, segment))
    }

    /// The first segment on the way back out of a dead end in which the point lies, if what is there has come nearly as far as the path goes
    /// in.
    fn holding_on_the_way_back(&self, point: &Point3<f64>, index: usize, farthest_m: f64) -> Option<usize> {
        /// Before a wall one turns back nearer to it or farther off than the path does.
        const NEARLY_M: f64 = 0.5;
        let turn = index + 1 + self.segments[index + 1..].iter().position(|segment| segment.turns_back)?;
        if farthest_m < self.segments[turn].start_m - NEARLY_M {
            return None;
        }
        let holds = |segment: &Segment| {
            let (along_m, lateral_m) = segment.project(point);
            (0.0..=segment.length_m).contains(&along_m) && lateral_m.abs() <= segment.width_at_m(along_m) / 2.0
        };
        (turn..self.segments.len()).find(|index| holds(&self.segments[*index]))
    }

    /// The segment on the way back out of a dead end that goes along the same piece of path as this one on the way in.
    fn same_place_on_the_way_back(&self, index: usize) -> Option<usize> {
        let turn = index + 1 + self.segments[index + 1..].iter().position(|segment| segment.turns_back)?;
        let back = turn + (turn - 1 - index);
        let (out, other) = (&self.segments[index], self.segments.get(back)?);
        (out.fitting == other.fitting && out.curvature_1_m == -other.curvature_1_m && out.length_m == other.length_m)
            .then_some(back)
    }

    /// Goes on with a segment; it starts where the path ends so far.
    pub(crate) fn push(&mut self, segment: Segment) {
        let start_m = self.length_m();
        self.segments.push(Segment { start_m, ..segment });
    }

    /// Ends the path `short_m` before where it ends, or midway between there and the start of segment `first` if that is less; then
    /// goes back along the same way to the start of segment `first`. Gives the index of the first segment on the way back.
    pub(crate) fn turn_back(&mut self, first: usize, short_m: f64) -> usize {
        let Some(first_m) = self.segments.get(first).map(|segment| segment.start_m) else { return first };
        let end_m = self.length_m() - short_m.min((self.length_m() - first_m) / 2.0);
        while self.segments.len() > first + 1 && self.segments.last().is_some_and(|last| last.start_m >= end_m) {
            self.segments.pop();
        }
        if let Some(last) = self.segments.last_mut() {
            *last = last.shortened(end_m - last.start_m);
        }
        let turn = self.segments.len();
        for index in (first..turn).rev() {
            let back = self.segments[index].reversed();
            self.push(Segment { turns_back: index + 1 == turn, ..back });
        }
        turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(curvature_1_m: f64) -> Segment {
        Segment {
            world_from_start: Transform::identity(),
            length_m: 1.0,
            curvature_1_m,
            pitch_rad: 0.0,
            width_m: 0.5,
            height_m: 0.3,
            end_width_m: 0.5,
            end_height_m: 0.3,
            start_m: 0.0,
            fitting: 0,
            turns_back: false,
        }
    }

    #[test]
    fn a_point_offset_from_a_pose_on_the_path_projects_back_to_it() {
        for curvature in [0.0, 1.6, -1.6, 0.3] {
            let segment = arc(curvature);
            for along in [0.0, 0.2, 0.7] {
                for lateral in [-0.2, 0.0, 0.1] {
                    let point = segment.pose_at(along) * Point3::new(0.0, lateral, 0.04);
                    let (s, y) = segment.project(&point);
                    assert!((s - along).abs() < 1e-12 && (y - lateral).abs() < 1e-12, "{curvature} {along} {lateral}: {s} {y}");
                }
            }
        }
    }

    /// A point right behind half a circle is beyond its end, though it lies beside its start.
    #[test]
    fn half_a_circle_goes_on_beyond_its_end() {
        for curvature in [1.6, -1.6] {
            let half = Segment { length_m: PI / 1.6, ..arc(curvature) };
            let path = Centreline {
                segments: vec![
                    half.clone(),
                    Segment { world_from_start: half.pose_at(half.length_m), start_m: half.length_m, ..arc(0.0) },
                ],
            };
            for near in 0..2 {
                let at = path.project(&(path.pose_at(half.length_m + 0.3) * Point3::new(0.0, 0.02, 0.0)), near);
                assert_eq!(at.segment, 1);
                assert!((at.distance_m - half.length_m - 0.3).abs() < 1e-9 && (at.lateral_m - 0.02).abs() < 1e-9, "{at:?}");
            }
            let before = half.project(&Point3::new(-0.1, 0.0, 0.0));
            assert!(before.0 < 0.0 && before.0 > -0.2, "{before:?}");
        }
    }

    #[test]
    fn the_search_follows_the_path_both_ways() {
        let segment = |start_m: f64| Segment {
            world_from_start: Transform::translation(start_m, 0.0, 0.0),
            curvature_1_m: 0.0,
            start_m,
            ..arc(0.0)
        };
        let path = Centreline { segments: vec![segment(0.0), segment(1.0), segment(2.0)] };
        for near in 0..3 {
            let at = path.project(&Point3::new(1.4, 0.1, 0.0), near);
            assert_eq!((at.segment, at.lateral_m), (1, 0.1));
            assert!((at.distance_m - 1.4).abs() < 1e-12);
        }
    }

    #[test]
    fn a_left_arc_ends_to_the_left() {
        let quarter = arc(std::f64::consts::FRAC_PI_2).pose_at(1.0);
        let radius = 1.0 / std::f64::consts::FRAC_PI_2;
        assert!((quarter.translation.vector - Vector3::new(radius, radius, 0.0)).norm() < 1e-12);
        assert!((quarter.rotation * Vector3::x() - Vector3::y()).norm() < 1e-12);
    }
}
