//! A run's figures, and the verdict on them.

use ductloop_duct::fitting::Shape;
use serde::Serialize;

use crate::ahead_scores::AheadScores;
use crate::reason_words::stop_reason;
use crate::record::{EndState, FrameRecord, RunRecord};
use crate::scenario::{Bound, Measured, Scenario};
use crate::survey::Survey;

/// The figures of a run, against the truth. What was not measured is `None`.
///
/// Figures of tracking (`lateral_*`, `heading_*`, estimates) leave out the settling distance that the scenario names; errors against the
/// path, and the estimator's, also what the robot does that is not to follow it: turning on the spot, and backing out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Whether the base passed the finish line.
    pub completed: bool,
    /// How the run ended.
    pub end_state: &'static str,
    /// Why the navigator had stopped, where that ended the run.
    pub stop_reason: Option<&'static str>,
    /// Distance along the centreline from start to end.
    pub distance_m: f64,
    /// Simulated time.
    pub sim_time_s: f64,
    /// Time that passed meanwhile.
    pub wall_time_s: Option<f64>,
    /// Simulated time over time that passed.
    pub real_time_factor: Option<f64>,
    /// RMS offset from the centreline.
    pub lateral_rms_m: Option<f64>,
    /// Largest offset from the centreline.
    pub lateral_max_m: Option<f64>,
    /// RMS heading error.
    pub heading_rms_rad: Option<f64>,
    /// Largest heading error.
    pub heading_max_rad: Option<f64>,
    /// RMS difference between measured and true offset.
    pub lateral_estimate_rms_m: Option<f64>,
    /// RMS difference between measured and true heading.
    pub heading_estimate_rms_rad: Option<f64>,
    /// RMS difference between the estimator's and the true offset, in straight ducts: in a bend or a junction the estimator's is from the middle
    /// of the duct that it leaves or enters, the true one from the path. `None` without an estimator, or a straight.
    pub filtered_lateral_rms_m: Option<f64>,
    /// Mean of minus the natural logarithm of the density that the estimator gives the true offset, heading and width, in metres and radians:
    /// the less, the better it knows both them and its errors (I. J. Good 1952). In straight ducts; `None` without an estimator, or
    /// a straight.
    pub filtered_log_loss: Option<f64>,
    /// Share of frames that gave both offset and heading.
    pub estimates_valid: Option<f64>,
    /// Contacts with anything but the floor.
    pub collisions: u32,
    /// Highest speed of such a contact, along its normal.
    pub contact_speed_max_m_s: f64,
    /// Least distance between the robot and any wall at any exposure. Between two a collision may have come and gone.
    pub min_clearance_m: Option<f64>,
    /// Junctions passed as the route names them, by the truth.
    pub junctions_taken: u32,
    /// Distance between believed and true place at the end, over the way.
    pub survey_drift_share: Option<f64>,
    /// Largest error of a surveyed length, as a share of it, over straights of at least a metre.
    pub survey_length_error_max: Option<f64>,
    /// Largest error of a surveyed width, over ducts driven along for at least a metre.
    pub survey_width_error_max_m: Option<f64>,
    /// Deposits on the floor that the sensor resolves and that were not found.
    pub survey_deposits_missed: Option<u32>,
    /// Deposits that were found where nothing lies.
    pub survey_deposits_false: Option<u32>,
    /// Largest error of the mean thickness of a deposit that the sensor resolves.
    pub survey_deposit_error_max_m: Option<f64>,
    /// Fittings, obstacles and ends that the robot came to.
    pub ahead_fittings: u32,
    /// Share of them that it named rightly before it entered them.
    pub ahead_named_share: Option<f64>,
    /// Least distance, in widths of the duct, from which on an elbow, tee, cross or dead end had its right name.
    pub ahead_detection_widths_min: Option<f64>,
    /// Longest time from when one could be seen to when it had its right name.
    pub ahead_latency_max_s: Option<f64>,
    /// Largest error of the distance to one, when it had its right name last.
    pub ahead_distance_error_max_m: Option<f64>,
    /// How often it named something where the duct goes straight on as far as can be seen.
    pub ahead_false_alarms: Option<u32>,
    /// RMS rate of change of the commanded wheel speeds, in rad/s2.
    pub control_effort: Option<f64>,
}

