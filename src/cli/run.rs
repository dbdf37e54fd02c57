//! `ductloop run`: scenarios to verdicts.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ductloop::closed_loop::{RunFailure, run_with};
use ductloop::output::junit::Case;
use ductloop::output::{self, FolderError, Manifest, RunFolder, Summary, folder_name};
use ductloop::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use ductloop::run_files::write_run;
use ductloop::{NavigatorCommand, Pilot, Scenario, Verdict};
use serde_json::json;

use super::args::{Command, RunArgs};
use super::inputs::{self, Input};
use super::problem::{Problem, Problems};
use super::progress::Progress;
use super::rendering::Rendering;
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, destination, interrupt, verdict_table, warnings};

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
    /// Its report, if its folder was written.
    report: Option<PathBuf>,
}

/// How a run ended, for the command.
enum Outcome {
    /// With figures, and with what kept its folder from being written, if anything did.
    Over(Box<Summary>, Option<Problem>),
    /// By Ctrl-C: nothing is kept.
    Interrupted,
}

/// Carries it out.
///
/// # Errors
/// What keeps any run from beginning.
pub(crate) fn command(args: &RunArgs) -> Result<u8, Problem> {
    let navigator = navigator(args)?;
    let inputs = inputs::read(&args.inputs, &args.overlay)?;
    interrupt::listen();
    let planned = plan(args, inputs)?;
    if !args.quiet {
        for Input { file, scenario, .. } in planned.iter().map(|run| &run.input) {
            warnings::of_start(scenario).iter().for_each(|warning| warning.tell(file));
        }
    }
    let rendering = Rendering::open(args.rendering, args.quiet)?;
    let count = planned.len();
    let mut finished = Vec::new();
    let mut problems = Problems::default();
    let mut interrupted = false;
    for (index, run) in planned.into_iter().enumerate() {
        interrupted = interrupt::requested();
        if interrupted {
            break;
        }
        match execute(&run, index, count, args, &rendering, navigator.as_ref()) {
            Outcome::Over(summary, problem) => {
                let report = problem.is_none().then(|| run.folder.path().join("report.html"));
                finished.push(Finished { planned: run, summary: *summary, report });
                problem.into_iter().for_each(|problem| problems.note(problem));
            }
            Outcome::Interrupted => {
                interrupted = true;
                break;
            }
        }
    }
    let mut code = finished.iter().map(|run| run.summary.verdict.exit_code()).max().unwrap_or(0);
    if let Err(problem) = write_junit(args, &finished) {
        problems.note(problem);
    }
    if let Err(problem) = show(args, &finished) {
        problems.note(problem);
    }
    let problem = problems.into_inner();
    if let Some(problem) = &problem {
        code = code.max(problem.tell());
    }
    if args.json {
        let errors = problem.as_ref().map_or(Vec::new(), Problem::to_json);
        let runs: Vec<_> = finished.iter().map(|run| &run.summary).collect();
        if let Err(lost) = print_json(&json!({Command::RUNS: runs, "errors": errors})) {
            code = code.max(lost.tell());
        }
    }
    if interrupted {
        note(&format!("interrupted: {} of {count} runs are complete, nothing of the others was kept", finished.len()));
        code = INTERRUPTED;
    }
    Ok(code)
}

/// The navigator's program, if one is asked for.
fn navigator(args: &RunArgs) -> Result<Option<NavigatorCommand>, Problem> {
    let Some(line) = &args.navigator else { return Ok(None) };
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(format!("--navigator {line}"));
    // One beyond what a `Duration` holds is none.
    let limit = Duration::try_from_secs_f64(args.navigator_limit_s).unwrap_or(Duration::MAX);
    let command = NavigatorCommand::parse(line, limit).map_err(|error| wrong(error.to_string()))?;
    if command.is_there() {
        Ok(Some(command))
    } else {
        let help = "the first word is a program: a path, or a name that is looked for in PATH";
        Err(wrong(format!("there is no program `{}`", command.program)).help(help))
    }
}

/// Makes sure that everything can be written, before anything runs.
fn plan(args: &RunArgs, inputs: Vec<Input>) -> Result<Vec<Planned>, Problem> {
    destination::folder("--out", &args.out)?;
    let mut problems = Problems::default();
    let mut names: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut planned = Vec::new();
    for input in inputs {
        let toml = input.scenario.to_toml();
        // Another navigator's run has a folder of its own.
        let (changed, told) = match &args.navigator {
            Some(navigator) => (true, format!("{toml}# {navigator}\n")),
            None => (input.changed, toml.clone()),
        };
        let name = folder_name(&input.scenario.name, changed, input.scenario.seed, &told);
        if let Some(other) = names.insert(name.clone(), input.file.clone()) {
            let message = format!("its run's folder would be `{name}`, as that of {}", other.display());
            problems.note(
                Problem::new(Problem::WRONG_INPUT, message)
                    .about(input.file.display().to_string())
                    .help("give one of the two another `name`"),
            );
            continue;
        }
        match RunFolder::prepare(&args.out, &name, &toml, args.force) {
            Ok(folder) => planned.push(Planned { input, name, folder }),
            Err(error @ FolderError::System { .. }) => {
                problems.note(destination::refused("--out", &args.out, error.to_string()));
            }
            Err(error) => problems.note(Problem::new(Problem::WRONG_INPUT, error.to_string())),
        }
    }
    if let Some(path) = &args.junit
        && let Err(problem) = junit_file(path)
    {
        problems.note(problem);
    }
    problems.or(planned)
}

