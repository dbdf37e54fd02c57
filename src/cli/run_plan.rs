//! Which runs a call of `run` is to make, each with a folder of its own, and whether all of it can be written: known before any
//! begins.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ductloop::Scenario;
use ductloop::output::{FolderError, OutFolder, folder_name};

use super::args::RunArgs;
use super::inputs::Input;
use super::problem::{Problem, Problems};
use super::{INTERRUPTED, destination, interrupt};

/// The runs, and what they are made of.
pub(crate) struct Plan {
    /// The scenarios as files and command line have them; their seeds count where no others are asked for.
    pub(crate) inputs: Vec<Input>,
    /// Input by input, each with its seeds in their order.
    pub(crate) runs: Vec<Planned>,
    /// Where the runs' folders go.
    pub(crate) out: OutFolder,
}

/// A run that can begin. Its scenario is made when it does: a hundred thousand would take gigabytes.
pub(crate) struct Planned {
    /// Index of its input.
    pub(crate) input: usize,
    /// Its seed.
    pub(crate) seed: u64,
    /// Its scenario, where the seed makes more of it than random numbers: a network that is drawn.
    drawn: Option<Box<Scenario>>,
    /// The name of its folder.
    pub(crate) name: String,
}

impl Plan {
    /// The input of a run.
    pub(crate) fn input(&self, run: &Planned) -> &Input {
        &self.inputs[run.input]
    }

    /// The scenario of a run: what `--seed` would make of its input.
    pub(crate) fn scenario(&self, run: &Planned) -> Scenario {
        match &run.drawn {
            Some(scenario) => (**scenario).clone(),
            None => Scenario { seed: run.seed, ..self.input(run).scenario.clone() },
        }
    }
}

/// Plans the runs, and makes sure that everything can be written.
///
/// # Errors
/// Two runs of one name, folders and files that cannot be written, more passes asked for than there are seeds.
pub(crate) fn plan(args: &RunArgs, inputs: Vec<Input>) -> Result<Plan, Problem> {
    enough_seeds(args)?;
    destination::folder("--out", &args.out)?;
    let out = OutFolder::read(&args.out, args.force);
    let mut problems = Problems::default();
    // Where each name comes from.
    let mut names: BTreeMap<String, usize> = BTreeMap::new();
    let mut runs = Vec::new();
    for (index, input) in inputs.iter().enumerate() {
        let mut scenario = input.scenario.clone();
        let draws = args.seeds.is_some() && with_seed(args, input, scenario.seed ^ 1)?.duct != scenario.duct;
        // The run whose folder is tried out for all of this input: no other has a longer name.
        let mut longest: Option<(String, String)> = None;
        for seed in seeds(args, input) {
            // A hundred thousand seeds take a minute.
            if interrupt::requested() {
                return Err(Problem::new(INTERRUPTED, "interrupted before the first run"));
            }
            scenario.seed = seed;
            let drawn = if draws { Some(Box::new(with_seed(args, input, seed)?)) } else { None };
            if let Some(drawn) = &drawn {
                scenario = (**drawn).clone();
            }
            let toml = scenario.to_toml();
            let name = name(args, input, &scenario, &toml);
            if let Some(other) = names.insert(name.clone(), index) {
                let message = format!("its run's folder would be `{name}`, as that of {}", inputs[other].source);
                problems.note(
                    Problem::new(Problem::WRONG_INPUT, message)
                        .about(input.source.to_string())
                        .help("give one of the two another `name`"),
                );
                continue;
            }
            match out.look(&out.folder(&name, &toml)) {
                Ok(()) if longest.as_ref().is_none_or(|(other, _)| other.len() < name.len()) => {
                    longest = Some((name.clone(), toml))
                }
                Ok(()) => {}
                Err(error) => problems.note(unusable(args, &error)),
            }
            runs.push(Planned { input: index, seed, drawn, name });
        }
        if let Some((name, toml)) = longest
            && let Err(error) = out.try_out(&out.folder(&name, &toml))
        {
            problems.note(unusable(args, &error));
        }
    }
    if let Some(path) = &args.junit
        && let Err(problem) = junit_file(path)
    {
        problems.note(problem);
    }
    problems.or(Plan { inputs, runs, out })
}

/// An input read again with another seed.
fn with_seed(args: &RunArgs, input: &Input, seed: u64) -> Result<Scenario, Problem> {
    let mut overlays = args.overlay.overlays();
    overlays.set.push(format!("seed={seed}"));
    input.source.read(&overlays).map_err(|diagnostics| Problem::in_files(vec![args.overlay.as_typed(diagnostics)]))
}

/// The seeds of an input.
fn seeds<'a>(args: &'a RunArgs, input: &'a Input) -> Box<dyn Iterator<Item = u64> + 'a> {
    match &args.seeds {
        Some(seeds) => Box::new(seeds.iter()),
        None => Box::new(std::iter::once(input.scenario.seed)),
    }
}

/// The name of a run's folder. Another navigator's run has one of its own.
fn name(args: &RunArgs, input: &Input, scenario: &Scenario, toml: &str) -> String {
    match &args.navigator {
        Some(navigator) => folder_name(&scenario.name, true, scenario.seed, &format!("{toml}# {navigator}\n")),
        None => folder_name(&scenario.name, input.changed || args.seeds.is_some(), scenario.seed, toml),
    }
}

/// Makes sure that no more passes are asked for than there are seeds.
fn enough_seeds(args: &RunArgs) -> Result<(), Problem> {
    let (Some(least), Some(seeds)) = (args.at_least, &args.seeds) else { return Ok(()) };
    let count = seeds.count();
    if least as usize <= count {
        return Ok(());
    }
    let message = format!("each scenario runs with {count} seed{} only", if count == 1 { "" } else { "s" });
    Err(Problem::new(Problem::WRONG_INPUT, message)
        .about(format!("--at-least {least}"))
        .help(format!("{count} or fewer can be asked for, or name more `--seeds`")))
}

/// Makes sure that the JUnit file can be written. `--junit scenarios/*.toml`, where its name was forgotten, must not write over
/// the first scenario.
fn junit_file(path: &Path) -> Result<(), Problem> {
    if path.extension().is_some_and(|ending| ending == "toml") {
        let wrong = Problem::new(Problem::WRONG_INPUT, "a JUnit file is XML, and this is the name of a scenario file");
        return Err(wrong.about(format!("--junit {}", path.display())).help("as in `--junit out/junit.xml`"));
    }
    destination::file("--junit", path)
}

/// That a run's folder cannot be used.
fn unusable(args: &RunArgs, error: &FolderError) -> Problem {
    match error {
        FolderError::System { .. } => destination::refused("--out", &args.out, error.to_string()),
        error => Problem::new(Problem::WRONG_INPUT, error.to_string()),
    }
}

/// The report of a run in its folder.
pub(crate) fn report(out: &Path, name: &str) -> PathBuf {
    out.join(name).join("report.html")
}
