//! What happened over time.

mod filter;
mod stages;

use super::plot::{Band, Level, Plot, Series, Style};
use crate::output::words::{metric_words, number};
use crate::record::{FrameRecord, RunRecord};
use crate::scenario::{Bound, Scenario};

/// A plot with its heading.
pub(super) struct Chart {
    pub(super) title: &'static str,
    pub(super) note: String,
    pub(super) plot: Plot,
}

impl Chart {
    fn new(title: &'static str, mut note: String, plot: Plot) -> Self {
        let beyond = |(x, y): &(f64, Option<f64>)| {
            (plot.x[0]..=plot.x[1]).contains(x) && y.is_some_and(|y| !(plot.y[0]..=plot.y[1]).contains(&y))
        };
        let count = plot.series.iter().flat_map(|series| &series.points).filter(|point| beyond(point)).count();
        if count > 0 {
            note += &format!(" {count} beyond the axis, drawn at its edge.");
        }
        Self { title, note, plot }
    }
}

/// The charts of a run, in the order of the page.
pub(super) fn all(scenario: &Scenario, run: &RunRecord) -> Vec<Chart> {
    let time = Time::of(scenario, run);
    let mut charts = Vec::new();
    for quantity in &QUANTITIES {
        charts.extend(time.errors(quantity));
    }
    charts.extend(QUANTITIES.iter().map(|quantity| time.estimate_errors(quantity)));
    charts.extend(filter::all(&time));
    charts.extend(stages::all(&time));
    charts.push(time.wheel_speeds());
    charts.push(time.speed());
    charts.push(time.clearance());
    charts
}

/// Something that is estimated and has a truth.
struct Quantity {
    title: &'static str,
    close_up: &'static str,
    estimate_title: &'static str,
    axis: &'static str,
    estimate_axis: &'static str,
    /// Metrics that bound it: RMS, largest, RMS of the estimate.
    metrics: [&'static str; 3],
    truth: fn(&FrameRecord) -> f64,
    estimate: fn(&FrameRecord) -> Option<f64>,
    /// The estimate's stated standard deviation.
    sigma: fn(&FrameRecord) -> Option<f64>,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        title: "Lateral error",
        close_up: "Lateral error, close up",
        estimate_title: "Error of the lateral estimate",
        axis: "lateral / mm",
        estimate_axis: "estimate − truth / mm",
        metrics: ["lateral_rms_m", "lateral_max_m", "lateral_estimate_rms_m"],
        truth: |f| f.truth.lateral_m,
        estimate: |f| f.measurement.lateral_m,
        sigma: |f| f.score.lateral_sigma_m,
    },
    Quantity {
        title: "Heading error",
        close_up: "Heading error, close up",
        estimate_title: "Error of the heading estimate",
        axis: "heading / °",
        estimate_axis: "estimate − truth / °",
        metrics: ["heading_rms_rad", "heading_max_rad", "heading_estimate_rms_rad"],
        truth: |f| f.truth.heading_rad,
        estimate: |f| f.measurement.heading_rad,
        sigma: |f| f.score.heading_sigma_rad,
    },
];

/// The run's time axis, and what is shaded along it.
struct Time<'a> {
    scenario: &'a Scenario,
    run: &'a RunRecord,
    bands: Vec<Band>,
    /// When the settling distance was behind the robot, if it ever was.
    settled_s: Option<f64>,
    end_s: f64,
}

impl<'a> Time<'a> {
    fn of(scenario: &'a Scenario, run: &'a RunRecord) -> Self {
        let end_s = run.sim_time_s.max(run.frames.last().map_or(0.0, |f| f.time_s)).max(1e-3);
        let settled_m = scenario.start.distance_m + scenario.pass.settle_m;
        let settled_s = run.frames.iter().find(|f| f.truth.distance_m >= settled_m).map(|f| f.time_s);
        let mut bands = Vec::new();
        let until_s = settled_s.unwrap_or(end_s);
        if until_s > 0.0 {
            bands.push(Band { x: [0.0, until_s], class: "settling", label: "settling".to_owned() });
        }
        for fault in scenario.faults.iter().filter(|fault| fault.at_s < end_s) {
            let to = fault.for_s.map_or(end_s, |length_s| (fault.at_s + length_s).min(end_s));
            let label = format!("fault: {}", fault.kind.label(&scenario.rig));
            bands.push(Band { x: [fault.at_s, to], class: "fault", label });
        }
        Self { scenario, run, bands, settled_s, end_s }
    }

    fn plot(&self, y_label: &str, y: [f64; 2], levels: Vec<Level>, series: Vec<Series>) -> Plot {
        let (x, bands) = ([0.0, self.end_s], self.bands.clone());
        Plot { x_label: "time / s".to_owned(), y_label: y_label.to_owned(), x, y, height: 230.0, bands, levels, series }
    }

