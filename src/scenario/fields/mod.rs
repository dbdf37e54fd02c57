//! The one table of fields: path, type, unit, default, bounds, a sentence. It drives reading, checking, writing, the JSON
//! Schema and the paths of `--set`.
//!
//! To add a field, add a row to the file of its table; if its value is a plain number, word or flag of the resolved
//! [`Scenario`](super::Scenario), nothing else is needed.

mod camera;
mod course;
mod duct;
mod estimation;
mod fault;
mod field;
mod fitting;
mod general;
mod imager;
mod koh_cho;
mod lasers;
mod laws;
mod limits;
mod link;
mod mount_control;
mod navigator;
mod object;
mod paper;
mod pass;
mod robot;
mod robust;
mod scale;
mod sensor;
mod shape;
mod wheel_control;

pub use field::{Default, Field, Kind};
pub use scale::Scale;

pub(super) use field::Slot;
pub(super) use shape::{Shape, TableShape, root};

pub(super) use fitting::end;
pub(super) use general::{FORMAT, KIND};
/// A table of the file.
#[derive(Clone, Copy, Debug)]
pub struct TableRow {
    /// Its path; ends in `[]` for an array of tables, in `.*` for tables whose names the file chooses.
    pub path: &'static str,
    /// What it is, in one sentence.
    pub about: &'static str,
    /// Keys of which exactly one must be there; empty if there is no such rule.
    pub exactly_one: &'static [&'static str],
    /// Keys of which at most one may be there.
    pub at_most_one: &'static [&'static str],
    /// The fewest elements of an array of tables.
    pub min_len: usize,
    /// An example of an array of tables that must not be empty, as TOML.
    pub example: &'static str,
}

impl TableRow {
    const fn new(path: &'static str, about: &'static str) -> Self {
        Self { path, about, exactly_one: &[], at_most_one: &[], min_len: 0, example: "" }
    }
}

/// Every table, in the order in which a file is written.
pub fn tables() -> impl Iterator<Item = &'static TableRow> {
    [
        general::TABLES,
        robot::TABLES,
        sensor::TABLES,
        camera::TABLES,
        lasers::TABLES,
        imager::TABLES,
        navigator::TABLES,
        paper::TABLES,
        robust::TABLES,
        limits::TABLES,
        koh_cho::TABLES,
        wheel_control::TABLES,
        mount_control::TABLES,
        link::TABLES,
        laws::TABLES,
        estimation::TABLES,
        duct::TABLES,
        fitting::TABLES,
        object::TABLES,
        fitting::ROUTE_TABLES,
        course::TABLES,
        fault::TABLES,
        pass::TABLES,
    ]
    .into_iter()
    .flatten()
}

/// Every field, in the order in which a file is written.
pub fn fields() -> impl Iterator<Item = &'static Field> {
    [
        general::FIELDS,
        robot::FIELDS,
        sensor::FIELDS,
        camera::FIELDS,
        lasers::FIELDS,
        imager::FIELDS,
        navigator::FIELDS,
        paper::FIELDS,
        robust::FIELDS,
        limits::FIELDS,
        koh_cho::FIELDS,
        wheel_control::FIELDS,
        mount_control::FIELDS,
        link::FIELDS,
        laws::FIELDS,
        estimation::FIELDS,
        duct::FIELDS,
        fitting::RUN_FIELDS,
        fitting::RANDOM_FIELDS,
        fitting::BRANCH_FIELDS,
        fitting::BRANCH_RUN_FIELDS,
        object::FIELDS,
        fitting::ROUTE_FIELDS,
        course::FIELDS,
        fault::FIELDS,
        pass::FIELDS,
    ]
    .into_iter()
    .flatten()
}

/// The field at a path as it is typed: `duct.run[1].elbow_deg`, `sensor.laser.low.offset_m`.
pub fn field(path: &str) -> Option<&'static Field> {
    let mut table = root();
    let mut steps = path.split('.').peekable();
    while let Some(step) = steps.next() {
        let (key, indexed) = step.split_once('[').map_or((step, false), |(key, _)| (key, true));
        match table.child(key)? {
            Shape::Leaf(field) if !indexed && steps.peek().is_none() => return Some(field),
            Shape::Table(inner) if !indexed => table = inner,
            Shape::List(inner) if indexed => table = inner,
            Shape::Named(inner) if !indexed => {
                steps.next()?;
                table = inner;
            }
            _ => return None,
        }
    }
    None
}

/// The path of the table that a path stands in.
fn parent(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(parent, _)| parent)
}

/// The last key of a path.
fn last(path: &str) -> &str {
    path.rsplit_once('.').map_or(path, |(_, last)| last)
}
