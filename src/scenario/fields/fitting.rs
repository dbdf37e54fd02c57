//! Fittings of runs and of branches, and the route through them.

use ductloop_duct::network::End;

use super::{Default, Field, Kind, TableRow};

/// The keys of which each fitting has one: what it is.
const KINDS: &[&str] = &[
    "straight_m",
    "elbow_deg",
    "mitre_deg",
    "vaned_deg",
    "transition_m",
    "offset_m",
    "slope_deg",
    "tee",
    "bullhead_m",
    "side_branch",
    "wye_deg",
    "cross_m",
    "damper",
    "grille",
    "drop_m",
];

pub(super) const TABLES: &[TableRow] = &[
    TableRow {
        exactly_one: KINDS,
        min_len: 1,
        example: "[{ straight_m = 6.0 }]",
        ..TableRow::new("duct.run[]", "A fitting of the run. Turns are positive to the left.")
    },
    TableRow::new(
        "duct.random",
        "A network drawn from a seed, with a route through it, in the place of duct.run, duct.branch and route.turns.",
    ),
    TableRow::new("duct.branch[]", "A run of fittings that begins at a port of a fitting elsewhere."),
    TableRow {
        exactly_one: KINDS,
        min_len: 1,
        example: "[{ straight_m = 2.0 }]",
        ..TableRow::new("duct.branch[].run[]", "A fitting of the branch. Turns are positive to the left.")
    },
];

pub(super) const ROUTE_TABLES: &[TableRow] =
    &[TableRow::new("route", "The way through a network with junctions: a turn for each junction and each dead end on the way.")];

const ENDS: &[&str] = &["cap", "open"];
const HANDS: &[&str] = &["left", "right"];

/// The word for how an end is finished, the other way round.
pub(in crate::scenario) fn end(word: &str) -> End {
    if word == "open" { End::Open } else { End::Cap }
}

/// The fields of a fitting in the list at this path.
macro_rules! fitting {
    ($list:literal) => {
        [
            Field::of_element(concat!($list, ".name"), Kind::Name)
                .or(Default::Computed("what it is, and its number among those: tee-1, tee-2"))
                .about("What branches, drawings and errors call it; no other fitting may have it."),
            length(concat!($list, ".straight_m"), 0.01, 1000.0).about("A straight of this length."),
            angle(concat!($list, ".elbow_deg"), -180.0, 180.0).about("A radius elbow that turns by this angle, left positive."),
            angle(concat!($list, ".mitre_deg"), -120.0, 120.0).about("A mitred elbow that turns by this angle, left positive."),
            angle(concat!($list, ".vaned_deg"), -120.0, 120.0)
                .about("A mitred elbow with turning vanes, which a robot cannot pass; left positive."),
            length(concat!($list, ".transition_m"), 0.01, 100.0).about("A transition of this length to another section."),
            length(concat!($list, ".offset_m"), -50.0, 50.0)
                .about("An offset, an S-bend, by so much to the left; negative to the right."),
            angle(concat!($list, ".slope_deg"), -10.0, 10.0).about("A straight that climbs at this angle; negative falls."),
            word(concat!($list, ".tee"), HANDS)
                .about("A tee: a square branch flush with the wall on this side; the duct goes straight on."),
            length(concat!($list, ".bullhead_m"), 0.02, 10.0)
                .about("A bull-head tee at the end of its run: branches `left` and `right` of this width, no way straight on."),
            word(concat!($list, ".side_branch"), HANDS)
                .about("A square branch on this side behind a shoe of 45 degrees; the duct goes straight on."),
            angle(concat!($list, ".wye_deg"), 30.0, 60.0)
                .about("A wye at the end of its run: branches `left` and `right`, each at this angle."),
            length(concat!($list, ".cross_m"), 0.02, 10.0)
                .about("A cross: square branches `left` and `right` of this width; the duct goes straight on."),
            word(concat!($list, ".damper"), &["open", "shut"]).about("A curtain fire damper in a straight."),
            word(concat!($list, ".grille"), &["left", "right", "ceiling"])
                .about("A straight with a grille there, beyond which is the open."),
            length(concat!($list, ".drop_m"), 0.01, 100.0)
                .about("A straight with a hole in its floor, this long, and a shaft below."),
            aside(concat!($list, ".throat_radius_m"), 0.005, 50.0, "0.75 of the width there")
                .about("Radius of a radius elbow's inner wall."),
            aside(
                concat!($list, ".length_m"),
                0.01,
                1000.0,
                "slope 1.0, offset 1.5 times the offset and at least 2 widths, \
                   damper 0.3, grille 0.6, drop the hole and 0.2 on each side",
            )
            .about("Length along the duct, seen from above, of a slope, offset, damper, grille or drop."),
            aside(concat!($list, ".to_width_m"), 0.02, 10.0, "the width before").about("Width behind a transition."),
            aside(concat!($list, ".to_height_m"), 0.02, 10.0, "the height before").about("Height behind a transition."),
            Field::of_element(concat!($list, ".align"), Kind::Word(&["centre", "left", "right"]))
                .or(Default::Computed("\"centre\""))
                .about("What of a transition stays in line, seen from above: the middle, or a wall."),
            Field::of_element(concat!($list, ".align_upright"), Kind::Word(&["bottom", "centre"]))
                .or(Default::Computed("\"bottom\""))
                .about("What of a transition stays in line, seen from the side: the floor, or the middle."),
            aside(concat!($list, ".branch_width_m"), 0.02, 10.0, "the width of the duct there")
                .about("Width of the branch of a tee or side branch, of both branches of a wye."),
            aside(concat!($list, ".shoe_m"), 0.005, 10.0, "a quarter of the branch's width")
                .about("By how much a side branch's shoe widens its opening."),
            aside(concat!($list, ".opening_length_m"), 0.01, 100.0, "0.6 of the length").about("Length of a grille's opening."),
            aside(concat!($list, ".opening_height_m"), 0.01, 10.0, "half the height, in the ceiling half the width")
                .about("Height of a grille's opening; width of one in the ceiling."),
            aside(concat!($list, ".hole_width_m"), 0.01, 10.0, "the width of the duct there")
                .about("Width of a drop's hole across the duct."),
            aside(concat!($list, ".depth_m"), 0.01, 100.0, "1.0").about("Depth of a drop's shaft."),
            Field::of_element(concat!($list, ".left_end"), Kind::Word(ENDS))
                .or(Default::Computed("\"cap\""))
                .about("How a junction's port `left` is finished where no branch begins."),
            Field::of_element(concat!($list, ".right_end"), Kind::Word(ENDS))
                .or(Default::Computed("\"cap\""))
                .about("How a junction's port `right` is finished where no branch begins."),
            Field::of_element(concat!($list, ".surface"), Kind::Name)
                .or(Default::Computed("duct.surface"))
                .about("What this fitting is made of, by the surface's name."),
        ]
    };
}

