//! What may be typed.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use ductloop::sweep::work::Shard;

use crate::cli::args::{OverlayArgs, RendererArgs, RendererChoice};

#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "\
Examples:
  ductloop sweep scenarios/sweeps/duct-width.toml             all of it, on all cores; report in out/duct-width/report.html
  ductloop sweep duct-width --set replicates=20               more runs of each point
  ductloop sweep smoke --json                                 figures as JSON

  ductloop sweep plan smoke --out out/s                       its steps alone, for schedulers
  ductloop sweep work out/s --shard 1/2                       on one machine
  ductloop sweep work out/s --shard 2/2                       on another that sees the same folder
  ductloop sweep status out/s
  ductloop sweep merge out/s

  ductloop sweep duct-width --engine slurm --nodes 8 --partition compute --out /shared/sweeps
                                                              a job array of Slurm, followed to its end and merged
  ductloop sweep duct-width --engine ray --nodes 8 --address 10.0.0.1:6379 --out /shared/sweeps
                                                              tasks on a Ray cluster; without --address on this machine

Called again after an interrupt, a crash or a power cut, it does what is missing and nothing twice. Every case is a row of
results.parquet; the report says with which command each of the worst is repeated alone."
)]
pub(crate) struct SweepArgs {
    #[command(subcommand)]
    pub(crate) step: Option<Step>,
    #[command(flatten)]
    pub(crate) whole: WholeArgs,
}

/// Steps of a sweep.
#[derive(Debug, Subcommand)]
pub(crate) enum Step {
    /// Write the list of cases, and run none
    Plan(PlanArgs),
    /// Run the cases of a plan that are not done, or a share of them
    Work(WorkArgs),
    /// Say how much of a plan is done
    Status(PlaceArgs),
    /// Make table, summary and report of what is done
    Merge(MergeArgs),
}

/// Which sweep.
#[derive(Args, Debug)]
pub(crate) struct FileArgs {
    /// File of kind `sweep`, or name of one in ./scenarios/sweeps
    #[arg(required = true, value_name = "FILE|NAME")]
    pub(crate) input: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// What renders: with the processor results do not depend on the machine
    #[arg(long, value_enum, default_value_t = RendererChoice::Cpu)]
    pub(crate) renderer: RendererChoice,
    /// Take the place of another sweep's plan; results of cases that both have are kept
    #[arg(long)]
    pub(crate) force: bool,
    /// Plan more cases than 10 000
    #[arg(long)]
    pub(crate) yes: bool,
}

#[derive(Args, Debug)]
pub(crate) struct WholeArgs {
    #[command(flatten)]
    pub(crate) file: FileArgs,
    /// Folder for the sweep's folder, or the address of an object store (`s3://bucket/prefix`)
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: String,
    /// Cases at a time, each on one core
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) engine: EngineArgs,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

/// Which scheduler runs the cases, on which machines; this machine alone if none is named.
#[derive(Args, Debug)]
pub(crate) struct EngineArgs {
    /// Run the cases on the machines of a scheduler, which see this program and DIR under the same paths
    #[arg(long, value_enum, value_name = "ENGINE", requires = "nodes")]
    pub(crate) engine: Option<EngineChoice>,
    #[command(flatten)]
    pub(crate) machines: MachinesArgs,
}

/// A scheduler's machines, and what it is told.
#[derive(Args, Clone, Debug)]
pub(crate) struct MachinesArgs {
    /// Machines to ask for; never more than there are points
    #[arg(long, value_name = "N", requires = "engine", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) nodes: Option<u32>,
    /// Slurm: partition of the jobs
    #[arg(long, value_name = "NAME", requires = "engine")]
    pub(crate) partition: Option<String>,
    /// Slurm: one more argument for sbatch, as in `--engine-arg=--time=60`; may be given several times
    #[arg(long, value_name = "ARG", requires = "engine", allow_hyphen_values = true)]
    pub(crate) engine_arg: Vec<String>,
    /// Ray: the cluster's address; without it that of `RAY_ADDRESS`, else one that runs here, else one is started on this machine
    #[arg(long, value_name = "HOST:PORT", requires = "engine")]
    pub(crate) address: Option<String>,
    /// Ray or Optuna: Python in which it is installed [default: python3]
    #[arg(long, value_name = "PROGRAM", requires = "engine")]
    pub(crate) python: Option<String>,
}

impl MachinesArgs {
    /// Options that are given and that only a scheduler understands.
    pub(crate) fn of_a_scheduler(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            ("--nodes", self.nodes.is_some()),
            ("--partition", self.partition.is_some()),
            ("--engine-arg", !self.engine_arg.is_empty()),
            ("--address", self.address.is_some()),
        ];
        given.into_iter().filter(|(_, given)| *given).map(|(option, _)| option)
    }
}

/// A scheduler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EngineChoice {
    /// A job array
    Slurm,
    /// Tasks of a cluster
    Ray,
}

#[derive(Args, Debug)]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    pub(crate) file: FileArgs,
    /// Folder of the plan and its results, or their place in an object store
    #[arg(long, value_name = "DIR")]
    pub(crate) out: String,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

#[derive(Args, Debug)]
pub(crate) struct WorkArgs {
    /// Folder of a plan, or its place in an object store
    #[arg(value_name = "DIR")]
    pub(crate) place: String,
    /// Share of the points, as in `2/5`: the second of five
    #[arg(long, value_name = "I/N", value_parser = shard, default_value = "1/1")]
    pub(crate) shard: Shard,
    /// Cases at a time, each on one core
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

#[derive(Args, Debug)]
pub(crate) struct PlaceArgs {
    /// Folder of a plan, or its place in an object store
    #[arg(value_name = "DIR")]
    pub(crate) place: String,
    #[command(flatten)]
    pub(crate) saying: SayingArgs,
}

#[derive(Args, Debug)]
pub(crate) struct MergeArgs {
    #[command(flatten)]
    pub(crate) place: PlaceArgs,
    /// Merge what is there, although cases are missing
    #[arg(long)]
    pub(crate) partial: bool,
}

/// What is said, and how.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct SayingArgs {
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

impl SweepArgs {
    /// Whether the result is to be one JSON document.
    pub(crate) fn json(&self) -> bool {
        match &self.step {
            None => self.whole.saying.json,
            Some(Step::Plan(args)) => args.saying.json,
            Some(Step::Work(args)) => args.saying.json,
            Some(Step::Status(args)) => args.saying.json,
            Some(Step::Merge(args)) => args.place.saying.json,
        }
    }
}

/// How a case is rendered: on one thread.
pub(crate) fn rendering(renderer: RendererChoice) -> RendererArgs {
    RendererArgs { renderer, threads: Some(1) }
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
    match parts {
        Some((index, count)) if index >= 1 && index <= count => Ok(Shard { index, count }),
        Some((index, count)) => Err(format!("shards of {count} are 1/{count} to {count}/{count}, and this is {index}/{count}")),
        None => Err("as in `2/5`: the second of five".into()),
    }
}
