//! One call for library users: run a scenario with a navigator, get verdict and figures.

use std::ops::ControlFlow;
use std::time::Instant;

use crate::closed_loop::{RunFailure, run_with};
use crate::engine::{Engine, Threads};
use crate::metrics::{Metrics, Reason, Verdict, judge};
use crate::pilot::Pilot;
use crate::record::RunRecord;
use crate::scenario::Scenario;

/// What a run came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Whether every criterion of the scenario held.
    pub verdict: Verdict,
    /// Those that did not.
    pub reasons: Vec<Reason>,
    /// The run's figures.
    pub metrics: Metrics,
    /// Every frame.
    pub record: RunRecord,
}

/// Runs a scenario with the given navigator on a graphics adapter of hardware if there is one, else on the processor
/// ([`Engine::auto`]). Nothing is written.
///
/// # Errors
/// Where the run could not go on.
pub fn run(scenario: &Scenario, pilot: impl Into<Pilot>) -> Result<Outcome, RunFailure> {
    run_on(&Engine::auto(), scenario, pilot)
}

/// The same on an engine that the caller has opened: for many runs, or for the same results on every x86-64 machine ([`Engine::Cpu`]).
///
/// # Errors
/// Where the run could not go on.
pub fn run_on(engine: &Engine, scenario: &Scenario, pilot: impl Into<Pilot>) -> Result<Outcome, RunFailure> {
    let threads = Threads::here();
    let mut renderer = engine.renderer(scenario, threads.rendering())?;
    let started = Instant::now();
    let record = run_with(scenario, pilot.into(), renderer.as_mut(), threads.pace(), |_, _| ControlFlow::Continue(()))?;
    let metrics = Metrics::of(scenario, &record, Some(started.elapsed().as_secs_f64()));
    let (verdict, reasons) = judge(scenario, &record, &metrics);
    Ok(Outcome { verdict, reasons, metrics, record })
}
