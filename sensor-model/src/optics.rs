//! Parameters of light, surface and CCD: what turns geometry into grey values.
//!
//! The defaults are the noise that every figure of this project is quoted with. No data sheet of INCRA I's camera was found;
//! full well and read noise are typical of a 7.4 um interline CCD (assumption).
//!
//! Left out: dark current and its non-uniformity between pixels (DSNU), so that no light is the same black level at every pixel,
//! exposure and temperature; and vignetting, so that the image's corners are as bright as its middle, without the lens' cos^4
//! or its barrel's shade. How the slits' width grows is said in [`crate::light`].

/// Light and sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Exposure for which the peaks below hold, in seconds.
    pub exposure_s: f64,
    /// Grey value above black of a stripe's peak, at full laser power, on a wall of albedo 1/2 met squarely at `REFERENCE_M`
    /// from the source, in the middle of the fan, before the point spread.
    pub stripe_peak_dn: f64,
    /// Grey value above black that the headlamp gives the same wall at the same place; 0 switches it off.
    pub headlamp_peak_dn: f64,
    /// Light at the fan's edge as a share of its middle (0.8: Powell lens).
    pub fan_edge: f64,
    /// Standard deviation of the point spread, in pixels, before it is integrated over the pixel (which adds a variance of
    /// 1/12 px^2).
    pub psf_sigma_px: f64,
    /// Contrast of the speckle in the lasers' light: standard deviation over mean of a pixel; 0 switches it off. The grain is
    /// one pixel and belongs to the image plane, so the point spread does not blur it; it is drawn anew for each frame.
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

/// Widest point spread that the renderers' seven taps hold, in pixels: 3.5 px are then 2.9 standard deviations.
pub const PSF_SIGMA_MAX_PX: f64 = 1.2;

/// A parameter out of its bounds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} is {value}; it must be {bound}")]
pub struct OpticsError {
    /// The field's name.
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be.
    pub bound: &'static str,
}

impl Optics {
    /// Checks every bound that the renderers rely on.
    ///
    /// # Errors
    /// The first field out of its bounds.
    pub fn validate(&self) -> Result<(), OpticsError> {
        let ccd = &self.ccd;
        let not_negative = |v: f64| v >= 0.0 && v.is_finite();
        let rules: [(&'static str, f64, bool, &'static str); 10] = [
            ("exposure_s", self.exposure_s, self.exposure_s > 0.0 && self.exposure_s.is_finite(), "positive"),
            ("stripe_peak_dn", self.stripe_peak_dn, not_negative(self.stripe_peak_dn), "0 or more"),
            ("headlamp_peak_dn", self.headlamp_peak_dn, not_negative(self.headlamp_peak_dn), "0 or more"),
            ("fan_edge", self.fan_edge, self.fan_edge > 0.0 && self.fan_edge <= 1.0, "above 0 and at most 1"),
            ("psf_sigma_px", self.psf_sigma_px, (0.0..=PSF_SIGMA_MAX_PX).contains(&self.psf_sigma_px), "from 0 to 1.2"),
            ("speckle_contrast", self.speckle_contrast, (0.0..=1.0).contains(&self.speckle_contrast), "from 0 to 1"),
            ("full_well_e", ccd.full_well_e, ccd.full_well_e >= 1.0 && ccd.full_well_e.is_finite(), "1 or more"),
            ("read_noise_e", ccd.read_noise_e, not_negative(ccd.read_noise_e), "0 or more"),
            ("black_level_dn", ccd.black_level_dn, (0.0..255.0).contains(&ccd.black_level_dn), "from 0 to less than 255"),
            ("prnu", ccd.prnu, (0.0..=0.2).contains(&ccd.prnu), "from 0 to 0.2"),
        ];
        match rules.into_iter().find(|(.., holds, _)| !holds) {
            Some((field, value, _, bound)) => Err(OpticsError { field, value, bound }),
            None => Ok(()),
        }
    }
}

impl Ccd {
    /// Grey values for one electron.
    pub fn dn_per_electron(&self) -> f64 {
        (255.0 - self.black_level_dn) / self.full_well_e
    }
}
