//! `ductloop tune`: parameters sought on some ducts, and the find held against the default on others.

use std::path::{Path, PathBuf};

use ductloop::output::write_whole;
use ductloop::report;
use ductloop::scenario::shown;
use ductloop::scenario::study_file::{Concern, StudyFile};
use ductloop::scenario::sweep_file::{Level, SweepFile};
use ductloop::sweep::plan::Plan;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::{Row, Table};
use ductloop::sweep::work::Shard;
use ductloop::tune::ask_tell::{AskTell, Lost};
use ductloop::tune::held_out::{Held, representatives};
use ductloop::tune::proposer::Proposer;
use ductloop::tune::search::{Search, search, sweep_of};
use ductloop::tune::summary::summary;
use ductloop::tune::verdict::verdict_words;
use ductloop::tune::{candidate, trials};
use serde_json::Value;

use super::args::OverlayArgs;
use super::problem::Problem;
use super::rendering::Rendering;
use super::streams::{note, print, print_json};
use super::sweep::args::{SayingArgs, rendering};
use super::sweep::engine::{Engine, from_anywhere};
use super::sweep::inputs::renderer_id;
use super::sweep::steps;
use super::warnings::Warning;
use super::{INTERRUPTED, destination, interrupt};

mod args;
mod folder;
mod optimiser;

pub(crate) use args::TuneArgs;
use folder::{BEST, FRONT, Folder, REPORT, SUMMARY, TRIALS};

/// Where a name is looked for.
const LIBRARY: &str = "scenarios/studies";

/// What carries the runs out.
struct Means<'a> {
    rendering: Rendering,
    store: Store,
    /// A scheduler; this machine without one.
    engine: Option<Engine>,
    args: &'a TuneArgs,
}

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

impl From<Lost> for Broken {
    fn from(lost: Lost) -> Self {
        if interrupt::requested() { Self::Interrupted } else { Self::Problem(optimiser::lost(lost)) }
    }
}

/// Carries it out.
///
/// # Errors
/// What keeps it from beginning or going on. What is finished is kept.
pub(crate) fn command(args: &TuneArgs) -> Result<u8, Problem> {
    interrupt::listen();
    let path = find(&args.input);
    let driver = args.driver()?;
    let study = StudyFile { driver: driver.as_ref().map(args::Driver::told), ..read(&path, &args.overlay)? };
    concerning(&study, args, &path)?;
    let engine = match args.scheduler()? {
        Some((scheduler, machines)) => Engine::of(Some(scheduler), &machines)?,
        None => None,
    };
    let rendering = Rendering::open(rendering(args.renderer), args.saying.quiet)?;
    let folder = Folder::open(&study, driver.as_ref(), args)?;
    let place = folder.path.join(folder::RUNS).display().to_string();
    let place = if engine.is_some() { from_anywhere(&place)? } else { place };
    let store = Store::open(&place).map_err(|error| destination::refused("--out", &args.out, error.message.clone()))?;
    let means = Means { rendering, store, engine, args };
    let found = match &driver {
        None => {
            folder.begin(args)?;
            means.carry_out(&study, &mut Proposer::of(&study))
        }
        Some(driver) => {
            // One that does not start leaves no study behind.
            let mut outside = match optimiser::start(&study, driver, &folder.path) {
                Err(_) if interrupt::requested() => return Ok(interrupted()),
                started => started?,
            };
            folder.begin(args)?;
            let found = means.carry_out(&study, &mut outside);
            if found.is_ok() {
                optimiser::end(outside);
            }
            found
        }
    };
    match found {
        Ok((search, held)) => conclude(&study, &search, held.as_ref(), &folder.path, &means),
        Err(Broken::Interrupted) => Ok(interrupted()),
        Err(Broken::Problem(problem)) => Err(problem),
    }
}

fn interrupted() -> u8 {
    note("interrupted: what was run is kept; the same call goes on from there");
    INTERRUPTED
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

/// What is hardly meant is warned of, or refused.
fn concerning(study: &StudyFile, args: &TuneArgs, path: &Path) -> Result<(), Problem> {
    let concerns = study.concerns();
    if args.strict && !concerns.is_empty() {
        let joined = |of: &dyn Fn(&Concern) -> String| concerns.iter().map(of).collect::<Vec<_>>().join("; ");
        return Err(Problem::new(Problem::WRONG_INPUT, joined(&|concern| concern.message.clone()))
            .about(path.display().to_string())
            .help(joined(&|concern| concern.help.clone())));
    }
    concerns.into_iter().for_each(|concern| Warning::from(concern).tell(&path.display()));
    Ok(())
}

impl Means<'_> {
    /// The search, and then default and find on what was held out.
    fn carry_out(&self, study: &StudyFile, optimiser: &mut dyn AskTell) -> Result<(Search, Option<Held>), Broken> {
        let quiet = self.args.saying.quiet;
        let found = search(
            study,
            optimiser,
            |sweep| self.rows(sweep),
            |search| {
                if !quiet {
                    note(&progress(study, search));
                }
            },
        )?;
        let chosen = representatives(&found);
        if chosen.is_empty() {
            return Ok((found, None));
        }
        if !quiet {
            let each = study.held_out.bases.len() * study.held_out.replicates as usize;
            note(&format!("held out: {each} runs each of the default and of {}", counted(chosen.len(), "candidate")));
        }
        let default = self.rows(study.held_out.clone())?;
        let mut rows = Vec::new();
        for index in chosen {
            if let Some(values) = &found.trials[index].values {
                rows.push((index, self.rows(held_out_with(study, values))?));
            }
        }
        let held = Held::of(study, default, rows);
        Ok((found, Some(held)))
    }

    /// Carries a sweep out in the study's store, and reads its rows.
    fn rows(&self, sweep: SweepFile) -> Result<Vec<Row>, Broken> {
        let Self { rendering, store, engine, args } = self;
        let plan = Plan::of(sweep, &renderer_id(rendering));
        let cannot = |message: String| {
            Problem::new(Problem::CANNOT_GO_ON, message).help("what was run is kept: the same call goes on from there")
        };
        plan.write(store, true).map_err(|error| cannot(error.to_string()))?;
        let silent = SayingArgs { quiet: true, ..args.saying };
        let gone_on = match engine {
            None => steps::carry_out(&plan, store, rendering, Shard::ALL, args.threads, silent)?.is_some(),
            Some(engine) => engine.carry_out(&plan, store, args.threads, silent)?,
        };
        if !gone_on {
            return Err(Broken::Interrupted);
        }
        let table = Table::read(&plan, store).map_err(|error| steps::lost(&error))?;
        if table.missing > 0 {
            return Err(cannot(format!("{} of {} runs are missing", table.missing, plan.cases)).into());
        }
        Ok(table.rows)
    }
}

