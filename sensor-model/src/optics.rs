//! Parameters of light, lens and CCD: what turns geometry into grey values. The equations are in `docs/sensor-model.md`.
//!
//! The defaults are the noise that every figure of this project is quoted with. No data sheet of INCRA I's camera was found;
//! full well and read noise are typical of a 7.4 um interline CCD (assumption). What the defaults leave at zero (dark current,
//! DSNU, hot pixels, blooming, defocus, ghosts, the bounce) is there to be switched on.
//!
//! Grey values (DN) are those of an 8-bit image wherever a name ends in `_dn`; with 10 or 12 bits the same light gives 4 or 16
//! times (more exactly, 1023/255 and 4095/255 times) the number.

/// Light, lens and sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Exposure for which the grey values below hold, in seconds.
    pub exposure_s: f64,
    /// Grey value above black of a stripe's peak, at full laser power, on a matt wall of albedo 1/2 met squarely at `REFERENCE_M`
    /// from the source, in the middle of the fan and of the image, before the point spread.
    pub stripe_peak_dn: f64,
    /// Grey value above black that the headlamp, a point at the camera, gives the same wall at the same place; 0 switches it off.
    pub headlamp_peak_dn: f64,
    /// Grey value above black at which an open end is seen, evenly bright (daylight through a grille); 0 is a dark room.
    pub ambient_dn: f64,
    /// How the light is spread along the fans.
    pub fan_profile: FanProfile,
    /// Contrast of the speckle in the lasers' light: standard deviation over mean of a pixel; 0 switches it off. It belongs to the
    /// image plane, so the point spread does not blur it; it is drawn anew for each frame.
    pub speckle_contrast: f64,
    /// Size of a speckle grain in the image, in pixels: from 1, where every pixel has its own.
    pub speckle_grain_px: f64,
    /// Whether bodies standing in the duct cast shadows in the lasers' light; walls always do.
    pub shadows: bool,
    /// Whether stripes are seen again where a wall mirrors them. Needs surfaces that are not matt.
    pub ghosts: bool,
    /// Whether stripes light up the walls about them (one bounce).
    pub bounce: bool,
    /// The lens.
    pub lens: Lens,
    /// The CCD.
    pub ccd: Ccd,
    /// Whether anything random (shot, dark and read noise, PRNU, DSNU, hot pixels, speckle) is applied.
    pub noise: bool,
}

/// How a laser's light is spread along its fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FanProfile {
    /// A Powell lens: a clipped Gaussian that keeps this share of the middle's light at the fan's edges, from 0.01 to 1.
    Powell {
        /// The share.
        edge: f64,
    },
    /// A cylinder lens: a Gaussian whose 1/e^2 points are the fan's edges, with ends that fade beyond them.
    Cylinder,
}

/// What the lens does beyond the pinhole and its distortion.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Standard deviation of the point spread in focus, in pixels, before it is integrated over the pixel (which adds a variance
    /// of 1/12 px^2).
    pub psf_sigma_px: f64,
    /// Whether light falls off with the fourth power of the cosine of the angle from the optical axis.
    pub vignetting: bool,
    /// Diameter of the entrance pupil, in metres; 0 keeps everything in focus.
    pub aperture_m: f64,
    /// Distance along the view that is in focus, in metres.
    pub focus_m: f64,
    /// Whether what moves during the exposure is blurred.
    pub motion_blur: bool,
}

/// The CCD, after EMVA 1288 (release 4.0): electrons in, grey values out.
#[derive(Clone, Debug, PartialEq)]
pub struct Ccd {
    /// Electrons at which a pixel is full; it then reads the largest number.
    pub full_well_e: f64,
    /// Standard deviation of the read noise (EMVA's sigma_d at no exposure), in electrons.
    pub read_noise_e: f64,
    /// Grey value of no light, in DN of 8 bits.
    pub black_level_dn: f64,
    /// Photo-response non-uniformity: standard deviation of the pixels' gains over their mean.
    pub prnu: f64,
    /// Dark signal non-uniformity: standard deviation of the pixels' dark values, in electrons.
    pub dsnu_e: f64,
    /// Dark current, in electrons a second.
    pub dark_current_e_s: f64,
    /// Share of the pixels that are hot.
    pub hot_pixels: f64,
    /// Mean additional dark current of a hot pixel, in electrons a second; it is distributed exponentially.
    pub hot_pixel_e_s: f64,
    /// Share of the charge beyond the full well that spills along the column, half up and half down; the rest is drained.
    pub blooming: f64,
    /// Bits of a grey value.
    pub bits: Bits,
}

/// How finely grey values are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// 0 to 255.
    #[default]
    Eight,
    /// 0 to 1023.
    Ten,
    /// 0 to 4095.
    Twelve,
}

/// Distance at which peak grey values are stated, from the source, in metres.
pub const REFERENCE_M: f64 = 0.3;

/// Albedo for which they are stated.
pub const REFERENCE_ALBEDO: f64 = 0.5;

