//! What goes wrong on purpose: the kinds of faults, read from and written to `[[fault]]`.

use ductloop_nav::rig::Rig;

use super::Scenario;
use super::check::{Checked, quoted};
use super::diagnostic::Finding;
use super::fields::Scale;
use super::tree::{Node, Table, Value};
use super::typed::Typed;
use super::unknown_key::nearest;

/// Something that goes wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// When it begins, in simulated seconds.
    pub at_s: f64,
    /// How long it lasts, in seconds; `None`: to the end of the run.
    pub for_s: Option<f64>,
    /// What it is.
    pub kind: FaultKind,
}

/// What can go wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// A laser gives no light.
    LaserOff {
        /// Its index in the rig.
        laser: usize,
    },
    /// A laser gives less light than it should.
    LaserDim {
        /// Its index in the rig.
        laser: usize,
        /// What is left of its power.
        share: f64,
    },
    /// Frames come without light: every pixel black but for the noise.
    FrameBlank,
    /// Frames do not arrive.
    FrameDropped {
        /// How many, as a share.
        share: f64,
    },
    /// In place of a frame the one before arrives again.
    FrameRepeated {
        /// How often, as a share.
        share: f64,
    },
    /// Frames arrive late.
    FrameLate {
        /// By how many frame periods.
        frames: usize,
    },
    /// Dirt on the lens takes light away, in blotches.
    LensDirt {
        /// Share of the image that is under dirt.
        share: f64,
    },
    /// The camera's gain grows, or falls where this is negative.
    GainDrift {
        /// By how much a second, as a share of the gain: exp(rate t).
        rate_1_s: f64,
    },
    /// An encoder loses counts.
    EncoderLoses {
        /// Whose.
        side: Side,
        /// How many, as a share.
        share: f64,
    },
    /// An encoder counts no more.
    EncoderStuck {
        /// Whose.
        side: Side,
    },
    /// A motor gets less than its voltage.
    MotorWeak {
        /// Which.
        side: Side,
        /// What is left of it.
        share: f64,
    },
    /// A motor's circuit is open.
    MotorDead {
        /// Which.
        side: Side,
    },
    /// Dust or grease under one wheel.
    WheelSlips {
        /// Which.
        wheel: Wheel,
        /// What is left of the friction.
        share: f64,
    },
    /// Something pushes the robot.
    Push {
        /// Force forward and to the left, in newtons.
        force_n: [f64; 2],
    },
    /// The pan that is read is more than the pan that there is.
    PanMisread {
        /// By this, in radians.
        by_rad: f64,
    },
    /// No command reaches the wheel controller.
    LinkLost,
    /// Commands for the left wheels drive the right ones, and the other way round.
    WheelsSwapped,
}

/// A side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// A wheel of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wheel {
    /// On the left, in front.
    FrontLeft,
    /// On the left, behind.
    RearLeft,
    /// On the right, in front.
    FrontRight,
    /// On the right, behind.
    RearRight,
}

impl Side {
    /// The words for them.
    pub const WORDS: [&str; 2] = ["left", "right"];

    fn of(word: &str) -> Option<Self> {
        [Self::Left, Self::Right].into_iter().find(|side| side.word() == word)
    }

    /// The word for it.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

impl Wheel {
    /// The words for them.
    pub const WORDS: [&str; 4] = ["front-left", "rear-left", "front-right", "rear-right"];

    fn of(word: &str) -> Option<Self> {
        [Self::FrontLeft, Self::RearLeft, Self::FrontRight, Self::RearRight].into_iter().find(|wheel| wheel.word() == word)
    }

