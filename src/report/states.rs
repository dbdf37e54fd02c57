//! How long the navigator was in which state, and why.

use ductloop_nav::navigator::{Reason, State};
use minijinja::{Value, context};

use crate::output::frames::state_word;
use crate::output::words::number;
use crate::reason_words::reason_about;
use crate::record::RunRecord;
use crate::scenario::Scenario;

/// A row for each state and reason that occurred, in the order in which they first did.
pub(super) fn rows(scenario: &Scenario, run: &RunRecord) -> Vec<Value> {
    let mut seen: Vec<((State, Option<Reason>), usize, f64)> = Vec::new();
    for frame in &run.frames {
        let key = (frame.state, frame.reason);
        match seen.iter_mut().find(|(known, ..)| *known == key) {
            Some((_, frames, _)) => *frames += 1,
            None => seen.push((key, 1, frame.time_s)),
        }
    }
    let row = |((state, reason), frames, first_s): ((State, Option<Reason>), usize, f64)| {
        context! {
            state => state_word(state),
            why => reason.map_or("", reason_about),
            seconds => number(frames as f64 / f64::from(scenario.rates.camera_hz), 3),
            first => number(first_s, 3),
        }
    };
    seen.into_iter().map(row).collect()
}