/// What a run comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every criterion held.
    Pass,
    /// One did not.
    Fail,
    /// The run could not go on.
    Error,
    /// A wall-clock limit was reached.
    Timeout,
}

/// A criterion that did not hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// The metric.
    pub metric: String,
    /// Its value: a number in SI, a truth value, a word, or null where it was not measured.
    pub value: serde_json::Value,
    /// What it had to be, in the same unit: the most, or the least if `metric` says min.
    pub bound: serde_json::Value,
    /// Simulated time at which the bound was first broken, where that is one moment.
    pub at_s: Option<f64>,
}

impl Verdict {
    /// Exit code of a command whose worst verdict this is.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Pass => 0,
            Self::Fail => 1,
            Self::Error => 3,
            Self::Timeout => 4,
        }
    }

    /// By its word in files.
    pub fn of(word: &str) -> Option<Self> {
        [Self::Pass, Self::Fail, Self::Error, Self::Timeout].into_iter().find(|verdict| verdict.word() == word)
    }

    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Error => "error",
            Self::Timeout => "timeout",
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for value in values {
        sum += value;
        count += 1;
    }
    (count > 0).then(|| sum / count as f64)
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    mean(values.map(|value| value * value)).map(f64::sqrt)
}

fn greatest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.map(f64::abs).reduce(f64::max)
}

