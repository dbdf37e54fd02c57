//! How far each stage of the perception was from the truth, over time.

use ductloop_nav::perception::Wall;

use super::{Chart, Plot, Series, Style, Time, range};
use crate::output::words::number;
use crate::record::FrameRecord;

type Value = fn(&FrameRecord) -> Option<f64>;

/// The charts; none of a perception that tells nothing of its stages.
pub(super) fn all(time: &Time) -> Vec<Chart> {
    let told = |frame: &FrameRecord| frame.score.centres.claimed > 0;
    if !time.run.frames.iter().any(told) {
        return Vec::new();
    }
    vec![
        stage(
            time,
            "Stripes found",
            "share / %",
            [
                ("truly stripe, of what was taken for it", "estimate", |f| {
                    f.score.centres.precision().map(|share| 100.0 * share)
                }),
                ("found, of what is truly stripe", "truth", |f| f.score.centres.recall().map(|share| 100.0 * share)),
            ],
            "Precision and recall of the stripe centres, column by column.",
        ),
        stage(
            time,
            "Errors in the image",
            "RMS / px",
            [
                ("centres", "estimate", |f| f.score.centres.rms_px()),
                ("lines, at their ends", "truth", |f| f.score.lines.rms_px()),
            ],
            "Stripe centres and lines against where the stripes truly are.",
        ),
        stage(
            time,
            "Errors of the walls' distances",
            "measured − true / mm",
            [
                ("left", "left", |f| f.score.wall(Wall::Left)?.distance_error_m.map(|error| 1e3 * error)),
                ("right", "right", |f| f.score.wall(Wall::Right)?.distance_error_m.map(|error| 1e3 * error)),
            ],
            "Normal distance from the base's origin, of walls that are one plane.",
        ),
    ]
}

fn stage(time: &Time, title: &'static str, axis: &str, series: [(&str, &'static str, Value); 2], note: &str) -> Chart {
    let series: Vec<Series> = series
        .into_iter()
        .map(|(label, class, value)| Series { label: label.to_owned(), class, style: Style::Dots, points: time.points(value) })
        .collect();
    let mut note = note.to_owned();
    for one in &series {
        let values: Vec<f64> = one.points.iter().filter_map(|(_, y)| *y).collect();
        if !values.is_empty() {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            note += &format!(" Mean, {}: {}.", one.label, number(mean, 3));
        }
    }
    let all = series.iter().flat_map(|one| one.points.iter().filter_map(|(_, y)| *y)).collect();
    let y = range(Vec::new(), all, &[]);
    Chart::new(title, note, Plot { height: 180.0, ..time.plot(axis, y, Vec::new(), series) })
}
