//! One profile across a stripe to a Gaussian on a background that may slope, by least squares: the maximum of likelihood where the
//! noise is normal.
//!
//! Noise is what the sensor adds, the same everywhere, and speckle, a share of the stripe's own light ([`ProfileNoise`]): the middle
//! weighs less than the flanks, by a first fit in which all weigh the same. Real stripes stand in a halo that no Gaussian follows, and
//! flanks that weigh much would have the fit follow the halo: where noise does not explain what a fit misses, what the first one misses
//! beside the stripe is taken for the noise there, so that the stripe's core decides. A full pixel says only that there was more light
//! than it could tell: it counts where the model falls short of it, and not where it is beyond.
//!
//! A slope of the background, left out, would pull the middle: 0.02 grey values a pixel under a stripe 16 px wide and 120 high by 0.08 px.
//! Where speckle is the noise it is known from beside the stripe, and costs nothing.

use nalgebra::{SMatrix, SVector};

/// b + g (y - c) + a exp(-(y - c)^2 / (2 s^2)), in grey values over pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Its middle c, in pixels.
    pub centre_px: f64,
    /// Its standard deviation s, in pixels; positive.
    pub sigma_px: f64,
    /// Its height a above the background, in grey values.
    pub height: f64,
    /// The background b below its middle, in grey values.
    pub background: f64,
    /// The background's slope g, in grey values a pixel.
    pub slope: f64,
}

/// Grey values in a row, next to each other.
#[derive(Clone, Copy, Debug)]
pub struct Profile<'a> {
    /// Where the first value stands, in pixels.
    pub first_px: usize,
    /// The values.
    pub values: &'a [u16],
    /// A pixel of this value or more is full.
    pub full: u16,
}

/// How far grey values scatter about a stripe's true profile: sqrt(`floor`^2 + (`speckle` signal)^2), the signal without background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileNoise {
    /// Standard deviation where there is no signal, in grey values; positive.
    pub floor: f64,
    /// Standard deviation as a share of the signal.
    pub speckle: f64,
}

/// A fitted profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianFit {
    /// The fitted shape.
    pub shape: Gaussian,
    /// Variance of its middle, in pixels squared, if the noise is what was said, or beside the stripe what it turned out to be.
    pub centre_variance_px2: f64,
    /// Sum of squared residuals, each over its standard deviation: about [`GaussianFit::freedom`] if the noise is what was assumed.
    pub chi2: f64,
    /// Values that counted, less the five parameters.
    pub freedom: usize,
    /// Whether the noise that was said explains what the fit misses the values by.
    pub is_explained: bool,
}

/// Full width at half maximum of a Gaussian of standard deviation 1: 2 sqrt(2 ln 2).
pub const FWHM: f64 = 2.354_820_045_030_949_3;

/// Steps of one minimisation; from a fair start four or five reach the settled place.
const STEPS: usize = 12;
/// A step that moves middle and width less than this, in pixels, ends it.
const SETTLED_PX: f64 = 1e-4;
/// A step that gains less than this share of the sum of squares ends it too.
const SETTLED: f64 = 1e-5;
/// A smaller share of the height is nothing.
const NOTHING: f64 = 1e-16;
/// Middle, logarithm of the width, height, background, its slope.
const PARAMETERS: usize = 5;
type Vector = SVector<f64, PARAMETERS>;
type Matrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

impl Gaussian {
    /// Full width at half maximum, in pixels.
    pub fn fwhm_px(&self) -> f64 {
        FWHM * self.sigma_px
    }

