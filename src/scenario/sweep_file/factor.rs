//! What is varied: a field of a scenario, and the values that it takes.

use serde::{Deserialize, Serialize};

/// A field with the values that it takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// Its path: `duct.width_m`.
    pub path: String,
    /// Its unit; empty if it has none.
    pub unit: String,
    /// Its values.
    pub levels: Levels,
}

/// A value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Level {
    /// A number.
    Number(f64),
    /// A whole number, of a field that takes no other.
    Integer(i64),
    /// A word, or any other value, as TOML.
    Toml(String),
}

/// The values of a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Levels {
    /// These, each as likely as the others where a design draws.
    List(Vec<Level>),
    /// What lies between two ends, both of which belong to it.
    Range {
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
        /// Even steps in the logarithm.
        log: bool,
        /// Whole numbers only.
        whole: bool,
    },
    /// A normal distribution, cut off where the field's bounds are.
    Normal {
        /// Its mean.
        mean: f64,
        /// Its standard deviation before it is cut off.
        deviation: f64,
        /// Bounds of the field, or narrower ones.
        within: [f64; 2],
    },
}

impl Level {
    /// As TOML.
    pub fn toml(&self) -> String {
        match self {
            // `{:?}` writes the shortest text that reads back as the same number, with a point or an exponent.
            Self::Number(value) => format!("{value:?}"),
            Self::Integer(value) => value.to_string(),
            Self::Toml(text) => text.clone(),
        }
    }

    /// As a number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Integer(value) => Some(*value as f64),
            Self::Toml(_) => None,
        }
    }

    /// As people read it: a word without its quotes.
    pub fn shown(&self) -> String {
        match self {
            Self::Number(value) => crate::scenario::shown(*value),
            Self::Integer(value) => value.to_string(),
            Self::Toml(text) => text.trim_matches('"').to_owned(),
        }
    }
}

impl Factor {
    /// Whether all of its values are numbers.
    pub fn is_numeric(&self) -> bool {
        match &self.levels {
            Levels::List(levels) => levels.iter().all(|level| level.number().is_some()),
            Levels::Range { .. } | Levels::Normal { .. } => true,
        }
    }

    /// The value at a share of the distribution, 0 to below 1.
    pub fn at(&self, share: f64) -> Level {
        match &self.levels {
            Levels::List(levels) => {
                let index = (share * levels.len() as f64) as usize;
                levels[index.min(levels.len() - 1)].clone()
            }
            Levels::Range { from, to, log, whole: true } => {
                // Up to one beyond the last: each whole number has the share of what lies between it and the next.
                let value = between(*from, to + 1.0, *log, share).floor();
                Level::Integer(value.clamp(*from, *to) as i64)
            }
            Levels::Range { from, to, log, whole: false } => Level::Number(between(*from, *to, *log, share)),
            Levels::Normal { mean, deviation, within: [least, most] } => {
                let below = |x: f64| cumulative((x - mean) / deviation);
                let (low, high) = (below(*least), below(*most));
                let value = mean + deviation * quantile(low + share * (high - low));
                Level::Number(value.clamp(*least, *most))
            }
        }
    }
}

/// A point of a range, `share` of the way from its lower to its upper end, both of which come out exactly.
pub(super) fn between(from: f64, to: f64, log: bool, share: f64) -> f64 {
    if share <= 0.0 || from == to {
        from
    } else if share >= 1.0 {
        to
    } else if log {
        libm::exp(libm::log(from) + share * (libm::log(to) - libm::log(from))).clamp(from, to)
    } else {
        (from + share * (to - from)).clamp(from, to)
    }
}

/// The standard normal distribution.
fn cumulative(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

/// The inverse of [`cumulative`]: Newton's steps from Abramowitz and Stegun 26.2.23, which is within 4.5e-4.
fn quantile(share: f64) -> f64 {
    // Beyond 8 deviations a draw does not get: shares are multiples of 2^-53 at best.
    let share = share.clamp(1e-15, 1.0 - 1e-15);
    let tail = share.min(1.0 - share);
    let t = (-2.0 * libm::log(tail)).sqrt();
    let start = t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let mut x = -start;
    for _ in 0..4 {
        let density = libm::exp(-0.5 * x * x) / (2.0 * std::f64::consts::PI).sqrt();
        x -= (cumulative(x) - tail) / density;
    }
    if share < 0.5 { x } else { -x }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(levels: Levels) -> Factor {
        Factor { path: "x".into(), unit: String::new(), levels }
    }

    /// Quantiles of the standard normal distribution as tables have them (Abramowitz and Stegun, table 26.5).
    #[test]
    fn the_normal_distribution_is_the_one_of_the_tables() {
        for (share, x) in
            [(0.5, 0.0), (0.841_344_746_068_543, 1.0), (0.975, 1.959_963_984_540_054), (0.001, -3.090_232_306_167_814)]
        {
            assert!((quantile(share) - x).abs() < 1e-9, "{share}: {}", quantile(share));
        }
        assert!((quantile(1e-12) + 7.034_483_8).abs() < 1e-5, "{}", quantile(1e-12));
    }

    #[test]
    fn whole_numbers_have_equal_shares_and_both_ends() {
        let dice = factor(Levels::Range { from: 1.0, to: 6.0, log: false, whole: true });
        let mut counts = [0; 6];
        for i in 0..600 {
            let Level::Integer(face) = dice.at((f64::from(i) + 0.5) / 600.0) else { panic!("no whole number") };
            counts[face as usize - 1] += 1;
        }
        assert_eq!(counts, [100; 6]);
    }

    #[test]
    fn whole_numbers_of_a_logarithmic_range_are_spread_over_the_logarithm() {
        let sizes = factor(Levels::Range { from: 16.0, to: 4000.0, log: true, whole: true });
        let below =
            (0..1000).filter(|i| sizes.at((f64::from(*i) + 0.5) / 1000.0).number().is_some_and(|size| size < 253.0)).count();
        assert!((490..=510).contains(&below), "{below} of 1000 below the geometric mean");
        assert_eq!((sizes.at(0.0), sizes.at(0.999_999_9)), (Level::Integer(16), Level::Integer(4000)));
    }

    #[test]
    fn a_normal_distribution_stays_within_its_bounds() {
        let cut = factor(Levels::Normal { mean: 0.0, deviation: 1.0, within: [-0.5, 4.0] });
        let values: Vec<f64> = (0..1000).filter_map(|i| cut.at((f64::from(i) + 0.5) / 1000.0).number()).collect();
        assert!(values.iter().all(|v| (-0.5..=4.0).contains(v)));
        // Half of what lies above -0.5 lies below 0.3993: (1 - 0.308538) / 2 + 0.308538 = 0.654269.
        assert!((values[500] - 0.3968).abs() < 0.003, "{}", values[500]);
    }

    #[test]
    fn the_middle_of_a_logarithmic_range_is_the_geometric_mean() {
        let range = factor(Levels::Range { from: 0.1, to: 10.0, log: true, whole: false });
        assert!((range.at(0.5).number().unwrap_or_default() - 1.0).abs() < 1e-12);
        assert_eq!(range.at(0.0).number(), Some(0.1));
    }

    #[test]
    fn numbers_read_back_as_they_were() {
        for value in [0.1, 1.0, -3e-9, 1e300, f64::MIN_POSITIVE] {
            assert_eq!(Level::Number(value).toml().parse::<f64>(), Ok(value));
        }
    }
}
