//! Bars on a terminal: one a run, or one for all runs of a call; elsewhere nothing, so that logs stay readable.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use ductloop::Verdict;
use ductloop::record::FrameRecord;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// What is shown of the runs of a call.
pub(crate) enum Progress {
    /// A bar for each while it is on.
    Each {
        /// How many there are.
        count: usize,
        /// Whether nothing is shown.
        quiet: bool,
    },
    /// One bar for all.
    All(AllRuns),
}

/// All runs in one bar: how many are done, how many of them did not pass, and the time left.
pub(crate) struct AllRuns {
    /// A run is [`AllRuns::STEPS`] of it, so that it moves on while runs are on, and the time left is known before the first is done.
    bar: ProgressBar,
    count: usize,
    done: AtomicUsize,
    failed: AtomicUsize,
}

/// A run's share in it: distance along the duct out of the distance to the finish line.
pub(crate) struct RunProgress<'a> {
    shown: Shown<'a>,
    start_m: f64,
    distance_m: f64,
}

enum Shown<'a> {
    Own(ProgressBar),
    /// Steps that are shown so far.
    Share(&'a AllRuns, u64),
}

impl Progress {
    /// For `count` runs; `as_one` shows them in one bar.
    pub(crate) fn new(count: usize, as_one: bool, quiet: bool) -> Self {
        if as_one { Self::All(AllRuns::new(count, target(quiet))) } else { Self::Each { count, quiet } }
    }

    /// Of run `index`, which begins at `start_m` and has `distance_m` to go.
    pub(crate) fn run(&self, name: &str, index: usize, start_m: f64, distance_m: f64) -> RunProgress<'_> {
        let shown = match self {
            Self::All(all) => Shown::Share(all, 0),
            Self::Each { count, quiet } => {
                let length = (distance_m.max(0.0) * 1e3) as u64;
                let bar = styled(length, target(*quiet), "[{prefix}] {wide_bar} {percent:>3} %  {msg}  {elapsed} (left {eta})");
                bar.set_prefix(format!("{}/{count} {name}", index + 1));
                Shown::Own(bar)
            }
        };
        RunProgress { shown, start_m, distance_m }
    }

    /// Takes the bar of all away.
    pub(crate) fn done(self) {
        if let Self::All(all) = self {
            all.bar.finish_and_clear();
        }
    }
}

impl AllRuns {
    const STEPS: u64 = 1000;

    fn new(count: usize, target: ProgressDrawTarget) -> Self {
        let template = "{wide_bar} {percent:>3} %  {msg}  {elapsed} (left {eta})";
        let all = Self {
            bar: styled(count as u64 * Self::STEPS, target, template),
            count,
            done: AtomicUsize::new(0),
            failed: AtomicUsize::new(0),
        };
        all.tell();
        all
    }

    fn tell(&self) {
        let (done, failed) = (self.done.load(Ordering::Relaxed), self.failed.load(Ordering::Relaxed));
        self.bar.set_message(format!("{done} of {} runs done, {failed} failed", self.count));
    }
}

impl RunProgress<'_> {
    /// Shows a frame.
    pub(crate) fn frame(&mut self, record: &FrameRecord) {
        let gone_m = (record.truth.distance_m - self.start_m).max(0.0);
        match &mut self.shown {
            Shown::Own(bar) => {
                bar.set_position((gone_m * 1e3) as u64);
                // Formatting every frame would cost more than the bar is worth.
                if record.frame.is_multiple_of(15) {
                    let lateral_mm = record.truth.lateral_m * 1e3;
                    bar.set_message(format!("{:.1} s  {:.2} m  {lateral_mm:+.1} mm", record.time_s, record.truth.distance_m));
                }
            }
            Shown::Share(all, shown) => {
                let share = if self.distance_m > 0.0 { (gone_m / self.distance_m).min(1.0) } else { 0.0 };
                show_up_to(all, shown, (share * AllRuns::STEPS as f64) as u64);
            }
        }
    }

    /// Takes the run's bar away, or counts it among those that are done; without a verdict it was broken off.
    pub(crate) fn done(self, verdict: Option<Verdict>) {
        match self.shown {
            Shown::Own(bar) => bar.finish_and_clear(),
            Shown::Share(all, mut shown) => {
                let Some(verdict) = verdict else { return };
                show_up_to(all, &mut shown, AllRuns::STEPS);
                all.done.fetch_add(1, Ordering::Relaxed);
                if verdict != Verdict::Pass {
                    all.failed.fetch_add(1, Ordering::Relaxed);
                }
                all.tell();
            }
        }
    }
}

/// Moves the bar of all on to `steps` of a run of which `shown` are shown. A robot that rolls back does not move it back.
fn show_up_to(all: &AllRuns, shown: &mut u64, steps: u64) {
    if steps > *shown {
        all.bar.inc(steps - *shown);
        *shown = steps;
    }
}

fn target(quiet: bool) -> ProgressDrawTarget {
    if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) }
}

fn styled(length: u64, target: ProgressDrawTarget, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(length), target);
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_of_all_counts_what_is_done_and_moves_while_runs_are_on() {
        let all = AllRuns::new(3, ProgressDrawTarget::hidden());
        let told = |all: &AllRuns| (all.bar.position(), all.bar.message());
        let run = || RunProgress { shown: Shown::Share(&all, 0), start_m: 0.5, distance_m: 2.0 };
        assert_eq!(told(&all), (0, "0 of 3 runs done, 0 failed".into()));
        let (passing, failing, broken) = (run(), run(), run());
        let mut shown = 0;
        show_up_to(&all, &mut shown, 250);
        show_up_to(&all, &mut shown, 100);
        assert_eq!(told(&all).0, 250, "it does not go back");
        drop(broken);
        passing.done(Some(Verdict::Pass));
        failing.done(Some(Verdict::Timeout));
        assert_eq!(told(&all), (2250, "2 of 3 runs done, 1 failed".into()));
        run().done(None);
        assert_eq!(told(&all), (2250, "2 of 3 runs done, 1 failed".into()));
    }
}
