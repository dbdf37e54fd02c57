//! What stands in fittings, and openings that are not ports: turning vanes, a damper's curtain, a grille, a hole in the floor.

use nalgebra::{Point2, Point3, Vector3};

use super::{Blade, Fitting, GrilleSide, Shape};
use crate::Transform;
use crate::cell::{Beyond, Cell, Portal, Side, Slant, Solid};
use crate::centreline::turn_about_z;

/// Radius of a large single-thickness turning vane, in metres (4.5 inches), and the spacing of vanes along the mitre line (3.25
/// inches): what SMACNA's duct construction standards draw.
const VANE_RADIUS_M: f64 = 0.1143;
const VANE_SPACING_M: f64 = 0.0826;
/// Thickness of a vane as it is modelled, in metres: a flat plate in place of the curved sheet's chord.
const VANE_THICK_M: f64 = 0.002;
/// Share of the room at its place that a vane takes at most.
const VANE_ROOM: f64 = 0.9;

/// Share of the height that the folded curtain of an open damper takes.
const CURTAIN_SHARE: f64 = 0.12;
/// Depth of the folded curtain along the duct, and thickness of the drawn one, in metres.
const FOLDED_M: f64 = 0.05;
const DRAWN_M: f64 = 0.003;

/// Louvre bars: about this far apart, this thick, and this deep, in metres. They run along the duct, inside, against the sheet.
const LOUVRE_PITCH_M: f64 = 0.03;
const LOUVRE_THICK_M: f64 = 0.002;
const LOUVRE_DEEP_M: f64 = 0.012;

/// Places of floor and ceiling in a cell's faces.
const FLOOR: usize = 0;
const CEILING: usize = 1;
/// Places of the left and of the right wall of a straight duct's one cell: after floor, ceiling, entry come right, exit, left.
const RIGHT_WALL: usize = 3;
const LEFT_WALL: usize = 5;

impl Fitting {
    /// Height that is free all along it, in metres: of a transition the lower of its two, of an open damper what its folded curtain
    /// leaves.
    pub fn clear_height_m(&self) -> f64 {
        let lowest_m = self.ports().iter().map(|port| port.height_m).fold(self.height_m, f64::min);
        match self.shape {
            Shape::Damper { blade: Blade::Open, .. } => (1.0 - CURTAIN_SHARE) * lowest_m,
            _ => lowest_m,
        }
    }

    /// How many cells lie below its floor.
    pub(super) fn cells_below(&self) -> usize {
        usize::from(matches!(self.shape, Shape::Drop { .. }))
    }

    /// Puts into its cells, numbered from `first`, what they hold besides sheet metal around them.
    pub(super) fn furnish(&self, cells: &mut Vec<Cell>, first: usize) {
        let middle_m = |length_m: f64, z_m| Transform::translation(length_m / 2.0, 0.0, z_m);
        match self.shape {
            Shape::VanedElbow { angle_rad } => {
                for vane in self.vanes(angle_rad) {
                    for cell in cells.iter_mut().filter(|cell| cell.is_reached_by(&vane)) {
                        cell.solids.push(vane.clone());
                    }
                }
            }
            Shape::Damper { length_m, blade } => {
                let (deep_m, high_m) = match blade {
                    Blade::Open => (FOLDED_M, CURTAIN_SHARE * self.height_m),
                    Blade::Shut => (DRAWN_M, self.height_m),
                };
                let size_m = Vector3::new(deep_m.min(length_m / 2.0), self.width_m, high_m);
                let stand = middle_m(length_m, self.height_m - high_m);
                cells[0].solids.push(Solid::cuboid(&stand, size_m, self.surface));
            }
            Shape::Grille { length_m, side, opening_length_m, opening_height_m } => {
                let face = match side {
                    GrilleSide::Left => LEFT_WALL,
                    GrilleSide::Right => RIGHT_WALL,
                    GrilleSide::Ceiling => CEILING,
                };
                let opening = |along: f64, up: f64| {
                    let x = (length_m + along * opening_length_m) / 2.0;
                    self.grille_point(side, x, up * opening_height_m / 2.0, 0.0)
                };
                // Anticlockwise seen from the right or, in the ceiling, from above; from the left it is the other way round.
                let mut outline = vec![opening(-1.0, -1.0), opening(1.0, -1.0), opening(1.0, 1.0), opening(-1.0, 1.0)];
                if side == GrilleSide::Left {
                    outline.reverse();
                }
                let portal = Portal::new(&cells[0].faces[face].plane, outline, Beyond::Outside);
                cells[0].faces[face].portals.push(portal);
                cells[0].solids.extend(self.louvres(side, [length_m / 2.0, opening_length_m], opening_height_m));
            }
            Shape::Drop { length_m, hole_length_m, hole_width_m, depth_m } => {
                let (near, far, half) = ((length_m - hole_length_m) / 2.0, (length_m + hole_length_m) / 2.0, hole_width_m / 2.0);
                let plan = [[near, half], [near, -half], [far, -half], [far, half]].map(|[x, y]| Point2::new(x, y));
                let hole: Vec<_> = plan.iter().rev().map(|c| Point3::new(c.x, c.y, 0.0)).collect();
                let floor = &mut cells[0].faces[FLOOR];
                floor.portals.push(Portal::new(&floor.plane, hole, Beyond::Cell(first + 1)));
                let slants = [Slant::level(-depth_m), Slant::level(0.0)];
                let mut shaft = Cell::upright(&plan, slants, &[Side::Wall; 4], self.surface, cells[0].fitting);
                let lid = &mut shaft.faces[CEILING];
                lid.portals.push(Portal::new(&lid.plane, lid.outline.clone(), Beyond::Cell(first)));
                cells.push(shaft);
            }
            _ => {}
        }
    }

