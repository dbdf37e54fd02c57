//! `ductloop accuracy`: a grid of poses, each rendered, read and held against the truth.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use ductloop::Verdict;
use ductloop::accuracy::verdict::{self, Miss};
use ductloop::accuracy::{TrialError, Trials, again, all_stand, carry_out};
use ductloop::engine::Threads;
use ductloop::output::{FolderError, Manifest, RunFolder, folder_name};
use ductloop::report;
use ductloop::scenario::accuracy_file::AccuracyFile;
use ductloop::scenario::{Pipeline, shown};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Map, Value, json};

use super::args::OverlayArgs;
use super::problem::Problem;
use super::streams::{note, print, print_json};
use super::{INTERRUPTED, accuracy_table, destination, interrupt};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop accuracy scenarios/studies/accuracy.toml                      table; tables and heat maps in out/accuracy
  ductloop accuracy accuracy --set poses.count=50 --json                 fewer poses; figures as JSON
  ductloop accuracy accuracy --set 'pipelines=[\"paper\"]'                 one pipeline only

Images are made by the processor, so that figures do not depend on the machine.")]
pub(crate) struct AccuracyArgs {
    /// File of kind `accuracy`, or name of one in ./scenarios/studies
    #[arg(value_name = "FILE|NAME")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Threads; results are the same
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Folder for the study's folder; it is made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Replace the folder of another study
    #[arg(long)]
    pub(crate) force: bool,
}

/// Where a name is looked for.
const LIBRARY: &str = "scenarios/studies";

/// Carries it out.
///
/// # Errors
/// A file that is wrong, a folder that cannot be written, a pose at which there is no image.
pub(crate) fn command(args: &AccuracyArgs) -> Result<u8, Problem> {
    let path = find(&args.input);
    let changed = args.overlay.overlays() != Default::default();
    let file = read(&path, &args.overlay)?;
    destination::folder("--out", &args.out)?;
    let toml = file.to_toml();
    let folder = RunFolder::prepare(&args.out, &folder_name(&file.name, changed, file.seed, &toml), &toml, args.force).map_err(
        |error| match error {
            FolderError::System { .. } => destination::refused("--out", &args.out, error.to_string()),
            error => Problem::new(Problem::WRONG_INPUT, error.to_string()),
        },
    )?;
    let threads = args.threads.map_or_else(Threads::here, |n| Threads { all: n.into() });
    interrupt::listen();
    let manifest = Manifest::now(file.seed, "cpu", None, threads.all);
    let Some(trials) = measure(&file, threads.all, args.quiet, &path)? else {
        note("interrupted: nothing was kept");
        return Ok(INTERRUPTED);
    };

    let summary = summary(&file, &trials);
    let misses = misses(&file, &summary);
    let summary = with_verdict(summary, &misses);
    write(&folder, &file, &toml, &trials, &summary, &manifest)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, format!("{error:#}")).about(path.display().to_string()))?;
    if args.json {
        print_json(&summary)?;
    }
    if !args.quiet {
        let mut text = accuracy_table::show(&file, &summary);
        for miss in &misses {
            text += &format!("\n{}", words(miss));
        }
        text += &format!("\n{}", folder.path().join("report.html").display());
        if args.json { note(&text) } else { print(&text)? }
    }
    Ok(if misses.is_empty() { Verdict::Pass } else { Verdict::Fail }.exit_code())
}

/// Reads a study, and makes sure that all of its poses can be rendered.
///
/// # Errors
/// Everything that is wrong with the file, an argument that has no meaning here, the first pose outside the duct.
pub(super) fn read(path: &Path, overlay: &OverlayArgs) -> Result<AccuracyFile, Problem> {
    if let Some(pipeline) = &overlay.perception {
        let message = "a study says itself which pipelines read its frames, several of them";
        return Err(Problem::new(Problem::WRONG_INPUT, message)
            .about(format!("--perception {pipeline}"))
            .help(format!("`--set 'pipelines=[\"{pipeline}\"]'` has this one alone read them")));
    }
    let file = AccuracyFile::read(path, &overlay.overlays()).map_err(|wrong| Problem::in_files(vec![overlay.as_typed(wrong)]))?;
    all_stand(&file).map_err(|error| cannot_stand(&error, path))?;
    Ok(file)
}

fn cannot_stand(error: &TrialError, path: &Path) -> Problem {
    Problem::new(Problem::WRONG_INPUT, error.to_string())
        .about(path.display().to_string())
        .help("`[poses]`, `[start]` and `[grid]` say where the camera is; it must stand inside the duct")
}

/// The file that the input names.
fn find(input: &Path) -> PathBuf {
    let named = Path::new(LIBRARY).join(input).with_extension("toml");
    let is_name = input.components().count() == 1 && input.extension().is_none();
    if is_name && !input.exists() && named.exists() { named } else { input.to_owned() }
}

