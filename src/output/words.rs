//! Figures, bounds and reasons as people read them: millimetres and degrees.

use serde_json::Value;

use crate::metrics::{Metrics, Reason};
use crate::scenario::{Bound, Criterion, Measured, Scenario};

/// How a metric is shown.
#[derive(Clone, Copy, Debug)]
pub struct MetricWords {
    /// Its name in the summary.
    pub metric: &'static str,
    /// What people call it.
    pub label: &'static str,
    /// Unit that it is shown in; may be empty.
    pub unit: &'static str,
    /// What a value in SI is multiplied by for that.
    pub per_si: f64,
}

const fn words(metric: &'static str, label: &'static str, unit: &'static str, per_si: f64) -> MetricWords {
    MetricWords { metric, label, unit, per_si }
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// All metrics of a summary, in its order.
pub const METRICS: [MetricWords; 33] = [
    words("completed", "finish line passed", "", 1.0),
    words("end_state", "how it ended", "", 1.0),
    words("stop_reason", "why it stopped", "", 1.0),
    words("distance_m", "distance covered", "m", 1.0),
    words("sim_time_s", "simulated time", "s", 1.0),
    words("wall_time_s", "time it took", "s", 1.0),
    words("real_time_factor", "real-time factor", "×", 1.0),
    words("lateral_rms_m", "RMS lateral error", "mm", 1e3),
    words("lateral_max_m", "largest lateral error", "mm", 1e3),
    words("heading_rms_rad", "RMS heading error", "°", DEGREES),
    words("heading_max_rad", "largest heading error", "°", DEGREES),
    words("lateral_estimate_rms_m", "RMS error of the lateral estimate", "mm", 1e3),
    words("heading_estimate_rms_rad", "RMS error of the heading estimate", "°", DEGREES),
    words("filtered_lateral_rms_m", "RMS error of the estimator's offset", "mm", 1e3),
    words("filtered_log_loss", "log loss of the estimator", "", 1.0),
    words("estimates_valid", "frames with a valid estimate", "%", 100.0),
    words("collisions", "collisions", "", 1.0),
    words("contact_speed_max_m_s", "highest contact speed", "mm/s", 1e3),
    words("min_clearance_m", "least clearance", "mm", 1e3),
    words("junctions_taken", "junctions taken", "", 1.0),
    words("survey_drift_share", "drift of the survey over the way", "%", 100.0),
    words("survey_length_error_max", "largest error of a surveyed length", "%", 100.0),
    words("survey_width_error_max_m", "largest error of a surveyed width", "mm", 1e3),
    words("survey_deposits_missed", "deposits not found", "", 1.0),
    words("survey_deposits_false", "deposits found where nothing lies", "", 1.0),
    words("survey_deposit_error_max_m", "largest error of a deposit's thickness", "mm", 1e3),
    words("ahead_fittings", "fittings and ends come to", "", 1.0),
    words("ahead_named_share", "named rightly before they were entered", "%", 100.0),
    words("ahead_detection_widths_min", "least detection distance", "widths", 1.0),
    words("ahead_latency_max_s", "longest time until one was named rightly", "s", 1.0),
    words("ahead_distance_error_max_m", "largest error of the distance to one", "mm", 1e3),
    words("ahead_false_alarms", "false alarms in straight ducts", "", 1.0),
    words("control_effort", "control effort", "rad/s²", 1.0),
];

/// The words for a metric; one that is not known is called by its name and shown in SI.
pub fn metric_words(metric: &str) -> MetricWords {
    METRICS.into_iter().find(|words| words.metric == metric).unwrap_or(words("", "another figure", "", 1.0))
}

/// A number with at least `digits` significant digits and no zeros at the end.
pub fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "not a number".to_owned();
    }
    let magnitude = if value == 0.0 { 0 } else { libm::floor(libm::log10(value.abs())) as i64 };
    let decimals = (digits as i64 - 1 - magnitude).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl MetricWords {
    /// A value of the metric, in SI, with its unit.
    pub fn show(&self, measured: Measured<'_>, digits: usize) -> String {
        match measured {
            Measured::Number(value) => self.with_unit(&number(value * self.per_si, digits)),
            Measured::Flag(true) => "yes".to_owned(),
            Measured::Flag(false) => "no".to_owned(),
            Measured::Word(word) => word.to_owned(),
            // A run that finished, or that something else ended, has no such reason: nothing that could have been measured.
            Measured::Nothing if self.metric == "stop_reason" => "nothing stopped it".to_owned(),
            Measured::Nothing => "not measured".to_owned(),
        }
    }

    /// A number as it was written, with the metric's unit.
    pub fn with_unit(&self, number: &str) -> String {
        match self.unit {
            "" => number.to_owned(),
            // A degree sign stands close, other units do not.
            "°" => format!("{number}°"),
            unit => format!("{number}\u{a0}{unit}"),
        }
    }
}

