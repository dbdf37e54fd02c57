//! The steps of a sweep, alone and all of them.

use std::ops::ControlFlow;

use ductloop::engine::Threads;
use ductloop::output::folder_name;
use ductloop::sweep::ledger::{self, Damaged};
use ductloop::sweep::plan::{Plan, PlanError};
use ductloop::sweep::store::{Store, StoreError};
use ductloop::sweep::table::{self, Table};
use ductloop::sweep::work::{self, Means, Shard, Tally, WorkError};
use serde_json::json;

use super::args::{FileArgs, MergeArgs, PlaceArgs, PlanArgs, SayingArgs, WholeArgs, WorkArgs, rendering};
use super::bar::Bar;
use super::engine::{self, Engine};
use super::inputs::{self, Planned, renderer_id};
use super::verdict;
use crate::cli::args::RendererChoice;
use crate::cli::problem::Problem;
use crate::cli::rendering::Rendering;
use crate::cli::streams::{note, print, print_json};
use crate::cli::{INTERRUPTED, destination, interrupt};

/// All steps, on this machine or those of a scheduler.
pub(super) fn whole(args: &WholeArgs) -> Result<u8, Problem> {
    let engine = Engine::of(args.engine.engine, &args.engine.machines)?;
    let Planned { plan, rendering, changed } = inputs::planned(&args.file, args.saying.quiet)?;
    let name = folder_name(&plan.sweep.name, changed, plan.sweep.seed, &plan.identity());
    let out = if engine.is_some() { engine::from_anywhere(&args.out)? } else { args.out.clone() };
    let place = format!("{}/{name}", out.trim_end_matches('/'));
    let store = write_plan(&plan, &place, &args.file, "--out")?;
    let gone_on = match engine {
        None => carry_out(&plan, &store, &rendering, Shard::ALL, args.threads, args.saying)?.is_some(),
        Some(engine) => engine.carry_out(&plan, &store, args.threads, args.saying)?,
    };
    if !gone_on {
        return Ok(INTERRUPTED);
    }
    let table = Table::read(&plan, &store).map_err(|error| lost(&error))?;
    verdict::conclude(&plan, &store, &table, args.saying)
}

/// `sweep plan`.
pub(super) fn plan(args: &PlanArgs) -> Result<u8, Problem> {
    let Planned { plan, .. } = inputs::planned(&args.file, args.saying.quiet)?;
    let store = write_plan(&plan, &args.out, &args.file, "--out")?;
    let list = table::list(&plan).map_err(|error| Problem::new(Problem::CANNOT_GO_ON, error.to_string()))?;
    store.replace("cases.parquet", list).map_err(|error| unwritable(&error, "--out"))?;
    if args.saying.json {
        print_json(&json!({
            "format": 1, "sweep": plan.sweep.name, "place": args.out, "points": plan.points, "cases": plan.cases, "renderer": plan.renderer,
            "build": plan.build,
        }))?;
    }
    if !args.saying.quiet {
        let Plan { points, cases, .. } = plan;
        let text = format!("{}: {cases} cases at {points} points\n`ductloop sweep work {}` runs them", plan.sweep.name, args.out);
        if args.saying.json { note(&text) } else { print(&text)? }
    }
    Ok(0)
}

/// `sweep work`.
pub(super) fn work(args: &WorkArgs) -> Result<u8, Problem> {
    let (plan, store) = open(&args.place)?;
    if args.shard.count > plan.points {
        let message = format!("the plan has {} points, which cannot be shared out to {}", plan.points, args.shard.count);
        return Err(
            Problem::new(Problem::WRONG_INPUT, message).about(format!("--shard {}/{}", args.shard.index, args.shard.count))
        );
    }
    let choice = if plan.renderer == "cpu" { RendererChoice::Cpu } else { RendererChoice::Wgpu };
    let rendering = Rendering::open(rendering(choice), true)?;
    if renderer_id(&rendering) != plan.renderer {
        let message = format!("the plan is for {}, and here renders {}", plan.renderer, renderer_id(&rendering));
        return Err(Problem::new(Problem::CANNOT_GO_ON, message).about(args.place.clone()).help("plan with `--renderer cpu`"));
    }
    let Some(tally) = carry_out(&plan, &store, &rendering, args.shard, args.threads, args.saying)? else {
        return Ok(INTERRUPTED);
    };
    let Tally { done, found, failed, .. } = tally;
    if args.saying.json {
        print_json(&json!({"cases": done, "found": found, "ran": done - found, "failed": failed}))?;
    }
    if !args.saying.quiet {
        let text = format!("{} cases run, {found} were done before; {failed} of all did not pass", done - found);
        if args.saying.json { note(&text) } else { print(&text)? }
    }
    Ok(0)
}