/// The held-out runs of a candidate.
fn held_out_with(study: &StudyFile, values: &[Level]) -> SweepFile {
    let one = sweep_of(study, std::slice::from_ref(&values.to_vec()), (1, 1));
    SweepFile { factors: one.factors, design: one.design, ..study.held_out.clone() }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn progress(study: &StudyFile, search: &Search) -> String {
    let costs = |index: usize| -> String {
        let costs: Vec<String> = search.trials[index].costs.objectives.iter().map(|cost| shown_cost(*cost)).collect();
        costs.join(", ")
    };
    let generation = search.trials.last().map_or(0, |trial| trial.generation);
    let best = match search.best {
        None => "none keeps the constraints".to_owned(),
        Some(best) if study.objectives.len() == 1 => format!("best {}", costs(best)),
        Some(best) => format!("{} on the front, compromise {}", search.front.len(), costs(best)),
    };
    format!("generation {generation}: {} of {} runs, {best}, default {}", search.runs, study.runs, costs(0))
}

fn shown_cost(cost: f64) -> String {
    format!("{cost:.4e}").parse::<f64>().map_or_else(|_| "-".to_owned(), shown)
}

/// Writes what came of it, and tells.
fn conclude(study: &StudyFile, search: &Search, held: Option<&Held>, folder: &Path, means: &Means<'_>) -> Result<u8, Problem> {
    let saying = means.args.saying;
    let document = summary(study, search, held);
    write(study, search, held, &document, folder, means)
        .map_err(|error| Problem::new(Problem::CANNOT_GO_ON, format!("{error:#}")).about(folder.display().to_string()))?;
    if saying.json {
        print_json(&document)?;
    }
    if !saying.quiet {
        let mut text = String::new();
        if let Some(values) = search.best.and_then(|best| search.trials[best].values.as_ref()) {
            for (parameter, value) in study.parameters.iter().zip(values) {
                text += &format!("{} = {}\n", parameter.path, value.toml());
            }
        }
        for words in verdict_words(study, search, held) {
            text += &format!("{words}\n");
        }
        text += &folder.join(REPORT).display().to_string();
        if saying.json { note(&text) } else { print(&text)? }
    }
    Ok(0)
}

fn write(
    study: &StudyFile,
    search: &Search,
    held: Option<&Held>,
    document: &Value,
    folder: &Path,
    means: &Means<'_>,
) -> anyhow::Result<()> {
    write_whole(&folder.join(TRIALS), &trials::parquet(study, search)?)?;
    let overlay = |index: usize, what: &str| {
        let values = search.trials[index].values.as_ref()?;
        let comment = format!("{what} by `ductloop tune` of the study \"{}\": lay it over a scenario with `--with`.", study.name);
        Some(candidate::overlay(&study.parameters, values, &comment))
    };
    let best = folder.join(BEST);
    match search.best.and_then(|best| overlay(best, "Found")) {
        Some(text) => write_whole(&best, text.as_bytes())?,
        // One of before is no longer what was found.
        None => drop(std::fs::remove_file(&best)),
    }
    let front = folder.join(FRONT);
    let _ = std::fs::remove_dir_all(&front);
    if study.objectives.len() > 1 {
        std::fs::create_dir_all(&front)?;
        for index in &search.front {
            if let Some(text) = overlay(*index, &format!("Candidate {index}, bettered by no other in every objective")) {
                write_whole(&front.join(format!("{index}.toml")), text.as_bytes())?;
            }
        }
    }
    write_whole(&folder.join(SUMMARY), format!("{document:#}\n").as_bytes())?;
    let paths = held.map(|held| held.trajectories(study, search, &means.rendering.engine)).transpose()?.flatten();
    write_whole(&folder.join(REPORT), report::tune::html(study, search, held, paths.as_ref())?.as_bytes())?;
    Ok(())
}

/// The file that the input names.
fn find(input: &Path) -> PathBuf {
    let named = Path::new(LIBRARY).join(input).with_extension("toml");
    let is_name = input.components().count() == 1 && input.extension().is_none();
    if is_name && !input.exists() && named.exists() { named } else { input.to_owned() }
}
