//! The duct, and what its sheets look and feel like.

use ductloop_duct::network::End;

use super::{Default, Field, Kind, TableRow};
use crate::scenario::model::end_word;

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("duct", "The duct: one cross-section, and fittings joined one after the other."),
    TableRow {
        exactly_one: &["straight_m", "elbow_deg", "mitre_deg"],
        min_len: 1,
        example: "[{ straight_m = 6.0 }]",
        ..TableRow::new("duct.run[]", "A fitting of the run. Turns are positive to the left.")
    },
    TableRow::new(
        "surface.*",
        "A surface under a name of its own; it defines one, or overrides one that comes with the program.",
    ),
];

const ENDS: &[&str] = &["cap", "open"];

fn end(word: &str) -> End {
    if word == "open" { End::Open } else { End::Cap }
}

pub(super) const FIELDS: &[Field] = &[
    Field::number("duct.width_m", 0.05, 10.0, |s| &mut s.duct.width_m).unit("m").required("0.5").about("Inside width."),
    Field::number("duct.height_m", 0.05, 10.0, |s| &mut s.duct.height_m).unit("m").required("0.3").about("Inside height."),
    Field::of_element("duct.surface", Kind::Name)
        .default("\"galvanised\"")
        .about("What the duct is made of, by the surface's name; a fitting may have its own."),
    Field::word("duct.entry", ENDS, |s| end_word(s.duct.entry), |s, word| s.duct.entry = end(word))
        .default("\"cap\"")
        .about("How the run's beginning is finished."),
    Field::word("duct.exit", ENDS, |s| end_word(s.duct.exit), |s, word| s.duct.exit = end(word))
        .default("\"open\"")
        .about("How the run's end is finished."),
    Field::of_element("duct.run[].straight_m", Kind::Number { min: 0.01, max: 1000.0 })
        .unit("m")
        .or(Default::Absent("it is another fitting"))
        .about("A straight of this length."),
    Field::of_element("duct.run[].elbow_deg", Kind::Number { min: -180.0, max: 180.0 })
        .unit("degrees")
        .or(Default::Absent("it is another fitting"))
        .about("A radius elbow that turns by this angle, left positive."),
    Field::of_element("duct.run[].mitre_deg", Kind::Number { min: -120.0, max: 120.0 })
        .unit("degrees")
        .or(Default::Absent("it is another fitting"))
        .about("A mitred elbow that turns by this angle, left positive."),
    Field::of_element("duct.run[].throat_radius_m", Kind::Number { min: 0.005, max: 50.0 })
        .unit("m")
        .or(Default::Computed("0.75 of the width"))
        .about("Radius of a radius elbow's inner wall."),
    Field::of_element("duct.run[].surface", Kind::Name)
        .or(Default::Computed("duct.surface"))
        .about("What this fitting is made of, by the surface's name."),
    Field::of_element("surface.*.albedo", Kind::Number { min: 0.01, max: 1.0 })
        .required("0.5")
        .about("Share of the light that the surface scatters."),
    Field::of_element("surface.*.friction", Kind::Number { min: 0.01, max: 2.0 })
        .required("0.7")
        .about("Coefficient of friction between wheel and surface."),
];
