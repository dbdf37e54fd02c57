//! What the pixels of one column say of the middles of the stripes that cross it.
//!
//! A pixel at the distance a across the stripe from its middle collects the stripe's Gaussian over its square
//! (`docs/sensor-model.md`, section 4); its variance is that of EMVA 1288 with the speckle's and the unequal pixels' shares of the
//! light. Unknown are the middles, which are sought, and each stripe's amplitude and the column's background, which are not.

use ductloop_sensor::optics::Optics;
use nalgebra::SMatrix;

/// Most stripes that are read together.
pub const MOST_STRIPES: usize = 4;
/// Middles, amplitudes, background.
const UNKNOWNS: usize = 2 * MOST_STRIPES + 1;
/// How far a stripe's light reaches, in standard deviations: beyond 6 it is 1e-8 of its peak.
const REACH_SIGMAS: f64 = 6.0;

/// A stripe in a column (or row).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripe {
    /// Its middle, in pixels along the column.
    pub centre_px: f64,
    /// Light across it, summed: amplitude times sqrt(2 pi) times standard deviation, in DN px of 8 bits.
    pub light_dn_px: f64,
    /// Its standard deviation across it, with that of the lens and of the pixel's shorter extent, in pixels.
    pub sigma_px: f64,
    /// Cosine of the angle between the column and the direction across the stripe; positive.
    pub cosine: f64,
    /// Light of anything else that is even about here, in DN of 8 bits above black.
    pub background_dn: f64,
}

/// The noise of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// K: grey values of 8 bits for an electron.
    pub dn_per_electron: f64,
    /// Variance without light: read noise, dark current and quantisation, in DN^2.
    pub dark_dn2: f64,
    /// Relative variance of the lasers' light: speckle.
    pub speckle2: f64,
    /// Relative variance of all light: unequal pixels.
    pub gain2: f64,
    /// Grey value above black at which a pixel is full.
    pub full_dn: f64,
    /// Lines of the image that share a grain of speckle.
    pub grain_px: f64,
}

impl Noise {
    /// Of a CCD at an exposure.
    pub fn of(optics: &Optics, exposure_s: f64) -> Self {
        let ccd = &optics.ccd;
        let k = ccd.dn_per_electron();
        // A step of more than 8 bits is a smaller part of a grey value of 8 bits.
        let step_dn = 255.0 / f64::from(ccd.bits.max_dn());
        let dark_e = ccd.read_noise_e * ccd.read_noise_e + ccd.dark_current_e_s * exposure_s;
        let on = f64::from(u8::from(optics.noise));
        Self {
            dn_per_electron: k * on,
            dark_dn2: on * (k * k * dark_e + k * k * ccd.dsnu_e * ccd.dsnu_e) + step_dn * step_dn / 12.0,
            speckle2: on * optics.speckle_contrast * optics.speckle_contrast,
            gain2: on * ccd.prnu * ccd.prnu,
            full_dn: 255.0 - ccd.black_level_dn,
            grain_px: optics.speckle_grain_px,
        }
    }

    /// Variance of a pixel, in DN^2. A grain of g x g pixels varies as one: what is averaged over several pixels then varies g^2
    /// times as much, which holds as long as a grain is small against the stripe.
    pub fn variance_dn2(&self, laser_dn: f64, even_dn: f64) -> f64 {
        let grain2 = self.grain_px * self.grain_px;
        self.dark_dn2
            + self.dn_per_electron * (laser_dn + even_dn)
            + self.speckle2 * grain2 * laser_dn * laser_dn
            + self.gain2 * (laser_dn + even_dn) * (laser_dn + even_dn)
    }
}

impl Stripe {
    /// How far its light reaches along the column, in pixels.
    pub fn reach_px(&self) -> f64 {
        (REACH_SIGMAS * self.sigma_px + 1.0) / self.cosine
    }

