//! `survey.json`: the ducts as they were driven, each held against the truth, and the figures of the whole.

use ductloop_duct::network::Network;
use ductloop_nav::course::DuctRecord;
use ductloop_nav::mapping::{Closed, Closure, Figure, Height};
use serde::Serialize;

use super::deposits::{self, RESOLVED_M, SurveyedDeposit};
use super::drift::{drift_m, path_m};
use super::path::{Straight, is_on_path, junctions_taken, straight_of, straights};
use crate::record::{FrameRecord, RunRecord};
use crate::scenario::Scenario;

/// Shorter straights, and ducts that were driven along for less, are left out of the largest errors, in metres.
const LEAST_M: f64 = 1.0;
/// Heights that differ by less are one, in metres.
const SAME_HEIGHT_M: f64 = 1e-6;

/// The document: fields in this order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Survey {
    /// Version of this document's format.
    pub format: u32,
    /// The ducts in which the robot was, in order, as its own log has them.
    pub ducts: Vec<SurveyedDuct>,
    /// Ducts that are one: closed loops.
    pub loops: Vec<Loop>,
    /// Distance between believed and true place at the last frame, with the loops closed; null without a believed one.
    pub drift_m: Option<f64>,
    /// The same without closing them.
    pub drift_open_m: Option<f64>,
    /// `drift_m` over the way.
    pub drift_share: Option<f64>,
    /// Way of the robot.
    pub path_m: f64,
    /// Deposits thinner than this are not asked for.
    pub deposits_resolved_m: f64,
    /// Points of the cloud; null where none is kept.
    pub points: Option<usize>,
    /// Junctions that it went through, by the truth.
    #[serde(skip)]
    pub junctions_taken: u32,
    /// Deposits that were not found, and that are none; null where no floor was seen.
    #[serde(skip)]
    pub deposits_missed: Option<u32>,
    /// See `deposits_missed`.
    #[serde(skip)]
    pub deposits_false: Option<u32>,
    /// Largest error of a deposit's mean thickness.
    #[serde(skip)]
    pub deposit_error_max_m: Option<f64>,
}

/// A duct.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyedDuct {
    /// From where the passage before it ends (the first one from the start; a dead end's from its wall) to where the next begins; null
    /// where the end was not seen.
    pub length_m: Option<f64>,
    /// Standard deviation of the length; null where that of an end is not known.
    pub length_sigma_m: Option<f64>,
    /// Width; null where nothing measures it.
    pub width_m: Option<f64>,
    /// Standard deviation of the width.
    pub width_sigma_m: Option<f64>,
    /// Height, by the pieces of the way on which light was seen on the ceiling; null where none was.
    pub height_m: Option<f64>,
    /// Standard deviation of the height.
    pub height_sigma_m: Option<f64>,
    /// What lies on its floor, along it.
    pub deposits: Vec<SurveyedDeposit>,
    /// The stretch of it whose floor was seen, from its beginning; null where none was.
    pub floor_seen_m: Option<[f64; 2]>,
    /// By what fitting it was left; null for the one in which the run ended.
    pub left_by: Option<&'static str>,
    /// Turn by which it was left, positive to the left.
    pub turn_deg: Option<f64>,
    /// Standard deviation of that turn; null of a turn on the spot, and where none is known.
    pub turn_sigma_deg: Option<f64>,
    /// Radius of that turn's arc; null where there is none.
    pub radius_m: Option<f64>,
    /// What was met in it: branches passed, and what it turned back or stopped before.
    pub met: Vec<Thing>,
    /// The straight that the robot was truly in.
    #[serde(rename = "true")]
    pub truth: Option<Figures>,
    /// What was found less what is true.
    pub error: Option<Figures>,
    /// Way along this straight of the path in its frames.
    #[serde(skip)]
    driven_m: f64,
}

/// A duct into which the robot came again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Loop {
    /// The two that are one, by their places in `ducts`, counted from 1.
    pub ducts: [usize; 2],
    /// Whether it was driven the other way the second time.
    pub opposite: bool,
    /// By how much they did not meet, as the ducts before them had it: along the first one, ...
    pub misclosure_along_m: f64,
    /// ... across it, to the left, ...
    pub misclosure_left_m: f64,
    /// ... and in direction.
    pub misclosure_deg: f64,
}

