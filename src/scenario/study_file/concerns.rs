//! What is not wrong with a study, and is hardly meant so.

use super::{Optimiser, StudyFile};
use crate::scenario::sweep_file::{Base, SweepFile};
use crate::scenario::{EstimatorKind, Law, Pipeline, Scenario};

/// Something that somebody should know before a study is run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Concern {
    /// What it is.
    pub message: String,
    /// What to do instead.
    pub help: String,
}

impl StudyFile {
    /// What is to be warned of.
    pub fn concerns(&self) -> Vec<Concern> {
        let mut all = self.overlaps();
        all.extend(self.idle_parameters());
        all.extend(self.idle_step());
        all
    }

    /// A step to stop at, for an optimiser that has no step size. Who drives a study from outside is not known before it is run.
    fn idle_step(&self) -> Option<Concern> {
        let name = self.driver.as_deref().unwrap_or(self.optimiser.word());
        let has_steps = self.driver.is_none() && self.optimiser == Optimiser::CmaEs;
        (self.stop.step.is_some() && !has_steps).then(|| Concern {
            message: format!("`[stop]` `step` ends nothing: {name} has no steps that become smaller"),
            help: "leave it out, or say `generations_without_gain`".to_owned(),
        })
    }

    /// Scenarios that are trained on and held out with a seed in common.
    fn overlaps(&self) -> Vec<Concern> {
        let seeds = |sweep: &SweepFile| sweep.seed..sweep.seed.saturating_add(u64::from(sweep.replicates));
        let (train, held) = (seeds(&self.train), seeds(&self.held_out));
        let common = train.start.max(held.start)..train.end.min(held.end);
        if common.is_empty() {
            return Vec::new();
        }
        // Two files may say the same in other words.
        let scenario = |sweep: &SweepFile, base: usize| {
            let mut scenario = sweep.scenario(base, &[], common.start).ok()?;
            (scenario.name, scenario.about) = (String::new(), String::new());
            Some(scenario)
        };
        let held: Vec<_> = (0..self.held_out.bases.len()).map(|base| scenario(&self.held_out, base)).collect();
        let both = |base: &usize| scenario(&self.train, *base).is_some_and(|own| held.contains(&Some(own)));
        let told = |base: &Base| {
            let (name, first, last) = (&base.name, common.start, common.end - 1);
            let seeds = if first == last { format!("seed {first}") } else { format!("seeds {first} to {last}") };
            let message = format!("`{name}` is trained on and held out with {seeds}: what is found there proves nothing");
            Concern { message, help: "give `[held_out]` a `seed` beyond those of `[train]`, or scenarios of its own".to_owned() }
        };
        (0..self.train.bases.len()).filter(both).map(|base| told(&self.train.bases[base])).collect()
    }

    /// Parameters of a part that no training scenario uses.
    fn idle_parameters(&self) -> Vec<Concern> {
        let seed = self.train.seed;
        let trained: Vec<Scenario> =
            (0..self.train.bases.len()).filter_map(|base| self.train.scenario(base, &[], seed).ok()).collect();
        let told = |path: &str| {
            let (needed, _) = needs(path).filter(|(_, is_met)| !trained.iter().any(is_met))?;
            let message = format!("`{path}` changes nothing: no training scenario has `{needed}`");
            Some(Concern { message, help: format!("leave it out, or say `{needed}` in `[scenario]`") })
        };
        self.parameters.iter().filter_map(|parameter| told(&parameter.path)).collect()
    }
}

/// What a scenario must have for a field to count, in its words, and whether it has; `None` where every one does.
fn needs(path: &str) -> Option<(String, impl Fn(&Scenario) -> bool)> {
    let (table, _) = path.rsplit_once('.')?;
    let (group, part) = table.split_once('.').unwrap_or((table, ""));
    let law = Law::of(part).filter(|_| group == "control");
    let pipeline = Pipeline::of(part).filter(|_| group == "perception");
    let is_kalman = group == "estimation";
    let words = match (law, pipeline) {
        (Some(law), _) => format!("control.law = \"{}\"", law.word()),
        (_, Some(pipeline)) => format!("perception.pipeline = \"{}\"", pipeline.word()),
        _ if is_kalman => "estimation.kind = \"kalman\"".to_owned(),
        _ => return None,
    };
    // The printed law has its landing in Koh and Cho's table.
    let is_printed_too = path == "control.koh-cho.landing";
    let is_met = move |scenario: &Scenario| {
        law.is_none_or(|law| scenario.control.law == law || (is_printed_too && scenario.control.law == Law::KohChoPrinted))
            && pipeline.is_none_or(|pipeline| scenario.perception.pipeline == pipeline)
            && (!is_kalman || scenario.estimation.kind == EstimatorKind::Kalman)
    };
    Some((words, is_met))
}
