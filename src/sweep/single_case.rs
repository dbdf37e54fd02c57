//! One case to its outcome.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use super::case::Case;
use super::outcome::{Outcome, numbers};
use crate::closed_loop::{RunError, RunFailure, run_unscored};
use crate::engine::Engine;
use crate::metrics::{Metrics, Verdict, judge};
use crate::pilot::Pilot;
use crate::record::{EndState, RunRecord};
use crate::scenario::sweep_file::SweepFile;
use crate::scenario::{Diagnostics, Scenario};

/// What became of the attempt.
#[derive(Debug)]
pub enum Attempt {
    /// The case has its outcome.
    Over(Box<Outcome>),
    /// The caller broke it off.
    BrokenOff,
    /// The machine, not the case, kept it from going on: a lost graphics adapter.
    Lost(RunError),
}

/// Runs a case on one thread. A case that cannot go on, or takes longer than the sweep's limit, has that as its outcome. `watch` may
/// break it off.
pub fn run(sweep: &SweepFile, case: &Case, engine: &Engine, host: &str, watch: impl Fn() -> ControlFlow<()>) -> Attempt {
    let started = Instant::now();
    let none = |verdict, error: String| Outcome {
        hash: case.hash,
        verdict,
        reasons: String::new(),
        end_state: None,
        metrics: Default::default(),
        run_hash: None,
        error: Some(error),
        wall_time_s: started.elapsed().as_secs_f64(),
        host: host.to_owned(),
    };
    let over = |outcome| Attempt::Over(Box::new(outcome));
    let scenario = match sweep.scenario(case.at.base, &case.settings, case.seed) {
        Ok(scenario) => scenario,
        Err(wrong) => return over(none(Verdict::Error, format!("no scenario: {}", in_a_line(&wrong)))),
    };
    // One beyond what a `Duration` holds is none.
    let limit = sweep.wall_limit_s.and_then(|limit| Duration::try_from_secs_f64(limit).ok());
    let mut timed_out = false;
    let simulate = || -> Result<RunRecord, RunFailure> {
        let mut renderer = engine.renderer(&scenario, 1)?;
        run_unscored(&scenario, Pilot::of(&scenario), renderer.as_mut(), |_, _| {
            timed_out = limit.is_some_and(|limit| started.elapsed() >= limit);
            if timed_out { ControlFlow::Break(()) } else { watch() }
        })
    };
    match catch_unwind(AssertUnwindSafe(simulate)) {
        Err(panic) => over(none(Verdict::Error, format!("the simulation has a fault of its own: {}", words(panic.as_ref())))),
        Ok(Ok(record)) if record.end == EndState::BrokenOff && !timed_out => Attempt::BrokenOff,
        Ok(Ok(record)) if timed_out => {
            // How far it came depends on the machine: nothing of that is kept.
            let limit = sweep.wall_limit_s.unwrap_or_default();
            let end_state = Some(record.end.word().to_owned());
            over(Outcome { end_state, ..none(Verdict::Timeout, format!("not over after {limit} s")) })
        }
        Ok(Ok(record)) => over(judged(case, &scenario, &record, none(Verdict::Pass, String::new()))),
        Ok(Err(RunFailure { error: error @ RunError::Render(_), .. })) if !matches!(engine, Engine::Cpu) => Attempt::Lost(error),
        Ok(Err(RunFailure { error, record: Some(record) })) => {
            let judged = judged(case, &scenario, &record, none(Verdict::Error, error.to_string()));
            over(Outcome {
                verdict: Verdict::Error,
                reasons: String::new(),
                run_hash: None,
                error: Some(error.to_string()),
                ..judged
            })
        }
        Ok(Err(RunFailure { error, record: None })) => over(none(Verdict::Error, error.to_string())),
    }
}

fn judged(case: &Case, scenario: &Scenario, record: &RunRecord, blank: Outcome) -> Outcome {
    let metrics = Metrics::of(scenario, record, None);
    let (verdict, reasons) = judge(scenario, record, &metrics);
    Outcome {
        hash: case.hash,
        verdict,
        reasons: reasons.iter().map(|reason| reason.metric.as_str()).collect::<Vec<_>>().join(", "),
        end_state: Some(metrics.end_state.to_owned()),
        metrics: numbers(&metrics),
        run_hash: Some(format!("{:032x}", record.run_hash)),
        error: None,
        ..blank
    }
}

/// What is wrong with a scenario, in a line.
pub fn in_a_line(wrong: &Diagnostics) -> String {
    wrong.0.iter().map(|one| one.message.as_str()).collect::<Vec<_>>().join("; ")
}

/// What a panic said.
fn words(panic: &(dyn std::any::Any + Send)) -> &str {
    match (panic.downcast_ref::<&str>(), panic.downcast_ref::<String>()) {
        (Some(text), _) => text,
        (_, Some(text)) => text,
        _ => "it does not say which",
    }
}
