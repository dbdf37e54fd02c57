//! The command line, a file a command.
//!
//! - `args`: what may be typed; - `inputs`: files, folders and names to scenarios, all checked before anything runs, with their
//!   `source`, a file or the library; - `list`, `new`: the library shown and copied;
//! - `destination`: where results go, checked likewise; - `run`, `render`, `check`, `accuracy`, `calibrate`, `schema`,
//!   `bench`: the commands; - `sweep`: designs of experiments and their steps; - `tune`: studies, whose generations are sweeps;
//! - `progress`, `verdict_table`: what they show while and after; - `rendering`: opening what renders;
//! - what `run` is made of: `seeds` (those that are asked for), `run_plan` (scenarios times seeds, each with its folder), `one_run`
//!   (from first frame to folder), `jobs` (several at once), `seed_verdict`, `seed_table` (what the seeds of a scenario came to);
//! - `shot`, `truth_files`: what `render` shows and what it writes beside it; - `warnings`: what is hardly meant so;
//! - `perceive`, `picture_files`, `regions`, `perceived`: picture files through the perception, and what is told of it;
//! - `problem`: what a command can end with other than its result; - `streams`: standard output and error; - `interrupt`: Ctrl-C;
//! - `python`: one in which a package is installed, for engines that need one.
//!
//! Exit codes: 0 every verdict passed; 1 one failed; 2 the command line or a file is wrong, or the output cannot be written;
//! 3 a run could not go on; 4 a wall-clock limit; 130 interrupted.

mod accuracy;
mod accuracy_table;
mod args;
mod bench;
mod calibrate;
mod check;
mod destination;
mod inputs;
mod interrupt;
mod jobs;
mod list;
mod new;
mod one_run;
mod perceive;
mod perceived;
mod picture_files;
mod problem;
mod progress;
mod python;
mod regions;
mod render;
mod rendering;
mod run;
mod run_plan;
mod schema;
mod seed_table;
mod seed_verdict;
mod seeds;
mod shot;
mod source;
mod streams;
mod sweep;
mod truth_files;
mod tune;
mod verdict_table;
mod warnings;

use clap::Parser;

use args::{Cli, Command};
use problem::Problem;

/// Exit code of a run that was interrupted, as shells have it: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Reads the command line and carries it out; returns the exit code.
pub(crate) fn main() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return not_understood(&error),
    };
    let result = match &cli.command {
        Command::Run(args) => run::command(args),
        Command::Render(args) => render::command(args),
        Command::Accuracy(args) => accuracy::command(args),
        Command::List(args) => list::command(args),
        Command::New(args) => new::command(args),
        Command::Check(args) => check::command(args),
        Command::Schema(args) => schema::command(args),
        Command::Bench(args) => bench::command(args),
        Command::Calibrate(args) => calibrate::command(args),
        Command::Perceive(args) => perceive::command(args),
        Command::Sweep(args) => sweep::command(args),
        Command::Tune(args) => tune::command(args),
    };
    result.unwrap_or_else(|problem| {
        let code = problem.tell();
        if cli.command.json() { problem.print(cli.command.list()) } else { code }
    })
}

/// Shows help or version, or what is wrong with the command line: then whoever asked for a document gets one too.
fn not_understood(error: &clap::Error) -> u8 {
    let _ = error.print();
    // clap's own exit code for usage is 2, and 0 for --help and --version.
    let code = u8::try_from(error.exit_code()).unwrap_or(Problem::WRONG_INPUT);
    let typed: Vec<_> = std::env::args_os().skip(1).take_while(|arg| arg != "--").collect();
    if code == 0 || !typed.iter().any(|arg| arg == "--json") {
        return code;
    }
    let said = error.to_string();
    let said = said.strip_prefix("error: ").unwrap_or(&said);
    let (message, help) = said.split_once("\n\n").unwrap_or((said, ""));
    let list = match typed.first().and_then(|command| command.to_str()) {
        Some("run") => Some(Command::RUNS),
        Some("check" | "list") => Some(Command::SCENARIOS),
        Some("perceive") => Some(perceive::PerceiveArgs::IMAGES),
        _ => None,
    };
    Problem::new(code, message.trim()).help(help.trim()).print(list)
}
