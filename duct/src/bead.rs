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
        for (before, after) in self.joined_ports() {
            let fitting = &self.fittings[after.0];
            let Some(port) = fitting.port(after.1) else { continue };
            let world_from_joint = self.world_from_fitting[after.0] * port.entry_from_inward();
            for (joint_from_bar, size_m) in bars(port.width_m, port.height_m, height_m, width_m) {
                let bar = Solid::cuboid(&(world_from_joint * joint_from_bar), size_m, surface);
                // Only the two fittings' own cells can hold it.
                for fitting in [before.0.min(after.0), before.0.max(after.0)] {
                    let cells = self.cells_of(fitting);
                    for cell in self.cells[cells].iter_mut().filter(|cell| cell.is_reached_by(&bar)) {
                        cell.solids.push(bar.clone());
                    }
                }
            }
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