    /// The word for it.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

/// Each kind's word, the keys that it needs, and what reports call it.
pub(super) const KINDS: [(&str, &[&str], &str); 17] = [
    ("laser-off", &["laser"], "laser {} off"),
    ("laser-dim", &["laser", "share"], "laser {} dim"),
    ("frame-blank", &[], "blank frames"),
    ("frame-dropped", &["share"], "frames dropped"),
    ("frame-repeated", &["share"], "frames repeated"),
    ("frame-late", &["frames"], "frames late"),
    ("lens-dirt", &["share"], "dirt on the lens"),
    ("gain-drift", &["rate_1_s"], "gain drifts"),
    ("encoder-loses", &["side", "share"], "{} encoder loses counts"),
    ("encoder-stuck", &["side"], "{} encoder stuck"),
    ("motor-weak", &["side", "share"], "{} motor weak"),
    ("motor-dead", &["side"], "{} motor dead"),
    ("wheel-slips", &["wheel", "share"], "{} wheel slips"),
    ("push", &["forward_n", "left_n"], "pushed"),
    ("pan-misread", &["by_deg"], "pan misread"),
    ("link-lost", &[], "link lost"),
    ("wheels-swapped", &[], "wheels swapped"),
];

/// The words of [`KINDS`].
pub(super) const WORDS: [&str; KINDS.len()] = {
    let mut words = [""; KINDS.len()];
    let mut i = 0;
    while i < words.len() {
        words[i] = KINDS[i].0;
        i += 1;
    }
    words
};

/// Keys that say something of a kind, those of all kinds left out.
const OF_A_KIND: [&str; 9] = ["laser", "side", "wheel", "share", "frames", "rate_1_s", "forward_n", "left_n", "by_deg"];

impl FaultKind {
    /// Its place in [`KINDS`].
    fn index(self) -> usize {
        match self {
            Self::LaserOff { .. } => 0,
            Self::LaserDim { .. } => 1,
            Self::FrameBlank => 2,
            Self::FrameDropped { .. } => 3,
            Self::FrameRepeated { .. } => 4,
            Self::FrameLate { .. } => 5,
            Self::LensDirt { .. } => 6,
            Self::GainDrift { .. } => 7,
            Self::EncoderLoses { .. } => 8,
            Self::EncoderStuck { .. } => 9,
            Self::MotorWeak { .. } => 10,
            Self::MotorDead { .. } => 11,
            Self::WheelSlips { .. } => 12,
            Self::Push { .. } => 13,
            Self::PanMisread { .. } => 14,
            Self::LinkLost => 15,
            Self::WheelsSwapped => 16,
        }
    }

    /// The word for it in a scenario.
    pub fn word(self) -> &'static str {
        KINDS[self.index()].0
    }

    /// Whether it makes encoders read something else than they should.
    pub fn is_of_encoders(self) -> bool {
        matches!(self, Self::EncoderLoses { .. } | Self::EncoderStuck { .. })
    }

    /// What reports call it.
    pub fn label(self, rig: &Rig) -> String {
        let whose = match self {
            Self::LaserOff { laser } | Self::LaserDim { laser, .. } => laser_name(rig, laser),
            Self::EncoderLoses { side, .. }
            | Self::EncoderStuck { side }
            | Self::MotorWeak { side, .. }
            | Self::MotorDead { side } => side.word().to_owned(),
            Self::WheelSlips { wheel, .. } => wheel.word().to_owned(),
            _ => String::new(),
        };
        KINDS[self.index()].2.replace("{}", &whose)
    }

    /// What it says of itself, by key.
    fn parameters(self, rig: &Rig) -> Vec<(&'static str, Value)> {
        let text = |word: &str| Value::Text(word.to_owned());
        match self {
            Self::LaserOff { laser } => vec![("laser", Value::Text(laser_name(rig, laser)))],
            Self::LaserDim { laser, share } => {
                vec![("laser", Value::Text(laser_name(rig, laser))), ("share", Value::Number(share))]
            }
            Self::FrameDropped { share } | Self::FrameRepeated { share } | Self::LensDirt { share } => {
                vec![("share", Value::Number(share))]
            }
            Self::FrameLate { frames } => vec![("frames", Value::Integer(frames as i64))],
            Self::GainDrift { rate_1_s } => vec![("rate_1_s", Value::Number(rate_1_s))],
            Self::EncoderLoses { side, share } | Self::MotorWeak { side, share } => {
                vec![("side", text(side.word())), ("share", Value::Number(share))]
            }
            Self::EncoderStuck { side } | Self::MotorDead { side } => vec![("side", text(side.word()))],
            Self::WheelSlips { wheel, share } => vec![("wheel", text(wheel.word())), ("share", Value::Number(share))],
            Self::Push { force_n: [forward, left] } => {
                vec![("forward_n", Value::Number(forward)), ("left_n", Value::Number(left))]
            }
            Self::PanMisread { by_rad } => vec![("by_deg", Value::Number(Scale::Degrees.in_file(by_rad)))],
            Self::FrameBlank | Self::LinkLost | Self::WheelsSwapped => Vec::new(),
        }
    }
}

fn laser_name(rig: &Rig, laser: usize) -> String {
    rig.lasers.get(laser).map_or_else(|| format!("laser {laser}"), |laser| laser.name.clone())
}

/// A fault being read.
struct Reader<'a> {
    table: &'a Table,
    path: String,
    rig: &'a Rig,
    typed: &'a Typed,
    checked: &'a mut Checked,
}

