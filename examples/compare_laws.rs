//! Every control law, and navigators of one's own, on the same scenarios and seeds: a table, JSON, and a plot of the traces.
//!
//! ```text
//! cargo run --release --example compare_laws -- [--seeds N] [--json FILE] [--plot FILE] [--navigator 'NAME=COMMAND'] [SCENARIO…]
//! ```
//!
//! Settling distance: along the duct, until the robot stays within 5 mm of its centreline. Overshoot: how far it comes to the other
//! side than it started on. RMS and worst lateral error and effort are those of `summary.json`. Means over the seeds, but the worst of
//! worst error, settling distance and overshoot.

use std::fmt::Write as _;
use std::time::Duration;

use ductloop::engine::Engine;
use ductloop::scenario::{Law, Overlays};
use ductloop::{NavigatorCommand, Pilot, Scenario};
use serde_json::{Value, json};

/// Within this of the centreline a robot has settled, in metres.
const SETTLED_M: f64 = 5e-3;

type Failure = Box<dyn std::error::Error>;

struct Asked {
    seeds: u64,
    json: Option<String>,
    plot: Option<String>,
    navigators: Vec<(String, String)>,
    scenarios: Vec<String>,
}

/// One run's figures and trace.
struct Run {
    lateral_rms_m: Option<f64>,
    lateral_max_m: Option<f64>,
    settled_m: Option<f64>,
    overshoot_m: f64,
    effort: Option<f64>,
    time_s: f64,
    completed: bool,
    /// (distance since the start, lateral), in metres.
    trace: Vec<(f64, f64)>,
}

fn asked() -> Result<Asked, Failure> {
    let mut asked = Asked { seeds: 3, json: None, plot: None, navigators: Vec::new(), scenarios: Vec::new() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--seeds" => asked.seeds = value()?.parse()?,
            "--json" => asked.json = Some(value()?),
            "--plot" => asked.plot = Some(value()?),
            "--navigator" => {
                let named = value()?;
                let (name, command) = named.split_once('=').ok_or("--navigator NAME=COMMAND")?;
                asked.navigators.push((name.to_owned(), command.to_owned()));
            }
            _ => asked.scenarios.push(word),
        }
    }
    if asked.scenarios.is_empty() {
        asked.scenarios = ["scenarios/straight-offset.toml", "scenarios/straight-fast.toml"].map(str::to_owned).to_vec();
    }
    Ok(asked)
}

fn run(scenario: &Scenario, pilot: Pilot) -> Result<Run, Failure> {
    let outcome = ductloop::run_on(&Engine::Cpu, scenario, pilot)?;
    let side = scenario.start.lateral_m.signum();
    let trace: Vec<(f64, f64)> = outcome
        .record
        .frames
        .iter()
        .map(|frame| (frame.truth.distance_m - scenario.start.distance_m, frame.truth.lateral_m))
        .collect();
    let last_off = trace.iter().rposition(|(_, y)| y.abs() > SETTLED_M);
    let settled_m = match last_off {
        None => Some(0.0),
        Some(index) => trace.get(index + 1).map(|(x, _)| *x),
    };
    let metrics = &outcome.metrics;
    Ok(Run {
        lateral_rms_m: metrics.lateral_rms_m,
        lateral_max_m: metrics.lateral_max_m,
        settled_m,
        overshoot_m: trace.iter().map(|(_, y)| -side * y).fold(0.0, f64::max),
        effort: metrics.control_effort,
        time_s: outcome.record.sim_time_s,
        completed: metrics.completed,
        trace,
    })
}

/// The figures of one law on one scenario; what any run did not come to is null.
fn figures(runs: &[Run]) -> Value {
    let mean = |of: &dyn Fn(&Run) -> Option<f64>| {
        let all: Option<Vec<f64>> = runs.iter().map(of).collect();
        all.map(|all| all.iter().sum::<f64>() / all.len() as f64)
    };
    let worst = |of: &dyn Fn(&Run) -> Option<f64>| {
        let all: Option<Vec<f64>> = runs.iter().map(of).collect();
        all.map(|all| all.into_iter().fold(0.0, f64::max))
    };
    json!({
        "runs": runs.len(),
        "completed": runs.iter().filter(|run| run.completed).count(),
        "lateral_rms_m": mean(&|run| run.lateral_rms_m),
        "lateral_max_m": worst(&|run| run.lateral_max_m),
        "settled_m": worst(&|run| run.settled_m),
        "overshoot_m": worst(&|run| Some(run.overshoot_m)),
        "control_effort": mean(&|run| run.effort),
        "sim_time_s": mean(&|run| Some(run.time_s)),
    })
}

fn row(name: &str, figures: &Value) -> String {
    let shown = |key: &str, scale: f64, digits: usize| {
        figures[key].as_f64().map_or_else(|| "-".to_owned(), |x| format!("{:.digits$}", x * scale))
    };
    format!(
        "| {name} | {}/{} | {} | {} | {} | {} | {} | {} |",
        figures["completed"],
        figures["runs"],
        shown("lateral_rms_m", 1e3, 2),
        shown("lateral_max_m", 1e3, 2),
        shown("settled_m", 1.0, 2),
        shown("overshoot_m", 1e3, 1),
        shown("control_effort", 1.0, 1),
        shown("sim_time_s", 1.0, 1),
    )
}

