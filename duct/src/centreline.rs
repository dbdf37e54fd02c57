//! The reference path through a network, and where a point stands relative to it.

use nalgebra::{Point3, Vector3};

use crate::Transform;

/// A piece of the reference path: a line or an arc in the xy plane of its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Pose of the segment's start: x along the path, y left, z up.
    pub world_from_start: Transform,
    /// Length along the path, in metres.
    pub length_m: f64,
    /// Curvature, in 1/m: zero for a line, positive for a left turn.
    pub curvature_1_m: f64,
    /// Inside width of the duct, in metres.
    pub width_m: f64,
    /// Inside height of the duct, in metres.
    pub height_m: f64,
    /// Distance of the segment's start along the whole path, in metres.
    pub start_m: f64,
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
    /// Pose at `along_m` from the segment's start.
    pub fn pose_at(&self, along_m: f64) -> Transform {
        self.world_from_start * start_from_along(self.curvature_1_m, along_m)
    }

    /// (distance along this segment, lateral offset) of a point, not limited to the segment's own length.
    fn project(&self, point: &Point3<f64>) -> (f64, f64) {
        let p = self.world_from_start.inverse() * point;
        if self.curvature_1_m == 0.0 {
            return (p.x, p.y);
        }
        // The arc's centre lies at y = radius, signed. Seen from there, measured from the start toward the path's direction:
        let radius = 1.0 / self.curvature_1_m;
        let side = radius.signum();
        let (dx, dy) = (p.x, radius - p.y);
        let angle = libm::atan2(dx, side * dy);
        (angle * radius.abs(), side * (radius.abs() - (dx * dx + dy * dy).sqrt()))
    }
}

/// Pose at `along_m` on a line or arc that starts at the origin along x.
pub fn start_from_along(curvature_1_m: f64, along_m: f64) -> Transform {
    let angle = curvature_1_m * along_m;
    let (s, c) = libm::sincos(angle);
    let translation =
        if curvature_1_m == 0.0 { Vector3::new(along_m, 0.0, 0.0) } else { Vector3::new(s, 1.0 - c, 0.0) / curvature_1_m };
    let (half_s, half_c) = libm::sincos(angle / 2.0);
    let rotation = nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(half_c, 0.0, 0.0, half_s));
    Transform::from_parts(translation.into(), rotation)
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

    /// Where a point stands relative to the path. The search starts at segment `near` and follows the path from there, so its
    /// cost does not grow with the network; a point must not move by more than a segment between two calls.
    ///
    /// # Panics
    /// If the path has no segments.
    pub fn project(&self, point: &Point3<f64>, near: usize) -> PathPoint {
        let mut index = near.min(self.segments.len() - 1);
        // Forward while past the end, then backward while before the start; never both, so it ends.
        while index + 1 < self.segments.len() && self.segments[index].project(point).0 > self.segments[index].length_m {
            index += 1;
        }
        while index > 0 && self.segments[index].project(point).0 < 0.0 {
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(curvature_1_m: f64) -> Segment {
        Segment {
            world_from_start: Transform::identity(),
            length_m: 1.0,
            curvature_1_m,
            width_m: 0.5,
            height_m: 0.3,
            start_m: 0.0,
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
