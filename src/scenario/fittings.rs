//! A fitting as it is typed: one key says what it is, others how large.

use ductloop_duct::fitting::{AcrossAlign, Blade, GrilleSide, Hand, Shape, UprightAlign};

use super::check::quoted;
use super::elements::Element;
use super::fields::Scale;
use super::layout::Section;
use super::tree::Value;

/// Radius of an elbow's inner wall over the duct's width, where none is given: the common one without vanes.
pub(super) const THROAT_RATIO: f64 = 0.75;
/// Shoe of a side branch over the branch's width, where none is given: what SMACNA's duct construction standards draw.
const SHOE_RATIO: f64 = 0.25;
/// Lengths in metres, where none is given.
const SLOPE_M: f64 = 1.0;
const DAMPER_M: f64 = 0.3;
const GRILLE_M: f64 = 0.6;
const BESIDE_HOLE_M: f64 = 0.2;
const DEPTH_M: f64 = 1.0;
/// Opening of a grille over the length and over the height of its sheet.
const OPENING_LENGTH: f64 = 0.6;
const OPENING_HEIGHT: f64 = 0.5;

/// A kind of fitting: its key, the word for it in names, and the other keys that it takes.
pub(super) struct Kind {
    pub(super) key: &'static str,
    pub(super) word: &'static str,
    pub(super) others: &'static [&'static str],
}

const JUNCTION_ENDS: [&str; 2] = ["left_end", "right_end"];

const fn kind(key: &'static str, word: &'static str, others: &'static [&'static str]) -> Kind {
    Kind { key, word, others }
}

pub(super) const KINDS: [Kind; 15] = [
    kind("straight_m", "straight", &[]),
    kind("elbow_deg", "elbow", &["throat_radius_m"]),
    kind("mitre_deg", "mitre", &[]),
    kind("vaned_deg", "vaned", &[]),
    kind("transition_m", "transition", &["to_width_m", "to_height_m", "align", "align_upright"]),
    kind("offset_m", "offset", &["length_m"]),
    kind("slope_deg", "slope", &["length_m"]),
    kind("tee", "tee", &["branch_width_m", JUNCTION_ENDS[0], JUNCTION_ENDS[1]]),
    kind("bullhead_m", "bullhead", &JUNCTION_ENDS),
    kind("side_branch", "side-branch", &["branch_width_m", "shoe_m", JUNCTION_ENDS[0], JUNCTION_ENDS[1]]),
    kind("wye_deg", "wye", &["branch_width_m", JUNCTION_ENDS[0], JUNCTION_ENDS[1]]),
    kind("cross_m", "cross", &JUNCTION_ENDS),
    kind("damper", "damper", &["length_m"]),
    kind("grille", "grille", &["length_m", "opening_length_m", "opening_height_m"]),
    kind("drop_m", "drop", &["length_m", "hole_width_m", "depth_m"]),
];

/// What a fitting is, if one of its keys says it.
pub(super) fn kind_of(piece: &Element<'_>) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| piece.has(kind.key))
}

/// The key among these that this fitting does not take, and what would.
pub(super) fn stray_key(piece: &Element<'_>) -> Option<(&'static str, String, String)> {
    let own = kind_of(piece)?;
    let is_stray = |key: &&'static str| piece.has(key) && !own.others.contains(key);
    let key = KINDS.iter().flat_map(|kind| kind.others).copied().find(is_stray)?;
    let takers: Vec<&str> = KINDS.iter().filter(|kind| kind.others.contains(&key)).map(|kind| kind.key).collect();
    let message = format!("`{key}` in a fitting that takes none: it is a {}", own.word);
    Some((key, message, format!("only a fitting with {} has it", quoted(&takers).replace(", ", " or "))))
}

