//! `ductloop tune`: parameters sought on some ducts, and the find held against the default on others.

use std::path::{Path, PathBuf};

use clap::Args;
use ductloop::output::{folder_name, write_whole};
use ductloop::report;
use ductloop::scenario::shown;
use ductloop::scenario::study_file::StudyFile;
use ductloop::scenario::sweep_file::{Level, SweepFile};
use ductloop::sweep::plan::Plan;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::{Row, Table};
use ductloop::sweep::work::Shard;
use ductloop::tune::candidate;
use ductloop::tune::search::{Search, Trial, search};
use ductloop::tune::summary::{Held, summary, verdict_words};
use ductloop::tune::{comparison, trials};
use serde_json::Value;

use super::args::{OverlayArgs, RendererChoice};
use super::problem::Problem;
use super::rendering::Rendering;
use super::streams::{note, print, print_json};
use super::sweep::args::{SayingArgs, rendering};
use super::sweep::inputs::renderer_id;
use super::sweep::steps;
use super::{INTERRUPTED, destination, interrupt};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop tune scenarios/studies/koh-cho.toml                 best.toml, trials.parquet and report.html in out/koh-cho
  ductloop tune smoke --json                                   a small one; figures as JSON
  ductloop tune koh-cho --set runs=60 --set optimiser=sobol    fewer runs, another way to search
  ductloop run straight-offset --with out/koh-cho/best.toml    what was found, on any scenario

