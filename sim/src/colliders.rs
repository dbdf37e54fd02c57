//! A network's floor, walls and solids as fixed Rapier colliders.

use std::collections::BTreeSet;

use rapier3d::prelude::{ActiveHooks, CoefficientCombineRule, ColliderBuilder, ColliderSet, SharedShape};

use crate::chassis::{BODY, FLANK, FLOOR, TREAD, WALL, groups};
use crate::convert;
use crate::walls::Walls;

/// Inserts one half-space for all floors and a convex collider for each slab and solid.
///
/// A slab's user data is its place among all slabs, from 1, as [`SeamFilter`](crate::seams::SeamFilter) numbers them. Friction is
/// that of what touches them: theirs is 1, and coefficients multiply.
pub fn insert(walls: &Walls, colliders: &mut ColliderSet) {
    let up = -convert::vector(&walls.floor.normal);
    let floor = ColliderBuilder::new(SharedShape::halfspace(up))
        .translation(up * -walls.floor.offset_m)
        .friction(1.0)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .collision_groups(groups(FLOOR, TREAD | BODY));
    colliders.insert(floor);
    let mut solids = BTreeSet::new();
    let mut sheets = 0;
    for obstacle in walls.of_cell.iter().flatten() {
        // A solid that reaches into several cells is listed with each, and must not push twice.
        let centre = obstacle.centre.coords.map(f64::to_bits);
        if obstacle.sheet.is_none() && !solids.insert([centre.x, centre.y, centre.z, obstacle.radius_m.to_bits()]) {
            continue;
        }
        let mut wall = ColliderBuilder::new(obstacle.shape.clone())
            .friction(1.0)
            .friction_combine_rule(CoefficientCombineRule::Multiply)
            .collision_groups(groups(WALL, FLANK | BODY));
        if obstacle.sheet.is_some() {
            sheets += 1;
            wall = wall.user_data(sheets).active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
        colliders.insert(wall);
    }
}