/// `sweep status`.
pub(super) fn status(args: &PlaceArgs) -> Result<u8, Problem> {
    let (plan, store) = open(&args.place)?;
    let table = Table::read(&plan, &store).map_err(|error| lost(&error))?;
    verdict::tell_damage(&store, &table.damaged);
    let done = table.rows.len();
    let failed = table.rows.iter().filter(|row| !row.outcome.passed()).count();
    let Table { missing, spared, damaged, .. } = &table;
    if args.saying.json {
        print_json(&json!({
            "format": 1, "sweep": plan.sweep.name, "cases": plan.cases, "done": done, "failed": failed, "missing": missing, "spared": spared,
            "damaged": damaged.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(),
        }))?;
    } else if !args.saying.quiet {
        let spared = if *spared > 0 { format!(", {spared} spared by the stopping rule") } else { String::new() };
        print(&format!(
            "{}: {done} of {} cases done, {failed} of them failed, {missing} to do{spared}",
            plan.sweep.name, plan.cases
        ))?;
    }
    Ok(0)
}

/// `sweep merge`.
pub(super) fn merge(args: &MergeArgs) -> Result<u8, Problem> {
    let (plan, store) = open(&args.place.place)?;
    let table = Table::read(&plan, &store).map_err(|error| lost(&error))?;
    verdict::tell_damage(&store, &table.damaged);
    if table.missing > 0 && !args.partial {
        let message = format!("{} of {} cases are not done", table.missing, plan.cases);
        return Err(Problem::new(Problem::WRONG_INPUT, message)
            .about(args.place.place.clone())
            .help(format!("`ductloop sweep work {}` does them; `--partial` merges what is there", args.place.place)));
    }
    ledger::tidy(&store);
    verdict::conclude(&plan, &store, &table, args.place.saying)
}

/// Puts a plan in its place.
fn write_plan(plan: &Plan, place: &str, args: &FileArgs, option: &str) -> Result<Store, Problem> {
    if place.is_empty() {
        let empty = Problem::new(Problem::WRONG_INPUT, "this is no folder: it is empty");
        return Err(empty.about(option).help("name a folder, as in `--out out/s`"));
    }
    if !place.contains("://") {
        destination::folder(option, place.as_ref())?;
        foreign(place)?;
    }
    let store = Store::open(place).map_err(|error| unwritable(&error, option))?;
    match plan.write(&store, args.force) {
        Ok(()) => Ok(store),
        Err(PlanError::Store(error)) => Err(unwritable(&error, option)),
        Err(error) => Err(Problem::new(Problem::WRONG_INPUT, error.to_string()).help(
            "replace its plan with --force (results of cases that both have are kept), or choose another folder with --out",
        )),
    }
}

/// A folder that holds other things than a sweep is left alone.
fn foreign(place: &str) -> Result<(), Problem> {
    let mut entries = std::fs::read_dir(place).into_iter().flatten().flatten();
    if std::path::Path::new(place).join(ductloop::sweep::plan::NAME).exists() || entries.next().is_none() {
        return Ok(());
    }
    let message = format!("is not empty and holds no {}, so it is not a sweep's and is left alone", ductloop::sweep::plan::NAME);
    Err(Problem::new(Problem::WRONG_INPUT, message).about(place).help("move it away, or choose another folder with --out"))
}

fn open(place: &str) -> Result<(Plan, Store), Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message);
    if !place.contains("://") && !std::path::Path::new(place).is_dir() {
        return Err(wrong("there is no such folder".into()).about(place).help("`ductloop sweep plan FILE --out DIR` makes one"));
    }
    let store = Store::open(place).map_err(|error| wrong(error.to_string()))?;
    let plan = Plan::read(&store).map_err(|error| wrong(error.to_string()))?;
    Ok((plan, store))
}

/// The work of a shard with its bar; `None` if it was interrupted.
pub(crate) fn carry_out(
    plan: &Plan,
    store: &Store,
    rendering: &Rendering,
    shard: Shard,
    threads: Option<u16>,
    saying: SayingArgs,
) -> Result<Option<Tally>, Problem> {
    let bar = Bar::new(saying.quiet);
    let host = host();
    let threads = threads.map_or_else(|| Threads::here().all, usize::from);
    let means = Means { plan, store, engine: &rendering.engine, threads, host: &host };
    let damaged = |part: &Damaged| {
        note(&format!("warning: {}/{}: {}; its cases are run again", store.place(), part.name, part.error));
    };
    let worked = work::work(means, shard, damaged, &|tally| {
        if let Some(tally) = tally {
            bar.show(tally);
        }
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.done();
    let tally = worked.map_err(|error| {
        let help = "what is finished is kept: the same call goes on from there";
        match error {
            WorkError::Lost(_) => Problem::new(Problem::CANNOT_GO_ON, error.to_string()).about(store.place()).help(help),
            _ => Problem::new(Problem::CANNOT_GO_ON, error.to_string()).help(help),
        }
    })?;
    if interrupt::requested() {
        note(&format!(
            "interrupted: {} of {} cases are done and kept; the same call goes on from there",
            tally.done, tally.cases
        ));
        return Ok(None);
    }
    Ok(Some(tally))
}

fn unwritable(error: &StoreError, option: &str) -> Problem {
    Problem::new(Problem::WRONG_INPUT, error.message.clone())
        .about(format!("{option} {}", error.place))
        .help("choose another place")
}

pub(crate) fn lost(error: &StoreError) -> Problem {
    Problem::new(Problem::CANNOT_GO_ON, error.to_string())
}

/// This machine's name.
fn host() -> String {
    let told = std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| std::env::var("COMPUTERNAME").ok());
    told.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).unwrap_or_else(|| "unknown".to_owned())
}
