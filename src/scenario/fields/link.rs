//! The link from the command controller to wheel and mount controller.

use super::{Field, TableRow};

pub(super) const TABLES: &[TableRow] = &[TableRow::new(
    "link",
    "The link from the command controller to wheel and mount controller, beyond the frame that deciding takes.",
)];

pub(super) const FIELDS: &[Field] = &[
    Field::number("link.latency_ms", 0.0, 10_000.0, |s| &mut s.link.latency_s)
        .milli("ms")
        .default("0.0")
        .about("Time that every command is on the way at least."),
    Field::number("link.jitter_ms", 0.0, 10_000.0, |s| &mut s.link.jitter_s)
        .milli("ms")
        .default("0.0")
        .about("Longest time beyond that; each command's is drawn evenly from 0 to this."),
    Field::number("link.loss", 0.0, 1.0, |s| &mut s.link.loss).default("0.0").about("Probability that a command is lost."),
    Field::number("link.repeat", 0.0, 1.0, |s| &mut s.link.repeat)
        .default("0.0")
        .about("Probability that a command comes twice."),
];
