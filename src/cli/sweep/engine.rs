//! Sweeps on the machines of a scheduler: who they are, how they are followed, and how it ends. What runs there is `sweep work`, and what
//! is done stands in the sweep's store, so that nothing hangs on this process: it may die and be called again.
//!
//! - `slurm`: a job array; - `ray`: tasks of a cluster, by a driver in Python.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use ductloop::sweep::ledger;
use ductloop::sweep::plan::Plan;
use ductloop::sweep::store::Store;
use ductloop::sweep::table::Table;

use super::args::{EngineChoice, MachinesArgs, SayingArgs};
use super::bar::Bar;
use super::steps::lost;
use super::{interrupt, verdict};
use crate::cli::problem::Problem;
use crate::cli::streams::note;

mod ray;
mod slurm;

use ray::Ray;
use slurm::Slurm;

/// How often the results are counted: names in a folder, or requests to an object store, which cost.
const BETWEEN_COUNTS: Duration = Duration::from_secs(1);
const BETWEEN_REMOTE_COUNTS: Duration = Duration::from_secs(5);
/// How soon Ctrl-C is noticed.
const ATTENTION: Duration = Duration::from_millis(50);
/// Where engines leave what their jobs say.
const LOGS: &str = "logs";

/// A scheduler that is there.
pub(in crate::cli) enum Engine {
    Slurm(Slurm),
    Ray(Ray),
}

/// What is to be done, and where.
pub(super) struct Order<'a> {
    plan: &'a Plan,
    /// Folder or address of the sweep, from anywhere.
    place: &'a str,
    /// A folder for scripts and logs: the sweep's, or one on this machine where the sweep is in an object store.
    desk: &'a Path,
    /// This program.
    program: PathBuf,
    /// How many workers there are to be: as many as nodes, but no more than points.
    shards: u64,
    /// Cases at a time on each; as many as the scheduler gives cores if `None`.
    threads: Option<u16>,
}

/// Workers under way.
trait Job {
    /// What is to be said of them; `None` once they have ended.
    fn state(&mut self) -> Option<String>;
    /// Ends them. What they have finished is kept.
    fn cancel(&mut self);
    /// Where they say what went wrong.
    fn logs(&self) -> String;
    /// Whether an earlier call started them.
    fn is_inherited(&self) -> bool;
}

impl Engine {
    /// What the command line asks for, if it does, once it is clear that it is there.
    ///
    /// # Errors
    /// Where it is not, or an option belongs to another one.
    pub(in crate::cli) fn of(engine: Option<EngineChoice>, args: &MachinesArgs) -> Result<Option<Self>, Problem> {
        let (Some(choice), Some(nodes)) = (engine, args.nodes) else { return Ok(None) };
        let given = [
            ("--partition", EngineChoice::Slurm, args.partition.is_some()),
            ("--engine-arg", EngineChoice::Slurm, !args.engine_arg.is_empty()),
            ("--address", EngineChoice::Ray, args.address.is_some()),
            ("--python", EngineChoice::Ray, args.python.is_some()),
        ];
        if let Some((option, ..)) = given.iter().find(|(_, of, given)| *given && *of != choice) {
            let (mine, other) = if choice == EngineChoice::Slurm { ("Slurm", "Ray") } else { ("Ray", "Slurm") };
            return Err(
                Problem::new(Problem::WRONG_INPUT, format!("this is for {other}, and the engine is {mine}")).about(*option)
            );
        }
        let nodes = u64::from(nodes);
        Ok(Some(match choice {
            EngineChoice::Slurm => Self::Slurm(Slurm::find(nodes, args.partition.clone(), args.engine_arg.clone())?),
            EngineChoice::Ray => Self::Ray(Ray::find(nodes, args.address.clone(), args.python.clone())?),
        }))
    }

