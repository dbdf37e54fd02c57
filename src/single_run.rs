//! One call for library users: run a scenario with a navigator, get verdict and figures.

use std::ops::ControlFlow;
use std::time::Instant;

use ductloop_sensor::WgpuRenderer;
use ductloop_sensor::gpu::Gpu;

use crate::closed_loop::{Pace, RunError, RunFailure, run_with};
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

/// Runs a scenario with the given navigator on whatever graphics adapter there is. Nothing is written.
///
/// # Errors
/// Where there is no adapter, or the run could not go on.
pub fn run(scenario: &Scenario, pilot: impl Into<Pilot>) -> Result<Outcome, RunFailure> {
    let gpu = Gpu::open()?;
    let mut renderer = renderer(&gpu, scenario)?;
    let started = Instant::now();
    let record = run_with(scenario, pilot.into(), &mut renderer, Pace::Overlapped, |_, _| ControlFlow::Continue(()))?;
    let metrics = Metrics::of(scenario, &record, Some(started.elapsed().as_secs_f64()));
    let (verdict, reasons) = judge(scenario, &record, &metrics);
    Ok(Outcome { verdict, reasons, metrics, record })
}

/// The wgpu renderer of a scenario's duct, seen by its true rig.
///
/// # Errors
/// Where the duct or the rig cannot be rendered, or the device fails.
pub fn renderer(gpu: &Gpu, scenario: &Scenario) -> Result<WgpuRenderer, RunError> {
    let network = scenario.duct.network()?;
    let looks: Vec<_> = scenario.surfaces.iter().map(|surface| surface.look).collect();
    Ok(WgpuRenderer::new(gpu, &network, &scenario.actual_rig(), &scenario.optics, &looks, scenario.seed)?)
}
