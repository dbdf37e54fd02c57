//! What may be typed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::args::{OverlayArgs, RendererChoice};
use crate::cli::problem::Problem;
use crate::cli::sweep::args::{EngineChoice, MachinesArgs, SayingArgs};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop tune scenarios/studies/koh-cho.toml                 best.toml, trials.parquet and report.html in out/koh-cho
  ductloop tune smoke --json                                   a small one; figures as JSON
  ductloop tune koh-cho --set runs=60 --set optimiser=sobol    fewer runs, another way to search
  ductloop run straight-offset --with out/koh-cho/best.toml    what was found, on any scenario

  ductloop tune koh-cho --engine optuna                        the same study, proposed by Optuna (`pip install optuna`)
  ductloop tune koh-cho --optimiser 'python3 examples/optimiser.py'
                                                               by any program that speaks the protocol of docs/tuning.md
  ductloop tune koh-cho --engine slurm --nodes 8 --out /shared/studies
                                                               runs on a cluster; --engine slurm,optuna joins both

Called again after an interrupt, a crash or a power cut, it goes on from what was run: the same study with the same seed gives the same best
to the bit, on any number of threads. When the find is not better than the default by more than noise on the held-out ducts, it says so.")]
pub(crate) struct TuneArgs {
    /// File of kind `study`, or name of one in ./scenarios/studies
    #[arg(value_name = "FILE|NAME")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// What renders: with the processor results do not depend on the machine
    #[arg(long, value_enum, default_value_t = RendererChoice::Cpu)]
    pub(crate) renderer: RendererChoice,
    /// Folder for the study's folder; it is made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Runs at a time, each on one core; results are the same
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Who proposes candidates in the study's optimiser's place, and which scheduler runs them; both with a comma between
    #[arg(long, value_enum, value_name = "ENGINE", value_delimiter = ',')]
    pub(crate) engine: Vec<TuneEngine>,
    #[command(flatten)]
    pub(crate) machines: MachinesArgs,
    /// Program that proposes candidates, as a shell takes it
    #[arg(long, value_name = "COMMAND")]
    pub(crate) optimiser: Option<String>,
    /// Take the place of another study in its folder; runs that both have are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Refuse what is only warned of, as scenarios that are trained on and held out with the same seeds
    #[arg(long)]
    pub(crate) strict: bool,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

/// An engine of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TuneEngine {
    /// Candidates by Optuna
    Optuna,
    /// Runs as job arrays of Slurm
    Slurm,
    /// Runs as tasks of a Ray cluster
    Ray,
}

/// Who proposes in the place of what is built in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Driver {
    /// Optuna, in this Python.
    Optuna { python: String },
    /// A shell's command.
    Command(String),
}

impl Driver {
    /// As a study's folder remembers it.
    pub(super) fn told(&self) -> String {
        match self {
            // Which Python it is in does not matter.
            Self::Optuna { .. } => "optuna".to_owned(),
            Self::Command(command) => command.clone(),
        }
    }
}

impl TuneArgs {
    /// Who proposes, where it is not the study's own optimiser.
    ///
    /// # Errors
    /// Two at a time.
    pub(super) fn driver(&self) -> Result<Option<Driver>, Problem> {
        let optuna = self.engine.contains(&TuneEngine::Optuna);
        match (&self.optimiser, optuna) {
            (Some(_), true) => {
                Err(Problem::new(Problem::WRONG_INPUT, "two propose candidates: this command, and `--engine optuna`")
                    .about("--optimiser")
                    .help("leave one of them out"))
            }
            (Some(command), false) if command.trim().is_empty() => {
                Err(Problem::new(Problem::WRONG_INPUT, "this is no command: it is empty")
                    .about("--optimiser")
                    .help("as in `--optimiser 'python3 examples/optimiser.py'`"))
            }
            (Some(command), false) => Ok(Some(Driver::Command(command.clone()))),
            (None, true) => {
                let python = self.machines.python.clone().unwrap_or_else(|| "python3".to_owned());
                Ok(Some(Driver::Optuna { python }))
            }
            (None, false) => Ok(None),
        }
    }

    /// Which scheduler runs the candidates, if one does, and what it is told.
    ///
    /// # Errors
    /// Two at a time, none for an option that needs one, or one without machines.
    pub(super) fn scheduler(&self) -> Result<Option<(EngineChoice, MachinesArgs)>, Problem> {
        let wrong = |message: &str, about: &str| Problem::new(Problem::WRONG_INPUT, message).about(about);
        let mut schedulers = self.engine.iter().filter_map(|engine| match engine {
            TuneEngine::Optuna => None,
            TuneEngine::Slurm => Some(EngineChoice::Slurm),
            TuneEngine::Ray => Some(EngineChoice::Ray),
        });
        let scheduler = schedulers.next();
        if schedulers.next().is_some() {
            return Err(wrong("runs are handed to one scheduler", "--engine").help("leave one of them out"));
        }
        // Optuna's Python is none of Slurm's business.
        let python = self.machines.python.clone().filter(|_| !self.engine.contains(&TuneEngine::Optuna));
        let machines = MachinesArgs { python, ..self.machines.clone() };
        let Some(scheduler) = scheduler else {
            let alone = machines.of_a_scheduler().next().or(machines.python.as_ref().map(|_| "--python"));
            return match alone {
                Some(option) => {
                    Err(wrong("this is for an engine, and none is named", option).help("as in `--engine slurm --nodes 8`"))
                }
                None => Ok(None),
            };
        };
        if machines.nodes.is_none() {
            return Err(wrong("how many machines is not said", "--engine").help("as in `--engine slurm --nodes 8`"));
        }
        Ok(Some((scheduler, machines)))
    }
}
