//! The report's section on what lay ahead: the confusion matrices, the distance to the next thing over time with what was named, and a
//! row a thing.

use std::fmt::Write;

use minijinja::{Value, context};

use super::confusion_table;
use super::plot::{Plot, Series, Style, escaped};
use crate::ahead_scores::confusion::NOTHING;
use crate::ahead_scores::{AheadScores, FittingScore, Glance};
use crate::output::words::number;
use crate::record::RunRecord;

/// Farther things are left off the chart, in metres.
const FAR_M: f64 = 3.0;
/// Margins and width of plots: the strip below shares their axis.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 12.0;
const WIDTH: f64 = 1000.0;
/// The strip's rows, and how wide a letter is in them.
const ROW: f64 = 24.0;
const LETTER: f64 = 7.4;

/// The section; nothing where nothing lay ahead and nothing was named.
pub(super) fn section(run: &RunRecord, scores: &AheadScores) -> Value {
    if scores.fittings.is_empty() && scores.false_alarms.unwrap_or(0) == 0 {
        return Value::from(());
    }
    let drawing = |svg: String| Value::from_safe_string(svg);
    let rows: Vec<Value> = scores.fittings.iter().map(row).collect();
    context! {
        by_fittings => drawing(confusion_table::svg(&scores.by_fittings)),
        by_frames => drawing(confusion_table::svg(&scores.by_frames)),
        chart => drawing(chart(run).svg()),
        strip => drawing(strip(run)),
        false_alarms => scores.false_alarms,
        rows => rows,
    }
}

fn row(score: &FittingScore) -> Value {
    let mm = |error: Option<f64>| error.map_or(String::new(), |error_m| format!("{} mm", number(error_m * 1e3, 2)));
    context! {
        name => score.name.clone(),
        truth => score.truth,
        named => score.named,
        right => score.right,
        entered => number(score.entered_s, 3),
        visible => number(score.visible_m, 3),
        detected => if score.right { format!("{} m, {} widths", number(score.detected_m, 3), number(score.detected_widths, 2)) } else { String::new() },
        latency => if score.right { format!("{} s", number(score.latency_s, 2)) } else { String::new() },
        distance => mm(score.distance_error_m),
        width => mm(score.width_error_m),
        radius => mm(score.radius_error_m),
    }
}

fn end_s(run: &RunRecord) -> f64 {
    run.frames.last().map_or(0.0, |frame| frame.time_s).max(1e-3)
}

/// Distance to the next thing, by the truth and as it was named.
fn chart(run: &RunRecord) -> Plot {
    let mut truth: Vec<(f64, Option<f64>)> = Vec::new();
    let mut before = None;
    for frame in &run.frames {
        let thing = frame.true_ahead.map(|ahead| ahead.thing);
        if before.is_some_and(|before| before != thing) {
            truth.push((frame.time_s, None));
        }
        before = Some(thing);
        let distance_m = frame.true_ahead.map(|ahead| ahead.distance_m);
        truth.push((frame.time_s, distance_m.filter(|distance_m| *distance_m <= FAR_M)));
    }
    let named = |right: bool| -> Vec<(f64, Option<f64>)> {
        let glances = run.frames.iter().filter_map(Glance::of);
        let points = glances.filter(|glance| !glance.truth.is_inside && glance.is_right() == right);
        points.filter_map(|glance| Some((glance.time_s, Some(glance.thing_named()?.distance_m.min(FAR_M))))).collect()
    };
    let series = |label: &str, class, style, points| Series { label: label.to_owned(), class, style, points };
    Plot {
        x_label: "time / s".to_owned(),
        y_label: "ahead of the base / m".to_owned(),
        x: [0.0, end_s(run)],
        y: [0.0, FAR_M],
        height: 260.0,
        bands: Vec::new(),
        levels: Vec::new(),
        series: vec![
            series("true distance to the next thing", "truth", Style::Line, truth),
            series("named rightly", "nominal", Style::Dots, named(true)),
            series("named otherwise", "bound", Style::Dots, named(false)),
        ],
    }
}

/// What was true and what was named, over the chart's time axis.
fn strip(run: &RunRecord) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw_strip(&mut out, run);
    out
}

fn draw_strip(out: &mut String, run: &RunRecord) -> std::fmt::Result {
    let height = 2.0 * ROW + 8.0;
    writeln!(
        out,
        r#"<svg class="strip" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="What was true and what was named">"#
    )?;
    let scale = (WIDTH - LEFT - RIGHT) / end_s(run);
    let words = |word: fn(&Glance) -> &'static str| -> Vec<(f64, &'static str)> {
        run.frames.iter().map(|frame| (frame.time_s, Glance::of(frame).map_or("off-path", |glance| word(&glance)))).collect()
    };
    let truth = words(|glance| if glance.truth.is_inside { "inside" } else { glance.true_class().word() });
    let named = words(|glance| glance.named.map_or(NOTHING, |named| named.fitting.word()));
    draw_row(out, "true", 2.0, scale, &truth)?;
    draw_row(out, "named", 4.0 + ROW, scale, &named)?;
    writeln!(out, "</svg>")
}

/// A row of the strip from `y` on: times and what was the case from then on.
fn draw_row(out: &mut String, label: &str, y: f64, scale: f64, words: &[(f64, &'static str)]) -> std::fmt::Result {
    let middle = y + ROW / 2.0 + 4.0;
    writeln!(out, r#"<text x="{:.1}" y="{middle:.1}" text-anchor="end">{label}</text>"#, LEFT - 7.0)?;
    let mut from = 0;
    for piece in words.chunk_by(|a, b| a.1 == b.1) {
        let (from_s, word) = piece[0];
        let (to_s, _) = words[(from + piece.len()).min(words.len() - 1)];
        let (x, wide) = (LEFT + from_s * scale, (to_s - from_s) * scale);
        let title = escaped(&format!("{word}: {} to {} s", number(from_s, 3), number(to_s, 3)));
        write!(out, r#"<rect class="is-{word}" x="{x:.1}" y="{y:.1}" width="{wide:.1}" height="{ROW}">"#)?;
        writeln!(out, "<title>{title}</title></rect>")?;
        if word.len() as f64 * LETTER < wide {
            let x = x + wide / 2.0;
            writeln!(out, r#"<text class="on-{word}" x="{x:.1}" y="{middle:.1}" text-anchor="middle">{word}</text>"#)?;
        }
        from += piece.len();
    }
    Ok(())
}
