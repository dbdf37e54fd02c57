//! `ductloop run`: scenarios to verdicts.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

use ductloop::output::junit::Case;
use ductloop::output::{self, Summary};
use ductloop::{NavigatorCommand, Verdict};
use serde_json::{Map, json};

use super::args::{Command, RunArgs};
use super::inputs;
use super::jobs;
use super::one_run::{self, Outcome, Terms};
use super::problem::{Problem, Problems};
use super::progress::Progress;
use super::rendering::Rendering;
use super::run_plan::{self, Plan};
use super::seed_verdict::SeedVerdict;
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, interrupt, seed_table, verdict_table, warnings};

/// The list of scenarios in the document of `run --seeds`.
const SEEDS: &str = "seeds";
/// So many runs with seeds are shown run by run as well.
const SHOWN_SINGLY: usize = 20;

/// A run that is over.
pub(crate) struct Finished {
    /// Index of its input.
    pub(crate) input: usize,
    /// The name of its folder.
    pub(crate) name: String,
    /// What it came to.
    pub(crate) summary: Summary,
    /// Its report, if its folder was written.
    pub(crate) report: Option<PathBuf>,
}

/// Carries it out.
///
/// # Errors
/// What keeps any run from beginning.
pub(crate) fn command(args: &RunArgs) -> Result<u8, Problem> {
    let navigator = navigator(args)?;
    let inputs = inputs::read(&args.inputs, &args.overlay)?;
    interrupt::listen();
    let plan = run_plan::plan(args, inputs)?;
    if !args.quiet {
        for input in &plan.inputs {
            warnings::of_start(&input.scenario).iter().for_each(|warning| warning.tell(&input.source));
        }
    }
    let (count, jobs) = (plan.runs.len(), usize::from(args.jobs));
    let at_once = jobs.min(count);
    let rendering = Rendering::open(args.rendering, args.quiet)?.for_jobs(args.rendering, at_once);
    let progress = Progress::new(count, at_once > 1 || (args.seeds.is_some() && count > 1), args.quiet);
    let terms = Terms { args, plan: &plan, rendering: &rendering, navigator: navigator.as_ref(), progress: &progress };
    let outcomes = jobs::carry_out(count, jobs, |index| {
        if interrupt::requested() {
            return ControlFlow::Break(());
        }
        match one_run::execute(&terms, index) {
            Outcome::Over(summary, problem) => ControlFlow::Continue((summary, problem)),
            Outcome::Interrupted => ControlFlow::Break(()),
        }
    });
    progress.done();

    let mut finished = Vec::new();
    let mut problems = Problems::default();
    for (run, (summary, problem)) in plan.runs.iter().zip(outcomes).filter_map(|(run, outcome)| Some((run, outcome?))) {
        let report = problem.is_none().then(|| run_plan::report(&args.out, &run.name));
        finished.push(Finished { input: run.input, name: run.name.clone(), summary: *summary, report });
        problem.into_iter().for_each(|problem| problems.note(problem));
    }
    let scenarios = seed_verdicts(args, &plan, &finished);
    let mut code = exit_code(&finished, scenarios.as_deref());
    if let Err(problem) = write_junit(args, &plan, &finished, scenarios.as_deref()) {
        problems.note(problem);
    }
    if let Err(problem) = show(args, &plan, &finished, scenarios.as_deref()) {
        problems.note(problem);
    }
    let problem = problems.into_inner();
    if let Some(problem) = &problem {
        code = code.max(problem.tell());
    }
    if args.json {
        let mut document = Map::new();
        document.insert(Command::RUNS.into(), json!(finished.iter().map(|run| &run.summary).collect::<Vec<_>>()));
        if let Some(scenarios) = &scenarios {
            document.insert(SEEDS.into(), scenarios.iter().map(SeedVerdict::to_json).collect());
        }
        document.insert("errors".into(), problem.as_ref().map_or(Vec::new(), Problem::to_json).into());
        if let Err(lost) = print_json(&document.into()) {
            code = code.max(lost.tell());
        }
    }
    // A run that was on when it came may be finished all the same: then nothing is missing.
    if finished.len() < count {
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

/// What each scenario came to over its seeds, where seeds were asked for.
fn seed_verdicts<'a>(args: &RunArgs, plan: &'a Plan, finished: &'a [Finished]) -> Option<Vec<SeedVerdict<'a>>> {
    let seeds = args.seeds.as_ref()?.count();
    let at_least = args.at_least.map_or(seeds, |least| least as usize);
    let of = |(index, input): (usize, &'a inputs::Input)| SeedVerdict {
        scenario: &input.scenario,
        seeds,
        at_least,
        runs: finished.iter().filter(|run| run.input == index).collect(),
    };
    Some(plan.inputs.iter().enumerate().map(of).collect())
}

/// Of the worst scenario, where seeds were asked for, else of the worst run.
fn exit_code(finished: &[Finished], scenarios: Option<&[SeedVerdict<'_>]>) -> u8 {
    let verdicts: Vec<Verdict> = match scenarios {
        Some(scenarios) => scenarios.iter().filter_map(SeedVerdict::verdict).collect(),
        None => finished.iter().map(|run| run.summary.verdict).collect(),
    };
    verdicts.into_iter().map(Verdict::exit_code).max().unwrap_or(0)
}

/// Writes the JUnit file that was asked for, if one was.
fn write_junit(args: &RunArgs, plan: &Plan, finished: &[Finished], scenarios: Option<&[SeedVerdict<'_>]>) -> Result<(), Problem> {
    let Some(path) = &args.junit else { return Ok(()) };
    // What is said of a scenario's failures where they do not count.
    let allowed: Vec<Option<String>> = (0..plan.inputs.len())
        .map(|index| {
            let scenario = scenarios.map(|all| &all[index]).filter(|scenario| scenario.enough_passed())?;
            Some(format!("allowed, as {} of {} seeds passed and {} must", scenario.passed(), scenario.seeds, scenario.at_least))
        })
        .collect();
    let case = |run| {
        let Finished { input, name, summary, report }: &Finished = run;
        let scenario = &plan.inputs[*input].scenario;
        let reasons = summary.reasons.iter().map(|r| output::words::reason(scenario, &summary.metrics, r)).collect();
        Case { summary, name, reasons, report: report.as_deref(), allowed: allowed[*input].as_deref() }
    };
    output::write_junit(path, &finished.iter().map(case).collect::<Vec<_>>())
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(format!("--junit {}", path.display())))
}

/// Tells people how it went: on standard output, or on standard error where a document goes to standard output.
fn show(args: &RunArgs, plan: &Plan, finished: &[Finished], scenarios: Option<&[SeedVerdict<'_>]>) -> Result<(), Problem> {
    if args.quiet || finished.is_empty() {
        return Ok(());
    }
    let singly = scenarios.is_none() || finished.len() <= SHOWN_SINGLY;
    let mut text = String::new();
    if singly {
        text += &verdict_table::show(finished.iter().map(|run| &run.summary), scenarios.is_some());
    }
    let mut notable: Vec<&Finished> = if singly { finished.iter().collect() } else { Vec::new() };
    match scenarios {
        None => {
            for run in finished.iter().filter(|run| run.summary.verdict != Verdict::Pass) {
                let scenario = &plan.inputs[run.input].scenario;
                text += &format!("\n{}", verdict_table::reasons(&run.summary.scenario, scenario, &run.summary));
            }
        }
        Some(scenarios) => {
            let line = if singly { "\n" } else { "" };
            text += &format!("{line}{}", seed_table::show(scenarios));
            if !singly {
                notable = scenarios.iter().flat_map(seed_table::notable).collect();
            }
        }
    }
    for report in notable.iter().filter_map(|run| run.report.as_ref()) {
        text += &format!("\n{}", report.display());
    }
    if args.json {
        note(&text);
        Ok(())
    } else {
        print(&text)
    }
}
