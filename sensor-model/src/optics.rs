//! Parameters of light, surface and CCD: what turns geometry into grey values.
//!
//! The defaults are the noise that every figure of this project is quoted with. No data sheet of INCRA I's camera was found;
//! full well and read noise are typical of a 7.4 um interline CCD (assumption).

/// Light and sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Exposure for which the peaks below hold, in seconds.
    pub exposure_s: f64,
    /// Grey value above black of a stripe's peak, at full laser power, on a wall of albedo 1/2 met squarely at `REFERENCE_M`.
    pub stripe_peak_dn: f64,
    /// Grey value above black that the headlamp gives the same wall at the same place; 0 switches it off.
    pub headlamp_peak_dn: f64,
    /// Light at the fan's edge as a share of its middle (0.8: Powell lens).
    pub fan_edge: f64,
    /// Standard deviation of the point spread, in pixels.
    pub psf_sigma_px: f64,
    /// Contrast of the speckle in the lasers' light: standard deviation over mean of a pixel; 0 switches it off.
    pub speckle_contrast: f64,
    /// The CCD.
    pub ccd: Ccd,
    /// Whether anything random (shot and read noise, PRNU, speckle) is applied.
    pub noise: bool,
}

/// The CCD, after EMVA 1288: electrons in, grey values out.
#[derive(Clone, Debug, PartialEq)]
pub struct Ccd {
    /// Electrons at which a pixel is full; it then reads 255 DN.
    pub full_well_e: f64,
    /// Standard deviation of the read noise, in electrons.
    pub read_noise_e: f64,
    /// Grey value of no light, in DN.
    pub black_level_dn: f64,
    /// Photo-response non-uniformity: standard deviation of the pixels' gains over their mean.
    pub prnu: f64,
}

/// Distance at which peak grey values are stated, from the source, in metres.
pub const REFERENCE_M: f64 = 0.3;

/// Albedo for which they are stated.
pub const REFERENCE_ALBEDO: f64 = 0.5;

/// What a surface looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Share of the light that it scatters, evenly in all directions (Lambert).
    pub albedo: f64,
}

impl Default for Optics {
    fn default() -> Self {
        Self {
            exposure_s: 4e-3,
            stripe_peak_dn: 180.0,
            headlamp_peak_dn: 20.0,
            fan_edge: 0.8,
            psf_sigma_px: 0.6,
            speckle_contrast: 0.12,
            ccd: Ccd::default(),
            noise: true,
        }
    }
}

impl Default for Ccd {
    fn default() -> Self {
        Self { full_well_e: 30_000.0, read_noise_e: 15.0, black_level_dn: 8.0, prnu: 0.01 }
    }
}

impl Ccd {
    /// Grey values for one electron.
    pub fn dn_per_electron(&self) -> f64 {
        (255.0 - self.black_level_dn) / self.full_well_e
    }
}
