//! Where the robot stands in each frame.

use std::fmt;

use ductloop_duct::Transform;
use ductloop_duct::centreline::Centreline;
use ductloop_nav::angle::rotation_about_z;
use nalgebra::{Translation3, Vector3};

use crate::scenario::Scenario;
use crate::scenario::accuracy_file::Poses;
use crate::stream::uniform;

/// A pose of the base in the duct, and how wide the duct is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Distance along the centreline, in metres.
    pub distance_m: f64,
    /// Offset from the centreline, left positive, in metres.
    pub lateral_m: f64,
    /// Heading against the centreline, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Width of the duct, in metres.
    pub width_m: f64,
}

/// What is drawn for a pose; each has random numbers of its own.
#[derive(Clone, Copy)]
enum Draw {
    Distance,
    Heading,
    Lateral,
    Width,
    LeftWall,
    RightWall,
}

impl Pose {
    /// Pose number `index`: what `poses` draws, the rest as the scenario starts. The same in every cell of a grid, as far as the
    /// scenarios agree, so that cells differ by what they are and not by their draws.
    pub fn draw(scenario: &Scenario, poses: &Poses, seed: u64, index: u64) -> Self {
        let value =
            |range: Option<[f64; 2]>, what: Draw| range.map(|[from, to]| from + (to - from) * uniform(seed, index, what as u64));
        let start = &scenario.start;
        let distance_m = value(poses.distance_m, Draw::Distance).unwrap_or(start.distance_m);
        let heading_rad = value(poses.heading_rad, Draw::Heading).unwrap_or(start.heading_rad);
        let walls = value(poses.wall_m, Draw::LeftWall).zip(value(poses.wall_m, Draw::RightWall));
        if let Some((left_m, right_m)) = walls {
            // The camera stands ahead of the base, so it moves sideways as the robot turns.
            let camera = rotation_about_z(heading_rad) * scenario.actual_rig().mount.position_in_base_m.coords;
            let lateral_m = (right_m - left_m) / 2.0 - camera.y;
            return Self { distance_m, lateral_m, heading_rad, width_m: left_m + right_m };
        }
        Self {
            distance_m,
            lateral_m: value(poses.lateral_m, Draw::Lateral).unwrap_or(start.lateral_m),
            heading_rad,
            width_m: value(poses.width_m, Draw::Width).unwrap_or(scenario.duct.width_m),
        }
    }

    /// The scenario in a duct of this pose's width. What the navigator is told of the width stays as far off as it was.
    pub fn scenario(&self, scenario: &Scenario) -> Scenario {
        let mut own = scenario.clone();
        own.navigation.width_m += self.width_m - own.duct.width_m;
        own.navigation.fixed_width_m = own.navigation.fixed_width_m.map(|_| own.navigation.width_m);
        own.duct.width_m = self.width_m;
        own
    }

    /// The base in the world, beside this centreline.
    pub fn world_from_base(&self, centreline: &Centreline) -> Transform {
        let beside = Translation3::from(Vector3::new(0.0, self.lateral_m, 0.0));
        let turned = rotation_about_z(self.heading_rad);
        centreline.pose_at(self.distance_m) * Transform::from_parts(beside, turned.into())
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { distance_m, lateral_m, heading_rad, width_m } = self;
        let heading_deg = heading_rad.to_degrees();
        write!(
            f,
            "distance {distance_m:.3} m, lateral offset {lateral_m:.3} m, heading {heading_deg:.2} deg, duct {width_m:.3} m wide"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario() -> Scenario {
        Scenario::from_toml_str(
            "format = 1\nkind = \"scenario\"\nname = \"x\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 8.0 }]\n",
        )
        .unwrap()
    }

    #[test]
    fn walls_are_as_far_from_the_camera_as_was_drawn() {
        let poses = Poses {
            count: 100,
            wall_m: Some([0.15, 0.5]),
            width_m: None,
            lateral_m: None,
            heading_rad: Some([-0.1, 0.1]),
            distance_m: None,
        };
        let scenario = scenario();
        let mut seen = [f64::INFINITY, 0.0_f64];
        for index in 0..poses.count {
            let pose = Pose::draw(&scenario, &poses, 7, index);
            let own = pose.scenario(&scenario);
            assert!(own.validate().is_ok() && own.navigation.width_m == pose.width_m);
            let base = pose.world_from_base(&own.duct.network().unwrap().centreline);
            let camera = base * own.rig.mount.position_in_base_m;
            for distance in [pose.width_m / 2.0 - camera.y, pose.width_m / 2.0 + camera.y] {
                assert!((0.15 - 1e-12..=0.5 + 1e-12).contains(&distance), "{pose:?}: {distance}");
                seen = [seen[0].min(distance), seen[1].max(distance)];
            }
        }
        assert!(seen[0] < 0.17 && seen[1] > 0.48, "{seen:?}");
    }

    #[test]
    fn numbers_fill_their_range_evenly() {
        const COUNT: u64 = 4000;
        for stream in 0..3 {
            let mean = (0..COUNT).map(|i| uniform(3, i, stream)).sum::<f64>() / COUNT as f64;
            // Five standard deviations of a mean of so many: 5 / sqrt(12 * 4000).
            assert!((mean - 0.5).abs() < 0.023, "{mean}");
        }
        assert_ne!(uniform(3, 5, 0), uniform(3, 5, 1));
        assert_ne!(uniform(3, 5, 0), uniform(4, 5, 0));
    }
}
