//! `ductloop sweep`: a design of experiments, on this machine or many.
//!
//! - `args`: what may be typed; - `inputs`: the file, and whether its points can be; - `steps`: plan, work, status, merge, alone;
//! - `bar`: how far it is; - `verdict`: the table and the exit code at the end; - `engine`: Slurm and Ray, whose machines run `work`.

use super::interrupt;
use super::problem::Problem;

pub(super) mod args;
mod bar;
pub(super) mod engine;
pub(super) mod inputs;
pub(super) mod steps;
mod verdict;

use args::Step;
pub(crate) use args::SweepArgs;
pub(crate) use inputs::read;

/// Carries it out.
///
/// # Errors
/// What keeps it from beginning or going on. What is finished is kept.
pub(crate) fn command(args: &SweepArgs) -> Result<u8, Problem> {
    interrupt::listen();
    match &args.step {
        None => steps::whole(&args.whole),
        Some(Step::Plan(args)) => steps::plan(args),
        Some(Step::Work(args)) => steps::work(args),
        Some(Step::Status(args)) => steps::status(args),
        Some(Step::Merge(args)) => steps::merge(args),
    }
}
