//! The keys of a study file, each value against what it must be.

use super::{Constraints, MOST_RUNS, Objective, Optimiser, Over, Stop, StudyFile};
use crate::metrics::Metrics;
use crate::scenario::check::{NAME_RULE, is_name};
use crate::scenario::diagnostic::Finding;
use crate::scenario::source::Span;
use crate::scenario::sweep_file::reader::{Read, Reader};
use crate::scenario::sweep_file::{Design, Factor, Levels, MOST_REPLICATES, SweepFile, SweepPass};
use crate::scenario::tree::{Entry, Table};
use crate::scenario::unknown_key::nearest;

/// The word of `kind` for these files.
const KIND: &str = "study";
const KEYS: [&str; 15] = [
    "format",
    "kind",
    "name",
    "about",
    "seed",
    "optimiser",
    "runs",
    "halving",
    "wall_limit_s",
    "parameter",
    "train",
    "held_out",
    "objective",
    "constraints",
    "stop",
];
/// Keys of an objective.
const OBJECTIVE_KEYS: [&str; 3] = ["over", "weights", "relative"];
const OBJECTIVE_HELP: &str = "as in `[objective]` with `weights = { lateral_rms_m = 1.0 }` below it";
/// Largest weight or bound.
const MOST_NUMBER: f64 = 1e100;
/// Most objectives: with more nearly every candidate is on the front.
pub(super) const MOST_OBJECTIVES: usize = 4;
/// And what is laid over every base.
const SCENARIO: &str = "scenario";
const PARAMETER_HELP: &str = "as in `control.koh-cho.landing = { from = 0.005, to = 0.1, scale = \"log\" }` below `[parameter]`";

/// What is read, and what was wrong so far.
pub(super) struct StudyReader<'a> {
    all: Reader<'a>,
}

impl<'a> StudyReader<'a> {
    pub(super) fn new(root: &'a Table) -> Self {
        Self { all: Reader::new(root) }
    }

