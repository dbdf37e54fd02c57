//! Runs across the stripe to one point each, guided by thickness (section 4.1: "the most reliable feature for extracting laser
//! stripe is thickness of laser stripe in the image plane").
//!
//! A run is a stretch of set pixels in one column. What a laser's stripe at that pixel would be thick is known: equation 1
//! gives its depth, the rig the width of the light there, and the ratio of its peak to the threshold the part of the profile
//! that the binary image keeps. A run that fits no laser is a reflection, an edge, or two stripes that cross, and is dropped.

use super::bit_image::BitImage;
use super::scan::{Across, ScanImage};
use super::triangulation::Triangulation;
use crate::rig::{Laser, LineWidth};

/// A stripe's point: one column, its centre across the stripe to a fraction of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripePoint {
    /// Column in scan coordinates.
    pub x_px: f64,
    /// Centre of the binary run, in scan coordinates: the paper's thinning.
    pub run_centre_px: f64,
    /// Centre of the light, in scan coordinates: the centroid above the background.
    pub centre_px: f64,
    /// Length of the run.
    pub thickness_px: f64,
    /// Brightest pixel of the run above the background, in DN.
    pub peak_dn: f64,
    /// Bit i is set if the thickness fits laser i.
    pub lasers: u8,
}

/// What the thickness of a stripe is expected from.
#[derive(Clone, Debug)]
pub struct ExpectedThickness {
    across: Across,
    focal_px: f64,
    psf_sigma_px: f64,
    line: LineWidth,
    lasers: Vec<(Triangulation, nalgebra::Point3<f64>)>,
}

/// Limits of what thinning accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThicknessLimits {
    /// Thinnest run, as a share of the expected thickness.
    pub min_ratio: f64,
    /// Thickest run, as a share of the expected thickness.
    pub max_ratio: f64,
}

/// Pixels on either side of a run that still hold light of the stripe: these, and a quarter of the run.
const LEAST_SKIRT_PX: usize = 3;
/// Pixels beyond the skirt from which the background under the stripe is interpolated.
const BACKGROUND_PX: usize = 3;

impl ExpectedThickness {
    /// For the lasers of a rig. `psf_sigma_px` is the camera's blur.
    pub fn new(rig: &crate::rig::Rig, across: Across, psf_sigma_px: f64) -> Self {
        let camera = &rig.camera;
        let laser = |l: &Laser| (Triangulation::from_rig(camera, l), l.source_in_camera);
        Self {
            across,
            focal_px: match across {
                Across::V => camera.focal_px[1],
                Across::U => camera.focal_px[0],
            },
            psf_sigma_px,
            line: rig.line,
            lasers: rig.lasers.iter().map(laser).collect(),
        }
    }

    /// Thickness in pixels at which a stripe of laser `index` stands `ratio` times above the threshold's level, seen at scan
    /// coordinates (x, y). `None` where that laser cannot be seen.
    pub fn at(&self, index: usize, x: f64, y: f64, ratio: f64) -> Option<f64> {
        let (triangulation, source) = &self.lasers[index];
        let [u, v] = self.across.pixel(x, y);
        let point = triangulation.point(u, v)?;
        let fwhm = self.focal_px * self.line.at((point - source).norm()) / point.z;
        let blur = FWHM_PER_SIGMA * self.psf_sigma_px;
        // Two points of a Gaussian at 1 / ratio of its peak are FWHM sqrt(log2 ratio) apart.
        Some((fwhm * fwhm + blur * blur).sqrt() * libm::log2(ratio.max(1.0)).sqrt())
    }

    fn fitting_lasers(&self, x: f64, y: f64, thickness: f64, ratio: f64, limits: ThicknessLimits) -> u8 {
        let mut lasers = 0;
        for index in 0..self.lasers.len() {
            // Half a pixel at each end is lost or won by sampling.
            let fits = self.at(index, x, y, ratio).is_some_and(|expected| {
                thickness + 1.0 >= limits.min_ratio * expected && thickness - 1.0 <= limits.max_ratio * expected
            });
            lasers |= u8::from(fits) << index;
        }
        lasers
    }
}

