//! Places on chains to centres: a Gaussian at each, and a second look where the first is not to be believed.
//!
//! A stripe's halo is as bright as half the stripe where it falls on something white, and a Gaussian may then fit the halo. Its width gives
//! that away: along a chain the stripe is about as wide everywhere, and halos only widen it. So where a Gaussian does not explain the
//! values and is wider than most of its chain's, or is far wider, it is fitted again to what lies within the usual width.

use super::chain::Point;
use super::gaussian::{self, FWHM, Gaussian, GaussianFit, Profile, ProfileNoise};
use crate::perception::scan::ScanImage;

/// What places are measured in, and what a stripe must be.
pub(super) struct Measuring<'a> {
    /// The image, a row of it for each column across the stripes.
    pub(super) image: &'a ScanImage,
    /// How grey values scatter.
    pub(super) noise: ProfileNoise,
    /// The value of a full pixel.
    pub(super) full: u16,
    /// Least height, in grey values.
    pub(super) min_height: f64,
    /// Thinnest and thickest stripe, in pixels.
    pub(super) fwhm_px: [f64; 2],
}

/// A Gaussian's height over the answer of the filter that answers it best, nearly.
const START_HEIGHT: f64 = 1.2;
/// Width beyond which a stripe is looked at again, as a multiple of its chain's.
const WIDE: f64 = 1.4;
/// The same where noise seems to explain a fit: a halo that is much wider than its core hides the core's misfit among many values.
const FAR_TOO_WIDE: f64 = 3.0;
/// Width beyond which it is not believed after the second look.
const TOO_WIDE: f64 = 2.0;
/// Of the widths of fits this share is narrower than the stripe's usual width: those that follow a halo are the wide ones.
const USUAL: f64 = 0.3;
/// A second fit reaches so many usual widths to either side, and so many pixels more.
const REACH: f64 = 1.0;
/// See `REACH`.
const REACH_PX: f64 = 2.0;

/// Gives every point, a filter's place so far, its centre, and takes out those that have none. The points of a chain stand together.
pub(super) fn measure(points: &mut Vec<Point>, measuring: &Measuring<'_>, widths: &mut Vec<f64>) {
    for point in points.iter_mut() {
        let whole = f64::from(point.span[1] - point.span[0]);
        match measuring.fit(point, point.fwhm_px, whole) {
            Some(fitted) => *point = fitted,
            None => point.freedom = 0.0,
        }
    }
    let Some(of_image_px) = usual(points, widths) else { return points.clear() };
    for chain in points.chunk_by_mut(|a, b| a.chain == b.chain) {
        // A chain that has never left the halo does not know.
        let of_chain_px = usual(chain, widths).unwrap_or(of_image_px);
        let usual_px = if of_chain_px > FAR_TOO_WIDE * of_image_px { of_image_px } else { of_chain_px };
        let doubtful = |point: &&mut Point| {
            let bound_px = usual_px * if point.is_explained { FAR_TOO_WIDE } else { WIDE };
            !point.is_measured() || point.fwhm_px > bound_px
        };
        for point in chain.iter_mut().filter(doubtful) {
            let second = measuring.fit(point, usual_px, REACH * usual_px + REACH_PX);
            match second.filter(|fitted| fitted.fwhm_px <= TOO_WIDE * usual_px) {
                Some(fitted) => *point = fitted,
                // A wide stripe beside narrow ones has no narrow core.
                None if point.is_explained => {}
                None => point.freedom = 0.0,
            }
        }
    }
    points.retain(Point::is_measured);
}

/// The width that stripes of these points usually have, in pixels; `None` where none is measured.
fn usual(points: &[Point], widths: &mut Vec<f64>) -> Option<f64> {
    widths.clear();
    widths.extend(points.iter().filter(|point| point.is_measured()).map(|point| point.fwhm_px));
    let at = (USUAL * widths.len().checked_sub(1)? as f64) as usize;
    Some(*widths.select_nth_unstable_by(at, f64::total_cmp).1)
}

impl Measuring<'_> {
    /// The centre near a place, sought from a width, within a reach of the place.
    fn fit(&self, point: &Point, fwhm_px: f64, reach_px: f64) -> Option<Point> {
        let place = f64::from(point.place);
        let from = point.span[0].max((place - reach_px).max(0.0) as u32) as usize;
        let to = point.span[1].min((place + reach_px) as u32 + 1) as usize;
        let values = &self.image.row(point.x)[from..to.max(from)];
        let start = Gaussian {
            centre_px: place,
            sigma_px: fwhm_px / FWHM,
            height: START_HEIGHT * point.contrast,
            background: values.iter().copied().min().unwrap_or_default().into(),
            slope: 0.0,
        };
        let profile = Profile { first_px: from, values, full: self.full };
        let GaussianFit { shape, centre_variance_px2, chi2, freedom, is_explained } =
            gaussian::fit(&profile, &start, &self.noise)?;
        let [thinnest_px, thickest_px] = self.fwhm_px;
        let is_stripe = (0.6 * thinnest_px..=1.6 * thickest_px).contains(&shape.fwhm_px())
            && shape.height >= self.min_height
            && (shape.centre_px - place).abs() <= fwhm_px.max(2.0);
        is_stripe.then_some(Point {
            y_px: shape.centre_px,
            variance_px2: centre_variance_px2,
            fwhm_px: shape.fwhm_px(),
            height: shape.height,
            chi2,
            freedom: freedom as f64,
            is_explained,
            ..*point
        })
    }
}
