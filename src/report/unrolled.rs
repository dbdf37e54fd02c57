//! The duct laid out straight along its centreline and widened: where across the duct the robot was.

use ductloop_duct::network::Network;

use super::plot::{Level, Plot, Series, Style};
use super::robot_plan;
use crate::record::{FrameRecord, RunRecord};
use crate::scenario::Scenario;

/// Frames whose outline is drawn; more are not seen.
const OUTLINES: usize = 800;

/// Lateral offset in millimetres over the distance along the centreline.
pub(super) fn plot(scenario: &Scenario, network: &Network, run: &RunRecord) -> Plot {
    let segments = &network.centreline.segments;
    let half_mm = segments.iter().map(|segment| segment.width_m.max(segment.end_width_m) * 500.0).fold(0.0, f64::max);
    let side = |sign: f64| {
        let points = segments.iter().flat_map(|segment| {
            let wall = |width_m: f64| Some(sign * width_m * 500.0);
            [(segment.start_m, wall(segment.width_m)), (segment.start_m + segment.length_m, wall(segment.end_width_m))]
        });
        let label = if sign > 0.0 { "wall" } else { "" };
        Series { label: label.to_owned(), class: "wall", style: Style::Line, points: points.collect() }
    };
    let base = run.frames.iter().map(|f| (f.truth.distance_m, Some(f.truth.lateral_m * 1e3))).collect();
    let mut series = vec![
        Series { label: "robot's outline".to_owned(), class: "swept", style: Style::Area, points: swept(scenario, run) },
        side(1.0),
        side(-1.0),
        Series { label: "base".to_owned(), class: "truth", style: Style::Line, points: base },
    ];
    let hits: Vec<_> = run
        .frames
        .windows(2)
        .filter(|pair| pair[1].collisions.count > pair[0].collisions.count)
        .map(|pair| (pair[1].truth.distance_m, Some(pair[1].truth.lateral_m * 1e3)))
        .collect();
    if !hits.is_empty() {
        series.push(Series { label: "collision".to_owned(), class: "collision", style: Style::Dots, points: hits });
    }
    Plot {
        x_label: "distance along the centreline / m".to_owned(),
        y_label: "lateral / mm".to_owned(),
        x: [0.0, network.centreline.length_m()],
        y: [-1.12 * half_mm, 1.12 * half_mm],
        height: 260.0,
        bands: Vec::new(),
        levels: vec![Level { y: 0.0, class: "centreline", label: "centreline".to_owned() }],
        series,
    }
}

/// The strip that the robot's outline covers: its leftmost points forward, its rightmost ones back.
fn swept(scenario: &Scenario, run: &RunRecord) -> Vec<(f64, Option<f64>)> {
    let corners = robot_plan::corners(&scenario.robot);
    let reach = |frame: &FrameRecord, sign: f64| {
        let (sin, cos) = libm::sincos(frame.truth.heading_rad);
        let furthest = corners.iter().map(|[x, y]| sign * (sin * x + cos * y)).fold(f64::NEG_INFINITY, f64::max);
        (frame.truth.distance_m, Some((frame.truth.lateral_m + sign * furthest) * 1e3))
    };
    let every = run.frames.len().div_ceil(OUTLINES).max(1);
    let shown = || run.frames.iter().step_by(every);
    let left: Vec<_> = shown().map(|frame| reach(frame, 1.0)).collect();
    let mut right: Vec<_> = shown().map(|frame| reach(frame, -1.0)).collect();
    right.reverse();
    [left, right].concat()
}
