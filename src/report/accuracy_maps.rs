//! Where the errors of an accuracy study are: heat maps of each pipeline over lateral offset and heading, and over a wall's distance.
//!
//! Cells of the grid are kept apart, since surfaces and rigs err in different places; only those that differ by nothing but where the
//! robot stands (`start.lateral_m` and its like in the grid) are one map's, because that is what a map is over. All maps of a study
//! have the same axes.

use super::heat_map::{HeatMap, Mean};
use crate::accuracy::Trials;
use crate::accuracy::trial::{Reading, SIDES, Trial};
use crate::scenario::Pipeline;
use crate::scenario::accuracy_file::{AccuracyFile, Cell};

/// The maps of a cell of the grid, or of several that differ by where the robot stands alone.
#[derive(Clone, Debug, PartialEq)]
pub struct CellMaps {
    /// The grid's values, without those that say where the robot stands; empty where there are no others.
    pub label: String,
    /// Cells of the grid in it.
    pub cells: usize,
    /// Poses in it.
    pub poses: usize,
    /// Each map's file name without its ending, and the map.
    pub maps: Vec<(String, HeatMap)>,
}

/// A grid of more cells has maps of these first ones only: a page of more could not be opened.
pub const MOST_MAPPED: usize = 256;
/// Fields of a map along x and y, and the fewest poses for which there are so many; fewer poses have larger fields.
const FIELDS: [(usize, [usize; 2]); 3] = [(400, [12, 8]), (100, [6, 4]), (0, [3, 2])];
/// Fields of the scenario that say where the robot stands.
const STANDS: &str = "start.";

const POSE: [&str; 2] = ["lateral offset / mm", "heading / °"];
const WALL: [&str; 2] = ["distance of the wall from the camera / m", "heading / °"];

/// The maps of a study, cell by cell in the grid's order.
pub fn heat_maps(file: &AccuracyFile, trials: &Trials) -> Vec<CellMaps> {
    let axes = Axes::of(trials);
    let groups = groups(&file.cells);
    let is_one = groups.len() == 1;
    let maps_of = |group: Group| {
        let own = || trials.list.iter().filter(|trial| group.cells.contains(&trial.cell));
        let poses = own().count();
        let size = FIELDS.iter().find(|(least, _)| poses >= *least).map_or([1, 1], |(_, size)| *size);
        let of_pipeline = |pipeline: &Pipeline| {
            let readings: Vec<(&Trial, &Reading)> = own()
                .flat_map(|trial| trial.readings.iter().filter(|r| r.pipeline == *pipeline).map(move |r| (trial, r)))
                .collect();
            of_readings(*pipeline, &readings, &axes, size)
        };
        let named = |(name, map): (String, HeatMap)| match (is_one, group.cells.first()) {
            (false, Some(first)) => (format!("{first:03}-{name}"), map),
            _ => (name, map),
        };
        let maps = file.pipelines.iter().flat_map(of_pipeline).map(named).collect();
        CellMaps { label: group.label, cells: group.cells.len(), poses, maps }
    };
    groups.into_iter().take(MOST_MAPPED).map(maps_of).collect()
}

/// Cells that share their maps.
struct Group {
    label: String,
    cells: Vec<usize>,
}

fn groups(cells: &[Cell]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        let values = cell.values.iter().filter(|(path, _)| !path.starts_with(STANDS));
        let label = values.map(|(path, value)| format!("{path} = {value}")).collect::<Vec<_>>().join(", ");
        match groups.iter_mut().find(|group| group.label == label) {
            Some(group) => group.cells.push(index),
            None => groups.push(Group { label, cells: vec![index] }),
        }
    }
    groups
}

/// What the axes of all maps cover: all poses of the study.
struct Axes {
    lateral_mm: [f64; 2],
    heading_deg: [f64; 2],
    wall_m: [f64; 2],
}

impl Axes {
    fn of(trials: &Trials) -> Self {
        let walls = trials.list.iter().flat_map(|trial| &trial.readings).flat_map(|reading| {
            let counted = SIDES.into_iter().filter(|wall| reading.counts(*wall));
            counted.filter_map(|wall| Some(reading.score.wall(wall)?.camera_distance_m))
        });
        Self {
            lateral_mm: range(trials.list.iter().map(|trial| at(trial)[0])),
            heading_deg: range(trials.list.iter().map(|trial| at(trial)[1])),
            wall_m: range(walls),
        }
    }
}

/// From the least to the greatest, and never of no length.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [least, most] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)]);
    match least < most {
        true => [least, most],
        false if least.is_finite() => [least - 0.5, least + 0.5],
        false => [0.0, 1.0],
    }
}

