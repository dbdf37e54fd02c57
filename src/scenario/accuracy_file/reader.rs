//! The tables of an accuracy file that are not a scenario's, each value against what it must be.

use super::criteria::{BOUNDS, PassBound};
use super::drawn::DRAWN;
use super::{Factor, Finding, KIND, MOST_POSES, Node, Pipeline, Poses, Span, Table, Value, fields};
use crate::scenario::tree::Entry;
use crate::scenario::unknown_key;

/// What was wrong so far.
#[derive(Default)]
pub(super) struct Reader {
    pub(super) findings: Vec<Finding>,
}

/// Keys that a study has beside a scenario's; `pass` has another meaning.
const TABLES: [&str; 3] = ["pipelines", "poses", "grid"];
/// Fields that the whole study has once, so that the grid cannot give them values.
pub(super) const OF_THE_FILE: [&str; 3] = [fields::FORMAT, fields::KIND, "name"];

impl Reader {
    fn wrong(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.findings.push(Finding::new(span, message).help(help));
    }

    /// Whether the file is one of these; its kind becomes a scenario's, which the rest of it is.
    pub(super) fn kind(&mut self, root: &mut Table) -> bool {
        let help = "an accuracy study has `kind = \"accuracy\"`; a scenario is for `ductloop run`";
        match root.entry_mut(fields::KIND).map(|entry| &mut entry.node) {
            Some(Node { value: Value::Text(word), .. }) if word == KIND => {
                "scenario".clone_into(word);
                true
            }
            Some(node) => {
                self.wrong(node.span, "this file is no accuracy study", help);
                false
            }
            None => {
                self.wrong(Span::default(), "the file does not say its `kind`", help);
                false
            }
        }
    }

    /// Keys at the top that neither a study nor a scenario has; `root` is without the study's own.
    pub(super) fn unknown(&mut self, root: &Table) {
        let shape = fields::root();
        let unknown = root.entries.iter().filter(|entry| shape.child(&entry.key).is_none());
        self.findings.extend(unknown.map(|entry| unknown_key::finding_beside(shape, "", entry, &TABLES)));
    }

    /// What would never count: a field of the grid that `[poses]` draws, and what was laid over the file at a field that the study itself
    /// gives values.
    pub(super) fn overruled(&mut self, root: &Table, factors: &[Factor], poses: &Poses) {
        let drawn = poses.draws();
        for factor in factors {
            if let Some((key, path)) = drawn.iter().find(|(_, path)| *path == factor.path) {
                let message =
                    format!("`{key}` of `[poses]` draws `{path}` for each pose, so the grid's values would never count");
                self.wrong(factor.span, message, format!("take `{path}` out of `[grid]`, or `{key}` out of `[poses]`"));
            }
        }
        let gridded = factors.iter().map(|factor| {
            let path = factor.path.as_str();
            (path, "grid", format!("as in `--set 'grid.{path}=[VALUE, …]'`"))
        });
        let drawn = drawn.into_iter().map(|(key, path)| (path, "poses", format!("as in `--set 'poses.{key}=[FROM, TO]'`")));
        for (path, table, help) in gridded.chain(drawn).collect::<Vec<_>>() {
            // The file itself is the first source.
            if let Some(node) = at(root, path).filter(|node| node.span.source > 0) {
                let message = format!("`[{table}]` of the study gives `{path}` its values, so this one would never count");
                self.wrong(node.span, message, help);
            }
        }
    }

    pub(super) fn pipelines(&mut self, entry: Option<Entry>) -> Vec<Pipeline> {
        const HELP: &str = "as in `pipelines = [\"robust\", \"paper\"]`";
        let Some(entry) = entry else { return vec![Pipeline::Robust, Pipeline::Paper] };
        let mut pipelines = Vec::new();
        for item in entry.node.as_list().unwrap_or_default() {
            match item.as_text().and_then(Pipeline::of).filter(|pipeline| *pipeline != Pipeline::Truth) {
                Some(pipeline) if pipelines.contains(&pipeline) => self.wrong(item.span, "named twice", HELP),
                Some(pipeline) => pipelines.push(pipeline),
                None => self.wrong(item.span, "not a pipeline that reads images", "`robust` and `paper` are"),
            }
        }
        if entry.node.as_list().is_none_or(<[Node]>::is_empty) {
            self.wrong(entry.node.span, "`pipelines` is an array of words, one at least", HELP);
        }
        pipelines
    }

    pub(super) fn poses(&mut self, entry: Option<Entry>) -> Poses {
        let mut poses = Poses { count: 1, wall_m: None, width_m: None, lateral_m: None, heading_rad: None, distance_m: None };
        let Some(table) = entry.as_ref().and_then(|entry| self.table(entry)) else {
            if entry.is_none() {
                self.wrong(Span::default(), "`[poses]` is missing", "as in `[poses]` and below it `count = 500`");
            }
            return poses;
        };
        for entry in &table.entries {
            let node = &entry.node;
            match entry.key.as_str() {
                "count" => match node.as_integer().filter(|count| (1..=MOST_POSES).contains(count)) {
                    Some(count) => poses.count = count.unsigned_abs(),
                    None => {
                        self.wrong(node.span, format!("`count` is a whole number from 1 to {MOST_POSES}"), "as in `count = 500`")
                    }
                },
                key => {
                    let Some(drawn) = DRAWN.iter().find(|drawn| drawn.key == key) else {
                        let known: Vec<_> = DRAWN.iter().map(|drawn| drawn.key).collect();
                        let message = format!("unknown key `{key}` in `poses`");
                        self.wrong(entry.key_span, message, format!("known here: count, {}", known.join(", ")));
                        continue;
                    };
                    let range = self.range(entry, drawn.bounds);
                    match key {
                        "wall_m" => poses.wall_m = range,
                        "width_m" => poses.width_m = range,
                        "lateral_m" => poses.lateral_m = range,
                        "heading_deg" => poses.heading_rad = range.map(|range| range.map(f64::to_radians)),
                        _ => poses.distance_m = range,
                    }
                }
            }
        }
        if poses.wall_m.is_some() && (poses.width_m.is_some() || poses.lateral_m.is_some()) {
            let message = "`wall_m` draws lateral offset and width: neither can be drawn beside it";
            let span = table.get("width_m").or_else(|| table.get("lateral_m")).map_or(Span::default(), |node| node.span);
            self.wrong(span, message, "keep `wall_m`, or `width_m` and `lateral_m`");
        }
        poses
    }

