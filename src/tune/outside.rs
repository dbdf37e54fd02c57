//! An optimiser of its own: any program that speaks this protocol of JSON lines, one object a line, over its standard input and output.
//!
//! | to the optimiser | from it |
//! |---|---|
//! | `{"message": "begin", "format": 1, "study": …, "seed": …, "runs": …, "parameters": [{"path", "unit", "from", "to", "scale", "whole", "default"}], "objectives": [names]}` | `{"ready": "its name"}` |
//! | `{"message": "ask", "count": 8}`: as many as it likes, about `count` | `{"candidates": [{path: value, …}, …]}`; none: it has finished |
//! | `{"message": "tell", "trials": [{"trial", "values", "costs", "violation", "is_full", "is_replayed"}, …]}` | |
//! | `{"message": "end"}`, and its input ends | |
//!
//! The first `tell` is the default: trial 0, with `values` where all scenarios agree on them. After that each `tell` has the candidates of the
//! last answer, in its order; the last one may have fewer, where the budget ended. `costs` is a number an objective, to be made small, null
//! where nothing was measured; `violation` is 0 where all constraints are kept. A candidate that is not `is_full` had a share of its runs
//! (halving), and its costs are not to be put beside those of all. `is_replayed`: it was proposed in an earlier call, which ended early, and
//! is not asked for again; what it came to is told as if it had been.

use serde_json::{Map, Value, json};

use super::ask_tell::{AskTell, Lost};
use super::candidate;
use super::cma_es::default_lambda;
use super::journal::{Generation, Journal};
use super::search::Trial;
use crate::scenario::study_file::StudyFile;
use crate::scenario::sweep_file::{Factor, Level, Levels};

/// Version of the protocol.
const FORMAT: u32 = 1;
/// Most candidates of one answer.
const MOST_CANDIDATES: usize = 100_000;
/// How much of a line is quoted.
const QUOTED: usize = 200;

/// A way to it and back, line by line.
pub trait Lines {
    /// Sends a line.
    ///
    /// # Errors
    /// Where nobody reads.
    fn send(&mut self, line: &str) -> Result<(), Lost>;

    /// The next line of its own.
    ///
    /// # Errors
    /// Where there will be none.
    fn receive(&mut self) -> Result<String, Lost>;

    /// A line that is there already, without waiting.
    fn unasked(&mut self) -> Option<String>;
}

/// An optimiser at the other end.
#[derive(Debug)]
pub struct Outside<L> {
    lines: L,
    name: String,
    parameters: Vec<Factor>,
    objectives: usize,
    journal: Journal,
    /// Whether the candidates that it is told of next were proposed in an earlier call.
    is_replayed: bool,
}

impl<L: Lines> Outside<L> {
    /// Greets it.
    ///
    /// # Errors
    /// Where it does not answer as it should.
    pub fn greet(study: &StudyFile, mut lines: L, journal: Journal) -> Result<Self, Lost> {
        let parameters: Vec<Value> = study.parameters.iter().map(|parameter| described(study, parameter)).collect();
        let objectives: Vec<&str> = study.objectives.iter().map(|objective| objective.name.as_str()).collect();
        let begin = json!({
            "message": "begin", "format": FORMAT, "study": study.name, "seed": study.seed, "runs": study.runs, "parameters": parameters,
            "objectives": objectives,
        });
        lines.send(&begin.to_string())?;
        let (line, answer) = answer(&mut lines)?;
        let Some(name) = answer.get("ready").and_then(Value::as_str) else {
            return Err(senseless(&line, "it has no `ready`", "`{\"ready\": \"its name\"}`"));
        };
        let name = name.to_owned();
        let (parameters, objectives) = (study.parameters.clone(), study.objectives.len());
        Ok(Self { lines, name, parameters, objectives, journal, is_replayed: false })
    }

    /// Says that it may go.
    pub fn farewell(mut self) -> L {
        // It may have gone already.
        let _ = self.lines.send(&json!({"message": "end"}).to_string());
        self.lines
    }

    fn told(&self, trial: &Trial, values: Value) -> Value {
        let cost = |cost: &f64| Some(*cost).filter(|cost| cost.is_finite());
        json!({
            "trial": trial.number, "values": values, "costs": trial.costs.objectives.iter().map(cost).collect::<Vec<_>>(),
            "violation": trial.costs.violation, "is_full": trial.is_full, "is_replayed": self.is_replayed,
        })
    }
}