/// Whether a frame counts for figures of tracking.
fn settled<'a>(scenario: &'a Scenario) -> impl Fn(&&'a FrameRecord) -> bool + 'a {
    let from_m = scenario.start.distance_m + scenario.pass.settle_m;
    move |frame| frame.truth.distance_m >= from_m
}

/// An arc whose radius is smaller is a turn on the spot, in metres: the narrowest bend's is 0.15 m. Below this yaw rate, in rad/s, it is
/// none.
const ON_THE_SPOT_M: f64 = 0.08;
const TURNING_RAD_S: f64 = 0.05;
/// Slower than this backwards the robot stands, in m/s.
const BACKING_M_S: f64 = 0.01;

/// Whether the robot goes along the path, or stands: the path has no errors to tell while it turns on the spot, or backs out.
fn goes_along(frame: &FrameRecord) -> bool {
    let (speed_m_s, yaw_rate_rad_s) = (frame.truth.speed_m_s, frame.truth.yaw_rate_rad_s.abs());
    let turns = yaw_rate_rad_s > TURNING_RAD_S && speed_m_s.abs() < ON_THE_SPOT_M * yaw_rate_rad_s;
    !turns && speed_m_s > -BACKING_M_S
}

impl Metrics {
    /// Metrics that are numbers and bear on the result, by their names in the summary: all but `completed`, `end_state`,
    /// `stop_reason` and what depends on the machine.
    pub const NUMBERS: [&str; 28] = [
        "distance_m",
        "sim_time_s",
        "lateral_rms_m",
        "lateral_max_m",
        "heading_rms_rad",
        "heading_max_rad",
        "lateral_estimate_rms_m",
        "heading_estimate_rms_rad",
        "filtered_lateral_rms_m",
        "filtered_log_loss",
        "estimates_valid",
        "collisions",
        "contact_speed_max_m_s",
        "min_clearance_m",
        "junctions_taken",
        "survey_drift_share",
        "survey_length_error_max",
        "survey_width_error_max_m",
        "survey_deposits_missed",
        "survey_deposits_false",
        "survey_deposit_error_max_m",
        "ahead_fittings",
        "ahead_named_share",
        "ahead_detection_widths_min",
        "ahead_latency_max_s",
        "ahead_distance_error_max_m",
        "ahead_false_alarms",
        "control_effort",
    ];

    /// The figures of a run that took `wall_time_s`.
    pub fn of(scenario: &Scenario, run: &RunRecord, wall_time_s: Option<f64>) -> Self {
        Self::with_ahead(scenario, run, &AheadScores::of(scenario, run), wall_time_s)
    }

    /// The same for who has the run's scores of what was named already.
    pub(crate) fn with_ahead(scenario: &Scenario, run: &RunRecord, ahead: &AheadScores, wall_time_s: Option<f64>) -> Self {
        let tracked = || run.frames.iter().filter(settled(scenario));
        let along = || tracked().filter(|frame| goes_along(frame));
        let lateral = || along().map(|f| f.truth.lateral_m);
        let heading = || along().map(|f| f.truth.heading_rad);
        let fittings = scenario.duct.fittings();
        let is_straight = |fitting: usize| fittings.get(fitting).is_some_and(|own| matches!(own.shape, Shape::Straight { .. }));
        let in_straights = || along().filter(|frame| is_straight(frame.truth.fitting));
        let lateral_error = tracked().filter_map(|f| Some(f.measurement.lateral_m? - f.truth.lateral_m));
        let heading_error = tracked().filter_map(|f| Some(f.measurement.heading_rad? - f.truth.heading_rad));
        let valid = tracked().filter(|f| f.measurement.lateral_m.is_some() && f.measurement.heading_rad.is_some()).count();
        let count = tracked().count();
        let camera_hz = f64::from(scenario.rates.camera_hz);
        let effort = run.frames.windows(2).flat_map(|pair| {
            let [a, b] = [&pair[0], &pair[1]].map(|f| f.command.wheel_speed_rad_s);
            [(b.left - a.left) * camera_hz, (b.right - a.right) * camera_hz]
        });
        let survey = Survey::of(scenario, run);
        let survey = survey.as_ref();
        Self {
            completed: run.end == EndState::Finished,
            end_state: run.end.word(),
            stop_reason: stop_reason(run.end, run.frames.last()),
            distance_m: run.distance_m,
            sim_time_s: run.sim_time_s,
            wall_time_s,
            real_time_factor: wall_time_s.filter(|t| *t > 0.0).map(|t| run.sim_time_s / t),
            lateral_rms_m: rms(lateral()),
            lateral_max_m: greatest(lateral()),
            heading_rms_rad: rms(heading()),
            heading_max_rad: greatest(heading()),
            lateral_estimate_rms_m: rms(lateral_error),
            heading_estimate_rms_rad: rms(heading_error),
            filtered_lateral_rms_m: rms(in_straights().filter_map(|f| Some(f.estimate?.lateral_m - f.truth.lateral_m))),
            filtered_log_loss: mean(
                in_straights().filter_map(|f| f.estimate?.log_loss(f.truth.lateral_m, f.truth.heading_rad, f.width_m)),
            ),
            estimates_valid: (count > 0).then(|| valid as f64 / count as f64),
            collisions: run.collisions.count,
            contact_speed_max_m_s: run.collisions.contact_speed_max_m_s,
            min_clearance_m: run.frames.iter().map(|f| f.truth.clearance_m).reduce(f64::min),
            junctions_taken: survey.map_or(0, |survey| survey.junctions_taken),
            survey_drift_share: survey.and_then(|survey| survey.drift_share),
            survey_length_error_max: survey.and_then(Survey::length_error_max),
            survey_width_error_max_m: survey.and_then(Survey::width_error_max_m),
            survey_deposits_missed: survey.and_then(|survey| survey.deposits_missed),
            survey_deposits_false: survey.and_then(|survey| survey.deposits_false),
            survey_deposit_error_max_m: survey.and_then(|survey| survey.deposit_error_max_m),
            ahead_fittings: ahead.fittings.len() as u32,
            ahead_named_share: ahead.named_share(),
            ahead_detection_widths_min: ahead.detection_widths_min(),
            ahead_latency_max_s: ahead.latency_max_s(),
            ahead_distance_error_max_m: ahead.distance_error_max_m(),
            ahead_false_alarms: ahead.false_alarms,
            control_effort: rms(effort),
        }
    }

    /// A metric by its name in the summary.
    pub fn get(&self, name: &str) -> Measured<'_> {
        let number = |value: Option<f64>| value.map_or(Measured::Nothing, Measured::Number);
        match name {
            "completed" => Measured::Flag(self.completed),
            "end_state" => Measured::Word(self.end_state),
            "stop_reason" => self.stop_reason.map_or(Measured::Nothing, Measured::Word),
            "distance_m" => Measured::Number(self.distance_m),
            "sim_time_s" => Measured::Number(self.sim_time_s),
            "wall_time_s" => number(self.wall_time_s),
            "real_time_factor" => number(self.real_time_factor),
            "lateral_rms_m" => number(self.lateral_rms_m),
            "lateral_max_m" => number(self.lateral_max_m),
            "heading_rms_rad" => number(self.heading_rms_rad),
            "heading_max_rad" => number(self.heading_max_rad),
            "lateral_estimate_rms_m" => number(self.lateral_estimate_rms_m),
            "heading_estimate_rms_rad" => number(self.heading_estimate_rms_rad),
            "filtered_lateral_rms_m" => number(self.filtered_lateral_rms_m),
            "filtered_log_loss" => number(self.filtered_log_loss),
            "estimates_valid" => number(self.estimates_valid),
            "collisions" => Measured::Number(f64::from(self.collisions)),
            "contact_speed_max_m_s" => Measured::Number(self.contact_speed_max_m_s),
            "min_clearance_m" => number(self.min_clearance_m),
            "junctions_taken" => Measured::Number(f64::from(self.junctions_taken)),
            "survey_drift_share" => number(self.survey_drift_share),
            "survey_length_error_max" => number(self.survey_length_error_max),
            "survey_width_error_max_m" => number(self.survey_width_error_max_m),
            "survey_deposits_missed" => number(self.survey_deposits_missed.map(f64::from)),
            "survey_deposits_false" => number(self.survey_deposits_false.map(f64::from)),
            "survey_deposit_error_max_m" => number(self.survey_deposit_error_max_m),
            "ahead_fittings" => Measured::Number(f64::from(self.ahead_fittings)),
            "ahead_named_share" => number(self.ahead_named_share),
            "ahead_detection_widths_min" => number(self.ahead_detection_widths_min),
            "ahead_latency_max_s" => number(self.ahead_latency_max_s),
            "ahead_distance_error_max_m" => number(self.ahead_distance_error_max_m),
            "ahead_false_alarms" => number(self.ahead_false_alarms.map(f64::from)),
            "control_effort" => number(self.control_effort),
            _ => Measured::Nothing,
        }
    }
}

