//! What a scenario came to over its seeds.

use std::cmp::Ordering;

use ductloop::{Scenario, Verdict};
use serde_json::{Value, json};

use super::run::Finished;

/// The runs of one scenario with several seeds.
pub(crate) struct SeedVerdict<'a> {
    /// The scenario; its own seed is of no account here.
    pub(crate) scenario: &'a Scenario,
    /// How many seeds there are.
    pub(crate) seeds: usize,
    /// How many of them must pass.
    pub(crate) at_least: usize,
    /// Those that are over, in the order of the seeds; an interrupt leaves some out.
    pub(crate) runs: Vec<&'a Finished>,
}

/// A figure over the seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    /// The middle one; of an even number the mean of the two in the middle.
    pub(crate) median: f64,
    /// The largest.
    pub(crate) worst: f64,
}

impl SeedVerdict<'_> {
    /// How many seeds passed.
    pub(crate) fn passed(&self) -> usize {
        self.runs.iter().filter(|run| run.summary.verdict == Verdict::Pass).count()
    }

    /// Whether as many passed as have to.
    pub(crate) fn enough_passed(&self) -> bool {
        self.passed() >= self.at_least
    }

    /// The scenario's verdict. A run that could not go on, or was not given the time, is not made up for by others. `None` where an
    /// interrupt has left seeds out.
    pub(crate) fn verdict(&self) -> Option<Verdict> {
        let broken = self.runs.iter().map(|run| run.summary.verdict).max().filter(|worst| *worst > Verdict::Fail);
        let by_count = if self.enough_passed() { Verdict::Pass } else { Verdict::Fail };
        (self.runs.len() == self.seeds).then(|| broken.unwrap_or(by_count))
    }

    /// A figure over the seeds whose runs came to their end; `None` where it was measured in none.
    pub(crate) fn spread(&self, figure: impl Fn(&Finished) -> Option<f64>) -> Option<Spread> {
        let ended = self.runs.iter().filter(|run| run.summary.verdict <= Verdict::Fail);
        let mut values: Vec<f64> = ended.filter_map(|run| figure(run)).collect();
        values.sort_by(f64::total_cmp);
        let worst = *values.last()?;
        let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
        Some(Spread { median: low + (high - low) / 2.0, worst })
    }

    /// The runs, the worst first: by verdict, then by what they were off the centreline; what was not measured is worse than
    /// anything that was. Equals stay in the order of the seeds.
    pub(crate) fn worst_first(&self) -> Vec<&Finished> {
        let mut runs = self.runs.clone();
        runs.sort_by(|a, b| worse(b, a));
        runs
    }

    /// `{"scenario", "seeds", "passed", "at_least", "verdict"}`.
    pub(crate) fn to_json(&self) -> Value {
        json!({
            "scenario": self.scenario.name,
            "seeds": self.seeds,
            "passed": self.passed(),
            "at_least": self.at_least,
            "verdict": self.verdict().map(Verdict::word),
        })
    }
}

fn worse(a: &Finished, b: &Finished) -> Ordering {
    let off = |run: &Finished| [run.summary.metrics.lateral_rms_m, run.summary.metrics.heading_rms_rad];
    let figure = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    let by_figures = || off(a).into_iter().zip(off(b)).map(|(a, b)| figure(a).total_cmp(&figure(b)));
    a.summary.verdict.cmp(&b.summary.verdict).then_with(|| by_figures().fold(Ordering::Equal, Ordering::then))
}

#[cfg(test)]
mod tests {
    use ductloop::Metrics;
    use ductloop::output::Summary;

    use super::*;

