//! What stands in the duct, beads and objects: it is within the duct, no two objects share a name or a place, and the robot does not
//! start in it.

use std::collections::BTreeMap;

use ductloop_duct::cell::Solid;
use ductloop_duct::network::Network;
use ductloop_sim::clearance::Outline;
use nalgebra::Vector3;

use super::{Cross, FREE_M, up_mm};
use crate::scenario::model::{Object, ObjectShape};

impl Cross<'_> {
    /// Beads no wider than the fittings that they are between: elsewhere they would stand in the next joint.
    pub(super) fn beads(&mut self) {
        let duct = &self.scenario.duct;
        let paths = ["duct.bead_mm", "duct.bead_width_mm", "duct.run", "duct.width_m"];
        if duct.bead_m == 0.0 || duct.run.len() + duct.branches.len() < 2 || !self.checked.is_sound(&paths) {
            return;
        }
        let lengths_m = duct.fittings().into_iter().map(|fitting| fitting.length_m());
        // Without a way straight on it is as long as its branches are wide, which is checked with them.
        let lengths_m = lengths_m.enumerate().filter(|(_, length_m)| *length_m > 0.0);
        let Some((index, length_m)) = lengths_m.min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        if duct.bead_width_m > length_m {
            let (name, path) = self.fitting_at(index).unwrap_or_default();
            let message = format!("flange beads {} mm wide are wider than `{name}` is long", duct.bead_width_m * 1e3);
            let help = format!("{:.3} mm or less, or a longer fitting", libm::floor(length_m * 1e6) / 1e3);
            let fitting = self.named_at(&name, &path);
            self.wrong_with(&["duct.bead_width_mm", "duct.bead_mm"], message, &help, vec![fitting]);
        }
    }

    /// Each object is within the duct, and none of them in another.
    pub(super) fn objects(&mut self, network: &Network) {
        if !self.checked.is_sound(&["duct"]) {
            return;
        }
        self.places(network);
        if self.checked.is_sound(&["duct"]) {
            self.clear_of_each_other(network);
        }
    }

    /// Reports tell objects apart by their names.
    pub(super) fn object_names(&mut self) {
        let mut first: BTreeMap<&str, usize> = BTreeMap::new();
        let named = self.scenario.duct.objects.iter().enumerate().filter(|(_, object)| !object.name.is_empty());
        for (i, Object { name, .. }) in named {
            match first.get(name.as_str()) {
                Some(other) => {
                    let message = format!("two objects are called \"{name}\"");
                    let other = (self.typed.span(&format!("duct.object[{other}].name")), "the other one".to_owned());
                    let help = "a name of its own for one of them, or none";
                    self.at(&format!("duct.object[{i}].name"), message, help, vec![other]);
                }
                None => {
                    first.insert(name, i);
                }
            }
        }
    }

    /// No two of them are in each other.
    fn clear_of_each_other(&mut self, network: &Network) {
        let objects = &self.scenario.duct.objects;
        let solids: Vec<Solid> = objects.iter().map(|object| object.solid(&network.centreline)).collect();
        for (i, object) in objects.iter().enumerate() {
            if let Some(other) = (0..i).find(|other| overlap(&solids[i], &solids[*other])) {
                let others = called(other, &objects[other]);
                let others = others.trim_end_matches(',');
                let message = format!("{} overlaps {others}", called(i, object));
                let there = (self.typed.span(&format!("duct.object[{other}].at_m")), format!("{others} stands here"));
                let help = "another place for one of the two; they may touch";
                self.at(&format!("duct.object[{i}].at_m"), message, help, vec![there]);
            }
        }
    }

    /// Each is within the duct.
    fn places(&mut self, network: &Network) {
        let length_m = network.centreline.length_m();
        for (i, object) in self.scenario.duct.objects.iter().enumerate() {
            let path = |key: &str| format!("duct.object[{i}].{key}");
            if object.at_m > length_m {
                let message = format!("{} stands at {} m, but the duct ends at {length_m:.3} m", called(i, object), object.at_m);
                self.wrong_at(&path("at_m"), message, "a distance within the duct".to_owned());
            } else if !network.encloses(&object.solid(&network.centreline)) {
                let (key, help) = Self::room(network, object);
                self.wrong_at(&path(key), format!("{} reaches out of the duct", called(i, object)), help);
            }
        }
    }

    /// Where an object that is not inside would be: the key to change, and to what.
    fn room(network: &Network, object: &Object) -> (&'static str, String) {
        let [width_m, height_m] = network.centreline.section_at_m(object.at_m);
        let length_m = network.centreline.length_m();
        let ObjectShape::Box { size_m: [along_m, across_m, high_m] } = object.shape;
        let (sin, cos) = libm::sincos(object.turned_rad);
        let half = |a: f64, b: f64| (a * cos.abs() + b * sin.abs()) / 2.0;
        let (ahead_m, aside_m) = (half(along_m, across_m), half(across_m, along_m));
        let free_m = width_m / 2.0 - aside_m;
        let last_m = length_m - ahead_m;
        if high_m > height_m {
            ("size_m", format!("upright at most {height_m} m, the duct's height"))
        } else if object.above_m + high_m > height_m {
            ("above_m", format!("{:.3} or less: the duct is {height_m} m high", -up_mm(high_m - height_m)))
        } else if free_m < 0.0 {
            ("size_m", format!("so turned it is {:.3} m wide, and the duct is {width_m} m wide", 2.0 * aside_m))
        } else if object.left_m.abs() > free_m {
            ("left_m", format!("in a straight it may be {:.3} to {:.3}", up_mm(-free_m), -up_mm(-free_m)))
        } else if !(ahead_m..=last_m).contains(&object.at_m) && ahead_m <= last_m {
            ("at_m", format!("in a straight it may be {:.3} to {:.3}", up_mm(ahead_m), -up_mm(-last_m)))
        } else {
            ("at_m", "the duct bends here: another place, or a smaller object".to_owned())
        }
    }

    /// The robot stands free of beads and objects at the start. `network` holds them.
    pub(super) fn start_among(&mut self, network: &Network) {
        if !self.checked.is_sound(&["robot", "duct", "start"]) {
            return;
        }
        let scenario = self.scenario;
        let outline = Outline::new(&scenario.robot);
        let start = scenario.world_from_start(network);
        let touches = |solid: &Solid| outline.distance_to_solid_m(solid, &start) < FREE_M;
        let objects: Vec<Solid> = scenario.duct.objects.iter().map(|object| object.solid(&network.centreline)).collect();
        let help = "another place for it, or another `start.distance_m` or `start.lateral_m`".to_owned();
        for (i, object) in scenario.duct.objects.iter().enumerate().filter(|(i, _)| touches(&objects[*i])) {
            let message = format!("the robot starts where {} stands", called(i, object));
            self.wrong_at(&format!("duct.object[{i}].at_m"), message, help.clone());
        }
        let mut beads = network.cells.iter().flat_map(|cell| &cell.solids).filter(|solid| !objects.contains(solid));
        if beads.any(touches) {
            self.wrong(
                &["start.distance_m", "start", "duct.bead_mm"],
                "at the start the robot touches a flange bead".to_owned(),
                "a start between two joints".to_owned(),
            );
        }
    }

    /// An error at a path into an array of tables.
    fn wrong_at(&mut self, path: &str, message: String, help: String) {
        let finding = super::Finding::new(self.typed.span(path), message).help(help);
        self.checked.wrong(path, finding);
    }
}

/// Bodies that reach into each other by less than this only touch, in metres: rounding is far below, any real overlap above.
const TOUCH_M: f64 = 1e-6;

/// Whether two upright boxes have room in common: no axis keeps them apart, neither the vertical nor one along their sides
/// (Gottschalk, Lin and Manocha, OBBTree, 1996, for boxes that share an axis).
fn overlap(a: &Solid, b: &Solid) -> bool {
    let reach = |solid: &Solid, axis: &Vector3<f64>| {
        let along = solid.corners.iter().map(|corner| axis.dot(&corner.coords));
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
    };
    a.planes.iter().chain(&b.planes).all(|plane| {
        let ((a_low, a_high), (b_low, b_high)) = (reach(a, &plane.normal), reach(b, &plane.normal));
        a_high - b_low > TOUCH_M && b_high - a_low > TOUCH_M
    })
}

/// An object as a sentence speaks of it.
fn called(index: usize, object: &Object) -> String {
    if object.name.is_empty() {
        format!("`duct.object[{index}]`")
    } else {
        format!("`duct.object[{index}]`, \"{}\",", object.name)
    }
}
