//! `ductloop render`: what the camera sees, and the truth at its exposure.

use std::fmt::Display;
use std::path::PathBuf;

use ductloop::closed_loop::RunError;
use ductloop::output::write_whole;
use ductloop::scenario::shown;
use ductloop::{GreyImage, Scenario, contact_sheet, picture};
use ductloop_sensor::renderer::RenderError;
use serde_json::{Value, json};

use super::args::RenderArgs;
use super::inputs::Input;
use super::problem::Problem;
use super::rendering::Rendering;
use super::shot::{Moments, Shot, of_pose, of_run, start_pose};
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, destination, inputs, interrupt, truth_files, warnings};

/// Carries it out: runs the loop up to the times asked for, or takes the pose that was given, and renders.
///
/// # Errors
/// A wrong input, a run that ends before the first of the times, a file that cannot be written.
pub(crate) fn command(args: &RenderArgs) -> Result<u8, Problem> {
    let inputs = inputs::read(std::slice::from_ref(&args.input), &args.overlay)?;
    let [Input { source, scenario, .. }] = inputs.as_slice() else {
        let many = wrong("one scenario is rendered at a time, and this folder holds several".into());
        return Err(many.about(args.input.display().to_string()).help("name one of its files"));
    };
    check(args, scenario)?;
    let rendering = Rendering::open(args.rendering, args.quiet)?;
    interrupt::listen();
    let moments = if args.pose.is_empty() {
        of_run(scenario, &rendering, &args.at_s, source)?
    } else {
        Some(Moments { shots: vec![of_pose(scenario, &args.pose)?], merged: Vec::new(), missed: None })
    };
    let Some(Moments { shots, merged, missed }) = moments else {
        note("interrupted: nothing was written");
        return Ok(INTERRUPTED);
    };
    if !args.quiet {
        merged.iter().for_each(|words| note(&format!("note: --at-s: {words}")));
        warnings::of_shots(scenario, &shots).iter().for_each(|warning| warning.tell(source));
    }
    // The run saw the scenario's own images; those that are shown are made anew, as they were asked for.
    let mut shown = scenario.clone();
    shown.optics.noise &= !args.no_noise;
    shown.optics.ccd.bits = args.bits.unwrap_or(shown.optics.ccd.bits);
    let images = expose(&shown, &rendering, &shots).map_err(|error| match error {
        RunError::Render(RenderError::OutsideNetwork { .. } | RenderError::AgainstMetal { .. }) if !args.pose.is_empty() => {
            let refused = wrong(error.to_string()).about("--pose");
            match start_pose(scenario) {
                Some(start) => refused.help(format!("the scenario's own camera is at `--pose {start}` at the start")),
                None => refused,
            }
        }
        error => cannot_go_on(source, &error),
    })?;
    let mut document = document(args, &shots);
    let files = files(args, &shown, &shots, &images, &document).map_err(|error| cannot_go_on(source, &error))?;
    // Before anything new stands beside it.
    remove_truth_of_earlier_call(args).map_err(|(path, error)| cannot_go_on(&path.display(), &error))?;
    for (path, bytes) in &files {
        write_whole(path, bytes).map_err(|error| cannot_go_on(&path.display(), &error))?;
    }
    let code = missed.as_ref().map_or(0, Problem::tell);
    if args.json {
        if let (Some(problem), Some(document)) = (&missed, document.as_object_mut()) {
            document.insert("errors".into(), problem.to_json().into());
        }
        print_json(&document)?;
    } else if !args.quiet {
        print(&files.iter().map(|(path, _)| path.display().to_string()).collect::<Vec<_>>().join("\n"))?;
    }
    Ok(code)
}

fn cannot_go_on(what: &dyn Display, error: &dyn Display) -> Problem {
    Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(what.to_string())
}

fn wrong(message: String) -> Problem {
    Problem::new(Problem::WRONG_INPUT, message)
}