    /// Its share of the height, from 0 to 1, at each of `n` pixels from `first_px` on.
    ///
    /// Two exponentials a pixel apart differ by a factor that itself changes by the same factor from pixel to pixel: three exponentials do
    /// for all of them. From the middle outward everything shrinks, so that rounding errors do too.
    fn shares(&self, first_px: usize, n: usize) -> [f64; MOST] {
        let mut shares = [0.0; MOST];
        let n = n.min(MOST);
        if n == 0 {
            return shares;
        }
        let nearest = ((self.centre_px - first_px as f64).round().max(0.0) as usize).min(n - 1);
        let narrow = 1.0 / (self.sigma_px * self.sigma_px);
        let off = (first_px + nearest) as f64 - self.centre_px;
        let middle = libm::exp(-off * off * narrow / 2.0);
        let from_factor_to_factor = libm::exp(-narrow);
        shares[nearest] = middle;
        let (before, after) = shares[..n].split_at_mut(nearest);
        let outward = |places: &mut dyn Iterator<Item = &mut f64>, off: f64| {
            let (mut share, mut factor) = (middle, libm::exp(-(2.0 * off + 1.0) * narrow / 2.0));
            for place in places {
                share *= factor;
                if share < NOTHING {
                    break;
                }
                factor *= from_factor_to_factor;
                *place = share;
            }
        };
        outward(&mut after[1..].iter_mut(), off);
        outward(&mut before.iter_mut().rev(), -off);
        shares
    }

    /// Its value at y.
    fn at(&self, y_px: f64) -> f64 {
        self.background + self.slope * (y_px - self.centre_px) + self.height * self.share(y_px)
    }

    /// Its share of the height at y.
    fn share(&self, y_px: f64) -> f64 {
        let off = (y_px - self.centre_px) / self.sigma_px;
        libm::exp(-off * off / 2.0)
    }

    /// After a step in (c, ln s, a, b, g), of which b is the background where the middle was.
    fn stepped(&self, step: &Vector) -> Self {
        let slope = self.slope + step[4];
        Self {
            centre_px: self.centre_px + step[0],
            // No step more than doubles or halves the width.
            sigma_px: self.sigma_px * libm::exp(step[1].clamp(-0.7, 0.7)),
            height: self.height + step[2],
            background: self.background + step[3] + slope * step[0],
            slope,
        }
    }

    /// Whether it is a bump whose middle stands within the profile and whose width the profile can tell.
    fn is_within(&self, profile: &Profile<'_>) -> bool {
        let (first, length) = (profile.first_px as f64, profile.values.len() as f64);
        // No comparison with a NaN is true.
        self.height > 0.0
            && self.background.is_finite()
            && self.slope.is_finite()
            && self.height.is_finite()
            && (first - 0.5..=first + length - 0.5).contains(&self.centre_px)
            && (0.25..=length).contains(&self.sigma_px)
    }
}

/// The Gaussian that fits a profile best, sought from `start`; `None` where fewer than seven values count or the search leaves the
/// profile. Of a longer profile the 256 values about the start count.
pub fn fit(profile: &Profile<'_>, start: &Gaussian, noise: &ProfileNoise) -> Option<GaussianFit> {
    let profile = profile.about(start.centre_px, MOST as f64 / 2.0);
    let alike = ProfileNoise { floor: noise.floor + FIRST_FLOOR * start.height.abs(), speckle: 0.0 };
    let first = minimise(&profile, start, &alike.weights(&profile, start), PARAMETERS)?.0;
    if !first.is_within(&profile) {
        return None;
    }
    let profile = profile.about(first.centre_px, REACH * first.sigma_px + REACH_PX);
    let weighted = |noise: &ProfileNoise| minimise(&profile, &first, &noise.weights(&profile, &first), PARAMETERS + 2);
    let (mut shape, mut at) = weighted(noise)?;
    let is_explained = at.chi2 <= UNEXPLAINED * (at.counted - PARAMETERS) as f64;
    if !is_explained {
        (shape, at) = weighted(&ProfileNoise { floor: floor(&profile, &first, noise.floor), ..*noise })?;
    }
    if !shape.is_within(&profile) {
        return None;
    }
    let centre_variance_px2 = at.curvature.try_inverse()?[(0, 0)];
    let fitted = GaussianFit { shape, centre_variance_px2, chi2: at.chi2, freedom: at.counted - PARAMETERS, is_explained };
    (centre_variance_px2 > 0.0 && centre_variance_px2.is_finite() && at.chi2.is_finite()).then_some(fitted)
}

