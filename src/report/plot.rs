//! A plot of series over a common axis, as SVG whose colours are classes of the page's style sheet.

use std::fmt::Write;

use super::thinning::{Point, thin};
use super::ticks::ticks;

/// Points that a series may have; on 900 px more are not seen.
const ROOM: usize = 1800;
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Label of the x axis, with its unit.
    pub x_label: String,
    /// Label of the y axis, with its unit.
    pub y_label: String,
    /// Range of x.
    pub x: [f64; 2],
    /// Range of y. Points beyond are drawn at the edge.
    pub y: [f64; 2],
    /// Height of the drawing; it is 1000 wide.
    pub height: f64,
    /// Ranges of x that are shaded.
    pub bands: Vec<Band>,
    /// Horizontal lines.
    pub levels: Vec<Level>,
    /// The series, the first one undermost.
    pub series: Vec<Series>,
}

/// A shaded range of x.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// From where to where.
    pub x: [f64; 2],
    /// Class of its colour.
    pub class: &'static str,
    /// Shown in the legend.
    pub label: String,
}

/// A horizontal line.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Where.
    pub y: f64,
    /// Class of its colour.
    pub class: &'static str,
    /// Shown in the legend; levels of one label share their entry.
    pub label: String,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line from point to point, broken at gaps.
    Line,
    /// A dot a point.
    Dots,
    /// Each value held until the next.
    Steps,
    /// A filled outline.
    Area,
}