    /// What was wrong.
    pub(super) fn findings(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.all.findings)
    }

    /// The study, with its training and its held-out scenarios still to be read; `None` where the file is none.
    pub(super) fn study(&mut self) -> Option<(StudyFile, [Read; 2])> {
        let help =
            "a study has `format = 1` and `kind = \"study\"`; a sweep is for `ductloop sweep`, a scenario for `ductloop run`";
        if !self.all.is_of_kind(KIND, help) {
            return None;
        }
        for entry in &self.all.root.entries {
            if !KEYS.contains(&entry.key.as_str()) && entry.key != SCENARIO {
                self.all.unknown(entry, "at the top of the file", &KEYS);
            }
        }
        let parameters = self.parameters();
        // A parameter may stand there too: it is what the default has.
        let settings = self.all.settings(&[]);
        let name = self.all.name();
        let wall_limit_s = self.all.number(self.all.root, "wall_limit_s", [1e-3, 1e9]);
        let seed = self.all.integer("seed", [0, i64::MAX], 1).unsigned_abs();
        let blank = SweepFile {
            name: name.clone(),
            about: String::new(),
            seed,
            bases: Vec::new(),
            settings,
            factors: Vec::new(),
            design: Design::Listed,
            replicates: 1,
            common_random_numbers: true,
            metrics: Metrics::NUMBERS.map(str::to_owned).into(),
            wall_limit_s,
            stop: None,
            pass: SweepPass::default(),
        };
        let reads = ["train", "held_out"].map(|key| self.set(key, &blank));
        let study = StudyFile {
            about: self.all.text("about"),
            optimiser: self.optimiser(),
            driver: None,
            runs: self.all.integer("runs", [1, MOST_RUNS], 200).unsigned_abs(),
            halving: self.all.flag("halving", true),
            objectives: self.objectives(),
            constraints: self.constraints(),
            stop: self.stop(),
            name,
            seed,
            parameters,
            train: blank.clone(),
            held_out: blank,
        };
        Some((study, reads))
    }

    /// Every parameter lies between two ends.
    fn parameters(&mut self) -> Vec<Factor> {
        let Some(entry) = self.all.root.entry("parameter") else {
            self.all.wrong(Span::default(), "missing `[parameter]`: nothing is to be found", PARAMETER_HELP);
            return Vec::new();
        };
        let parameters = self.all.factors("parameter", true);
        for (index, parameter) in parameters.iter().enumerate() {
            if parameters[..index].iter().any(|other| other.path == parameter.path) {
                let message = format!("parameter `{}` stands there twice", parameter.path);
                self.all.wrong(entry.key_span, message, "keep one of the two");
            }
            if !matches!(parameter.levels, Levels::Range { .. }) {
                let message = format!("parameter `{}` has no ends to be sought between", parameter.path);
                self.all.wrong(entry.key_span, message, PARAMETER_HELP);
            }
            // The find is written as an overlay, which takes an array as a whole.
            if parameter.path.contains('[') {
                let message = format!("parameter `{}` is an element of an array, which no overlay can set", parameter.path);
                self.all.wrong(entry.key_span, message, "choose a field that stands for itself");
            }
        }
        parameters
    }

    /// Scenarios and seeds.
    fn set(&mut self, key: &str, blank: &SweepFile) -> Read {
        const INNER: [&str; 3] = ["base", "replicates", "seed"];
        let Some(entry) = self.all.root.entry(key) else {
            let what =
                if key == "train" { "the optimiser runs its candidates on" } else { "the find is held against the default on" };
            let message = format!("missing `[{key}]`: what {what}");
            self.all.wrong(Span::default(), message, format!("as in `[{key}]` with `base = \"../straight.toml\"` below it"));
            return Read { sweep: blank.clone(), bases: Vec::new() };
        };
        let Some(table) = self.all.table(entry) else { return Read { sweep: blank.clone(), bases: Vec::new() } };
        let mut reader = Reader::new(table);
        for inner in table.entries.iter().filter(|inner| !INNER.contains(&inner.key.as_str())) {
            reader.unknown(inner, &format!("in [{key}]"), &INNER);
        }
        let bases = reader.bases();
        let replicates = u32::try_from(reader.integer("replicates", [1, MOST_REPLICATES], 1)).unwrap_or(1);
        let seed = reader.integer("seed", [0, i64::MAX], i64::try_from(blank.seed).unwrap_or(1)).unsigned_abs();
        self.all.findings.extend(reader.findings);
        Read { sweep: SweepFile { replicates, seed, ..blank.clone() }, bases }
    }

    fn optimiser(&mut self) -> Optimiser {
        const ALL: [Optimiser; 3] = [Optimiser::CmaEs, Optimiser::Sobol, Optimiser::Random];
        let Some(node) = self.all.root.get("optimiser") else { return Optimiser::CmaEs };
        let word = node.as_text().unwrap_or_default();
        ALL.into_iter().find(|one| one.word() == word).unwrap_or_else(|| {
            let guess = nearest(word, ALL.iter().map(|one| one.word()))
                .map_or(String::new(), |near| format!("did you mean \"{near}\"? "));
            let help = format!("{guess}optimisers: \"cma-es\", \"sobol\", \"random\"");
            self.all.wrong(node.span, "there is no such optimiser", help);
            Optimiser::CmaEs
        })
    }

    /// One, or several below names of theirs.
    fn objectives(&mut self) -> Vec<Objective> {
        let Some(entry) = self.all.root.entry("objective") else {
            self.all.wrong(Span::default(), "missing `[objective]`: what is to be made small", OBJECTIVE_HELP);
            return Vec::new();
        };
        let Some(table) = self.all.table(entry) else { return Vec::new() };
        let is_single = table.entries.iter().any(|inner| OBJECTIVE_KEYS.contains(&inner.key.as_str()));
        if is_single || table.entries.is_empty() {
            return vec![self.objective("cost", entry, table)];
        }
        if table.entries.len() > MOST_OBJECTIVES {
            let message = format!("these are {} objectives, and more than {MOST_OBJECTIVES} make no front", table.entries.len());
            self.all.wrong(entry.key_span, message, "weigh some of them into one, or bound them in `[constraints]`");
            return Vec::new();
        }
        let mut objectives = Vec::new();
        for inner in &table.entries {
            match inner.node.as_table() {
                Some(_) if !is_name(&inner.key) => {
                    let message = format!("`{}` is no name of an objective", inner.key.escape_default());
                    self.all.wrong(inner.key_span, message, NAME_RULE);
                }
                Some(own) => objectives.push(self.objective(&inner.key, inner, own)),
                None => self.all.unknown(inner, "in [objective]", &OBJECTIVE_KEYS),
            }
        }
        objectives
    }

    fn objective(&mut self, name: &str, entry: &Entry, table: &Table) -> Objective {
        for inner in table.entries.iter().filter(|inner| !OBJECTIVE_KEYS.contains(&inner.key.as_str())) {
            self.all.unknown(inner, "in an objective", &OBJECTIVE_KEYS);
        }
        let over = match table.get("over") {
            None => Over::Mean,
            Some(node) => match (node.as_text(), node.as_number()) {
                (Some("mean"), _) => Over::Mean,
                (Some("worst"), _) => Over::Worst,
                (_, Some(share)) if (0.0..=1.0).contains(&share) => Over::Quantile(share),
                _ => {
                    self.all.wrong(node.span, "`over` is \"mean\", \"worst\" or a quantile from 0 to 1", "as in `over = 0.9`");
                    Over::Mean
                }
            },
        };
        let weights = match table.entry("weights") {
            Some(weights) => self.bounds(weights),
            None => Vec::new(),
        };
        if weights.iter().all(|(_, weight)| *weight == 0.0) {
            let place = if name == "cost" { "[objective]".to_owned() } else { format!("[objective.{name}]") };
            self.all.wrong(entry.key_span, format!("`{place}` weighs no metric"), OBJECTIVE_HELP);
        }
        let mut reader = Reader::new(table);
        let relative = reader.flag("relative", false);
        self.all.findings.extend(reader.findings);
        Objective { name: name.to_owned(), weights, relative, over }
    }

    fn constraints(&mut self) -> Constraints {
        const INNER: [&str; 5] = ["finishes", "most", "least", "of_default", "mean_of_default"];
        let Some(table) = self.all.root.entry("constraints").and_then(|entry| self.all.table(entry)) else {
            return Constraints { finishes: true, ..Constraints::default() };
        };
        for inner in table.entries.iter().filter(|inner| !INNER.contains(&inner.key.as_str())) {
            self.all.unknown(inner, "in [constraints]", &INNER);
        }
        let mut reader = Reader::new(table);
        let finishes = reader.flag("finishes", true);
        self.all.findings.extend(reader.findings);
        let [most, least, of_default, mean_of_default] = ["most", "least", "of_default", "mean_of_default"]
            .map(|key| table.entry(key).map_or_else(Vec::new, |entry| self.bounds(entry)));
        Constraints { finishes, most, least, of_default, mean_of_default }
    }

    /// Metrics by their names, each with a number.
    fn bounds(&mut self, entry: &Entry) -> Vec<(String, f64)> {
        let Some(table) = self.all.table(entry) else { return Vec::new() };
        let mut bounds = Vec::new();
        for inner in &table.entries {
            let known = Metrics::NUMBERS.contains(&inner.key.as_str());
            if !known {
                let guess = nearest(&inner.key, Metrics::NUMBERS.into_iter())
                    .map_or(String::new(), |near| format!("did you mean `{near}`? "));
                let help = format!("{guess}metrics: {}", Metrics::NUMBERS.join(", "));
                self.all.wrong(inner.key_span, format!("`{}` is no metric of a run", inner.key), help);
                continue;
            }
            match inner.node.as_number().filter(|number| number.is_finite()) {
                Some(number) if number.abs() > MOST_NUMBER => {
                    let message = format!("`{}` is beyond what can be reckoned with", inner.key);
                    self.all.wrong(inner.node.span, message, format!("at most {MOST_NUMBER:e} to either side"));
                }
                Some(number) => bounds.push((inner.key.clone(), number)),
                None => {
                    self.all.wrong(inner.node.span, format!("`{}` needs a number, in SI", inner.key), "as in `collisions = 0`")
                }
            }
        }
        bounds
    }

    fn stop(&mut self) -> Stop {
        const INNER: [&str; 2] = ["step", "generations_without_gain"];
        let Some(table) = self.all.root.entry("stop").and_then(|entry| self.all.table(entry)) else { return Stop::default() };
        for inner in table.entries.iter().filter(|inner| !INNER.contains(&inner.key.as_str())) {
            self.all.unknown(inner, "in [stop]", &INNER);
        }
        let generations = self.all.count(table, "generations_without_gain", [1, 1_000_000]);
        Stop {
            step: self.all.number(table, "step", [1e-12, 1.0]),
            generations_without_gain: generations.and_then(|count| u32::try_from(count).ok()),
        }
    }
}
