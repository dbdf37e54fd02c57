//! The frames before a thing: what it was named before the robot entered it, since when, and how exactly.

use ductloop_nav::ahead::Fitting;
use serde::Serialize;

use super::confusion::NOTHING;
use super::glance::Glance;
use super::way::Thing;

/// A name is lost when it was not given for so many frames in a row, about a quarter of a second: what was dropped for less is one name.
pub(super) const LOST_FRAMES: usize = 8;
/// What was named last counts if it was named within this before the robot entered, in widths of the duct: what was said of it farther
/// off and not upheld is forgotten.
const LAST_WIDTHS: f64 = 1.0;
/// A thing that is never entered (a dead end, or where a run ends) counts if the robot came as near as this, in widths: by then it should
/// have been named.
const NEAR_WIDTHS: f64 = 1.5;
/// Least distance from which a thing could be seen for its detection distance to say anything of the robot, in widths.
const ROOM_WIDTHS: f64 = 2.0;

/// How a thing was named. Distances are those of the base from where the thing begins, along the path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittingScore {
    /// What it is called: the fitting's name, or the object's.
    pub name: String,
    /// What it is.
    #[serde(rename = "true")]
    pub truth: &'static str,
    /// What it was named last before the robot entered it: `unknown` if nothing within the last width; `nothing` if not even that.
    pub named: &'static str,
    /// Whether that was right, and at its place.
    pub right: bool,
    /// Where it begins, along the path.
    pub at_m: f64,
    /// Time at which the robot entered it, or was as near to it as it came.
    pub entered_s: f64,
    /// Width of the duct before it.
    pub width_m: f64,
    /// From how far it could be seen: the sensor's reach, or less where the robot came round a corner.
    pub visible_m: f64,
    /// From how far on it had its right name until it was entered; 0 if it had another one then.
    pub detected_m: f64,
    /// The same in widths of the duct.
    pub detected_widths: f64,
    /// Time from when it could be seen to that; to when it was entered, if it did not have its right name then.
    pub latency_s: f64,
    /// Named distance less the true one, when it had its right name last; null if it had not.
    pub distance_error_m: Option<f64>,
    /// The same of the width behind a transition.
    pub width_error_m: Option<f64>,
    /// Radius of the arc that the robot drove through an elbow by, less that of the elbow's middle; null for others.
    pub radius_error_m: Option<f64>,
    /// Whether a goal is set for its detection distance (elbows, tees, crosses, dead ends), and it could be seen from far enough to reach it.
    #[serde(skip)]
    pub has_goal: bool,
}

/// Whether a detection distance is asked for: of elbows, tees, crosses and dead ends.
fn has_goal(fitting: Fitting) -> bool {
    matches!(fitting, Fitting::Elbow(_) | Fitting::Branch(_) | Fitting::BullheadTee | Fitting::Cross | Fitting::DeadEnd)
}

impl FittingScore {
    /// Of a thing, by the glances at which it was the next one, in order. `None` where the robot never came near it. `radius_m` is that of
    /// the arc which the robot planned into the next duct.
    pub(super) fn of(thing: &Thing, glances: &[Glance], radius_m: impl Fn(usize) -> Option<f64>) -> Option<Self> {
        // Up to where the nose goes in; it may begin with the base still in the thing before.
        let begin = glances.iter().position(|glance| !glance.truth.is_inside)?;
        let length = glances[begin..].iter().position(|glance| glance.truth.is_inside);
        let glances = &glances[begin..length.map_or(glances.len(), |length| begin + length)];
        let last = glances.last()?;
        if length.is_none() && last.truth.distance_m > NEAR_WIDTHS * thing.width_m {
            return None;
        }
        let is_last = |glance: &&Glance| glance.truth.distance_m <= last.truth.distance_m + LAST_WIDTHS * thing.width_m;
        let is_name = |glance: &&Glance| glance.named.is_some_and(|named| named.fitting != Fitting::Unknown);
        let names = || glances.iter().rev().take_while(is_last).filter(is_name);
        // While a name is held for a few frames more, its place may be that of what these frames show.
        let is_held_on =
            |glance: &&Glance| glance.named.is_some_and(|named| named.fitting == thing.fitting) && !glance.is_right();
        let named_last = names().find(|glance| !is_held_on(glance)).or_else(|| names().next());
        let word = |glance: &Glance| glance.named.map_or(NOTHING, |named| named.fitting.word());
        let right = named_last.is_some_and(Glance::is_right);
        let held = held(glances).filter(|_| right).map(|from| &glances[from]);
        let visible = glances.iter().find(|glance| glance.truth.is_in_reach).unwrap_or(last);
        let detected_m = held.map_or(0.0, |glance| glance.truth.distance_m);
        let right_last = named_last.filter(|_| right);
        let radius_error_m = thing.radius_m.filter(|_| right && length.is_some()).zip(radius_m(last.ducts));
        Some(Self {
            name: thing.name.clone(),
            truth: thing.fitting.word(),
            named: word(named_last.unwrap_or(last)),
            right,
            at_m: thing.at_m,
            entered_s: last.time_s,
            width_m: thing.width_m,
            visible_m: visible.truth.distance_m,
            detected_m,
            detected_widths: detected_m / thing.width_m,
            latency_s: (held.unwrap_or(last).time_s - visible.time_s).max(0.0),
            distance_error_m: right_last.and_then(|glance| Some(glance.named?.distance_m - glance.truth.distance_m)),
            width_error_m: right_last.and_then(|glance| Some(glance.named?.width_m? - thing.width_after_m?)),
            radius_error_m: radius_error_m.map(|(truth_m, driven_m)| driven_m - truth_m),
            has_goal: visible.truth.distance_m >= ROOM_WIDTHS * thing.width_m && has_goal(thing.fitting),
        })
    }
}

/// The first glance from which on the right name was held to the end; `None` if it had been lost by then.
fn held(glances: &[Glance]) -> Option<usize> {
    let mut first = None;
    let mut missed = 0;
    for (index, glance) in glances.iter().enumerate().rev() {
        if glance.is_right() {
            (first, missed) = (Some(index), 0);
        } else {
            missed += 1;
        }
        // Unknown right at the end is dealt with by what was named last.
        if missed >= LOST_FRAMES && first.is_some() {
            break;
        }
    }
    first
}