/// What can be told to be wrong before anything runs.
fn check(args: &RenderArgs, scenario: &Scenario) -> Result<(), Problem> {
    if args.out.extension().is_none_or(|ending| ending != "png") {
        return Err(wrong("the picture's name must end in .png".into()).about(args.out.display().to_string()));
    }
    if let Some(late_s) = args.at_s.iter().find(|time_s| **time_s > scenario.time_limit_s) {
        let limit_s = scenario.time_limit_s;
        let message = format!("{} s is later than the run can end, {limit_s} s at the latest (time_limit_s)", shown(*late_s));
        return Err(wrong(message).about("--at-s").help("a longer run: `--set time_limit_s=SECONDS`"));
    }
    for (option, given) in [("--truth", args.truth), ("--lines", args.lines)] {
        if given && args.at_s.len() > 1 {
            let message = format!("a contact sheet of {} times cannot show this", args.at_s.len());
            return Err(wrong(message).about(option).help("give `--at-s` a single time"));
        }
    }
    let beside = [args.out.clone(), args.out.with_extension("json")].into_iter();
    let truth: Vec<PathBuf> = if args.truth { truth_files::names(&args.out).into() } else { Vec::new() };
    beside.chain(truth).try_for_each(|file: PathBuf| destination::file("--out", &file))
}

/// Takes away the truth that an earlier call has left beside a picture which this one replaces without writing it anew, and says so.
fn remove_truth_of_earlier_call(args: &RenderArgs) -> Result<(), (PathBuf, std::io::Error)> {
    if args.truth {
        return Ok(());
    }
    for stale in truth_files::of_earlier_call(&args.out) {
        if let Err(error) = std::fs::remove_file(&stale) {
            return Err((stale, error));
        }
        if !args.quiet {
            note(&format!("removed {}: it was the truth of an earlier picture of this name", stale.display()));
        }
    }
    Ok(())
}

/// Renders each shot.
fn expose(scenario: &Scenario, rendering: &Rendering, shots: &[Shot]) -> Result<Vec<GreyImage>, RunError> {
    let mut renderer = rendering.engine.renderer(scenario, rendering.threads.all)?;
    let mut images = Vec::new();
    for shot in shots {
        let mut image = GreyImage::black(&scenario.rig.camera, scenario.optics.ccd.bits);
        renderer.render(&shot.view, image.room())?;
        images.push(image);
    }
    Ok(images)
}

/// Whether a sheet is made, even where the run came to one of the times only: what is written has the form that was asked for.
fn is_sheet(args: &RenderArgs) -> bool {
    args.at_s.len() > 1
}

/// Every file with its bytes.
fn files(
    args: &RenderArgs,
    shown: &Scenario,
    shots: &[Shot],
    images: &[GreyImage],
    document: &Value,
) -> anyhow::Result<Vec<(PathBuf, Vec<u8>)>> {
    let mut files = vec![
        (args.out.clone(), png(args, shots, images)?),
        (args.out.with_extension("json"), format!("{document:#}\n").into_bytes()),
    ];
    if let ([shot], [image], true) = (shots, images, args.truth) {
        files.extend(truth_files::of(shown, &shot.view, image, &args.out)?);
    }
    Ok(files)
}

/// The picture: the frame as it is, with lines drawn on it, or several frames on a sheet.
fn png(args: &RenderArgs, shots: &[Shot], images: &[GreyImage]) -> image::ImageResult<Vec<u8>> {
    match (images, shots) {
        ([image], [shot]) if args.lines => picture::overlay_png(image, &shot.lines),
        ([image], _) if !is_sheet(args) => picture::grey_png(image),
        _ => contact_sheet::png(images.iter().zip(shots.iter().map(|shot| shot.label.as_str()))),
    }
}

fn document(args: &RenderArgs, shots: &[Shot]) -> Value {
    match shots {
        [one] if !is_sheet(args) => one.document.clone(),
        several => json!({"format": 1, "frames": several.iter().map(|shot| &shot.document).collect::<Vec<_>>()}),
    }
}