    /// A point of the sheet that holds a grille, or inside of it: `x_m` along the duct, `up_m` upward from its middle (in the ceiling:
    /// to the left), `deep_m` into the duct.
    fn grille_point(&self, side: GrilleSide, x_m: f64, up_m: f64, deep_m: f64) -> Point3<f64> {
        let (half, middle_z_m) = (self.width_m / 2.0, self.height_m / 2.0);
        match side {
            GrilleSide::Left => Point3::new(x_m, half - deep_m, middle_z_m + up_m),
            GrilleSide::Right => Point3::new(x_m, deep_m - half, middle_z_m + up_m),
            GrilleSide::Ceiling => Point3::new(x_m, up_m, self.height_m - deep_m),
        }
    }

    fn louvres(&self, side: GrilleSide, [middle_m, length_m]: [f64; 2], opening_height_m: f64) -> Vec<Solid> {
        let spaces = (opening_height_m / LOUVRE_PITCH_M).round().max(2.0);
        let thick_m = LOUVRE_THICK_M.min(opening_height_m / 8.0);
        let deep_m = LOUVRE_DEEP_M.min(self.width_m / 8.0).min(self.height_m / 8.0);
        (1..spaces as usize)
            .map(|i| {
                let up_m = opening_height_m * (i as f64 / spaces - 0.5);
                let centre = self.grille_point(side, middle_m, up_m, deep_m / 2.0);
                let size_m = match side {
                    GrilleSide::Ceiling => Vector3::new(length_m, thick_m, deep_m),
                    _ => Vector3::new(length_m, deep_m, thick_m),
                };
                let stand = Transform::translation(centre.x, centre.y, centre.z - size_m.z / 2.0);
                Solid::cuboid(&stand, size_m, self.surface)
            })
            .collect()
    }

    /// Flat plates on the mitre line, square to it, as far apart as vanes are. Each is as long as the chord of a vane, or as the two
    /// wedges have room for at its place.
    fn vanes(&self, angle_rad: f64) -> Vec<Solid> {
        let (side, half_rad) = (angle_rad.signum(), angle_rad.abs() / 2.0);
        let (s, c) = libm::sincos(half_rad);
        let mitre_m = self.width_m / c;
        let spaces = (mitre_m / VANE_SPACING_M).round().max(2.0);
        let along = turn_about_z(side * half_rad);
        (1..spaces as usize)
            .map(|i| {
                let from_inner_m = mitre_m * i as f64 / spaces;
                // The mitre line leaves the inner corner, seen in the entry's frame, forward by s and outward by c. Beside it the first
                // wedge goes as far as the entry, and as far as the heel's wall.
                let room_m = f64::min(from_inner_m * s / c, (mitre_m - from_inner_m) * c / s);
                let long_m = 2.0 * f64::min(VANE_RADIUS_M * s, VANE_ROOM * room_m);
                let at = Vector3::new(from_inner_m * s, side * (self.width_m / 2.0 - from_inner_m * c), 0.0);
                let thick_m = VANE_THICK_M.min(0.1 * room_m);
                let stand = Transform::from_parts(at.into(), along);
                Solid::cuboid(&stand, Vector3::new(long_m, thick_m, self.height_m), self.surface)
            })
            .collect()
    }
}
