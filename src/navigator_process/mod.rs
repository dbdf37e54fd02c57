//! A navigator that is a program of its own, in any language, in lock-step over its standard input and output.
//!
//! - `protocol`: the messages, byte by byte as in `docs/navigator-protocol.md`; - `hello`: what it is told first; - `channel`: the
//!   running program behind pipes, with a time limit on every answer; - `words`: a command line to words, without a shell.
//!
//! Whatever it does (ends, answers nonsense, answers late, does not read) ends the run with a named error within the time limit,
//! and no process of ours is left behind. Programs that it starts itself are its own business.

mod channel;
mod hello;
mod protocol;
mod words;

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ductloop_nav::messages::{Command, Counts, Frame, Tick};
use ductloop_nav::navigator::{Navigator, Report, State};
use ductloop_nav::perception::Measurement;
use ductloop_nav::rig::MountAngles;

use crate::pilot::Pilot;
use crate::scenario::Scenario;
use channel::Channel;
pub use words::{WordsError, words};

/// How a navigator's program is started, and how long it is waited for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NavigatorCommand {
    /// The program.
    pub program: String,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// Longest time for one answer, the first included.
    pub limit: Duration,
}

/// What a navigator's program did wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NavigatorError {
    /// It could not be started.
    #[error("the navigator `{program}` cannot be started: {why}")]
    Start {
        /// The program.
        program: String,
        /// What the system says.
        why: String,
    },
    /// It ended, or closed its standard input or output.
    #[error("the navigator ended ({how}) {when}")]
    Ended {
        /// Its exit status, as far as it is known.
        how: String,
        /// During which exchange.
        when: String,
    },
    /// It did not answer in time.
    #[error("the navigator gave no answer within {limit_s} s {when}")]
    Slow {
        /// The limit, in seconds.
        limit_s: String,
        /// During which exchange.
        when: String,
    },
    /// What it answered is not a message of the protocol.
    #[error("the navigator answered what is no message of the protocol {when}: {what}")]
    Garbage {
        /// What is wrong with it.
        what: String,
        /// During which exchange.
        when: String,
    },
}

/// Where a navigator's program leaves its error for the loop, as [`Navigator`] itself cannot fail.
#[derive(Clone, Debug, Default)]
pub(crate) struct FailureSlot(Arc<Mutex<Option<NavigatorError>>>);

impl FailureSlot {
    fn put(&self, error: NavigatorError) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// The error, if there is one.
    pub(crate) fn get(&self) -> Option<NavigatorError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A navigator's program, as a navigator.
struct NavigatorProcess {
    channel: Channel,
    failure: FailureSlot,
    rest: MountAngles,
    state: State,
    measurement: Measurement,
}

impl NavigatorCommand {
    /// From a command line: words apart by spaces, with quotes as shells have them, but without a shell.
    ///
    /// # Errors
    /// Where there is no word, or a quote is not closed.
    pub fn parse(line: &str, limit: Duration) -> Result<Self, WordsError> {
        let mut words = words(line)?.into_iter();
        let program = words.next().ok_or(WordsError::Empty)?;
        Ok(Self { program, arguments: words.collect(), limit })
    }

    /// Whether there is such a program, as far as can be told without starting it: a path that leads somewhere, or a name in `PATH`.
    pub fn is_there(&self) -> bool {
        let ending = std::env::consts::EXE_SUFFIX;
        let exists = |path: &Path| path.is_file() || Path::new(&format!("{}{ending}", path.display())).is_file();
        let path = Path::new(&self.program);
        if path.components().count() > 1 || self.program.contains(std::path::is_separator) {
            return exists(path);
        }
        std::env::var_os("PATH").is_some_and(|all| std::env::split_paths(&all).any(|folder| exists(&folder.join(path))))
    }

    /// Starts it and tells it of the scenario what a navigator may know.
    ///
    /// # Errors
    /// Where it cannot be started, or does not greet back.
    pub fn start(&self, scenario: &Scenario) -> Result<Pilot, NavigatorError> {
        let mut channel = Channel::open(self)?;
        channel.greet(&hello::hello(scenario))?;
        let failure = FailureSlot::default();
        let navigator = NavigatorProcess {
            channel,
            failure: failure.clone(),
            rest: scenario.rig.mount.rest,
            state: State::Unknown,
            measurement: Measurement::default(),
        };
        Ok(Pilot::of_process(Box::new(navigator), failure))
    }
}

impl Navigator for NavigatorProcess {
    fn on_frame(&mut self, frame: &Frame<'_>, counts: Counts, mount: MountAngles, tick: Tick) -> Command {
        match self.channel.exchange(frame, counts, mount, tick) {
            Ok(answer) => {
                self.state = answer.state;
                self.measurement =
                    Measurement { lateral_m: answer.lateral_m, heading_rad: answer.heading_rad, ..Measurement::default() };
                answer.command
            }
            Err(error) => {
                self.failure.put(error);
                Command::stop(self.rest)
            }
        }
    }

    fn report(&self) -> Report<'_> {
        Report { state: self.state, measurement: self.measurement, ..Report::default() }
    }
}