/// The faults of a scenario.
pub(super) fn read(layered: &Table, rig: &Rig, typed: &Typed, checked: &mut Checked) -> Vec<Fault> {
    let list = layered.at("fault").and_then(Node::as_list).unwrap_or_default();
    let tables = list.iter().enumerate().filter_map(|(i, node)| node.as_table().map(|table| (i, table)));
    let mut faults = Vec::new();
    for (i, table) in tables {
        let mut reader = Reader { table, path: format!("fault[{i}]"), rig, typed, checked };
        faults.extend(reader.fault());
    }
    faults
}

impl Reader<'_> {
    fn fault(&mut self) -> Option<Fault> {
        let word = self.table.get("kind").and_then(Node::as_text)?;
        let (_, keys, _) = KINDS.iter().find(|(known, ..)| *known == word)?;
        let mut complete = true;
        for key in OF_A_KIND {
            let (given, wanted) = (self.table.get(key).is_some(), keys.contains(&key));
            if given && !wanted {
                self.not_of_this_kind(key, word);
            } else if wanted && !given {
                complete = false;
                self.missing(key, word);
            }
        }
        let kind = complete.then(|| self.kind(word)).flatten()?;
        let at_s = self.number("at_s")?;
        Some(Fault { at_s, for_s: self.number("for_s"), kind })
    }

    fn kind(&mut self, word: &str) -> Option<FaultKind> {
        Some(match word {
            "laser-off" => FaultKind::LaserOff { laser: self.laser()? },
            "laser-dim" => FaultKind::LaserDim { laser: self.laser()?, share: self.number("share")? },
            "frame-blank" => FaultKind::FrameBlank,
            "frame-dropped" => FaultKind::FrameDropped { share: self.number("share")? },
            "frame-repeated" => FaultKind::FrameRepeated { share: self.number("share")? },
            "frame-late" => FaultKind::FrameLate { frames: self.number("frames")? as usize },
            "lens-dirt" => FaultKind::LensDirt { share: self.number("share")? },
            "gain-drift" => FaultKind::GainDrift { rate_1_s: self.number("rate_1_s")? },
            "encoder-loses" => FaultKind::EncoderLoses { side: self.side()?, share: self.number("share")? },
            "encoder-stuck" => FaultKind::EncoderStuck { side: self.side()? },
            "motor-weak" => FaultKind::MotorWeak { side: self.side()?, share: self.number("share")? },
            "motor-dead" => FaultKind::MotorDead { side: self.side()? },
            "wheel-slips" => {
                FaultKind::WheelSlips { wheel: self.text("wheel").and_then(Wheel::of)?, share: self.number("share")? }
            }
            "push" => FaultKind::Push { force_n: [self.number("forward_n")?, self.number("left_n")?] },
            "pan-misread" => FaultKind::PanMisread { by_rad: Scale::Degrees.si(self.number("by_deg")?) },
            "link-lost" => FaultKind::LinkLost,
            "wheels-swapped" => FaultKind::WheelsSwapped,
            _ => return None,
        })
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.table.get(key)?.as_number()
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.table.get(key)?.as_text()
    }

    fn side(&self) -> Option<Side> {
        self.text("side").and_then(Side::of)
    }

    fn laser(&mut self) -> Option<usize> {
        let names: Vec<&str> = self.rig.lasers.iter().map(|l| l.name.as_str()).collect();
        let name = self.text("laser")?.to_owned();
        let laser = names.iter().position(|n| *n == name);
        if laser.is_none() && self.checked.is_sound(&["sensor"]) {
            let path = format!("{}.laser", self.path);
            let guess =
                nearest(&name, names.iter().copied()).map(|near| format!("did you mean \"{near}\"? ")).unwrap_or_default();
            let finding = Finding::new(self.typed.span(&path), format!("the rig has no laser \"{name}\""));
            self.checked.wrong(&path, finding.help(format!("{guess}the rig's lasers: {}", quoted(&names))));
        }
        laser
    }

    fn not_of_this_kind(&mut self, key: &str, word: &str) {
        let path = format!("{}.{key}", self.path);
        if !self.checked.is_sound(&[&path]) {
            return;
        }
        let kinds: Vec<&str> = KINDS.iter().filter(|(_, keys, _)| keys.contains(&key)).map(|(kind, ..)| *kind).collect();
        let finding = Finding::new(self.typed.span(&path), format!("`{key}` in a fault of kind \"{word}\""));
        self.checked.wrong(&path, finding.help(format!("only these kinds have it: {}", quoted(&kinds))));
    }

    fn missing(&mut self, key: &str, word: &str) {
        let of_key = format!("{}.{key}", self.path);
        // Something of the rig that is wrong may be why no laser is there to name.
        if !self.checked.is_sound(&[&of_key]) || (key == "laser" && !self.checked.is_sound(&["sensor"])) {
            return;
        }
        let help = match key {
            "laser" => {
                let names: Vec<&str> = self.rig.lasers.iter().map(|l| l.name.as_str()).collect();
                format!("the rig's lasers: {}", quoted(&names))
            }
            "side" => format!("one of {}", quoted(&Side::WORDS)),
            "wheel" => format!("one of {}", quoted(&Wheel::WORDS)),
            _ => format!("a fault of kind \"{word}\" needs it"),
        };
        let path = self.path.clone();
        let message = format!("`{path}` is a \"{word}\" and does not say `{key}`");
        self.checked.wrong(&path, Finding::new(self.typed.span(&path), message).help(help));
    }
}

