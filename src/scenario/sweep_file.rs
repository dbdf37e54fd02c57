//! A file of kind `sweep`: one base scenario or several, factors, a design, and how often each point is repeated.
//!
//! ```toml
//! format = 1
//! kind = "sweep"
//! name = "duct-width"
//! base = "../straight.toml"              # from this file's folder; or an array of several
//! design = "grid"                        # or "one-at-a-time", "listed"; "sobol", "latin-hypercube", "random" with `samples`
//! replicates = 5                         # runs of each point, each with a seed of its own
//!
//! [factor]                               # any field of a scenario by its path
//! duct.width_m = { from = 0.3, to = 1.2, levels = 10 }
//! sensor.preset = ["wide", "incra1"]
//!
//! [scenario.pass]                        # laid over every base, as `--with` does
//! lateral_rms_mm = 5.0
//!
//! [pass]                                 # of the sweep itself
//! pass_rate_min = 0.9
//! ```
//!
//! A case is a base, a list of settings `path=value` and a seed: just what `ductloop run BASE --set path=value … --seed N` takes.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::diagnostic::{Diagnostics, Finding};
use super::overlay::Overlays;
use super::source::Span;
use super::typed::Typed;
use super::{Scenario, resolve};

pub mod factor;
mod factor_reader;
pub(in crate::scenario) mod reader;
mod schema;
mod settings;

pub use factor::{Factor, Level, Levels};
use reader::{Read, Reader};
pub use schema::schema;

/// Most values of one factor.
pub const MOST_LEVELS: usize = 100_000;
/// Most design points of a sampled design.
pub const MOST_SAMPLES: i64 = 1_000_000;
/// Most points of a Sobol sequence: what its generator has.
pub const MOST_SOBOL: i64 = 65_536;
/// Most replicates of a point.
pub const MOST_REPLICATES: i64 = 100_000;

/// A sweep as resolved: all that its cases follow from, texts of the bases included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepFile {
    /// Its name, and its folder's.
    pub name: String,
    /// What it is for; may be empty.
    pub about: String,
    /// Seed of the design and, with common random numbers, the first replicate's.
    pub seed: u64,
    /// The base scenarios, one at least.
    pub bases: Vec<Base>,
    /// Settings laid over every base, `path=value` with the value as TOML: `[scenario]`.
    pub settings: Vec<String>,
    /// What is varied.
    pub factors: Vec<Factor>,
    /// Which combinations of them are run.
    pub design: Design,
    /// Runs of each point.
    pub replicates: u32,
    /// Whether the runs of every point have the same seeds: `seed`, `seed + 1`, and so on.
    pub common_random_numbers: bool,
    /// Metrics of a run that are kept.
    pub metrics: Vec<String>,
    /// Wall-clock limit of a case, in seconds.
    pub wall_limit_s: Option<f64>,
    /// When a point has been repeated often enough.
    pub stop: Option<StopRule>,
    /// What the sweep as a whole must come to.
    pub pass: SweepPass,
}

/// A base scenario.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Base {
    /// The file as the call can reach it.
    pub file: String,
    /// Its scenario's name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// Which combinations of the factors' values are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// Every combination; the last factor varies fastest.
    Grid,
    /// The base itself, then each factor through its values, all else as in the base.
    OneAtATime,
    /// The factors' values in step: all first ones, all second ones, and so on.
    Listed,
    /// A Sobol sequence, scrambled by the seed (Burley 2020).
    Sobol {
        /// Points.
        samples: u64,
    },
    /// A Latin hypercube: each factor's range in as many strata as there are points, one point in each (McKay, Beckman, Conover 1979).
    LatinHypercube {
        /// Points.
        samples: u64,
    },
    /// Independent draws.
    Random {
        /// Points.
        samples: u64,
    },
}

/// Ends a point's replicates once its pass rate is known well enough. It looks at them in their order, whoever finishes first, so
/// that the result does not depend on threads or machines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StopRule {
    /// Half the width of the 95 % Wilson interval of the pass rate at which a point has been repeated enough.
    pub pass_rate_half_width: f64,
    /// Replicates that every point has.
    pub least_replicates: u32,
}

/// What a sweep must come to; without any, a sweep that is complete has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepPass {
    /// Least share of cases that pass.
    pub pass_rate_min: Option<f64>,
    /// Least share of cases that pass at the worst point.
    pub point_pass_rate_min: Option<f64>,
    /// Most cases that could not go on.
    pub errors: Option<u64>,
    /// Most cases that reached their wall-clock limit.
    pub timeouts: Option<u64>,
}

impl Design {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::OneAtATime => "one-at-a-time",
            Self::Listed => "listed",
            Self::Sobol { .. } => "sobol",
            Self::LatinHypercube { .. } => "latin-hypercube",
            Self::Random { .. } => "random",
        }
    }
}

impl SweepFile {
    /// Reads a sweep file, lays the overlays over it, and reads its bases.
    ///
    /// # Errors
    /// Every error found: in the file, in a factor's values, in a base.
    pub fn read(path: &Path, overlays: &Overlays) -> Result<Self, Diagnostics> {
        resolve(Typed::read(path, overlays), |base| beside(path, base))
    }

    /// The same from a text whose bases stand in `bases`, by the name that the text has for them; errors name it `sweep`.
    ///
    /// # Errors
    /// Every error found.
    pub fn from_toml_str(text: &str, bases: &[(&str, &str)]) -> Result<Self, Diagnostics> {
        resolve(Typed::from_text("sweep", text), |base| among(bases, base))
    }