impl Loop {
    fn of(closed: &Closed) -> Self {
        let [along_m, left_m, turn_rad] = closed.misclosure;
        Self {
            ducts: closed.ducts.map(|duct| duct + 1),
            opposite: closed.is_opposite,
            misclosure_along_m: along_m,
            misclosure_left_m: left_m,
            misclosure_deg: turn_rad.to_degrees(),
        }
    }
}

/// Something met in a duct.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thing {
    /// What.
    pub fitting: &'static str,
    /// Where, from the duct's beginning; null where that was not seen.
    pub at_m: Option<f64>,
}

/// Figures of a duct, or their errors. What has no true value or was not found is null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Length.
    pub length_m: Option<f64>,
    /// Width.
    pub width_m: Option<f64>,
    /// Height.
    pub height_m: Option<f64>,
    /// Turn by which it is left.
    pub turn_deg: Option<f64>,
}

impl Survey {
    /// Of a run; `None` if the scenario's duct is none, which no scenario that was read has.
    pub fn of(scenario: &Scenario, run: &RunRecord) -> Option<Self> {
        let network = scenario.duct.network().ok()?;
        let path_m = path_m(&run.frames);
        let (notes, closure) = (&run.notes, run.notes.closure());
        let world_from_first = network.centreline.pose_at(scenario.start.distance_m);
        let drift_open_m = drift_m(&world_from_first, &run.frames, notes, &Closure::default());
        let drift_m = drift_m(&world_from_first, &run.frames, notes, &closure);
        let found = deposits::found(scenario, &network, notes, &closure, &run.frames);
        let mut ducts = ducts(scenario, &network, run);
        for (duct, deposit) in found.deposits {
            if let Some(duct) = ducts.get_mut(duct) {
                duct.deposits.push(deposit);
            }
        }
        Some(Self {
            format: 1,
            ducts,
            loops: closure.loops.iter().map(Loop::of).collect(),
            drift_m,
            drift_open_m,
            drift_share: drift_m.filter(|_| path_m > 0.0).map(|drift_m| drift_m / path_m),
            path_m,
            deposits_resolved_m: RESOLVED_M,
            points: run.notes.cloud.as_ref().map(|cloud| cloud.points().count()),
            junctions_taken: junctions_taken(&network, &run.frames),
            deposits_missed: found.missed,
            deposits_false: found.none,
            deposit_error_max_m: found.error_max_m,
        })
    }

    /// Largest error of a length, as a share of it, over straights of at least a metre.
    pub fn length_error_max(&self) -> Option<f64> {
        let share = |duct: &SurveyedDuct| {
            let true_m = duct.truth?.length_m.filter(|length_m| *length_m >= LEAST_M)?;
            Some((duct.error?.length_m? / true_m).abs())
        };
        self.ducts.iter().filter_map(share).reduce(f64::max)
    }

    /// Largest error of a width, over ducts that were driven along for at least a metre, in metres.
    pub fn width_error_max_m(&self) -> Option<f64> {
        let driven = self.ducts.iter().filter(|duct| duct.driven_m >= LEAST_M);
        driven.filter_map(|duct| Some(duct.error?.width_m?.abs())).reduce(f64::max)
    }

