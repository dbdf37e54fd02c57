//! The page of an accuracy study: figures of each pipeline and cell, and maps of where the errors are.

use ductloop_nav::perception::Wall;
use minijinja::{Environment, Value, context};
use serde_json::Value as Json;

use super::heat_map::{HeatMap, Mean};
use super::{ReportError, STYLE};
use crate::accuracy::Trials;
use crate::accuracy::trial::{Reading, SIDES, Trial};
use crate::scenario::Pipeline;
use crate::scenario::accuracy_file::AccuracyFile;

const PAGE: &str = include_str!("accuracy.html");
/// Fields of a map, along x and y.
const FIELDS: [usize; 2] = [12, 8];

/// The maps of a study: the file's name without its ending, and the map.
pub fn heat_maps(file: &AccuracyFile, trials: &Trials) -> Vec<(String, HeatMap)> {
    let mut maps = Vec::new();
    for pipeline in &file.pipelines {
        let word = pipeline.word();
        let pose = |trial: &Trial| [1e3 * trial.pose.lateral_m, trial.pose.heading_rad.to_degrees()];
        let all = || readings(trials, *pipeline);
        let of_pose = |value: fn(&Reading) -> Option<f64>| {
            all().filter(|(_, r)| r.shows_pose()).filter_map(move |(trial, r)| {
                let [x, y] = pose(trial);
                Some([x, y, value(r)?])
            })
        };
        const POSE: [&str; 2] = ["lateral offset / mm", "heading / °"];
        for (name, title, value) in [
            (
                "lateral",
                "lateral offset, RMS error / mm",
                (|r| r.score.lateral_error_m.map(|e| 1e3 * e)) as fn(&Reading) -> Option<f64>,
            ),
            ("heading", "heading, RMS error / °", |r| r.score.heading_error_rad.map(f64::to_degrees)),
        ] {
            let points: Vec<[f64; 3]> = of_pose(value).collect();
            maps.push((format!("{word}-{name}"), map(&format!("{word}: {title}"), POSE, Mean::RootOfSquares, &points)));
        }
        let walls: Vec<[f64; 3]> =
            all().flat_map(|(trial, reading)| SIDES.into_iter().filter_map(move |wall| of_wall(trial, reading, wall))).collect();
        let labels = ["distance of the wall from the camera / m", "heading / °"];
        maps.push((
            format!("{word}-wall"),
            map(&format!("{word}: distance of a wall, RMS error / mm"), labels, Mean::RootOfSquares, &walls),
        ));
        let missed: Vec<[f64; 3]> = all()
            .filter(|(_, r)| r.shows_pose())
            .map(|(trial, r)| {
                let [x, y] = pose(trial);
                [x, y, if r.is_answered() { 0.0 } else { 1.0 }]
            })
            .collect();
        if missed.iter().any(|[.., value]| *value > 0.0) {
            maps.push((format!("{word}-missed"), map(&format!("{word}: share without an answer"), POSE, Mean::Plain, &missed)));
        }
    }
    maps
}

fn readings(trials: &Trials, pipeline: Pipeline) -> impl Iterator<Item = (&Trial, &Reading)> {
    trials.list.iter().flat_map(move |trial| {
        let of = trial.readings.iter().filter(move |reading| reading.pipeline == pipeline);
        of.map(move |reading| (trial, reading))
    })
}

fn of_wall(trial: &Trial, reading: &Reading, wall: Wall) -> Option<[f64; 3]> {
    let score = reading.score.wall(wall).filter(|_| reading.counts(wall))?;
    Some([score.camera_distance_m, trial.pose.heading_rad.to_degrees(), 1e3 * score.distance_error_m?])
}

/// The map over what the points cover.
fn map(title: &str, labels: [&str; 2], mean: Mean, points: &[[f64; 3]]) -> HeatMap {
    let range = |axis: usize| {
        let least = points.iter().map(|point| point[axis]).fold(f64::INFINITY, f64::min);
        let most = points.iter().map(|point| point[axis]).fold(f64::NEG_INFINITY, f64::max);
        match least < most {
            true => [least, most],
            false if least.is_finite() => [least - 0.5, least + 0.5],
            false => [0.0, 1.0],
        }
    };
    HeatMap::of(title, labels, [range(0), range(1)], FIELDS, mean, points.iter().copied())
}

/// The page. `summary` is the study's document.
///
/// # Errors
/// None that is known of.
pub fn html(file: &AccuracyFile, summary: &Json, maps: &[(String, HeatMap)]) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.add_template("accuracy.html", PAGE)?;
    let mut rows = Vec::new();
    if file.cells.len() > 1 {
        for (index, cell) in file.cells.iter().enumerate() {
            let values: Vec<_> = cell.values.iter().map(|(_, value)| value.as_str()).collect();
            rows.extend(table_rows(file, &values.join(", "), &summary["cells"][index]["pipelines"]));
        }
    }
    rows.extend(table_rows(file, "all", &summary["pipelines"]));
    let fields: Vec<&str> =
        file.cells.first().map_or(Vec::new(), |cell| cell.values.iter().map(|(path, _)| path.as_str()).collect());
    let drawings: Vec<Value> = maps.iter().map(|(_, map)| Value::from_safe_string(map.svg())).collect();
    Ok(environment.get_template("accuracy.html")?.render(context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        name => &file.name,
        about => &file.about,
        verdict => summary["verdict"].as_str(),
        reasons => summary["reasons"].as_array().into_iter().flatten().map(reason).collect::<Vec<_>>(),
        poses => summary["poses"].as_u64(),
        seed => file.seed,
        fields => fields.join(", "),
        rows => rows,
        maps => drawings,
    })?)
}

fn reason(reason: &Json) -> String {
    let word = |key: &str| reason[key].as_str().unwrap_or("?").to_owned();
    let value = reason["value"].as_f64().map_or("not measured".to_owned(), |value| format!("{value:.4}"));
    format!("{}: {} is {value}, the bound {}", word("pipeline"), word("bound"), reason["limit"])
}

fn table_rows(file: &AccuracyFile, label: &str, pipelines: &Json) -> Vec<Value> {
    let row = |pipeline: &Pipeline| {
        let figures = &pipelines[pipeline.word()];
        let number = |value: &Json, per_unit: f64, decimals: usize| {
            value.as_f64().map_or("–".to_owned(), |value| format!("{:.decimals$}", value * per_unit))
        };
        let spread = |key: &str, per_unit: f64, decimals: usize| {
            ["bias", "rms", "worst", "bound", "bound_ratio"].map(|what| match what {
                "bound_ratio" => number(&figures[key][what], 1.0, 2),
                _ => number(&figures[key][what], per_unit, decimals),
            })
        };
        context! {
            label => label,
            pipeline => pipeline.word(),
            shown => number(&figures["shown"], 1.0, 0),
            detection => number(&figures["detection"], 100.0, 1),
            wall => spread("wall_distance_m", 1e3, 3),
            heading => spread("heading_rad", 1_f64.to_degrees(), 4),
            lateral => spread("lateral_m", 1e3, 3),
            centres => number(&figures["centres_rms_px"], 1.0, 3),
            precision => number(&figures["centres"]["precision"], 100.0, 1),
            recall => number(&figures["centres"]["recall"], 100.0, 1),
            nees => number(&figures["nees"], 1.0, 2),
            within => number(&figures["within_3_sigma"], 100.0, 1),
            beyond => number(&figures["beyond_6_sigma"], 1.0, 0),
        }
    };
    file.pipelines.iter().map(row).collect()
}
