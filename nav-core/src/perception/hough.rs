//! The Hough transform: points to lines x cos(theta) + y sin(theta) = r (section 4.1).
//!
//! Lines are taken one at a time, the one with most votes first; its points' votes are withdrawn before the next is sought, so
//! that a strong stripe does not hide a weak one beside it.

use std::f64::consts::PI;

use super::thinning::StripePoint;

/// A line x cos(theta) + y sin(theta) = r in scan coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarLine {
    /// Distance from the image's origin, in pixels, signed.
    pub r_px: f64,
    /// Direction of the line's normal, in radians.
    pub theta_rad: f64,
    /// Points that voted for it.
    pub votes: u32,
}

/// Resolution and range of the transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoughGrid {
    /// Size of a bin in r.
    pub r_px: f64,
    /// Size of a bin in theta.
    pub theta_rad: f64,
    /// Steepest line sought, as the angle between it and the rows.
    pub max_slope_rad: f64,
}

/// The accumulator.
#[derive(Clone, Debug)]
pub struct Hough {
    grid: HoughGrid,
    /// (cos, sin) over the bin size of r, for each theta.
    directions: Vec<[f32; 2]>,
    first_theta_rad: f64,
    r_bins: usize,
    /// Added to r over its bin size to make an index.
    r_offset: f32,
    votes: Vec<u16>,
}

impl Hough {
    /// An accumulator for images of up to `width` by `height` in scan coordinates.
    pub fn new(grid: HoughGrid, width: usize, height: usize) -> Self {
        let span = grid.max_slope_rad.clamp(grid.theta_rad, PI / 2.0);
        let thetas = (2.0 * span / grid.theta_rad).floor() as usize + 1;
        let first_theta_rad = PI / 2.0 - span;
        let directions = (0..thetas)
            .map(|k| {
                let (s, c) = libm::sincos(first_theta_rad + k as f64 * grid.theta_rad);
                [(c / grid.r_px) as f32, (s / grid.r_px) as f32]
            })
            .collect();
        let diagonal = ((width * width + height * height) as f64).sqrt();
        let half = (diagonal / grid.r_px).ceil() as usize + 1;
        let r_bins = 2 * half + 1;
        Self { grid, directions, first_theta_rad, r_bins, r_offset: half as f32 + 0.5, votes: vec![0; thetas * r_bins] }
    }

    /// Withdraws all votes.
    pub fn clear(&mut self) {
        self.votes.fill(0);
    }

    /// Lets a point vote for every line through it.
    pub fn vote(&mut self, point: &StripePoint) {
        self.each_bin(point, |votes| *votes = votes.saturating_add(1));
    }

    /// Takes a point's votes back.
    pub fn withdraw(&mut self, point: &StripePoint) {
        self.each_bin(point, |votes| *votes = votes.saturating_sub(1));
    }

    fn each_bin(&mut self, point: &StripePoint, change: impl Fn(&mut u16)) {
        let (x, y) = (point.x_px as f32, point.run_centre_px as f32);
        for ([c, s], row) in self.directions.iter().zip(self.votes.chunks_exact_mut(self.r_bins)) {
            // r_offset makes the sum positive, so truncation rounds to the nearest bin.
            if let Some(votes) = row.get_mut((x * c + y * s + self.r_offset) as usize) {
                change(votes);
            }
        }
    }

    /// The line with most votes; the first in order of theta and r where several have as many.
    pub fn strongest(&self) -> PolarLine {
        let most = self.votes.iter().copied().max().unwrap_or(0);
        let index = self.votes.iter().position(|v| *v == most).unwrap_or(0);
        let (k, bin) = (index / self.r_bins, index % self.r_bins);
        PolarLine {
            r_px: (bin as f64 + 0.5 - f64::from(self.r_offset)) * self.grid.r_px,
            theta_rad: self.first_theta_rad + k as f64 * self.grid.theta_rad,
            votes: u32::from(most),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x_px: f64, y: f64) -> StripePoint {
        StripePoint { x_px, run_centre_px: y, centre_px: y, thickness_px: 3.0, peak_dn: 50.0, lasers: 1 }
    }

    #[test]
    fn two_lines_come_out_in_the_order_of_their_votes_and_within_a_bin() {
        let grid = HoughGrid { r_px: 1.0, theta_rad: PI / 180.0, max_slope_rad: PI / 3.0 };
        let mut hough = Hough::new(grid, 640, 480);
        let lines = [(0.31, 100.0, 300), (-0.2, 300.0, 200)];
        let points: Vec<Vec<StripePoint>> = lines
            .iter()
            .map(|(slope, at_zero, count)| (0..*count).map(|x| point(f64::from(x), at_zero + slope * f64::from(x))).collect())
            .collect();
        points.iter().flatten().for_each(|p| hough.vote(p));
        for ((slope, at_zero, count), own) in lines.iter().zip(&points) {
            let found = hough.strongest();
            let theta = libm::atan2(1.0, -slope);
            assert!((found.theta_rad - theta).abs() <= 1.0_f64.to_radians(), "{found:?}");
            assert!((found.r_px - at_zero * libm::sin(theta)).abs() <= 3.0, "{found:?}");
            assert!(f64::from(found.votes) > 0.3 * f64::from(*count), "{found:?}");
            own.iter().for_each(|p| hough.withdraw(p));
        }
        assert_eq!(hough.strongest().votes, 0);
    }
}
