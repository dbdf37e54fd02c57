//! What goes wrong on purpose.

use super::{Default, Field, Kind, TableRow};

pub(super) const TABLES: &[TableRow] = &[TableRow::new("fault[]", "Something that goes wrong on purpose, from a time on.")];

pub(super) const FIELDS: &[Field] = &[
    Field::of_element("fault[].kind", Kind::Word(&["laser-off", "frame-blank", "wheels-swapped", "link-lost"]))
        .required("\"laser-off\"")
        .about("A laser goes dark, frames come without light, left and right wheel commands are swapped, or no command reaches wheels and mount."),
    Field::of_element("fault[].at_s", Kind::Number { min: 0.0, max: 36_000.0 })
        .unit("s")
        .required("8.0")
        .about("Simulated time at which it begins."),
    Field::of_element("fault[].for_s", Kind::Number { min: 1e-3, max: 36_000.0 })
        .unit("s")
        .or(Default::Absent("it lasts to the end of the run"))
        .about("How long it lasts."),
    Field::of_element("fault[].laser", Kind::Name)
        .or(Default::Absent("the fault is not of a laser"))
        .about("Which laser goes dark, by its name."),
];
