//! The navigator: perception, control law, and what it is told of the duct.

use super::field::Slot;
use super::{Default, Field, Kind, Scale, TableRow};
use crate::scenario::model::{Law, Pipeline};

pub(super) const TABLES: &[TableRow] = &[
    TableRow::new("perception", "How images become errors."),
    TableRow::new("control", "How errors become wheel speeds."),
    TableRow::new("navigation", "What the navigator is told of the duct."),
];

pub(super) const FIELDS: &[Field] = &[
    Field::word(
        "perception.pipeline",
        &["robust", "paper", "truth"],
        |s| s.perception.pipeline.word(),
        |s, word| s.perception.pipeline = Pipeline::of(word).unwrap_or(Pipeline::Robust),
    )
    .default("\"robust\"")
    .about(
        "\"robust\" tells walls with their deviations and what does not belong to them, \"paper\" is the paper's chain, \"truth\" \
         steers by the true errors, to tell what perception costs.",
    ),
    Field::word(
        "control.law",
        &Law::WORDS,
        |s| s.control.law.word(),
        |s, word| s.control.law = Law::of(word).unwrap_or_default(),
    )
    .default("\"koh-cho\"")
    .about(
        "The path-tracking law: Koh and Cho's, the same as printed (it does not settle), pure pursuit, Stanley's, Kanayama's, \
         Samson's, a linear-quadratic regulator.",
    ),
    Field::number("navigation.width_m", 0.05, 10.0, |s| &mut s.navigation.width_m)
        .unit("m")
        .or(Default::Computed("duct.width_m"))
        .about("The duct's width as the navigator is told it, W_d: where the run begins, unless navigation.width is a number."),
    Field::new(
        "navigation.width",
        Kind::NumberOr { min: 0.05, max: 10.0, word: "measured" },
        Slot::NumberOr(|s| &mut s.navigation.fixed_width_m, Scale::Si),
    )
    .unit("m")
    .default("\"measured\"")
    .about(
        "The width of ducts: \"measured\", from navigation.width_m on; or a number that is taken for it all along, in every duct, so that \
         one wall is enough to know the place across it.",
    ),
    Field::number("navigation.coast_s", 0.0, 60.0, |s| &mut s.navigation.coast_s)
        .unit("s")
        .default("0.5")
        .about("Longest time without sight of a wall before the robot stops."),
    Field::count("navigation.frozen_frames", 0, 1000, |s| &mut s.navigation.frozen_frames)
        .default("3")
        .about(
            "So many frames in a row that are the same to the bit as the one before are a frozen camera, and are not believed; 0: whatever \
             comes is believed. Images without noise always are: they may well be the same.",
        ),
    Field::number("control.wheel_bandwidth_rad_s", 1.0, 500.0, |s| &mut s.control.wheel_bandwidth_rad_s)
        .unit("rad/s")
        .default("60.0")
        .about("Bandwidth that the wheel controller's gains are chosen for: both poles of its loop lie there."),
];