/// Makes sure that the JUnit file can be written. `--junit scenarios/*.toml`, where its name was forgotten, must not write over
/// the first scenario.
fn junit_file(path: &Path) -> Result<(), Problem> {
    if path.extension().is_some_and(|ending| ending == "toml") {
        let wrong = Problem::new(Problem::WRONG_INPUT, "a JUnit file is XML, and this is the name of a scenario file");
        return Err(wrong.about(format!("--junit {}", path.display())).help("as in `--junit out/junit.xml`"));
    }
    destination::file("--junit", path)
}

/// One run from its first frame to its folder.
fn execute(
    run: &Planned,
    index: usize,
    count: usize,
    args: &RunArgs,
    rendering: &Rendering,
    navigator: Option<&NavigatorCommand>,
) -> Outcome {
    let scenario = &run.input.scenario;
    let manifest = Manifest::now(scenario.seed, rendering.engine.word(), rendering.adapter(), rendering.threads.all);
    let manifest = Manifest { navigator: args.navigator.clone(), ..manifest };
    let progress = Progress::new(&run.name, index, count, distance_to_go_m(scenario), args.quiet);
    let started = Instant::now();
    // One beyond what a `Duration` holds is none.
    let limit = args.wall_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok());
    let mut timed_out = false;
    let result = simulate(scenario, rendering, navigator, |record| {
        progress.frame(record, scenario.start.distance_m);
        timed_out = limit.is_some_and(|limit| started.elapsed() >= limit);
        if timed_out || interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let wall_time_s = Some(started.elapsed().as_secs_f64());
    progress.done();
    let cannot_go_on = |error: &dyn std::fmt::Display| {
        Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(run.input.file.display().to_string())
    };
    let (record, mut summary) = match result {
        Ok(record) if record.end == EndState::BrokenOff && !timed_out => return Outcome::Interrupted,
        Ok(record) => {
            let summary = Summary::of(scenario, &record, rendering.engine.word(), wall_time_s);
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
            let summary = Summary::of(scenario, &record, rendering.engine.word(), wall_time_s);
            (*record, summary.broken_off(Verdict::Error, error.to_string()))
        }
        Err(RunFailure { error, record: None }) => {
            let summary = Summary::of(scenario, &never_begun(), rendering.engine.word(), wall_time_s);
            return Outcome::Over(Box::new(summary.broken_off(Verdict::Error, error.to_string())), Some(cannot_go_on(&error)));
        }
    };
    let unwritten = write_run(&run.folder, scenario, &record, &summary, &manifest).err();
    if let Some(error) = &unwritten {
        summary = summary.broken_off(Verdict::Error, error.to_string());
    }
    Outcome::Over(Box::new(summary), unwritten.map(|error| cannot_go_on(&error)))
}

/// The record of a run that failed before its first frame.
fn never_begun() -> RunRecord {
    RunRecord {
        frames: Vec::new(),
        key_frames: KeyFrames::default(),
        end: EndState::Failed,
        sim_time_s: 0.0,
        collisions: Default::default(),
        distance_m: 0.0,
        run_hash: 0,
    }
}

fn simulate(
    scenario: &Scenario,
    rendering: &Rendering,
    navigator: Option<&NavigatorCommand>,
    mut watch: impl FnMut(&FrameRecord) -> ControlFlow<()>,
) -> Result<RunRecord, RunFailure> {
    let mut renderer = rendering.engine.renderer(scenario, rendering.threads.rendering())?;
    let pilot = match navigator {
        Some(program) => program.start(scenario)?,
        None => Pilot::of(scenario),
    };
    run_with(scenario, pilot, renderer.as_mut(), rendering.threads.pace(), |record, _| watch(record))
}

fn distance_to_go_m(scenario: &Scenario) -> f64 {
    scenario.duct.network().map_or(0.0, |network| scenario.finish_m(&network) - scenario.start.distance_m)
}

/// Writes the JUnit file that was asked for, if one was.
fn write_junit(args: &RunArgs, finished: &[Finished]) -> Result<(), Problem> {
    let Some(path) = &args.junit else { return Ok(()) };
    let case = |run| {
        let Finished { planned, summary, report }: &Finished = run;
        let scenario = &planned.input.scenario;
        let reasons = summary.reasons.iter().map(|r| output::words::reason(scenario, &summary.metrics, r)).collect();
        Case { summary, name: &planned.name, reasons, report: report.as_deref() }
    };
    output::write_junit(path, &finished.iter().map(case).collect::<Vec<_>>())
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(format!("--junit {}", path.display())))
}

/// Tells people how it went: on standard output, or on standard error where a document goes to standard output.
fn show(args: &RunArgs, finished: &[Finished]) -> Result<(), Problem> {
    if args.quiet || finished.is_empty() {
        return Ok(());
    }
    let rows: Vec<_> = finished.iter().map(|run| (&run.planned.input.scenario, &run.summary)).collect();
    let mut text = verdict_table::show(&rows);
    for report in finished.iter().filter_map(|run| run.report.as_ref()) {
        text += &format!("\n{}", report.display());
    }
    if args.json {
        note(&text);
        Ok(())
    } else {
        print(&text)
    }
}
