//! `ductloop check`: are these files right?

use std::path::{Path, PathBuf};

use ductloop::calibrate::gauge::file::GaugeFile;
use ductloop::output::write_whole;
use ductloop::report::network_plan;
use ductloop::scenario::{FileKind, Overlays};
use serde_json::{Value, json};

use super::args::CheckArgs;
use super::problem::{Problem, Problems};
use super::streams::{print, print_json};
use super::warnings::{self, Warning};
use super::{accuracy, inputs, tune};

/// Carries it out.
///
/// # Errors
/// Everything that is wrong with any of the files.
pub(crate) fn command(args: &CheckArgs) -> Result<u8, Problem> {
    // Studies, sweeps and gauges that are named are checked as what they are; folders leave them alone.
    let kind = |input: &PathBuf| if input.is_file() { inputs::kind(input) } else { None };
    let mut scenarios = Vec::new();
    let mut problems = Problems::default();
    let mut rows = Vec::new();
    for input in &args.inputs {
        let row = match kind(input) {
            Some(FileKind::Accuracy) => study(input, args),
            Some(FileKind::Gauge) => gauge(input, args),
            Some(FileKind::Sweep) => sweep(input, args),
            Some(FileKind::Study) => tuning(input, args),
            _ => {
                scenarios.push(input.clone());
                continue;
            }
        };
        match row {
            Ok(row) => rows.push(row),
            Err(problem) => problems.note(problem),
        }
    }
    let inputs = inputs::read(&scenarios, &args.overlay).unwrap_or_else(|problem| {
        problems.note(problem);
        Vec::new()
    });
    let inputs = problems.or(inputs)?;
    if let Some(plan) = &args.plan {
        draw_plans(&inputs, plan)?;
    }
    for input in &inputs {
        let scenario = &input.scenario;
        let length_m = scenario.duct.network().map_or(f64::NAN, |network| network.centreline.length_m());
        let (file, fittings, criteria) = (&input.source, scenario.duct.fittings().len(), scenario.pass.list.len());
        if !args.quiet && !args.json {
            let about = if scenario.about.is_empty() { String::new() } else { format!(": {}", scenario.about) };
            let (name, seed) = (&scenario.name, scenario.seed);
            print(&format!(
                "{file}: ok, `{name}`{about}\n  {length_m:.2} m, fittings: {fittings}, criteria: {criteria}, seed: {seed}"
            ))?;
        }
        let warnings = warnings::of_start(scenario);
        if !args.quiet {
            warnings.iter().for_each(|warning| warning.tell(&input.source));
        }
        rows.push(json!({
            "file": file.to_string(), "scenario": scenario.name, "length_m": length_m, "fittings": fittings, "criteria": criteria,
            "warnings": warnings.iter().map(Warning::to_json).collect::<Vec<_>>(),
        }));
    }
    if args.json {
        print_json(&json!({"scenarios": rows, "errors": []}))?;
    }
    Ok(0)
}

/// Draws each scenario's duct: of one to this file, of several to `plan-NAME.svg` beside it.
fn draw_plans(inputs: &[inputs::Input], plan: &Path) -> Result<(), Problem> {
    for (index, input) in inputs.iter().enumerate() {
        // A scenario that was read has a network.
        let Ok(network) = input.scenario.duct.network() else { continue };
        let name = &input.scenario.name;
        let path = if inputs.len() == 1 {
            plan.to_owned()
        } else {
            let stem = plan.file_stem().unwrap_or_default().to_string_lossy();
            // Two scenarios of one name keep a drawing each.
            let before = inputs[..index].iter().filter(|other| other.scenario.name == *name).count();
            let number = if before == 0 { String::new() } else { format!("-{}", before + 1) };
            plan.with_file_name(format!("{stem}-{name}{number}.svg"))
        };
        write_whole(&path, network_plan::svg(&input.scenario, &network).as_bytes())
            .map_err(|error| Problem::new(Problem::WRONG_INPUT, error.to_string()).about(path.display().to_string()))?;
    }
    Ok(())
}

