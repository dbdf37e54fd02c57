//! `[factor]`: paths of fields, and the values, ranges or distributions that they take.

use super::factor::between;
use super::reader::{OF_THE_FILE, Reader};
use super::{Factor, Level, Levels, MOST_LEVELS, settings};
use crate::scenario::fields::{self, Field, Kind};
use crate::scenario::tree::{Entry, Node, Table, Value};
use crate::scenario::unknown_key::nearest;
use crate::scenario::value;

/// Keys that a factor's table may have.
const FACTOR: [&str; 8] = ["from", "to", "levels", "scale", "mean", "deviation", "least", "most"];
/// How a factor is written.
pub(in crate::scenario) const FACTOR_HELP: &str = "as in `duct.width_m = [0.3, 0.5]`, `duct.width_m = { from = 0.3, to = 1.2, levels = 10 }` or, where \
                                      the design draws, `sensor.error.pan_deg = { mean = 0.0, deviation = 0.2 }`";

impl Reader<'_> {
    /// The factors that stand below this key.
    pub(in crate::scenario) fn factors(&mut self, key: &str, sampled: bool) -> Vec<Factor> {
        let mut factors = Vec::new();
        if let Some(entry) = self.root.entry(key)
            && let Some(table) = self.table(entry)
        {
            self.factors_of("", table, sampled, &mut factors);
            if table.entries.is_empty() {
                self.wrong(entry.key_span, format!("`[{key}]` is empty: nothing is varied"), FACTOR_HELP);
            }
        }
        factors
    }

    /// Tables are steps of a path until it is a field's; what stands there says its values.
    fn factors_of(&mut self, path: &str, table: &Table, sampled: bool, factors: &mut Vec<Factor>) {
        for entry in &table.entries {
            let path = if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
            match (fields::field(&path), &entry.node.value) {
                (Some(field), _) if OF_THE_FILE.contains(&field.path) => {
                    let message = format!("`{path}` cannot be varied");
                    let help = match field.path {
                        "seed" => "`replicates` repeats every point with seeds of its own".to_owned(),
                        _ => format!("it says what the file is, not what is simulated; {FACTOR_HELP}"),
                    };
                    self.wrong(entry.key_span, message, help);
                }
                (Some(field), _) => {
                    if let Some(levels) = self.levels(field, &path, entry, sampled) {
                        factors.push(Factor { path, unit: field.unit.to_owned(), levels });
                    }
                }
                (None, Value::Table(inner)) if inner.entries.iter().all(|entry| !FACTOR.contains(&entry.key.as_str())) => {
                    self.factors_of(&path, inner, sampled, factors)
                }
                (None, _) => {
                    let near = nearest(&path, fields::fields().map(|field| field.path));
                    let guess = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
                    let help = format!(
                        "{guess}`ductloop schema` lists all fields; an index stands within quotes, as in \
                                        `\"duct.run[0].straight_m\"`"
                    );
                    self.wrong(entry.key_span, format!("`{path}` names no field of a scenario"), help);
                }
            }
        }
    }

    fn levels(&mut self, field: &Field, path: &str, entry: &Entry, sampled: bool) -> Option<Levels> {
        let before = self.findings.len();
        let levels = match &entry.node.value {
            Value::List(list) if !list.is_empty() => {
                let levels: Vec<Level> = list.iter().map(|node| self.level(field, path, node)).collect();
                // In step the same value may belong to several points.
                let in_step = self.root.get("design").and_then(Node::as_text) == Some("listed");
                if self.findings.len() == before && !in_step {
                    self.told_apart(path, list, &levels);
                }
                Levels::List(levels)
            }
            Value::Table(table) => self.spread(field, path, entry, table, sampled)?,
            _ => {
                self.wrong(entry.node.span, format!("`{path}` needs the values that it takes, one at least"), FACTOR_HELP);
                return None;
            }
        };
        (self.findings.len() == before).then_some(levels)
    }

    /// Says which value stands twice in a list.
    fn told_apart(&mut self, path: &str, list: &[Node], levels: &[Level]) {
        for (index, node) in list.iter().enumerate() {
            if levels[..index].contains(&levels[index]) {
                self.wrong(node.span, format!("`{path}` has this value twice"), "keep one; `replicates` repeats a point");
            }
        }
    }

    /// One value, as the field takes it.
    fn level(&mut self, field: &Field, path: &str, node: &Node) -> Level {
        self.findings.extend(value::wrong(field, path, node));
        match (field.kind, &node.value) {
            (Kind::Integer { .. } | Kind::Choice(_), Value::Integer(value)) => Level::Integer(*value),
            (_, Value::Number(_) | Value::Integer(_)) => Level::Number(node.as_number().unwrap_or_default()),
            _ => Level::Toml(settings::toml(node)),
        }
    }

    /// A range or a distribution.
    fn spread(&mut self, field: &Field, path: &str, entry: &Entry, table: &Table, sampled: bool) -> Option<Levels> {
        for inner in &table.entries {
            if !FACTOR.contains(&inner.key.as_str()) {
                self.unknown(inner, &format!("in factor `{path}`"), &FACTOR);
            }
        }
        let (bounds, whole) = match field.kind {
            Kind::Number { min, max } | Kind::NumberOr { min, max, .. } | Kind::Numbers { min, max, single: true, .. } => {
                ([min, max], false)
            }
            Kind::Integer { min, max } => ([min as f64, max as f64], true),
            _ => {
                self.wrong(entry.node.span, format!("`{path}` has no numbers between: list its values"), FACTOR_HELP);
                return None;
            }
        };
        if table.get("mean").is_some() || table.get("deviation").is_some() {
            return self.normal(path, entry, table, bounds, whole, sampled);
        }
        let end = |reader: &mut Self, key: &str| match table.get(key) {
            Some(node) => {
                reader.findings.extend(value::wrong(field, path, node));
                node.as_number()
            }
            None => {
                reader.wrong(entry.node.span, format!("factor `{path}` has no `{key}`"), FACTOR_HELP);
                None
            }
        };
        let (from, to) = (end(self, "from"), end(self, "to"));
        let (from, to) = (from?, to?);
        for key in ["least", "most"] {
            if let Some(inner) = table.entry(key) {
                self.wrong(inner.key_span, format!("`{key}` cuts off a distribution, and `{path}` is a range"), FACTOR_HELP);
            }
        }
        if from >= to {
            self.wrong(entry.node.span, format!("`{path}` goes from {from} to {to}: the smaller one comes first"), FACTOR_HELP);
            return None;
        }
        let log = self.is_log(path, table, from)?;
        let Some(node) = table.get("levels") else {
            if !sampled {
                let message = format!("factor `{path}` is a range without `levels`, and the design draws none");
                self.wrong(entry.node.span, message, FACTOR_HELP);
            }
            return Some(Levels::Range { from, to, log, whole });
        };
        let Some(count) = node.as_integer().and_then(|n| usize::try_from(n).ok()).filter(|n| (2..=MOST_LEVELS).contains(n))
        else {
            self.wrong(node.span, format!("`levels` is a whole number from 2 to {MOST_LEVELS}"), FACTOR_HELP);
            return None;
        };
        let value = |i: usize| between(from, to, log, i as f64 / (count - 1) as f64);
        let mut levels: Vec<Level> = if whole {
            (0..count).map(|i| Level::Integer(value(i).round() as i64)).collect()
        } else {
            // What a person would have typed: 0.7 for 0.7000000000000001.
            (0..count).map(|i| Level::Number(format!("{:.11e}", value(i)).parse().unwrap_or_default())).collect()
        };
        levels.dedup();
        Some(Levels::List(levels))
    }

    fn normal(
        &mut self,
        path: &str,
        entry: &Entry,
        table: &Table,
        bounds: [f64; 2],
        whole: bool,
        sampled: bool,
    ) -> Option<Levels> {
        if !sampled {
            let message = format!("factor `{path}` is a distribution, and a design that lists its points draws none");
            self.wrong(
                entry.node.span,
                message,
                "choose `design = \"sobol\"`, `\"latin-hypercube\"` or `\"random\"`, or list values",
            );
        }
        if whole {
            self.wrong(entry.node.span, format!("`{path}` takes whole numbers: a normal distribution has none"), FACTOR_HELP);
        }
        for key in ["from", "to", "levels", "scale"] {
            if let Some(inner) = table.entry(key) {
                let message = format!("`{key}` is of a range, and `{path}` is a normal distribution");
                self.wrong(inner.key_span, message, "`mean`, `deviation` and, to cut it off, `least` and `most`");
            }
        }
        let mean = self.number(table, "mean", bounds);
        let deviation = self.number(table, "deviation", [f64::MIN_POSITIVE, 1e12]);
        let within = [self.number(table, "least", bounds), self.number(table, "most", bounds)];
        for (key, value) in [("mean", mean), ("deviation", deviation)] {
            if value.is_none() && table.get(key).is_none() {
                self.wrong(entry.node.span, format!("factor `{path}` has no `{key}`"), FACTOR_HELP);
            }
        }
        let (mean, deviation) = (mean?, deviation?);
        let [least, most] = [within[0].unwrap_or(bounds[0]), within[1].unwrap_or(bounds[1])];
        if least >= most {
            self.wrong(entry.node.span, format!("`{path}`: `least` is not below `most`"), FACTOR_HELP);
        } else if !(least..=most).contains(&mean) {
            self.wrong(entry.node.span, format!("the mean of `{path}` lies beyond `least` and `most`"), FACTOR_HELP);
        }
        Some(Levels::Normal { mean, deviation, within: [least, most] })
    }

    /// Whether a range has even steps in the logarithm.
    fn is_log(&mut self, path: &str, table: &Table, from: f64) -> Option<bool> {
        let Some(node) = table.get("scale") else { return Some(false) };
        match node.as_text() {
            Some("linear") => Some(false),
            Some("log") if from > 0.0 => Some(true),
            Some("log") => {
                self.wrong(node.span, format!("`{path}` begins at {from}, which has no logarithm"), "begin above zero");
                None
            }
            _ => {
                self.wrong(node.span, "`scale` is \"linear\" or \"log\"", FACTOR_HELP);
                None
            }
        }
    }
}
