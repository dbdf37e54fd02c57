//! Verdict, criteria, figures and circumstances of a run, as the page's template wants them.

use ductloop_duct::fitting::Shape;
use ductloop_duct::network::Network;
use minijinja::{Value, context};

use crate::metrics::Verdict;
use crate::output::words::{Held, METRICS, number, reason, sentence};
use crate::output::{Manifest, Summary};
use crate::scenario::Scenario;

/// Name and purpose of the scenario, and what it is made of in a line each.
pub(super) fn scenario(scenario: &Scenario, network: &Network) -> Value {
    let count = |wanted: fn(&Shape) -> bool| network.fittings.iter().filter(|fitting| wanted(&fitting.shape)).count();
    let straights = count(|shape| matches!(shape, Shape::Straight { .. }));
    let elbows = count(|shape| matches!(shape, Shape::RadiusElbow { .. } | Shape::MitredElbow { .. }));
    let others = network.fittings.len() - straights - elbows;
    let others = if others > 0 { format!(", {others} of other kinds") } else { String::new() };
    let plural = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let (width, height) = (number(scenario.duct.width_m * 1e3, 4), number(scenario.duct.height_m * 1e3, 4));
    let length = number(network.centreline.length_m(), 3);
    let start = &scenario.start;
    let lasers = plural(scenario.rig.lasers.len(), "laser");
    let camera = &scenario.rig.camera;
    context! {
        name => &scenario.name,
        about => &scenario.about,
        facts => vec![
            format!("{width} × {height} mm, {length} m, {}, {}{others}", plural(straights, "straight"), plural(elbows, "elbow")),
            format!("{} × {} px at {} Hz, {lasers}", camera.width_px, camera.height_px, scenario.rates.camera_hz),
            format!(
                "perception {}, law {}, {} m/s",
                scenario.perception.pipeline.word(),
                scenario.control.law.word(),
                number(scenario.speed_m_s, 3)
            ),
            format!(
                "from {} m, {:+} mm and {:+}° off the centreline",
                number(start.distance_m, 3),
                (start.lateral_m * 1e4).round() / 10.0,
                (start.heading_rad.to_degrees() * 100.0).round() / 100.0
            ),
        ],
    }
}

/// The verdict and why.
pub(super) fn verdict(scenario: &Scenario, summary: &Summary) -> Value {
    let kept = scenario.pass.list.iter().filter(|c| c.bound.holds(summary.metrics.get(c.metric))).count();
    let all = scenario.pass.list.len();
    let why = match summary.verdict {
        Verdict::Pass if all == 0 => "The scenario asks for nothing.".to_owned(),
        Verdict::Pass if all == 1 => "The one criterion was kept.".to_owned(),
        Verdict::Pass => format!("All {all} criteria were kept."),
        Verdict::Fail => format!("{kept} of {all} criteria were kept."),
        Verdict::Error => "The run could not go on.".to_owned(),
        Verdict::Timeout => "The run was not given the time to end.".to_owned(),
    };
    let mut reasons: Vec<String> = summary.message.iter().map(|message| sentence(message)).collect();
    reasons.extend(summary.reasons.iter().map(|r| reason(scenario, &summary.metrics, r)));
    context! { word => summary.verdict.word(), why => why, reasons => reasons }
}

/// Each criterion held against its figure.
pub(super) fn criteria(scenario: &Scenario, summary: &Summary) -> Vec<Value> {
    // Of a run that did not come to its end no criterion is judged.
    let judged = matches!(summary.verdict, Verdict::Pass | Verdict::Fail);
    let row = |held: Held| {
        context! {
            label => sentence(held.label),
            key => held.key,
            bound => held.bound,
            value => held.value,
            margin => held.margin,
            // The bar is full where the bound is; what lies far past it is cut.
            percent => held.share.map(|share| number((share * 100.0).min(150.0) / 1.5, 3)),
            kept => held.kept,
            judged => judged,
        }
    };
    scenario.pass.list.iter().map(|criterion| row(Held::of(criterion, &summary.metrics))).collect()
}

/// Every figure of the summary.
pub(super) fn metrics(summary: &Summary) -> Vec<Value> {
    METRICS
        .iter()
        .map(|words| {
            let value = words.show(summary.metrics.get(words.metric), 4);
            context! { label => sentence(words.label), name => words.metric, value => value }
        })
        .collect()
}

/// What made the run, and the command that repeats it.
pub(super) fn details(scenario: &Scenario, summary: &Summary, manifest: &Manifest) -> Vec<Value> {
    let row = |name: &str, value: String| context! { name => name, value => value };
    let host = &manifest.host;
    let cpu = host.cpu.as_ref().map_or(String::new(), |cpu| format!(", {cpu}"));
    let cores = host.cores.map_or(String::new(), |cores| format!(", {cores} hardware threads"));
    let mut rows = vec![row("seed", summary.seed.to_string()), row("renderer", summary.renderer.clone())];
    if let Some(adapter) = &manifest.adapter {
        let software = if adapter.software { ", computes on the processor" } else { "" };
        rows.push(row("adapter", format!("{} ({}, {}{software})", adapter.name, adapter.backend, adapter.driver)));
    }
    rows.push(row("run hash", summary.run_hash.clone().unwrap_or_else(|| "none: the run did not come to its end".to_owned())));
    if let Some(navigator) = &manifest.navigator {
        rows.push(row("navigator", format!("{navigator} (not the robot's own: law and perception above are not used)")));
    }
    rows.push(row("ductloop", manifest.version.clone()));
    rows.push(row("begun", manifest.started_at.clone()));
    rows.push(row("host", format!("{} {}{cpu}{cores}; {} used", host.os, host.arch, manifest.threads)));
    let rates = scenario.rates;
    rows.push(row(
        "rates",
        format!("physics {} Hz, wheel controller {} Hz, camera {} Hz", rates.physics_hz, rates.wheel_control_hz, rates.camera_hz),
    ));
    rows.push(row("repeat", format!("ductloop run scenario.toml --renderer {}", summary.renderer)));
    rows
}