/// The fewest digits, from three, that tell the value from its bound: nobody believes "5 mm is more than 5 mm".
fn telling_digits(value: f64, bound: f64) -> usize {
    (3..12).find(|digits| value == bound || number(value, *digits) != number(bound, *digits)).unwrap_or(12)
}

/// A criterion held against what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// What the metric is called.
    pub label: &'static str,
    /// Its key in the scenario.
    pub key: &'static str,
    /// What it had to be: `at most 5 mm`.
    pub bound: String,
    /// What it was.
    pub value: String,
    /// How far inside the bound it lay, outside if negative: `1.2 mm (24 %)`; empty where that has no meaning.
    pub margin: String,
    /// Value over bound where the bound is a maximum, bound over value where it is a minimum: 1 is just kept.
    pub share: Option<f64>,
    /// Whether it was kept.
    pub kept: bool,
}

impl Held {
    /// A criterion of the scenario against the run's figures.
    pub fn of(criterion: &Criterion, metrics: &Metrics) -> Self {
        let words = metric_words(criterion.metric);
        let measured = metrics.get(criterion.metric);
        let kept = criterion.bound.holds(measured);
        let held = Self {
            label: words.label,
            key: criterion.key,
            bound: String::new(),
            value: words.show(measured, 3),
            margin: String::new(),
            share: None,
            kept,
        };
        let (bound, sign, word) = match &criterion.bound {
            Bound::AtMost(bound) => (*bound, 1.0, "at most"),
            Bound::AtLeast(bound) => (*bound, -1.0, "at least"),
            Bound::Is(flag) => return Self { bound: words.show(Measured::Flag(*flag), 3), ..held },
            Bound::Word(word) => return Self { bound: word.clone(), ..held },
        };
        let bound_text = words.show(Measured::Number(bound), 6);
        let Measured::Number(value) = measured else { return Self { bound: format!("{word} {bound_text}"), ..held } };
        let digits = telling_digits(value, bound);
        let margin = words.show(Measured::Number(sign * (bound - value)), 3);
        let share = if sign > 0.0 { value / bound } else { bound / value };
        let percent = sign * (bound - value) / bound.abs() * 100.0;
        let relative = match percent {
            // Percent of percent would not be understood.
            _ if bound == 0.0 || words.unit == "%" => String::new(),
            _ if share >= 3.0 && share.is_finite() && sign > 0.0 => format!(" ({} × the bound)", number(share, 2)),
            percent => format!(" ({} %)", number(percent, 2)),
        };
        Self {
            bound: format!("{word} {bound_text}"),
            value: words.show(measured, digits),
            margin: format!("{margin}{relative}"),
            share: Some(share).filter(|share| share.is_finite() && *share >= 0.0),
            ..held
        }
    }
}

/// A reason of the verdict as a sentence: `RMS lateral error: 7.3 mm; it must be at most 5 mm.`
pub fn reason(scenario: &Scenario, metrics: &Metrics, reason: &Reason) -> String {
    let when = reason.at_s.map_or(String::new(), |at_s| format!(", first at {} s", number(at_s, 4)));
    let criterion = scenario.pass.list.iter().find(|c| c.metric == reason.metric && !c.bound.holds(metrics.get(c.metric)));
    if let Some(criterion) = criterion {
        let Held { label, bound, value, .. } = Held::of(criterion, metrics);
        return sentence(&format!("{label}: {value}{when}; it must be {bound}."));
    }
    let words = metric_words(&reason.metric);
    let (value, bound) = (shown(&words, &reason.value), shown(&words, &reason.bound));
    if reason.metric == "sim_time_s" {
        return format!("The time limit of {bound} of simulated time was reached.");
    }
    sentence(&format!("{}: {value}{when}; the bound is {bound}.", words.label))
}

