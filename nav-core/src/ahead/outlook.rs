//! Which fitting lies ahead, and how sure that is.

use super::features::Features;
use super::matching::Match;
use super::model::{Family, Model};
use super::strip::DuctPlace;

/// A side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// What the duct becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fitting {
    /// Not known.
    #[default]
    Unknown,
    /// It goes straight on as far as is seen.
    Straight,
    /// It turns to this side and goes nowhere else.
    Elbow(Side),
    /// It goes on, and a branch leaves to this side.
    Branch(Side),
    /// It ends across another duct: left and right.
    BullheadTee,
    /// It goes on, and branches leave to both sides.
    Cross,
    /// It becomes wider or narrower.
    Transition,
    /// It goes on aside of where it was, by an S-bend to this side.
    Offset(Side),
    /// Its floor ends.
    Drop,
    /// Something stands in it that does not reach from wall to wall.
    Obstacle,
    /// It ends.
    DeadEnd,
}

impl Fitting {
    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Straight => "straight",
            Self::Elbow(Side::Left) => "elbow-left",
            Self::Elbow(Side::Right) => "elbow-right",
            Self::Branch(Side::Left) => "branch-left",
            Self::Branch(Side::Right) => "branch-right",
            Self::BullheadTee => "bullhead-tee",
            Self::Cross => "cross",
            Self::Transition => "transition",
            Self::Offset(Side::Left) => "offset-left",
            Self::Offset(Side::Right) => "offset-right",
            Self::Drop => "drop",
            Self::Obstacle => "obstacle",
            Self::DeadEnd => "dead-end",
        }
    }
}

impl Side {
    /// 0 left, 1 right.
    pub fn index(self) -> usize {
        self as usize
    }

    /// 1 left, -1 right: the sign of a turn to this side.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// What is ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outlook {
    /// Which fitting, after hysteresis.
    pub fitting: Fitting,
    /// Where it begins, in metres along the duct: where its first wall ends, or where the duct does.
    pub at_m: f64,
    /// How far that is from the base, along the duct, in metres.
    pub distance_m: f64,
    /// Share of the last frames that showed this fitting.
    pub confidence: f64,
    /// Where the left and the right wall are open there, from and to, in metres along the duct.
    pub openings: [Option<[f64; 2]>; 2],
    /// Angle of an elbow, positive to the left, in radians.
    pub turn_rad: Option<f64>,
    /// Radius of the middle of a radius elbow, in metres.
    pub radius_m: Option<f64>,
    /// Width of the duct behind an elbow or a transition, in metres.
    pub width_m: Option<f64>,
    /// Where something stands across the way, or the floor ends, in metres along the duct.
    pub blocked_m: Option<f64>,
    /// Where the duct is seen to end being a straight one, whatever it becomes, in metres along it.
    pub straight_to_m: Option<f64>,
}

/// Frames over which a fitting must hold.
const FRAMES: u32 = 12;
/// Share of them that must show it.
const HOLDS: f64 = 0.7;
/// A fitting that this share of the last frames did not show is not known any more.
const DROPS: f64 = 0.3;
/// The best model must explain so much more than the best one of another name, of fewer rays than these still more, and leave no more than
/// this unexplained (shares of the rays).
const MARGIN: f64 = 0.012;
const ENOUGH_SIGHTS: f64 = 240.0;
const UNEXPLAINED: f64 = 0.25;
/// A wall that ends a duct is seen to reach so far to both sides, as a share of half the width.
const SPANS_SHARE: f64 = 0.75;
/// What does not is a thing in the duct, if it is no farther than this, in metres.
const OBSTACLE_WITHIN_M: f64 = 1.0;
/// A duct is straight if it is seen to be for this many widths.
const STRAIGHT_WIDTHS: f64 = 1.5;

/// Watches what frames show.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Watch {
    /// What the last frames showed: the same fitting so often ...
    last: Fitting,
    /// ... as an exponential mean over [`FRAMES`].
    share: f64,
    held: Fitting,
    /// The model of that name which was seen last.
    model: Option<Model>,
}

impl Watch {
    /// The model of what is held to be ahead.
    pub(super) fn model(&self) -> Option<&Model> {
        self.model.as_ref()
    }

    pub(super) fn look(&mut self, features: &Features, matched: Option<&Match>, place: &DuctPlace) -> Outlook {
        let (fitting, model) = classify(features, matched, place);
        let weight = 1.0 / f64::from(FRAMES);
        if fitting == self.last {
            self.share += weight * (1.0 - self.share);
        } else {
            (self.last, self.share) = (fitting, weight);
        }
        if self.share >= HOLDS {
            self.held = self.last;
        } else if self.held != self.last && self.share >= DROPS {
            self.held = Fitting::Unknown;
        }
        if fitting == self.held {
            self.model = model;
        } else if self.model.is_some_and(|model| model.fitting() != self.held) {
            self.model = None;
        }
        let confidence = if self.held == self.last { self.share } else { 0.0 };
        let stands_m = match self.held {
            Fitting::DeadEnd | Fitting::Obstacle => self.model.map(|model| model.begins_m()).or(features.across_m),
            _ => features.across_m,
        };
        let blocked_m = stands_m.into_iter().chain(features.drop_m).min_by(f64::total_cmp);
        let at_m = match (&self.model, self.held) {
            (Some(model), _) => model.begins_m(),
            (None, Fitting::Drop | Fitting::Obstacle | Fitting::DeadEnd) => blocked_m.unwrap_or(features.free_to_m),
            _ => features.events_m().fold(f64::INFINITY, f64::min).min(features.free_to_m),
        };
        let outlook = Outlook {
            fitting: self.held,
            at_m,
            distance_m: at_m - place.along_m,
            confidence,
            blocked_m,
            straight_to_m: features.events_m().chain(features.across_m).chain(features.drop_m).min_by(f64::total_cmp),
            ..Outlook::default()
        };
        self.model.map_or(outlook, |model| Outlook {
            openings: model.openings(),
            turn_rad: model.turn_rad(),
            radius_m: model.radius_m(place.width_m),
            width_m: model.width_behind_m(place.width_m),
            ..outlook
        })
    }
}

/// What it is: a floor that ends, the fitting that explains the rays best, or what is left.
fn classify(features: &Features, matched: Option<&Match>, place: &DuctPlace) -> (Fitting, Option<Model>) {
    if features.drop_m.is_some() {
        return (Fitting::Drop, None);
    }
    if let Some(Match { model, cost, other, sights }) = matched
        && *cost < UNEXPLAINED
        && other - cost > MARGIN * (ENOUGH_SIGHTS / *sights as f64).max(1.0)
        && model.family != Family::Straight
    {
        return (model.fitting(), Some(*model));
    }
    let is_empty = features.events_m().next().is_none() || matched.is_some_and(|m| m.model.family == Family::Straight);
    match features.across_m {
        Some(at_m) if is_empty => {
            let spans = features.across_reach_m.iter().all(|reach| reach.abs() >= SPANS_SHARE * place.width_m / 2.0);
            match spans {
                true => (Fitting::DeadEnd, None),
                // From afar a bend's first piece looks like one.
                false if at_m - place.along_m < OBSTACLE_WITHIN_M => (Fitting::Obstacle, None),
                false => (Fitting::Unknown, None),
            }
        }
        None if is_empty && features.free_to_m >= place.along_m + STRAIGHT_WIDTHS * place.width_m => (Fitting::Straight, None),
        _ => (Fitting::Unknown, None),
    }
}