/// Most values that are looked at.
const MOST: usize = 256;
/// The floor of the first fit's noise as a share of the height: with the signal's own noise far below it, all values weigh the same.
const FIRST_FLOOR: f64 = 0.1;
/// The second fit reaches so many standard deviations to either side, and so many pixels more.
const REACH: f64 = 3.0;
/// See `REACH`.
const REACH_PX: f64 = 2.0;
/// Beside the stripe is where there is less than this share of its light.
const BESIDE: f64 = 0.1;
/// A fit that misses its values by so many times what noise explains, squared, is not of one Gaussian in noise.
const UNEXPLAINED: f64 = 2.5;

/// The noise beside a stripe: what was said, or what the fit misses the values by there if that is more.
fn floor(profile: &Profile<'_>, shape: &Gaussian, said: f64) -> f64 {
    let (mut n, mut squares) = (0, 0.0);
    for (i, value) in profile.values.iter().enumerate() {
        let y_px = (profile.first_px + i) as f64;
        if shape.share(y_px) < BESIDE {
            let residual = f64::from(*value) - shape.at(y_px);
            (n, squares) = (n + 1, squares + residual * residual);
        }
    }
    said.max((squares / f64::from(n.max(1))).sqrt())
}

impl<'a> Profile<'a> {
    /// The part of it within `reach_px` of a place.
    fn about(&self, place_px: f64, reach_px: f64) -> Self {
        let within = |at: f64| ((at - self.first_px as f64).max(0.0) as usize).min(self.values.len());
        let (from, to) = (within((place_px - reach_px).ceil()), within((place_px + reach_px).floor() + 1.0));
        let values: &'a [u16] = &self.values[from..to.max(from)];
        Self { first_px: self.first_px + from, values: &values[..values.len().min(MOST)], full: self.full }
    }
}

impl ProfileNoise {
    /// One over the variance of each value of a profile of this shape.
    fn weights(&self, profile: &Profile<'_>, shape: &Gaussian) -> [f64; MOST] {
        let mut weights = [0.0; MOST];
        let shares = shape.shares(profile.first_px, profile.values.len());
        for (weight, share) in weights.iter_mut().zip(shares).take(profile.values.len()) {
            let signal = self.speckle * shape.height * share;
            *weight = 1.0 / (self.floor * self.floor + signal * signal);
        }
        weights
    }
}

/// The weighted sum of squares at some shape, with its gradient and the Gauss-Newton curvature by (c, ln s, a, b, g).
struct Sum {
    chi2: f64,
    gradient: Vector,
    curvature: Matrix,
    counted: usize,
}

fn sum(profile: &Profile<'_>, at: &Gaussian, weights: &[f64; MOST]) -> Sum {
    let mut sum = Sum { chi2: 0.0, gradient: Vector::zeros(), curvature: Matrix::zeros(), counted: 0 };
    let shares = at.shares(profile.first_px, profile.values.len());
    for (i, ((value, weight), share)) in profile.values.iter().zip(weights).zip(shares).enumerate() {
        let from_middle = (profile.first_px + i) as f64 - at.centre_px;
        let off = from_middle / at.sigma_px;
        let residual = f64::from(*value) - (at.background + at.slope * from_middle + at.height * share);
        if *value >= profile.full && residual <= 0.0 {
            continue;
        }
        let lean = at.height * share * off;
        // The background stays where it is when the middle moves.
        let slope = Vector::from([lean / at.sigma_px, lean * off, share, 1.0, from_middle]);
        sum.chi2 += weight * residual * residual;
        for j in 0..PARAMETERS {
            let weighted = weight * slope[j];
            sum.gradient[j] += weighted * residual;
            // The lower half; the other one is its mirror.
            for k in 0..=j {
                sum.curvature[(j, k)] += weighted * slope[k];
            }
        }
        sum.counted += 1;
    }
    sum.curvature.fill_upper_triangle_with_lower_triangle();
    sum
}

