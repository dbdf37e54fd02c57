//! A point of the unit box as settings of a scenario.

use crate::scenario::study_file::StudyFile;
use crate::scenario::sweep_file::{Factor, Level, Levels};

/// Digits to which a number is proposed: what a person would type, and what is written stands for exactly what was run.
const DIGITS: usize = 6;

/// The value of every parameter at a point, rounded.
pub fn values(parameters: &[Factor], point: &[f64]) -> Vec<Level> {
    parameters.iter().zip(point).map(|(parameter, share)| rounded(parameter, parameter.at(share.clamp(0.0, 1.0)))).collect()
}

/// A parameter's value of which there may be more digits than are proposed; never beyond its ends.
pub fn rounded(parameter: &Factor, level: Level) -> Level {
    let Level::Number(value) = level else { return level };
    let short = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    Level::Number(match parameter.levels {
        Levels::Range { from, to, .. } => f64::clamp(short, from, to),
        _ => short,
    })
}

/// What the scenarios have where nothing is laid over them; `None` where they differ.
pub fn default(study: &StudyFile, parameter: &Factor) -> Option<f64> {
    let mut found = None;
    for base in 0..study.train.bases.len() {
        let text = study.train.scenario(base, &[], study.train.seed).ok()?.to_toml();
        let table: toml::Table = text.parse().ok()?;
        let mut value = &toml::Value::Table(table);
        for key in parameter.path.split('.') {
            value = value.get(key)?;
        }
        let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))?;
        match found {
            None => found = Some(number),
            Some(other) if other == number => {}
            Some(_) => return None,
        }
    }
    found
}

/// As settings, `path=value`.
pub fn settings(parameters: &[Factor], values: &[Level]) -> Vec<String> {
    parameters.iter().zip(values).map(|(parameter, value)| format!("{}={}", parameter.path, value.toml())).collect()
}

/// As a partial scenario, which `run --with` takes.
pub fn overlay(parameters: &[Factor], values: &[Level], comment: &str) -> String {
    let lines = comment.lines().map(|line| format!("# {line}"));
    let fields = parameters.iter().zip(values).map(|(parameter, value)| format!("{} = {}", parameter.path, value.toml()));
    lines.chain(fields).map(|line| line + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::sweep_file::Levels;

    fn parameter(from: f64, to: f64, log: bool, whole: bool) -> Factor {
        Factor { path: "a.b_m".into(), unit: "m".into(), levels: Levels::Range { from, to, log, whole } }
    }

    #[test]
    fn ends_belong_to_a_range_and_numbers_are_short() {
        let parameters = [parameter(0.3, 3.0, true, false), parameter(1.0, 4.0, false, true)];
        for (point, told) in [([0.0, 0.0], ["0.3", "1"]), ([1.0, 1.0], ["3.0", "4"]), ([0.5, 0.5], ["0.948683", "3"])] {
            let texts: Vec<String> = values(&parameters, &point).iter().map(Level::toml).collect();
            assert_eq!(texts, told, "{point:?}");
        }
        let values = values(&parameters[..1], &[0.5]);
        assert_eq!(settings(&parameters[..1], &values), ["a.b_m=0.948683"]);
        assert_eq!(overlay(&parameters[..1], &values, "found\nhere"), "# found\n# here\na.b_m = 0.948683\n");
    }
}