    /// The document's text.
    ///
    /// # Errors
    /// None that is known of: a number that is not finite becomes null.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

fn ducts(scenario: &Scenario, network: &Network, run: &RunRecord) -> Vec<SurveyedDuct> {
    let all = straights(network);
    let log = &run.notes.ducts;
    let frames_of = |duct: usize| run.frames.iter().filter(move |frame| frame.ducts == duct + 1);
    let held: Vec<Option<usize>> = (0..log.len()).map(|duct| straight_of(network, &all, frames_of(duct))).collect();
    let mut ducts: Vec<SurveyedDuct> = (0..log.len()).map(|duct| found(&log[duct], run, duct)).collect();
    for (number, duct) in ducts.iter_mut().enumerate() {
        let Some(index) = held[number] else { continue };
        let next_is_next = held.get(number + 1).is_some_and(|next| *next == Some(index + 1));
        let mut truth = truth(network, &all[index]);
        truth.turn_deg = truth.turn_deg.filter(|_| next_is_next);
        // The first one is measured from where the run began.
        if number == 0 {
            truth.length_m = all[index].end_m.map(|end_m| end_m - scenario.start.distance_m);
        }
        duct.driven_m = driven_m(network, &all[index], frames_of(number));
        duct.error = Some(duct.less(&truth));
        duct.truth = Some(truth);
    }
    ducts
}

fn truth(network: &Network, straight: &Straight) -> Figures {
    let segments = &network.centreline.segments[straight.segments.clone()];
    let height_m = segments[0].height_m;
    let is_one = segments.iter().all(|segment| (segment.height_m - height_m).abs() < SAME_HEIGHT_M);
    Figures {
        length_m: straight.begin_m.zip(straight.end_m).map(|(begin_m, end_m)| end_m - begin_m),
        width_m: Some(straight.width_m),
        height_m: Some(height_m).filter(|_| is_one),
        turn_deg: straight.turn_rad.map(f64::to_degrees),
    }
}

/// How much of the straight lies between the first and the last of these frames in it.
fn driven_m<'f>(network: &Network, straight: &Straight, frames: impl Iterator<Item = &'f FrameRecord>) -> f64 {
    let is_in = |frame: &&FrameRecord| straight.segments.contains(&frame.truth.segment) && is_on_path(network, frame);
    let along = frames.filter(is_in).map(|frame| frame.truth.distance_m);
    let (from_m, to_m) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), at| (from.min(at), to.max(at)));
    (to_m - from_m).max(0.0)
}

/// What the notes say of a duct.
fn found(log: &DuctRecord, run: &RunRecord, number: usize) -> SurveyedDuct {
    let height: Option<Height> = run.notes.ceilings.height(number);
    let from_begin = |at_m: f64| at_m - log.begin_m.unwrap_or(0.0);
    let width_sigma_m = log.width_deviation_m;
    let ends = run.notes.ends.of(&run.notes.ducts, number);
    // By the walls at its ends, where those were seen.
    let by_wall =
        |logged_m: Option<f64>, figure: Option<Figure>| logged_m.map(|logged_m| figure.map_or(logged_m, |figure| figure.value));
    let length_m = by_wall(log.begin_m, ends.begin_m).zip(by_wall(log.end_m, ends.end_m)).map(|(begin_m, end_m)| end_m - begin_m);
    let met = |met: &ductloop_nav::course::Met| Thing {
        fitting: met.fitting.word(),
        at_m: log.begin_m.map(|begin_m| met.at_m - begin_m),
    };
    SurveyedDuct {
        length_m,
        length_sigma_m: length_m.and_then(|length_m| ends.length_sigma_m(length_m)),
        width_m: width_sigma_m.map(|_| log.width_m),
        width_sigma_m,
        height_m: height.map(|height| height.height_m),
        height_sigma_m: height.map(|height| height.sigma_m),
        deposits: Vec::new(),
        // Light beyond the end is on another duct's floor, or on what the wall throws back.
        floor_seen_m: run
            .notes
            .floors
            .seen_m(number)
            .map(|ends_m| ends_m.map(from_begin).map(|at_m| length_m.map_or(at_m, |length_m| at_m.min(length_m)))),
        left_by: log.by.map(|fitting| fitting.word()),
        turn_deg: log.by.map(|_| ends.turn_rad.map_or(log.turn_rad, |turn_rad| turn_rad.value).to_degrees()),
        turn_sigma_deg: ends.turn_rad.map(|turn_rad| turn_rad.sigma.to_degrees()),
        radius_m: Some(log.radius_m).filter(|radius_m| log.by.is_some() && radius_m.is_finite() && *radius_m > 0.0),
        met: log.met.iter().map(met).collect(),
        truth: None,
        error: None,
        driven_m: 0.0,
    }
}

impl SurveyedDuct {
    fn less(&self, truth: &Figures) -> Figures {
        let less = |found: Option<f64>, truth: Option<f64>| found.zip(truth).map(|(found, truth)| found - truth);
        Figures {
            length_m: less(self.length_m, truth.length_m),
            width_m: less(self.width_m, truth.width_m),
            height_m: less(self.height_m, truth.height_m),
            turn_deg: less(self.turn_deg, truth.turn_deg),
        }
    }
}
