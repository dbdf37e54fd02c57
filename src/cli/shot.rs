//! What is rendered by `ductloop render`: moments of a run, or a camera that somebody put somewhere.

use std::ops::ControlFlow;

use ductloop::closed_loop::{RunFailure, run_with};
use ductloop::record::{EndState, FrameRecord, RunRecord};
use ductloop::scenario::shown;
use ductloop::viewpoint::still;
use ductloop::{Pilot, Scenario};
use ductloop_nav::perception::StripeLine;
use ductloop_nav::rig::{Mount, MountAngles};
use ductloop_sensor::renderer::View;
use nalgebra::Point3;
use serde_json::{Value, json};

use super::interrupt;
use super::problem::Problem;
use super::rendering::Rendering;
use super::source::Source;

/// A frame to render.
pub(crate) struct Shot {
    /// What the camera is to see.
    pub(crate) view: View,
    /// What to write below it on a contact sheet.
    pub(crate) label: String,
    /// Where camera and robot are, and what the navigator made of the frame.
    pub(crate) document: Value,
    /// The lines that the navigator found in the frame; only of the last of several.
    pub(crate) lines: Vec<StripeLine>,
}

/// The moments of a run that were asked for.
pub(crate) struct Moments {
    /// Those that it came to, in their order.
    pub(crate) shots: Vec<Shot>,
    /// Which of the times fall on one frame, in words.
    pub(crate) merged: Vec<String>,
    /// Why the run did not come to all of them, if it did not.
    pub(crate) missed: Option<Problem>,
}

