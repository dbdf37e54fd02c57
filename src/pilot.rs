//! Who steers a run: the robot's own navigator as the scenario describes it, one with a part exchanged, or somebody else's.

use std::sync::{Arc, Mutex, PoisonError};

use ductloop_nav::control::ControlLaw;
use ductloop_nav::control::kanayama::Kanayama;
use ductloop_nav::control::koh_cho::KohCho;
use ductloop_nav::control::koh_cho_printed::KohChoPrinted;
use ductloop_nav::control::limits::Limits;
use ductloop_nav::control::lqr::Lqr;
use ductloop_nav::control::pure_pursuit::PurePursuit;
use ductloop_nav::control::samson::Samson;
use ductloop_nav::control::stanley::Stanley;
use ductloop_nav::course::route::Turn;
use ductloop_nav::course::{CourseParams, Mission};
use ductloop_nav::estimation::Estimator;
use ductloop_nav::exposure::{AutoExposure, ExposureParams};
use ductloop_nav::messages::Frame;
use ductloop_nav::navigator::{DuctNavigator, Navigator, NavigatorParams};
use ductloop_nav::odometry::DriveModel;
use ductloop_nav::perception::paper::{PaperParams, PaperPerception};
use ductloop_nav::perception::robust::{RobustParams, RobustPerception};
use ductloop_nav::perception::{Measurement, Perception};
use ductloop_nav::rig::MountAngles;

use crate::navigator_process::FailureSlot;
use crate::scenario::{EstimatorKind, Law, Pipeline, Route, Scenario};

/// A navigator, and where the loop leaves the truth for it if it steers by the truth.
pub struct Pilot {
    pub(crate) navigator: Box<dyn Navigator>,
    pub(crate) truth: Option<TruthFeed>,
    pub(crate) failure: Option<FailureSlot>,
}

/// Carries the true errors from the loop to [`TruthPerception`]. Nothing else connects a navigator to the simulator.
#[derive(Clone, Debug, Default)]
pub struct TruthFeed(Arc<Mutex<Measurement>>);

/// Perception that is told the true errors instead of reading images: tells what perception costs.
#[derive(Clone, Debug)]
pub struct TruthPerception(TruthFeed);

impl TruthFeed {
    pub(crate) fn set(&self, lateral_m: f64, heading_rad: f64, width_m: f64) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Measurement {
            lateral_m: Some(lateral_m),
            heading_rad: Some(heading_rad),
            width_m: Some(width_m),
            ..Measurement::default()
        };
    }
}

