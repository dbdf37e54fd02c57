//! The middle of a stripe in one column, and how sure it is.
//!
//! The light down a column is a Gaussian of known width over a background that is a straight line,
//!
//! I(y) = b0 + b1 t + A g(t),  t = y - c,  g = exp(-t^2 / (2 s^2)),
//!
//! with the variance that the camera and the speckle give each pixel: V = read^2 + 1/12 + K (I - black) + (C A g)^2, K grey values
//! an electron, C the speckle's contrast in a pixel. Weighted least squares with these variances is the maximum-likelihood estimate
//! up to what the variances themselves tell of the middle (two parts in a hundred at C = 0.12), and its covariance the Cramer-Rao
//! bound. It differs from a centroid: where speckle rules, the flanks far from the middle say most.
//!
//! Linear in b0, b1, A and A times the step of c; two Gauss-Newton steps suffice, since the search begins near.

use nalgebra::{Matrix4, Vector4};

use super::view::View;

/// What is known of the noise, in DN of the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Variance of read-out and quantisation.
    pub(super) floor: f64,
    /// Grey values an electron.
    pub(super) gain: f64,
    /// Grey value of black.
    pub(super) black: f64,
    /// Squared contrast of the speckle in a pixel.
    pub(super) speckle: f64,
}

/// A fitted column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    /// The middle, in scan coordinates.
    pub(super) y_px: f64,
    /// Its standard deviation, in pixels.
    pub(super) sigma_px: f64,
    /// Height of the stripe above its background, in DN.
    pub(super) amplitude: f64,
    /// Standard deviation of that.
    pub(super) amplitude_sigma: f64,
    /// Squared residuals over their variances, a degree of freedom.
    pub(super) chi2: f64,
    /// How far, in standard deviations of the light, light of the form g (1 + b (t / s)^3) moves the middle, for b = 1. (Light of the
    /// form g (1 + a t / s) moves it by a.)
    pub(super) cubic: f64,
}

/// Longest column that is fitted, in pixels.
const LONGEST: usize = 320;
/// How much of the column is taken: so many standard deviations and pixels on either side of the middle.
const REACH: [f64; 2] = [3.2, 3.0];
/// Share of the amplitude by which real light departs from a Gaussian: keeps bright stripes from being found unlike one.
const SHAPE_ERROR: f64 = 0.015;
/// Steps of the search.
const STEPS: usize = 2;

/// Fits column `x` about row `guess_px`; `amplitude` is what the stripe's height is taken for in the variances, in DN. `None` where
/// the image ends, too much is saturated, or nothing like a stripe is there.
pub(super) fn fit(view: &View<'_>, x: usize, guess_px: f64, sigma_px: f64, amplitude: f64, noise: &Noise) -> Option<Fitted> {
    let reach = REACH[0] * sigma_px + REACH[1];
    let (from, to) = ((guess_px - reach).ceil(), (guess_px + reach).floor() + 1.0);
    if from < 0.0 || to > view.size[1] as f64 || to - from > LONGEST as f64 {
        return None;
    }
    let (from, to) = (from as usize, to as usize);
    let mut values = [0.0; LONGEST];
    let (mut least, mut full) = (f64::INFINITY, 0);
    view.column(x, from, to, |y, value| {
        values[y - from] = value;
        least = least.min(value);
        full += usize::from(value >= view.full);
    });
    let values = &values[..to - from];
    if 3 * full > values.len() {
        return None;
    }
    let mut centre = guess_px;
    let mut amplitude = amplitude;
    let mut fitted = None;
    for step in 0..STEPS {
        let (next, height) = improve(values, from, centre, sigma_px, amplitude, least, view.full, noise, step + 1 == STEPS)?;
        if (next.y_px - guess_px).abs() > reach / 2.0 {
            return None;
        }
        centre = next.y_px;
        amplitude = height;
        fitted = Some(next);
    }
    fitted
}

/// One Gauss-Newton step from `centre`: the result, and the amplitude to go on with.
#[allow(clippy::too_many_arguments, reason = "the state of one search")]
fn improve(
    values: &[f64],
    from: usize,
    centre: f64,
    sigma: f64,
    amplitude: f64,
    least: f64,
    full: f64,
    noise: &Noise,
    last: bool,
) -> Option<(Fitted, f64)> {
    let inverse = 1.0 / sigma;
    // g by recurrence: g(t + 1) = g(t) q(t), q(t + 1) = q(t) exp(-1 / s^2).
    let first = (from as f64 - centre) * inverse;
    let mut g = libm::exp(-0.5 * first * first);
    let mut q = libm::exp(-first * inverse - 0.5 * inverse * inverse);
    let ratio = libm::exp(-inverse * inverse);
    let background = (least - noise.black).max(0.0) * noise.gain + noise.floor;
    let (shot, speckle) = (noise.gain * amplitude, (noise.speckle + SHAPE_ERROR * SHAPE_ERROR) * amplitude * amplitude);
    let mut a = [0.0; 10];
    let mut b = [0.0; 4];
    let (mut yy, mut used) = (0.0, 0.0);
    let mut cubic = Vector4::zeros();
    let mut t = first;
    for value in values {
        let slope = t * g;
        if *value < full {
            let w = 1.0 / (background + g * (shot + speckle * g));
            let (wt, wg, ws) = (w * t, w * g, w * slope);
            a[0] += w;
            a[1] += wt;
            a[2] += wg;
            a[3] += ws;
            a[4] += wt * t;
            a[5] += wg * t;
            a[6] += ws * t;
            a[7] += wg * g;
            a[8] += ws * g;
            a[9] += ws * slope;
            b[0] += w * value;
            b[1] += wt * value;
            b[2] += wg * value;
            b[3] += ws * value;
            yy += w * value * value;
            used += 1.0;
            if last {
                let odd = slope * t * t;
                cubic += Vector4::new(w, wt, wg, ws) * odd;
            }
        }
        g *= q;
        q *= ratio;
        t += inverse;
    }
    if used < 7.0 {
        return None;
    }
    // Unknowns: background, its slope (by t / s), amplitude, amplitude times step over s.
    let matrix = Matrix4::new(a[0], a[1], a[2], a[3], a[1], a[4], a[5], a[6], a[2], a[5], a[7], a[8], a[3], a[6], a[8], a[9]);
    let right = Vector4::from(b);
    let covariance = matrix.cholesky()?.inverse();
    let found = covariance * right;
    let height = found[2];
    if height <= 0.0 || !height.is_finite() {
        return None;
    }
    let step = (found[3] / height).clamp(-1.5, 1.5) * sigma;
    let chi2 = (yy - found.dot(&right)).max(0.0) / (used - 4.0);
    let sigma_px = sigma * covariance[(3, 3)].max(0.0).sqrt() / height;
    let fitted = Fitted {
        y_px: centre + step,
        sigma_px,
        amplitude: height,
        amplitude_sigma: covariance[(2, 2)].max(0.0).sqrt(),
        chi2,
        cubic: covariance.row(3).transpose().dot(&cubic),
    };
    (fitted.y_px.is_finite() && sigma_px.is_finite() && sigma_px > 0.0).then_some((fitted, height))
}
