//! The reference path as a survey sees it: its straights, each of one width, and its junctions.

use std::ops::Range;

use ductloop_duct::network::Network;
use nalgebra::{Point3, Unit, Vector3};

use crate::record::FrameRecord;

/// A wall that ends a straight is looked for up to here, in metres.
const WALL_WITHIN_M: f64 = 100.0;
/// A ray towards it sets out so far before the end of the path, in metres: the path may end in the wall itself.
const BEFORE_END_M: f64 = 1e-3;
/// Widths that differ by less are one, in metres.
const SAME_WIDTH_M: f64 = 1e-6;

/// A piece of the path that neither turns nor changes its width: the straight fittings between two bends or transitions, and what it
/// goes straight through between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Straight {
    /// The path's segments in it.
    pub(super) segments: Range<usize>,
    /// Where it begins and ends, in metres along the path; where the path turns back, the wall behind that place. `None` where nothing
    /// ends it: an open end.
    pub(super) begin_m: Option<f64>,
    /// See `begin_m`.
    pub(super) end_m: Option<f64>,
    /// Width, in metres.
    pub(super) width_m: f64,
    /// By how much the path turns between its end and the next straight, in radians, positive to the left; `None` for the last one.
    pub(super) turn_rad: Option<f64>,
}

/// All straights of the path, in its order.
pub(super) fn straights(network: &Network) -> Vec<Straight> {
    let segments = &network.centreline.segments;
    let is_straight = |at: usize| {
        let segment = &segments[at];
        segment.curvature_1_m == 0.0 && (segment.width_m - segment.end_width_m).abs() < SAME_WIDTH_M
    };
    let goes_on = |at: usize| !segments[at].turns_back && (segments[at].width_m - segments[at - 1].width_m).abs() < SAME_WIDTH_M;
    let mut found: Vec<Range<usize>> = Vec::new();
    for at in (0..segments.len()).filter(|at| is_straight(*at)) {
        match found.last_mut() {
            Some(last) if last.end == at && goes_on(at) => last.end = at + 1,
            _ => found.push(at..at + 1),
        }
    }
    let turns_back = |at: usize| segments.get(at).is_some_and(|segment| segment.turns_back);
    let straight = |(index, range): (usize, &Range<usize>)| {
        let (first, last) = (&segments[range.start], &segments[range.end - 1]);
        let path_end_m = last.start_m + last.length_m;
        let begin_m = match turns_back(range.start) {
            true => wall(network, range.start, 0.0, -1.0).map(|behind_m| first.start_m - behind_m),
            false => Some(first.start_m),
        };
        let end_m = match turns_back(range.end) || range.end == segments.len() {
            true => wall(network, range.end - 1, last.length_m, 1.0).map(|ahead_m| path_end_m + ahead_m),
            false => Some(path_end_m),
        };
        let turn_rad = found.get(index + 1).map(|next| match turns_back(next.start) {
            true => std::f64::consts::PI,
            false => segments[range.end..next.start].iter().map(|arc| arc.curvature_1_m * arc.length_m).sum(),
        });
        Straight { segments: range.clone(), begin_m, end_m, width_m: first.width_m, turn_rad }
    };
    found.iter().enumerate().map(straight).collect()
}

/// How far a wall across the duct is from a place on a segment, on the way ahead (1) or back (-1), in metres.
fn wall(network: &Network, segment: usize, along_m: f64, way: f64) -> Option<f64> {
    let segment = &network.centreline.segments[segment];
    let pose = segment.pose_at(along_m);
    let from = pose * Point3::new(-way * BEFORE_END_M, 0.0, segment.height_m / 2.0);
    let cell = network.cells_of(segment.fitting).next()?;
    let cell = network.cell_at(&from, cell)?;
    let hit = network.cast(cell, &from, &Unit::new_unchecked(pose.rotation * (Vector3::x() * way)), WALL_WITHIN_M)?;
    Some(hit.distance_m - BEFORE_END_M)
}

