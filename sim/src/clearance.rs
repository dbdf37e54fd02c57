//! How far the robot's outline is from the nearest wall, ceiling or solid.

use ductloop_duct::Transform;
use ductloop_duct::cell::{Beyond, CellId, FaceKind, Solid};
use ductloop_duct::network::Network;
use nalgebra::Point3;
use rapier3d::math::Pose;
use rapier3d::parry::query;

use crate::convert;
use crate::outline::{self, Part};
use crate::spec::RobotSpec;
use crate::walls::{Obstacle, Walls, solid_obstacle};

/// The robot's outline, and how far it reaches from the base's origin.
pub struct Outline {
    parts: Vec<Part>,
    reach_m: f64,
}

impl Outline {
    /// The outline of a robot: chassis box, mast, wheel cylinders.
    pub fn new(robot: &RobotSpec) -> Self {
        let parts: Vec<Part> = outline::body(robot).into_iter().chain(outline::wheels(robot)).collect();
        let reach_m = parts
            .iter()
            .map(|part| part.shape.compute_bounding_sphere(&convert::pose(&part.base_from_part)))
            .map(|sphere| sphere.center().length() + sphere.radius())
            .fold(0.0, f64::max);
        Self { parts, reach_m }
    }

    /// How far the robot reaches from its base's origin, in metres.
    pub fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// Smallest distance from the robot to one solid, in metres; zero when it touches. Infinite for a solid without volume.
    pub fn distance_to_solid_m(&self, solid: &Solid, world_from_base: &Transform) -> f64 {
        let Some(obstacle) = solid_obstacle(solid) else { return f64::INFINITY };
        let distances_m = self.parts.iter().map(|part| {
            let pose = convert::pose(&(world_from_base * part.base_from_part));
            distance_m(part, &pose, &obstacle, f64::INFINITY)
        });
        distances_m.fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// Smallest distance from the robot to a wall, ceiling or solid, in metres; zero when it touches. Floors and portals do not
    /// count. `cell` holds the robot's base; cells are searched from there through portals, as far as something nearer than
    /// what was found could stand. Infinite only where there is nothing to touch.
    pub fn clearance_m(&self, network: &Network, walls: &Walls, cell: CellId, world_from_base: &Transform) -> f64 {
        let base = Point3::from(world_from_base.translation.vector);
        let poses: Vec<Pose> = self.parts.iter().map(|part| convert::pose(&(world_from_base * part.base_from_part))).collect();
        let mut nearest_m = f64::INFINITY;
        let mut seen = vec![cell];
        let mut next = 0;
        while let Some(&id) = seen.get(next) {
            next += 1;
            for obstacle in &walls.of_cell[id] {
                if (obstacle.centre - base).norm() - obstacle.radius_m - self.reach_m < nearest_m {
                    for (part, pose) in self.parts.iter().zip(&poses) {
                        nearest_m = nearest_m.min(distance_m(part, pose, obstacle, nearest_m));
                    }
                }
            }
            // Into a shaft below a floor there is no way down but for a robot in it, which then starts there.
            for face in network.cells[id].faces.iter().filter(|face| face.kind != FaceKind::Floor) {
                // Beyond this plane nothing is nearer than the plane itself.
                if -face.plane.distance(&base) - self.reach_m > nearest_m {
                    continue;
                }
                for portal in &face.portals {
                    if let Beyond::Cell(beyond) = portal.beyond
                        && !seen.contains(&beyond)
                    {
                        seen.push(beyond);
                    }
                }
            }
        }
        nearest_m.max(0.0)
    }
}

/// Distance of a part from an obstacle, or any larger number than `nearest_m` if it is not below that.
fn distance_m(part: &Part, pose: &Pose, obstacle: &Obstacle, nearest_m: f64) -> f64 {
    let mut at_least_m = 0.0;
    if let (Some(sheet), Some(map)) = (&obstacle.sheet, part.shape.as_support_map()) {
        // The distance of the part's extreme point from the plane bounds the distance from below, and is it where the foot
        // lies within the sheet.
        let extreme = convert::from_vector(map.support_point(pose, convert::vector(&sheet.plane.normal))).into();
        at_least_m = -sheet.plane.distance(&extreme);
        if at_least_m >= nearest_m || sheet.covers(&extreme) {
            return at_least_m;
        }
    }
    // Both kinds of shape are support maps, which have a distance.
    let apart = query::distance(pose, &*part.shape, &Pose::IDENTITY, &*obstacle.shape);
    apart.map_or(f64::INFINITY, |d| d.distance.max(at_least_m))
}