/// The verdict on a run that came to an end, and every criterion that did not hold.
pub fn judge(scenario: &Scenario, run: &RunRecord, metrics: &Metrics) -> (Verdict, Vec<Reason>) {
    let mut reasons: Vec<Reason> = scenario
        .pass
        .list
        .iter()
        .filter(|criterion| !criterion.bound.holds(metrics.get(criterion.metric)))
        .map(|criterion| Reason {
            metric: criterion.metric.to_owned(),
            value: metrics.get(criterion.metric).to_json(),
            bound: criterion.bound.to_json(),
            at_s: first_broken(scenario, run, criterion.metric, &criterion.bound),
        })
        .collect();
    // A run that the time limit ended has failed even if nothing else asks for completion, unless it was to end so.
    let asked = scenario.pass.list.iter().any(|criterion| criterion.metric == "end_state");
    let told = reasons.iter().any(|reason| reason.metric == "completed");
    if run.end == EndState::TimeLimit && !asked && !told {
        reasons.push(Reason {
            metric: "sim_time_s".into(),
            value: run.sim_time_s.into(),
            bound: scenario.time_limit_s.into(),
            at_s: Some(run.sim_time_s),
        });
    }
    (if reasons.is_empty() { Verdict::Pass } else { Verdict::Fail }, reasons)
}

