//! What came of a case.

use super::case::CaseHash;
use crate::metrics::{Metrics, Verdict};
use crate::scenario::Measured;

/// A case's result. All but the last two fields follow from the case alone, unless its wall-clock limit was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The case.
    pub hash: CaseHash,
    /// Its verdict.
    pub verdict: Verdict,
    /// Metrics whose bounds did not hold, in a list with commas.
    pub reasons: String,
    /// How the run ended.
    pub end_state: Option<String>,
    /// The metrics of [`Metrics::NUMBERS`], in its order.
    pub metrics: [Option<f64>; Metrics::NUMBERS.len()],
    /// Hash of the run; `None` if it did not come to its end.
    pub run_hash: Option<String>,
    /// Why it did not.
    pub error: Option<String>,
    /// Time that it took, in seconds.
    pub wall_time_s: f64,
    /// Machine that it ran on.
    pub host: String,
}

impl Outcome {
    /// A metric by its name.
    pub fn metric(&self, name: &str) -> Option<f64> {
        let index = Metrics::NUMBERS.iter().position(|other| *other == name)?;
        self.metrics[index]
    }

    /// Simulated time over time that passed.
    pub fn real_time_factor(&self) -> Option<f64> {
        self.metric("sim_time_s").filter(|_| self.wall_time_s > 0.0).map(|sim_time_s| sim_time_s / self.wall_time_s)
    }

    /// Whether the case passed.
    pub fn passed(&self) -> bool {
        self.verdict == Verdict::Pass
    }
}

/// The metrics that are kept, of a run.
pub fn numbers(metrics: &Metrics) -> [Option<f64>; Metrics::NUMBERS.len()] {
    Metrics::NUMBERS.map(|name| match metrics.get(name) {
        Measured::Number(value) if value.is_finite() => Some(value),
        _ => None,
    })
}
