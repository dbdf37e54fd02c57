//! `ductloop render`: what the camera sees, and the truth at its exposure.

use std::path::PathBuf;

use ductloop::closed_loop::RunError;
use ductloop::output::write_whole;
use ductloop::{GreyImage, Scenario, contact_sheet, picture};
use ductloop_sensor::renderer::RenderError;
use serde_json::{Value, json};

use super::args::RenderArgs;
use super::inputs::Input;
use super::problem::Problem;
use super::rendering::Rendering;
use super::shot::{Shot, of_pose, of_run};
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, destination, inputs, interrupt, truth_files};

/// Carries it out: runs the loop up to the times asked for, or takes the pose that was given, and renders.
///
/// # Errors
/// A wrong input, a run that ends before that time, a file that cannot be written.
pub(crate) fn command(args: &RenderArgs) -> Result<u8, Problem> {
    let inputs = inputs::read(std::slice::from_ref(&args.input), &args.overlay)?;
    let [Input { file, scenario, .. }] = inputs.as_slice() else {
        let many = wrong("one scenario is rendered at a time, and this folder holds several".into());
        return Err(many.about(args.input.display().to_string()).help("name one of its files"));
    };
    check(args, scenario)?;
    let rendering = Rendering::open(args.rendering, args.quiet)?;
    interrupt::listen();
    let shots = if args.pose.is_empty() {
        let Some(shots) = of_run(scenario, &rendering, &args.at_s, file)? else {
            note("interrupted: nothing was written");
            return Ok(INTERRUPTED);
        };
        shots
    } else {
        vec![of_pose(scenario, &args.pose)?]
    };
    let cannot_go_on =
        |error: &dyn std::fmt::Display| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(file.display().to_string());
    // The run saw the scenario's own images; those that are shown are made anew, as they were asked for.
    let mut shown = scenario.clone();
    shown.optics.noise &= !args.no_noise;
    shown.optics.ccd.bits = args.bits.unwrap_or(shown.optics.ccd.bits);
    let images = expose(&shown, &rendering, &shots).map_err(|error| match error {
        RunError::Render(RenderError::OutsideNetwork { .. }) if !args.pose.is_empty() => wrong(error.to_string()).about("--pose"),
        error => cannot_go_on(&error),
    })?;
    let document = document(&shots);
    let mut files = vec![
        (args.out.clone(), png(args, &shots, &images).map_err(|error| cannot_go_on(&error))?),
        (args.out.with_extension("json"), format!("{document:#}\n").into_bytes()),
    ];
    if let ([shot], [image], true) = (shots.as_slice(), images.as_slice(), args.truth) {
        files.extend(truth_files::of(&shown, &shot.view, image, &args.out).map_err(|error| cannot_go_on(&error))?);
    }
    for (path, bytes) in &files {
        let cannot = |error: &dyn std::fmt::Display| Problem::new(Problem::CANNOT_GO_ON, error.to_string());
        write_whole(path, bytes).map_err(|error| cannot(&error).about(path.display().to_string()))?;
    }
    if args.json {
        print_json(&document)?;
    } else if !args.quiet {
        print(&files.iter().map(|(path, _)| path.display().to_string()).collect::<Vec<_>>().join("\n"))?;
    }
    Ok(0)
}

fn wrong(message: String) -> Problem {
    Problem::new(Problem::WRONG_INPUT, message)
}

/// What can be told to be wrong before anything runs.
fn check(args: &RenderArgs, scenario: &Scenario) -> Result<(), Problem> {
    if args.out.extension().is_none_or(|ending| ending != "png") {
        return Err(wrong("the picture's name must end in .png".into()).about(args.out.display().to_string()));
    }
    if args.at_s.iter().any(|time_s| *time_s > scenario.time_limit_s) {
        let message = format!("this is later than the run can end, {} s at the latest (time_limit_s)", scenario.time_limit_s);
        return Err(wrong(message).about("--at-s"));
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

/// The picture: the frame as it is, with lines drawn on it, or several frames on a sheet.
fn png(args: &RenderArgs, shots: &[Shot], images: &[GreyImage]) -> image::ImageResult<Vec<u8>> {
    match (images, shots) {
        ([image], [shot]) if args.lines => picture::overlay_png(image, &shot.lines),
        ([image], _) => picture::grey_png(image),
        _ => contact_sheet::png(images.iter().zip(shots.iter().map(|shot| shot.label.as_str()))),
    }
}

fn document(shots: &[Shot]) -> Value {
    match shots {
        [one] => one.document.clone(),
        several => json!({"format": 1, "frames": several.iter().map(|shot| &shot.document).collect::<Vec<_>>()}),
    }
}