/// Widest point spread of a lens in focus, in pixels.
pub const PSF_SIGMA_MAX_PX: f64 = 1.2;

impl Default for Optics {
    fn default() -> Self {
        Self {
            exposure_s: 4e-3,
            stripe_peak_dn: 180.0,
            headlamp_peak_dn: 20.0,
            ambient_dn: 0.0,
            fan_profile: FanProfile::Powell { edge: 0.8 },
            speckle_contrast: 0.12,
            speckle_grain_px: 1.0,
            shadows: true,
            ghosts: false,
            bounce: false,
            lens: Lens::default(),
            ccd: Ccd::default(),
            noise: true,
        }
    }
}

impl Default for Lens {
    fn default() -> Self {
        Self { psf_sigma_px: 0.6, vignetting: true, aperture_m: 0.0, focus_m: 0.5, motion_blur: true }
    }
}

impl Default for Ccd {
    fn default() -> Self {
        Self {
            full_well_e: 30_000.0,
            read_noise_e: 15.0,
            black_level_dn: 8.0,
            prnu: 0.01,
            dsnu_e: 0.0,
            dark_current_e_s: 0.0,
            hot_pixels: 0.0,
            hot_pixel_e_s: 0.0,
            blooming: 0.0,
            bits: Bits::Eight,
        }
    }
}

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
        let (lens, ccd) = (&self.lens, &self.ccd);
        let edge = match self.fan_profile {
            FanProfile::Powell { edge } => edge,
            FanProfile::Cylinder => 1.0,
        };
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let not_negative = |v: f64| v >= 0.0 && v.is_finite();
        let share = |v: f64| (0.0..=1.0).contains(&v);
        let rules: [(&'static str, f64, bool, &'static str); 18] = [
            ("exposure_s", self.exposure_s, positive(self.exposure_s), "positive"),
            ("stripe_peak_dn", self.stripe_peak_dn, not_negative(self.stripe_peak_dn), "0 or more"),
            ("headlamp_peak_dn", self.headlamp_peak_dn, not_negative(self.headlamp_peak_dn), "0 or more"),
            ("ambient_dn", self.ambient_dn, not_negative(self.ambient_dn), "0 or more"),
            ("fan_edge", edge, (0.01..=1.0).contains(&edge), "from 0.01 to 1"),
            ("speckle_contrast", self.speckle_contrast, share(self.speckle_contrast), "from 0 to 1"),
            ("speckle_grain_px", self.speckle_grain_px, (1.0..=16.0).contains(&self.speckle_grain_px), "from 1 to 16"),
            ("psf_sigma_px", lens.psf_sigma_px, (0.0..=PSF_SIGMA_MAX_PX).contains(&lens.psf_sigma_px), "from 0 to 1.2"),
            ("aperture_m", lens.aperture_m, (0.0..=0.05).contains(&lens.aperture_m), "from 0 to 0.05 m"),
            ("focus_m", lens.focus_m, lens.focus_m >= 0.01, "0.01 m or more"),
            ("full_well_e", ccd.full_well_e, ccd.full_well_e >= 1.0 && ccd.full_well_e.is_finite(), "1 or more"),
            ("read_noise_e", ccd.read_noise_e, not_negative(ccd.read_noise_e), "0 or more"),
            ("black_level_dn", ccd.black_level_dn, (0.0..255.0).contains(&ccd.black_level_dn), "from 0 to less than 255"),
            ("prnu", ccd.prnu, (0.0..=0.2).contains(&ccd.prnu), "from 0 to 0.2"),
            ("dsnu_e", ccd.dsnu_e, not_negative(ccd.dsnu_e), "0 or more"),
            ("dark_current_e_s", ccd.dark_current_e_s, not_negative(ccd.dark_current_e_s), "0 or more"),
            ("hot_pixel_e_s", ccd.hot_pixel_e_s, not_negative(ccd.hot_pixel_e_s), "0 or more"),
            (
                "hot_pixels or blooming",
                ccd.hot_pixels.max(ccd.blooming),
                share(ccd.hot_pixels) && share(ccd.blooming),
                "from 0 to 1",
            ),
        ];
        match rules.into_iter().find(|(.., holds, _)| !holds) {
            Some((field, value, _, bound)) => Err(OpticsError { field, value, bound }),
            None => Ok(()),
        }
    }
}

impl Ccd {
    /// Grey values of 8 bits for one electron: a full well reads the largest number.
    pub fn dn_per_electron(&self) -> f64 {
        (255.0 - self.black_level_dn) / self.full_well_e
    }
}

impl Bits {
    /// The number of bits.
    pub fn count(self) -> u32 {
        match self {
            Self::Eight => 8,
            Self::Ten => 10,
            Self::Twelve => 12,
        }
    }

    /// The largest grey value.
    pub fn max_dn(self) -> u32 {
        (1 << self.count()) - 1
    }
}
