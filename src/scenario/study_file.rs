//! A file of kind `study`: parameters to be found on some ducts, and other ducts that hold the find against the default.
//!
//! ```toml
//! format = 1
//! kind = "study"
//! name = "koh-cho"
//! optimiser = "cma-es"                   # or "sobol", "random"
//! runs = 500                             # budget
//!
//! [parameter]                            # any number of a scenario by its path
//! control.koh-cho.landing = { from = 0.005, to = 0.1, scale = "log" }
//!
//! [train]
//! base = ["../straight-offset.toml", "../straight-narrow.toml"]
//! replicates = 2                         # seeds of each
//!
//! [held_out]                             # never seen by the optimiser
//! base = ["../straight-wide.toml"]
//! replicates = 5
//! seed = 1001
//!
//! [objective]
//! over = "mean"                          # over the runs of a candidate; or "worst", or a quantile as 0.9
//! weights = { lateral_rms_m = 1.0 }      # of metrics, in SI; their sum is what is made small
//! relative = true                        # as a share of what the default costs on the same duct with the same seed
//!                                        # several of them stand below names of theirs: [objective.tracking], [objective.effort]
//!
//! [constraints]                          # that every run must keep
//! most = { collisions = 0 }
//! of_default = { control_effort = 1.0 }  # no more than the default's, on the same duct with the same seed
//! mean_of_default = { control_effort = 1.0 }  # the same in the mean over all
//!
//! [scenario]                             # laid over every base, as `--with` does
//! perception.pipeline = "truth"
//! ```

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::diagnostic::{Diagnostics, Finding};
use super::overlay::Overlays;
use super::source::Span;
use super::sweep_file::reader::Read;
use super::sweep_file::{Factor, SweepFile, WrongBases, among, beside, with_bases};
use super::typed::Typed;

mod concerns;
mod reader;
mod schema;

pub use concerns::Concern;
use reader::StudyReader;
pub use schema::schema;

/// Most runs of a study.
pub const MOST_RUNS: i64 = 10_000_000;

/// A study as resolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyFile {
    /// Its name, and its folder's.
    pub name: String,
    /// What it is for; may be empty.
    pub about: String,
    /// Seed of the optimiser.
    pub seed: u64,
    /// Who proposes candidates.
    pub optimiser: Optimiser,
    /// Command of a program of its own that proposes them instead; no file says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driver: Option<String>,
    /// Runs of a scenario that the search may take, held-out ones not counted.
    pub runs: u64,
    /// Whether a candidate that is in the worse half after one seed of each scenario is not run any further.
    pub halving: bool,
    /// What is varied, each between two ends.
    pub parameters: Vec<Factor>,
    /// What candidates are run on: a sweep without factors.
    pub train: SweepFile,
    /// What the best and the default are held against each other on.
    pub held_out: SweepFile,
    /// What is made small; of several, all that no other candidate betters in each are found.
    pub objectives: Vec<Objective>,
    /// What every run must keep.
    pub constraints: Constraints,
    /// When to stop before the budget is used.
    pub stop: Stop,
}

/// Who proposes candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimiser {
    /// An evolution strategy that learns the shape of the objective.
    CmaEs,
    /// A scrambled Sobol sequence.
    Sobol,
    /// Independent draws.
    Random,
}

/// What is made small.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Objective {
    /// Its name; a study's only one is its `cost`.
    pub name: String,
    /// Metrics, in SI, each with its weight.
    pub weights: Vec<(String, f64)>,
    /// Whether a run costs its share of what the default's own run costs, on the same duct with the same seed.
    pub relative: bool,
    /// How the runs of a candidate make one number.
    pub over: Over,
}

/// How the runs of a candidate make one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    /// Their mean.
    Mean,
    /// The worst of them.
    Worst,
    /// What this share of them keeps below.
    Quantile(f64),
}

/// What every run of a candidate must keep; one that does not is worse than any that do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Constraints {
    /// Whether it must pass the finishing line.
    pub finishes: bool,
    /// Metrics with the most that they may be.
    pub most: Vec<(String, f64)>,
    /// Metrics with the least that they must be.
    pub least: Vec<(String, f64)>,
    /// Metrics with the most that they may be, in times what the default has on the same duct with the same seed.
    pub of_default: Vec<(String, f64)>,
    /// Metrics of which the mean over the runs may be at most so many times the mean over the default's.
    pub mean_of_default: Vec<(String, f64)>,
}

/// When to stop before the budget is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    /// Step in every parameter, as a share of its range, below which the search has come to rest.
    pub step: Option<f64>,
    /// Generations without a better candidate.
    pub generations_without_gain: Option<u32>,
}

impl Optimiser {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::CmaEs => "cma-es",
            Self::Sobol => "sobol",
            Self::Random => "random",
        }
    }
}

impl StudyFile {
    /// Reads a study file, lays the overlays over it, and reads its bases.
    ///
    /// # Errors
    /// Every error found: in the file, in a parameter, in a base.
    pub fn read(path: &Path, overlays: &Overlays) -> Result<Self, Diagnostics> {
        resolve(&Typed::read(path, overlays), &|base: &str| beside(path, base))
    }

    /// The same from a text whose bases stand in `bases`, by the name that the text has for them; errors name it `study`.
    ///
    /// # Errors
    /// Every error found.
    pub fn from_toml_str(text: &str, bases: &[(&str, &str)]) -> Result<Self, Diagnostics> {
        resolve(&Typed::from_text("study", text), &|base: &str| among(bases, base))
    }

    /// Runs of one candidate.
    pub fn runs_of_a_candidate(&self) -> u64 {
        self.train.bases.len() as u64 * u64::from(self.train.replicates)
    }
}

fn resolve(typed: &Typed, load: &impl Fn(&str) -> Result<(String, String), Diagnostics>) -> Result<StudyFile, Diagnostics> {
    let fail = |findings: Vec<Finding>| {
        let mut all = typed.unreadable.clone();
        all.extend(Diagnostics::from_findings(findings, &typed.sources).0);
        Diagnostics(all)
    };
    if !typed.unreadable.is_empty() || !typed.findings.is_empty() {
        return Err(fail(typed.findings.clone()));
    }
    let mut reader = StudyReader::new(&typed.root);
    let Some((study, [train, held_out])) = reader.study() else { return Err(fail(reader.findings())) };
    let findings = reader.findings();
    if !findings.is_empty() {
        return Err(fail(findings));
    }
    let with = |read: Read| {
        // Each parameter is looked at in each base, as a factor of a sweep is.
        let sweep = SweepFile { factors: study.parameters.clone(), ..read.sweep };
        let sweep = with_bases(Read { sweep, bases: read.bases }, load).map_err(|wrong| match wrong {
            WrongBases::Named(findings) => fail(findings),
            WrongBases::Within(wrong) => wrong,
        })?;
        Ok::<_, Diagnostics>(SweepFile { factors: Vec::new(), ..sweep })
    };
    let (train, held_out) = (with(train)?, with(held_out)?);
    let study = StudyFile { train, held_out, ..study };
    let least = 2 * study.runs_of_a_candidate();
    if study.runs < least {
        let span = typed.root.get("runs").map_or(Span::default(), |node| node.span);
        let message = format!("{} runs are too few for the default and one candidate", study.runs);
        return Err(fail(vec![
            Finding::new(span, message).help(format!("each takes {} runs: `runs = {least}` or more", least / 2)),
        ]));
    }
    Ok(study)
}

#[cfg(test)]
mod tests;
