//! A heat map: a value over two quantities, as SVG that stands alone or in a page.

use std::fmt::Write;

use super::plot::escaped;
use super::ticks::ticks;

/// A heat map.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// What is shown, with its unit.
    pub title: String,
    /// Labels of the axes, with their units.
    pub labels: [String; 2],
    /// Range of each axis.
    pub ranges: [[f64; 2]; 2],
    /// Fields along x and y.
    pub size: [usize; 2],
    /// Values row by row from the least y on; `None` where there are none.
    pub values: Vec<Option<f64>>,
}

/// What a field shows of its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mean {
    /// Their mean.
    Plain,
    /// The root of the mean of their squares.
    RootOfSquares,
}

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 60.0;
const RIGHT: f64 = 80.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;
/// Steps of the colour scale beside the map.
const SCALE_STEPS: usize = 32;

/// Colours from least to most: dark blue to yellow, even in lightness, told apart by the colour-blind ("viridis", Smith and van der
/// Walt 2015, at quarters).
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];

impl HeatMap {
    /// Bins `points` (x, y, value) and takes the `mean` of the values in each field. Points beyond the ranges count in the outermost
    /// fields.
    pub fn of(
        title: &str,
        labels: [&str; 2],
        ranges: [[f64; 2]; 2],
        size: [usize; 2],
        mean: Mean,
        points: impl Iterator<Item = [f64; 3]>,
    ) -> Self {
        let mut sums = vec![(0.0, 0_usize); size[0] * size[1]];
        let bin = |axis: usize, at: f64| {
            let [from, to] = ranges[axis];
            let share = (at - from) / (to - from).max(f64::MIN_POSITIVE);
            ((share * size[axis] as f64).max(0.0) as usize).min(size[axis] - 1)
        };
        for [x, y, value] in points {
            let (sum, count) = &mut sums[bin(1, y) * size[0] + bin(0, x)];
            *sum += if mean == Mean::RootOfSquares { value * value } else { value };
            *count += 1;
        }
        let mean_of = |sum: f64, count: usize| match mean {
            Mean::Plain => sum / count as f64,
            Mean::RootOfSquares => (sum / count as f64).sqrt(),
        };
        let values = sums.into_iter().map(|(sum, count)| (count > 0).then(|| mean_of(sum, count))).collect();
        Self { title: title.to_owned(), labels: labels.map(str::to_owned), ranges, size, values }
    }

    /// The largest value; 1 where there is none above zero.
    fn most(&self) -> f64 {
        let most = self.values.iter().flatten().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
        if most > 0.0 { most } else { 1.0 }
    }

    /// The drawing.
    pub fn svg(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.draw(&mut out);
        out
    }

    fn draw(&self, out: &mut String) -> std::fmt::Result {
        let most = self.most();
        writeln!(
            out,
            r##"<svg xmlns="http://www.w3.org/2000/svg" class="heat" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{0}" font-family="sans-serif" font-size="12.5" fill="#777">"##,
            escaped(&self.title)
        )?;
        writeln!(out, r#"<text x="{LEFT}" y="18">{}</text>"#, escaped(&self.title))?;
        let room = [WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM];
        let field = [room[0] / self.size[0] as f64, room[1] / self.size[1] as f64];
        for (index, value) in self.values.iter().enumerate() {
            let (column, row) = (index % self.size[0], index / self.size[0]);
            let (x, y) = (LEFT + column as f64 * field[0], HEIGHT - BOTTOM - (row + 1) as f64 * field[1]);
            if let Some(value) = value.filter(|value| value.is_finite()) {
                let colour = colour(value / most);
                // Half a pixel more, so that no seams show.
                let (w, h) = (field[0] + 0.5, field[1] + 0.5);
                writeln!(
                    out,
                    r#"<rect x="{x:.1}" y="{y:.1}" width="{w:.1}" height="{h:.1}" fill="{colour}"><title>{value:.4}</title></rect>"#
                )?;
            }
        }
        self.draw_axes(out, room)?;
        let step = room[1] / SCALE_STEPS as f64;
        for i in 0..SCALE_STEPS {
            let y = HEIGHT - BOTTOM - (i + 1) as f64 * step;
            let colour = colour((i as f64 + 0.5) / SCALE_STEPS as f64);
            writeln!(
                out,
                r#"<rect x="{:.1}" y="{y:.1}" width="12" height="{:.1}" fill="{colour}"/>"#,
                WIDTH - RIGHT + 14.0,
                step + 0.5
            )?;
        }
        let (values, decimals) = ticks(0.0, most, 6);
        for value in values {
            let y = HEIGHT - BOTTOM - value / most * room[1] + 4.0;
            writeln!(out, r#"<text x="{:.1}" y="{y:.1}">{value:.decimals$}</text>"#, WIDTH - RIGHT + 31.0)?;
        }
        writeln!(out, "</svg>")
    }

    fn draw_axes(&self, out: &mut String, room: [f64; 2]) -> std::fmt::Result {
        let share = |axis: usize, value: f64| {
            let [from, to] = self.ranges[axis];
            (value - from) / (to - from).max(f64::MIN_POSITIVE)
        };
        let (values, decimals) = ticks(self.ranges[0][0], self.ranges[0][1], 6);
        for value in values {
            let (x, value) = (LEFT + share(0, value) * room[0], value + 0.0);
            writeln!(
                out,
                r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{value:.decimals$}</text>"#,
                HEIGHT - BOTTOM + 16.0
            )?;
        }
        let (values, decimals) = ticks(self.ranges[1][0], self.ranges[1][1], 6);
        for value in values {
            let (y, value) = (HEIGHT - BOTTOM - share(1, value) * room[1] + 4.0, value + 0.0);
            writeln!(out, r#"<text x="{:.1}" y="{y:.1}" text-anchor="end">{value:.decimals$}</text>"#, LEFT - 6.0)?;
        }
        let (x, y) = (LEFT + room[0] / 2.0, TOP + room[1] / 2.0);
        writeln!(out, r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{}</text>"#, HEIGHT - 8.0, escaped(&self.labels[0]))?;
        writeln!(
            out,
            r#"<text transform="translate(14 {y:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
            escaped(&self.labels[1])
        )
    }
}

/// The colour of a share from 0 to 1.
pub(super) fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let from = (at as usize).min(COLOURS.len() - 2);
    let mix = |i: usize| (COLOURS[from][i] + (COLOURS[from + 1][i] - COLOURS[from][i]) * (at - from as f64)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_binned_where_they_lie() {
        let points = [[0.1, 0.1, 3.0], [0.2, 0.2, 4.0], [0.9, 0.9, 1.0], [7.0, -7.0, 2.0]];
        let map = HeatMap::of("t", ["x", "y"], [[0.0, 1.0]; 2], [2, 2], Mean::RootOfSquares, points.into_iter());
        let lower_left = (12.5_f64).sqrt();
        assert_eq!(map.values, [Some(lower_left), Some(2.0), None, Some(1.0)]);
        let svg = map.svg();
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(svg.contains("#fde725") && !svg.contains("NaN"), "{svg}");
    }

    #[test]
    fn a_map_of_nothing_has_finite_numbers() {
        let map = HeatMap::of("t", ["x", "y"], [[0.0, 0.0]; 2], [3, 2], Mean::Plain, [[0.0, 0.0, f64::NAN]].into_iter());
        let svg = map.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
