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
//! The background's slope is nearly the same from column to column; what the columns before said of it, with a variance that grows a
//! little at each, is a prior (a Kalman filter of one state). Else it would cost the middle of a broad stripe a sixth of its accuracy.
//!
//! Linear in b0, b1, A and A times the step of c: one or two Gauss-Newton steps suffice, since the search begins near.

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

/// What is known of the slope of the background, in DN a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slope {
    mean: f64,
    variance: f64,
    /// By which the variance grows at each column.
    drift: f64,
}

/// Columns over which a background's slope is taken for even: sets how fast its variance grows.
const EVEN_COLUMNS: f64 = 30.0;

impl Slope {
    /// From the first column.
    fn first(mean: f64, variance: f64) -> Self {
        Self { mean, variance, drift: variance / (EVEN_COLUMNS * EVEN_COLUMNS) }
    }

    /// After another column.
    fn next(self, mean: f64, variance: f64) -> Self {
        Self { mean, variance: variance + self.drift, ..self }
    }
}

/// What is looked for in a column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// Its row.
    pub(super) y_px: f64,
    /// Standard deviation of its light down the column, in pixels.
    pub(super) sigma_px: f64,
    /// What its height is taken for in the variances, in DN.
    pub(super) amplitude: f64,
    /// What is known of the background's slope.
    pub(super) slope: Option<Slope>,
}

/// A fitted column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    /// What is known of the background's slope after it.
    pub(super) slope: Slope,
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
pub(super) const LONGEST: usize = 320;
/// How much of the column is taken: so many standard deviations and pixels on either side of the middle.
const REACH: [f64; 2] = [3.2, 3.0];
/// Share of the amplitude by which real light departs from a Gaussian: keeps bright stripes from being found unlike one.
const SHAPE_ERROR: f64 = 0.015;
/// Steps of the search at most, and the step, in standard deviations of the light, after which another would not count: what is
/// left is of its third power.
const STEPS: usize = 3;
const NEAR: f64 = 0.08;

/// Fits column `x`; `values` is room to work in. `None` where the image ends, too much is saturated, or nothing like a stripe is there.
pub(super) fn fit(view: &View<'_>, x: usize, expected: &Expected, noise: &Noise, values: &mut Vec<f64>) -> Option<Fitted> {
    let Expected { y_px: guess_px, sigma_px, .. } = *expected;
    let reach = REACH[0] * sigma_px + REACH[1];
    let (from, to) = ((guess_px - reach).ceil(), (guess_px + reach).floor() + 1.0);
    // The image may end within the window, if the middle and more is in it.
    let rows = view.size[1] as f64;
    let inside = guess_px >= sigma_px + 2.0 && guess_px <= rows - 3.0 - sigma_px;
    if !inside || to - from > LONGEST as f64 {
        return None;
    }
    let (from, to) = (from.max(0.0) as usize, to.min(rows) as usize);
    let (mut least, mut full) = (f64::INFINITY, 0);
    values.clear();
    view.column(x, from, to, |_, value| {
        values.push(value);
        least = least.min(value);
        full += usize::from(value >= view.full);
    });
    if 3 * full > values.len() {
        return None;
    }
    let column = Column { values, from, least, full: view.full };
    let mut sought = *expected;
    let mut fitted = None;
    for _ in 0..STEPS {
        let next = column.improve(&sought, noise)?;
        if (next.y_px - guess_px).abs() > reach / 2.0 {
            return None;
        }
        let near = (next.y_px - sought.y_px).abs() < NEAR * sigma_px;
        (sought.y_px, sought.amplitude) = (next.y_px, next.amplitude);
        fitted = Some(next);
        if near {
            break;
        }
    }
    fitted
}

/// A column's values.
struct Column<'a> {
    values: &'a [f64],
    /// The row of the first.
    from: usize,
    /// The least of them, taken for the background in the variances.
    least: f64,
    /// At this value and beyond a pixel is full.
    full: f64,
}