/// The faults of a scenario as it would be written: of each, its keys and values.
pub(super) fn write(scenario: &Scenario) -> impl Iterator<Item = Vec<(&'static str, Value)>> + '_ {
    scenario.faults.iter().map(|fault| {
        let mut pairs = vec![("kind", Value::Text(fault.kind.word().to_owned())), ("at_s", Value::Number(fault.at_s))];
        pairs.extend(fault.for_s.map(|for_s| ("for_s", Value::Number(for_s))));
        pairs.extend(fault.kind.parameters(&scenario.rig));
        pairs
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fault of each kind, with each key that it needs, is read as that kind and written as it was read.
    #[test]
    fn every_kind_is_read_and_written() {
        for (word, keys, _) in KINDS {
            let value = |key: &str| match key {
                "laser" => "\"high\"",
                "side" => "\"right\"",
                "wheel" => "\"rear-left\"",
                "frames" => "3",
                "left_n" => "-2.5",
                _ => "0.25",
            };
            let given: Vec<String> = keys.iter().map(|key| format!("{key} = {}", value(key))).collect();
            let text = format!(
                "format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{{ straight_m = 6.0 }}]\n\
                 [sensor]\npreset = \"wide\"\n[[fault]]\nkind = \"{word}\"\nat_s = 1.5\nfor_s = 2.0\n{}\n",
                given.join("\n")
            );
            let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
            let [fault] = scenario.faults[..] else { panic!("{word}: {:?}", scenario.faults) };
            assert_eq!((fault.kind.word(), fault.at_s, fault.for_s), (word, 1.5, Some(2.0)));
            assert!(!fault.kind.label(&scenario.rig).contains('{'), "{word}");
            let written = scenario.to_toml();
            let again = Scenario::from_toml_str(&written).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
            assert_eq!(again.faults, scenario.faults, "{written}");
        }
    }
}
