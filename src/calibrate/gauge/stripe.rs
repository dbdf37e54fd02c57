//! A stripe's centre at one place of an image in which nothing else is as bright.
//!
//! In each line of pixels across the stripe: the peak of the light, a level background from either side of it, and the centroid of what
//! stands above that, within a window about the centroid itself (so that the window draws it nowhere). A straight line through the
//! centroids of the neighbouring lines, those that lie off it left out, then gives the centre in the line that was asked for.
//! For stripes on a flat matte face before a dark room (ground that slopes by a thousandth of the peak a pixel moves a centre by some
//! hundredths of a pixel); the navigator's own extraction is [`ductloop_nav::perception`]'s.

use ductloop_nav::messages::Pixels;

use crate::grey_image::GreyImage;

/// Which way lines of pixels run across the stripe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Down the columns: a centre has a whole u.
    Columns,
    /// Along the rows: a centre has a whole v.
    Rows,
}

/// A centre that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centre {
    /// Where it is across the stripe, in pixels.
    pub at_px: f64,
    /// Its standard deviation out of the scatter of the neighbouring lines.
    pub sigma_px: f64,
    /// How many lines it rests on.
    pub lines: usize,
}

/// Least height of a peak above its background, in DN of 8 bits.
const LEAST_DN: f64 = 10.0;
/// Half the window of the centroid, as a share of the full width at half maximum: out to 1/50 of a Gaussian's height.
const WINDOW: f64 = 1.2;
/// Where the background is taken from, as shares of the same width: beyond the Gaussian.
const BACKGROUND: [f64; 2] = [1.5, 2.5];
/// Rounds of the centroid within its window.
const ROUNDS: usize = 8;
/// Fewest lines that a centre rests on.
const LEAST_LINES: usize = 7;
/// Centroids farther off the line than so many robust deviations are left out.
const OFF: f64 = 3.5;

/// The centre of the stripe in line `index` of pixels, from the lines within `window` of it.
///
/// `None` where fewer than seven lines show one.
pub fn centre(image: &GreyImage, across: Across, index: usize, window: usize) -> Option<Centre> {
    let [width, height] = image.size_px();
    let lines = if across == Across::Columns { width } else { height };
    let near = index.saturating_sub(window)..(index + window + 1).min(lines);
    let mut profile = Vec::new();
    let mut points: Vec<(f64, f64)> = Vec::new();
    for line in near {
        load(image, across, line, &mut profile);
        if let Some(at) = centroid(&profile) {
            points.push((line as f64 - index as f64, at));
        }
    }
    fit(&mut points)
}

/// A line of pixels, in DN of 8 bits.
fn load(image: &GreyImage, across: Across, line: usize, profile: &mut Vec<f64>) {
    let ([width, height], scale) = (image.size_px(), 255.0 / f64::from(image.bits().max_dn()));
    let value = |at: usize| match image.pixels() {
        Pixels::Grey8(values) => f64::from(values[at]),
        Pixels::Grey16(values) => f64::from(values[at]),
    };
    profile.clear();
    match across {
        Across::Columns => profile.extend((0..height).map(|row| value(row * width + line) * scale)),
        Across::Rows => profile.extend((0..width).map(|column| value(line * width + column) * scale)),
    }
}

/// The centroid of the brightest peak.
fn centroid(profile: &[f64]) -> Option<f64> {
    let smooth = |at: usize| profile[at - 2..=at + 2].iter().sum::<f64>() / 5.0;
    let peak = (2..profile.len().checked_sub(2)?).max_by(|a, b| smooth(*a).total_cmp(&smooth(*b)))?;
    let mut sorted = profile.to_vec();
    sorted.sort_by(f64::total_cmp);
    let floor = sorted[sorted.len() / 2];
    let half = floor + (smooth(peak) - floor) / 2.0;
    if smooth(peak) - floor < LEAST_DN {
        return None;
    }
    let left = (2..peak).rev().find(|at| smooth(*at) < half)?;
    let right = (peak..profile.len() - 2).find(|at| smooth(*at) < half)?;
    let width = (right - left) as f64;
    let mut at = (right + left) as f64 / 2.0;
    for _ in 0..ROUNDS {
        let [near, far] = BACKGROUND.map(|share| share * width);
        // At the image's edge one side alone must do.
        let background = match (mean(profile, at - far, at - near), mean(profile, at + near, at + far)) {
            (Some(before), Some(after)) => (before + after) / 2.0,
            (before, after) => before.or(after)?,
        };
        let (mut light, mut moment) = (0.0, 0.0);
        for (pixel, share) in shares(at - WINDOW * width, at + WINDOW * width) {
            let above = (profile.get(pixel)? - background) * share;
            light += above;
            moment += above * pixel as f64;
        }
        let next = moment / light;
        let near = light > 0.0 && (next - at).abs() < width;
        if !near {
            return None;
        }
        at = next;
    }
    Some(at)
}