fn main() -> Result<(), Failure> {
    let asked = asked()?;
    let mut document = serde_json::Map::new();
    let mut panels = Vec::new();
    for file in &asked.scenarios {
        let base = Scenario::read(file.as_ref(), &Overlays::default())?;
        println!("\n{} ({} m/s, seeds 1 to {}):\n", base.name, base.speed_m_s, asked.seeds);
        println!("| law | completed | RMS, mm | worst, mm | settled, m | overshoot, mm | effort, rad/s² | time, s |");
        println!("|---|---|---|---|---|---|---|---|");
        let mut traces = Vec::new();
        let mut of_scenario = serde_json::Map::new();
        let mut add = |name: &str, runs: Vec<Run>| {
            let figures = figures(&runs);
            println!("{}", row(name, &figures));
            of_scenario.insert(name.to_owned(), figures);
            traces.extend(runs.into_iter().next().map(|run| (name.to_owned(), run.trace)));
        };
        for law in Law::ALL {
            let mut runs = Vec::new();
            for seed in 1..=asked.seeds {
                let mut scenario = Scenario { seed, ..base.clone() };
                scenario.control.law = law;
                runs.push(run(&scenario, Pilot::of(&scenario))?);
            }
            add(law.word(), runs);
        }
        for (name, command) in &asked.navigators {
            let program = NavigatorCommand::parse(command, Duration::from_secs(10))?;
            let mut runs = Vec::new();
            for seed in 1..=asked.seeds {
                let scenario = Scenario { seed, ..base.clone() };
                runs.push(run(&scenario, program.start(&scenario)?)?);
            }
            add(name, runs);
        }
        document.insert(base.name.clone(), Value::Object(of_scenario));
        panels.push((format!("{}, {} m/s", base.name, base.speed_m_s), traces));
    }
    if let Some(file) = &asked.json {
        std::fs::write(file, serde_json::to_string_pretty(&document)? + "\n")?;
    }
    if let Some(file) = &asked.plot {
        std::fs::write(file, plot(&panels))?;
    }
    Ok(())
}

/// A title, and of each law its name and points (distance, lateral error).
type Panel = (String, Vec<(String, Vec<(f64, f64)>)>);

/// Lateral offset over distance, a panel a scenario, as SVG.
fn plot(panels: &[Panel]) -> String {
    const COLOURS: [&str; 9] =
        ["#1b6ca8", "#999999", "#d1495b", "#edae49", "#00798c", "#6a4c93", "#2e933c", "#000000", "#a0522d"];
    let (width, height, left, top) = (680.0, 240.0, 56.0, 30.0);
    const LENGTH_M: f64 = 3.0;
    const RANGE_MM: (f64, f64) = (-20.0, 70.0);
    let at = |panel: usize, x_m: f64, y_m: f64| {
        let y_mm = (y_m * 1e3).clamp(RANGE_MM.0, RANGE_MM.1);
        let panel_top = top + panel as f64 * (height + 60.0);
        (left + x_m / LENGTH_M * width, panel_top + (RANGE_MM.1 - y_mm) / (RANGE_MM.1 - RANGE_MM.0) * height)
    };
    let (all_w, all_h) = (left + width + 150.0, top + panels.len() as f64 * (height + 60.0));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {all_w} {all_h}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let mut put = |line: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(svg, "{line}");
    };
    for (panel, (title, traces)) in panels.iter().enumerate() {
        let (x, y) = at(panel, 0.0, RANGE_MM.1 * 1e-3);
        put(format!(
            "<text x=\"{x}\" y=\"{:.1}\" font-weight=\"bold\">{title}: lateral offset (mm) over distance (m)</text>",
            y - 8.0
        ));
        for y_mm in [-20, 0, 20, 40, 60] {
            let ((x0, y), (x1, _)) = (at(panel, 0.0, f64::from(y_mm) * 1e-3), at(panel, LENGTH_M, 0.0));
            put(format!("<line x1=\"{x0}\" y1=\"{y:.1}\" x2=\"{x1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>"));
            put(format!("<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{y_mm}</text>", x0 - 6.0, y + 4.0));
        }
        for half in 0..=6 {
            let (x, y) = at(panel, f64::from(half) * 0.5, RANGE_MM.0 * 1e-3);
            put(format!("<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>", y + 16.0, f64::from(half) * 0.5));
        }
        for (index, (name, trace)) in traces.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let near = trace.iter().filter(|(x, _)| (0.0..=LENGTH_M).contains(x));
            let points: Vec<String> = near.map(|(x, y)| at(panel, *x, *y)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            put(format!("<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{}\"/>", points.join(" ")));
            let (x, y) = at(panel, LENGTH_M, RANGE_MM.1 * 1e-3);
            let y = y + 16.0 * (index as f64 + 0.5);
            put(format!("<text x=\"{:.1}\" y=\"{y:.1}\" fill=\"{colour}\">{name}</text>", x + 10.0));
        }
    }
    svg + "</svg>\n"
}
