//! Parameters of the robust perception pipeline.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] =
    &[TableRow::new("perception.robust", "The robust pipeline: what it takes a stripe, a wall and the camera's noise for.")];

pub(super) const FIELDS: &[Field] = &[
    Field::number("perception.robust.contrast_dn", 0.1, 255.0, |s| &mut s.perception.robust.contrast_dn)
        .unit("DN")
        .default("1.0")
        .about("Least height of a stripe above what is beside it, averaged over its middle."),
    Field::number("perception.robust.psf_sigma_px", 0.0, 10.0, |s| &mut s.perception.robust.psf_sigma_px)
        .unit("px")
        .default("0.6")
        .about("The lens' point spread as the navigator knows it, for the expected thickness."),
    Field::number("perception.robust.full_well_e", 100.0, 1e7, |s| &mut s.perception.robust.full_well_e)
        .unit("e")
        .default("30000.0")
        .about("Full well as the navigator knows it: what shot noise is reckoned from."),
    Field::number("perception.robust.read_noise_e", 0.0, 1e4, |s| &mut s.perception.robust.read_noise_e)
        .unit("e")
        .default("15.0")
        .about("Read noise as the navigator knows it."),
    Field::number("perception.robust.black_dn", 0.0, 128.0, |s| &mut s.perception.robust.black_dn)
        .unit("DN")
        .default("8.0")
        .about("Black level as the navigator knows it."),
    Field::number("perception.robust.fan_edge", 0.01, 1.0, |s| &mut s.perception.robust.fan_edge)
        .default("0.8")
        .about("Light at the ends of a laser's fan as a share of that in its middle, as the navigator knows it."),
    Field::number("perception.robust.speckle_contrast", 0.0, 1.0, |s| &mut s.perception.robust.speckle_contrast)
        .default("0.12")
        .about("Contrast of the lasers' speckle in a pixel as the navigator knows it."),
    Field::numbers("perception.robust.range_m", 2, 0.02, 50.0, |s| &mut s.perception.robust.range_m)
        .unit("m")
        .default("[0.08, 4.0]")
        .about("Least and greatest depth at which stripes are sought."),
    Field::number("perception.robust.max_heading_deg", 1.0, 89.0, |s| &mut s.perception.robust.max_heading_rad)
        .degrees()
        .default("35.0")
        .about("Largest heading against a wall that is taken for one."),
    Field::number("perception.robust.lean_deg", 0.001, 20.0, |s| &mut s.perception.robust.lean_rad)
        .degrees()
        .default("0.2")
        .about("How far walls may lean against the robot's own upright: standard deviation."),
    Field::number("perception.robust.offset_px", 0.0001, 10.0, |s| &mut s.perception.robust.offset_px)
        .unit("px")
        .default("0.004")
        .about("Error that all centres of a stripe have in common: standard deviation ..."),
    Field::number("perception.robust.offset_share", 0.0, 1.0, |s| &mut s.perception.robust.offset_share)
        .default("0.0008")
        .about("... and what is added to it, as a share of the stripe's thickness (standard deviation)."),
    Field::size("perception.robust.min_centres", 3, 8192, |s| &mut s.perception.robust.min_centres)
        .default("24")
        .about("Fewest stripe centres that a wall is believed on."),
];
