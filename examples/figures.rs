//! Repeats the figures that the documents quote, and writes them as JSON. `./figures.sh` calls it.
//!
//! ```text
//! cargo run --release --example figures -- [--slice] --bench FILE --physics FILE --stripes FILE --sensor FILE --memory FILE \
//!     --calibration FILE --study FILE --study FILE … --tuned FILE … OUT.json
//! ```
//!
//! `--bench` is what `ductloop bench --json` printed; the others are the printed lines of the tests that measure physics,
//! rendered stripes, and the sensor (CCD, light, and the renderers against each other), `--memory` those of the example
//! `resident_memory`, `--calibration` those of the gauge and of the photographs; `--study` is what `ductloop accuracy --json` printed,
//! `--tuned` what `ductloop tune --json` did.
//! `--slice` takes one seed a scenario instead of eight, and four random networks instead of 32.

use std::error::Error;
use std::path::Path;

use ductloop::scenario::Overlays;
use ductloop::survey::Survey;
use ductloop::{Engine, Metrics, Outcome, Pilot, Scenario, Verdict};
use serde_json::{Map, Value, json};

/// The scenarios that figures are quoted of.
const SCENARIOS: [&str; 5] = ["straight", "straight-offset", "straight-incra1", "straight-narrow", "straight-wide"];

/// The routes and surveys that figures are quoted of, in `scenarios/networks`.
const ROUTES: [&str; 5] = ["elbow-mitred", "tees", "loop", "explore", "twenty-fittings"];
/// Random networks for each seed of the others.
const NETWORKS_A_SEED: u64 = 4;

struct Arguments {
    seeds: u64,
    bench: Value,
    physics: Vec<String>,
    stripes: Vec<String>,
    sensor: Vec<String>,
    memory: Vec<String>,
    calibration: Vec<String>,
    studies: Map<String, Value>,
    tuned: Map<String, Value>,
    out: String,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = read_arguments()?;
    let mut tracking = Map::new();
    for name in SCENARIOS {
        tracking.insert(name.into(), over_seeds(name, &[], arguments.seeds)?);
    }
    // What the paper's own steps cost: Hough's bins as lines, the cross product as plane.
    let own = ["perception.paper.line_fit=hough-peak", "perception.paper.plane_fit=cross-product"];
    let mut papers_own_steps = Map::new();
    for name in ["straight-offset", "straight-incra1"] {
        papers_own_steps.insert(name.into(), over_seeds(name, &own, arguments.seeds)?);
    }
    let mut truth = Map::new();
    truth.insert("straight-offset".into(), over_seeds("straight-offset", &["perception.pipeline=truth"], 1)?);
    let mut speed = Map::new();
    for metres_per_second in ["0.5", "0.8"] {
        let setting = format!("robot.speed_m_s={metres_per_second}");
        speed.insert(metres_per_second.into(), over_seeds("straight-offset", &[&setting], arguments.seeds)?);
    }
    let mut routes = Map::new();
    for name in ROUTES {
        routes.insert(name.into(), driven(&format!("networks/{name}"), 1)?);
    }
    routes.insert("random-network".into(), driven("networks/random-network", NETWORKS_A_SEED * arguments.seeds)?);
    let document = json!({
        "seeds": arguments.seeds,
        "bench": arguments.bench,
        "tracking": tracking,
        "papers_own_steps": papers_own_steps,
        "steered_by_the_truth": truth,
        "straight_offset_by_speed_m_s": speed,
        "routes": routes,
        "physics": arguments.physics,
        "stripes": arguments.stripes,
        "sensor": arguments.sensor,
        "memory": arguments.memory,
        "calibration": arguments.calibration,
        "accuracy": arguments.studies,
        "tuning": arguments.tuned,
    });
    std::fs::write(&arguments.out, format!("{document:#}\n"))?;
    println!("{}", arguments.out);
    Ok(())
}

