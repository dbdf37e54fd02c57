use super::*;
use crate::metrics::{Metrics, Verdict};
use crate::scenario::study_file::{Objective, Over};
use crate::sweep::case::Cases;
use crate::sweep::outcome::Outcome;
use crate::tune::held_out::Held;
use crate::tune::proposer::Proposer;
use crate::tune::verdict::{Outcome as Worth, verdict_words};

const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                    [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";

fn study(head: &str, constraints: &str) -> StudyFile {
    let other = BASE.replace("\"b\"", "\"c\"");
    let text = format!(
        "format = 1\nkind = \"study\"\nname = \"s\"\nruns = 600\n{head}\n\
         [parameter]\nstart.lateral_m = {{ from = -0.1, to = 0.1 }}\nrobot.speed_m_s = {{ from = 0.1, to = 1.0, scale = \"log\" }}\n\
         [train]\nbase = [\"b.toml\", \"c.toml\"]\nreplicates = 3\n[held_out]\nbase = \"b.toml\"\nseed = 100\n\
         [objective]\nweights = {{ lateral_rms_m = 1.0 }}\n{constraints}"
    );
    StudyFile::from_toml_str(&text, &[("b.toml", BASE), ("c.toml", &other)]).unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// What a run measures in these tests: best at 0.03 m and 0.4 m/s, a little worse or better by the seed, which all candidates share; faster
/// than 0.5 m/s it touches.
fn outcome(case: &crate::sweep::case::Case) -> Outcome {
    let value = |index: usize| case.at.values.get(index).and_then(|value| value.as_ref()?.number());
    let (lateral, speed) = (value(0).unwrap_or(0.0), value(1).unwrap_or(0.3));
    let log = libm::log(speed / 0.4);
    let noise = 1e-3 * ((case.seed % 7) as f64 + case.at.base as f64);
    let mut metrics = [Some(0.0); Metrics::NUMBERS.len()];
    let at = |name: &str| Metrics::NUMBERS.iter().position(|other| *other == name).expect("a metric");
    metrics[at("lateral_rms_m")] = Some((lateral - 0.03) * (lateral - 0.03) * 100.0 + log * log + noise);
    metrics[at("control_effort")] = Some(speed * speed);
    metrics[at("collisions")] = Some(if speed > 0.5 { 1.0 } else { 0.0 });
    Outcome {
        hash: case.hash,
        verdict: Verdict::Pass,
        reasons: String::new(),
        end_state: Some("finished".to_owned()),
        metrics,
        run_hash: None,
        error: None,
        wall_time_s: 0.0,
        host: String::new(),
    }
}

fn rows(sweep: SweepFile) -> Result<Vec<Row>, Lost> {
    let cases = Cases::of(&sweep, "cpu");
    Ok((0..cases.count()).map(|index| cases.case(index)).map(|case| Row { outcome: outcome(&case), case }).collect())
}

fn searched(study: &StudyFile) -> Search {
    search(study, &mut Proposer::of(study), rows, |_| {}).unwrap_or_else(|lost| panic!("{lost}"))
}

fn best(study: &StudyFile) -> (Search, Trial) {
    let found = searched(study);
    let trial = found.trials[found.best.expect("a best")].clone();
    (found, trial)
}

#[test]
fn the_least_cost_is_found_within_the_budget() {
    for head in ["", "halving = false"] {
        let study = study(head, "");
        let (found, best) = best(&study);
        let values: Vec<f64> = best.values.iter().flatten().filter_map(Level::number).collect();
        assert!((values[0] - 0.03).abs() < 0.01 && (values[1] / 0.4 - 1.0).abs() < 0.05, "{head}: {values:?}");
        assert!(found.runs > 590 && found.runs <= 600, "{}", found.runs);
        assert!(best.is_full && best.rows.len() == 6 && best.costs.objectives < found.trials[0].costs.objectives);
        assert_eq!(best.costs, crate::tune::objective::costs(&study, &best.rows, &found.trials[0].rows));
    }
}

/// Halving spares runs, and what was spared is told apart.
#[test]
fn the_worse_half_is_run_no_further() {
    let (halved, _) = best(&study("", ""));
    let (whole, _) = best(&study("halving = false", ""));
    assert!(halved.trials.len() > whole.trials.len() * 5 / 4, "{} and {}", halved.trials.len(), whole.trials.len());
    assert!(halved.trials.iter().all(|trial| trial.rows.len() == if trial.is_full { 6 } else { 2 }));
    let full = halved.trials.iter().filter(|trial| trial.is_full && trial.generation == 1).count();
    assert_eq!(full, 3, "half of six");
    assert!(whole.trials.iter().all(|trial| trial.is_full));
}

/// Where each scenario has one seed, the first half of the scenarios tells which half of the candidates is worse.
#[test]
fn with_one_seed_the_scenarios_are_halved() {
    let mut study = study("", "");
    study.train.replicates = 1;
    let (found, best) = best(&study);
    assert_eq!(best.rows.len(), 2);
    let spared: Vec<&Trial> = found.trials.iter().filter(|trial| !trial.is_full).collect();
    assert!(!spared.is_empty() && spared.iter().all(|trial| trial.rows.len() == 1 && trial.rows[0].case.at.base == 0));
}

/// Accuracy asks for 0.4 m/s, effort for as little speed as there is: between the two no candidate is better in both, and the front tells so.
#[test]
fn of_several_objectives_the_front_is_found() {
    let mut study = study("", "");
    study.objectives = ["lateral_rms_m", "control_effort"]
        .map(|metric| Objective { name: metric.into(), weights: vec![(metric.into(), 1.0)], relative: false, over: Over::Mean })
        .into();
    let found = searched(&study);
    assert_eq!(found.optimiser, "MO-CMA-ES");
    assert!(found.trials.iter().all(|trial| trial.is_full), "nothing is halved");
    assert!(found.front.len() >= 5, "{:?}", found.front);
    let costs = |index: usize| &found.trials[index].costs;
    for trial in &found.trials {
        assert!(!found.front.iter().any(|index| trial.costs.dominates(costs(*index))), "{}", trial.number);
    }
    assert!(found.front.iter().all(|a| found.front.iter().all(|b| !costs(*a).dominates(costs(*b)))));
    let best = found.best.expect("a compromise");
    assert!(found.front.contains(&best));
    // Speeds from near the slowest to near the most accurate one; none beyond, where both are worse.
    let speed = |index: &usize| found.trials[*index].values.as_ref().and_then(|values| values[1].number()).unwrap_or(0.3);
    let speeds: Vec<f64> = found.front.iter().map(speed).collect();
    let [least, most] = [f64::min, f64::max].map(|of| speeds.iter().copied().fold(speeds[0], of));
    assert!(least < 0.15 && (0.3..0.45).contains(&most), "{least} to {most}");
    assert!((least..=most).contains(&speed(&best)) && speed(&best) > least && speed(&best) < most);
}

/// Least at 0.4 m/s, which takes an effort of 0.16; where no more than 0.09 may be taken, the best is at the bound.
#[test]
fn constraints_come_before_the_cost() {
    let study = study("", "[constraints]\nmost = { collisions = 0, control_effort = 0.09 }\n");
    let (found, best) = best(&study);
    assert!(best.costs.is_feasible());
    let speed = best.values.as_ref().and_then(|values| values[1].number()).unwrap_or_default();
    assert!((0.28..=0.3).contains(&speed), "{speed}");
    assert!(found.trials.iter().any(|trial| !trial.costs.is_feasible()), "some were too fast");
    let none = self::study("", "[constraints]\nmost = { lateral_rms_m = -1.0 }\n");
    let found = searched(&none);
    assert!(found.best.is_none() && found.trials.iter().all(|trial| trial.costs.violation > 0.0));
}

/// The default drives at 0.3 m/s and costs 0.17 and noise; no run may cost more than half of what the default's own did.
#[test]
fn a_candidate_is_held_against_the_defaults_own_runs() {
    let study = study("", "[constraints]\nof_default = { lateral_rms_m = 0.5 }\n");
    let (found, _) = best(&study);
    let default = &found.trials[0].rows;
    assert!(!found.trials[0].costs.is_feasible(), "the default costs as much as itself");
    for trial in &found.trials {
        let keeps = |row: &Row| {
            let own = default
                .iter()
                .find(|own| own.case.seed == row.case.seed && own.case.at.base == row.case.at.base)
                .expect("its own");
            row.outcome.metric("lateral_rms_m") <= own.outcome.metric("lateral_rms_m").map(|value| 0.5 * value)
        };
        assert_eq!(trial.costs.is_feasible(), trial.rows.iter().all(keeps), "{}", trial.number);
    }
}

/// What `[scenario]` says of a parameter is what the default has; candidates have their own.
#[test]
fn the_default_of_a_parameter_can_be_said() {
    let study = study("", "[scenario]\nrobot.speed_m_s = 0.6\n");
    assert_eq!(candidate::default(&study, &study.parameters[1]), Some(0.6));
    let scenario = |settings: &[String]| study.train.scenario(0, settings, 1).map(|scenario| scenario.speed_m_s);
    assert_eq!(scenario(&[]), Ok(0.6));
    assert_eq!(scenario(&["robot.speed_m_s=0.3".to_owned()]), Ok(0.3));
}

/// As shares of the default's own runs, the default costs 1.
#[test]
fn costs_may_be_shares_of_the_defaults() {
    let mut study = study("", "");
    study.objectives[0].relative = true;
    let (found, best) = best(&study);
    assert_eq!(found.trials[0].costs.objectives, [1.0]);
    let share = |row: &Row| {
        let same = |own: &&Row| own.case.seed == row.case.seed && own.case.at.base == row.case.at.base;
        let own = found.trials[0].rows.iter().find(same).expect("its own");
        row.outcome.metric("lateral_rms_m").expect("measured") / own.outcome.metric("lateral_rms_m").expect("measured")
    };
    let mean = best.rows.iter().map(share).sum::<f64>() / best.rows.len() as f64;
    assert!((best.costs.objectives[0] - mean).abs() < 1e-12 && mean < 0.2, "{mean}");
}

/// In the mean a candidate may cost more on one duct if it costs less on another; the default just keeps its own mean.
#[test]
fn a_mean_is_held_against_the_defaults_mean() {
    let study = study("", "[constraints]\nmean_of_default = { lateral_rms_m = 1.0 }\n");
    let (found, best) = best(&study);
    let mean = |trial: &Trial, rows: &dyn Fn(&Row) -> bool| -> f64 {
        let values: Vec<f64> =
            trial.rows.iter().filter(|row| rows(row)).filter_map(|row| row.outcome.metric("lateral_rms_m")).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    assert!(found.trials[0].costs.is_feasible() && best.costs.is_feasible());
    for trial in &found.trials {
        // Of those that were spared, the default's runs with the same seeds count.
        let same =
            |row: &Row| trial.rows.iter().any(|own| own.case.seed == row.case.seed && own.case.at.base == row.case.at.base);
        let keeps = mean(trial, &|_| true) <= mean(&found.trials[0], &same) * (1.0 + 1e-12);
        assert_eq!(trial.costs.is_feasible(), keeps, "{}", trial.number);
    }
    assert!(found.trials.iter().any(|trial| !trial.costs.is_feasible()));
}

#[test]
fn a_study_stops_as_it_says() {
    let (found, _) = best(&study("[stop]\nstep = 0.05\n", ""));
    assert_eq!(found.ended, Ended::AtRest);
    let (found, _) = best(&study("optimiser = \"random\"\n[stop]\ngenerations_without_gain = 2\n", ""));
    assert_eq!(found.ended, Ended::NoGain);
    let last = found.trials.last().map_or(0, |trial| trial.generation);
    assert!(found.trials[found.best.expect("a best")].generation + 2 == last, "{last}");
}

/// What it does follows from the study alone: the same again, and another with another seed.
#[test]
fn the_same_study_makes_the_same_candidates() {
    for optimiser in ["cma-es", "sobol", "random"] {
        let of = |seed: u64| best(&study(&format!("optimiser = \"{optimiser}\"\nseed = {seed}"), "")).0.trials;
        assert_eq!(of(3), of(3), "{optimiser}");
        assert_ne!(of(3).last(), of(4).last(), "{optimiser}");
    }
}

/// A study that holds out seven ducts; its objectives are these.
fn with_held_out_ducts(objectives: &str) -> StudyFile {
    let ducts: Vec<(String, String)> =
        (0..7).map(|i| (format!("{i}.toml"), BASE.replace("\"b\"", &format!("\"d{i}\"")))).collect();
    let bases: Vec<(&str, &str)> =
        ducts.iter().map(|(name, text)| (name.as_str(), text.as_str())).chain([("b.toml", BASE)]).collect();
    let names: Vec<String> = ducts.iter().map(|(name, _)| format!("{name:?}")).collect();
    let text = format!(
        "format = 1\nkind = \"study\"\nname = \"s\"\nruns = 60\n[parameter]\nstart.lateral_m = {{ from = -0.1, to = 0.1 }}\nrobot.speed_m_s = {{ from = 0.1, to = 1.0 }}\n[train]\n\
         base = \"b.toml\"\n[held_out]\nbase = [{}]\nseed = 100\n{objectives}[constraints]\nmost = {{ collisions = 0 }}\n",
        names.join(", ")
    );
    StudyFile::from_toml_str(&text, &bases).unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// What a find is worth, and how it is told, that has the default's runs on what is held out, at `times` the cost of metrics and changed on one
/// duct.
fn worth(study: &StudyFile, times: &[(&str, f64)], change: &[(&str, Option<f64>)]) -> (Worth, String) {
    let at = |name: &str| Metrics::NUMBERS.iter().position(|other| *other == name).expect("a metric");
    let found = searched(study);
    let best = found.best.expect("a best");
    assert_ne!(best, 0);
    let default = rows(study.held_out.clone()).unwrap_or_else(|lost| panic!("{lost}"));
    let mut own = default.clone();
    for (metric, times) in times {
        own.iter_mut().for_each(|row| row.outcome.metrics[at(metric)] = row.outcome.metrics[at(metric)].map(|cost| times * cost));
    }
    change.iter().for_each(|(metric, value)| own[3].outcome.metrics[at(metric)] = *value);
    let held = Held::of(study, default, vec![(best, own)]);
    (held.outcome(study), verdict_words(study, &found, Some(&held)).join("\n"))
}

/// What is better on held-out ducts and touches there, or has no figures there, is no gain.
#[test]
fn what_breaks_down_on_held_out_ducts_is_no_gain() {
    let study = with_held_out_ducts("[objective]\nweights = { lateral_rms_m = 1.0 }\n");
    let half = |change: &[(&str, Option<f64>)]| worth(&study, &[("lateral_rms_m", 0.5)], change);
    let (worth, words) = half(&[]);
    assert!(worth == Worth::Gain && words.contains("better on 7 of 7 ducts"), "{words}");
    let (worth, words) = half(&[("collisions", Some(1.0))]);
    assert!(worth == Worth::Broken && words.contains("most collisions") && words.contains("NO GAIN"), "{words}");
    let (worth, words) = half(&[("lateral_rms_m", None)]);
    assert!(worth == Worth::Broken && words.contains("the default has figures and it has none"), "{words}");
    let (worth, words) = half(&[("lateral_rms_m", Some(50.0))]);
    assert!(worth == Worth::NoGain && words.contains("no more than noise"), "{words}");
}

/// Of several objectives one that is better does not make up for one that is worse.
#[test]
fn what_is_worse_in_one_objective_is_a_trade_off() {
    let study = with_held_out_ducts(
        "[objective.tracking]\nweights = { lateral_rms_m = 1.0 }\n[objective.effort]\nweights = { control_effort = 1.0 }\n",
    );
    for (tracking, effort, is) in [
        (0.5, 1.0, Worth::Gain),
        (0.5, 0.5, Worth::Gain),
        (0.5, 2.0, Worth::TradeOff),
        (2.0, 0.5, Worth::TradeOff),
        (1.0, 2.0, Worth::NoGain),
        (1.0, 1.0, Worth::NoGain),
    ] {
        let (worth, words) = worth(&study, &[("lateral_rms_m", tracking), ("control_effort", effort)], &[]);
        assert_eq!(worth, is, "{tracking} {effort}: {words}");
    }
    // Nor for a wall that is touched.
    let times = [("lateral_rms_m", 0.5), ("control_effort", 2.0)];
    let (worth, words) = worth(&study, &times, &[("collisions", Some(1.0))]);
    assert_eq!(worth, Worth::Broken, "{words}");
}