/// The straight in which most of these frames were exposed; `None` where the robot was on the path in none of them.
pub(super) fn straight_of<'f>(
    network: &Network,
    all: &[Straight],
    frames: impl Iterator<Item = &'f FrameRecord>,
) -> Option<usize> {
    let mut counts = vec![0_usize; all.len()];
    for frame in frames.filter(|frame| is_on_path(network, frame)) {
        if let Some(straight) = all.iter().position(|straight| straight.segments.contains(&frame.truth.segment)) {
            counts[straight] += 1;
        }
    }
    // The first of the greatest.
    let best = (0..all.len()).max_by_key(|straight| (counts[*straight], usize::MAX - straight))?;
    (counts[best] > 0).then_some(best)
}

/// Whether the robot is in the fitting that the path goes through there.
pub(super) fn is_on_path(network: &Network, frame: &FrameRecord) -> bool {
    network.centreline.segments.get(frame.truth.segment).is_some_and(|segment| segment.fitting == frame.truth.fitting)
}

/// Junctions of the path that the robot went through: it was in the junction where the path is, and later behind it on the path.
pub fn junctions_taken(network: &Network, frames: &[FrameRecord]) -> u32 {
    let segments = &network.centreline.segments;
    let mut inside: Option<(usize, usize)> = None;
    let mut taken = 0;
    for frame in frames.iter().filter(|frame| is_on_path(network, frame)) {
        let at = frame.truth.segment;
        let fitting = segments[at].fitting;
        match inside {
            Some((junction, _)) if junction == fitting => {}
            Some((_, entered)) => {
                taken += u32::from(at > entered);
                inside = None;
            }
            None => {}
        }
        if inside.is_none() && network.fittings[fitting].is_junction() {
            inside = Some((fitting, at));
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn network(duct: &str) -> Network {
        let text = format!("format = 1\nkind = \"scenario\"\nname = \"t\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n{duct}");
        let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
        scenario.duct.network().unwrap_or_else(|wrong| panic!("{wrong}"))
    }

    /// Numbers of a straight, in the order in which they stand in it.
    type Expected = (Option<f64>, Option<f64>, f64, Option<f64>);

    fn close(found: &[Straight], expected: &[Expected]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        let near =
            |a: Option<f64>, b: Option<f64>| a.is_some() == b.is_some() && (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() < 1e-9;
        for (straight, (begin_m, end_m, width_m, turn_rad)) in std::iter::zip(found, expected) {
            let same = near(straight.begin_m, *begin_m) && near(straight.end_m, *end_m) && near(straight.turn_rad, *turn_rad);
            assert!(same && (straight.width_m - width_m).abs() < 1e-9, "{straight:?}");
        }
    }

    #[test]
    fn straights_lie_between_bends_and_transitions() {
        let network = network(
            "run = [{ straight_m = 2.0 }, { straight_m = 1.0 }, { mitre_deg = -90 }, { straight_m = 1.5 },\n\
             { transition_m = 0.4, to_width_m = 0.4 }, { straight_m = 1.0 }]\nexit = \"open\"",
        );
        let arc_m = 0.25 * std::f64::consts::FRAC_PI_2;
        let second = 3.0 + arc_m;
        close(
            &straights(&network),
            &[
                (Some(0.0), Some(3.0), 0.5, Some(-std::f64::consts::FRAC_PI_2)),
                (Some(second), Some(second + 1.5), 0.5, Some(0.0)),
                (Some(second + 1.9), None, 0.4, None),
            ],
        );
    }

    /// Past a tee, back from 0.6 m before the cap, and into its branch.
    #[test]
    fn a_dead_end_reaches_to_its_wall_both_ways() {
        let network = network(
            "run = [{ straight_m = 2.0 }, { tee = \"left\", name = \"t\" }, { straight_m = 2.0 }]\nexit = \"cap\"\n\
             [[duct.branch]]\nfrom = \"t.left\"\nrun = [{ straight_m = 1.5 }]\nend = \"cap\"\n\
             [route]\nturns = [\"straight\", \"turn-back\", \"right\"]",
        );
        let (turn, half) = (2.5 + 1.4, std::f64::consts::FRAC_PI_2);
        let branch = turn + 1.4 + 0.25 * half;
        close(
            &straights(&network),
            &[
                (Some(0.0), Some(4.5), 0.5, Some(std::f64::consts::PI)),
                (Some(turn - 0.6), Some(turn + 1.4), 0.5, Some(-half)),
                (Some(branch), Some(branch + 1.5), 0.5, None),
            ],
        );
    }
}
