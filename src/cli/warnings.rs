//! What can be run and is hardly meant so: a laser whose source is outside the duct lights nothing in it, a study that trains on what it
//! holds out proves nothing.

use std::fmt::Display;

use ductloop::Scenario;
use ductloop::scenario::study_file::Concern;
use ductloop::viewpoint::{lasers_outside, world_from_start_camera};
use serde_json::{Value, json};

use super::shot::Shot;
use super::streams::note;

/// Something that somebody should know before they look at the result.
#[derive(Debug, PartialEq)]
pub(crate) struct Warning {
    message: String,
    help: String,
}

impl Warning {
    fn laser_outside(laser: &str, at: &str) -> Self {
        Self {
            message: format!("{at} the source of laser `{laser}` is outside the duct: its light is missing"),
            help: format!("another source in [sensor.laser.{laser}], or another place of the camera"),
        }
    }

    /// Tells it on standard error; `source` is where the scenario comes from.
    pub(crate) fn tell(&self, source: &dyn Display) {
        note(&format!("warning: {source}: {}\n  help: {}", self.message, self.help));
    }

    /// `{"message", "help"}`.
    pub(crate) fn to_json(&self) -> Value {
        json!({"message": self.message, "help": self.help})
    }
}

impl From<Concern> for Warning {
    fn from(Concern { message, help }: Concern) -> Self {
        Self { message, help }
    }
}

/// What is to be said of a scenario before it runs.
pub(crate) fn of_start(scenario: &Scenario) -> Vec<Warning> {
    let outside = world_from_start_camera(scenario).map(|camera| lasers_outside(scenario, &camera)).unwrap_or_default();
    outside.into_iter().map(|laser| Warning::laser_outside(&scenario.rig.lasers[laser].name, "at the start")).collect()
}

/// What is to be said of frames: a warning a laser that is on.
pub(crate) fn of_shots(scenario: &Scenario, shots: &[Shot]) -> Vec<Warning> {
    let outside: Vec<_> = shots.iter().map(|shot| lasers_outside(scenario, &shot.view.world_from_camera)).collect();
    let of_laser = |(index, laser): (usize, &ductloop_nav::rig::Laser)| {
        let is_dark = |(shot, outside): &(&Shot, &Vec<usize>)| shot.view.laser_power[index] > 0.0 && outside.contains(&index);
        let dark: Vec<_> = shots.iter().zip(&outside).filter(is_dark).map(|(shot, _)| shot.label.as_str()).collect();
        // A pose has no time.
        let at = if dark == [""] { "here".to_owned() } else { format!("at {}", dark.join(", ")) };
        (!dark.is_empty()).then(|| Warning::laser_outside(&laser.name, &at))
    };
    scenario.rig.lasers.iter().enumerate().filter_map(of_laser).collect()
}
