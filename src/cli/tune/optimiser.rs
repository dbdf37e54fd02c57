//! A program that proposes candidates: started, spoken with, and told from one that has died.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use ductloop::scenario::study_file::StudyFile;
use ductloop::tune::ask_tell::Lost;
use ductloop::tune::journal::Journal;
use ductloop::tune::outside::{Lines, Outside};

use super::args::Driver;
use crate::cli::problem::Problem;
use crate::cli::{interrupt, python};

/// The program that asks Optuna, and its name in the study's folder.
const OPTUNA: &str = include_str!("optuna_optimiser.py");
pub(super) const OPTUNA_NAME: &str = "optuna_optimiser.py";
/// What it proposed, and what it says beside.
pub(super) const JOURNAL: &str = "candidates.jsonl";
pub(super) const LOG: &str = "optimiser.log";
/// How soon Ctrl-C is noticed.
const ATTENTION: Duration = Duration::from_millis(50);
/// How long it may take to go.
const FAREWELL: Duration = Duration::from_secs(10);
/// How much of its log is told when it dies, in lines.
const TOLD: usize = 5;

/// An optimiser under way.
#[derive(Debug)]
pub(super) struct Process {
    child: Child,
    input: Option<ChildStdin>,
    output: Receiver<std::io::Result<String>>,
    log: PathBuf,
}

/// Starts it and greets it.
///
/// # Errors
/// Where it cannot be started, or does not answer.
pub(super) fn start(study: &StudyFile, driver: &Driver, folder: &Path) -> Result<Outside<Process>, Problem> {
    let journal = Journal::open(folder.join(JOURNAL)).map_err(lost)?;
    let process = Process::start(driver, folder)?;
    Outside::greet(study, process, journal).map_err(lost)
}

/// Lets it go.
pub(super) fn end(optimiser: Outside<Process>) {
    drop(optimiser.farewell());
}

/// It is gone, or makes no sense.
pub(super) fn lost(lost: Lost) -> Problem {
    let problem = Problem::new(Problem::CANNOT_GO_ON, lost.message).about("the optimiser");
    if lost.help.is_empty() { problem } else { problem.help(lost.help) }
}

impl Process {
    fn start(driver: &Driver, folder: &Path) -> Result<Self, Problem> {
        let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message);
        let (mut command, what) = match driver {
            Driver::Optuna { python } => {
                let elsewhere = "or leave `--engine optuna` out: the study's own optimiser needs nothing";
                python::find(python, "optuna", "Optuna", elsewhere)?;
                let script = folder.join(OPTUNA_NAME);
                std::fs::write(&script, OPTUNA)
                    .map_err(|error| wrong(format!("cannot be written: {error}")).about(script.display().to_string()))?;
                let mut command = Command::new(python);
                command.arg(script);
                (command, format!("--engine optuna: {python}"))
            }
            Driver::Command(line) => {
                let mut command = Command::new("sh");
                command.args(["-c", line]);
                (command, format!("--optimiser {line}"))
            }
        };
        let log = folder.join(LOG);
        let errors = File::create(&log).map_err(|error| wrong(error.to_string()).about(log.display().to_string()))?;
        // Its own words at once, not when a buffer is full.
        command.env("PYTHONUNBUFFERED", "1").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors);
        // Ctrl-C in the terminal does not reach it: this process decides what becomes of it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| wrong(format!("cannot be started: {error}")).about(what))?;
        let input = child.stdin.take();
        let (send, output) = channel();
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                for line in BufReader::new(stdout).lines() {
                    if send.send(line).is_err() {
                        return;
                    }
                }
            });
        }
        Ok(Self { child, input, output, log })
    }

    /// That it is gone, and what it said last.
    fn gone(&mut self, when: &str) -> Lost {
        let until = Instant::now() + Duration::from_secs(2);
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break format!("ended with {status}"),
                Ok(None) if Instant::now() < until => std::thread::sleep(ATTENTION),
                _ => break "closed its output".to_owned(),
            }
        };
        let log = std::fs::read_to_string(&self.log).unwrap_or_default();
        let lines: Vec<&str> = log.lines().filter(|line| !line.trim().is_empty()).collect();
        let last: String = lines[lines.len().saturating_sub(TOLD)..].iter().map(|line| format!("\n  {line}")).collect();
        let said = if last.is_empty() { ", without a word of why".to_owned() } else { format!("; it said last:{last}") };
        Lost {
            message: format!("it {status} {when}{said}"),
            help: format!(
                "{} has all it said; what was run and proposed is kept: the same call goes on from there",
                self.log.display()
            ),
        }
    }
}

impl Lines for Process {
    fn send(&mut self, line: &str) -> Result<(), Lost> {
        let written = self.input.as_mut().is_some_and(|input| writeln!(input, "{line}").and_then(|()| input.flush()).is_ok());
        if written { Ok(()) } else { Err(self.gone("before it was spoken to")) }
    }

    fn receive(&mut self) -> Result<String, Lost> {
        loop {
            match self.output.recv_timeout(ATTENTION) {
                Ok(Ok(line)) if line.trim().is_empty() => {}
                Ok(Ok(line)) => return Ok(line),
                Ok(Err(error)) => {
                    let help = "what was run is kept: the same call goes on from there".to_owned();
                    return Err(Lost { message: format!("its answer cannot be read: {error}"), help });
                }
                Err(RecvTimeoutError::Disconnected) => return Err(self.gone("when it was to answer")),
                Err(RecvTimeoutError::Timeout) if interrupt::requested() => {
                    return Err(Lost { message: "interrupted".into(), help: String::new() });
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }
}

impl Drop for Process {
    /// It goes when its input ends; if it does not, it is made to.
    fn drop(&mut self) {
        drop(self.input.take());
        let until = Instant::now() + FAREWELL;
        while Instant::now() < until && !interrupt::requested() {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(ATTENTION);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
