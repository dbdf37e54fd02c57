//! Stripe centres without a rig: for photographs of which nothing is known but that light stripes are in them.
//!
//! The robust pipeline knows how thick a stripe must be and where it may be; this extractor does not. In data-flow order:
//!
//! 1. `noise`: how much neighbouring grey values scatter;
//! 2. `detect`: in each column a matched filter of several widths, and the places where it answers best;
//! 3. `chain`: places of neighbouring columns joined; what nothing joins is dropped;
//! 4. `measure`, [`gaussian`]: at each that is left a Gaussian fitted to the grey values, which gives the centre and its variance;
//! 5. `segments`: chains split into straight lines.
//!
//! Stripes may run along u or along v; both are tried, and the way in which more places hang together is taken. A stripe steeper than
//! about 45 degrees against that way is not followed. What it does not do: tell which laser a stripe is of, tell a stripe from another
//! bright line, or undistort ([`super::lens`] does). A [`Region`] keeps it from looking where no stripe can be.
//!
//! How exact: see `tests/ridge.rs`. The stated deviation is the fit's own, scaled to how well Gaussians fit this image; an error that
//! neighbouring columns share (a stripe that is not symmetric) is not in it.

mod chain;
mod detect;
pub mod gaussian;
mod measure;
mod noise;
mod region;
mod segments;

pub use region::Region;

use super::scan::{Across, ScanImage};
use super::{Stages, StripeCentre, StripeLine};
use crate::messages::Frame;
use chain::{Chain, Following, Point};
use detect::{Filters, Peak, WIDTH_TO_FWHM};
use gaussian::ProfileNoise;
use measure::Measuring;
use noise::NoiseMeter;
use segments::Segment;

/// Parameters of the extractor.
#[derive(Clone, Debug, PartialEq)]
pub struct RidgeParams {
    /// Which axis runs across the stripes; `None`: both are tried.
    pub across: Option<Across>,
    /// Thinnest and thickest stripe sought, as full width at half maximum, in pixels.
    pub fwhm_px: [f64; 2],
    /// Least height above the background, in DN of 8 bits.
    pub min_height_dn: f64,
    /// Least contrast over its own noise.
    pub min_snr: f64,
    /// Standard deviation of a stripe's light as a share of it, for the weights of the fit: speckle, and what a Gaussian does not fit.
    pub speckle: f64,
    /// Most stripes in one column.
    pub per_column: usize,
    /// Columns that a stripe may miss in a row.
    pub max_gap_px: usize,
    /// Fewest centres that make a stripe.
    pub min_points: usize,
    /// Largest standard deviation of a centre, in pixels.
    pub max_sigma_px: f64,
}

impl Default for RidgeParams {
    fn default() -> Self {
        Self {
            across: None,
            fwhm_px: [2.0, 30.0],
            min_height_dn: 4.0,
            min_snr: 6.0,
            speckle: 0.1,
            per_column: 6,
            max_gap_px: 12,
            min_points: 20,
            max_sigma_px: 0.7,
        }
    }
}

/// A stripe's centre, with what it was fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RidgeCentre {
    /// Column, in pixels.
    pub u_px: f64,
    /// Row, in pixels.
    pub v_px: f64,
    /// Standard deviation across the stripe, along the axis that was scanned, in pixels.
    pub sigma_px: f64,
    /// Full width at half maximum along that axis, in pixels.
    pub fwhm_px: f64,
    /// Height above the background, in DN of 8 bits.
    pub height_dn: f64,
    /// The line that it is part of: its index in [`Ridge::lines`].
    pub line: usize,
}

/// The extractor with its buffers: after the first frames it allocates nothing.
#[derive(Clone, Debug)]
pub struct Ridge {
    params: RidgeParams,
    filters: Filters,
    noise: NoiseMeter,
    images: [ScanImage; 2],
    crossings: Vec<f64>,
    peaks: Vec<Peak>,
    open: Vec<u32>,
    todo: Vec<[usize; 2]>,
    ratios: Vec<f64>,
    /// What was found with stripes along u, and along v.
    found: [Found; 2],
    across: Across,
    centres: Vec<RidgeCentre>,
    plain: Vec<StripeCentre>,
    lines: Vec<StripeLine>,
}