impl Column<'_> {
    /// One Gauss-Newton step from where the stripe is sought.
    fn improve(&self, sought: &Expected, noise: &Noise) -> Option<Fitted> {
        let Self { values, from, least, full } = *self;
        let Expected { y_px: centre, sigma_px: sigma, amplitude, slope: known } = *sought;
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
        let mut cubic = [0.0; 4];
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
                let odd = slope * t * t;
                cubic[0] += w * odd;
                cubic[1] += wt * odd;
                cubic[2] += wg * odd;
                cubic[3] += ws * odd;
            }
            g *= q;
            q *= ratio;
            t += inverse;
        }
        if used < 7.0 {
            return None;
        }
        if let Some(Slope { mean, variance, .. }) = known {
            // In the unit of the unknown: DN a standard deviation.
            let weight = 1.0 / (variance * sigma * sigma);
            a[4] += weight;
            b[1] += weight * mean * sigma;
            yy += weight * mean * mean * sigma * sigma;
        }
        // Unknowns: background, its slope (by t / s), amplitude, amplitude times step over s.
        let normal = Normal4::of(&a)?;
        let found = normal.solve(&b);
        let height = found[2];
        if height <= 0.0 || !height.is_finite() {
            return None;
        }
        let step = (found[3] / height).clamp(-1.5, 1.5) * sigma;
        let explained: f64 = found.iter().zip(&b).map(|(x, y)| x * y).sum();
        let chi2 = (yy - explained).max(0.0) / (used - 4.0);
        let [_, tilt_variance, height_variance, step_variance] = normal.variances();
        let sigma_px = sigma * step_variance.sqrt() / height;
        let (tilt, tilt_variance) = (found[1] * inverse, tilt_variance * inverse * inverse);
        let fitted = Fitted {
            slope: known.map_or_else(|| Slope::first(tilt, tilt_variance), |known| known.next(tilt, tilt_variance)),
            y_px: centre + step,
            sigma_px,
            amplitude: height,
            amplitude_sigma: height_variance.sqrt(),
            chi2,
            cubic: normal.solve(&cubic)[3],
        };
        (fitted.y_px.is_finite() && sigma_px.is_finite() && sigma_px > 0.0).then_some(fitted)
    }
}

/// Normal equations of four unknowns, factored as L D L^T. By hand, because it is solved some thousand times a frame.
struct Normal4 {
    l: [f64; 6],
    d: [f64; 4],
}

impl Normal4 {
    /// From the upper triangle, row by row; `None` where it is not positive definite.
    fn of(a: &[f64; 10]) -> Option<Self> {
        let d0 = a[0];
        let (l10, l20, l30) = (a[1] / d0, a[2] / d0, a[3] / d0);
        let d1 = a[4] - l10 * a[1];
        let (c21, c31) = (a[5] - l10 * a[2], a[6] - l10 * a[3]);
        let (l21, l31) = (c21 / d1, c31 / d1);
        let d2 = a[7] - l20 * a[2] - l21 * c21;
        let c32 = a[8] - l20 * a[3] - l21 * c31;
        let l32 = c32 / d2;
        let d3 = a[9] - l30 * a[3] - l31 * c31 - l32 * c32;
        let d = [d0, d1, d2, d3];
        let least = 1e-12;
        (d0 > 0.0 && d1 > least * a[4] && d2 > least * a[7] && d3 > least * a[9])
            .then_some(Self { l: [l10, l20, l21, l30, l31, l32], d })
    }

    fn solve(&self, b: &[f64; 4]) -> [f64; 4] {
        let [l10, l20, l21, l30, l31, l32] = self.l;
        let y0 = b[0];
        let y1 = b[1] - l10 * y0;
        let y2 = b[2] - l20 * y0 - l21 * y1;
        let y3 = b[3] - l30 * y0 - l31 * y1 - l32 * y2;
        let x3 = y3 / self.d[3];
        let x2 = y2 / self.d[2] - l32 * x3;
        let x1 = y1 / self.d[1] - l21 * x2 - l31 * x3;
        let x0 = y0 / self.d[0] - l10 * x1 - l20 * x2 - l30 * x3;
        [x0, x1, x2, x3]
    }

    /// The diagonal of the inverse.
    fn variances(&self) -> [f64; 4] {
        let [l10, l20, l21, l30, l31, l32] = self.l;
        let [w0, w1, w2, w3] = self.d.map(|d| 1.0 / d);
        // Columns of the inverse of L.
        let (m10, m21, m32) = (-l10, -l21, -l32);
        let (m20, m31) = (-l20 - l21 * m10, -l31 - l32 * m21);
        let m30 = -l30 - l31 * m10 - l32 * m20;
        [w0 + m10 * m10 * w1 + m20 * m20 * w2 + m30 * m30 * w3, w1 + m21 * m21 * w2 + m31 * m31 * w3, w2 + m32 * m32 * w3, w3]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Vector4};
    use proptest::prelude::*;

    use super::*;
    use crate::messages::Frame;
    use crate::perception::scan::Across;

