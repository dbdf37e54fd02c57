//! What a run must achieve: bounds on the metrics of its summary.

use super::fields::Scale;

/// The criteria of a run, all of which must hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Criteria {
    /// Distance from the start that metrics of tracking leave out, in metres.
    pub settle_m: f64,
    /// The criteria, in the order of the table of fields.
    pub list: Vec<Criterion>,
}

/// A bound on a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// Its key in the file: `lateral_rms_mm`.
    pub key: &'static str,
    /// The metric of the summary: `lateral_rms_m`.
    pub metric: &'static str,
    /// The key's unit, as in `mm`; empty if it has none.
    pub unit: &'static str,
    /// How a number in that unit becomes the metric's.
    pub scale: Scale,
    /// The bound, in the metric's unit.
    pub bound: Bound,
}

/// What a metric must be.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// At most this.
    AtMost(f64),
    /// At least this.
    AtLeast(f64),
    /// This truth value.
    Is(bool),
    /// This word.
    Word(String),
}

/// A metric as it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured<'a> {
    /// A number, in SI.
    Number(f64),
    /// A truth value.
    Flag(bool),
    /// A word.
    Word(&'a str),
    /// It was not measured, or could not be.
    Nothing,
}

impl Bound {
    /// Whether what was measured keeps the bound. What was not measured, is not a number, or is of another type does not.
    pub fn holds(&self, measured: Measured<'_>) -> bool {
        match (self, measured) {
            (Self::AtMost(bound), Measured::Number(value)) => value <= *bound,
            (Self::AtLeast(bound), Measured::Number(value)) => value >= *bound,
            (Self::Is(bound), Measured::Flag(value)) => value == *bound,
            (Self::Word(bound), Measured::Word(value)) => value == bound,
            _ => false,
        }
    }
}

impl Criteria {
    /// The criterion with this key.
    pub fn get(&self, key: &str) -> Option<&Criterion> {
        self.list.iter().find(|c| c.key == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_measured_keeps_no_bound() {
        assert!(Bound::AtMost(1.0).holds(Measured::Number(1.0)));
        assert!(!Bound::AtMost(1.0).holds(Measured::Number(1.1)));
        assert!(!Bound::AtLeast(1.0).holds(Measured::Number(0.9)));
        assert!(Bound::Word("finished".into()).holds(Measured::Word("finished")));
        for bound in [Bound::AtMost(1.0), Bound::AtLeast(0.0), Bound::Is(true), Bound::Word("x".into())] {
            assert!(!bound.holds(Measured::Nothing));
            assert!(!bound.holds(Measured::Number(f64::NAN)));
        }
    }
}
