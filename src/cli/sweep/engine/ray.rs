//! A sweep as tasks of a Ray cluster. Ray speaks Python: a small driver that comes with this program hands the tasks over and waits for
//! them; it ends them when its standard input closes, so that they end however this process does.

use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;

use super::{Job, LOGS, Order, aside, no_desk, put};
use crate::cli::problem::Problem;
use crate::cli::python;
use crate::cli::streams::note;

/// The driver, and its name in the sweep's folder.
const DRIVER: &str = include_str!("ray_driver.py");
const NAME: &str = "ray_driver.py";
/// How often a task is begun again whose node is lost.
const RETRIES: u32 = 10;
/// How long the driver may take to end its tasks.
const FAREWELL: Duration = Duration::from_secs(30);

/// A Ray that is there.
pub(in crate::cli) struct Ray {
    pub(super) nodes: u64,
    address: Option<String>,
    python: String,
}

/// A driver under way.
pub(super) struct Driver {
    child: Child,
    ended: Option<ExitStatus>,
    log: PathBuf,
    shards: u64,
}

impl Ray {
    /// Looks for it.
    ///
    /// # Errors
    /// Where there is no Python, or no Ray in it.
    pub(super) fn find(nodes: u64, address: Option<String>, python: Option<String>) -> Result<Self, Problem> {
        let python = python.unwrap_or_else(|| "python3".to_owned());
        python::find(&python, "ray", "Ray", "or leave `--engine` out to run on this machine alone")?;
        Ok(Self { nodes, address, python })
    }

    /// Starts the driver.
    ///
    /// # Errors
    /// Where it cannot be written or started.
    pub(super) fn submit(&self, order: &Order<'_>) -> Result<Driver, Problem> {
        let driver = order.desk.join(NAME);
        put(&driver, DRIVER)?;
        let log = order.desk.join(LOGS).join("ray.log");
        let written = File::options().create(true).append(true).open(&log);
        let out = written.and_then(|file| Ok((file.try_clone()?, file))).map_err(|error| no_desk(&log, &error))?;
        let task = json!({
            "address": self.address, "work": [order.program.display().to_string(), "sweep", "work", order.place], "shards": order.shards,
            "threads": order.threads, "retries": RETRIES,
        });
        let child = aside(&self.python)
            .arg(&driver)
            .arg(task.to_string())
            .env("RAY_USAGE_STATS_ENABLED", "0")
            // Its own words at once, not when a buffer is full.
            .env("PYTHONUNBUFFERED", "1")
            .stdin(Stdio::piped())
            .stdout(out.0)
            .stderr(out.1)
            .spawn()
            .map_err(|error| Problem::new(Problem::WRONG_INPUT, error.to_string()).about(self.python.clone()))?;
        Ok(Driver { child, ended: None, log, shards: order.shards })
    }
}

impl Job for Driver {
    fn state(&mut self) -> Option<String> {
        if let Ok(Some(status)) = self.child.try_wait() {
            self.ended = Some(status);
            return None;
        }
        Some(format!("{} tasks on Ray", self.shards))
    }

    fn cancel(&mut self) {
        // The driver sees that and ends its tasks.
        drop(self.child.stdin.take());
        let until = Instant::now() + FAREWELL;
        while Instant::now() < until {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        note("warning: the driver does not end its tasks and is killed; they may go on for a while");
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    fn logs(&self) -> String {
        let status = self.ended.map_or(String::new(), |status| format!(" (the driver ended with {status})"));
        format!("{}{status}", self.log.display())
    }

    /// A driver ends its tasks when the call that started it ends.
    fn is_inherited(&self) -> bool {
        false
    }
}
