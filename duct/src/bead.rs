//! Flange beads: the low ridge that runs round the inside of a duct where two fittings are joined.

use nalgebra::Vector3;

use crate::Transform;
use crate::cell::{Solid, SurfaceId};
use crate::network::Network;

/// How far a bead reaches into the sheets that it lies on, as a share of its width. A gore's walls stand askew to the joint by up to 3.75
/// degrees: within half the bead's width they fall away from it by less than this.
const EMBEDDED: f64 = 0.05;

impl Network {
    /// Puts a bead round the inside of each joint between two fittings: four bars of rectangular section, `height_m` high and
    /// `width_m` wide, half of it on each side of the joint. Bars on floor and ceiling are as long as the duct is wide, those on the walls
    /// stand between them. Both measures must be positive, and the height less than half the duct's.
    pub fn add_beads(&mut self, height_m: f64, width_m: f64, surface: SurfaceId) {
        let mut first_cell = 0;
        for joint in 1..self.fittings.len() {
            let segment = &self.centreline.segments[joint];
            let bars = bars(segment.width_m, segment.height_m, height_m, width_m);
            // Only the two fittings' own cells can hold them; cells are in the order of their fittings.
            let of = |fitting: usize| move |cell: &crate::cell::Cell| cell.fitting == fitting;
            let before = self.cells[first_cell..].iter().take_while(|cell| of(joint - 1)(cell)).count();
            let after = self.cells[first_cell + before..].iter().take_while(|cell| of(joint)(cell)).count();
            let cells = &mut self.cells[first_cell..first_cell + before + after];
            for (joint_from_bar, size_m) in bars {
                let bar = Solid::cuboid(&(segment.world_from_start * joint_from_bar), size_m, surface);
                for cell in cells.iter_mut().filter(|cell| cell.is_reached_by(&bar)) {
                    cell.solids.push(bar.clone());
                }
            }
            first_cell += before;
        }
    }
}

/// Four bars round a duct's inside, at x = 0, x along the duct: where each stands, and its size.
fn bars(duct_width_m: f64, duct_height_m: f64, height_m: f64, width_m: f64) -> [(Transform, Vector3<f64>); 4] {
    let deep_m = EMBEDDED * width_m;
    let across = Vector3::new(width_m, duct_width_m + 2.0 * deep_m, height_m + deep_m);
    let upright = Vector3::new(width_m, height_m + deep_m, duct_height_m - 2.0 * height_m);
    let aside_m = (duct_width_m - height_m + deep_m) / 2.0;
    [
        (Transform::translation(0.0, 0.0, -deep_m), across),
        (Transform::translation(0.0, 0.0, duct_height_m - height_m), across),
        (Transform::translation(0.0, aside_m, height_m), upright),
        (Transform::translation(0.0, -aside_m, height_m), upright),
    ]
}