fn shown(words: &MetricWords, value: &Value) -> String {
    match value {
        Value::Number(number) => words.show(number.as_f64().map_or(Measured::Nothing, Measured::Number), 4),
        Value::Bool(flag) => words.show(Measured::Flag(*flag), 4),
        Value::String(word) => word.clone(),
        _ => words.show(Measured::Nothing, 4),
    }
}

/// The same with a capital at its beginning.
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_matter() {
        let shown = [0.0, 4.0, 4.25159, 0.012_345, -0.0, 1234.5, 99.96, f64::NAN].map(|x| number(x, 3));
        assert_eq!(shown, ["0", "4", "4.25", "0.0123", "0", "1234", "100", "not a number"]);
    }

    #[test]
    fn a_value_just_past_its_bound_is_told_from_it() {
        let digits = telling_digits(5.0004, 5.0);
        assert_eq!((number(5.0004, digits), number(5.0, digits)), ("5.0004".into(), "5".into()));
        assert_eq!(telling_digits(7.3, 5.0), 3);
    }

    #[test]
    fn margins_are_those_of_a_person_with_a_ruler() {
        let mut metrics = Metrics {
            completed: true,
            end_state: "finished",
            stop_reason: None,
            distance_m: 4.0,
            sim_time_s: 20.0,
            wall_time_s: None,
            real_time_factor: None,
            lateral_rms_m: Some(0.004),
            lateral_max_m: Some(0.05),
            heading_rms_rad: None,
            heading_max_rad: None,
            lateral_estimate_rms_m: None,
            heading_estimate_rms_rad: None,
            filtered_lateral_rms_m: None,
            filtered_log_loss: None,
            estimates_valid: Some(0.9),
            collisions: 2,
            contact_speed_max_m_s: 0.0,
            min_clearance_m: Some(0.02),
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
        let held = |metric, bound, metrics: &Metrics| {
            let scale = crate::scenario::fields::Scale::Si;
            let held = Held::of(&Criterion { key: "key", metric, unit: "", scale, bound }, metrics);
            (held.bound, held.value, held.margin, held.kept)
        };
        let row = |bound: &str, value: &str, margin: &str, kept| (bound.to_owned(), value.to_owned(), margin.to_owned(), kept);
        let nbsp = |text: &str| text.replace('_', "\u{a0}");
        assert_eq!(
            held("lateral_rms_m", Bound::AtMost(0.005), &metrics),
            row(&nbsp("at most 5_mm"), &nbsp("4_mm"), &nbsp("1_mm (20 %)"), true)
        );
        assert_eq!(
            held("lateral_max_m", Bound::AtMost(0.01), &metrics),
            row(&nbsp("at most 10_mm"), &nbsp("50_mm"), &nbsp("-40_mm (5 × the bound)"), false)
        );
        assert_eq!(
            held("min_clearance_m", Bound::AtLeast(0.03), &metrics),
            row(&nbsp("at least 30_mm"), &nbsp("20_mm"), &nbsp("-10_mm (-33 %)"), false)
        );
        assert_eq!(
            held("estimates_valid", Bound::AtLeast(0.8), &metrics),
            row(&nbsp("at least 80_%"), &nbsp("90_%"), &nbsp("10_%"), true)
        );
        assert_eq!(held("collisions", Bound::AtMost(0.0), &metrics), row("at most 0", "2", "-2", false));
        assert_eq!(held("completed", Bound::Is(true), &metrics), row("yes", "yes", "", true));
        // It finished: there is nothing that could have been measured.
        let word = Bound::Word("drop".to_owned());
        assert_eq!(held("stop_reason", word, &metrics), row("drop", "nothing stopped it", "", false));
        metrics.lateral_rms_m = None;
        let unmeasured = held("lateral_rms_m", Bound::AtMost(0.005), &metrics);
        assert_eq!(unmeasured, row(&nbsp("at most 5_mm"), "not measured", "", false));
    }
}
