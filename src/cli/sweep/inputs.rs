//! The sweep's file, and whether its points can be: all looked at before anything runs.

use std::path::{Path, PathBuf};

use ductloop::engine::Engine;
use ductloop::scenario::Diagnostics;
use ductloop::scenario::sweep_file::SweepFile;
use ductloop::sweep::plan::Plan;
use ductloop::sweep::single_case::in_a_line;

use super::args::{FileArgs, rendering};
use crate::cli::args::OverlayArgs;
use crate::cli::problem::Problem;
use crate::cli::rendering::Rendering;
use crate::cli::streams::note;

/// Where a name is looked for.
const LIBRARY: &str = "scenarios/sweeps";
/// Cases that are planned without a word.
const MOST_CASES: u64 = 10_000;
/// Points that are looked at beforehand; of more than these as many, evenly.
const LOOKED_AT: u64 = 256;

/// A plan that is ready to be written, and what renders.
pub(super) struct Planned {
    pub(super) plan: Plan,
    pub(super) rendering: Rendering,
    /// Whether the command line changed the file.
    pub(super) changed: bool,
}

/// Reads the file and makes a plan of it.
///
/// # Errors
/// Everything that is wrong with the file, with all of its points, or with their number.
pub(super) fn planned(args: &FileArgs, quiet: bool) -> Result<Planned, Problem> {
    let path = find(args.input.as_deref().unwrap_or(Path::new("")));
    let about = path.display().to_string();
    let sweep = file(&path, &args.overlay)?;
    let rendering = Rendering::open(rendering(args.renderer), quiet)?;
    let plan = Plan::of(sweep, &renderer_id(&rendering));
    if plan.cases > MOST_CASES && !args.yes {
        let message = format!("{} points of {} replicates are {} cases", plan.points, plan.sweep.replicates, plan.cases);
        return Err(Problem::new(Problem::WRONG_INPUT, message).about(about).help(format!(
            "more than {MOST_CASES} are planned with `--yes`; a design that draws (`design = \"sobol\"`) takes as few as you say"
        )));
    }
    possible(&plan, &about, quiet)?;
    Ok(Planned { plan, rendering, changed: args.overlay.overlays() != Default::default() })
}

/// A sweep's plan, to be looked at and not carried out.
///
/// # Errors
/// Everything that is wrong with the file, and that no point of it is possible.
pub(crate) fn read(path: &Path, overlay: &OverlayArgs, quiet: bool) -> Result<Plan, Problem> {
    let plan = Plan::of(file(path, overlay)?, "cpu");
    possible(&plan, &path.display().to_string(), quiet)?;
    Ok(plan)
}

fn file(path: &Path, overlay: &OverlayArgs) -> Result<SweepFile, Problem> {
    if let Some(pipeline) = &overlay.perception {
        return Err(Problem::new(Problem::WRONG_INPUT, "a sweep says itself how its scenarios perceive")
            .about(format!("--perception {pipeline}"))
            .help(format!("`--set scenario.perception.pipeline={pipeline}` lays it over every base")));
    }
    SweepFile::read(path, &overlay.overlays()).map_err(|wrong| Problem::in_files(vec![overlay.as_typed(wrong)]))
}

/// Makes sure that not every point is impossible, and tells of those that are.
fn possible(plan: &Plan, about: &str, quiet: bool) -> Result<(), Problem> {
    let cases = plan.cases();
    let looked_at = plan.points.min(LOOKED_AT);
    let mut impossible: Vec<(String, Diagnostics)> = Vec::new();
    for nth in 0..looked_at {
        // Multiplied first, so that they are spread over all; 128 bits hold any product of two counts.
        let point = (u128::from(nth) * u128::from(plan.points) / u128::from(looked_at)) as u64;
        let case = cases.replicate(point, 0);
        if let Err(wrong) = plan.sweep.scenario(case.at.base, &case.settings, case.seed) {
            impossible.push((case.settings.join(" "), wrong));
        }
    }
    let Some((settings, wrong)) = impossible.first() else { return Ok(()) };
    let (count, told) = (impossible.len(), in_a_line(wrong));
    if count as u64 == plan.points {
        let message = format!("no point of this sweep is a possible scenario; the first, {settings}: {told}");
        return Err(Problem::new(Problem::WRONG_INPUT, message)
            .about(about)
            .help("change the factors, or what `[scenario]` lays over"));
    }
    if !quiet {
        note(&format!(
            "warning: {about}: of {looked_at} points looked at {count} are no possible scenario, and will be rows with the verdict \
             \"error\"; the first, {settings}: {told}"
        ));
    }
    Ok(())
}

/// What a case's hash says of what renders.
pub(crate) fn renderer_id(rendering: &Rendering) -> String {
    match (&rendering.engine, rendering.adapter()) {
        (Engine::Cpu, _) | (_, None) => "cpu".to_owned(),
        (_, Some(adapter)) => format!("wgpu {} ({}, {})", adapter.name, adapter.driver, adapter.backend),
    }
}

/// The file that the input names.
fn find(input: &Path) -> PathBuf {
    let named = Path::new(LIBRARY).join(input).with_extension("toml");
    let is_name = input.components().count() == 1 && input.extension().is_none();
    if is_name && !input.exists() && named.exists() { named } else { input.to_owned() }
}
