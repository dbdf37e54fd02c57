//! Lens and CCD: what becomes of the light between pupil and grey value.

use ductloop_sensor::optics::Bits;

use super::field::Slot;
use super::{Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("sensor.lens", "What the lens does beyond the pinhole and its distortion."),
    TableRow::new("sensor.ccd", "The CCD, after EMVA 1288."),
];

fn bits(count: i64) -> Bits {
    match count {
        10 => Bits::Ten,
        12 => Bits::Twelve,
        _ => Bits::Eight,
    }
}

pub(super) const FIELDS: &[Field] = &[
    Field::number("sensor.lens.psf_sigma_px", 0.0, 1.2, |s| &mut s.optics.lens.psf_sigma_px)
        .unit("px")
        .default("0.6")
        .about("Standard deviation of the point spread in focus."),
    Field::new("sensor.lens.vignetting", Kind::Flag, Slot::Flag(|s| &mut s.optics.lens.vignetting))
        .default("true")
        .about("Whether light falls off with the fourth power of the cosine of the angle from the optical axis."),
    Field::number("sensor.lens.aperture_mm", 0.0, 50.0, |s| &mut s.optics.lens.aperture_m)
        .milli("mm")
        .default("0.0")
        .about("Diameter of the entrance pupil; 0 keeps everything in focus."),
    Field::number("sensor.lens.focus_m", 0.01, 1000.0, |s| &mut s.optics.lens.focus_m)
        .unit("m")
        .default("0.5")
        .about("Distance along the view that is in focus."),
    Field::new("sensor.lens.motion_blur", Kind::Flag, Slot::Flag(|s| &mut s.optics.lens.motion_blur))
        .default("true")
        .about("Whether what moves during the exposure is blurred."),
    Field::new(
        "sensor.ccd.bits",
        Kind::Choice(&[8, 10, 12]),
        Slot::Choice { get: |s| i64::from(s.optics.ccd.bits.count()), set: |s, count| s.optics.ccd.bits = bits(count) },
    )
    .default("8")
    .about("Bits of a grey value; fields in DN are those of 8 bits all the same."),
    Field::number("sensor.ccd.full_well_e", 100.0, 1e6, |s| &mut s.optics.ccd.full_well_e)
        .unit("electrons")
        .default("30000.0")
        .about("Electrons at which a pixel is full and reads the largest grey value."),
    Field::number("sensor.ccd.read_noise_e", 0.0, 1e4, |s| &mut s.optics.ccd.read_noise_e)
        .unit("electrons")
        .default("15.0")
        .about("Standard deviation of the read noise."),
    Field::number("sensor.ccd.black_level_dn", 0.0, 200.0, |s| &mut s.optics.ccd.black_level_dn)
        .unit("DN")
        .default("8.0")
        .about("Grey value of no light."),
    Field::number("sensor.ccd.prnu", 0.0, 0.2, |s| &mut s.optics.ccd.prnu)
        .default("0.01")
        .about("Standard deviation of the pixels' gains over their mean."),
    Field::number("sensor.ccd.dsnu_e", 0.0, 1e4, |s| &mut s.optics.ccd.dsnu_e)
        .unit("electrons")
        .default("0.0")
        .about("Standard deviation of the pixels' dark values."),
    Field::number("sensor.ccd.dark_current_e_s", 0.0, 1e6, |s| &mut s.optics.ccd.dark_current_e_s)
        .unit("electrons/s")
        .default("0.0")
        .about("Dark current of every pixel."),
    Field::number("sensor.ccd.hot_pixels", 0.0, 1.0, |s| &mut s.optics.ccd.hot_pixels)
        .default("0.0")
        .about("Share of the pixels that are hot."),
    Field::number("sensor.ccd.hot_pixel_e_s", 0.0, 1e8, |s| &mut s.optics.ccd.hot_pixel_e_s)
        .unit("electrons/s")
        .default("0.0")
        .about("Mean additional dark current of a hot pixel; it is distributed exponentially."),
    Field::number("sensor.ccd.blooming", 0.0, 1.0, |s| &mut s.optics.ccd.blooming)
        .default("0.0")
        .about("Share of the charge beyond the full well that spills along the column; the rest is drained."),
];