/// The pixels between two places and the share of each; a pixel reaches half to either side of its centre.
fn shares(from: f64, to: f64) -> impl Iterator<Item = (usize, f64)> {
    let first = (from + 0.5).floor();
    let count = ((to + 0.5).floor() - first).max(0.0) as usize;
    (0..=count).map(move |i| {
        let pixel = first + i as f64;
        let share = (to.min(pixel + 0.5) - from.max(pixel - 0.5)).max(0.0);
        // Beyond the line there are none: usize::MAX names no pixel.
        (if pixel < 0.0 { usize::MAX } else { pixel as usize }, share)
    })
}

fn mean(profile: &[f64], from: f64, to: f64) -> Option<f64> {
    let (mut sum, mut total) = (0.0, 0.0);
    for (pixel, share) in shares(from, to) {
        sum += profile.get(pixel)? * share;
        total += share;
    }
    (total > 0.0).then(|| sum / total)
}

/// The straight line through (line, centroid), at line 0.
fn fit(points: &mut Vec<(f64, f64)>) -> Option<Centre> {
    for round in 0.. {
        if points.len() < LEAST_LINES {
            return None;
        }
        let count = points.len() as f64;
        let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
        let sxx: f64 = points.iter().map(|(x, _)| (x - mx) * (x - mx)).sum();
        let sxy: f64 = points.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
        let slope = sxy / sxx;
        let off = |(x, y): &(f64, f64)| (y - my - slope * (x - mx)).abs();
        let mut sizes: Vec<_> = points.iter().map(off).collect();
        let squares: f64 = sizes.iter().map(|size| size * size).sum();
        let middle = sizes.len() / 2;
        let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let before = points.len();
        points.retain(|point| off(point) <= OFF * (median / 0.674_489_75).max(1e-6));
        if points.len() == before || round == 4 {
            let deviation = (squares / (count - 2.0)).sqrt();
            let sigma_px = deviation * (1.0 / count + mx * mx / sxx).sqrt();
            return Some(Centre { at_px: my - slope * mx, sigma_px, lines: before });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use ductloop_sensor::optics::Bits;

    /// A slanted Gaussian stripe on level ground, of 12 bits so that rounding does not count.
    fn stripe(across: Across, slope: f64) -> GreyImage {
        let (width, height) = (64, 80);
        let value = |pixel: usize| {
            let (u, v) = ((pixel % width) as f64, (pixel / width) as f64);
            let (along, over) = if across == Across::Columns { (u, v) } else { (v, u) };
            let away = (over - 30.3 - slope * (along - 20.0)) / 2.5;
            (160.0 + 1500.0 * libm::exp(-away * away / 2.0)) as u16
        };
        let values: Vec<_> = (0..width * height).map(value).collect();
        GreyImage::of([width, height], Bits::Twelve, &values).expect("so many values")
    }

    #[test]
    fn a_slanted_stripe_is_found_either_way() {
        for across in [Across::Columns, Across::Rows] {
            for slope in [0.0, 0.3, -0.4] {
                let found = centre(&stripe(across, slope), across, 20, 10).expect("a stripe");
                // Cut off to whole values of 1500.
                assert!((found.at_px - 30.3).abs() < 0.02, "{across:?} {slope}: {found:?}");
            }
        }
    }

    #[test]
    fn there_is_none_in_a_blank_image_or_beyond_its_edge() {
        let blank = GreyImage::of([64, 80], Bits::Eight, &[9; 64 * 80]).expect("so many values");
        assert_eq!(centre(&blank, Across::Columns, 20, 10), None);
        assert_eq!(centre(&stripe(Across::Columns, 0.0), Across::Columns, 500, 10), None);
    }
}
