//! The duct, and what its sheets look and feel like.

use super::fitting::end;
use super::{Field, Kind, TableRow};
use crate::scenario::model::end_word;

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("duct", "The duct: its cross-section where it begins, and fittings joined one after the other."),
    TableRow::new(
        "surface.*",
        "A surface under a name of its own; it defines one, or overrides one that comes with the program.",
    ),
];

const ENDS: &[&str] = &["cap", "open"];

pub(super) const FIELDS: &[Field] = &[
    Field::number("duct.width_m", 0.05, 10.0, |s| &mut s.duct.width_m)
        .unit("m")
        .required("0.5")
        .about("Inside width where the duct begins."),
    Field::number("duct.height_m", 0.05, 10.0, |s| &mut s.duct.height_m)
        .unit("m")
        .required("0.3")
        .about("Inside height where the duct begins."),
    Field::of_element("duct.surface", Kind::Name)
        .default("\"galvanised\"")
        .about("What the duct is made of, by the surface's name; a fitting may have its own."),
    Field::word("duct.entry", ENDS, |s| end_word(s.duct.entry), |s, word| s.duct.entry = end(word))
        .default("\"cap\"")
        .about("How the run's beginning is finished."),
    Field::word("duct.exit", ENDS, |s| end_word(s.duct.exit), |s, word| s.duct.exit = end(word))
        .default("\"open\"")
        .about("How the run's end is finished."),
    Field::number("duct.bead_mm", 0.0, 10.0, |s| &mut s.duct.bead_m).milli("mm").default("0.0").about(
        "Height of the flange beads at the joints, of duct.surface; 0 for none. A wheel that bumps over one counts a collision.",
    ),
    Field::number("duct.bead_width_mm", 1.0, 200.0, |s| &mut s.duct.bead_width_m)
        .milli("mm")
        .default("20.0")
        .about("Width of the flange beads along the duct, half of it on each side of the joint."),
    Field::of_element("surface.*.albedo", Kind::Number { min: 0.01, max: 1.0 })
        .required("0.5")
        .about("Share of the light that the surface scatters evenly: dust, paint, oxide."),
    Field::of_element("surface.*.specular", Kind::Number { min: 0.0, max: 1.0 }).default("0.0").about(
        "Share of the light that it mirrors when met squarely, spread by its roughness; metal 0.5 to 0.9, paint and grease 0.04.",
    ),
    Field::of_element("surface.*.roughness", Kind::Number { min: 0.005, max: 1.0 })
        .default("0.3")
        .about("Roughness alpha of the GGX distribution: 0.01 a mirror, 0.5 a dull sheen."),
    Field::of_element("surface.*.spangle", Kind::Number { min: 0.0, max: 0.5 })
        .default("0.0")
        .about("Spangle of galvanising: standard deviation of the albedo over its mean."),
    Field::of_element("surface.*.spangle_mm", Kind::Number { min: 1.0, max: 1000.0 })
        .unit("mm")
        .default("10.0")
        .about("Size of a spangle."),
    Field::of_element("surface.*.seam_mm", Kind::Number { min: 0.0, max: 50.0 })
        .unit("mm")
        .default("0.0")
        .about("Width of the dark seam where sheets are joined; 0 for none."),
    Field::of_element("surface.*.friction", Kind::Number { min: 0.01, max: 2.0 })
        .required("0.7")
        .about("Coefficient of friction between wheel and surface."),
];