    fn points(&self, value: impl Fn(&FrameRecord) -> Option<f64>) -> Vec<(f64, Option<f64>)> {
        self.run.frames.iter().map(|frame| (frame.time_s, value(frame))).collect()
    }

    fn settled(&self) -> impl Iterator<Item = &'a FrameRecord> {
        let from_s = self.settled_s.unwrap_or(f64::INFINITY);
        self.run.frames.iter().filter(move |frame| frame.time_s >= from_s)
    }

    /// Where the scenario bounds a metric, in the unit that it is shown in.
    fn bound(&self, metric: &str) -> Option<f64> {
        let criterion = self.scenario.pass.list.iter().find(|criterion| criterion.metric == metric)?;
        match criterion.bound {
            Bound::AtMost(bound) | Bound::AtLeast(bound) => Some(bound * metric_words(metric).per_si),
            Bound::Is(_) | Bound::Word(_) => None,
        }
    }

    /// Lines at plus and minus a metric's bound.
    fn levels(&self, metrics: &[(&str, &'static str, &str)]) -> Vec<Level> {
        let both = |(metric, class, label): &(&str, &'static str, &str)| {
            let bound = self.bound(metric)?;
            Some([bound, -bound].map(|y| Level { y, class, label: (*label).to_owned() }))
        };
        metrics.iter().filter_map(both).flatten().collect()
    }

    /// Truth and estimates; where the beginning dwarfs the rest, the rest again close up.
    fn errors(&self, quantity: &Quantity) -> Vec<Chart> {
        let per_si = metric_words(quantity.metrics[0]).per_si;
        let truth = |frame: &FrameRecord| (quantity.truth)(frame) * per_si;
        let estimate = |frame: &FrameRecord| (quantity.estimate)(frame).map(|value| value * per_si);
        let levels = self.levels(&[(quantity.metrics[0], "rms", "RMS bound"), (quantity.metrics[1], "bound", "bound")]);
        // The truth on top: where the estimates are good they would hide it.
        let series = vec![
            Series { label: "estimate".to_owned(), class: "estimate", style: Style::Dots, points: self.points(estimate) },
            Series { label: "truth".to_owned(), class: "truth", style: Style::Line, points: self.points(|f| Some(truth(f))) },
        ];
        let seen = self.run.frames.iter().filter(|frame| estimate(frame).is_some()).count();
        let note = format!("Estimated in {seen} of {} frames.", self.run.frames.len());
        let range = |frames: &mut dyn Iterator<Item = &FrameRecord>| {
            let frames: Vec<_> = frames.collect();
            let truths = frames.iter().map(|frame| truth(frame)).collect();
            let estimates = frames.iter().filter_map(|frame| estimate(frame)).collect();
            range(truths, estimates, &levels)
        };
        let whole = range(&mut self.run.frames.iter());
        let close = range(&mut self.settled());
        let plot = self.plot(quantity.axis, whole, levels.clone(), series.clone());
        let mut charts = vec![Chart::new(quantity.title, note, plot)];
        let dwarfed = whole[1] - whole[0] > 3.0 * (close[1] - close[0]);
        if let Some(from_s) = self.settled_s.filter(|from_s| dwarfed && *from_s < self.end_s) {
            let plot = Plot { x: [from_s, self.end_s], ..self.plot(quantity.axis, close, levels, series) };
            charts.push(Chart::new(quantity.close_up, "The same after settling.".to_owned(), plot));
        }
        charts
    }

    fn estimate_errors(&self, quantity: &Quantity) -> Chart {
        let words = metric_words(quantity.metrics[2]);
        let error =
            |frame: &FrameRecord| (quantity.estimate)(frame).map(|value| (value - (quantity.truth)(frame)) * words.per_si);
        let errors: Vec<f64> = self.settled().filter_map(error).collect();
        let note = if errors.is_empty() {
            "No estimate after settling.".to_owned()
        } else {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let spread = (errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors.len() as f64).sqrt();
            let [mean, spread] = [mean, spread].map(|value| words.with_unit(&number(value, 3)));
            format!("After settling: mean {mean}, standard deviation {spread}.")
        };
        let levels = self.levels(&[(quantity.metrics[2], "rms", "RMS bound")]);
        let all = self.run.frames.iter().filter_map(error).collect();
        let y = range(Vec::new(), all, &levels);
        let mut series =
            vec![Series { label: "error".to_owned(), class: "estimate", style: Style::Dots, points: self.points(error) }];
        for (sign, label) in [(1.0, "three stated deviations"), (-1.0, "")] {
            let points = self.points(|frame| (quantity.sigma)(frame).map(|sigma| sign * 3.0 * sigma * words.per_si));
            if points.iter().any(|(_, y)| y.is_some()) {
                series.push(Series { label: label.to_owned(), class: "sigma", style: Style::Line, points });
            }
        }
        Chart::new(quantity.estimate_title, note, self.plot(quantity.estimate_axis, y, levels, series))
    }

    fn wheel_speeds(&self) -> Chart {
        let period_s = 1.0 / f64::from(self.scenario.rates.camera_hz);
        type Side = (&'static str, &'static str, &'static str, fn(&ductloop_nav::messages::Sides) -> f64);
        const SIDES: [Side; 2] =
            [("left", "left commanded", "command left", |s| s.left), ("right", "right commanded", "command right", |s| s.right)];
        let mut series = Vec::new();
        for (label, label_commanded, class_commanded, of) in SIDES {
            let points = self.points(|f| Some(of(&f.truth.wheel_speed_rad_s)));
            series.push(Series { label: label.to_owned(), class: label, style: Style::Line, points });
            // A command acts one frame after the one that it was decided on.
            let commanded = self.run.frames.iter().map(|f| (f.time_s + period_s, Some(of(&f.command.wheel_speed_rad_s))));
            let (label, points) = (label_commanded.to_owned(), commanded.collect());
            series.push(Series { label, class: class_commanded, style: Style::Steps, points });
        }
        let values = series.iter().flat_map(|s| s.points.iter().filter_map(|(_, y)| *y)).collect();
        let y = range(values, Vec::new(), &[]);
        let note = "Commands are drawn from when they act, one frame after the frame that they answer.".to_owned();
        Chart::new("Wheel speeds", note, self.plot("wheel speed / rad/s", y, Vec::new(), series))
    }

    fn speed(&self) -> Chart {
        let points = self.points(|f| Some(f.truth.speed_m_s));
        let levels = vec![Level { y: self.scenario.speed_m_s, class: "nominal", label: "nominal".to_owned() }];
        let y = range(points.iter().filter_map(|(_, y)| *y).chain([0.0]).collect(), Vec::new(), &levels);
        let series = vec![Series { label: "truth".to_owned(), class: "truth", style: Style::Line, points }];
        let note = "Speed of the base along its own x axis.".to_owned();
        Chart::new("Speed", note, Plot { height: 180.0, ..self.plot("speed / m/s", y, levels, series) })
    }

    fn clearance(&self) -> Chart {
        let points = self.points(|f| Some(f.truth.clearance_m * 1e3));
        let bound = self.bound("min_clearance_m").map(|y| Level { y, class: "bound", label: "bound".to_owned() });
        let levels: Vec<Level> = bound.into_iter().collect();
        let y = range(points.iter().filter_map(|(_, y)| *y).chain([0.0]).collect(), Vec::new(), &levels);
        let series = vec![Series { label: "truth".to_owned(), class: "truth", style: Style::Line, points }];
        let note = "Smallest distance of the robot's outline to a wall, the ceiling or a solid.".to_owned();
        Chart::new("Clearance", note, Plot { height: 180.0, ..self.plot("clearance / mm", y, levels, series) })
    }
}

/// A range that shows every truth, all but a few stray estimates, and the bounds that are not far away.
fn range(truths: Vec<f64>, mut estimates: Vec<f64>, levels: &[Level]) -> [f64; 2] {
    estimates.retain(|value| value.is_finite());
    estimates.sort_by(f64::total_cmp);
    // One in fifty at either end may lie outside.
    let stray = estimates.len() / 50;
    let shown = &estimates[stray..estimates.len() - stray];
    let values = || truths.iter().chain(shown).copied().filter(|value| value.is_finite());
    let reach = values().map(f64::abs).fold(0.0, f64::max);
    let near = levels.iter().map(|level| level.y).filter(|y| y.abs() <= 4.0 * reach);
    let all: Vec<f64> = values().chain(near).collect();
    let (Some(least), Some(most)) = (all.iter().copied().reduce(f64::min), all.iter().copied().reduce(f64::max)) else {
        return [-1.0, 1.0];
    };
    // A flat series still needs an axis.
    let pad = (0.07 * (most - least)).max(0.02 * reach).max(1e-6);
    [least - pad, most + pad]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stray_estimates_and_far_bounds_do_not_squash_the_rest() {
        let mut estimates = vec![1.0; 99];
        estimates.push(500.0);
        let far = [Level { y: 90.0, class: "bound", label: String::new() }];
        let [least, most] = range(vec![-1.0, 0.0], estimates, &far);
        assert!((-1.2..-1.0).contains(&least) && (1.0..1.2).contains(&most), "{least} {most}");
        let near = [Level { y: 3.0, class: "bound", label: String::new() }];
        assert!(range(vec![-1.0, 1.0], Vec::new(), &near)[1] > 3.0);
        assert_eq!(range(Vec::new(), Vec::new(), &[]), [-1.0, 1.0]);
    }
}
