//! How far a sweep is: a bar on a terminal, a line now and then elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use ductloop::sweep::work::Tally;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::streams::note;

/// Time between two lines where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// The bar.
pub(super) struct Bar {
    bar: ProgressBar,
    /// When the next line is due; `None` where a bar is drawn or nothing is to be said.
    lines: Option<Mutex<Instant>>,
    started: Instant,
}

impl Bar {
    pub(super) fn new(quiet: bool) -> Self {
        let drawn = !quiet && std::io::stderr().is_terminal();
        let target = if drawn { ProgressDrawTarget::stderr_with_hz(5) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} cases  {msg}  {elapsed} (left {eta})");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(500));
        let started = Instant::now();
        Self { bar, lines: (!quiet && !drawn).then(|| Mutex::new(started + BETWEEN_LINES)), started }
    }

    /// Shows a tally.
    pub(super) fn show(&self, tally: Tally) {
        let Tally { cases, done, found, failed } = tally;
        self.draw(cases, done, found, &format!("{failed} failed"));
    }

    /// Shows how far others are: `done` of `cases`, `found` of them from before, and what there is to say of those at work.
    pub(super) fn draw(&self, cases: u64, done: u64, found: u64, said: &str) {
        self.bar.set_length(cases);
        self.bar.set_position(done);
        if done == found {
            // What was done before says nothing of how long the rest takes.
            self.bar.reset_eta();
        }
        let rate = done.saturating_sub(found) as f64 / self.started.elapsed().as_secs_f64().max(1e-3);
        let words = format!("{said}, {rate:.2} a second");
        if let Some(due) = &self.lines {
            let mut due = due.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            if Instant::now() >= *due {
                *due = Instant::now() + BETWEEN_LINES;
                let left = if done > found {
                    format!(", {:.0} s left", cases.saturating_sub(done) as f64 / rate)
                } else {
                    String::new()
                };
                note(&format!("{done} of {cases} cases, {words}{left}"));
            }
        }
        self.bar.set_message(words);
    }

    /// Takes the bar away.
    pub(super) fn done(self) {
        self.bar.finish_and_clear();
    }
}
