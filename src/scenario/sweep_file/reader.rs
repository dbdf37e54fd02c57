//! The keys of a sweep file, each value against what it must be.

use super::factor_reader::FACTOR_HELP;
use super::{
    Design, Factor, Finding, Levels, MOST_REPLICATES, MOST_SAMPLES, MOST_SOBOL, Span, StopRule, SweepFile, SweepPass, settings,
};
use crate::metrics::Metrics;
use crate::scenario::check::{NAME_RULE, is_name};
use crate::scenario::fields;
use crate::scenario::tree::{Entry, Table, Value};
use crate::scenario::unknown_key::nearest;
use crate::scenario::value;

/// The word of [`fields::KIND`] for these files.
const KIND: &str = "sweep";
/// Keys at the top.
const KEYS: [&str; 16] = [
    "format",
    "kind",
    "name",
    "about",
    "seed",
    "base",
    "design",
    "samples",
    "replicates",
    "common_random_numbers",
    "metrics",
    "wall_limit_s",
    "factor",
    "scenario",
    "stop",
    "pass",
];
/// Fields of a scenario that say what the file is, and cannot be varied.
pub(in crate::scenario) const OF_THE_FILE: [&str; 5] = ["format", "kind", "name", "about", "seed"];

/// A sweep whose bases are still to be read.
pub(in crate::scenario) struct Read {
    pub(in crate::scenario) sweep: SweepFile,
    /// Files of the bases as typed.
    pub(in crate::scenario) bases: Vec<(String, Span)>,
}

/// What is read, and what was wrong so far.
pub(in crate::scenario) struct Reader<'a> {
    pub(in crate::scenario) root: &'a Table,
    pub(in crate::scenario) findings: Vec<Finding>,
}

impl<'a> Reader<'a> {
    pub(in crate::scenario) fn new(root: &'a Table) -> Self {
        Self { root, findings: Vec::new() }
    }

    pub(in crate::scenario) fn wrong(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.findings.push(Finding::new(span, message).help(help));
    }

    /// The sweep; `None` where the file is none.
    pub(super) fn sweep(&mut self) -> Option<Read> {
        if !self.is_sweep() {
            return None;
        }
        for entry in &self.root.entries {
            if !KEYS.contains(&entry.key.as_str()) {
                self.unknown(entry, "at the top of the file", &KEYS);
            }
        }
        let bases = self.bases();
        let design = self.design();
        let sampled = !matches!(design, Design::Grid | Design::OneAtATime | Design::Listed);
        let factors = self.factors("factor", sampled);
        if design == Design::Listed {
            self.in_step(&factors);
        }
        if self.root.get("factor").is_none() && sampled {
            self.wrong(Span::default(), "a design that draws needs a `[factor]` to draw", FACTOR_HELP);
        }
        let sweep = SweepFile {
            name: self.name(),
            about: self.text("about"),
            seed: self.integer("seed", [0, i64::MAX], 1).unsigned_abs(),
            bases: Vec::new(),
            settings: self.settings(&factors),
            design,
            replicates: u32::try_from(self.integer("replicates", [1, MOST_REPLICATES], 1)).unwrap_or(1),
            common_random_numbers: self.flag("common_random_numbers", true),
            metrics: self.metrics(),
            wall_limit_s: self.number(self.root, "wall_limit_s", [1e-3, 1e9]),
            stop: self.stop(),
            pass: self.pass(),
            factors,
        };
        Some(Read { sweep, bases })
    }

    /// In step, every factor has as many values as the others.
    fn in_step(&mut self, factors: &[Factor]) {
        let count = |factor: &Factor| match &factor.levels {
            Levels::List(levels) => levels.len(),
            Levels::Range { .. } | Levels::Normal { .. } => 0,
        };
        if let Some([first, other]) =
            factors.first().and_then(|first| Some([first, factors.iter().find(|f| count(f) != count(first))?]))
        {
            let message = format!(
                "`{}` has {} values and `{}` {}: in step, all have as many",
                first.path,
                count(first),
                other.path,
                count(other)
            );
            let span = self.root.entry("factor").map_or_else(Span::default, |entry| entry.key_span);
            self.wrong(span, message, "list a value of each for every point, or choose `design = \"grid\"`");
        }
    }

