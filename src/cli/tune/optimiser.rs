//! A program that proposes candidates: started, spoken with, and told from one that has died.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::time::{Duration, Instant};

use ductloop::scenario::study_file::StudyFile;
use ductloop::tune::ask_tell::Lost;
use ductloop::tune::journal::Journal;
use ductloop::tune::outside::{Lines, Outside};

use super::args::Driver;
use crate::cli::problem::Problem;
use crate::cli::streams::note;
use crate::cli::{interrupt, python};

/// The program that asks Optuna, and its name in the study's folder.
const OPTUNA: &str = include_str!("optuna_optimiser.py");
pub(super) const OPTUNA_NAME: &str = "optuna_optimiser.py";
/// What it proposed, and what it says beside.
pub(super) const JOURNAL: &str = "candidates.jsonl";
pub(super) const LOG: &str = "optimiser.log";
/// How soon Ctrl-C is noticed.
const ATTENTION: Duration = Duration::from_millis(50);
/// After how long it is said that it has not answered yet.
const SILENCE: Duration = Duration::from_secs(30);
/// How long it may take to go.
const FAREWELL: Duration = Duration::from_secs(10);
/// Longest line that it may say, in bytes, and how many are waiting at most.
const LONGEST: u64 = 64 << 20;
const WAITING: usize = 4;
/// How much of its log is told when it dies: of so many bytes the last lines.
const TOLD_BYTES: u64 = 1 << 14;
const TOLD: usize = 5;

/// An optimiser under way.
#[derive(Debug)]
pub(super) struct Process {
    child: Child,
    /// To the thread that writes, so that one that does not read holds nobody up; its input ends when this does.
    input: Option<Sender<String>>,
    output: Receiver<std::io::Result<String>>,
    log: PathBuf,
    /// Whether it was told to go, and may take its time.
    may_linger: bool,
}

/// Starts it and greets it.
///
/// # Errors
/// Where it cannot be started, or does not answer.
pub(super) fn start(study: &StudyFile, driver: &Driver, folder: &Path) -> Result<Outside<Process>, Problem> {
    let begin = |lost: Lost| told(Problem::WRONG_INPUT, lost);
    let journal = Journal::open(folder.join(JOURNAL)).map_err(begin)?;
    let process = Process::start(driver, folder)?;
    Outside::greet(study, process, journal).map_err(begin)
}

/// Lets it go.
pub(super) fn end(optimiser: Outside<Process>) {
    let mut process = optimiser.farewell();
    process.may_linger = true;
}

/// It is gone, or makes no sense.
pub(super) fn lost(lost: Lost) -> Problem {
    told(Problem::CANNOT_GO_ON, lost)
}

fn told(code: u8, lost: Lost) -> Problem {
    let problem = Problem::new(code, lost.message).about("the optimiser");
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
        let (send, output) = sync_channel(WAITING);
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || read(stdout, &send));
        }
        let input = child.stdin.take().map(writer);
        Ok(Self { child, input, output, log, may_linger: false })
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
        let log = end_of(&self.log);
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
        let sent = self.input.as_ref().is_some_and(|input| input.send(line.to_owned()).is_ok());
        if sent { Ok(()) } else { Err(self.gone("before it was spoken to")) }
    }

    fn receive(&mut self) -> Result<String, Lost> {
        let (asked, mut is_told) = (Instant::now(), false);
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
                Err(RecvTimeoutError::Timeout) if !is_told && asked.elapsed() > SILENCE => {
                    note(
                        "the optimiser has not answered for 30 s; it is waited for (Ctrl-C ends the study, and keeps what was run)",
                    );
                    is_told = true;
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    fn unasked(&mut self) -> Option<String> {
        match self.output.try_recv() {
            Ok(Ok(line)) if !line.trim().is_empty() => Some(line),
            Ok(_) | Err(TryRecvError::Empty | TryRecvError::Disconnected) => None,
        }
    }
}

/// Reads its lines for whoever waits for them.
fn read(stdout: ChildStdout, send: &SyncSender<std::io::Result<String>>) {
    let mut stdout = BufReader::new(stdout);
    loop {
        let mut line = Vec::new();
        let read = stdout.by_ref().take(LONGEST).read_until(b'\n', &mut line);
        let line = match read {
            Ok(0) => return,
            Ok(_) if line.last() != Some(&b'\n') && line.len() as u64 == LONGEST => {
                Err(std::io::Error::other(format!("a line of more than {} MB", LONGEST >> 20)))
            }
            Ok(_) => {
                let end = line.iter().rposition(|byte| !b"\r\n".contains(byte)).map_or(0, |last| last + 1);
                line.truncate(end);
                String::from_utf8(line).map_err(std::io::Error::other)
            }
            Err(error) => Err(error),
        };
        let is_last = line.is_err();
        if send.send(line).is_err() || is_last {
            return;
        }
    }
}

/// Writes what it is sent, until nobody sends or it does not read any more.
fn writer(mut input: ChildStdin) -> Sender<String> {
    let (send, lines) = channel::<String>();
    std::thread::spawn(move || {
        for line in lines {
            if writeln!(input, "{line}").and_then(|()| input.flush()).is_err() {
                return;
            }
        }
    });
    send
}

/// The end of a log, whatever its size and its encoding.
fn end_of(log: &Path) -> String {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(log)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(TOLD_BYTES)))?;
        let mut end = Vec::new();
        file.take(TOLD_BYTES).read_to_end(&mut end)?;
        Ok(end)
    };
    String::from_utf8_lossy(&read().unwrap_or_default()).into_owned()
}

impl Drop for Process {
    /// It goes when its input ends. One that does not, or that was not to go, is made to, with all that it has started.
    fn drop(&mut self) {
        drop(self.input.take());
        let until = Instant::now() + FAREWELL;
        while self.may_linger && Instant::now() < until && !interrupt::requested() {
            if !matches!(self.child.try_wait(), Ok(None)) {
                break;
            }
            std::thread::sleep(ATTENTION);
        }
        #[cfg(unix)]
        if let Some(group) = i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw) {
            // Nobody may be left in it.
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
