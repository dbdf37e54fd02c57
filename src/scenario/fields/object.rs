//! What stands in the duct.

use super::{Default, Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] = &[TableRow::new(
    "duct.object[]",
    "Something that stands in the duct. The robot bumps into it; it hides and shades what is behind it. No two may overlap.",
)];

/// Words for `duct.object[].shape`.
const SHAPES: &[&str] = &["box"];

/// Smallest and largest edge of a box, in metres. The physics holds bodies about a millimetre apart.
const EDGE_MIN_M: f64 = 1e-3;
const EDGE_MAX_M: f64 = 10.0;

pub(super) const FIELDS: &[Field] = &[
    Field::of_element("duct.object[].name", Kind::Name)
        .or(Default::Absent("it has no name"))
        .about("What reports call it; no other object may have it."),
    Field::of_element("duct.object[].shape", Kind::Word(SHAPES)).default("\"box\"").about("What it is."),
    Field::of_element("duct.object[].size_m", Kind::Numbers { len: 3, min: EDGE_MIN_M, max: EDGE_MAX_M, single: false })
        .unit("m")
        .required("[0.1, 0.1, 0.1]")
        .about("Its size along the duct, across it and upright, before it is turned."),
    Field::of_element("duct.object[].at_m", Kind::Number { min: 0.0, max: 1e5 })
        .unit("m")
        .required("2.0")
        .about("Where its middle is along the duct's centreline."),
    Field::of_element("duct.object[].left_m", Kind::Number { min: -5.0, max: 5.0 })
        .unit("m")
        .default("0.0")
        .about("How far its middle is to the left of the centreline."),
    Field::of_element("duct.object[].above_m", Kind::Number { min: 0.0, max: 10.0 })
        .unit("m")
        .default("0.0")
        .about("How far its bottom is above the floor."),
    Field::of_element("duct.object[].turned_deg", Kind::Number { min: -180.0, max: 180.0 })
        .unit("degrees")
        .default("0.0")
        .about("Turn about the vertical against the centreline, anticlockwise positive."),
    Field::of_element("duct.object[].surface", Kind::Name)
        .or(Default::Computed("duct.surface"))
        .about("What it is made of, by the surface's name."),
];