/// Lateral offset in millimetres and heading in degrees.
fn at(trial: &Trial) -> [f64; 2] {
    [1e3 * trial.pose.lateral_m, trial.pose.heading_rad.to_degrees()]
}

/// The maps of a pipeline.
fn of_readings(pipeline: Pipeline, all: &[(&Trial, &Reading)], axes: &Axes, size: [usize; 2]) -> Vec<(String, HeatMap)> {
    let word = pipeline.word();
    let over_pose = [axes.lateral_mm, axes.heading_deg];
    let of_pose = |value: fn(&Reading) -> Option<f64>| -> Vec<[f64; 3]> {
        let shown = all.iter().filter(|(_, reading)| reading.shows_pose());
        let points = shown.filter_map(|(trial, reading)| {
            let [x, y] = at(trial);
            Some([x, y, value(reading)?])
        });
        points.collect()
    };
    let map = |title: &str, labels, ranges, mean, points: Vec<[f64; 3]>| {
        HeatMap::of(&format!("{word}: {title}"), labels, ranges, size, mean, points.into_iter())
    };
    let rms = Mean::RootOfSquares;
    let lateral = of_pose(|reading| reading.score.lateral_error_m.map(|error| 1e3 * error));
    let heading = of_pose(|reading| reading.score.heading_error_rad.map(f64::to_degrees));
    let walls = all.iter().flat_map(|(trial, reading)| {
        SIDES.into_iter().filter_map(move |wall| {
            let score = reading.score.wall(wall).filter(|_| reading.counts(wall))?;
            Some([score.camera_distance_m, at(trial)[1], 1e3 * score.distance_error_m?])
        })
    });
    let mut maps = vec![
        (format!("{word}-lateral"), map("lateral offset, RMS error / mm", POSE, over_pose, rms, lateral)),
        (format!("{word}-heading"), map("heading, RMS error / °", POSE, over_pose, rms, heading)),
        (
            format!("{word}-wall"),
            map("distance of a wall, RMS error / mm", WALL, [axes.wall_m, axes.heading_deg], rms, walls.collect()),
        ),
    ];
    let missed = of_pose(|reading| Some(if reading.is_answered() { 0.0 } else { 1.0 }));
    if missed.iter().any(|[.., value]| *value > 0.0) {
        maps.push((format!("{word}-missed"), map("share without an answer", POSE, over_pose, Mean::Plain, missed)));
    }
    maps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::carry_out;
    use std::ops::ControlFlow;

    const STUDY: &str = "format = 1\nkind = \"accuracy\"\nname = \"maps\"\npipelines = [\"robust\"]\n[poses]\ncount = 2\n\
                         heading_deg = [-4.0, 4.0]\n[grid]\nstart.lateral_m = [-0.05, 0.05]\nsensor.exposure = [4.0, 0.01]\n[duct]\n\
                         width_m = 0.6\nheight_m = 0.3\nrun = [{ straight_m = 20.0 }]\n[start]\ndistance_m = 8.0\n";

    /// What is seen in one cell is no other's: without light there is no answer anywhere, and the cell with light shows none of that.
    #[test]
    fn cells_are_kept_apart_and_poses_put_together() {
        let file = AccuracyFile::from_toml_str(STUDY).unwrap();
        let trials = carry_out(&file, 1, |_| ControlFlow::Continue(())).unwrap().unwrap();
        let cells = heat_maps(&file, &trials);
        let labels: Vec<_> = cells.iter().map(|cell| (cell.label.as_str(), cell.cells, cell.poses)).collect();
        assert_eq!(labels, [("sensor.exposure = 4.0", 2, 4), ("sensor.exposure = 0.01", 2, 4)]);
        let names = |cell: &CellMaps| cell.maps.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&cells[0]), ["000-robust-lateral", "000-robust-heading", "000-robust-wall"]);
        assert_eq!(names(&cells[1])[3], "001-robust-missed");
        let count = |cell: usize, map: usize| cells[cell].maps[map].1.values.iter().flatten().count();
        assert!(count(0, 0) >= 2 && count(1, 0) == 0, "{cells:?}");
        assert!(cells[1].maps[3].1.values.iter().flatten().all(|share| *share == 1.0));
        // Both poses of a cell and both lateral offsets of the grid are on its map, and all maps have the same axes.
        let [least, most] = cells[0].maps[0].1.ranges[0];
        assert!((least + 50.0).abs() < 1e-9 && (most - 50.0).abs() < 1e-9);
        assert_eq!(cells[0].maps[0].1.ranges, cells[1].maps[0].1.ranges);
    }
}