/// What one direction gave.
#[derive(Clone, Debug, Default)]
struct Found {
    /// Standard deviation of a grey value.
    noise: f64,
    points: Vec<Point>,
    chains: Vec<Chain>,
    segments: Vec<Segment>,
}

/// A profile is fitted over this many filter widths on either side, and some pixels of background.
const FIT_WIDTHS: f64 = 1.5;
const FIT_BACKGROUND_PX: usize = 2;
/// The filter's answer over a Gaussian's height, at least.
const LEAST_ANSWER: f64 = 0.5;
/// How many degrees of freedom the image's own noise factor counts for beside a profile's.
const PRIOR_FREEDOM: f64 = 12.0;

impl Ridge {
    /// An extractor.
    pub fn new(params: RidgeParams) -> Self {
        Self {
            filters: Filters::new(params.fwhm_px),
            params,
            noise: NoiseMeter::default(),
            images: Default::default(),
            crossings: Vec::new(),
            peaks: Vec::new(),
            open: Vec::new(),
            todo: Vec::new(),
            ratios: Vec::new(),
            found: Default::default(),
            across: Across::V,
            centres: Vec::new(),
            plain: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// Finds the stripes of a frame, within `region` if there is one. The centres of one line come together, in the order of their
    /// columns (or rows).
    pub fn extract(&mut self, frame: &Frame<'_>, region: Option<&Region>) -> &[RidgeCentre] {
        let tried: &[Across] = match self.params.across {
            Some(Across::V) => &[Across::V],
            Some(Across::U) => &[Across::U],
            None => &[Across::V, Across::U],
        };
        self.found.iter_mut().for_each(|found| found.points.clear());
        let is_empty = frame.width_px == 0 || frame.height_px == 0;
        for across in tried.iter().filter(|_| !is_empty) {
            self.scan(frame, region, *across);
        }
        let support = |across: &Across| self.found[slot(*across)].points.len();
        // Of equal ones the first.
        self.across = tried.iter().copied().rev().max_by_key(support).unwrap_or(Across::V);
        self.fit(frame);
        self.judge();
        self.show(frame.dn_per_dn8());
        &self.centres
    }

    /// The centres of the last frame.
    pub fn centres(&self) -> &[RidgeCentre] {
        &self.centres
    }

    /// The straight lines of the last frame.
    pub fn lines(&self) -> &[StripeLine] {
        &self.lines
    }

    /// Which axis ran across the stripes of the last frame.
    pub fn across(&self) -> Across {
        self.across
    }

    /// The same centres and lines in the form of a perception's stages. There are no planes without a rig.
    pub fn stages(&self) -> Stages<'_> {
        Stages { centres: &self.plain, lines: &self.lines, ..Stages::default() }
    }

    /// Places of all columns where a stripe may be, and the chains that they make.
    fn scan(&mut self, frame: &Frame<'_>, region: Option<&Region>, across: Across) {
        let image = &mut self.images[slot(across)];
        // Turned so that a column across the stripes is a row in memory.
        image.load(frame, turned(across));
        let found = &mut self.found[slot(across)];
        found.noise = self.noise.measure(image);
        let params = &self.params;
        let least = [params.min_snr * found.noise, LEAST_ANSWER * params.min_height_dn * frame.dn_per_dn8()];
        for x in 0..image.height {
            self.crossings.clear();
            match region {
                Some(region) => region.crossings(across, x as f64, &mut self.crossings),
                None => self.crossings.extend([0.0, image.width as f64]),
            }
            for pair in self.crossings.chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|place| place.ceil().clamp(0.0, image.width as f64) as usize);
                self.filters.peaks(image.row(x), from..to, least, params.per_column, &mut self.peaks);
                found.points.extend(self.peaks.iter().enumerate().map(|(i, peak)| {
                    let reach = (FIT_WIDTHS * peak.width as f64).ceil() as usize + FIT_BACKGROUND_PX;
                    // As far as the middle between this place and the next.
                    let before = i.checked_sub(1).map_or(from, |i| (self.peaks[i].y + peak.y) / 2);
                    let after = self.peaks.get(i + 1).map_or(to, |next| (peak.y + next.y) / 2 + 1);
                    let span = [before.max(peak.y.saturating_sub(reach)), after.min(peak.y + reach + 1)];
                    Point::of_place(x, peak.y, span, peak.contrast, peak.width as f64 / WIDTH_TO_FWHM)
                }));
            }
        }
        let following = self.following();
        let found = &mut self.found[slot(across)];
        chain::follow(&mut found.points, &following, &mut found.chains, &mut self.open);
        chain::keep(&mut found.points, &found.chains, &following);
    }

    /// A Gaussian at every place that is left; where none fits, there is no centre.
    fn fit(&mut self, frame: &Frame<'_>) {
        let (params, found) = (&self.params, &mut self.found[slot(self.across)]);
        let measuring = Measuring {
            image: &self.images[slot(self.across)],
            noise: ProfileNoise { floor: found.noise, speckle: params.speckle },
            full: frame.max_dn,
            min_height: params.min_height_dn * frame.dn_per_dn8(),
            fwhm_px: params.fwhm_px,
        };
        measure::measure(&mut found.points, &measuring, &mut self.ratios);
    }

    fn following(&self) -> Following {
        Following { max_gap: self.params.max_gap_px, min_points: self.params.min_points }
    }

    /// Each centre's deviation; those that are too uncertain go.
    fn judge(&mut self) {
        let following = self.following();
        let found = &mut self.found[slot(self.across)];
        // How much more, or less, than assumed grey values are off their Gaussians in this image: half the centres more, half less.
        self.ratios.clear();
        self.ratios.extend(found.points.iter().map(|point| point.chi2 / median_of_chi2(point.freedom)));
        let middle = self.ratios.len() / 2;
        let usual = if self.ratios.is_empty() { 1.0 } else { *self.ratios.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let most_px2 = self.params.max_sigma_px * self.params.max_sigma_px;
        found.points.retain_mut(|point| {
            // Ten values say little of their own scatter; the image's counts beside it.
            let factor = (PRIOR_FREEDOM * usual + point.chi2) / (PRIOR_FREEDOM + point.freedom);
            point.variance_px2 *= factor;
            point.variance_px2 <= most_px2
        });
        chain::keep_long(&mut found.points, &following, &mut self.open);
    }

    /// Lines, and all of it in pixels of the image.
    fn show(&mut self, dn_per_dn8: f64) {
        let found = &mut self.found[slot(self.across)];
        segments::split(&found.points, self.params.min_points, &mut found.segments, &mut self.todo);
        self.centres.clear();
        self.plain.clear();
        self.lines.clear();
        let across = self.across;
        for segment in &found.segments {
            let [first, end] = segment.points;
            let part = &found.points[first..end];
            let line = self.lines.len();
            for point in part {
                let [u_px, v_px] = across.pixel(point.x as f64, point.y_px);
                let sigma_px = point.variance_px2.sqrt();
                let height_dn = point.height / dn_per_dn8;
                self.centres.push(RidgeCentre { u_px, v_px, sigma_px, fwhm_px: point.fwhm_px, height_dn, line });
                self.plain.push(StripeCentre { u_px, v_px, sigma_px, assigned: None });
            }
            let end_px = |point: &Point| across.pixel(point.x as f64, segment.at(point.x as f64));
            self.lines.push(StripeLine {
                ends_px: [end_px(&part[0]), end_px(&part[part.len() - 1])],
                assigned: None,
                points: part.len(),
                residual_px: segment.residual_px,
            });
        }
    }
}

/// The median of chi-squared with so many degrees of freedom (Wilson and Hilferty, PNAS 17(12), 1931).
fn median_of_chi2(freedom: f64) -> f64 {
    let root = 1.0 - 2.0 / (9.0 * freedom.max(1.0));
    freedom.max(1.0) * root * root * root
}

fn slot(across: Across) -> usize {
    match across {
        Across::V => 0,
        Across::U => 1,
    }
}

/// The other axis.
fn turned(across: Across) -> Across {
    match across {
        Across::V => Across::U,
        Across::U => Across::V,
    }
}