fn read_arguments() -> Result<Arguments, Box<dyn Error>> {
    let (mut seeds, mut bench, mut out) = (8, Value::Null, None);
    let (mut physics, mut stripes, mut sensor, mut memory) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut calibration, mut studies, mut tuned) = (Vec::new(), Map::new(), Map::new());
    let mut rest = std::env::args().skip(1);
    while let Some(argument) = rest.next() {
        let mut text = || -> Result<String, Box<dyn Error>> {
            let file = rest.next().ok_or("a file must follow")?;
            Ok(std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))?)
        };
        match argument.as_str() {
            "--slice" => seeds = 1,
            "--bench" => bench = serde_json::from_str(&text()?)?,
            "--physics" => physics = printed(&text()?, &["chi ", "drift ", "closed form", " apart ", "energy of"]),
            "--stripes" => stripes = printed(&text()?, &["px RMS"]),
            "--sensor" => sensor = printed(&text()?, &[" for ", " px RMS", " DN, worst ", " centres; "]),
            "--memory" => memory = printed(&text()?, &[" MiB"]),
            "--calibration" => calibration = printed(&text()?, &["mm RMS", "px RMS", "skipped"]),
            "--study" => {
                let study: Value = serde_json::from_str(&text()?)?;
                let name = study["name"].as_str().ok_or("a study without a name")?.to_owned();
                studies.insert(name, cells(&study));
            }
            "--tuned" => {
                let study: Value = serde_json::from_str(&text()?)?;
                let name = study["study"].as_str().ok_or("a study without a name")?.to_owned();
                let keys = ["optimiser", "trials", "runs", "best", "held_out", "verdict"];
                tuned.insert(name, keys.iter().map(|key| ((*key).to_owned(), study[*key].clone())).collect::<Map<_, _>>().into());
            }
            path => out = Some(path.to_owned()),
        }
    }
    let out = out.ok_or("the name of the file to write is missing")?;
    Ok(Arguments { seeds, bench, physics, stripes, sensor, memory, calibration, studies, tuned, out })
}

/// The lines that tests printed with one of `words` in them, without the name of the test that stands before the first.
fn printed(text: &str, words: &[&str]) -> Vec<String> {
    let told = text.lines().filter(|line| words.iter().any(|word| line.contains(word)));
    told.map(|line| line.rsplit(" ... ").next().unwrap_or(line).to_owned()).collect()
}

/// What each pipeline reached in each cell of a study.
fn cells(study: &Value) -> Value {
    study["cells"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|cell| json!({"values": cell["values"], "pipelines": cell["pipelines"]}))
        .collect()
}

/// Median and worst over seeds 1..=n of what the documents quote.
fn over_seeds(name: &str, settings: &[&str], seeds: u64) -> Result<Value, Box<dyn Error>> {
    let mut runs = Vec::new();
    let mut passed = 0;
    for seed in 1..=seeds {
        let (_, outcome) = run(name, settings, seed)?;
        passed += u64::from(outcome.verdict == Verdict::Pass);
        runs.push(outcome.metrics);
    }
    let spread = |value: fn(&Metrics) -> Option<f64>, scale: f64| {
        let mut values: Vec<f64> = runs.iter().filter_map(value).map(|v| v * scale).collect();
        values.sort_by(f64::total_cmp);
        json!({"median": values.get(values.len() / 2), "worst": values.last()})
    };
    let degrees = 1.0_f64.to_degrees();
    Ok(json!({
        "passed": format!("{passed} of {seeds}"),
        "lateral_rms_mm": spread(|m| m.lateral_rms_m, 1e3),
        "lateral_max_mm": spread(|m| m.lateral_max_m, 1e3),
        "heading_rms_deg": spread(|m| m.heading_rms_rad, degrees),
        "lateral_estimate_rms_mm": spread(|m| m.lateral_estimate_rms_m, 1e3),
        "heading_estimate_rms_deg": spread(|m| m.heading_estimate_rms_rad, degrees),
        "invalid_share": spread(|m| m.estimates_valid.map(|valid| 1.0 - valid), 1.0),
        "real_time_factor": spread(|m| m.real_time_factor, 1.0),
    }))
}