    /// `[from, to]`, both within bounds.
    fn range(&mut self, entry: &Entry, [least, most]: [f64; 2]) -> Option<[f64; 2]> {
        let numbers: Option<Vec<f64>> = entry.node.as_list().and_then(|list| list.iter().map(Node::as_number).collect());
        match numbers.as_deref() {
            Some(&[from, to]) if from <= to && least <= from && to <= most => Some([from, to]),
            _ => {
                let message =
                    format!("`{}` is drawn between two numbers, the smaller one first, from {least} to {most}", entry.key);
                self.wrong(entry.node.span, message, format!("as in `{} = [{least}, {most}]`", entry.key));
                None
            }
        }
    }

    pub(super) fn pass(&mut self, entry: Option<Entry>) -> Vec<PassBound> {
        let mut list = Vec::new();
        let Some(table) = entry.as_ref().and_then(|entry| self.table(entry)) else { return list };
        for pipeline_entry in &table.entries {
            let Some(pipeline) = Pipeline::of(&pipeline_entry.key).filter(|pipeline| *pipeline != Pipeline::Truth) else {
                let message = format!("`{}` is not a pipeline that reads images", pipeline_entry.key);
                self.wrong(pipeline_entry.key_span, message, "bounds stand in `[pass.robust]` and `[pass.paper]`");
                continue;
            };
            let Some(bounds) = self.table(pipeline_entry) else { continue };
            for entry in &bounds.entries {
                let known = BOUNDS.iter().find(|bound| bound.key == entry.key);
                match (known, entry.node.as_number().filter(|value| value.is_finite())) {
                    (Some(bound), Some(value)) => list.push(PassBound { pipeline, bound, value }),
                    (Some(bound), None) => self.wrong(entry.node.span, format!("`{}` is a number", bound.key), bound.about),
                    (None, _) => {
                        let keys: Vec<_> = BOUNDS.iter().map(|bound| bound.key).collect();
                        let message = format!("unknown bound `{}`", entry.key);
                        self.wrong(entry.key_span, message, format!("known here: {}", keys.join(", ")));
                    }
                }
            }
        }
        list
    }

    pub(super) fn grid(&mut self, entry: Option<Entry>) -> Vec<Factor> {
        let mut factors = Vec::new();
        if let Some(table) = entry.as_ref().and_then(|entry| self.table(entry)) {
            self.factors("", table, &mut factors);
        }
        factors
    }

    /// Tables are steps of the path, arrays are the values at its end.
    fn factors(&mut self, path: &str, table: &Table, factors: &mut Vec<Factor>) {
        for entry in &table.entries {
            let path = if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
            match &entry.node.value {
                Value::Table(inner) => self.factors(&path, inner, factors),
                Value::List(levels) if !levels.is_empty() => match fields::field(&path) {
                    Some(_) if OF_THE_FILE.contains(&path.as_str()) => {
                        let message = format!("`{path}` is the whole study's, so the grid cannot give it values");
                        self.wrong(entry.key_span, message, format!("take `{path}` out of `[grid]`"));
                    }
                    Some(_) => factors.push(Factor { path, span: entry.key_span, levels: levels.clone() }),
                    None => {
                        let help =
                            "a path looks like `sensor.preset` or `\"duct.run[0].straight_m\"`; `ductloop schema` lists all";
                        self.wrong(entry.key_span, format!("`{path}` is no field of a scenario"), help);
                    }
                },
                _ => {
                    let message = format!("`{path}` needs the values that it takes, an array of one at least");
                    self.wrong(entry.node.span, message, "as in `sensor.preset = [\"wide\", \"incra1\"]`");
                }
            }
        }
    }

    fn table<'e>(&mut self, entry: &'e Entry) -> Option<&'e Table> {
        let table = entry.node.as_table();
        if table.is_none() {
            let message = format!("`{}` is a table, but {} stands here", entry.key, entry.node.value.kind());
            self.wrong(entry.node.span, message, format!("write `[{}]` on a line of its own, and its keys below", entry.key));
        }
        table
    }
}

/// The value at a path that may have indices, `duct.run[0].straight_m`, if one was typed just there.
fn at<'t>(root: &'t Table, path: &str) -> Option<&'t Node> {
    let mut table = Some(root);
    let mut found = None;
    for step in path.split('.') {
        let (key, index) = step.split_once('[').unwrap_or((step, ""));
        let node = &table?.entry(key)?.node;
        let node = match index.trim_end_matches(']').parse::<usize>() {
            Ok(index) => node.as_list()?.get(index)?,
            Err(_) => node,
        };
        table = node.as_table();
        found = Some(node);
    }
    found
}
