//! A sweep as a job array of Slurm: task i of N runs `work DIR --shard i/N` on a node of its own. A task whose node dies is requeued by
//! Slurm and does what its first start has left.
//!
//! A call that finds its own array still there, because the one before was killed, follows that one; should it end with cases missing, as
//! one that is being cancelled does, another is submitted.

use std::process::Stdio;
use std::time::{Duration, Instant};

use xxhash_rust::xxh3::xxh3_64;

use super::{Job, LOGS, Order, aside, put, quoted};
use crate::cli::problem::Problem;
use crate::cli::streams::note;

/// The controller serves everybody: how often it is asked.
const BETWEEN_QUESTIONS: Duration = Duration::from_secs(3);
/// The job script, in the sweep's folder.
const SCRIPT: &str = "slurm.sh";

/// A Slurm that is there.
pub(in crate::cli) struct Slurm {
    pub(super) nodes: u64,
    partition: Option<String>,
    arguments: Vec<String>,
}

/// An array under way.
pub(super) struct Array {
    /// Its number.
    id: String,
    logs: String,
    /// What was said of it last, and when to ask again.
    state: String,
    due: Instant,
    /// Whether an earlier call submitted it.
    inherited: bool,
    /// Whether the last answer was that nothing of it is left: the second time it has ended.
    gone: bool,
    /// Whether it was told that Slurm does not answer.
    told: bool,
}

impl Slurm {
    /// Looks for it.
    ///
    /// # Errors
    /// Where there is none.
    pub(super) fn find(nodes: u64, partition: Option<String>, arguments: Vec<String>) -> Result<Self, Problem> {
        match aside("sbatch").arg("--version").stdin(Stdio::null()).output() {
            Ok(told) if told.status.success() => Ok(Self { nodes, partition, arguments }),
            Ok(told) => Err(Problem::new(Problem::WRONG_INPUT, said(&told.stderr)).about("sbatch --version")),
            Err(error) => {
                let why = if error.kind() == std::io::ErrorKind::NotFound {
                    "there is none here".to_owned()
                } else {
                    error.to_string()
                };
                Err(Problem::new(Problem::WRONG_INPUT, format!("Slurm is not on this machine: sbatch: {why}"))
                    .about("--engine slurm")
                    .help(
                        "call it on a login node of the cluster; or leave `--engine` out to run on this machine; or run `ductloop sweep \
                         plan`, `work --shard I/N` and `merge` where the machines are",
                    ))
            }
        }
    }

    /// Submits an array, or finds the one that an earlier call of this sweep submitted and that is still there.
    ///
    /// # Errors
    /// Where Slurm does not take it.
    pub(super) fn submit(&self, order: &Order<'_>, quiet: bool) -> Result<Array, Problem> {
        let logs = order.desk.join(LOGS);
        // With all that the work follows from, so that the array of another plan is none of ours.
        let of = format!("{} {} {:?}", order.place, order.plan.build, order.plan.sweep);
        let name = format!("ductloop-{}-{:08x}", order.plan.sweep.name, xxh3_64(of.as_bytes()) >> 32);
        let array = |id: String, inherited: bool| Array {
            inherited,
            logs: logs.join(format!("slurm-{id}-*.log")).display().to_string(),
            id,
            state: "submitted".into(),
            due: Instant::now(),
            gone: false,
            told: false,
        };
        if let Some(id) = find_array(&name) {
            note(&format!("job {id} of an earlier call is at it: it is followed"));
            return Ok(array(id, true));
        }
        let path = order.desk.join(SCRIPT);
        put(&path, &script(order))?;
        let mut sbatch = aside("sbatch");
        sbatch.args(["--parsable", "--requeue", "--open-mode=append", "--nodes=1", "--exclusive"]);
        sbatch.arg(format!("--array=1-{}", order.shards)).arg(format!("--job-name={name}"));
        // Within the name of a log Slurm reads %: one that is in the folder's own name is doubled.
        let pattern = format!("{}/slurm-%A-%a.log", logs.display().to_string().replace('%', "%%"));
        sbatch.arg(format!("--output={pattern}")).arg("--chdir").arg(order.desk);
        sbatch.args(self.partition.iter().map(|name| format!("--partition={name}")));
        // What was asked for expressly comes last, and counts.
        sbatch.args(&self.arguments).arg(&path).stdin(Stdio::null());
        let told = sbatch.output().map_err(|error| Problem::new(Problem::WRONG_INPUT, error.to_string()).about("sbatch"))?;
        let stdout = String::from_utf8_lossy(&told.stdout);
        // `NUMBER`, or `NUMBER;CLUSTER`.
        let id = stdout.trim().split(';').next().unwrap_or_default().to_owned();
        if !told.status.success() || id.is_empty() {
            return Err(Problem::new(Problem::WRONG_INPUT, said(&told.stderr))
                .about("sbatch")
                .help("`--partition` and `--engine-arg` say what Slurm is to be asked for; the plan is written and kept"));
        }
        let array = array(id, false);
        if !quiet {
            note(&format!("job array {} of {} on Slurm; its logs are {}", array.id, order.shards, array.logs));
        }
        Ok(array)
    }
}