/// When a bound on a momentary figure was first broken; a mean or a count over the run has no such moment but for collisions.
fn first_broken(scenario: &Scenario, run: &RunRecord, metric: &str, bound: &Bound) -> Option<f64> {
    let value = |frame: &FrameRecord| match metric {
        "lateral_max_m" => Some(frame.truth.lateral_m.abs()),
        "heading_max_rad" => Some(frame.truth.heading_rad.abs()),
        "min_clearance_m" => Some(frame.truth.clearance_m),
        "collisions" => Some(f64::from(frame.collisions.count)),
        "contact_speed_max_m_s" => Some(frame.collisions.contact_speed_max_m_s),
        _ => None,
    };
    let of_tracking = matches!(metric, "lateral_max_m" | "heading_max_rad");
    run.frames
        .iter()
        .filter(|frame| !of_tracking || (settled(scenario)(frame) && goes_along(frame)))
        .find(|frame| value(frame).is_some_and(|v| !bound.holds(Measured::Number(v))))
        .map(|frame| frame.time_s)
}

#[cfg(test)]
mod tests {
    use ductloop_nav::messages::Command;
    use ductloop_nav::rig::MountAngles;
    use ductloop_sim::collision::Collisions;
    use ductloop_sim::truth::Truth;

    use super::*;
    use crate::record::KeyFrames;
    use crate::viewpoint::still;

