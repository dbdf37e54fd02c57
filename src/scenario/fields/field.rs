//! A row of the table of fields.

use super::Scale;
use crate::scenario::Scenario;

/// A field of the file.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Where it stands: `robot.speed_m_s`; `[]` after an array of tables, `*` for a name the file chooses.
    pub path: &'static str,
    /// What values it takes.
    pub kind: Kind,
    /// The unit of the file, as in `m/s`; empty if it has none.
    pub unit: &'static str,
    /// What holds if it is not given.
    pub default: Default,
    /// Words that belong here but that this version does not take, each with the reason.
    pub refused: &'static [(&'static str, &'static str)],
    /// What it is, in one sentence.
    pub about: &'static str,
    /// The place in the resolved scenario.
    pub(in crate::scenario) slot: Slot,
}

/// What values a field takes. Bounds are inclusive and in the file's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A finite number.
    Number {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A finite number, or this word.
    NumberOr {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// The word.
        word: &'static str,
    },
    /// One of these whole numbers.
    Choice(&'static [i64]),
    /// A whole number.
    Integer {
        /// Smallest.
        min: i64,
        /// Largest.
        max: i64,
    },
    /// So many finite numbers.
    Numbers {
        /// How many.
        len: usize,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// Whether a single number may stand for all of them.
        single: bool,
    },
    /// So many whole numbers.
    Integers {
        /// How many.
        len: usize,
        /// Smallest.
        min: i64,
        /// Largest.
        max: i64,
    },
    /// Any number of finite numbers.
    List {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// True or false.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
    /// Any number of these words.
    Words(&'static [&'static str]),
    /// A name: letters, digits, `-` and `_`, at most 64.
    Name,
    /// Any text.
    Text,
}

/// What holds if a field is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// Nothing: it must be given. With an example, as TOML.
    Required(&'static str),
    /// What the table's preset says; without a preset it must be given.
    Preset,
    /// This value, as TOML.
    Value(&'static str),
    /// What is worked out from other fields, in words.
    Computed(&'static str),
    /// Nothing, and that means something, in words.
    Absent(&'static str),
}

/// Where a field's value goes in the resolved scenario, in SI.
#[derive(Clone, Copy, Debug)]
pub(in crate::scenario) enum Slot {
    /// Read and written by the code of its table (arrays of tables, tables with names of their own).
    ByTable,
    /// Not in the resolved scenario; a resolved file holds this TOML.
    Fixed(&'static str),
    Number(fn(&mut Scenario) -> &mut f64, Scale),
    /// `None` is the word.
    NumberOr(fn(&mut Scenario) -> &mut Option<f64>, Scale),
    /// A part that is not always there.
    Part {
        get: fn(&Scenario) -> Option<f64>,
        set: fn(&mut Scenario, f64),
    },
    /// Numbers that do not lie side by side.
    Values {
        get: fn(&Scenario) -> Vec<f64>,
        set: fn(&mut Scenario, &[f64]),
    },
    Choice {
        get: fn(&Scenario) -> i64,
        set: fn(&mut Scenario, i64),
    },
    Numbers(fn(&mut Scenario) -> &mut [f64], Scale),
    List(fn(&mut Scenario) -> &mut Vec<f64>, Scale),
    Usize(fn(&mut Scenario) -> &mut usize),
    Sizes(fn(&mut Scenario) -> &mut [usize]),
    U32(fn(&mut Scenario) -> &mut u32),
    U64(fn(&mut Scenario) -> &mut u64),
    Flag(fn(&mut Scenario) -> &mut bool),
    Text(fn(&mut Scenario) -> &mut String),
    Word {
        get: fn(&Scenario) -> &'static str,
        set: fn(&mut Scenario, &str),
    },
    /// A criterion on this metric.
    Criterion(&'static str, Scale),
}

impl Field {
    /// A row with everything but its type left to fill in.
    pub(super) const fn new(path: &'static str, kind: Kind, slot: Slot) -> Self {
        Self { path, kind, unit: "", default: Default::Required("1"), refused: &[], about: "", slot }
    }

    /// A number between two bounds.
    pub(super) const fn number(path: &'static str, min: f64, max: f64, at: fn(&mut Scenario) -> &mut f64) -> Self {
        Self::new(path, Kind::Number { min, max }, Slot::Number(at, Scale::Si))
    }

    /// A point or direction, or another fixed number of numbers.
    pub(super) const fn numbers(path: &'static str, len: usize, min: f64, max: f64, at: fn(&mut Scenario) -> &mut [f64]) -> Self {
        Self::new(path, Kind::Numbers { len, min, max, single: false }, Slot::Numbers(at, Scale::Si))
    }

    /// A whole number.
    pub(super) const fn count(path: &'static str, min: i64, max: i64, at: fn(&mut Scenario) -> &mut u32) -> Self {
        Self::new(path, Kind::Integer { min, max }, Slot::U32(at))
    }

    /// A whole number that is a size in memory.
    pub(super) const fn size(path: &'static str, min: i64, max: i64, at: fn(&mut Scenario) -> &mut usize) -> Self {
        Self::new(path, Kind::Integer { min, max }, Slot::Usize(at))
    }

    /// One of several words.
    pub(super) const fn word(
        path: &'static str,
        words: &'static [&'static str],
        get: fn(&Scenario) -> &'static str,
        set: fn(&mut Scenario, &str),
    ) -> Self {
        Self::new(path, Kind::Word(words), Slot::Word { get, set })
    }

    /// A field of a table that has code of its own.
    pub(super) const fn of_element(path: &'static str, kind: Kind) -> Self {
        Self::new(path, kind, Slot::ByTable)
    }

    /// Unit and scale: in thousandths of the SI unit.
    pub(super) const fn milli(self, unit: &'static str) -> Self {
        self.scaled(unit, Scale::Milli)
    }

    /// In degrees.
    pub(super) const fn degrees(self) -> Self {
        self.scaled("degrees", Scale::Degrees)
    }

    /// The unit of a field that is SI.
    pub(super) const fn unit(self, unit: &'static str) -> Self {
        self.scaled(unit, Scale::Si)
    }

    const fn scaled(mut self, unit: &'static str, scale: Scale) -> Self {
        self.unit = unit;
        self.slot = match self.slot {
            Slot::Number(at, _) => Slot::Number(at, scale),
            Slot::NumberOr(at, _) => Slot::NumberOr(at, scale),
            Slot::Numbers(at, _) => Slot::Numbers(at, scale),
            Slot::List(at, _) => Slot::List(at, scale),
            Slot::Criterion(metric, _) => Slot::Criterion(metric, scale),
            other => other,
        };
        self
    }

    /// What holds if it is not given.
    pub(super) const fn or(mut self, default: Default) -> Self {
        self.default = default;
        self
    }

    /// It must be given; `example` is TOML.
    pub(super) const fn required(self, example: &'static str) -> Self {
        self.or(Default::Required(example))
    }

    /// The value that holds if it is not given, as TOML.
    pub(super) const fn default(self, toml: &'static str) -> Self {
        self.or(Default::Value(toml))
    }

    /// It comes from the table's preset.
    pub(super) const fn preset(self) -> Self {
        self.or(Default::Preset)
    }

    /// Words that this version refuses, each with the reason.
    pub(super) const fn refuse(mut self, words: &'static [(&'static str, &'static str)]) -> Self {
        self.refused = words;
        self
    }

    /// What it is, in one sentence.
    pub(super) const fn about(mut self, sentence: &'static str) -> Self {
        self.about = sentence;
        self
    }

    /// The key itself, without the tables before it.
    pub fn key(&self) -> &'static str {
        super::last(self.path)
    }

    /// The sentence with the unit, as help and documentation quote it.
    pub fn sentence(&self) -> String {
        if self.unit.is_empty() { self.about.to_owned() } else { format!("{} [{}]", self.about, self.unit) }
    }
}
