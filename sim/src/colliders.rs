//! A network's floor, walls and solids as fixed Rapier colliders.

use std::collections::BTreeSet;

use ductloop_duct::cell::Plane;
use rapier3d::prelude::{
    ActiveHooks, CoefficientCombineRule, ColliderBuilder, ColliderHandle, ColliderSet, InteractionGroups, SharedShape,
};

use crate::chassis::{BODY, FLANK, FLOOR, TREAD, WALL, groups};
use crate::contact_rules::FLOOR_MARK;
use crate::convert;
use crate::walls::{Obstacle, Walls};

/// Inserts a half-space for each plane of floors and a convex collider for each slab and solid; gives the planes' colliders.
///
/// A slab's user data is its place among all slabs, from 1, as [`SeamFilter`](crate::seams::SeamFilter) numbers them; a plane's is its
/// number above [`FLOOR_MARK`]. Friction is that of what touches them: theirs is 1, and coefficients multiply.
///
/// Where there are several planes, or holes, they are for wheels only, and disabled: a half-space is near everything, so only those
/// of floors near the robot may be enabled.
pub fn insert(walls: &Walls, colliders: &mut ColliderSet) -> Vec<ColliderHandle> {
    let plain = walls.floors.are_plain();
    let floors = walls.floors.planes.iter().enumerate().map(|(index, plane)| {
        let floor = half_space(plane);
        colliders.insert(if plain {
            floor.collision_groups(groups(FLOOR, TREAD | BODY))
        } else {
            floor
                .collision_groups(groups(FLOOR, TREAD))
                .user_data(FLOOR_MARK + index as u128)
                .active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS)
                .enabled(false)
        })
    });
    let floors = floors.collect();
    let mut solids = BTreeSet::new();
    let mut sheets = 0;
    let mut insert = |obstacle: &Obstacle, met_by: InteractionGroups| {
        // A solid that reaches into several cells is listed with each, and must not push twice.
        let centre = obstacle.centre.coords.map(f64::to_bits);
        if obstacle.sheet.is_none() && !solids.insert([centre.x, centre.y, centre.z, obstacle.radius_m.to_bits()]) {
            return;
        }
        let mut wall = fixed(obstacle.shape.clone()).collision_groups(met_by);
        if obstacle.sheet.is_some() {
            sheets += 1;
            wall = wall.user_data(sheets).active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
        colliders.insert(wall);
    };
    for obstacle in walls.of_cell.iter().flatten() {
        insert(obstacle, groups(WALL, FLANK | BODY));
    }
    for obstacle in walls.floor_slabs.iter().flatten() {
        insert(obstacle, groups(FLOOR, BODY));
    }
    floors
}

fn half_space(plane: &Plane) -> ColliderBuilder {
    let up = -convert::vector(&plane.normal);
    fixed(SharedShape::halfspace(up)).translation(up * -plane.offset_m)
}

fn fixed(shape: SharedShape) -> ColliderBuilder {
    ColliderBuilder::new(shape).friction(1.0).friction_combine_rule(CoefficientCombineRule::Multiply)
}