    /// The scenario of a base with settings laid over it and a seed.
    ///
    /// # Errors
    /// Where these settings together are no scenario: a robot that does not fit its duct, say.
    pub fn scenario(&self, base: usize, settings: &[String], seed: u64) -> Result<Scenario, Diagnostics> {
        let Base { file, text, .. } = &self.bases[base];
        let seed = format!("seed={seed}");
        let set = self.settings.iter().chain(settings).chain(std::iter::once(&seed));
        resolve::resolve(&Typed::from_text_with(file, text, set))
    }
}

/// A base as a file in `path`'s folder names it: where it is, and its text.
pub(in crate::scenario) fn beside(path: &Path, base: &str) -> Result<(String, String), Diagnostics> {
    let file = without_detours(&path.parent().unwrap_or(Path::new("")).join(base));
    let typed = Typed::read(&file, &Overlays::default());
    match typed.unreadable.is_empty() {
        true => Ok((file.display().to_string(), typed.sources.text(0).to_owned())),
        false => Err(Diagnostics(typed.unreadable)),
    }
}

/// The same out of texts, by the name that the file has for them.
pub(in crate::scenario) fn among(bases: &[(&str, &str)], base: &str) -> Result<(String, String), Diagnostics> {
    match bases.iter().find(|(name, _)| *name == base) {
        Some((name, text)) => Ok(((*name).to_owned(), (*text).to_owned())),
        None => Err(Diagnostics(vec![super::Diagnostic::of_file(base, "there is no such file", "check the name")])),
    }
}

/// A path with each `NAME/..` left out, as people would have typed it. Where NAME is a link that leads elsewhere, it stays.
fn without_detours(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir if matches!(short.components().next_back(), Some(Component::Normal(_))) => {
                short.pop();
            }
            Component::CurDir => {}
            part => short.push(part),
        }
    }
    match (path.canonicalize(), short.canonicalize()) {
        (Ok(there), Ok(here)) if there == here => short,
        _ => path.to_owned(),
    }
}

fn resolve(typed: Typed, load: impl Fn(&str) -> Result<(String, String), Diagnostics>) -> Result<SweepFile, Diagnostics> {
    let fail = |findings: Vec<Finding>| {
        let mut all = typed.unreadable.clone();
        all.extend(Diagnostics::from_findings(findings, &typed.sources).0);
        Err(Diagnostics(all))
    };
    if !typed.unreadable.is_empty() || !typed.findings.is_empty() {
        return fail(typed.findings.clone());
    }
    let mut reader = Reader::new(&typed.root);
    let Some(read) = reader.sweep() else { return fail(reader.findings) };
    if !reader.findings.is_empty() {
        return fail(reader.findings);
    }
    match with_bases(read, &load) {
        Ok(sweep) => Ok(sweep),
        Err(WrongBases::Named(findings)) => fail(findings),
        Err(WrongBases::Within(wrong)) => Err(wrong),
    }
}

/// What is wrong with the bases of a file.
pub(in crate::scenario) enum WrongBases {
    /// Where they are named.
    Named(Vec<Finding>),
    /// In their own files.
    Within(Diagnostics),
}

/// A sweep with its bases read by `load` (as the call can reach them, and their texts), each checked as it stands.
pub(in crate::scenario) fn with_bases(
    read: Read,
    load: &impl Fn(&str) -> Result<(String, String), Diagnostics>,
) -> Result<SweepFile, WrongBases> {
    let mut bases = Vec::new();
    let mut wrong = Vec::new();
    for (base, span) in &read.bases {
        match load(base) {
            Ok((file, text)) => bases.push(Base { file, name: String::new(), text }),
            Err(Diagnostics(found)) => {
                let told = found.into_iter().map(|one| format!("{}: {}", one.file, one.message)).collect::<Vec<_>>().join("; ");
                let help = "a base is a scenario file, its path from the sweep file's folder";
                wrong.push(Finding::new(*span, format!("the base cannot be read: {told}")).help(help));
            }
        }
    }
    if !wrong.is_empty() {
        return Err(WrongBases::Named(wrong));
    }
    let mut sweep = SweepFile { bases, ..read.sweep };
    // Paths may name an element that a base does not have: `duct.run[5].straight_m`.
    for Base { file, text, .. } in &sweep.bases {
        for factor in &sweep.factors {
            let setting = format!("{}={}", factor.path, factor.at(0.0).toml());
            if let Some(finding) = Typed::from_text_with(file, text, std::iter::once(&setting)).findings.first() {
                let help = finding.help.clone().unwrap_or_default();
                wrong.push(
                    Finding::new(Span::default(), format!("factor `{}` of {file}: {}", factor.path, finding.message)).help(help),
                );
            }
        }
    }
    if !wrong.is_empty() {
        return Err(WrongBases::Named(wrong));
    }
    // Each base as it stands, with what is laid over all of them.
    let mut all = Vec::new();
    for index in 0..sweep.bases.len() {
        match sweep.scenario(index, &[], sweep.seed) {
            Ok(scenario) => sweep.bases[index].name = scenario.name,
            Err(Diagnostics(found)) => all.extend(found),
        }
    }
    if !all.is_empty() {
        return Err(WrongBases::Within(Diagnostics(all)));
    }
    for (index, base) in sweep.bases.iter().enumerate() {
        if let Some(other) = sweep.bases[..index].iter().find(|other| other.name == base.name) {
            let message = format!("{} and {} are both named \"{}\"", other.file, base.file, base.name);
            let span = read.bases.get(index).map_or_else(Span::default, |(_, span)| *span);
            wrong.push(Finding::new(span, message).help("a case is told by its base's name: give one of the two another `name`"));
        }
    }
    if wrong.is_empty() { Ok(sweep) } else { Err(WrongBases::Named(wrong)) }
}

#[cfg(test)]
mod tests;
