//! The paper's figure 9 done again: estimated over actual positions by the points' index, a laser a panel, and each point's miss.

use std::fmt::Write;

use super::{GaugeResult, LaserResult, Measured, rms};
use crate::report::ticks::ticks;

const WIDTH: f64 = 980.0;
const LEFT: f64 = 62.0;
const GAP: f64 = 64.0;
const TOP: f64 = 64.0;
/// Heights of the two plots of a panel, and what lies between them.
const POSITIONS: f64 = 250.0;
const BETWEEN: f64 = 58.0;
const MISSES: f64 = 190.0;
const HEIGHT: f64 = TOP + POSITIONS + BETWEEN + MISSES + 52.0;
/// Decades of the misses, in mm.
const DECADES: [f64; 2] = [-3.0, 2.0];
/// Colours of x, y and z, distinct for colour-blind eyes too (Okabe and Ito).
const AXES: [(&str, &str); 3] = [("x", "#0072b2"), ("y", "#d55e00"), ("z", "#009e73")];
const INK: &str = "#1c2024";
const PAPER: &str = "#b3261e";
const OWN: &str = "#1f5fc4";

/// The figure as SVG that stands alone.
pub fn svg(result: &GaugeResult) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = draw(&mut out, result);
    out
}

fn draw(out: &mut String, result: &GaugeResult) -> std::fmt::Result {
    let count = result.lasers.len().max(1) as f64;
    let room = (WIDTH - LEFT - 14.0 - GAP * (count - 1.0)) / count;
    let size = format!(r#"viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}""#);
    writeln!(out, r#"<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12" fill="{INK}">"#)?;
    writeln!(out, r##"<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>"##)?;
    for (index, laser) in result.lasers.iter().enumerate() {
        panel(out, laser, LEFT + index as f64 * (room + GAP), room)?;
    }
    writeln!(out, "</svg>")
}

/// A plot's frame: where its values lie.
struct Frame {
    left: f64,
    width: f64,
    top: f64,
    height: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Frame {
    fn x(&self, value: f64) -> f64 {
        self.left + (value - self.x[0]) / (self.x[1] - self.x[0]) * self.width
    }

    fn y(&self, value: f64) -> f64 {
        let value = value.clamp(self.y[0], self.y[1]);
        self.top + self.height - (value - self.y[0]) / (self.y[1] - self.y[0]) * self.height
    }

    fn axes(&self, out: &mut String, label: &str, rows: &[(f64, String)]) -> std::fmt::Result {
        let (right, floor) = (self.left + self.width, self.top + self.height);
        for (value, text) in rows {
            let y = self.y(*value);
            writeln!(out, r##"<path d="M{:.1} {y:.1}H{right:.1}" stroke="#e3e6e8"/>"##, self.left)?;
            writeln!(out, r#"<text x="{:.1}" y="{:.1}" text-anchor="end">{text}</text>"#, self.left - 6.0, y + 4.0)?;
        }
        for value in ticks(self.x[0], self.x[1], 8).0 {
            writeln!(out, r#"<text x="{:.1}" y="{:.1}" text-anchor="middle">{value:.0}</text>"#, self.x(value), floor + 16.0)?;
        }
        writeln!(out, r##"<path d="M{0:.1} {1:.1}V{floor:.1}H{right:.1}" fill="none" stroke="#5e666f"/>"##, self.left, self.top)?;
        let middle = self.top + self.height / 2.0;
        writeln!(
            out,
            r#"<text transform="translate({:.1} {middle:.1}) rotate(-90)" text-anchor="middle">{label}</text>"#,
            self.left - 46.0
        )
    }
}

fn panel(out: &mut String, laser: &LaserResult, left: f64, width: f64) -> std::fmt::Result {
    let points: Vec<&Measured> = laser.calibration.iter().chain(&laser.test).collect();
    let x = [0.0, points.len() as f64 + 1.0];
    let values = || points.iter().flat_map(|point| point.actual_mm.iter().chain(point.estimated_mm.iter()).copied());
    let (low, high) = values().fold((0.0_f64, 1.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    let positions = Frame { left, width, top: TOP, height: POSITIONS, x, y: [low - 20.0, high + 20.0] };
    let rows: Vec<_> = ticks(positions.y[0], positions.y[1], 8).0.into_iter().map(|v| (v, format!("{:.0}", v + 0.0))).collect();
    writeln!(out, r#"<text x="{left:.1}" y="20" font-weight="bold">laser {}</text>"#, text(&laser.name))?;
    let mut at = left;
    for (name, colour) in AXES {
        writeln!(out, r#"<circle cx="{:.1}" cy="40" r="4.2" fill="none" stroke="{colour}"/>"#, at + 5.0)?;
        writeln!(out, r#"<path d="{}" stroke="{colour}"/>"#, cross(at + 5.0, 40.0))?;
        writeln!(out, r#"<text x="{:.1}" y="44">{name}</text>"#, at + 13.0)?;
        at += 34.0;
    }
    writeln!(
        out,
        r#"<text x="{:.1}" y="44" font-size="11">circle: actual, cross: estimated; shaded: calibrated with</text>"#,
        at + 4.0
    )?;
    let misses = Frame { left, width, top: TOP + POSITIONS + BETWEEN, height: MISSES, x, y: DECADES };
    for frame in [&positions, &misses] {
        let (from, to) = (frame.x(0.5), frame.x(laser.calibration.len() as f64 + 0.5));
        writeln!(
            out,
            r##"<rect x="{from:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="#eef1f4"/>"##,
            frame.top,
            to - from,
            frame.height
        )?;
    }
    positions.axes(out, "position / mm", &rows)?;
    for (index, point) in points.iter().enumerate() {
        let x = positions.x(index as f64 + 1.0);
        for (axis, (_, colour)) in AXES.iter().enumerate() {
            let [actual, estimated] = [point.actual_mm[axis], point.estimated_mm[axis]].map(|value| positions.y(value));
            writeln!(out, r#"<circle cx="{x:.1}" cy="{actual:.1}" r="4.2" fill="none" stroke="{colour}"/>"#)?;
            writeln!(out, r#"<path d="{}" stroke="{colour}"/>"#, cross(x, estimated))?;
        }
    }
    let decades: Vec<_> = (DECADES[0] as i32..=DECADES[1] as i32).map(|power| (f64::from(power), decade(power))).collect();
    misses.axes(out, "miss / mm", &decades)?;
    for (index, point) in points.iter().enumerate() {
        let y = misses.y(libm::log10(point.miss_mm().norm().max(1e-9)));
        writeln!(out, r#"<circle cx="{:.1}" cy="{y:.1}" r="3" fill="{OWN}"/>"#, misses.x(index as f64 + 1.0))?;
    }
    for (index, miss) in laser.paper_misses_mm.iter().enumerate() {
        let (x, y) = (misses.x(index as f64 + 1.0), misses.y(libm::log10(miss.max(1e-9))));
        writeln!(out, r#"<path d="{}" stroke="{PAPER}"/>"#, cross(x, y))?;
    }
    let own = laser.calibration.len() as f64 + 0.5;
    level(out, &misses, rms(&laser.calibration), [0.5, own])?;
    level(out, &misses, rms(&laser.test), [own, x[1]])?;
    let words = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.2} mm RMS"));
    let right = left + width;
    let (paper, test) = (words(laser.paper_rms_mm()), words(rms(&laser.test)));
    let at = [misses.y(1.0) - 10.0, misses.y(0.0) - 10.0];
    writeln!(
        out,
        r#"<text x="{right:.1}" y="{:.1}" text-anchor="end" fill="{PAPER}">crosses: the paper, {paper}</text>"#,
        at[0]
    )?;
    writeln!(
        out,
        r#"<text x="{right:.1}" y="{:.1}" text-anchor="end" fill="{OWN}">dots: here, {test} at other depths</text>"#,
        at[1]
    )?;
    let middle = left + width / 2.0;
    writeln!(out, r#"<text x="{middle:.1}" y="{:.1}" text-anchor="middle">index of measurement points</text>"#, HEIGHT - 14.0)
}

/// A dashed line at a miss.
fn level(out: &mut String, frame: &Frame, value: Option<f64>, x: [f64; 2]) -> std::fmt::Result {
    let Some(value) = value else { return Ok(()) };
    let (y, [from, to]) = (frame.y(libm::log10(value.max(1e-9))), x.map(|x| frame.x(x)));
    writeln!(out, r#"<path d="M{from:.1} {y:.1}H{to:.1}" stroke="{OWN}" stroke-dasharray="6 4"/>"#)
}

fn cross(x: f64, y: f64) -> String {
    format!("M{:.1} {:.1}l7 7m0 -7l-7 7", x - 3.5, y - 3.5)
}

fn decade(power: i32) -> String {
    match power {
        0.. => format!("1{}", "0".repeat(power as usize)),
        _ => format!("0.{}1", "0".repeat((-power - 1) as usize)),
    }
}

fn text(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