/// What each task runs. `exec`: what Slurm tells the job to do, end for one, `work` is told itself.
fn script(order: &Order<'_>) -> String {
    let threads = order.threads.map_or("\"$SLURM_CPUS_ON_NODE\"".to_owned(), |threads| threads.to_string());
    format!(
        "#!/bin/sh\n# Written by `ductloop sweep --engine slurm`: a task of its job array.\n\
         exec {} sweep work {} --shard \"$SLURM_ARRAY_TASK_ID/{}\" --threads {threads}\n",
        quoted(&order.program.display().to_string()),
        quoted(order.place),
        order.shards
    )
}

/// The number of the array of this name, if one of this user's is waiting or running.
fn find_array(name: &str) -> Option<String> {
    let told = aside("squeue")
        .args(["--noheader", "--me", "--format=%F", &format!("--name={name}")])
        .stdin(Stdio::null())
        .output()
        .ok()?;
    let id = String::from_utf8_lossy(&told.stdout).lines().next()?.trim().to_owned();
    (told.status.success() && !id.is_empty()).then_some(id)
}

impl Job for Array {
    fn state(&mut self) -> Option<String> {
        if Instant::now() < self.due {
            return Some(self.state.clone());
        }
        self.due = Instant::now() + BETWEEN_QUESTIONS;
        // A task a line, each with its state and, where it waits, why.
        let told = aside("squeue")
            .args(["--noheader", "--array", "--format=%T %r", &format!("--jobs={}", self.id)])
            .stdin(Stdio::null())
            .output();
        let tasks = match told {
            Ok(told) if told.status.success() => Ok(String::from_utf8_lossy(&told.stdout).into_owned()),
            // It is so old that the controller has forgotten it.
            Ok(told) if said(&told.stderr).contains("Invalid job id") => Ok(String::new()),
            Ok(told) => Err(said(&told.stderr)),
            Err(error) => Err(error.to_string()),
        };
        match tasks {
            Ok(tasks) => {
                self.told = false;
                let Some(state) = counted(&tasks) else {
                    // Between two states a task may be in none for a moment: only the second time is the end.
                    if self.gone {
                        return None;
                    }
                    self.gone = true;
                    self.due = Instant::now() + Duration::from_secs(1);
                    return Some(self.state.clone());
                };
                self.gone = false;
                self.state = state;
            }
            Err(error) => {
                if !std::mem::replace(&mut self.told, true) {
                    note(&format!("warning: squeue: {error}; the jobs go on, and Slurm is asked again"));
                }
            }
        }
        Some(self.state.clone())
    }

    fn cancel(&mut self) {
        let told = aside("scancel").arg(&self.id).stdin(Stdio::null()).output();
        let error = match told {
            Ok(told) if told.status.success() => return,
            Ok(told) => said(&told.stderr),
            Err(error) => error.to_string(),
        };
        note(&format!("warning: scancel {}: {error}; the jobs may go on", self.id));
    }

    fn logs(&self) -> String {
        self.logs.clone()
    }

    fn is_inherited(&self) -> bool {
        self.inherited
    }
}

/// "2 running, 1 pending (Resources)" from squeue's lines; `None` where there are none.
fn counted(tasks: &str) -> Option<String> {
    let mut states: Vec<(String, u64)> = Vec::new();
    for task in tasks.lines().map(str::trim).filter(|task| !task.is_empty()) {
        let (state, reason) = task.split_once(' ').unwrap_or((task, "None"));
        let mut words = state.to_lowercase();
        if state == "PENDING" && !["None", "(null)"].contains(&reason) {
            words += &format!(" ({reason})");
        }
        match states.iter_mut().find(|(other, _)| *other == words) {
            Some((_, count)) => *count += 1,
            None => states.push((words, 1)),
        }
    }
    let words: Vec<_> = states.iter().map(|(words, count)| format!("{count} {words}")).collect();
    (!words.is_empty()).then(|| words.join(", "))
}

/// What a program of Slurm said, in a line.
fn said(stderr: &[u8]) -> String {
    let text = String::from_utf8_lossy(stderr);
    let lines: Vec<_> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    if lines.is_empty() { "it failed without a word".to_owned() } else { lines.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn tasks_are_counted_by_state() {
        let tasks = "RUNNING None\nRUNNING None\nPENDING Resources\nPENDING None\nCOMPLETING None\n";
        assert_eq!(counted(tasks).as_deref(), Some("2 running, 1 pending (Resources), 1 pending, 1 completing"));
        assert_eq!(counted("\n"), None);
    }
}