Called again after an interrupt, a crash or a power cut, it goes on from what was run: the same study with the same seed gives the same best
to the bit, on any number of threads. When the find is not better than the default by more than noise on the held-out ducts, it says so.")]
pub(crate) struct TuneArgs {
    /// File of kind `study`, or name of one in ./scenarios/studies
    #[arg(value_name = "FILE|NAME")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// What renders: with the processor results do not depend on the machine
    #[arg(long, value_enum, default_value_t = RendererChoice::Cpu)]
    pub(crate) renderer: RendererChoice,
    /// Folder for the study's folder; it is made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Runs at a time, each on one core; results are the same
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Take the place of another study in its folder; runs that both have are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Refuse what is only warned of: scenarios that are trained on and held out with the same seeds
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

/// Where a name is looked for.
const LIBRARY: &str = "scenarios/studies";
/// The study as it was begun, beside its results.
const STUDY: &str = "study.json";

/// Why the search did not come to its end.
enum Broken {
    Interrupted,
    Problem(Problem),
}

impl From<Problem> for Broken {
    fn from(problem: Problem) -> Self {
        Self::Problem(problem)
    }
}

/// Carries it out.
///
/// # Errors
/// What keeps it from beginning or going on. What is finished is kept.
pub(crate) fn command(args: &TuneArgs) -> Result<u8, Problem> {
    interrupt::listen();
    let path = find(&args.input);
    let study = read(&path, &args.overlay)?;
    overlapping(&study, args, &path)?;
    let rendering = Rendering::open(rendering(args.renderer), args.saying.quiet)?;
    let folder = prepare(&study, args)?;
    let place = folder.join("runs");
    let store = Store::open(&place.display().to_string())
        .map_err(|error| destination::refused("--out", &args.out, error.message.clone()))?;
    match carry_out(&study, &rendering, &store, args) {
        Ok((search, held)) => conclude(&study, &search, held.as_ref(), &folder, &rendering, args),
        Err(Broken::Interrupted) => {
            note("interrupted: what was run is kept; the same call goes on from there");
            Ok(INTERRUPTED)
        }
        Err(Broken::Problem(problem)) => Err(problem),
    }
}

/// Reads a study.
///
/// # Errors
/// Everything that is wrong with it, or an argument that has no meaning here.
pub(super) fn read(path: &Path, overlay: &OverlayArgs) -> Result<StudyFile, Problem> {
    if let Some(pipeline) = &overlay.perception {
        return Err(Problem::new(Problem::WRONG_INPUT, "a study says itself how its scenarios perceive")
            .about(format!("--perception {pipeline}"))
            .help(format!("`--set scenario.perception.pipeline={pipeline}` lays it over every base")));
    }
    StudyFile::read(path, &overlay.overlays()).map_err(|wrong| Problem::in_files(vec![overlay.as_typed(wrong)]))
}

/// What is trained on and held out alike is warned of, or refused.
fn overlapping(study: &StudyFile, args: &TuneArgs, path: &Path) -> Result<(), Problem> {
    let overlaps = study.overlaps();
    if args.strict && !overlaps.is_empty() {
        return Err(Problem::new(Problem::WRONG_INPUT, overlaps.join("; "))
            .about(path.display().to_string())
            .help("give `[held_out]` a `seed` beyond those of `[train]`, or scenarios of its own"));
    }
    for overlap in overlaps {
        note(&format!("warning: {}: {overlap}; what is found there proves nothing (`--strict` refuses it)", path.display()));
    }
    Ok(())
}

/// The study's folder, which is its own.
fn prepare(study: &StudyFile, args: &TuneArgs) -> Result<PathBuf, Problem> {
    destination::folder("--out", &args.out)?;
    let text = serde_json::to_string_pretty(study).unwrap_or_default() + "\n";
    let changed = args.overlay.overlays() != Default::default();
    let folder = args.out.join(folder_name(&study.name, changed, study.seed, &text));
    let file = folder.join(STUDY);
    let refused = |message: String| destination::refused("--out", &args.out, message);
    match std::fs::read_to_string(&file) {
        Ok(there) if there == text => return Ok(folder),
        Ok(_) if !args.force => {
            let message = format!("{} holds another study, or this one as it was before its files changed", folder.display());
            return Err(Problem::new(Problem::WRONG_INPUT, message)
                .help("replace it with --force (runs that both have are kept), or choose another folder with --out"));
        }
        Ok(_) => {}
        Err(_) if folder.read_dir().is_ok_and(|mut entries| entries.next().is_some()) && !args.force => {
            let message =
                format!("{} is not empty and holds no {STUDY}, so it is not a study's and is left alone", folder.display());
            return Err(Problem::new(Problem::WRONG_INPUT, message).help("move it away, or choose another folder with --out"));
        }
        Err(_) => std::fs::create_dir_all(&folder).map_err(|error| refused(format!("{}: {error}", folder.display())))?,
    }
    write_whole(&file, text.as_bytes()).map_err(|error| refused(error.to_string()))?;
    Ok(folder)
}

/// The search, and then both on what was held out.
fn carry_out(study: &StudyFile, rendering: &Rendering, store: &Store, args: &TuneArgs) -> Result<(Search, Option<Held>), Broken> {
    let run = |sweep: SweepFile| rows(sweep, rendering, store, args);
    let found = search(study, run, |trials, best, runs| {
        if !args.saying.quiet {
            note(&progress(study, trials, best, runs));
        }
    })?;
    let Some(values) = found.best.and_then(|best| found.trials[best].values.clone()) else { return Ok((found, None)) };
    if !args.saying.quiet {
        note(&format!(
            "held out: {} runs of the default and of the best",
            study.held_out.bases.len() as u64 * u64::from(study.held_out.replicates)
        ));
    }
    let default = rows(study.held_out.clone(), rendering, store, args)?;
    let best = rows(held_out_with(study, &values), rendering, store, args)?;
    Ok((found, Some(Held::of(study, default, best))))
}

/// The held-out runs of a candidate.
fn held_out_with(study: &StudyFile, values: &[Level]) -> SweepFile {
    let one = ductloop::tune::search::sweep_of(study, std::slice::from_ref(&values.to_vec()), study.held_out.replicates);
    SweepFile { factors: one.factors, ..study.held_out.clone() }
}

/// Carries a sweep out in the study's store, and reads its rows.
fn rows(sweep: SweepFile, rendering: &Rendering, store: &Store, args: &TuneArgs) -> Result<Vec<Row>, Broken> {
    let plan = Plan::of(sweep, &renderer_id(rendering));
    let cannot = |message: String| {
        Problem::new(Problem::CANNOT_GO_ON, message).help("what was run is kept: the same call goes on from there")
    };
    plan.write(store, true).map_err(|error| cannot(error.to_string()))?;
    let silent = SayingArgs { quiet: true, ..args.saying };
    if steps::carry_out(&plan, store, rendering, Shard::ALL, args.threads, silent)?.is_none() {
        return Err(Broken::Interrupted);
    }
    let table = Table::read(&plan, store).map_err(|error| steps::lost(&error))?;
    if table.missing > 0 {
        return Err(cannot(format!("{} of {} runs are missing", table.missing, plan.cases)).into());
    }
    Ok(table.rows)
}

fn progress(study: &StudyFile, trials: &[Trial], best: Option<usize>, runs: u64) -> String {
    let default = trials.first().map_or(f64::NAN, |trial| trial.score.cost);
    let generation = trials.last().map_or(0, |trial| trial.generation);
    let best = best
        .map_or_else(|| "none keeps the constraints".to_owned(), |best| format!("best {}", shown_cost(trials[best].score.cost)));
    format!("generation {generation}: {runs} of {} runs, {best}, default {}", study.runs, shown_cost(default))
}

fn shown_cost(cost: f64) -> String {
    format!("{cost:.4e}").parse::<f64>().map_or_else(|_| "-".to_owned(), shown)
}

/// Writes what came of it, and tells.
fn conclude(
    study: &StudyFile,
    search: &Search,
    held: Option<&Held>,
    folder: &Path,
    rendering: &Rendering,
    args: &TuneArgs,
) -> Result<u8, Problem> {
    let comparison = held.and_then(|held| comparison::Comparison::of(&held.pairs, study.seed));
    let document = summary(study, search, held, comparison.as_ref());
    write(study, search, held, &document, folder, rendering)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, format!("{error:#}")).about(folder.display().to_string()))?;
    if args.saying.json {
        print_json(&document)?;
    }
    if !args.saying.quiet {
        let mut text = String::new();
        if let Some(values) = search.best.and_then(|best| search.trials[best].values.as_ref()) {
            for (parameter, value) in study.parameters.iter().zip(values) {
                text += &format!("{} = {}\n", parameter.path, value.toml());
            }
        }
        for words in verdict_words(study, search, comparison.as_ref()) {
            text += &format!("{words}\n");
        }
        text += &folder.join("report.html").display().to_string();
        if args.saying.json { note(&text) } else { print(&text)? }
    }
    Ok(0)
}