/// A sweep: its row of the document. All of its bases are checked with it, and its points as far as a plan looks at them.
fn sweep(file: &Path, args: &CheckArgs) -> Result<Value, Problem> {
    let plan = super::sweep::read(file, &args.overlay, args.quiet)?;
    let (sweep, points, cases) = (&plan.sweep, plan.points, plan.cases);
    if !args.quiet && !args.json {
        let about = if sweep.about.is_empty() { String::new() } else { format!(": {}", sweep.about) };
        let (file, name, seed, design) = (file.display(), &sweep.name, sweep.seed, sweep.design.word());
        print(&format!("{file}: ok, `{name}`{about}\n  {design}: {points} points, {cases} cases, seed: {seed}"))?;
    }
    Ok(json!({"file": file.display().to_string(), "sweep": sweep.name, "points": points, "cases": cases}))
}

/// An accuracy study: its row of the document.
fn study(file: &Path, args: &CheckArgs) -> Result<Value, Problem> {
    let study = accuracy::read(file, &args.overlay)?;
    let (cells, poses) = (study.cells.len(), study.poses.count * study.cells.len() as u64);
    if !args.quiet && !args.json {
        let about = if study.about.is_empty() { String::new() } else { format!(": {}", study.about) };
        let (file, name, seed, bounds) = (file.display(), &study.name, study.seed, study.pass.len());
        print(&format!("{file}: ok, `{name}`{about}\n  cells: {cells}, poses: {poses}, bounds: {bounds}, seed: {seed}"))?;
    }
    Ok(json!({
        "file": file.display().to_string(), "accuracy": study.name, "cells": cells, "poses": poses, "bounds": study.pass.len(),
        "warnings": [],
    }))
}

/// A tuning study: its row of the document.
fn tuning(file: &Path, args: &CheckArgs) -> Result<Value, Problem> {
    let study = tune::read(file, &args.overlay)?;
    let (parameters, runs) = (study.parameters.len(), study.runs);
    let warnings: Vec<Warning> = study.concerns().into_iter().map(Warning::from).collect();
    if !args.quiet && !args.json {
        let about = if study.about.is_empty() { String::new() } else { format!(": {}", study.about) };
        let (file, name, optimiser, seed) = (file.display(), &study.name, study.optimiser.word(), study.seed);
        print(&format!("{file}: ok, `{name}`{about}\n  parameters: {parameters}, {optimiser}, {runs} runs, seed: {seed}"))?;
    }
    if !args.quiet {
        warnings.iter().for_each(|warning| warning.tell(&file.display()));
    }
    Ok(json!({
        "file": file.display().to_string(), "study": study.name, "parameters": parameters, "runs": runs,
        "warnings": warnings.iter().map(Warning::to_json).collect::<Vec<_>>(),
    }))
}

/// An experiment with a gauge: its row of the document.
fn gauge(file: &Path, args: &CheckArgs) -> Result<Value, Problem> {
    if args.overlay.overlays() != Overlays::default() {
        let message = "nothing can be laid over an experiment with a gauge";
        let problem = Problem::new(Problem::WRONG_INPUT, message).about(file.display().to_string());
        return Err(problem.help("check it by itself"));
    }
    let GaugeFile { scenario, gauge } = GaugeFile::read(file).map_err(|wrong| Problem::in_files(vec![wrong]))?;
    let (lasers, points) = (gauge.laser.len(), gauge.laser.iter().map(|laser| laser.points_mm.len()).sum::<usize>());
    if !args.quiet && !args.json {
        let (file, name, seed) = (file.display(), &scenario.name, scenario.seed);
        print(&format!("{file}: ok, `{name}`: an experiment with a gauge\n  lasers: {lasers}, points: {points}, seed: {seed}"))?;
    }
    Ok(json!({
        "file": file.display().to_string(), "gauge": scenario.name, "lasers": lasers, "points": points, "warnings": [],
    }))
}