    proptest! {
        /// Against nalgebra's inverse.
        #[test]
        fn the_factored_equations_are_solved(values in prop::array::uniform16(-3.0..3.0f64), right in prop::array::uniform4(-5.0..5.0f64)) {
            let root = Matrix4::from_row_slice(&values);
            let matrix = root * root.transpose() + Matrix4::identity() * 0.1;
            let upper = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)].map(|at| matrix[at]);
            let normal = Normal4::of(&upper).expect("positive definite");
            let inverse = matrix.try_inverse().expect("positive definite");
            let solved = Vector4::from(normal.solve(&right));
            prop_assert!((matrix * solved - Vector4::from(right)).norm() < 1e-9 * (1.0 + solved.norm()));
            for (i, variance) in normal.variances().into_iter().enumerate() {
                prop_assert!((variance / inverse[(i, i)] - 1.0).abs() < 1e-9);
            }
        }
    }

    const NOISE: Noise = Noise { floor: 1.0 / 12.0 + 0.015, gain: 247.0 / 30_000.0, black: 8.0, speckle: 0.0 };

    fn expected(y_px: f64, sigma_px: f64, amplitude: f64) -> Expected {
        Expected { y_px, sigma_px, amplitude, slope: None }
    }

    /// A column of 12 bits, so that rounding is a hundredth of a pixel's own: the middle comes out wherever it is, on a slope, near the
    /// image's edge, with full pixels left out. Where the top is hidden, two or three steps leave a little more.
    #[test]
    fn the_middle_of_a_gaussian_is_found_to_rounding() {
        for (height, allowed_px) in [(3500.0, 1e-3), (4800.0, 6e-3)] {
            for sigma in [1.0, 2.3, 8.0] {
                for centre in [30.0, 30.37, 30.81, 3.0 + sigma] {
                    let value = |y: usize| {
                        let t = (y as f64 - centre) / sigma;
                        (300.0 + 2.0 * y as f64 + height * libm::exp(-t * t / 2.0)).round().min(4095.0) as u16
                    };
                    let pixels: Vec<u16> = (0..20 * 80).map(|i| value(i / 20)).collect();
                    let frame = Frame::grey16(20, 80, &pixels, 4095);
                    let view = View::new(&frame, Across::V);
                    let found = fit(&view, 10, &expected(centre + 0.1 * sigma, sigma, 3000.0), &NOISE, &mut Vec::new())
                        .unwrap_or_else(|| panic!("no stripe at {centre}, sigma {sigma}"));
                    assert!((found.y_px - centre).abs() < allowed_px, "{} for {centre}, sigma {sigma}", found.y_px);
                    assert!(found.sigma_px > 0.0 && found.sigma_px < 0.05, "{found:?}");
                }
            }
        }
    }

    /// The deviation that is stated is the scatter that there is: the Cramer-Rao bound of the column.
    #[test]
    fn centres_scatter_as_they_say() {
        let (sigma, amplitude) = (1.7, 20.0);
        let noise = Noise { speckle: 0.12 * 0.12, ..NOISE };
        let mut state = 7u64;
        let mut normal = || {
            // Twelve even numbers: near enough to a normal one.
            (0..12).fold(-6.0, |sum, _| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum + (state >> 11) as f64 / (1u64 << 53) as f64
            })
        };
        let (mut squares, mut stated, mut sum) = (0.0, 0.0, 0.0);
        const COLUMNS: usize = 4000;
        let mut pixels = [0u16; 40];
        for i in 0..COLUMNS {
            let centre = 20.0 + (i % 10) as f64 / 10.0;
            for (y, pixel) in pixels.iter_mut().enumerate() {
                let t = (y as f64 - centre) / sigma;
                let light = amplitude * libm::exp(-t * t / 2.0);
                let variance = NOISE.floor - 1.0 / 12.0 + NOISE.gain * (6.0 + light) + noise.speckle * light * light;
                *pixel = (14.0 + light + variance.sqrt() * normal()).round().max(0.0) as u16;
            }
            let tall: Vec<u16> = pixels.iter().flat_map(|value| [*value; 16]).collect();
            let frame = Frame::grey16(16, 40, &tall, 255);
            let found = fit(&View::new(&frame, Across::V), 3, &expected(centre, sigma, amplitude), &noise, &mut Vec::new())
                .expect("a stripe");
            let off = found.y_px - centre;
            squares += off * off;
            sum += off;
            stated += found.sigma_px * found.sigma_px;
        }
        let (scatter, stated, bias) = ((squares / COLUMNS as f64).sqrt(), (stated / COLUMNS as f64).sqrt(), sum / COLUMNS as f64);
        // A standard deviation of 4000 values is known to 1.1 %; shape error and integration of the variance add a few.
        assert!((scatter / stated - 1.0).abs() < 0.06, "scatter {scatter}, stated {stated}");
        assert!(bias.abs() < 0.005, "{bias}");
    }
}