/// Runs the loop up to the last of `times_s`; `None` if it was interrupted. `source` is where the scenario comes from.
///
/// # Errors
/// A run that ends, or cannot go on, before the first of them.
pub(crate) fn of_run(
    scenario: &Scenario,
    rendering: &Rendering,
    times_s: &[f64],
    source: &Source,
) -> Result<Option<Moments>, Problem> {
    let cannot_go_on =
        |error: &dyn std::fmt::Display| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(source.to_string());
    let threads = rendering.threads;
    let mut renderer = rendering.engine.renderer(scenario, threads.rendering()).map_err(|error| cannot_go_on(&error))?;
    let mut times_s = times_s.to_vec();
    times_s.sort_by(f64::total_cmp);
    let mut left = times_s.iter().copied().peekable();
    let (mut shots, mut merged) = (Vec::new(), Vec::new());
    let result = run_with(scenario, Pilot::of(scenario), renderer.as_mut(), threads.pace(), |record, _| {
        if interrupt::requested() {
            return ControlFlow::Break(());
        }
        // Ticks are whole, seconds are rounded.
        let due: Vec<f64> = std::iter::from_fn(|| left.next_if(|time_s| record.time_s + 1e-9 >= *time_s)).collect();
        if !due.is_empty() {
            shots.push(of_record(scenario, record));
        }
        if due.len() > 1 {
            merged.push(format!("{} fall on one frame, that of {:.3} s: it is shown once", seconds(&due), record.time_s));
        }
        if left.peek().is_none() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let late: Vec<f64> = left.collect();
    let written = if shots.is_empty() { "" } else { "; the frames until then are written" };
    let missed = match result {
        Ok(run) if late.is_empty() => {
            if let (Some(shot), Some(key)) = (shots.last_mut(), run.key_frames.spread().last()) {
                shot.lines.clone_from(&key.lines);
            }
            None
        }
        Ok(run) if run.end == EndState::BrokenOff => return Ok(None),
        Ok(run) => {
            // Between its last frame and its end a run lasts on; a time that falls there has no frame either.
            let last_s = last_frame_s(&run);
            let (times, end) = (seconds(&late), run.end.word());
            let ended = format!("the run's last frame is that of {last_s:.3} s ({end}), before {times}{written}");
            let help = "`[start]`, `time_limit_s` and the duct say how long a run is";
            Some(Problem::new(Problem::WRONG_INPUT, ended).about("--at-s").help(help))
        }
        Err(RunFailure { error, record: Some(record) }) if !late.is_empty() => {
            let last_s = last_frame_s(&record);
            let came_to = format!(
                "the run could not go on at {:.3} s, and its last frame is that of {last_s:.3} s, before {}",
                record.sim_time_s,
                seconds(&late)
            );
            Some(cannot_go_on(&format!("{came_to}{written}: {error}")))
        }
        Err(failure) => Some(cannot_go_on(&failure)),
    };
    match missed {
        Some(problem) if shots.is_empty() => Err(problem),
        missed => Ok(Some(Moments { shots, merged, missed })),
    }
}

/// When the last of a run's frames was exposed, in seconds.
fn last_frame_s(run: &RunRecord) -> f64 {
    run.frames.last().map_or(0.0, |record| record.time_s)
}

/// A camera where the robot's is at the start, as `--pose` takes it.
pub(crate) fn start_pose(scenario: &Scenario) -> Option<String> {
    let base = scenario.world_from_start(&scenario.duct.network().ok()?);
    let Mount { position_in_base_m, roll_rad, rest } = scenario.actual_rig().mount;
    let [x, y, z]: [f64; 3] = (base * position_in_base_m).coords.into();
    let yaw_rad = base.rotation.euler_angles().2 + rest.pan_rad;
    let [yaw_deg, pitch_deg, roll_deg] = [yaw_rad, rest.tilt_rad, roll_rad].map(f64::to_degrees);
    Some(format!("{x:.3},{y:.3},{z:.3},{yaw_deg:.1},{pitch_deg:.1},{roll_deg:.1}"))
}

/// Times as people read them: `1 s, 2 s and 2.5 s`.
fn seconds(times_s: &[f64]) -> String {
    let words: Vec<_> = times_s.iter().map(|time_s| format!("{} s", shown(*time_s))).collect();
    match words.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => words.concat(),
    }
}

/// Largest angle of a pose, in degrees, either way. More is a slip, and far more has lost its digits.
const TURN_DEG: f64 = 360.0;

/// A camera at `pose`: x, y, z in metres, then yaw, pitch and roll in degrees.
///
/// # Errors
/// Where these are not six numbers, or an angle is more than a whole turn.
pub(crate) fn of_pose(scenario: &Scenario, pose: &[f64]) -> Result<Shot, Problem> {
    let &[x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg] = pose else {
        let message = format!("six numbers are needed, not {}: X,Y,Z in metres, YAW,PITCH,ROLL in degrees", pose.len());
        return Err(Problem::new(Problem::WRONG_INPUT, message).about("--pose").help("as in `--pose 2,0,0.15,0,0,0`"));
    };
    for (name, angle_deg) in [("yaw", yaw_deg), ("pitch", pitch_deg), ("roll", roll_deg)] {
        if angle_deg.abs() > TURN_DEG {
            let message = format!("{name} is {} degrees; it must be from -{TURN_DEG} to {TURN_DEG}", shown(angle_deg));
            return Err(Problem::new(Problem::WRONG_INPUT, message).about("--pose"));
        }
    }
    // A mount that stands still in the world: its pan is the yaw, its tilt the pitch.
    let stand = Mount {
        position_in_base_m: Point3::new(x_m, y_m, z_m),
        roll_rad: roll_deg.to_radians(),
        rest: MountAngles { pan_rad: yaw_deg.to_radians(), tilt_rad: pitch_deg.to_radians() },
    };
    let laser_power = scenario.laser_powers(1.0);
    let view = View { laser_power, ..still(stand.base_from_camera(stand.rest), scenario.first_exposure_s()) };
    let document = json!({"format": 1, "scenario": scenario.name, "seed": scenario.seed, "camera": camera(&view)});
    Ok(Shot { view, label: String::new(), document, lines: Vec::new() })
}

/// Pose of the camera and how it exposes.
fn camera(view: &View) -> Value {
    let pose = &view.world_from_camera;
    json!({
        "position_m": pose.translation.vector.as_slice(),
        "rotation_xyzw": pose.rotation.coords.as_slice(),
        "exposure_s": view.exposure_s,
        "laser_power": view.laser_power,
    })
}

/// A frame of a run: what was the case at its exposure, and what the navigator made of it.
fn of_record(scenario: &Scenario, record: &FrameRecord) -> Shot {
    let position = record.truth.world_from_base.translation.vector;
    let rotation = record.truth.world_from_base.rotation.coords;
    let document = json!({
        "format": 1,
        "scenario": scenario.name,
        "seed": scenario.seed,
        "frame": record.frame,
        "tick": record.tick,
        "time_s": record.time_s,
        "truth": {
            "position_m": position.as_slice(),
            "rotation_xyzw": rotation.as_slice(),
            "distance_m": record.truth.distance_m,
            "lateral_m": record.truth.lateral_m,
            "heading_rad": record.truth.heading_rad,
            "clearance_m": record.truth.clearance_m,
            "speed_m_s": record.truth.speed_m_s,
        },
        "camera": camera(&record.view),
        "mount": {"pan_rad": record.mount.pan_rad, "tilt_rad": record.mount.tilt_rad},
        "estimate": {
            "lateral_m": record.measurement.lateral_m,
            "heading_rad": record.measurement.heading_rad,
            "width_m": record.measurement.width_m,
        },
    });
    Shot { view: record.view.clone(), label: format!("{:.3} s", record.time_s), document, lines: Vec::new() }
}
