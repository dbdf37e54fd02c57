//! One run from its first frame to its folder.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use ductloop::closed_loop::{RunFailure, run_with};
use ductloop::output::{Manifest, Summary};
use ductloop::record::{EndState, FrameRecord, KeyFrames, RunRecord};
use ductloop::run_files::write_run;
use ductloop::{NavigatorCommand, Pilot, Scenario, Verdict};

use super::args::RunArgs;
use super::interrupt;
use super::problem::Problem;
use super::progress::Progress;
use super::rendering::Rendering;
use super::run_plan::Plan;

/// What all runs of a call have in common.
pub(crate) struct Terms<'a> {
    /// What was typed.
    pub(crate) args: &'a RunArgs,
    /// The runs.
    pub(crate) plan: &'a Plan,
    /// What renders.
    pub(crate) rendering: &'a Rendering,
    /// The navigator's program, if there is one: each run starts its own.
    pub(crate) navigator: Option<&'a NavigatorCommand>,
    /// What people see meanwhile.
    pub(crate) progress: &'a Progress,
}

/// How a run ended, for the command. Its frames are in its folder; here they are no longer kept.
pub(crate) enum Outcome {
    /// With figures, and with what kept its folder from being written, if anything did.
    Over(Box<Summary>, Option<Problem>),
    /// By Ctrl-C: nothing is kept.
    Interrupted,
}

/// Carries out run `index` of the plan.
pub(crate) fn execute(terms: &Terms<'_>, index: usize) -> Outcome {
    let Terms { args, plan, rendering, navigator, progress } = *terms;
    let run = &plan.runs[index];
    let scenario = plan.scenario(run);
    let manifest = Manifest::now(scenario.seed, rendering.engine.word(), rendering.adapter(), rendering.threads.all);
    let manifest = Manifest { navigator: args.navigator.clone(), ..manifest };
    let mut progress = progress.run(&run.name, index, scenario.start.distance_m, distance_to_go_m(&scenario));
    let started = Instant::now();
    // One beyond what a `Duration` holds is none.
    let limit = args.wall_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok());
    let mut timed_out = false;
    let result = simulate(&scenario, rendering, navigator, |record| {
        progress.frame(record);
        timed_out = limit.is_some_and(|limit| started.elapsed() >= limit);
        if timed_out || interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let wall_time_s = Some(started.elapsed().as_secs_f64());
    let outcome = match result {
        Ok(record) if record.end == EndState::BrokenOff && !timed_out => Outcome::Interrupted,
        Ok(record) => {
            let summary = Summary::of(&scenario, &record, rendering.engine.word(), wall_time_s);
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
            written(terms, index, &scenario, &record, summary, &manifest)
        }
        Err(RunFailure { error, record: Some(record) }) => {
            let summary = Summary::of(&scenario, &record, rendering.engine.word(), wall_time_s);
            let summary = summary.broken_off(Verdict::Error, error.to_string());
            written(terms, index, &scenario, &record, summary, &manifest)
        }
        Err(RunFailure { error, record: None }) => {
            let summary = Summary::of(&scenario, &never_begun(), rendering.engine.word(), wall_time_s);
            let summary = summary.broken_off(Verdict::Error, error.to_string());
            Outcome::Over(Box::new(summary), Some(cannot_go_on(terms, index, &error)))
        }
    };
    progress.done(match &outcome {
        Outcome::Over(summary, _) => Some(summary.verdict),
        Outcome::Interrupted => None,
    });
    outcome
}

/// Writes the folder of a run that was simulated.
fn written(
    terms: &Terms<'_>,
    index: usize,
    scenario: &Scenario,
    record: &RunRecord,
    summary: Summary,
    manifest: &Manifest,
) -> Outcome {
    let folder = terms.plan.out.folder(&terms.plan.runs[index].name, &scenario.to_toml());
    match write_run(&folder, scenario, record, &summary, manifest) {
        Ok(()) => Outcome::Over(Box::new(summary), None),
        Err(error) => {
            let summary = summary.broken_off(Verdict::Error, error.to_string());
            Outcome::Over(Box::new(summary), Some(cannot_go_on(terms, index, &error)))
        }
    }
}

fn cannot_go_on(terms: &Terms<'_>, index: usize, error: &dyn std::fmt::Display) -> Problem {
    let source = &terms.plan.input(&terms.plan.runs[index]).source;
    Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(source.to_string())
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
        notes: Default::default(),
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
