//! What fields say of each other: rates that divide, a robot that fits its duct, lasers that show depth, a start that is free.
//!
//! Each rule is judged only where everything it rests on is sound, so that one slip gives one error.

mod controllers;
mod course;
mod network;
mod sensor;
mod standing;

use ductloop_duct::network::Network;

use super::Scenario;
use super::check::Checked;
use super::diagnostic::Finding;
use super::source::Span;
use super::tree::Entry;
use super::typed::Typed;
use network::Related;

/// Free space that a robot needs on every side. Less is touching: the physics holds bodies about a millimetre apart.
const FREE_M: f64 = 1e-3;

/// Checks all rules.
pub(super) fn check(scenario: &Scenario, typed: &Typed, checked: &mut Checked) {
    let mut cross = Cross { scenario, typed, checked };
    cross.rates();
    cross.robot();
    cross.controllers();
    cross.speed();
    cross.sensor();
    cross.perception();
    cross.told_width();
    cross.fit();
    cross.beads();
    if let Some(network) = cross.network() {
        cross.objects(&network);
        cross.course(&network);
    }
    cross.object_names();
}

/// Checks the rules of sensor and perception alone.
pub(super) fn check_rig(scenario: &Scenario, typed: &Typed, checked: &mut Checked) {
    let mut cross = Cross { scenario, typed, checked };
    cross.sensor();
    cross.perception();
}

/// Rounded up to a millimetre, so that what help says is accepted. The subtrahend is far below what is shown, and far above
/// what the product rounds.
fn up_mm(x_m: f64) -> f64 {
    (x_m * 1e3 - 1e-6).ceil() / 1e3
}

struct Cross<'a> {
    scenario: &'a Scenario,
    typed: &'a Typed,
    checked: &'a mut Checked,
}