    /// Light in the pixel at `at_px`, and its derivative by the middle: DN and DN / px.
    pub fn light(&self, at_px: f64) -> (f64, f64) {
        const SQRT_TAU: f64 = 2.506_628_274_631_000_5;
        let (across_px, half_px) = ((at_px - self.centre_px) * self.cosine, self.longer_px() / 2.0);
        let z = [across_px + half_px, across_px - half_px].map(|edge| edge / self.sigma_px);
        let below = |z: f64| 0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2);
        let density = |z: f64| libm::exp(-0.5 * z * z) / SQRT_TAU;
        let scale = self.light_dn_px / (2.0 * half_px);
        let value = scale * (below(z[0]) - below(z[1]));
        let slope = -scale * self.cosine * (density(z[0]) - density(z[1])) / self.sigma_px;
        (value, slope)
    }

    /// The larger of the extents of the pixel's sides across the stripe.
    fn longer_px(&self) -> f64 {
        self.cosine.max((1.0 - self.cosine * self.cosine).max(0.0).sqrt())
    }
}

/// Fisher information of the middles that are sought, in 1/px^2, the amplitudes, the background and the other middles not being
/// known. Rows and columns beyond the stripes, and of those that are not sought, are zero.
///
/// With Gaussian noise of a known variance it is the sum over the pixels of the products of the mean's derivatives over the
/// variance. Speckle's gamma distribution says as much of its scale as a normal distribution of its variance, shot noise likewise;
/// what variances say beyond the means is left out.
pub fn information(stripes: &[Stripe], sought: &[bool], noise: &Noise) -> SMatrix<f64, MOST_STRIPES, MOST_STRIPES> {
    let stripes = &stripes[..stripes.len().min(MOST_STRIPES)];
    let from = stripes.iter().map(|s| s.centre_px - s.reach_px()).fold(f64::INFINITY, f64::min).floor();
    let to = stripes.iter().map(|s| s.centre_px + s.reach_px()).fold(f64::NEG_INFINITY, f64::max).ceil();
    let even_dn = stripes.iter().map(|s| s.background_dn).sum::<f64>() / stripes.len().max(1) as f64;
    let mut all = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut at_px = from;
    while at_px <= to {
        let lights: Vec<(f64, f64)> = stripes.iter().map(|stripe| stripe.light(at_px)).collect();
        let laser_dn: f64 = lights.iter().map(|(value, _)| value).sum();
        // What is full says nothing.
        if laser_dn + even_dn < noise.full_dn {
            let mut by = SMatrix::<f64, UNKNOWNS, 1>::zeros();
            for (i, (stripe, (value, slope))) in stripes.iter().zip(&lights).enumerate() {
                by[i] = *slope;
                by[MOST_STRIPES + i] = value / stripe.light_dn_px.max(f64::MIN_POSITIVE);
            }
            by[2 * MOST_STRIPES] = 1.0;
            all += by * by.transpose() / noise.variance_dn2(laser_dn, even_dn);
        }
        at_px += 1.0;
    }
    marginal(all, stripes.len(), sought)
}

/// The part of the information that is left of what is sought once the rest has to be found as well (Schur's complement), one
/// unknown after the other.
fn marginal(
    mut all: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    count: usize,
    sought: &[bool],
) -> SMatrix<f64, MOST_STRIPES, MOST_STRIPES> {
    let is_sought = |i: usize| i < count && sought.get(i).copied().unwrap_or(false);
    for out in (0..UNKNOWNS).rev().filter(|i| !is_sought(*i)) {
        let pivot = all[(out, out)];
        // What nothing is said of takes nothing away.
        if pivot > 0.0 {
            let column = all.column(out).into_owned();
            all -= column * column.transpose() / pivot;
        }
        all.row_mut(out).fill(0.0);
        all.column_mut(out).fill(0.0);
    }
    all.fixed_view::<MOST_STRIPES, MOST_STRIPES>(0, 0).into()
}
