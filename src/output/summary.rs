//! `summary.json`: verdict and figures of a run.

use serde::Serialize;

use crate::ahead_scores::AheadScores;
use crate::metrics::{Metrics, Reason, Verdict, judge};
use crate::record::RunRecord;
use crate::scenario::Scenario;

/// What a run came to, as `summary.json` says it: fields in this order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Version of this document's format.
    pub format: u32,
    /// The scenario's name.
    pub scenario: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Every criterion that did not hold.
    pub reasons: Vec<Reason>,
    /// The scenario's seed.
    pub seed: u64,
    /// What rendered: `wgpu` or `cpu`.
    pub renderer: String,
    /// XXH3-128 of the run in 32 hexadecimal digits; null for a run that did not come to its end.
    pub run_hash: Option<String>,
    /// Its figures.
    pub metrics: Metrics,
    /// What lay ahead against what it was named, fitting by fitting and as counts that add up over runs.
    pub ahead: AheadScores,
    /// Why the run ended early, in words; only with the verdicts `error` and `timeout`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
}

impl Summary {
    /// Of a run that came to its end, which took `wall_time_s`.
    pub fn of(scenario: &Scenario, run: &RunRecord, renderer: &str, wall_time_s: Option<f64>) -> Self {
        let ahead = AheadScores::of(scenario, run);
        let metrics = Metrics::with_ahead(scenario, run, &ahead, wall_time_s);
        let (verdict, reasons) = judge(scenario, run, &metrics);
        Self {
            format: 1,
            scenario: scenario.name.clone(),
            verdict,
            reasons,
            seed: scenario.seed,
            renderer: renderer.to_owned(),
            run_hash: Some(format!("{:032x}", run.run_hash)),
            metrics,
            ahead,
            message: None,
        }
    }

    /// The same for a run that could not go on ([`Verdict::Error`]) or was not given the time to ([`Verdict::Timeout`]): the
    /// figures are those of its frames so far, and of its criteria nothing is said.
    pub fn broken_off(self, verdict: Verdict, message: impl Into<String>) -> Self {
        Self { verdict, message: Some(message.into()), reasons: Vec::new(), run_hash: None, ..self }
    }

    /// The document's text.
    ///
    /// # Errors
    /// None that is known of: a number that is not finite becomes null.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
