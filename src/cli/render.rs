//! `ductloop render`: one camera frame of a run, and the truth at its exposure.

use std::ops::ControlFlow;

use ductloop::closed_loop::run_with;
use ductloop::output::{FileError, write_whole};
use ductloop::record::{EndState, FrameRecord};
use ductloop::{Pilot, Scenario, picture};
use serde_json::{Value, json};

use super::args::RenderArgs;
use super::problem::Problem;
use super::rendering::Rendering;
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, destination, inputs, interrupt};

/// Carries it out: runs the loop up to the time asked for.
///
/// # Errors
/// A wrong input, a run that ends before that time, a file that cannot be written.
pub(crate) fn command(args: &RenderArgs) -> Result<u8, Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message);
    let inputs = inputs::read(std::slice::from_ref(&args.input), &args.overlay)?;
    let [input] = inputs.as_slice() else {
        let many = wrong("one scenario is rendered at a time, and this folder holds several".into());
        return Err(many.about(args.input.display().to_string()).help("name one of its files"));
    };
    let truth_file = args.out.with_extension("json");
    if args.out.extension().is_none_or(|ending| ending != "png") {
        return Err(wrong("the picture's name must end in .png".into()).about(args.out.display().to_string()));
    }
    let scenario = &input.scenario;
    if args.at_s > scenario.time_limit_s {
        let message = format!("this is later than the run can end, {} s at the latest (time_limit_s)", scenario.time_limit_s);
        return Err(wrong(message).about("--at-s"));
    }
    for file in [&args.out, &truth_file] {
        destination::file("--out", file)?;
    }
    let rendering = Rendering::open(args.rendering, args.quiet)?;
    interrupt::listen();
    let cannot_go_on = |error: &dyn std::fmt::Display| {
        Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(input.file.display().to_string())
    };
    let mut renderer = ductloop::renderer(&rendering.gpu, scenario).map_err(|error| cannot_go_on(&error))?;
    let mut found = None;
    let run = run_with(scenario, Pilot::of(scenario), &mut renderer, rendering.pace, |record, image| {
        if interrupt::requested() {
            return ControlFlow::Break(());
        }
        if record.time_s + 1e-9 < args.at_s {
            return ControlFlow::Continue(());
        }
        found = Some((record.clone(), image.to_vec()));
        ControlFlow::Break(())
    })
    .map_err(|failure| cannot_go_on(&failure))?;
    let Some((record, image)) = found else {
        if run.end == EndState::BrokenOff {
            note("interrupted: nothing was written");
            return Ok(INTERRUPTED);
        }
        let message = format!("the run ends at {:.3} s ({}), before {} s", run.sim_time_s, run.end.word(), args.at_s);
        return Err(wrong(message).about("--at-s"));
    };
    let camera = &scenario.rig.camera;
    let spread = run.key_frames.spread();
    let lines = spread.last().filter(|_| args.lines).map_or(&[][..], |key| &key.lines);
    let picture = if args.lines {
        picture::overlay_png(&image, camera.width_px, camera.height_px, lines)
    } else {
        picture::grey_png(&image, camera.width_px, camera.height_px)
    };
    let picture = picture.map_err(|error| cannot_go_on(&error))?;
    let truth = truth(scenario, &record);
    let cannot = |path: &std::path::Path| {
        let path = path.display().to_string();
        move |error: FileError| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(path)
    };
    write_whole(&args.out, &picture).map_err(cannot(&args.out))?;
    write_whole(&truth_file, format!("{truth:#}\n").as_bytes()).map_err(cannot(&truth_file))?;
    if args.json {
        print_json(&truth)?;
    } else if !args.quiet {
        print(&format!("{} and {}", args.out.display(), truth_file.display()))?;
    }
    Ok(0)
}

/// What was the case at the exposure, and what the navigator made of the frame.
fn truth(scenario: &Scenario, record: &FrameRecord) -> Value {
    let position = record.truth.world_from_base.translation.vector;
    let rotation = record.truth.world_from_base.rotation.coords;
    json!({
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
        "mount": {"pan_rad": record.mount.pan_rad, "tilt_rad": record.mount.tilt_rad},
        "estimate": {
            "lateral_m": record.measurement.lateral_m,
            "heading_rad": record.measurement.heading_rad,
            "width_m": record.measurement.width_m,
        },
    })
}
