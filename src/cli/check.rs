//! `ductloop check`: are these files right?

use serde_json::json;

use super::args::CheckArgs;
use super::inputs;
use super::problem::Problem;
use super::streams::{print, print_json};
use super::warnings::{self, Warning};

/// Carries it out.
///
/// # Errors
/// Everything that is wrong with any of the files.
pub(crate) fn command(args: &CheckArgs) -> Result<u8, Problem> {
    let inputs = inputs::read(&args.inputs, &args.overlay)?;
    let mut rows = Vec::new();
    for input in &inputs {
        let scenario = &input.scenario;
        let length_m = scenario.duct.network().map_or(f64::NAN, |network| network.centreline.length_m());
        let (file, fittings, criteria) = (input.file.display(), scenario.duct.run.len(), scenario.pass.list.len());
        if !args.quiet && !args.json {
            let about = if scenario.about.is_empty() { String::new() } else { format!(": {}", scenario.about) };
            let (name, seed) = (&scenario.name, scenario.seed);
            print(&format!(
                "{file}: ok, `{name}`{about}\n  {length_m:.2} m, fittings: {fittings}, criteria: {criteria}, seed: {seed}"
            ))?;
        }
        let warnings = warnings::of_start(scenario);
        if !args.quiet {
            warnings.iter().for_each(|warning| warning.tell(&input.file));
        }
        rows.push(json!({
            "file": file.to_string(), "scenario": scenario.name, "length_m": length_m, "fittings": fittings, "criteria": criteria,
            "warnings": warnings.iter().map(Warning::to_json).collect::<Vec<_>>(),
        }));
    }
    if args.json {
        print_json(&json!({"scenarios": rows, "errors": []}))?;
    }
    Ok(0)
}