/// Every frame; `None` if it was interrupted.
fn measure(file: &AccuracyFile, threads: usize, quiet: bool, path: &Path) -> Result<Option<Trials>, Problem> {
    let count = file.poses.count * file.cells.len() as u64;
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
    let bar = ProgressBar::with_draw_target(Some(count), target);
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} poses  {elapsed} (left {eta})");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let result = carry_out(file, threads, |done| {
        bar.set_position(done as u64);
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    result.map_err(|error| cannot_stand(&error, path))
}

/// The document: figures of all, and of each cell.
fn summary(file: &AccuracyFile, trials: &Trials) -> Value {
    let pipelines = |cell: Option<usize>| -> Value {
        let figures = file
            .pipelines
            .iter()
            .map(|pipeline| (pipeline.word().to_owned(), verdict::document(&trials.figures(cell, *pipeline))));
        figures.collect::<Map<_, _>>().into()
    };
    let cells: Vec<Value> = file
        .cells
        .iter()
        .enumerate()
        .map(|(index, cell)| {
            let values: Map<_, _> = cell.values.iter().map(|(path, value)| (path.clone(), json!(value))).collect();
            json!({"cell": index, "values": values, "pipelines": pipelines(Some(index))})
        })
        .collect();
    json!({
        "format": 1,
        "name": file.name,
        "seed": file.seed,
        "poses": trials.list.len(),
        "pipelines": pipelines(None),
        "cells": cells,
    })
}

fn misses(file: &AccuracyFile, summary: &Value) -> Vec<Miss> {
    verdict::misses(&file.pass, |bound| summary.get("pipelines")?.get(bound.pipeline.word()))
}

fn with_verdict(mut summary: Value, misses: &[Miss]) -> Value {
    summary["verdict"] = json!(if misses.is_empty() { "pass" } else { "fail" });
    summary["reasons"] = misses
        .iter()
        .map(|miss| {
            let bound = &miss.bound;
            json!({"pipeline": bound.pipeline.word(), "bound": bound.bound.key, "value": miss.value, "limit": bound.value})
        })
        .collect();
    summary
}

fn words(miss: &Miss) -> String {
    let bound = &miss.bound;
    let value = miss.value.map_or("not measured".to_owned(), |value| format!("{value:.4}"));
    let word = if bound.bound.is_least() { "least" } else { "most" };
    format!("FAIL {}: {} is {value}, {word} {}", bound.pipeline.word(), bound.bound.key, shown(bound.value))
}

/// Poses that somebody will want to see: of each pipeline those that are confident and wrong, the first of them, and the worst.
fn notable(file: &AccuracyFile, trials: &Trials) -> BTreeSet<(usize, u64, Pipeline)> {
    const CONFIDENT_AND_WRONG: usize = 8;
    let mut poses = BTreeSet::new();
    for pipeline in &file.pipelines {
        let figures = trials.figures(None, *pipeline);
        let worst = [&figures.wall_distance, &figures.heading, &figures.lateral].map(|spread| spread.worst_at());
        let wrong = figures.beyond_6_sigma.iter().take(CONFIDENT_AND_WRONG).copied();
        poses.extend(worst.into_iter().flatten().chain(wrong).map(|(cell, index)| (cell, index, *pipeline)));
    }
    poses
}

fn write(
    folder: &RunFolder,
    file: &AccuracyFile,
    toml: &str,
    trials: &Trials,
    summary: &Value,
    manifest: &Manifest,
) -> anyhow::Result<()> {
    folder.write("scenario.toml", toml.as_bytes())?;
    folder.write("manifest.json", manifest.to_json()?.as_bytes())?;
    folder.write("accuracy.parquet", &ductloop::output::accuracy::parquet(file, trials)?)?;
    for (cell, index, pipeline) in notable(file, trials) {
        let frame = again(&file.cells[cell].scenario, &file.poses, index, pipeline)?;
        let name = format!("poses/{cell:03}-{index:06}-{}", pipeline.word());
        folder.write(&format!("{name}.png"), &ductloop::picture::overlay_png(&frame.image, &frame.lines)?)?;
        folder.write(&format!("{name}.toml"), frame.scenario.to_toml().as_bytes())?;
    }
    let maps = report::accuracy_maps::heat_maps(file, trials);
    for (name, map) in maps.iter().flat_map(|cell| &cell.maps) {
        folder.write(&format!("maps/{name}.svg"), map.svg().as_bytes())?;
    }
    folder.write("report.html", report::accuracy::html(file, summary, &maps)?.as_bytes())?;
    folder.write("summary.json", format!("{summary:#}\n").as_bytes())?;
    Ok(folder.publish()?)
}
