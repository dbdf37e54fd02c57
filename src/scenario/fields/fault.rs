//! What goes wrong on purpose.

use super::{Default, Field, Kind, TableRow};
use crate::scenario::faults::{Side, WORDS, Wheel};

pub(super) const TABLES: &[TableRow] = &[TableRow::new("fault[]", "Something that goes wrong on purpose, from a time on.")];

pub(super) const FIELDS: &[Field] = &[
    Field::of_element("fault[].kind", Kind::Word(&WORDS)).required("\"laser-off\"").about(
        "A laser goes dark or dim; frames come without light, not at all, twice or late; dirt on the lens, a gain that drifts; an encoder \
         that loses counts or is stuck; a motor that is weak or dead; grease under a wheel; a push; a pan that is misread; no command \
         reaches the wheel controller, or left and right are swapped.",
    ),
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
        .about("Which laser goes dark or dim, by its name."),
    Field::of_element("fault[].side", Kind::Word(&Side::WORDS))
        .or(Default::Absent("the fault is not of a side"))
        .about("Whose encoder or motor."),
    Field::of_element("fault[].wheel", Kind::Word(&Wheel::WORDS))
        .or(Default::Absent("the fault is not of a wheel"))
        .about("Which wheel slips."),
    Field::of_element("fault[].share", Kind::Number { min: 0.0, max: 1.0 })
        .or(Default::Absent("the fault has none"))
        .about(
            "Of frames: how many are dropped or repeated; of counts: how many are lost; of the image: how much is under dirt; of a laser's \
             power, a motor's voltage or a wheel's friction: what is left.",
        ),
    Field::of_element("fault[].frames", Kind::Integer { min: 1, max: 30 })
        .or(Default::Absent("the fault is not of late frames"))
        .about("By how many frame periods frames are late."),
    Field::of_element("fault[].rate_1_s", Kind::Number { min: -2.0, max: 2.0 })
        .unit("1/s")
        .or(Default::Absent("the fault is not of the gain"))
        .about("By how much the gain grows a second, as a share of itself."),
    Field::of_element("fault[].forward_n", Kind::Number { min: -1000.0, max: 1000.0 })
        .unit("N")
        .or(Default::Absent("the fault is no push"))
        .about("Force of the push forward."),
    Field::of_element("fault[].left_n", Kind::Number { min: -1000.0, max: 1000.0 })
        .unit("N")
        .or(Default::Absent("the fault is no push"))
        .about("Force of the push to the left."),
    Field::of_element("fault[].by_deg", Kind::Number { min: -45.0, max: 45.0 })
        .unit("deg")
        .or(Default::Absent("the fault is not of the pan"))
        .about("By how much the pan that is read is more than the pan that there is."),
];
