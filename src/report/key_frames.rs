//! What the camera saw and what the navigator made of it.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ductloop_nav::perception::Wall;
use minijinja::{Value, context};

use super::ReportError;
use crate::output::frames::state_word;
use crate::output::words::number;
use crate::picture::{LASER_COLOURS, UNASSIGNED, colour, preview_png};
use crate::record::{FrameRecord, KeyFrame, RunRecord};
use crate::scenario::Scenario;

fn css([red, green, blue]: [u8; 3]) -> String {
    format!("rgb({red},{green},{blue})")
}

/// Names and colours of the lasers.
pub(super) fn lasers(scenario: &Scenario) -> Vec<Value> {
    let lasers = scenario.rig.lasers.iter().zip(LASER_COLOURS.iter().cycle());
    lasers
        .map(|(laser, rgb)| context! { name => format!("laser {}", laser.name), colour => css(*rgb) })
        .chain([context! { name => "line that no laser was taken for", colour => css(UNASSIGNED) }])
        .collect()
}

/// Picture and captions of each key frame.
pub(super) fn figures(scenario: &Scenario, run: &RunRecord) -> Result<Vec<Value>, ReportError> {
    run.key_frames.spread().into_iter().map(|key| figure(scenario, run, key)).collect()
}

fn figure(scenario: &Scenario, run: &RunRecord, key: &KeyFrame) -> Result<Value, ReportError> {
    let (width, height) = (scenario.rig.camera.width_px, scenario.rig.camera.height_px);
    let png = STANDARD.encode(preview_png(&key.image)?);
    let mut svg = String::new();
    // Writing to a string cannot fail. Pixel (0, 0) is the centre of the first pixel.
    let _ = write!(svg, r#"<svg viewBox="-0.5 -0.5 {width} {height}" role="img" aria-label="frame {}">"#, key.frame);
    let _ = write!(svg, r#"<image x="-0.5" y="-0.5" width="{width}" height="{height}" href="data:image/png;base64,{png}"/>"#);
    for line in key.lines.iter().filter(|line| line.ends_px.iter().flatten().all(|x| x.is_finite())) {
        let ([[u0, v0], [u1, v1]], stroke) = (line.ends_px, css(colour(line)));
        let what = match line.assigned {
            Some((laser, wall)) => {
                let name = scenario.rig.lasers.get(laser).map_or("?", |laser| laser.name.as_str());
                match wall {
                    Wall::Left | Wall::Right => format!("laser {name} on the {} wall", wall.word()),
                    Wall::Floor | Wall::Ceiling => format!("laser {name} on the {}", wall.word()),
                    Wall::Ahead => format!("laser {name} on the wall ahead"),
                }
            }
            None => "no laser".to_owned(),
        };
        let title = super::plot::escaped(&format!("{what}: {} points, {:.2} px RMS", line.points, line.residual_px));
        let _ = write!(svg, r#"<g stroke="{stroke}" fill="{stroke}"><title>{title}</title>"#);
        let _ = write!(svg, r#"<path class="stripe" d="M{u0:.1} {v0:.1}L{u1:.1} {v1:.1}"/>"#);
        let _ = write!(svg, r#"<circle cx="{u0:.1}" cy="{v0:.1}" r="4"/><circle cx="{u1:.1}" cy="{v1:.1}" r="4"/></g>"#);
    }
    svg += "</svg>";
    let record = usize::try_from(key.frame).ok().and_then(|i| run.frames.get(i));
    Ok(context! {
        svg => Value::from_safe_string(svg),
        frame => key.frame,
        time => record.map(|r| number(r.time_s, 4)),
        distance => record.map(|r| number(r.truth.distance_m, 3)),
        state => record.map(|r| state_word(r.state)),
        lines => key.lines.len(),
        rows => record.map(rows),
    })
}

/// Truth, estimate and difference of lateral and heading error.
fn rows(record: &FrameRecord) -> Vec<Value> {
    let row = |name: &str, unit: &str, per_si: f64, truth: f64, estimate: Option<f64>| {
        // Rounded first, and zero added, so that no -0.00 is shown.
        let shown = |value: f64| format!("{:+.2}{unit}", (value * per_si * 100.0).round() / 100.0 + 0.0);
        let (seen, error) = (estimate.map(shown), estimate.map(|e| shown(e - truth)));
        context! { name => name, truth => shown(truth), estimate => seen, error => error }
    };
    let (truth, seen) = (&record.truth, &record.measurement);
    vec![
        row("lateral", "\u{a0}mm", 1e3, truth.lateral_m, seen.lateral_m),
        row("heading", "°", 1f64.to_degrees(), truth.heading_rad, seen.heading_rad),
    ]
}