impl Cross<'_> {
    /// The place of the first of these paths that was typed, else of the table around the first.
    fn span(&self, paths: &[&str]) -> Span {
        let typed = paths.iter().find(|path| self.typed.root.at(path).is_some());
        self.typed.span(typed.or(paths.first()).copied().unwrap_or_default())
    }

    fn wrong(&mut self, paths: &[&str], message: String, help: String) {
        self.wrong_with(paths, message, &help, Vec::new());
    }

    /// The same of other places too.
    fn wrong_with(&mut self, paths: &[&str], message: String, help: &str, related: Vec<Related>) {
        let finding = Finding::new(self.span(paths), message).help(help);
        let finding = related.into_iter().fold(finding, |finding, (span, what)| finding.also(span, what));
        self.checked.wrong(paths.first().copied().unwrap_or_default(), finding);
    }

    /// A field that a message speaks of as well, if it was typed.
    fn field_at(&self, path: &str) -> Option<Related> {
        self.typed.root.at(path).map(|node| (node.span, format!("`{path}` is here")))
    }

    fn rates(&mut self) {
        let physics = self.scenario.rates.physics_hz;
        for (path, rate) in
            [("rates.wheel_control_hz", self.scenario.rates.wheel_control_hz), ("rates.camera_hz", self.scenario.rates.camera_hz)]
        {
            if !self.checked.is_sound(&["rates.physics_hz", path]) || physics.is_multiple_of(rate) {
                continue;
            }
            let below = (1..=rate).rev().find(|r| physics.is_multiple_of(*r));
            let above = (rate..=physics).find(|r| physics.is_multiple_of(*r));
            let near: Vec<_> = [below, above].into_iter().flatten().map(|r| r.to_string()).collect();
            self.wrong(
                &[path, "rates.physics_hz"],
                format!("`{path}` is {rate}, which does not divide the {physics} Hz of physics"),
                format!("nearest that do: {} Hz; or change `rates.physics_hz`", near.join(" and ")),
            );
        }
    }

    fn robot(&mut self) {
        if !self.checked.is_sound(&["robot"]) {
            return;
        }
        if let Err(error) = self.scenario.robot.validate() {
            let field = format!("robot.{}", error.field);
            let message = format!("the robot cannot be built: `{field}` is {}", error.value);
            // The field may be the preset's, and what was typed in its way another one.
            let path = field.split('[').next().unwrap_or(&field);
            let typed = ["robot.drive", "robot"].into_iter().filter_map(|table| {
                let entries = &self.typed.root.at(table)?.as_table()?.entries;
                let body = |e: &&Entry| !["preset", "speed_m_s", "drive"].contains(&e.key.as_str());
                entries.iter().find(body).map(|e| format!("{table}.{}", e.key))
            });
            let typed: Vec<String> = typed.collect();
            let paths: Vec<&str> = std::iter::once(path).chain(typed.iter().map(String::as_str)).collect();
            self.wrong(&paths, message, error.rule);
        }
    }

    /// A speed that the motors do not reach even without load is never driven.
    fn speed(&mut self) {
        let robot = &self.scenario.robot;
        if !self.checked.is_sound(&["robot"]) {
            return;
        }
        let unloaded_m_s = robot.unloaded_speed_m_s();
        if self.scenario.speed_m_s >= unloaded_m_s {
            let speed_m_s = self.scenario.speed_m_s;
            self.wrong(
                &["robot.speed_m_s", "robot.drive", "robot"],
                format!("`robot.speed_m_s` is {speed_m_s}: the motors turn the wheels at {unloaded_m_s:.3} m/s at most"),
                "below that, with some left for load; or another `robot.drive` or `robot.wheel_radius_m`".to_owned(),
            );
        }
    }

    fn perception(&mut self) {
        let paper = &self.scenario.perception.paper;
        let [thin, thick] = paper.thickness_ratio;
        for (path, sides) in
            [("perception.paper.opening_px", paper.opening_px), ("perception.paper.closing_px", paper.closing_px)]
        {
            if self.checked.is_sound(&[path]) && sides.iter().any(|side| side % 2 == 0) {
                let message = format!("`{path}` is {sides:?}: both sides must be odd");
                self.wrong(&[path], message, "an element has a middle pixel: 1, 3, 5, …".to_owned());
            }
        }
        let path = "perception.paper.thickness_ratio";
        if self.checked.is_sound(&[path]) && thin >= thick {
            let message = format!("`{path}` is [{thin}, {thick}]: nothing is thicker than {thin} and thinner than {thick}");
            self.wrong(&[path], message, "thinnest first, then thickest".to_owned());
        }
        let path = "perception.robust.range_m";
        let [near, far] = self.scenario.perception.robust.range_m;
        if self.checked.is_sound(&[path]) && near >= far {
            let message = format!("`{path}` is [{near}, {far}]: nothing is farther than {near} and nearer than {far}");
            self.wrong(&[path], message, "nearest first, then farthest".to_owned());
        }
    }

    fn fit(&mut self) {
        let [width_m, height_m] = self.scenario.robot.smallest_duct_m();
        let duct = &self.scenario.duct;
        for (path, what, has_m, robot_m, sides) in
            [("duct.width_m", "narrow", duct.width_m, width_m, 2.0), ("duct.height_m", "low", duct.height_m, height_m, 1.0)]
        {
            let needs_m = robot_m + sides * FREE_M;
            if self.checked.is_sound(&["robot", path]) && has_m < needs_m {
                let dimension = if path == "duct.width_m" { "wide" } else { "high" };
                self.wrong(
                    &[path],
                    format!("the duct is too {what} for the robot: {has_m} m, and the robot is {robot_m:.3} m {dimension}"),
                    format!("{:.3} m or more, a millimetre of it free on each side", up_mm(needs_m)),
                );
            }
        }
    }

    /// The network, if it can be made.
    fn network(&mut self) -> Option<Network> {
        self.one_way();
        if !self.checked.is_sound(&["duct.width_m", "duct.height_m", "duct.run", "duct.branch", "route"]) {
            return None;
        }
        match self.scenario.duct.network() {
            Ok(network) => return Some(network),
            Err(error) => self.no_network(error),
        }
        None
    }
}
