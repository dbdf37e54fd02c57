//! Where a camera can be: in the duct, and off its walls.
//!
//! Nothing nearer than a millimetre is drawn (the near plane of the graphics engine), so a camera against a wall would look through it
//! into the dark. It is refused instead.

use ductloop_duct::cell::{CellId, Plane};
use nalgebra::Point3;

use crate::scenery::{Room, Scenery};

/// Free space about a camera's centre, in metres: twice the distance of the near plane.
pub const CLEAR_M: f64 = 2e-3;

/// What rounding may take from a distance, in metres: as much as makes a point belong to a cell.
const ROUNDING_M: f64 = 1e-9;

/// Why a camera cannot be at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// It is outside the duct.
    Outside,
    /// It is less than [`CLEAR_M`] from the metal of a wall or of a body, or inside a body.
    Metal,
}

/// The cell of a camera at this point (world), looked for from `near`.
///
/// # Errors
/// Outside the network, inside a body, and less than [`CLEAR_M`] from metal. Portals are no walls.
pub fn clear_cell(scenery: &Scenery, centre: &Point3<f64>, near: CellId) -> Result<CellId, Obstacle> {
    let cell = scenery.cell_at(centre, near).ok_or(Obstacle::Outside)?;
    let room = &scenery.rooms[cell];
    // What borders an opening may be a wall of the cell beyond.
    let mut beyond = room.openings.iter().filter(|opening| is_near(&opening.plane, &opening.outline, centre));
    let is_free =
        is_clear(scenery, room, centre) && beyond.all(|opening| is_clear(scenery, &scenery.rooms[opening.beyond], centre));
    if is_free { Ok(cell) } else { Err(Obstacle::Metal) }
}

/// Whether a room's metal leaves the camera free.
fn is_clear(scenery: &Scenery, room: &Room, centre: &Point3<f64>) -> bool {
    let is_within = |body: &usize| scenery.bodies[*body].planes.iter().all(|plane| plane.distance(centre) <= 0.0);
    !room.sheets.iter().any(|sheet| is_near(&sheet.plane, &sheet.outline, centre)) && !room.bodies.iter().any(is_within)
}

/// Whether a point is less than [`CLEAR_M`] from a convex polygon in `plane`.
fn is_near(plane: &Plane, outline: &[Point3<f64>], point: &Point3<f64>) -> bool {
    let limit_m = CLEAR_M - ROUNDING_M;
    let off_m = plane.distance(point);
    if off_m.abs() >= limit_m {
        return false;
    }
    let foot = point - plane.normal.into_inner() * off_m;
    let Some(last) = outline.last() else { return false };
    let (mut is_left, mut is_right) = (false, false);
    let mut from = last;
    for to in outline {
        let (edge, reach) = (to - from, foot - from);
        let side = edge.cross(&reach).dot(&plane.normal);
        is_left |= side > 0.0;
        is_right |= side < 0.0;
        // The edge's point next to the foot; of an edge without length its corner.
        let length2 = edge.norm_squared();
        let along = if length2 > 0.0 { (edge.dot(&reach) / length2).clamp(0.0, 1.0) } else { 0.0 };
        if (point - (from + edge * along)).norm() < limit_m {
            return true;
        }
        from = to;
    }
    // Over its inside the foot is on one side of all edges, whichever way round they run.
    !(is_left && is_right)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// A square of 20 mm in the plane z = 0, both ways round.
    #[test]
    fn a_polygon_is_near_over_its_inside_and_about_its_edge() {
        let plane = Plane { normal: Vector3::z_axis(), offset_m: 0.0 };
        let mut outline: Vec<_> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .into_iter()
            .map(|[x, y]| Point3::new(x * 0.01, y * 0.01, 0.0))
            .collect();
        for _ in 0..2 {
            let near = |x_mm: f64, y_mm: f64, z_mm: f64| is_near(&plane, &outline, &(Point3::new(x_mm, y_mm, z_mm) * 1e-3));
            assert!(near(0.0, 0.0, 1.999) && near(0.0, 0.0, -1.999) && !near(0.0, 0.0, 2.0) && !near(0.0, 0.0, -2.001));
            assert!(near(11.9, 0.0, 0.0) && !near(12.1, 0.0, 0.0));
            // About a corner it is round: (1.5, 1.5) mm from it is 2.12 mm.
            assert!(near(11.3, -11.3, 0.0) && !near(11.5, -11.5, 0.0));
            assert!(near(11.0, 0.0, 1.7) && !near(11.0, 0.0, 1.8));
            outline.reverse();
        }
    }
}