    /// Does what is missing of a plan and follows it to its end; whether it came there, and was not interrupted.
    ///
    /// # Errors
    /// Where the work cannot be handed over, or has ended with cases missing. What is finished is kept.
    pub(in crate::cli) fn carry_out(
        &self,
        plan: &Plan,
        store: &Store,
        threads: Option<u16>,
        saying: SayingArgs,
    ) -> Result<bool, Problem> {
        let before = Table::read(plan, store).map_err(|error| lost(&error))?;
        verdict::tell_damage(store, &before.damaged);
        if before.missing == 0 {
            return Ok(true);
        }
        let nodes = match self {
            Self::Slurm(slurm) => slurm.nodes,
            Self::Ray(ray) => ray.nodes,
        };
        let desk = match store.folder() {
            Some(folder) => folder.to_owned(),
            None => PathBuf::from(from_anywhere(&format!("out/{}-engine", plan.sweep.name))?),
        };
        std::fs::create_dir_all(desk.join(LOGS)).map_err(|error| no_desk(&desk, &error))?;
        let program =
            std::env::current_exe().map_err(|error| Problem::new(Problem::CANNOT_GO_ON, format!("this program: {error}")))?;
        let order = Order { plan, place: store.place(), desk: &desk, program, shards: nodes.min(plan.points), threads };
        let mut done = before.rows.len() as u64;
        let (missing, logs) = loop {
            let mut job: Box<dyn Job> = match self {
                Self::Slurm(slurm) => Box::new(slurm.submit(&order, saying.quiet)?),
                Self::Ray(ray) => Box::new(ray.submit(&order)?),
            };
            if !follow(job.as_mut(), plan, store, done, saying) {
                return Ok(false);
            }
            let after = Table::read(plan, store).map_err(|error| lost(&error))?;
            if after.missing == 0 {
                return Ok(true);
            }
            if !job.is_inherited() {
                break (after.missing, job.logs());
            }
            // It may have been about to end, cancelled by an earlier call's Ctrl-C.
            note(&format!("the earlier call's job has ended, and {} of {} cases are not done", after.missing, plan.cases));
            done = after.rows.len() as u64;
        };
        let message = format!("the jobs have ended, and {missing} of {} cases are not done; {logs} says why", plan.cases);
        Err(Problem::new(Problem::CANNOT_GO_ON, message).about(store.place()).help(format!(
            "the same call runs what is missing; `ductloop sweep work {}` does so on this machine alone",
            quoted(store.place())
        )))
    }
}

/// Shows how far it is until the job has ended (true) or Ctrl-C came (false), which ends it.
fn follow(job: &mut dyn Job, plan: &Plan, store: &Store, found: u64, saying: SayingArgs) -> bool {
    let bar = Bar::new(saying.quiet);
    let between = if store.folder().is_some() { BETWEEN_COUNTS } else { BETWEEN_REMOTE_COUNTS };
    // Parts of other plans may lie there too: what is added counts.
    let count = || ledger::count(store).ok();
    let first = count().unwrap_or(found);
    let mut done = found;
    let over = loop {
        // A store that does not answer for once is asked again: those at work need not stop for it.
        if let Some(now) = count() {
            done = (found + now.saturating_sub(first)).min(plan.cases);
        }
        let state = job.state();
        bar.draw(plan.cases, done, found, state.as_deref().unwrap_or("ended"));
        if state.is_none() {
            break true;
        }
        let next = Instant::now() + between;
        while Instant::now() < next && !interrupt::requested() {
            std::thread::sleep(ATTENTION);
        }
        if interrupt::requested() {
            break false;
        }
    };
    bar.done();
    if !over {
        job.cancel();
        let done = count().map_or(done, |now| (found + now.saturating_sub(first)).min(plan.cases));
        note(&format!(
            "interrupted: the jobs are cancelled; {done} of {} cases are done and kept; the same call goes on from there",
            plan.cases
        ));
    }
    over
}

/// A place as all machines name it: an address as it is, a folder from the root.
///
/// # Errors
/// Where this process has no folder to stand in.
pub(in crate::cli) fn from_anywhere(place: &str) -> Result<String, Problem> {
    if place.contains("://") {
        return Ok(place.to_owned());
    }
    let absolute =
        std::path::absolute(place).map_err(|error| Problem::new(Problem::WRONG_INPUT, error.to_string()).about(place))?;
    Ok(absolute.display().to_string())
}

/// Writes a file into an engine's folder.
fn put(path: &Path, text: &str) -> Result<(), Problem> {
    std::fs::write(path, text).map_err(|error| no_desk(path, &error))
}

fn no_desk(path: &Path, error: &dyn Display) -> Problem {
    Problem::new(Problem::WRONG_INPUT, format!("cannot be written: {error}")).about(path.display().to_string())
}

/// A word as a shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-:+,@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// A program that Ctrl-C in the terminal does not reach: this one alone decides what becomes of the jobs.
fn aside(program: &str) -> std::process::Command {
    let mut command = std::process::Command::new(program);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quoted_word_is_one_word_to_a_shell() {
        for word in ["/plain/path-1.2", "with space", "it's", "$(reboot)", "a\"b", ""] {
            let told =
                std::process::Command::new("sh").args(["-c", &format!("printf %s {}", quoted(word))]).output().expect("a shell");
            assert_eq!(String::from_utf8_lossy(&told.stdout), word);
        }
    }

    #[test]
    fn a_place_is_the_same_from_anywhere() {
        let place = |text| from_anywhere(text).unwrap_or_default();
        assert_eq!(place("s3://bucket/a"), "s3://bucket/a");
        assert_eq!(place("/a/b"), "/a/b");
        assert!(Path::new(&place("a/b")).is_absolute() && place("a/b").ends_with("/a/b"));
    }
}
