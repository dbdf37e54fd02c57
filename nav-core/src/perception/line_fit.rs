//! Each line that Hough selected, refitted by least squares to the sub-pixel centres of its points.
//!
//! The paper stops at Hough's bin. With INCRA I's two planes only 3.4 degrees apart, a bin of 1 px and 1 degree costs 19 degrees
//! of heading; the refit 0.4.

use super::hough::PolarLine;
use super::thinning::StripePoint;

/// A line y = slope x + intercept in scan coordinates, with the points that it rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanLine {
    /// Pixels across the stripe for one along it.
    pub slope: f64,
    /// y at x = 0, in pixels.
    pub intercept_px: f64,
    /// Least and greatest x of its points.
    pub extent_px: [f64; 2],
    /// How many points it rests on.
    pub points: usize,
    /// RMS distance of its points from it, along y, in pixels.
    pub residual_px: f64,
}

/// Which of a point's two centres to use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Centre {
    /// The middle of the binary run.
    Run,
    /// The centroid of the light.
    Light,
}

impl ScanLine {
    /// A Hough line as it stands. Lines up and down the columns (theta = 0) have no such form and give `None`.
    pub fn from_polar(line: &PolarLine) -> Option<Self> {
        let (s, c) = libm::sincos(line.theta_rad);
        (s.abs() > 1e-6).then(|| Self {
            slope: -c / s,
            intercept_px: line.r_px / s,
            extent_px: [0.0, 0.0],
            points: 0,
            residual_px: 0.0,
        })
    }

    /// y at x.
    pub fn at(&self, x_px: f64) -> f64 {
        self.slope * x_px + self.intercept_px
    }

    /// Distance of a point from the line, square to it, in pixels.
    pub fn distance(&self, point: &StripePoint) -> f64 {
        (point.run_centre_px - self.at(point.x_px)).abs() / (1.0 + self.slope * self.slope).sqrt()
    }
}

/// Marks in `line_of` the free points (value `FREE`) within `tolerance_px` of `line` as members of line `index`.
pub fn claim(points: &[StripePoint], line: &ScanLine, tolerance_px: f64, index: u8, line_of: &mut [u8]) {
    for (point, owner) in points.iter().zip(line_of) {
        if *owner == index {
            *owner = FREE;
        }
        if *owner == FREE && line.distance(point) <= tolerance_px {
            *owner = index;
        }
    }
}

/// Frees the points of line `index` beside which another line runs within `reach_px`: where stripes cross, the light of one
/// moves the centres of the other.
///
/// The other line counts where its own points are, and `reach_px` beyond.
pub fn free_crowded(points: &[StripePoint], lines: &[ScanLine], index: u8, reach_px: f64, line_of: &mut [u8]) {
    let own = lines[usize::from(index)];
    let others = || lines.iter().enumerate().filter(|(i, _)| *i != usize::from(index)).map(|(_, line)| line);
    for (point, owner) in points.iter().zip(line_of).filter(|(_, owner)| **owner == index) {
        let x = point.x_px;
        let crowded = others().any(|other| {
            let [first, last] = other.extent_px;
            (first - reach_px..=last + reach_px).contains(&x) && (other.at(x) - own.at(x)).abs() < reach_px
        });
        if crowded {
            *owner = FREE;
        }
    }
}

/// A point that belongs to no line.
pub const FREE: u8 = u8::MAX;

/// Least-squares line through the members of line `index`; `None` for fewer than three or all in one column.
pub fn fit(points: &[StripePoint], line_of: &[u8], index: u8, centre: Centre) -> Option<ScanLine> {
    let members = || points.iter().zip(line_of).filter(|(_, owner)| **owner == index).map(|(point, _)| point);
    let y = |p: &StripePoint| match centre {
        Centre::Run => p.run_centre_px,
        Centre::Light => p.centre_px,
    };
    let (mut n, mut sum_x, mut sum_y) = (0usize, 0.0, 0.0);
    let mut extent_px = [f64::INFINITY, f64::NEG_INFINITY];
    for p in members() {
        n += 1;
        sum_x += p.x_px;
        sum_y += y(p);
        extent_px = [extent_px[0].min(p.x_px), extent_px[1].max(p.x_px)];
    }
    if n < 3 {
        return None;
    }
    let (mean_x, mean_y) = (sum_x / n as f64, sum_y / n as f64);
    let (mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0);
    for p in members() {
        let (dx, dy) = (p.x_px - mean_x, y(p) - mean_y);
        sxx += dx * dx;
        sxy += dx * dy;
        syy += dy * dy;
    }
    if sxx < 1.0 {
        return None;
    }
    let slope = sxy / sxx;
    let residual_px = ((syy - slope * sxy).max(0.0) / n as f64).sqrt();
    Some(ScanLine { slope, intercept_px: mean_y - slope * mean_x, extent_px, points: n, residual_px })
}
