//! `ductloop run`: scenarios to verdicts.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use ductloop::closed_loop::{RunFailure, run_with};
use ductloop::output::junit::Case;
use ductloop::output::{self, Manifest, RunFolder, Summary, folder_name};
use ductloop::record::{EndState, RunRecord};
use ductloop::{Pilot, Scenario, Verdict};
use serde_json::json;

use super::args::RunArgs;
use super::inputs::{self, Input};
use super::problem::{Problem, print_json};
use super::progress::Progress;
use super::rendering::Rendering;
use super::{INTERRUPTED, interrupt, verdict_table};

/// A run that is ready to begin: its folder can be written.
struct Planned {
    input: Input,
    name: String,
    folder: RunFolder,
}

/// A run that is over.
struct Finished {
    planned: Planned,
    summary: Summary,
}

/// How a run ended, for the command.
enum Outcome {
    Summary(Box<Summary>),
    Interrupted,
}

/// Carries it out.
///
/// # Errors
/// What keeps any run from beginning.
pub(crate) fn command(args: &RunArgs) -> Result<u8, Problem> {
    let planned = plan(args)?;
    let rendering = Rendering::open(args.rendering, args.quiet)?;
    interrupt::listen();
    let count = planned.len();
    let mut finished = Vec::new();
    let mut problem: Option<Problem> = None;
    let mut interrupted = false;
    for (index, run) in planned.into_iter().enumerate() {
        match execute(&run, index, count, args, &rendering) {
            Ok(Outcome::Summary(summary)) => finished.push(Finished { planned: run, summary: *summary }),
            Ok(Outcome::Interrupted) => interrupted = true,
            Err(failure) => {
                problem = Some(match problem {
                    Some(before) => before.and(failure),
                    None => failure,
                });
            }
        }
        if interrupted || interrupt::requested() {
            interrupted = index + 1 < count || interrupted;
            break;
        }
    }
    let mut code = finished.iter().map(|run| run.summary.verdict.exit_code()).max().unwrap_or(0);
    if let Some(path) = &args.junit {
        let cases: Vec<Case<'_>> = finished
            .iter()
            .map(|run| {
                let (scenario, summary) = (&run.planned.input.scenario, &run.summary);
                let reasons = summary.reasons.iter().map(|r| output::words::reason(scenario, &summary.metrics, r)).collect();
                Case { summary, name: &run.planned.name, reasons, report: Some(run.planned.folder.path()) }
            })
            .collect();
        if let Err(error) = output::write_junit(path, &cases) {
            let failure =
                Problem::new(Problem::CANNOT_GO_ON, format!("cannot be written: {error}")).about(path.display().to_string());
            problem = Some(match problem {
                Some(before) => before.and(failure),
                None => failure,
            });
        }
    }
    show(args, &finished);
    if let Some(problem) = &problem {
        code = code.max(problem.report(false));
    }
    if args.json {
        let errors = problem.as_ref().map_or(Vec::new(), Problem::to_json);
        print_json(&json!({"runs": finished.iter().map(|run| &run.summary).collect::<Vec<_>>(), "errors": errors}));
    }
    if interrupted {
        eprintln!("interrupted: {} of {count} runs are complete, nothing of the others was kept", finished.len());
        code = INTERRUPTED;
    }
    Ok(code)
}