    fn scenario(pass: &str) -> Scenario {
        let text = format!(
            "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
             run = [{{ straight_m = 6.0 }}]\n[start]\ndistance_m = 0.5\n[pass]\nsettle_m = 1.0\n{pass}"
        );
        Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)))
    }

    /// A frame a second at 1 m/s from 0.5 m; lateral offsets in mm. Estimates are 1 mm too large, and missing on even frames.
    fn run(laterals_mm: &[f64], end: EndState) -> RunRecord {
        let frame = |(i, lateral_mm): (usize, &f64)| {
            let lateral_m = lateral_mm * 1e-3;
            let mut measurement = ductloop_nav::perception::Measurement::default();
            if i % 2 == 1 {
                (measurement.lateral_m, measurement.heading_rad) = (Some(lateral_m + 1e-3), Some(0.0));
            }
            FrameRecord {
                frame: i as u64,
                tick: 1200 * i as u64,
                time_s: i as f64,
                truth: Truth {
                    world_from_base: nalgebra::Isometry3::identity(),
                    cell: 0,
                    fitting: 0,
                    segment: 0,
                    distance_m: 0.5 + i as f64,
                    lateral_m,
                    heading_rad: -0.02,
                    clearance_m: 0.1 - lateral_m.abs(),
                    speed_m_s: 1.0,
                    yaw_rate_rad_s: 0.0,
                    wheel_speed_rad_s: Default::default(),
                    motor_current_a: Default::default(),
                },
                collisions: Collisions { count: u32::from(i >= 3), contact_speed_max_m_s: if i >= 3 { 0.2 } else { 0.0 } },
                width_m: 0.5,
                counts: Default::default(),
                mount: MountAngles::default(),
                body: Default::default(),
                measurement,
                score: Default::default(),
                state: Default::default(),
                reason: None,
                estimate: None,
                outlook: None,
                true_ahead: None,
                believed_pose: None,
                ducts: 0,
                lines: 0,
                command: Command {
                    wheel_speed_rad_s: ductloop_nav::messages::Sides { left: 0.1 * i as f64, right: -0.1 * i as f64 },
                    ..Command::stop(MountAngles::default())
                },
                view: still(nalgebra::Isometry3::identity(), 0.004),
                laser_power: 1.0,
                faults: 0,
            }
        };
        let frames: Vec<FrameRecord> = laterals_mm.iter().enumerate().map(frame).collect();
        let collisions = frames.last().map_or(Collisions::default(), |f| f.collisions);
        let (sim_time_s, distance_m) = (frames.len() as f64, frames.len() as f64);
        RunRecord {
            frames,
            key_frames: KeyFrames::default(),
            end,
            sim_time_s,
            collisions,
            distance_m,
            notes: Default::default(),
            run_hash: 0,
        }
    }

    #[test]
    fn tracking_leaves_the_settling_distance_out() {
        // The first frame stands before 1.5 m and does not count; the second stands on the line and does.
        let metrics = Metrics::of(&scenario(""), &run(&[50.0, 3.0, -4.0, 0.0], EndState::Finished), Some(2.0));
        let close = |value: Option<f64>, to: f64| value.is_some_and(|v| (v - to).abs() < 1e-12);
        assert!(close(metrics.lateral_rms_m, (25.0_f64 / 3.0).sqrt() * 1e-3), "{metrics:?}");
        assert!(close(metrics.lateral_max_m, 4e-3) && close(metrics.heading_max_rad, 0.02), "{metrics:?}");
        assert!(close(metrics.lateral_estimate_rms_m, 1e-3) && close(metrics.heading_estimate_rms_rad, 0.02), "{metrics:?}");
        assert!(close(metrics.estimates_valid, 2.0 / 3.0) && close(metrics.real_time_factor, 2.0), "{metrics:?}");
        // Clearance and collisions count from the start.
        assert!(close(metrics.min_clearance_m, 0.05) && metrics.collisions == 1 && metrics.completed, "{metrics:?}");
        assert_eq!(metrics.contact_speed_max_m_s, 0.2);
        // Each wheel's command changes by 0.1 rad/s a frame, 30 frames a second.
        assert!(metrics.control_effort.is_some_and(|effort| (effort - 3.0).abs() < 1e-9), "{metrics:?}");
    }

    /// What the estimator says in a bend is of the duct that the robot leaves, not of the path.
    #[test]
    fn the_estimator_is_judged_in_straight_ducts() {
        use ductloop_nav::estimation::{Estimate, Outcome};
        let text = "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\n[duct]\nwidth_m = 0.5\nheight_m = 0.3\n\
                    run = [{ straight_m = 2.0 }, { elbow_deg = 90.0, throat_radius_m = 0.5 }, { straight_m = 2.0 }]\n";
        let scenario = Scenario::from_toml_str(text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
        let mut run = run(&[0.0; 3], EndState::Finished);
        for (fitting, (frame, lateral_m)) in run.frames.iter_mut().zip([0.003, 0.5, 0.004]).enumerate() {
            (frame.truth.fitting, frame.truth.distance_m, frame.truth.heading_rad) = (fitting, 5.0, 0.0);
            frame.estimate = Some(Estimate {
                lateral_m,
                heading_rad: 0.0,
                width_m: 0.5,
                effective_track_m: 0.3,
                icr_m: 0.0,
                covariance: nalgebra::SMatrix::identity() * 1e-6,
                outcome: Outcome::None,
                refused: 0,
                begun_anew: 0,
            });
        }
        let metrics = Metrics::of(&scenario, &run, None);
        assert!(metrics.filtered_lateral_rms_m.is_some_and(|rms| (rms - 12.5e-6_f64.sqrt()).abs() < 1e-12), "{metrics:?}");
        // Half of (9 + 16) / 2, and ln of 1e-3 sqrt(2 pi) for each of the three.
        let expected = 6.25 + 3.0 * libm::log(1e-3 * (2.0 * std::f64::consts::PI).sqrt());
        assert!(metrics.filtered_log_loss.is_some_and(|loss| (loss - expected).abs() < 1e-9), "{metrics:?} {expected}");
    }

    /// Turning on the spot at 0.7 rad/s, backing at 0.1 m/s: neither has errors; a bend of 0.2 m has, and who stands has.
    #[test]
    fn turning_round_and_backing_out_have_no_errors_of_tracking() {
        let mut turning = run(&[0.0, 3.0, 50.0, 60.0, -4.0, 1.0], EndState::Finished);
        for (frame, [speed_m_s, yaw_rate_rad_s]) in
            turning.frames[2..].iter_mut().zip([[0.01, 0.7], [-0.1, 0.0], [0.14, 0.7], [0.0; 2]])
        {
            (frame.truth.speed_m_s, frame.truth.yaw_rate_rad_s) = (speed_m_s, yaw_rate_rad_s);
        }
        turning.frames[2].truth.heading_rad = 2.0;
        turning.frames[3].truth.heading_rad = 3.1;
        let metrics = Metrics::of(&scenario("lateral_max_mm = 5.0"), &turning, None);
        let close = |value: Option<f64>, to: f64| value.is_some_and(|v| (v - to).abs() < 1e-12);
        assert!(
            close(metrics.lateral_rms_m, (26.0_f64 / 3.0).sqrt() * 1e-3) && close(metrics.lateral_max_m, 4e-3),
            "{metrics:?}"
        );
        assert!(close(metrics.heading_rms_rad, 0.02) && close(metrics.heading_max_rad, 0.02), "{metrics:?}");
        let scenario = scenario("lateral_max_mm = 3.5");
        let (_, reasons) = judge(&scenario, &turning, &metrics);
        assert_eq!(reasons.iter().map(|reason| reason.at_s).collect::<Vec<_>>(), [Some(4.0)]);
    }

    #[test]
    fn what_was_not_measured_fails_its_criterion() {
        let scenario = scenario("lateral_rms_mm = 5.0");
        let short = run(&[0.0], EndState::Finished);
        let metrics = Metrics::of(&scenario, &short, None);
        assert_eq!((metrics.lateral_rms_m, metrics.estimates_valid), (None, None));
        let (verdict, reasons) = judge(&scenario, &short, &metrics);
        assert_eq!(verdict, Verdict::Fail);
        assert_eq!((reasons.len(), &reasons[0].value), (1, &serde_json::Value::Null));
    }

    #[test]
    fn a_reason_says_when_the_bound_was_first_broken() {
        let scenario = scenario("lateral_max_mm = 5.0\ncollisions = 0");
        // 90 mm at the start is within the settling distance.
        let bad = run(&[90.0, 1.0, 6.0, 8.0], EndState::Finished);
        let (verdict, reasons) = judge(&scenario, &bad, &Metrics::of(&scenario, &bad, None));
        let told: Vec<_> = reasons.iter().map(|r| (r.metric.as_str(), r.at_s)).collect();
        assert_eq!(verdict, Verdict::Fail);
        assert_eq!(told, [("collisions", Some(3.0)), ("lateral_max_m", Some(2.0))]);
    }

    #[test]
    fn a_run_that_the_time_limit_ended_has_failed_unless_it_was_to_end_so() {
        let late = run(&[0.0, 0.0], EndState::TimeLimit);
        let verdict = |pass: &str| {
            let scenario = scenario(pass);
            judge(&scenario, &late, &Metrics::of(&scenario, &late, None)).0
        };
        assert_eq!(verdict(""), Verdict::Fail);
        assert_eq!(verdict("completed = true"), Verdict::Fail);
        assert_eq!(verdict("end_state = \"time-limit\""), Verdict::Pass);
        assert_eq!(verdict("end_state = \"finished\""), Verdict::Fail);
    }

    #[test]
    fn what_it_stopped_for_can_be_asked_for() {
        use ductloop_nav::navigator::{Reason, State};
        let verdict = |pass: &str, state: State, end: EndState| {
            let mut stopped = run(&[0.0, 0.0], end);
            if let Some(last) = stopped.frames.last_mut() {
                (last.state, last.reason) = (state, Some(Reason::Obstacle));
            }
            let scenario = scenario(pass);
            let metrics = Metrics::of(&scenario, &stopped, None);
            (metrics.stop_reason, judge(&scenario, &stopped, &metrics).0)
        };
        let asked = "end_state = \"stopped\"\nstop_reason = \"obstacle\"";
        assert_eq!(verdict(asked, State::Stopped, EndState::Stopped), (Some("obstacle"), Verdict::Pass));
        assert_eq!(verdict("stop_reason = \"drop\"", State::Stopped, EndState::Stopped), (Some("obstacle"), Verdict::Fail));
        // Stopped by the wheel controller, or ended otherwise: then the navigator's reason is none of a stop.
        assert_eq!(verdict(asked, State::Degraded, EndState::Stopped), (None, Verdict::Fail));
        assert_eq!(verdict("stop_reason = \"obstacle\"", State::Stopped, EndState::Finished), (None, Verdict::Fail));
    }
}