impl Perception for TruthPerception {
    fn perceive(&mut self, _frame: &Frame<'_>, _mount: MountAngles) -> Measurement {
        *self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Pilot {
    /// The robot's own navigator, as the scenario describes it.
    pub fn of(scenario: &Scenario) -> Self {
        Self::with_law(scenario, law(scenario))
    }

    /// The robot's own navigator with another control law.
    pub fn with_law(scenario: &Scenario, law: impl ControlLaw + 'static) -> Self {
        let (perception, truth) = match scenario.perception.pipeline {
            Pipeline::Truth => {
                let feed = TruthFeed::default();
                (Box::new(TruthPerception(feed.clone())) as Box<dyn Perception>, Some(feed))
            }
            Pipeline::Robust | Pipeline::Paper => (perception(scenario), None),
        };
        Self { navigator: Box::new(navigator(scenario, perception, law)), truth, failure: None }
    }

    /// The robot's own navigator with another perception.
    pub fn with_perception(scenario: &Scenario, perception: impl Perception + 'static) -> Self {
        Self { navigator: Box::new(navigator(scenario, perception, law(scenario))), truth: None, failure: None }
    }
}

impl Pilot {
    /// A navigator that may fail, and says so in a slot.
    pub(crate) fn of_process(navigator: Box<dyn Navigator>, failure: FailureSlot) -> Self {
        Self { navigator, truth: None, failure: Some(failure) }
    }
}

impl<N: Navigator + 'static> From<N> for Pilot {
    fn from(navigator: N) -> Self {
        Self { navigator: Box::new(navigator), truth: None, failure: None }
    }
}

/// The perception that reads a scenario's images: where it steers by the truth, the one it would read them by.
pub fn perception(scenario: &Scenario) -> Box<dyn Perception> {
    match scenario.perception.pipeline {
        Pipeline::Paper => Box::new(PaperPerception::new(scenario.rig.clone(), paper_params(scenario))),
        Pipeline::Robust | Pipeline::Truth => Box::new(RobustPerception::new(scenario.rig.clone(), robust_params(scenario))),
    }
}

fn navigator<P: Perception, L: ControlLaw>(scenario: &Scenario, perception: P, law: L) -> DuctNavigator<P, L> {
    let navigator = DuctNavigator::new(navigator_params(scenario), perception, law);
    let navigator = match (scenario.estimation.kind, scenario.perception.pipeline) {
        // The truth is exact: weighed, it would lose.
        (_, Pipeline::Truth) | (EstimatorKind::None, _) => navigator,
        (EstimatorKind::Kalman, _) => navigator.with_estimator(estimator(scenario)),
    };
    match scenario.exposure_s {
        Some(_) => navigator,
        None => navigator.with_auto_exposure(AutoExposure::new(exposure_params(scenario), &scenario.rig)),
    }
}

/// The scenario's control law, at rest.
pub fn law(scenario: &Scenario) -> Box<dyn ControlLaw> {
    let (speed_m_s, limits, control) = (scenario.speed_m_s, limits(scenario), &scenario.control);
    match control.law {
        Law::KohCho => Box::new(KohCho::new(speed_m_s, limits, control.koh_cho)),
        Law::KohChoPrinted => Box::new(KohChoPrinted::new(speed_m_s, limits, control.koh_cho.landing)),
        Law::PurePursuit => Box::new(PurePursuit::new(speed_m_s, limits, control.pure_pursuit)),
        Law::Stanley => Box::new(Stanley::new(speed_m_s, limits, control.stanley)),
        Law::Kanayama => Box::new(Kanayama::new(speed_m_s, limits, control.kanayama)),
        Law::Samson => Box::new(Samson::new(speed_m_s, limits, control.samson)),
        Law::Lqr => Box::new(Lqr::new(speed_m_s, limits, control.lqr)),
    }
}

/// Limits of the control laws, for one's own too: the effective track is the robot's.
pub fn limits(scenario: &Scenario) -> Limits {
    Limits { effective_track_m: effective_track_m(scenario), ..scenario.control.limits }
}

/// Parameters of the paper's pipeline: the duct's width is what the navigator is told.
pub fn paper_params(scenario: &Scenario) -> PaperParams {
    PaperParams { duct_width_m: scenario.navigation.width_m, ..scenario.perception.paper.clone() }
}

/// Parameters of the robust pipeline: the duct's width is what the navigator is told.
pub fn robust_params(scenario: &Scenario) -> RobustParams {
    RobustParams { duct_width_m: scenario.navigation.width_m, ..scenario.perception.robust.clone() }
}

/// Parameters of automatic exposure.
fn exposure_params(scenario: &Scenario) -> ExposureParams {
    let crate::scenario::AutoExposure { target_dn, exposure_s, laser_power } = scenario.auto_exposure;
    ExposureParams { target_dn, exposure_s, laser_power, first_exposure_s: scenario.first_exposure_s() }
}

/// The filter of the robot's own navigator, with nothing seen yet: told the duct's width and the robot's effective track.
pub fn estimator(scenario: &Scenario) -> Estimator {
    let count_m = scenario.robot.metres_per_count();
    let estimator = Estimator::new(scenario.estimation.params, scenario.navigation.width_m, effective_track_m(scenario), count_m);
    match scenario.navigation.fixed_width_m {
        Some(_) => estimator.with_known_width(),
        None => estimator,
    }
}

fn effective_track_m(scenario: &Scenario) -> f64 {
    scenario.robot.chi() * scenario.robot.track_m
}

fn navigator_params(scenario: &Scenario) -> NavigatorParams {
    let robot = &scenario.robot;
    NavigatorParams {
        ticks_per_s: f64::from(scenario.rates.physics_hz),
        ticks_per_frame: scenario.rates.ticks_per_frame(),
        drive: DriveModel {
            wheel_radius_m: robot.wheel_radius_m,
            effective_track_m: effective_track_m(scenario),
            counts_per_wheel_turn: robot.drive.counts_per_wheel_turn(),
            wheel_bandwidth_rad_s: scenario.control.wheel_bandwidth_rad_s,
        },
        coast_s: scenario.navigation.coast_s,
        // Images without noise may well be the same; a navigator that steers by the truth does not look at any.
        frozen_frames: Some(u64::from(scenario.navigation.frozen_frames))
            .filter(|frames| *frames > 0 && scenario.optics.noise && scenario.perception.pipeline != Pipeline::Truth),
        mount: scenario.rig.mount.rest,
        limits: limits(scenario),
        course: course_params(scenario),
        duct_width_m: scenario.navigation.width_m,
    }
}

fn course_params(scenario: &Scenario) -> CourseParams {
    let camera = scenario.rig.mount.position_in_base_m;
    CourseParams {
        mission: mission(&scenario.duct.route),
        speed_m_s: scenario.speed_m_s,
        camera_m: [camera.x, camera.y],
        turn_back_m: scenario.duct.route.turn_back_m,
        ..CourseParams::default()
    }
}

/// What a route tells the navigator: the turns, or that it is to find them itself.
fn mission(route: &Route) -> Mission {
    if route.explore {
        return Mission::Explore;
    }
    let turn = |turn: &ductloop_duct::network::Turn| match turn {
        ductloop_duct::network::Turn::Left => Turn::Left,
        ductloop_duct::network::Turn::Straight => Turn::Straight,
        ductloop_duct::network::Turn::Right => Turn::Right,
        ductloop_duct::network::Turn::TurnBack => Turn::TurnBack,
        ductloop_duct::network::Turn::Stop => Turn::Stop,
    };
    Mission::Route(route.turns.iter().map(turn).collect())
}