/// Full width at half maximum of a Gaussian of standard deviation one: 2 sqrt(2 ln 2).
const FWHM_PER_SIGMA: f64 = 2.354_820_045_030_949;

/// Thins the binary image to points, in the order of the rows in which their runs end. `starts` is room to work in.
pub fn thin(
    binary: &BitImage,
    grey: &ScanImage,
    threshold_dn: f64,
    expected: &ExpectedThickness,
    limits: ThicknessLimits,
    starts: &mut Vec<u32>,
    points: &mut Vec<StripePoint>,
) {
    points.clear();
    starts.clear();
    starts.resize(binary.width, 0);
    let mut measure = |x: usize, first: usize, end: usize| {
        if let Some(point) = measure_run(grey, x, first, end) {
            let ratio = point.peak_dn / threshold_dn;
            let lasers = expected.fitting_lasers(point.x_px, point.centre_px, point.thickness_px, ratio, limits);
            if lasers != 0 {
                points.push(StripePoint { lasers, ..point });
            }
        }
    };
    // Walking down the rows, a column whose bit differs from the row above begins or ends a run.
    for y in 0..binary.height {
        for (j, word) in binary.row(y).iter().enumerate() {
            let before = if y > 0 { binary.row(y - 1)[j] } else { 0 };
            let mut changed = word ^ before;
            while changed != 0 {
                let bit = changed.trailing_zeros() as usize;
                changed &= changed - 1;
                let x = 64 * j + bit;
                if word >> bit & 1 == 1 {
                    starts[x] = y as u32;
                } else {
                    measure(x, starts[x] as usize, y);
                }
            }
        }
    }
}

/// Measures the run of rows `first..end` in column `x`; `None` where it stands too near the image's edge for a background.
fn measure_run(grey: &ScanImage, x: usize, first: usize, end: usize) -> Option<StripePoint> {
    let skirt = LEAST_SKIRT_PX + (end - first) / 4;
    let reach = skirt + BACKGROUND_PX;
    if first < reach || end + reach > grey.height {
        return None;
    }
    let value = |y: usize| f64::from(grey.pixels[y * grey.width + x]);
    let mean = |from: usize| (from..from + BACKGROUND_PX).map(value).sum::<f64>() / BACKGROUND_PX as f64;
    let middle = (BACKGROUND_PX as f64 - 1.0) / 2.0;
    let (over_y, under_y) = ((first - reach) as f64 + middle, (end + skirt) as f64 + middle);
    let (over, under) = (mean(first - reach), mean(end + skirt));
    let slope = (under - over) / (under_y - over_y);
    let (mut light, mut moment, mut peak) = (0.0, 0.0, 0.0);
    for y in first - skirt..end + skirt {
        let above = value(y) - (over + slope * (y as f64 - over_y));
        light += above;
        moment += above * (y as f64 - first as f64);
        peak = f64::max(peak, above);
    }
    let centre = first as f64 + moment / light;
    // A centroid outside the run comes from light beside it, not from this stripe.
    let inside = centre >= first as f64 - 0.5 && centre <= end as f64 - 0.5;
    (light > 0.0 && inside).then(|| StripePoint {
        x_px: x as f64,
        run_centre_px: (first + end - 1) as f64 / 2.0,
        centre_px: centre,
        thickness_px: (end - first) as f64,
        peak_dn: peak,
        lasers: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centroid_of_a_sampled_gaussian_on_a_slope_is_its_centre() {
        for centre in [30.0, 30.3, 30.77] {
            let value = |y: usize| {
                let d = (y as f64 - centre) / 1.4;
                1000.0 + 20.0 * y as f64 + 20_000.0 * libm::exp(-d * d / 2.0)
            };
            let grey = ScanImage { width: 1, height: 64, pixels: (0..64).map(|y| value(y) as u16).collect() };
            let point = measure_run(&grey, 0, 29, 33).expect("a run in the middle of the image");
            // The profile is cut 3 pixels beyond the run, at more than 3 sigma; rounding to whole DN is 5e-5 of the peak.
            assert!((point.centre_px - centre).abs() < 0.01, "{} for {centre}", point.centre_px);
        }
    }
}