/// Levenberg and Marquardt's method (Marquardt, SIAM J. 11(2), 1963).
fn minimise(profile: &Profile<'_>, start: &Gaussian, weights: &[f64; MOST], least_values: usize) -> Option<(Gaussian, Sum)> {
    let mut shape = *start;
    let mut at = sum(profile, &shape, weights);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let mut damped = at.curvature;
        (0..PARAMETERS).for_each(|i| damped[(i, i)] *= 1.0 + damping);
        let step = damped.cholesky()?.solve(&at.gradient);
        let tried = shape.stepped(&step);
        let there = sum(profile, &tried, weights);
        if there.chi2.is_nan() {
            return None;
        }
        if there.chi2 <= at.chi2 {
            let gained = at.chi2 - there.chi2;
            (shape, at) = (tried, there);
            damping *= 0.1;
            if gained <= SETTLED * at.chi2 {
                break;
            }
        } else {
            damping *= 10.0;
        }
        if step[0].abs().max(shape.sigma_px * step[1].abs()) < SETTLED_PX {
            break;
        }
    }
    (at.counted >= least_values).then_some((shape, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NOISE: ProfileNoise = ProfileNoise { floor: 0.3, speckle: 0.0 };

    fn values(shape: &Gaussian, full: f64) -> Vec<u16> {
        (0..32)
            .map(|y| {
                (shape.background + shape.slope * (f64::from(y) - shape.centre_px) + shape.height * shape.share(f64::from(y)))
                    .min(full)
                    .round() as u16
            })
            .collect()
    }

    proptest! {
        /// Factor by factor or each by itself: the same exponentials.
        #[test]
        fn shares_are_exponentials(centre_px in -20.0..60.0f64, sigma_px in 0.25..40.0f64, first_px in 0..20usize, n in 0..50usize) {
            let shape = Gaussian { centre_px, sigma_px, height: 1.0, background: 0.0, slope: 0.0 };
            let shares = shape.shares(first_px, n);
            for (i, share) in shares[..n].iter().enumerate() {
                let expected = shape.share((first_px + i) as f64);
                prop_assert!((share - expected).abs() < 1e-13, "{i}: {share} {expected}");
            }
            prop_assert!(shares[n..].iter().all(|share| *share == 0.0));
        }

        /// What was put in comes out, to what rounding to whole grey values leaves: 0.3 of a value over a slope of 1000 values and
        /// more a pixel. Full pixels are made up for by the flanks.
        #[test]
        fn a_gaussian_is_found_again(
            centre_px in 12.0..20.0f64, sigma_px in 1.0..3.0f64, height in 8e3..4e4f64, background in 1e3..2e3f64,
            slope in -40.0..40.0f64, clip in 0.5..1.2f64,
        ) {
            let shape = Gaussian { centre_px, sigma_px, height, background, slope };
            let full = (background + clip * height).round();
            let values = values(&shape, full);
            let profile = Profile { first_px: 0, values: &values, full: full as u16 };
            let start =
                Gaussian { centre_px: centre_px.round(), sigma_px: 1.5 * sigma_px, height: 0.7 * height, background: 0.0, slope: 0.0 };
            let fitted = fit(&profile, &start, &NOISE).expect("a Gaussian");
            prop_assert!((fitted.shape.centre_px - centre_px).abs() < 2e-3, "{fitted:?}");
            prop_assert!((fitted.shape.sigma_px - sigma_px).abs() < 5e-3, "{fitted:?}");
            prop_assert!((fitted.shape.height - height).abs() < 0.01 * height, "{fitted:?}");
        }

        /// Whatever the values, no panic, and what comes back is finite.
        #[test]
        fn any_values_give_finite_numbers_or_none(values in prop::collection::vec(any::<u16>(), 0..40), full in any::<u16>()) {
            let profile = Profile { first_px: 100, values: &values, full };
            let start = Gaussian { centre_px: 110.0, sigma_px: 2.0, height: 500.0, background: 10.0, slope: 0.0 };
            let fitted = fit(&profile, &start, &ProfileNoise { speckle: 0.1, ..NOISE });
            if let Some(GaussianFit { shape, centre_variance_px2, chi2, .. }) = fitted {
                let numbers = [shape.centre_px, shape.sigma_px, shape.height, shape.background, centre_variance_px2, chi2];
                prop_assert!(numbers.iter().all(|x| x.is_finite()), "{shape:?}");
                prop_assert!(shape.sigma_px > 0.0 && centre_variance_px2 > 0.0);
            }
        }
    }

    /// A stripe in a halo five times as wide and a fifth as high, off its middle by 3 px: the core decides.
    #[test]
    fn a_halo_does_not_pull_the_middle_far() {
        let core = Gaussian { centre_px: 60.3, sigma_px: 2.0, height: 800.0, background: 100.0, slope: 0.0 };
        let halo = Gaussian { centre_px: 63.3, sigma_px: 10.0, height: 160.0, background: 0.0, slope: 0.0 };
        let values: Vec<u16> = (0..120).map(|y| (core.at(f64::from(y)) + halo.at(f64::from(y))).round() as u16).collect();
        for sigma_px in [1.5, 4.0] {
            let start = Gaussian { centre_px: 61.0, sigma_px, height: 900.0, background: 100.0, slope: 0.0 };
            let fitted = fit(&Profile { first_px: 0, values: &values, full: u16::MAX }, &start, &NOISE).expect("a Gaussian");
            // The halo's slope below the core, 160 / (10 sqrt(e)) a pixel at most, moves a least-squares middle by less than 0.1 px.
            assert!((fitted.shape.centre_px - 60.3).abs() < 0.1 && (fitted.shape.sigma_px - 2.0).abs() < 0.4, "{fitted:?}");
        }
    }

    /// The stated variance against the scatter of many profiles with noise of known size.
    #[test]
    fn the_stated_variance_is_the_scatter() {
        let shape = Gaussian { centre_px: 15.3, sigma_px: 1.7, height: 900.0, background: 100.0, slope: 2.0 };
        let mut state = 1_u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        // Twelve uniform numbers add up to a normal one, nearly.
        let mut normal = move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let noise = ProfileNoise { floor: 8.0, speckle: 0.1 };
        let (mut squares, mut stated, mut chi2, mut freedom) = (0.0, 0.0, 0.0, 0);
        const ROUNDS: usize = 2000;
        for _ in 0..ROUNDS {
            let value = |y: i32| {
                let signal = shape.height * shape.share(f64::from(y));
                shape.background
                    + shape.slope * (f64::from(y) - shape.centre_px)
                    + signal * (1.0 + noise.speckle * normal())
                    + noise.floor * normal()
            };
            let values: Vec<u16> = (0..32).map(value).map(|x| x.round().max(0.0) as u16).collect();
            let fitted = fit(&Profile { first_px: 0, values: &values, full: u16::MAX }, &shape, &noise).expect("a Gaussian");
            squares += (fitted.shape.centre_px - shape.centre_px).powi(2);
            stated += fitted.centre_variance_px2;
            (chi2, freedom) = (chi2 + fitted.chi2, freedom + fitted.freedom);
        }
        // The variance of a variance from 2000 values is 2/2000: 3 % as a standard deviation, three of them and a bias of 5 %.
        let ratio = squares / stated;
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
        let reduced = chi2 / freedom as f64;
        assert!((0.9..1.1).contains(&reduced), "{reduced}");
    }
}
