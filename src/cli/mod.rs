//! The command line, a file a command.
//!
//! - `args`: what may be typed; - `inputs`: files, folders and names to scenarios, all checked before anything runs;
//! - `run`, `render`, `check`, `bench`: the commands; - `progress`, `verdict_table`: what they show while and after;
//! - `problem`: what a command can end with other than its result; - `interrupt`: Ctrl-C.
//!
//! Exit codes: 0 every verdict passed; 1 one failed; 2 the command line or a file is wrong, or the output cannot be written;
//! 3 a run could not go on; 4 a wall-clock limit; 130 interrupted.

mod args;
mod bench;
mod check;
mod inputs;
mod interrupt;
mod problem;
mod progress;
mod render;
mod rendering;
mod run;
mod verdict_table;

use clap::Parser;

use args::{Cli, Command};
use problem::Problem;

/// Exit code of a run that was interrupted, as shells have it: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Reads the command line and carries it out; returns the exit code.
pub(crate) fn main() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // clap's own exit code for usage is 2, and 0 for --help and --version.
        Err(error) => {
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let result = match &cli.command {
        Command::Run(args) => run::command(args),
        Command::Render(args) => render::command(args),
        Command::Check(args) => check::command(args),
        Command::Schema => {
            problem::print_json(&ductloop::scenario::schema());
            Ok(0)
        }
        Command::Bench(args) => bench::command(args),
    };
    result.unwrap_or_else(|problem: Problem| problem.report(cli.command.json()))
}