const OTHER: Default = Default::Absent("it is another fitting");

const fn length(path: &'static str, min: f64, max: f64) -> Field {
    Field::of_element(path, Kind::Number { min, max }).unit("m").or(OTHER)
}

const fn angle(path: &'static str, min: f64, max: f64) -> Field {
    Field::of_element(path, Kind::Number { min, max }).unit("degrees").or(OTHER)
}

const fn word(path: &'static str, words: &'static [&'static str]) -> Field {
    Field::of_element(path, Kind::Word(words)).or(OTHER)
}

const fn aside(path: &'static str, min: f64, max: f64, how: &'static str) -> Field {
    Field::of_element(path, Kind::Number { min, max }).unit("m").or(Default::Computed(how))
}

pub(super) const RUN_FIELDS: &[Field] = &fitting!("duct.run[]");
pub(super) const BRANCH_RUN_FIELDS: &[Field] = &fitting!("duct.branch[].run[]");

pub(super) const BRANCH_FIELDS: &[Field] = &[
    Field::of_element("duct.branch[].from", Kind::Text)
        .required("\"tee-1.left\"")
        .about("The port at which the branch begins: a fitting's name, a dot, and `in`, `out`, `left` or `right`."),
    Field::of_element("duct.branch[].to", Kind::Text)
        .or(Default::Absent("the branch ends freely"))
        .about("The port that the branch's last fitting meets; it closes a loop."),
    Field::of_element("duct.branch[].end", Kind::Word(ENDS))
        .or(Default::Computed("\"cap\""))
        .about("How the branch's end is finished."),
];

/// Words for what a random network is made of.
const RANDOM_KINDS: &[&str] =
    &["elbow", "mitre", "offset", "transition", "slope", "tee", "side-branch", "cross", "wye", "bullhead"];

pub(super) const RANDOM_FIELDS: &[Field] = &[
    Field::of_element("duct.random.seed", Kind::Integer { min: 0, max: i64::MAX })
        .or(Default::Computed("the scenario's seed"))
        .about("What the network is drawn from."),
    Field::of_element("duct.random.fittings", Kind::Integers { len: 2, min: 2, max: 200 })
        .default("[10, 20]")
        .about("Fewest and most fittings, straights and dead ends among them."),
    Field::of_element("duct.random.straight_m", Kind::Numbers { len: 2, min: 0.05, max: 100.0, single: false })
        .unit("m")
        .default("[1.0, 3.0]")
        .about("Shortest and longest straight between two fittings."),
    Field::of_element("duct.random.widths_m", Kind::List { min: 0.05, max: 10.0 })
        .unit("m")
        .default("[0.4, 0.5, 0.6]")
        .about("Widths that transitions lead to."),
    Field::of_element("duct.random.kinds", Kind::Words(RANDOM_KINDS))
        .default("[\"elbow\", \"mitre\", \"offset\", \"transition\", \"tee\", \"side-branch\", \"cross\", \"wye\", \"bullhead\"]")
        .about("What stands between the straights; a word that comes twice is drawn twice as often."),
];

pub(super) const ROUTE_FIELDS: &[Field] = &[
    Field::of_element("route.turns", Kind::Words(&["left", "straight", "right", "turn-back", "stop"]))
        .or(Default::Absent("there is nothing to decide"))
        .about("What to do at each junction and each dead end on the way, in order; after the last the way goes on to the duct's end."),
    Field::of_element("route.explore", Kind::Flag)
        .or(Default::Absent("false: `route.turns` holds"))
        .about("Whether the way goes through every branch that can be reached, turning back in dead ends, instead of by turns."),
    Field::of_element("route.turn_back_m", Kind::Number { min: 0.0, max: 100.0 })
        .unit("m")
        .or(Default::Computed("0.6"))
        .about("How far before the end of a duct the way turns back."),
];