/// The fitting, where the duct has this section; `None` where what must be given is not, which has been reported.
pub(super) fn read(piece: &Element<'_>, [width_m, height_m]: Section) -> Option<Shape> {
    let si = |key: &str| piece.number(key, Scale::Si);
    let or = |key: &str, default: f64| si(key).unwrap_or(default);
    let degrees = |key: &str| piece.number(key, Scale::Degrees);
    let hand = |key: &str| piece.text(key).map(|word| if word == "left" { Hand::Left } else { Hand::Right });
    let kind = kind_of(piece)?;
    let branch_width_m = or("branch_width_m", width_m);
    Some(match kind.word {
        "straight" => Shape::Straight { length_m: si(kind.key)? },
        "elbow" => {
            Shape::RadiusElbow { angle_rad: degrees(kind.key)?, throat_radius_m: or("throat_radius_m", THROAT_RATIO * width_m) }
        }
        "mitre" => Shape::MitredElbow { angle_rad: degrees(kind.key)? },
        "vaned" => Shape::VanedElbow { angle_rad: degrees(kind.key)? },
        "transition" => Shape::Transition {
            length_m: si(kind.key)?,
            to_width_m: or("to_width_m", width_m),
            to_height_m: or("to_height_m", height_m),
            across: match piece.text("align") {
                Some("left") => AcrossAlign::Left,
                Some("right") => AcrossAlign::Right,
                _ => AcrossAlign::Concentric,
            },
            upright: match piece.text("align_upright") {
                Some("centre") => UprightAlign::Concentric,
                _ => UprightAlign::FlatBottom,
            },
        },
        "offset" => {
            let aside_m = si(kind.key)?;
            Shape::Offset { aside_m, length_m: or("length_m", f64::max(1.5 * aside_m.abs(), 2.0 * width_m)) }
        }
        "slope" => Shape::Slope { angle_rad: degrees(kind.key)?, length_m: or("length_m", SLOPE_M) },
        "tee" => Shape::Tee { hand: hand(kind.key)?, branch_width_m },
        "bullhead" => Shape::BullheadTee { branch_width_m: si(kind.key)? },
        "side-branch" => {
            Shape::SideBranch { hand: hand(kind.key)?, branch_width_m, shoe_m: or("shoe_m", SHOE_RATIO * branch_width_m) }
        }
        "wye" => Shape::Wye { half_angle_rad: degrees(kind.key)?, branch_width_m },
        "cross" => Shape::Cross { branch_width_m: si(kind.key)? },
        "damper" => {
            let blade = if piece.text(kind.key)? == "open" { Blade::Open } else { Blade::Shut };
            Shape::Damper { length_m: or("length_m", DAMPER_M), blade }
        }
        "grille" => {
            let length_m = or("length_m", GRILLE_M);
            let (side, sheet_m) = match piece.text(kind.key)? {
                "left" => (GrilleSide::Left, height_m),
                "right" => (GrilleSide::Right, height_m),
                _ => (GrilleSide::Ceiling, width_m),
            };
            Shape::Grille {
                length_m,
                side,
                opening_length_m: or("opening_length_m", OPENING_LENGTH * length_m),
                opening_height_m: or("opening_height_m", OPENING_HEIGHT * sheet_m),
            }
        }
        _ => {
            let hole_length_m = si(kind.key)?;
            Shape::Drop {
                hole_length_m,
                length_m: or("length_m", hole_length_m + 2.0 * BESIDE_HOLE_M),
                hole_width_m: or("hole_width_m", width_m),
                depth_m: or("depth_m", DEPTH_M),
            }
        }
    })
}

/// The keys and values of a fitting, every default written out.
pub(super) fn write(shape: &Shape) -> Vec<(&'static str, Value)> {
    let number = Value::Number;
    let degrees = |angle_rad| Value::Number(Scale::Degrees.in_file(angle_rad));
    let word = |word: &str| Value::Text(word.to_owned());
    let hand = |hand: Hand| word(if hand == Hand::Left { "left" } else { "right" });
    match *shape {
        Shape::Straight { length_m } => vec![("straight_m", number(length_m))],
        Shape::RadiusElbow { angle_rad, throat_radius_m } => {
            vec![("elbow_deg", degrees(angle_rad)), ("throat_radius_m", number(throat_radius_m))]
        }
        Shape::MitredElbow { angle_rad } => vec![("mitre_deg", degrees(angle_rad))],
        Shape::VanedElbow { angle_rad } => vec![("vaned_deg", degrees(angle_rad))],
        Shape::Transition { length_m, to_width_m, to_height_m, across, upright } => vec![
            ("transition_m", number(length_m)),
            ("to_width_m", number(to_width_m)),
            ("to_height_m", number(to_height_m)),
            (
                "align",
                word(match across {
                    AcrossAlign::Concentric => "centre",
                    AcrossAlign::Left => "left",
                    AcrossAlign::Right => "right",
                }),
            ),
            ("align_upright", word(if upright == UprightAlign::FlatBottom { "bottom" } else { "centre" })),
        ],
        Shape::Offset { length_m, aside_m } => vec![("offset_m", number(aside_m)), ("length_m", number(length_m))],
        Shape::Slope { length_m, angle_rad } => vec![("slope_deg", degrees(angle_rad)), ("length_m", number(length_m))],
        Shape::Tee { hand: side, branch_width_m } => vec![("tee", hand(side)), ("branch_width_m", number(branch_width_m))],
        Shape::BullheadTee { branch_width_m } => vec![("bullhead_m", number(branch_width_m))],
        Shape::SideBranch { hand: side, branch_width_m, shoe_m } => {
            vec![("side_branch", hand(side)), ("branch_width_m", number(branch_width_m)), ("shoe_m", number(shoe_m))]
        }
        Shape::Wye { half_angle_rad, branch_width_m } => {
            vec![("wye_deg", degrees(half_angle_rad)), ("branch_width_m", number(branch_width_m))]
        }
        Shape::Cross { branch_width_m } => vec![("cross_m", number(branch_width_m))],
        Shape::Damper { length_m, blade } => {
            vec![("damper", word(if blade == Blade::Open { "open" } else { "shut" })), ("length_m", number(length_m))]
        }
        Shape::Grille { length_m, side, opening_length_m, opening_height_m } => vec![
            (
                "grille",
                word(match side {
                    GrilleSide::Left => "left",
                    GrilleSide::Right => "right",
                    GrilleSide::Ceiling => "ceiling",
                }),
            ),
            ("length_m", number(length_m)),
            ("opening_length_m", number(opening_length_m)),
            ("opening_height_m", number(opening_height_m)),
        ],
        Shape::Drop { length_m, hole_length_m, hole_width_m, depth_m } => vec![
            ("drop_m", number(hole_length_m)),
            ("length_m", number(length_m)),
            ("hole_width_m", number(hole_width_m)),
            ("depth_m", number(depth_m)),
        ],
    }
}
