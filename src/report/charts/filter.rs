//! How far the estimator was from the truth, over time, and how far it said it might be.

use super::{Chart, Plot, Series, Style, Time, range};
use crate::output::words::number;
use crate::record::FrameRecord;

type Value = fn(&FrameRecord) -> Option<f64>;

/// The charts; none of a navigator without an estimator.
pub(super) fn all(time: &Time) -> Vec<Chart> {
    if !time.run.frames.iter().any(|frame| frame.estimate.is_some()) {
        return Vec::new();
    }
    vec![
        chart(
            time,
            "Filtered lateral offset",
            "filter − truth / mm",
            |f| f.estimate.map(|e| 1e3 * (e.lateral_m - f.truth.lateral_m)),
            |f| f.estimate.map(|e| 2e3 * e.deviation(0)),
        ),
        chart(
            time,
            "Filtered heading",
            "filter − truth / °",
            |f| f.estimate.map(|e| (e.heading_rad - f.truth.heading_rad).to_degrees()),
            |f| f.estimate.map(|e| 2.0 * e.deviation(1).to_degrees()),
        ),
    ]
}

fn chart(time: &Time, title: &'static str, axis: &str, error: Value, twice_sigma: Value) -> Chart {
    let line = |label: &str, class, points| Series { label: label.to_owned(), class, style: Style::Line, points };
    let series = vec![
        line("two standard deviations", "estimate", time.points(twice_sigma)),
        line("", "estimate", time.points(|f| twice_sigma(f).map(|value| -value))),
        line("error", "truth", time.points(error)),
    ];
    let inside = time.run.frames.iter().filter_map(|f| Some(error(f)?.abs() <= twice_sigma(f)?));
    let (count, all) = inside.fold((0usize, 0usize), |(count, all), is| (count + usize::from(is), all + 1));
    let note =
        format!("Within two standard deviations in {} % of the frames.", number(100.0 * count as f64 / all.max(1) as f64, 3));
    let errors = time.run.frames.iter().filter_map(error).collect();
    let settled = time.settled().filter_map(twice_sigma).flat_map(|value| [value, -value]).collect();
    let y = range(settled, errors, &[]);
    Chart::new(title, note, Plot { ..time.plot(axis, y, Vec::new(), series) })
}