fn run(name: &str, settings: &[&str], seed: u64) -> Result<(Scenario, Outcome), Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).with_extension("toml");
    let set = settings.iter().map(ToString::to_string).chain([format!("seed={seed}")]).collect();
    let scenario = Scenario::read(&file, &Overlays { set, ..Overlays::default() })?;
    // On the processor, so that figures are the same on every machine.
    let outcome = ductloop::run_on(&Engine::Cpu, &scenario, Pilot::of(&scenario))?;
    eprintln!("{name} {settings:?} seed {seed}: {}", outcome.verdict.word());
    Ok((scenario, outcome))
}

/// What routes through networks came to over seeds 1..=n: driving, naming, survey; and whether the survey's errors are of the size that its
/// deviations say.
fn driven(name: &str, seeds: u64) -> Result<Value, Box<dyn Error>> {
    let mut runs = Vec::new();
    let (mut lengths, mut turns) = (Vec::new(), Vec::new());
    let mut passed = 0;
    for seed in 1..=seeds {
        let (scenario, outcome) = run(name, &[], seed)?;
        passed += u64::from(outcome.verdict == Verdict::Pass);
        for duct in Survey::of(&scenario, &outcome.record).into_iter().flat_map(|survey| survey.ducts) {
            let Some(error) = duct.error else { continue };
            lengths.extend(error.length_m.zip(duct.length_sigma_m));
            turns.extend(error.turn_deg.zip(duct.turn_sigma_deg));
        }
        runs.push(outcome.metrics);
    }
    let spread = |value: fn(&Metrics) -> Option<f64>| {
        let mut values: Vec<f64> = runs.iter().filter_map(value).collect();
        values.sort_by(f64::total_cmp);
        json!({"least": values.first(), "median": values.get(values.len() / 2), "greatest": values.last()})
    };
    let sum = |value: fn(&Metrics) -> u32| runs.iter().map(value).sum::<u32>();
    Ok(json!({
        "passed": format!("{passed} of {seeds}"),
        "finished": runs.iter().filter(|m| m.completed).count(),
        "collisions": sum(|m| m.collisions),
        "junctions_taken": sum(|m| m.junctions_taken),
        "lateral_rms_mm": spread(|m| m.lateral_rms_m.map(|rms_m| rms_m * 1e3)),
        "ahead_fittings": sum(|m| m.ahead_fittings),
        "ahead_named_share": spread(|m| m.ahead_named_share),
        "ahead_detection_widths_min": spread(|m| m.ahead_detection_widths_min),
        "ahead_false_alarms": sum(|m| m.ahead_false_alarms.unwrap_or(0)),
        "survey_drift_share": spread(|m| m.survey_drift_share),
        "survey_length_error_max": spread(|m| m.survey_length_error_max),
        "survey_width_error_max_mm": spread(|m| m.survey_width_error_max_m.map(|error_m| error_m * 1e3)),
        "length_errors_m": against_deviations(&lengths),
        "turn_errors_deg": against_deviations(&turns),
    }))
}

/// Errors, each with its stated deviation: their RMS, the deviations' mean, the mean square of their ratio, and how many are within two.
fn against_deviations(errors: &[(f64, f64)]) -> Value {
    let count = errors.len();
    let mean = |of: fn(&(f64, f64)) -> f64| (count > 0).then(|| errors.iter().map(of).sum::<f64>() / count as f64);
    json!({
        "count": count,
        "rms": mean(|(error, _)| error * error).map(f64::sqrt),
        "deviation_mean": mean(|(_, sigma)| *sigma),
        "mean_square_in_deviations": mean(|(error, sigma)| (error / sigma) * (error / sigma)),
        "within_two": errors.iter().filter(|(error, sigma)| error.abs() <= 2.0 * sigma).count(),
    })
}