/// Reads every scenario and makes sure that every folder can be written, before anything runs.
fn plan(args: &RunArgs) -> Result<Vec<Planned>, Problem> {
    let inputs = inputs::read(&args.inputs, &args.overlay)?;
    let mut problem: Option<Problem> = None;
    let mut note = |one: Problem| {
        problem = Some(match problem.take() {
            Some(before) => before.and(one),
            None => one,
        });
    };
    let mut names: BTreeMap<String, std::path::PathBuf> = BTreeMap::new();
    let mut planned = Vec::new();
    for input in inputs {
        let toml = input.scenario.to_toml();
        let name = folder_name(&input.scenario.name, input.changed, input.scenario.seed, &toml);
        if let Some(other) = names.insert(name.clone(), input.file.clone()) {
            let message = format!("its runs' folder would be `{name}`, as that of {}", other.display());
            note(
                Problem::new(Problem::WRONG_INPUT, message)
                    .about(input.file.display().to_string())
                    .help("give one of the two another `name`"),
            );
            continue;
        }
        match RunFolder::prepare(&args.out, &name, &toml, args.force) {
            Ok(folder) => planned.push(Planned { input, name, folder }),
            Err(error) => note(Problem::new(Problem::WRONG_INPUT, error.to_string())),
        }
    }
    if let Some(folder) = args.junit.as_deref().and_then(Path::parent).filter(|folder| folder.is_file()) {
        note(Problem::new(Problem::WRONG_INPUT, "is a file, not a folder").about(folder.display().to_string()));
    }
    problem.map_or(Ok(planned), Err)
}

/// One run from its first frame to its folder.
fn execute(run: &Planned, index: usize, count: usize, args: &RunArgs, rendering: &Rendering) -> Result<Outcome, Problem> {
    let scenario = &run.input.scenario;
    let manifest = Manifest::now(scenario.seed, Rendering::WORD, Some(rendering.adapter()), rendering.threads);
    let progress = Progress::new(&run.name, index, count, distance_to_go_m(scenario), args.quiet);
    let started = Instant::now();
    let limit = args.wall_limit_s.map(Duration::from_secs_f64);
    let mut timed_out = false;
    let result = simulate(scenario, rendering, |record| {
        progress.frame(record, scenario.start.distance_m);
        timed_out = limit.is_some_and(|limit| started.elapsed() >= limit);
        if timed_out || interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let wall_time_s = Some(started.elapsed().as_secs_f64());
    progress.done();
    let (record, summary) = match result {
        Ok(record) if record.end == EndState::BrokenOff && !timed_out => return Ok(Outcome::Interrupted),
        Ok(record) => {
            let summary = Summary::of(scenario, &record, Rendering::WORD, wall_time_s);
            let summary = match args.wall_limit_s {
                Some(limit) if timed_out => {
                    let reached = record.sim_time_s;
                    summary.broken_off(
                        Verdict::Timeout,
                        format!("the limit of {limit} s was reached at {reached:.2} simulated seconds"),
                    )
                }
                _ => summary,
            };
            (record, summary)
        }
        Err(RunFailure { error, record: Some(record) }) => {
            let summary = Summary::of(scenario, &record, Rendering::WORD, wall_time_s);
            let summary = summary.broken_off(Verdict::Error, error.to_string());
            (*record, summary)
        }
        Err(RunFailure { error, record: None }) => {
            return Err(Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(run.input.file.display().to_string()));
        }
    };
    output::write_run(&run.folder, scenario, &record, &summary, &manifest)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(run.name.clone()))?;
    Ok(Outcome::Summary(Box::new(summary)))
}

fn simulate(
    scenario: &Scenario,
    rendering: &Rendering,
    mut watch: impl FnMut(&ductloop::record::FrameRecord) -> ControlFlow<()>,
) -> Result<RunRecord, RunFailure> {
    let mut renderer = ductloop::renderer(&rendering.gpu, scenario)?;
    run_with(scenario, Pilot::of(scenario), &mut renderer, rendering.pace, |record, _| watch(record))
}

fn distance_to_go_m(scenario: &Scenario) -> f64 {
    scenario.duct.network().map_or(0.0, |network| scenario.finish_m(&network) - scenario.start.distance_m)
}

/// Tells people how it went: on standard output, or on standard error where a document goes to standard output.
fn show(args: &RunArgs, finished: &[Finished]) {
    if args.quiet || finished.is_empty() {
        return;
    }
    let rows: Vec<_> = finished.iter().map(|run| (&run.planned.input.scenario, &run.summary)).collect();
    let mut text = verdict_table::show(&rows);
    for run in finished {
        text += &format!("\n{}", run.planned.folder.path().join("report.html").display());
    }
    if args.json {
        eprintln!("{text}");
    } else {
        println!("{text}");
    }
}
