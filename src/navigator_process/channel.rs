//! A navigator's program behind its pipes, with a time limit on every answer.
//!
//! Two threads stand between, as a pipe that is full or empty blocks whoever writes or reads it: one writes what it is handed, one
//! reads messages and hands them on. They end with the pipes; the program is ended, and waited for, when the channel is dropped.

use std::io::{Read, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use ductloop_nav::messages::{Counts, Frame, Tick};
use ductloop_nav::rig::MountAngles;
use serde_json::Value;

use super::protocol::{self, Answer, COMMAND, END, HELLO, MAX_ANSWER, READY, VERSION};
use super::{NavigatorCommand, NavigatorError};

/// A program that has been told that the run is over, or whose pipe is closed, is given this long to end by itself.
const FAREWELL: Duration = Duration::from_secs(1);

/// What the reading thread found.
enum Heard {
    /// A message: its kind and body.
    Message(u8, Vec<u8>),
    /// Something that is none.
    Garbage(String),
}

/// The program, and the threads' ends.
pub(super) struct Channel {
    child: Child,
    /// `None` once no more is to be written.
    outbox: Option<Sender<Vec<u8>>>,
    inbox: Receiver<Heard>,
    limit: Duration,
}

impl Channel {
    /// Starts the program.
    pub(super) fn open(command: &NavigatorCommand) -> Result<Self, NavigatorError> {
        let cannot = |why: String| NavigatorError::Start { program: command.program.clone(), why };
        let mut program = Command::new(&command.program);
        program.args(&command.arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        // A group of its own: Ctrl-C at a terminal goes to the run, which then ends its navigator.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut program, 0);
        let mut child = program.spawn().map_err(|error| cannot(error.to_string()))?;
        let pipes = (child.stdin.take(), child.stdout.take());
        let (to_writer, outbox) = channel::<Vec<u8>>();
        let (to_us, inbox) = channel();
        // From here on a drop ends the program.
        let channel = Self { child, outbox: Some(to_writer), inbox, limit: command.limit };
        let (Some(mut stdin), Some(stdout)) = pipes else { return Err(cannot("it has no pipes".into())) };
        let spawn = |body: Box<dyn FnOnce() + Send>| {
            let named = thread::Builder::new().name("navigator pipe".into());
            named.spawn(body).map(drop).map_err(|error| cannot(error.to_string()))
        };
        spawn(Box::new(move || {
            // A program that does not read any more is noticed by its missing answer.
            while let Ok(bytes) = outbox.recv() {
                if stdin.write_all(&bytes).and_then(|()| stdin.flush()).is_err() {
                    return;
                }
            }
        }))?;
        spawn(Box::new(move || listen(stdout, &to_us)))?;
        Ok(channel)
    }

    /// Says hello and waits until the program is ready.
    pub(super) fn greet(&mut self, hello: &Value) -> Result<(), NavigatorError> {
        let when = || "while greeting".to_owned();
        self.send(protocol::message(HELLO, hello.to_string().as_bytes()));
        let body = self.hear(READY, &when)?;
        let ready: Value = serde_json::from_slice(&body)
            .map_err(|error| NavigatorError::Garbage { what: format!("its greeting is no JSON: {error}"), when: when() })?;
        match ready.get("protocol").and_then(Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => Ok(()),
            other => Err(NavigatorError::Garbage {
                what: format!("its greeting speaks protocol {other:?}, not {VERSION}"),
                when: when(),
            }),
        }
    }

    /// Hands over a frame and waits for the command.
    pub(super) fn exchange(
        &mut self,
        frame: &Frame<'_>,
        counts: Counts,
        mount: MountAngles,
        tick: Tick,
    ) -> Result<Answer, NavigatorError> {
        let when = || format!("on the frame of tick {tick}");
        self.send(protocol::frame(frame, counts, mount, tick));
        let body = self.hear(COMMAND, &when)?;
        protocol::answer(&body).map_err(|what| NavigatorError::Garbage { what, when: when() })
    }

    fn send(&self, bytes: Vec<u8>) {
        if let Some(outbox) = &self.outbox {
            // Fails only if the writing thread has ended, as the program has: then no answer comes either.
            let _ = outbox.send(bytes);
        }
    }

    /// The next message, which must be of this kind.
    fn hear(&mut self, kind: u8, when: &dyn Fn() -> String) -> Result<Vec<u8>, NavigatorError> {
        match self.inbox.recv_timeout(self.limit) {
            Ok(Heard::Message(heard, body)) if heard == kind => Ok(body),
            Ok(Heard::Message(heard, _)) => {
                Err(NavigatorError::Garbage { what: format!("a message of kind {heard} instead of {kind}"), when: when() })
            }
            Ok(Heard::Garbage(what)) => Err(NavigatorError::Garbage { what, when: when() }),
            Err(RecvTimeoutError::Timeout) => {
                Err(NavigatorError::Slow { limit_s: format!("{}", self.limit.as_secs_f64()), when: when() })
            }
            Err(RecvTimeoutError::Disconnected) => Err(NavigatorError::Ended { how: self.how_it_ended(), when: when() }),
        }
    }

    /// Its exit status, in words. Its pipe is closed, so it is about to end; if it is not, it is ended.
    fn how_it_ended(&mut self) -> String {
        match self.wait(FAREWELL) {
            Some(status) => status.to_string(),
            None => "it closed its standard output".to_owned(),
        }
    }

    /// Waits for the program to end by itself.
    fn wait(&mut self, at_most: Duration) -> Option<std::process::ExitStatus> {
        let started = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(None) if started.elapsed() < at_most => thread::sleep(Duration::from_millis(5)),
                Ok(status) => return status,
                Err(_) => return None,
            }
        }
    }
}

impl Drop for Channel {
    fn drop(&mut self) {
        self.send(protocol::message(END, &[]));
        // The writing thread ends and closes the program's standard input.
        self.outbox = None;
        if self.wait(FAREWELL).is_none() {
            // It may have ended meanwhile: then there is nothing to kill.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Reads messages until the pipe ends or something else than a message comes.
fn listen(mut stdout: ChildStdout, to: &Sender<Heard>) {
    loop {
        let mut head = [0; 5];
        // The pipe's end, wherever it comes, is the program's end: the other side notices by this sender's.
        if stdout.read_exact(&mut head).is_err() {
            return;
        }
        let [a, b, c, d, kind] = head;
        let length = u32::from_le_bytes([a, b, c, d]);
        if length == 0 || length > MAX_ANSWER {
            let what =
                format!("a length of {length} bytes, where 1 to {MAX_ANSWER} may be (its standard output is for messages only)");
            let _ = to.send(Heard::Garbage(what));
            return;
        }
        let mut body = vec![0; length as usize - 1];
        if stdout.read_exact(&mut body).is_err() || to.send(Heard::Message(kind, body)).is_err() {
            return;
        }
    }
}
