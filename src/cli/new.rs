//! `ductloop new`: a copy of a scenario to start from.

use std::path::{Path, PathBuf};

use clap::Args;
use ductloop::Scenario;
use ductloop::output::write_whole;
use ductloop::scenario::renamed;
use serde_json::json;

use super::problem::Problem;
use super::source::Source;
use super::streams::{print, print_json};
use super::{destination, inputs};

/// What may be typed.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ductloop new my-duct.toml                        a copy of `straight`
  ductloop new my-elbow.toml --from elbow-left     of another scenario of the library: `ductloop list` shows them
  ductloop new ducts/b.toml --from ducts/a.toml    of a file

The copy has all comments, and the file's name as its own: `my-elbow`. Then:
  ductloop check my-elbow.toml --plan plan.svg     what is wrong with it, and what its duct looks like
  ductloop run my-elbow.toml                       its report is out/my-elbow/report.html")]
pub(crate) struct NewArgs {
    /// The file to write, as in `my-duct.toml`; folders above it are made where they are missing
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// What to copy: a scenario of the library, or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "straight")]
    pub(crate) from: PathBuf,
    /// Replace a file that is there
    #[arg(long)]
    pub(crate) force: bool,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// The longest name that a scenario can have.
const LONGEST_NAME: usize = 64;

/// Carries it out.
///
/// # Errors
/// A file's name that is none for a scenario, a file that is there or cannot be written, nothing to copy, or something that is no
/// scenario. Then nothing is written.
pub(crate) fn command(args: &NewArgs) -> Result<u8, Problem> {
    let file = &args.file;
    let name = name(file)?;
    let source = inputs::one(&args.from)?;
    // A link that leads nowhere is there, too.
    if !args.force && file.symlink_metadata().is_ok() {
        let there = Problem::new(Problem::WRONG_INPUT, "this file is there already");
        return Err(there.about(file.display().to_string()).help("choose another name, or replace it with `--force`"));
    }
    if let Source::File(from) = &source {
        destination::is_no_input("FILE", file, std::iter::once(from))?;
    }
    destination::file("FILE", file)?;
    let text = copy(&source, name)?;
    write_whole(file, text.as_bytes())
        .map_err(|error| Problem::new(Problem::WRONG_INPUT, error.to_string()).about(file.display().to_string()))?;
    if args.json {
        let (file, from) = (file.display().to_string(), source.to_string());
        print_json(&json!({"file": file, "scenario": name, "from": from, "errors": []}))?;
    } else if !args.quiet {
        let file = file.display();
        print(&format!("{file}: a copy of {source}; `ductloop check {file}` checks it, `ductloop run {file}` runs it"))?;
    }
    Ok(0)
}

/// The name of the scenario in a file of this name.
fn name(file: &Path) -> Result<&str, Problem> {
    let wrong = |message: String| Problem::new(Problem::WRONG_INPUT, message).about(file.display().to_string());
    if file.extension().is_none_or(|ending| ending != "toml") {
        return Err(wrong("the name of a scenario file ends in .toml".into()).help("as in `ductloop new my-duct.toml`"));
    }
    let is_sound = |name: &&str| {
        name.len() <= LONGEST_NAME && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_'))
    };
    file.file_stem().and_then(|stem| stem.to_str()).filter(is_sound).ok_or_else(|| {
        let message = format!("the scenario is called as its file, in letters, digits, `-` and `_`, {LONGEST_NAME} at most");
        wrong(message).help("as in `ductloop new my-duct.toml`")
    })
}

/// The text of a scenario under another name, with what to do with it at its head.
fn copy(source: &Source, name: &str) -> Result<String, Problem> {
    // What is copied must be sound, or the copy is not.
    let of_source = |diagnostics| Problem::in_files(vec![diagnostics]);
    source.read(&Default::default()).map_err(of_source)?;
    let text = source.text().map_err(|error| Problem::new(Problem::WRONG_INPUT, error).about(source.to_string()))?;
    // A mark of the byte order stands at the very beginning or nowhere.
    let text = text.trim_start_matches('\u{feff}');
    let head = format!(
        "# Begun as a copy of {source}. To draw its duct and see what is wrong with it, and to run it:\n\
         #   ductloop check {name}.toml --plan plan.svg\n\
         #   ductloop run {name}.toml\n\
         # `ductloop schema` prints all keys that there are, `ductloop run --help` what a run takes.\n\n",
        source = source.to_string().replace(char::is_control, " "),
    );
    let renamed = renamed(text, name).ok_or_else(|| {
        Problem::new(Problem::WRONG_INPUT, "it gives no name that could be exchanged").about(source.to_string())
    })?;
    let text = head + &renamed;
    Scenario::read_text(&format!("{name}.toml"), &text, &Default::default()).map_err(of_source)?;
    Ok(text)
}
