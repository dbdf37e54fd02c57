//! A bar a run on a terminal; elsewhere nothing, so that logs stay readable.

use std::time::Duration;

use ductloop::record::FrameRecord;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A run's progress: distance along the duct out of the distance to the finish line.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar for run `index` of `count`.
    pub(crate) fn new(name: &str, index: usize, count: usize, distance_m: f64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let bar = ProgressBar::with_draw_target(Some((distance_m.max(0.0) * 1e3) as u64), target);
        let style = ProgressStyle::with_template("[{prefix}] {wide_bar} {percent:>3} %  {msg}  {elapsed} (left {eta})");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_prefix(format!("{}/{count} {name}", index + 1));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// Shows a frame.
    pub(crate) fn frame(&self, record: &FrameRecord, start_m: f64) {
        self.0.set_position(((record.truth.distance_m - start_m).max(0.0) * 1e3) as u64);
        // Formatting every frame would cost more than the bar is worth.
        if record.frame.is_multiple_of(15) {
            let lateral_mm = record.truth.lateral_m * 1e3;
            self.0.set_message(format!("{:.1} s  {:.2} m  {lateral_mm:+.1} mm", record.time_s, record.truth.distance_m));
        }
    }

    /// Takes the bar away.
    pub(crate) fn done(self) {
        self.0.finish_and_clear();
    }
}