    /// A run that came to this, so many metres off the centreline.
    fn run(seed: u64, verdict: Verdict, lateral_rms_m: Option<f64>) -> Finished {
        let metrics = Metrics {
            completed: true,
            end_state: "finished",
            stop_reason: None,
            distance_m: 5.0,
            sim_time_s: 17.0,
            wall_time_s: None,
            real_time_factor: None,
            lateral_rms_m,
            lateral_max_m: None,
            heading_rms_rad: Some(0.01),
            heading_max_rad: None,
            lateral_estimate_rms_m: None,
            heading_estimate_rms_rad: None,
            filtered_lateral_rms_m: None,
            filtered_log_loss: None,
            estimates_valid: None,
            collisions: 0,
            contact_speed_max_m_s: 0.0,
            min_clearance_m: None,
            junctions_taken: 0,
            survey_drift_share: None,
            survey_length_error_max: None,
            survey_width_error_max_m: None,
            survey_deposits_missed: None,
            survey_deposits_false: None,
            survey_deposit_error_max_m: None,
            ahead_fittings: 0,
            ahead_named_share: None,
            ahead_detection_widths_min: None,
            ahead_latency_max_s: None,
            ahead_distance_error_max_m: None,
            ahead_false_alarms: None,
            control_effort: None,
        };
        let summary = Summary {
            format: 1,
            scenario: "t".into(),
            verdict,
            reasons: Vec::new(),
            seed,
            renderer: "cpu".into(),
            run_hash: None,
            metrics,
            ahead: Default::default(),
            message: None,
        };
        Finished { input: 0, name: format!("t-s{seed}"), summary, report: None }
    }

    fn scenario() -> Scenario {
        let text =
            "format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 6.0 }]";
        Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
    }

    #[test]
    fn the_verdict_counts_passes_unless_a_run_broke_or_is_missing() {
        use Verdict::{Error, Fail, Pass, Timeout};
        let scenario = scenario();
        let verdict = |verdicts: &[Verdict], seeds: usize, at_least: usize| {
            let runs: Vec<_> = verdicts.iter().zip(1..).map(|(verdict, seed)| run(seed, *verdict, None)).collect();
            SeedVerdict { scenario: &scenario, seeds, at_least, runs: runs.iter().collect() }.verdict()
        };
        assert_eq!(verdict(&[Pass, Pass, Pass], 3, 3), Some(Pass));
        assert_eq!(verdict(&[Pass, Fail, Pass], 3, 3), Some(Fail));
        assert_eq!(verdict(&[Pass, Fail, Pass], 3, 2), Some(Pass));
        assert_eq!(verdict(&[Pass, Error, Pass], 3, 2), Some(Error));
        assert_eq!(verdict(&[Timeout, Error, Pass], 3, 1), Some(Timeout));
        assert_eq!(verdict(&[Pass, Pass], 3, 2), None, "one was not run");
    }

    #[test]
    fn figures_are_of_runs_that_ended_and_the_worst_comes_first() {
        let scenario = scenario();
        let runs = [
            run(1, Verdict::Pass, Some(2.0)),
            run(2, Verdict::Error, Some(90.0)),
            run(3, Verdict::Fail, Some(1.0)),
            run(4, Verdict::Pass, Some(5.0)),
            run(5, Verdict::Pass, None),
            run(6, Verdict::Pass, Some(3.0)),
            run(7, Verdict::Pass, Some(5.0)),
        ];
        let all = SeedVerdict { scenario: &scenario, seeds: 7, at_least: 7, runs: runs.iter().collect() };
        let order: Vec<_> = all.worst_first().iter().map(|run| run.summary.seed).collect();
        // The error, the failure, what was not measured, then by distance; 4 and 7 are equal.
        assert_eq!(order, [2, 3, 5, 4, 7, 6, 1]);
        let lateral = |count: usize| {
            let some = SeedVerdict { runs: runs.iter().take(count).collect(), seeds: 7, at_least: 7, scenario: &scenario };
            some.spread(|run| run.summary.metrics.lateral_rms_m)
        };
        // Of 1, 2, 3, 5, 5 m, and of 1, 2, 5 and 1, 2 m; the error's 90 m do not count.
        assert_eq!(lateral(7), Some(Spread { median: 3.0, worst: 5.0 }));
        assert_eq!(lateral(5), Some(Spread { median: 2.0, worst: 5.0 }));
        assert_eq!(lateral(3), Some(Spread { median: 1.5, worst: 2.0 }));
        assert_eq!(all.spread(|_| None), None);
        assert_eq!((all.passed(), all.enough_passed()), (5, false));
    }
}