impl<L: Lines> AskTell for Outside<L> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn begin(&mut self, default: &Trial, values: &[Option<f64>]) -> Result<(), Lost> {
        let own: Option<Map<String, Value>> = self
            .parameters
            .iter()
            .zip(values)
            .map(|(parameter, value)| Some((parameter.path.clone(), json!((*value)?))))
            .collect();
        let told = self.told(default, json!(own));
        self.lines.send(&json!({"message": "tell", "trials": [told]}).to_string())
    }

    fn ask(&mut self) -> Result<Vec<Vec<Level>>, Lost> {
        let earlier = self.journal.earlier();
        self.is_replayed = earlier.is_some();
        if let Some(generation) = earlier {
            let levels = |one| levels(&self.parameters, one).map_err(|lost| self.journal.wrong(&lost.message));
            return generation.iter().map(levels).collect();
        }
        // What an evolution strategy would have in a generation.
        let count = default_lambda(self.parameters.len()) * self.objectives;
        if let Some(line) = self.lines.unasked() {
            return Err(senseless(&line, "it was not asked", "one answer to an `ask`"));
        }
        self.lines.send(&json!({"message": "ask", "count": count}).to_string())?;
        let (line, answer) = answer(&mut self.lines)?;
        let wrong = |why: &str| senseless(&line, why, "`{\"candidates\": [{\"path\": value, …}, …]}`");
        let list = answer.get("candidates").and_then(Value::as_array).ok_or_else(|| wrong("it has no list `candidates`"))?;
        if list.len() > MOST_CANDIDATES {
            return Err(wrong(&format!("{} candidates are more than {MOST_CANDIDATES}", list.len())));
        }
        let generation: Generation = list
            .iter()
            .map(|one| one.as_object().cloned().ok_or_else(|| wrong("a candidate is no object of paths and values")))
            .collect::<Result<_, _>>()?;
        let candidates = generation
            .iter()
            .map(|one| levels(&self.parameters, one).map_err(|lost| wrong(&lost.message)))
            .collect::<Result<_, _>>()?;
        if !generation.is_empty() {
            self.journal.keep(&generation)?;
        }
        Ok(candidates)
    }

    fn tell(&mut self, trials: &[Trial]) -> Result<(), Lost> {
        let values = |trial: &Trial| -> Map<String, Value> {
            let levels = trial.values.iter().flatten();
            self.parameters.iter().zip(levels).map(|(parameter, level)| (parameter.path.clone(), json!(level.number()))).collect()
        };
        let told: Vec<Value> = trials.iter().map(|trial| self.told(trial, json!(values(trial)))).collect();
        self.lines.send(&json!({"message": "tell", "trials": told}).to_string())
    }

    /// It says so itself, with an answer of no candidates.
    fn is_at_rest(&self) -> bool {
        false
    }
}

/// A parameter as it is told of.
fn described(study: &StudyFile, parameter: &Factor) -> Value {
    let Levels::Range { from, to, log, whole } = parameter.levels else { return Value::Null };
    json!({
        "path": parameter.path, "unit": parameter.unit, "from": from, "to": to, "scale": if log { "log" } else { "linear" },
        "whole": whole, "default": candidate::default(study, parameter),
    })
}

/// The value of every parameter, each between its ends.
fn levels(parameters: &[Factor], one: &Map<String, Value>) -> Result<Vec<Level>, Lost> {
    let wrong = |message: String| Lost { message, help: String::new() };
    if let Some(other) = one.keys().find(|key| !parameters.iter().any(|parameter| parameter.path == **key)) {
        return Err(wrong(format!("`{other}` is no parameter of the study")));
    }
    let level = |parameter: &Factor| {
        let path = &parameter.path;
        let Levels::Range { from, to, whole, .. } = parameter.levels else { return Err(wrong(format!("`{path}` has no ends"))) };
        let value = one.get(path).ok_or_else(|| wrong(format!("a candidate has no `{path}`")))?;
        let value = value.as_f64().ok_or_else(|| wrong(format!("`{path}` is no number")))?;
        if !(from..=to).contains(&value) {
            return Err(wrong(format!("`{path}` is {value}, which is not between {from} and {to}")));
        }
        match whole {
            true if value.fract() != 0.0 => Err(wrong(format!("`{path}` is {value}, and must be whole"))),
            true => Ok(Level::Integer(value as i64)),
            false => Ok(candidate::rounded(parameter, Level::Number(value))),
        }
    };
    parameters.iter().map(level).collect()
}

/// Its next line, and what it says.
fn answer(lines: &mut impl Lines) -> Result<(String, Value), Lost> {
    let line = lines.receive()?;
    match serde_json::from_str::<Value>(&line) {
        Ok(value) if value.is_object() => Ok((line, value)),
        Ok(_) => Err(senseless(&line, "it is no object", "one JSON object a line")),
        Err(error) => Err(senseless(&line, &format!("it is no JSON: {error}"), "one JSON object a line")),
    }
}

fn senseless(line: &str, why: &str, expected: &str) -> Lost {
    let short: String = line.chars().take(QUOTED).collect();
    let more = if short.len() < line.len() { "…" } else { "" };
    Lost {
        message: format!("the optimiser answered `{short}{more}`: {why}"),
        help: format!(
            "{expected} was expected; docs/tuning.md tells the protocol; what was run is kept: the same call goes on from there"
        ),
    }
}

#[cfg(test)]
mod tests;