    fn is_sweep(&mut self) -> bool {
        self.is_of_kind(KIND, "a sweep has `format = 1` and `kind = \"sweep\"`; a scenario is for `ductloop run`")
    }

    /// Whether the file says that it is of this kind, in a format that is read here.
    pub(in crate::scenario) fn is_of_kind(&mut self, kind: &str, help: &str) -> bool {
        match self.root.get(fields::KIND) {
            Some(node) if node.as_text() == Some(kind) => {}
            Some(node) => {
                self.wrong(node.span, format!("this file is no {kind}"), help);
                return false;
            }
            None => {
                self.wrong(Span::default(), "the file does not say its `kind`", help);
                return false;
            }
        }
        match self.root.get(fields::FORMAT) {
            Some(node) if node.as_integer() == Some(1) => true,
            Some(node) => {
                self.wrong(node.span, "this program reads format 1", help);
                false
            }
            None => {
                self.wrong(Span::default(), "the file does not say its `format`", help);
                false
            }
        }
    }

    pub(in crate::scenario) fn unknown(&mut self, entry: &Entry, place: &str, known: &[&'static str]) {
        let help = match nearest(&entry.key, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if fields::root().child(&entry.key).is_some() => {
                format!("fields of a scenario stand in `[scenario]`, as in `[scenario.{}]`", entry.key)
            }
            None => format!("known here: {}", known.join(", ")),
        };
        self.wrong(entry.key_span, format!("unknown key `{}` {place}", entry.key), help);
    }

    pub(in crate::scenario) fn name(&mut self) -> String {
        match self.root.get("name") {
            Some(node) => match node.as_text().filter(|text| is_name(text)) {
                Some(text) => return text.to_owned(),
                None => self.wrong(node.span, "`name` is not a name", NAME_RULE),
            },
            None => self.wrong(Span::default(), "missing `name`", "as in `name = \"duct-width\"`: it names the folder, too"),
        }
        String::new()
    }

    pub(in crate::scenario) fn text(&mut self, key: &str) -> String {
        match self.root.get(key).map(|node| (node.as_text(), node.span)) {
            Some((Some(text), _)) => text.to_owned(),
            Some((None, span)) => {
                self.wrong(span, format!("`{key}` is a text"), "put it between double quotes");
                String::new()
            }
            None => String::new(),
        }
    }

    pub(in crate::scenario) fn integer(&mut self, key: &str, [least, most]: [i64; 2], default: i64) -> i64 {
        let Some(node) = self.root.get(key) else { return default };
        match node.as_integer().filter(|value| (least..=most).contains(value)) {
            Some(value) => value,
            None => {
                self.wrong(
                    node.span,
                    format!("`{key}` is a whole number from {least} to {most}"),
                    format!("as in `{key} = {default}`"),
                );
                default
            }
        }
    }

    pub(in crate::scenario) fn flag(&mut self, key: &str, default: bool) -> bool {
        match self.root.get(key).map(|node| (&node.value, node.span)) {
            Some((Value::Flag(flag), _)) => *flag,
            Some((_, span)) => {
                self.wrong(span, format!("`{key}` is true or false"), format!("as in `{key} = {default}`"));
                default
            }
            None => default,
        }
    }

    /// A number within bounds, if there is one.
    pub(in crate::scenario) fn number(&mut self, table: &Table, key: &str, [least, most]: [f64; 2]) -> Option<f64> {
        let node = table.get(key)?;
        let number = node.as_number().filter(|value| (least..=most).contains(value));
        if number.is_none() {
            let message = format!("`{key}` is a number from {} to {}", value::shown(least), value::shown(most));
            self.wrong(node.span, message, format!("as in `{key} = {}`", value::shown(least.max(0.0).max(most.min(1.0)))));
        }
        number
    }

    /// A whole number within bounds, if there is one.
    pub(in crate::scenario) fn count(&mut self, table: &Table, key: &str, [least, most]: [i64; 2]) -> Option<u64> {
        let node = table.get(key)?;
        let count = node.as_integer().filter(|count| (least..=most).contains(count));
        if count.is_none() {
            self.wrong(
                node.span,
                format!("`{key}` is a whole number from {least} to {most}"),
                format!("as in `{key} = {least}`"),
            );
        }
        count.map(i64::unsigned_abs)
    }

    pub(in crate::scenario) fn bases(&mut self) -> Vec<(String, Span)> {
        const HELP: &str = "as in `base = \"../straight.toml\"`, from this file's folder, or an array of several";
        let Some(node) = self.root.get("base") else {
            self.wrong(Span::default(), "missing `base`: the scenario that is varied", HELP);
            return Vec::new();
        };
        let nodes = match &node.value {
            Value::List(list) if !list.is_empty() => list.as_slice(),
            _ => std::slice::from_ref(node),
        };
        let mut bases = Vec::new();
        for node in nodes {
            match node.as_text().filter(|text| !text.is_empty()) {
                Some(text) if bases.iter().any(|(other, _)| other == text) => {
                    self.wrong(node.span, "this base is named twice", "keep one of the two");
                }
                Some(text) => bases.push((text.to_owned(), node.span)),
                None => self.wrong(node.span, "a base is a scenario file", HELP),
            }
        }
        bases
    }

    fn design(&mut self) -> Design {
        const WORDS: [&str; 6] = ["grid", "one-at-a-time", "listed", "sobol", "latin-hypercube", "random"];
        let (word, span) = match self.root.get("design") {
            None => ("grid", Span::default()),
            Some(node) => (node.as_text().unwrap_or_default(), node.span),
        };
        let most = if word == "sobol" { MOST_SOBOL } else { MOST_SAMPLES };
        let samples = |reader: &mut Self| {
            if reader.root.get("samples").is_none() {
                reader.wrong(span, format!("design \"{word}\" needs its number of points"), "as in `samples = 64`");
            }
            reader.integer("samples", [1, most], 1).unsigned_abs()
        };
        let design = match word {
            "grid" => Design::Grid,
            "one-at-a-time" => Design::OneAtATime,
            "listed" => Design::Listed,
            "sobol" => Design::Sobol { samples: samples(self) },
            "latin-hypercube" => Design::LatinHypercube { samples: samples(self) },
            "random" => Design::Random { samples: samples(self) },
            _ => {
                let guess = nearest(word, WORDS.into_iter()).map_or(String::new(), |near| format!("did you mean \"{near}\"? "));
                self.wrong(span, "there is no such design", format!("{guess}designs: {}", WORDS.join(", ")));
                Design::Grid
            }
        };
        if let (Design::Grid | Design::OneAtATime | Design::Listed, Some(node)) = (design, self.root.get("samples")) {
            let message = format!("design \"{}\" takes the values that its factors list, not `samples`", design.word());
            self.wrong(node.span, message, "leave it out, or choose `design = \"sobol\"`, `\"latin-hypercube\"` or `\"random\"`");
        }
        design
    }

    /// What is laid over every base.
    pub(in crate::scenario) fn settings(&mut self, factors: &[Factor]) -> Vec<String> {
        let Some(entry) = self.root.entry("scenario") else { return Vec::new() };
        let Some(table) = self.table(entry) else { return Vec::new() };
        let settings = settings::of(table);
        for factor in factors {
            if settings.iter().any(|setting| setting.split_once('=').is_some_and(|(path, _)| path == factor.path)) {
                let message =
                    format!("`[factor]` gives `{}` its values, so the one in `[scenario]` would never count", factor.path);
                self.wrong(entry.key_span, message, "keep one of the two");
            }
        }
        // Checked with each base; these have no meaning in a partial scenario.
        for key in ["format", "kind", "seed"] {
            if let Some(entry) = table.entry(key) {
                self.wrong(entry.key_span, format!("`{key}` cannot be laid over the bases"), "leave it out: the sweep says it");
            }
        }
        settings
    }

    pub(in crate::scenario) fn metrics(&mut self) -> Vec<String> {
        let all = || Metrics::NUMBERS.iter().map(|name| (*name).to_owned()).collect();
        let Some(node) = self.root.get("metrics") else { return all() };
        let Some(list) = node.as_list().filter(|list| !list.is_empty()) else {
            self.wrong(node.span, "`metrics` is an array of names, one at least", "as in `metrics = [\"lateral_rms_m\"]`");
            return Vec::new();
        };
        let mut metrics: Vec<String> = Vec::new();
        for item in list {
            let known = item.as_text().and_then(|text| Metrics::NUMBERS.iter().find(|name| **name == text));
            match known {
                Some(name) if metrics.iter().any(|other| other == name) => self.wrong(item.span, "named twice", "keep one"),
                Some(name) => metrics.push((*name).to_owned()),
                None => {
                    let text = item.as_text().unwrap_or_default();
                    let near = nearest(text, Metrics::NUMBERS.into_iter()).map(|near| format!("did you mean \"{near}\"? "));
                    let help = format!("{}metrics: {}", near.unwrap_or_default(), Metrics::NUMBERS.join(", "));
                    self.wrong(item.span, "there is no such metric", help);
                }
            }
        }
        metrics
    }

    fn stop(&mut self) -> Option<StopRule> {
        const KEYS: [&str; 2] = ["pass_rate_half_width", "least_replicates"];
        let entry = self.root.entry("stop")?;
        let table = self.table(entry)?;
        for inner in table.entries.iter().filter(|inner| !KEYS.contains(&inner.key.as_str())) {
            self.unknown(inner, "in [stop]", &KEYS);
        }
        let half_width = self.number(table, "pass_rate_half_width", [1e-3, 0.5]);
        let least = self.count(table, "least_replicates", [1, MOST_REPLICATES]);
        if table.get("pass_rate_half_width").is_none() {
            self.wrong(entry.key_span, "`[stop]` has no `pass_rate_half_width`", "as in `pass_rate_half_width = 0.1`");
        }
        Some(StopRule {
            pass_rate_half_width: half_width?,
            least_replicates: least.and_then(|least| u32::try_from(least).ok()).unwrap_or(1),
        })
    }

    fn pass(&mut self) -> SweepPass {
        const KEYS: [&str; 4] = ["pass_rate_min", "point_pass_rate_min", "errors", "timeouts"];
        let Some(table) = self.root.entry("pass").and_then(|entry| self.table(entry)) else { return SweepPass::default() };
        for inner in table.entries.iter().filter(|inner| !KEYS.contains(&inner.key.as_str())) {
            match Metrics::NUMBERS.iter().any(|name| inner.key.starts_with(name.trim_end_matches("_m").trim_end_matches("_rad")))
            {
                true => self.wrong(
                    inner.key_span,
                    format!("`{}` is a bound on a run, and this `[pass]` is the sweep's", inner.key),
                    "bounds on each run stand in `[scenario.pass]`",
                ),
                false => self.unknown(inner, "in [pass]", &KEYS),
            }
        }
        SweepPass {
            pass_rate_min: self.number(table, "pass_rate_min", [0.0, 1.0]),
            point_pass_rate_min: self.number(table, "point_pass_rate_min", [0.0, 1.0]),
            errors: self.count(table, "errors", [0, MOST_SAMPLES * MOST_REPLICATES]),
            timeouts: self.count(table, "timeouts", [0, MOST_SAMPLES * MOST_REPLICATES]),
        }
    }

    pub(in crate::scenario) fn table<'e>(&mut self, entry: &'e Entry) -> Option<&'e Table> {
        let table = entry.node.as_table();
        if table.is_none() {
            let message = format!("`{}` is a table, but {} stands here", entry.key, entry.node.value.kind());
            self.wrong(entry.node.span, message, format!("write `[{}]` on a line of its own, and its keys below", entry.key));
        }
        table
    }
}
