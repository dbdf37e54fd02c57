//! `report.html`: one page that shows what a run did and why its verdict is what it is. It needs no script and no other file.
//!
//! - `verdict`: criteria and figures as tables;
//! - `plan`: the robot's path on the plan of the duct, to scale (`floor_plan`: what plans have in common); `unrolled`: the same along the centreline, widened;
//! - `charts`: errors, estimates, wheel speeds and clearance over time, drawn by [`plot`] with the [`ticks`] of its axes;
//! - `key_frames`: what the camera saw and what the navigator made of it;
//! - `ahead`: what lay ahead against what it was named, with the `confusion_table`s;
//! - `survey`: what lies on the floor;
//! - `states`: how long the navigator was how sure, and why;
//! - `thinning`: long series without the points that nobody sees;
//! - [`accuracy`]: the page of an accuracy study, with the [`heat_map`]s of `accuracy_maps`;
//! - [`sweep`]: that of a sweep; [`tune`]: that of a study.
//!
//! Colours are names in the page's style sheet, so that light, dark and printed pages each have their own.

pub mod accuracy;
pub mod accuracy_maps;
mod ahead;
mod charts;
mod confusion_table;
mod floor_plan;
pub mod heat_map;
mod key_frames;
pub mod network_plan;
mod plan;
pub mod plot;
mod robot_plan;
mod states;
mod survey;
pub mod sweep;
mod thinning;
pub mod ticks;
pub mod tune;
mod unrolled;
mod verdict;

use minijinja::{Environment, Value, context};

use crate::output::{Manifest, Summary};
use crate::record::RunRecord;
use crate::scenario::Scenario;

/// Why a report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The duct cannot be drawn. A scenario that was read or validated never gives this.
    #[error("the duct cannot be assembled: {0}")]
    Network(#[from] crate::scenario::DuctError),
    /// A key frame cannot be shown.
    #[error("a picture of a frame cannot be made: {0}")]
    Picture(#[from] image::ImageError),
    /// The page's template failed.
    #[error("the page cannot be made: {0}")]
    Page(#[from] minijinja::Error),
}

const PAGE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");

/// The report of a run.
///
/// # Errors
/// Where a key frame has another size than the scenario's camera, or the duct cannot be assembled.
pub fn html(scenario: &Scenario, run: &RunRecord, summary: &Summary, manifest: &Manifest) -> Result<String, ReportError> {
    let network = scenario.duct.network()?;
    let mut environment = Environment::new();
    environment.add_template("report.html", PAGE)?;
    let page = environment.get_template("report.html")?;
    let drawing = |svg: String| Value::from_safe_string(svg);
    let charts: Vec<Value> = charts::all(scenario, run)
        .into_iter()
        .map(|chart| context! { title => chart.title, note => chart.note, svg => drawing(chart.plot.svg()) })
        .collect();
    Ok(page.render(context! {
        style => drawing(STYLE.to_owned()),
        scenario => verdict::scenario(scenario, &network),
        verdict => verdict::verdict(scenario, summary),
        criteria => verdict::criteria(scenario, summary),
        metrics => verdict::metrics(summary),
        plan => drawing(plan::svg(scenario, &network, run)),
        unrolled => drawing(unrolled::plot(scenario, &network, run).svg()),
        states => states::rows(scenario, run),
        ahead => ahead::section(run, &summary.ahead),
        deposits => survey::section(scenario, run),
        charts => charts,
        lasers => key_frames::lasers(scenario),
        key_frames => key_frames::figures(scenario, run)?,
        details => verdict::details(scenario, summary, manifest),
    })?)
}