/// A series.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Shown in the legend.
    pub label: String,
    /// Class of its colour.
    pub class: &'static str,
    /// How it is drawn.
    pub style: Style,
    /// (x, y); a missing y is a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Text that is safe within SVG.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Plot {
    fn at_x(&self, x: f64) -> f64 {
        LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]).max(f64::MIN_POSITIVE) * (WIDTH - LEFT - RIGHT)
    }

    fn at_y(&self, y: f64) -> f64 {
        let (floor, room) = (self.height - BOTTOM, self.height - BOTTOM - TOP);
        floor - (y.clamp(self.y[0], self.y[1]) - self.y[0]) / (self.y[1] - self.y[0]).max(f64::MIN_POSITIVE) * room
    }

    fn shown_bands(&self) -> impl Iterator<Item = &Band> {
        self.bands.iter().filter(|band| band.x[0] < self.x[1] && band.x[1] > self.x[0])
    }

    /// The drawing.
    pub fn svg(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.draw(&mut out);
        out
    }

    fn draw(&self, out: &mut String) -> std::fmt::Result {
        let height = self.height;
        let name = format!("{} over {}", self.y_label, self.x_label);
        writeln!(out, r#"<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{}">"#, escaped(&name))?;
        self.draw_bands(out)?;
        self.draw_axes(out)?;
        for level in self.levels.iter().filter(|level| (self.y[0]..=self.y[1]).contains(&level.y)) {
            let (y, class) = (self.at_y(level.y), level.class);
            writeln!(out, r#"<path class="level {class}" d="M{LEFT} {y:.1}H{:.1}"/>"#, WIDTH - RIGHT)?;
        }
        for series in &self.series {
            self.draw_series(out, series)?;
        }
        self.draw_legend(out)?;
        writeln!(out, "</svg>")
    }

    fn draw_bands(&self, out: &mut String) -> std::fmt::Result {
        for band in self.shown_bands() {
            let [from, to] = band.x.map(|x| self.at_x(x.clamp(self.x[0], self.x[1])));
            let (height, class) = (self.height - BOTTOM - TOP, band.class);
            // A fault of one frame must still be seen.
            let width = (to - from).max(1.5);
            let title = escaped(&band.label);
            write!(out, r#"<rect class="band {class}" x="{from:.1}" y="{TOP}" width="{width:.1}" height="{height:.1}">"#)?;
            writeln!(out, "<title>{title}</title></rect>")?;
        }
        Ok(())
    }

    fn draw_axes(&self, out: &mut String) -> std::fmt::Result {
        let (floor, right) = (self.height - BOTTOM, WIDTH - RIGHT);
        let (values, decimals) = ticks(self.x[0], self.x[1], 12);
        for value in values {
            let x = self.at_x(value);
            writeln!(out, r#"<path class="grid" d="M{x:.1} {TOP}V{floor:.1}"/>"#)?;
            writeln!(out, r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{value:.decimals$}</text>"#, floor + 16.0)?;
        }
        let count = ((floor - TOP) / 24.0).max(2.0) as usize;
        let (values, decimals) = ticks(self.y[0], self.y[1], count);
        for value in values {
            let y = self.at_y(value);
            let class = if value == 0.0 { "grid zero" } else { "grid" };
            writeln!(out, r#"<path class="{class}" d="M{LEFT} {y:.1}H{right:.1}"/>"#)?;
            // -0 would be shown as such.
            let value = value + 0.0;
            writeln!(out, r#"<text x="{:.1}" y="{:.1}" text-anchor="end">{value:.decimals$}</text>"#, LEFT - 7.0, y + 4.0)?;
        }
        writeln!(out, r#"<path class="axis" d="M{LEFT} {TOP}V{floor:.1}H{right:.1}"/>"#)?;
        let (middle, label) = ((LEFT + right) / 2.0, escaped(&self.x_label));
        writeln!(out, r#"<text x="{middle:.1}" y="{:.1}" text-anchor="middle">{label}</text>"#, self.height - 6.0)?;
        let (middle, label) = ((TOP + floor) / 2.0, escaped(&self.y_label));
        writeln!(out, r#"<text transform="translate(13 {middle:.1}) rotate(-90)" text-anchor="middle">{label}</text>"#)
    }

    fn draw_series(&self, out: &mut String, series: &Series) -> std::fmt::Result {
        let room = if series.style == Style::Area { usize::MAX } else { ROOM };
        let points: Vec<Point> = thin(&series.points, room)
            .into_iter()
            .map(|(x, y)| (x, y.filter(|y| y.is_finite())))
            .filter(|(x, _)| (self.x[0]..=self.x[1]).contains(x))
            .collect();
        let mut path = String::new();
        let mut pen_down = false;
        for (x, y) in points {
            let Some(y) = y else {
                pen_down = false;
                continue;
            };
            let (x, y) = (self.at_x(x), self.at_y(y));
            match (series.style, pen_down) {
                (Style::Dots, _) => write!(path, "M{x:.1} {y:.1}h0")?,
                (_, false) => write!(path, "M{x:.1} {y:.1}")?,
                (Style::Steps, true) => write!(path, "H{x:.1}V{y:.1}")?,
                (Style::Line | Style::Area, true) => write!(path, "L{x:.1} {y:.1}")?,
            }
            pen_down = true;
        }
        let style = match series.style {
            Style::Line | Style::Steps => "line",
            Style::Dots => "dots",
            Style::Area => "area",
        };
        writeln!(out, r#"<path class="{style} {}" d="{path}"/>"#, series.class)
    }

    fn draw_legend(&self, out: &mut String) -> std::fmt::Result {
        let series = self.series.iter().map(|s| (s.label.as_str(), s.class, s.style));
        let levels = self.levels.iter().map(|l| (l.label.as_str(), l.class, Style::Line));
        let bands = self.shown_bands().map(|b| (b.label.as_str(), b.class, Style::Area));
        let (mut x, mut seen) = (LEFT, Vec::new());
        for (label, class, style) in series.chain(levels).chain(bands) {
            if label.is_empty() || seen.contains(&label) {
                continue;
            }
            seen.push(label);
            match style {
                Style::Dots => writeln!(out, r#"<path class="dots key {class}" d="M{:.1} 14h0m8 0h0m8 0h0"/>"#, x + 3.0)?,
                Style::Area => writeln!(out, r#"<rect class="band key {class}" x="{x:.1}" y="8" width="22" height="12"/>"#)?,
                Style::Line | Style::Steps => {
                    let kind = if self.levels.iter().any(|l| l.label == label) { "level" } else { "line" };
                    writeln!(out, r#"<path class="{kind} {class}" d="M{x:.1} 14h22"/>"#)?;
                }
            }
            writeln!(out, r#"<text x="{:.1}" y="18">{}</text>"#, x + 28.0, escaped(label))?;
            // Text cannot be measured here: 7 a letter is the width of a wide sans-serif at 12.5.
            x += 28.0 + 7.0 * label.chars().count() as f64 + 18.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<Point>) -> Plot {
        Plot {
            x_label: "time / s".into(),
            y_label: "a < b".into(),
            x: [0.0, 10.0],
            y: [-1.0, 1.0],
            height: 200.0,
            bands: Vec::new(),
            levels: Vec::new(),
            series: vec![Series { label: "s".into(), class: "truth", style: Style::Line, points }],
        }
    }

    #[test]
    fn a_gap_breaks_the_line_and_what_lies_beyond_stays_at_the_edge() {
        let svg = plot(vec![(0.0, Some(0.0)), (1.0, None), (2.0, Some(5.0)), (3.0, Some(f64::NAN)), (4.0, Some(-1.0))]).svg();
        let line = svg.lines().find(|line| line.contains(r#"class="line truth" d="M64.0 95.0"#)).expect(&svg);
        assert_eq!(line.matches('M').count(), 3, "{line}");
        assert!(line.contains(" 30.0") && line.contains(" 160.0"), "{line}");
        assert!(svg.contains("a &lt; b") && !svg.contains("a < b"));
    }

    #[test]
    fn a_plot_of_nothing_has_finite_numbers() {
        let svg = Plot { x: [0.0, 0.0], y: [0.0, 0.0], ..plot(vec![(0.0, Some(0.0))]) }.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