fn write(
    study: &StudyFile,
    search: &Search,
    held: Option<&Held>,
    document: &Value,
    folder: &Path,
    rendering: &Rendering,
) -> anyhow::Result<()> {
    write_whole(&folder.join("trials.parquet"), &trials::parquet(study, &search.trials)?)?;
    let best = folder.join("best.toml");
    match search.best.and_then(|best| search.trials[best].values.as_ref()) {
        Some(values) => {
            let comment =
                format!("Found by `ductloop tune` of the study \"{}\": lay it over a scenario with `--with`.", study.name);
            write_whole(&best, candidate::overlay(&study.parameters, values, &comment).as_bytes())?;
        }
        // One of before is no longer what was found.
        None => drop(std::fs::remove_file(&best)),
    }
    write_whole(&folder.join("summary.json"), format!("{document:#}\n").as_bytes())?;
    let paths = held.map(|held| held.trajectories(study, search, &rendering.engine)).transpose()?;
    write_whole(&folder.join("report.html"), report::tune::html(study, search, document, paths.as_ref())?.as_bytes())?;
    Ok(())
}

/// The file that the input names.
fn find(input: &Path) -> PathBuf {
    let named = Path::new(LIBRARY).join(input).with_extension("toml");
    let is_name = input.components().count() == 1 && input.extension().is_none();
    if is_name && !input.exists() && named.exists() { named } else { input.to_owned() }
}
