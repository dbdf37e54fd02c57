//! The page of a study: convergence, parameters against the cost, and the find against the default on what was held out.

use minijinja::{Environment, Value, context};

use super::plot::Plot;
use super::{ReportError, STYLE};
use crate::scenario::study_file::{Objective, Over, StudyFile};
use crate::scenario::sweep_file::SweepFile;
use crate::tune::candidate;
use crate::tune::comparison::Comparison;
use crate::tune::held_out::{Held, HeldTrial, Trajectories};
use crate::tune::search::Search;
use crate::tune::sensitivity::{against, rank_correlation};
use crate::tune::trials::{mean, metrics};
use crate::tune::verdict::{Outcome, verdict_words};

mod plots;

use plots::{convergence, front_plot, scatter, trajectories, volume};

const PAGE: &str = include_str!("tune.html");

/// The page.
///
/// # Errors
/// Where the template fails.
pub fn html(
    study: &StudyFile,
    search: &Search,
    held: Option<&Held>,
    paths: Option<&Trajectories>,
) -> Result<String, ReportError> {
    let several = study.objectives.len() > 1;
    let pairs = (0..study.objectives.len()).flat_map(|x| (x + 1..study.objectives.len()).map(move |y| [x, y]));
    let fronts: Vec<Value> = pairs.filter_map(|pair| front_plot(study, search, pair)).map(drawing).collect();
    let mut environment = Environment::new();
    environment.add_template("tune.html", PAGE)?;
    Ok(environment.get_template("tune.html")?.render(context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        name => study.name.as_str(), about => study.about.as_str(),
        words => verdict_words(study, search, held),
        outcome => held.map_or(Outcome::NoGain, |held| held.outcome(study)).word(),
        optimiser => search.optimiser.as_str(), seed => study.seed,
        objectives => study.objectives.iter().map(objective_words).collect::<Vec<_>>(),
        names => study.objectives.iter().map(|objective| objective.name.clone()).collect::<Vec<_>>(),
        train => names(&study.train), held_out => names(&study.held_out), several => several,
        convergence => if several { volume(search) } else { convergence(search) }.map(drawing),
        fronts => fronts,
        parameters => (0..study.parameters.len()).map(|index| parameter(study, search, index)).collect::<Vec<_>>(),
        comparisons => held.map(|held| comparisons(study, held)),
        scenarios => held.map(|held| scenarios(study, held)),
        metrics => metric_rows(study, search, held),
        paths => paths.and_then(trajectories).map(drawing), paths_label => paths.map(|paths| paths.label.clone()),
    })?)
}

fn drawing(plot: Plot) -> Value {
    Value::from_safe_string(plot.svg())
}

/// What an objective is, in words.
fn objective_words(objective: &Objective) -> String {
    let over = match objective.over {
        Over::Mean => "the mean over the runs".to_owned(),
        Over::Worst => "the worst of the runs".to_owned(),
        Over::Quantile(share) => format!("the {share} quantile over the runs"),
    };
    let terms: Vec<String> = objective.weights.iter().map(|(metric, weight)| format!("{weight} {metric}")).collect();
    let relative = if objective.relative { " as a share of the default's own run" } else { "" };
    format!("{}: {}{relative}, {over}", objective.name, terms.join(" + "))
}

fn names(sweep: &SweepFile) -> String {
    let names: Vec<&str> = sweep.bases.iter().map(|base| base.name.as_str()).collect();
    let seeds = if sweep.replicates == 1 { "one seed".to_owned() } else { format!("{} seeds", sweep.replicates) };
    format!("{} ({seeds} of each)", names.join(", "))
}

/// A parameter's row and its plots, one an objective.
fn parameter(study: &StudyFile, search: &Search, index: usize) -> Value {
    let parameter = &study.parameters[index];
    let best = search.best.and_then(|best| search.trials[best].values.as_ref());
    let by: Vec<Value> = study
        .objectives
        .iter()
        .enumerate()
        .map(|(at, objective)| {
            let points = against(search, index, at);
            context! {
                correlation => rank_correlation(&points).map(|rho| format!("{rho:+.2}")),
                plot => scatter(parameter, &objective.name, &points, best.and_then(|values| values[index].number())).map(drawing),
            }
        })
        .collect();
    context! {
        path => parameter.path.as_str(), unit => parameter.unit.as_str(),
        default => candidate::default(study, parameter).map(short),
        found => best.map(|values| values[index].shown()), by => by,
    }
}

/// The figures on what was held out: a row for each that stands for what was found, and each objective.
fn comparisons(study: &StudyFile, held: &Held) -> Vec<Value> {
    let row = |trial: usize, objective: &Objective, held: &Comparison| {
        context! {
            trial => trial, objective => objective.name.as_str(), pairs => held.pairs, better => held.better, units => held.units, by_duct => held.by_duct,
            default => short(held.default_cost), best => short(held.best_cost), gain => short(held.gain),
            least => short(held.interval[0]), most => short(held.interval[1]), p => format!("{:.4}", held.p_value),
        }
    };
    let of = |found: &HeldTrial| -> Vec<Value> {
        let each = study.objectives.iter().zip(&found.comparisons);
        each.filter_map(|(objective, held)| Some(row(found.trial, objective, held.as_ref()?))).collect()
    };
    held.found.iter().flat_map(of).collect()
}

/// The best against the default scenario by scenario, by each objective.
fn scenarios(study: &StudyFile, held: &Held) -> Vec<Value> {
    let Some(best) = held.found.first() else { return Vec::new() };
    let of = |objective: &Objective| {
        let rows = held.by_scenario(study, &best.rows, objective).into_iter().map(|(name, [default, found])| {
            let gain = (default > 0.0).then(|| format!("{:+.1} %", 100.0 * (found - default) / default));
            context! {
                name => name, objective => objective.name.clone(), default => short(default), best => short(found), change => gain,
            }
        });
        rows.collect::<Vec<_>>()
    };
    study.objectives.iter().flat_map(of).collect()
}

/// A number to five digits.
fn short(value: f64) -> String {
    format!("{value:.4e}").parse::<f64>().map_or_else(|_| "-".to_owned(), crate::scenario::shown)
}

/// Means of the metrics, of default and best, over the training runs and those held out.
fn metric_rows(study: &StudyFile, search: &Search, held: Option<&Held>) -> Vec<Value> {
    let number = |value: Option<f64>| value.map(|value| format!("{value:.5}"));
    let rows = |index: usize| &search.trials[index].rows;
    let found = held.and_then(|held| held.found.first());
    let row = |metric: String| {
        context! {
            default => number(mean(rows(0), &metric)), best => search.best.and_then(|best| number(mean(rows(best), &metric))),
            held_default => held.and_then(|held| number(mean(&held.default, &metric))),
            held_best => found.and_then(|found| number(mean(&found.rows, &metric))), metric => metric,
        }
    };
    metrics(study).into_iter().map(row).collect()
}
