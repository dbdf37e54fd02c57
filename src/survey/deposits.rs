//! The deposits that were found on the floor, each held against what the scenario laid there.

use ductloop_duct::Transform;
use ductloop_duct::network::Network;
use ductloop_nav::mapping::floor::THICKEST_M;
use ductloop_nav::mapping::{Closure, Deposit};
use ductloop_nav::planar::compose;
use nalgebra::Point2;
use serde::Serialize;

use super::cloud::world_from_believed;
use super::notes::Notes;
use crate::record::FrameRecord;
use crate::scenario::{Object, ObjectShape, Scenario};

/// A deposit is an object's if its middle lies above the object or within this beside it, in metres: the light's length on the floor, and
/// drift.
const BESIDE_M: f64 = 0.15;
/// An object whose bottom is no higher lies on the floor, in metres.
const ON_FLOOR_M: f64 = 1e-3;
/// Deposits are asked for from this thickness on, along and across for at least this, in metres: what the sensor resolves.
pub const RESOLVED_M: f64 = 0.005;
const RESOLVED_SIZE_M: [f64; 2] = [0.15, 0.08];
/// The floor is seen between these distances ahead of the base, in metres.
const SEEN_AHEAD_M: [f64; 2] = [1.2, 0.9];

/// A deposit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurveyedDeposit {
    /// From where it lies, from the duct's beginning (from where the duct was entered, where that was not seen).
    pub from_m: f64,
    /// To where.
    pub to_m: f64,
    /// Its right edge, to the left of the duct's middle.
    pub right_edge_m: f64,
    /// Its left edge.
    pub left_edge_m: f64,
    /// Floor that it covers, in square metres.
    pub area_m2: f64,
    /// Mean thickness.
    pub mean_m: f64,
    /// Standard deviation of that.
    pub mean_sigma_m: f64,
    /// Largest thickness.
    pub largest_m: f64,
    /// Thickness of what the scenario laid there; null where it laid nothing.
    pub true_m: Option<f64>,
    /// Mean less true thickness.
    pub error_m: Option<f64>,
}

/// What was found, and how that compares with what lies there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Found {
    /// Each with its duct's number.
    pub(super) deposits: Vec<(usize, SurveyedDeposit)>,
    /// Objects that the sensor resolves, that the robot came by, and that were not found; `None` where no floor was seen.
    pub(super) missed: Option<u32>,
    /// Deposits where nothing lies; `None` where no floor was seen.
    pub(super) none: Option<u32>,
    /// Largest error of the thickness of an object that the sensor resolves.
    pub(super) error_max_m: Option<f64>,
}

/// What the notes of a run say lies on the floors.
pub(super) fn found(scenario: &Scenario, network: &Network, notes: &Notes, closure: &Closure, frames: &[FrameRecord]) -> Found {
    if !(0..notes.ducts.len()).any(|duct| notes.floors.seen_m(duct).is_some()) {
        return Found::default();
    }
    let lying: Vec<&Object> = scenario.duct.objects.iter().filter(|object| object.above_m <= ON_FLOOR_M).collect();
    let world_from_first = network.centreline.pose_at(scenario.start.distance_m);
    let deposits = notes.floors.deposits();
    let of: Vec<Option<usize>> = deposits
        .iter()
        .map(|deposit| {
            let middle = middle(&world_from_first, *closure.first_from_duct.get(deposit.duct)?, deposit);
            lying.iter().position(|object| covers(object, network, &middle))
        })
        .collect();
    let surveyed = |(deposit, object): (&Deposit, &Option<usize>)| {
        let begin_m = notes.ducts.get(deposit.duct).and_then(|duct| duct.begin_m).unwrap_or(0.0);
        let true_m = object.map(|object| thickness_m(lying[object]));
        let surveyed = SurveyedDeposit {
            from_m: deposit.along_m[0] - begin_m,
            to_m: deposit.along_m[1] - begin_m,
            right_edge_m: deposit.left_m[0],
            left_edge_m: deposit.left_m[1],
            area_m2: deposit.area_m2,
            mean_m: deposit.mean_m,
            mean_sigma_m: deposit.sigma_m,
            largest_m: deposit.largest_m,
            true_m,
            error_m: true_m.map(|true_m| deposit.mean_m - true_m),
        };
        (deposit.duct, surveyed)
    };
    // The mean over all that was found of an object, by area; objects that the sensor does not resolve do not count.
    let (mut missed, mut error_max_m) = (0, None);
    for (number, object) in lying.iter().enumerate().filter(|(_, object)| is_resolved(object) && was_come_by(object, frames)) {
        let own = || deposits.iter().zip(&of).filter(|(_, of)| **of == Some(number)).map(|(deposit, _)| deposit);
        let area_m2: f64 = own().map(|deposit| deposit.area_m2).sum();
        if area_m2 > 0.0 {
            let mean_m = own().map(|deposit| deposit.mean_m * deposit.area_m2).sum::<f64>() / area_m2;
            let error_m = (mean_m - thickness_m(object)).abs();
            error_max_m = Some(error_max_m.map_or(error_m, |most: f64| most.max(error_m)));
        } else {
            missed += 1;
        }
    }
    let none = of.iter().filter(|object| object.is_none()).count() as u32;
    Found { deposits: deposits.iter().zip(&of).map(surveyed).collect(), missed: Some(missed), none: Some(none), error_max_m }
}

/// Where a deposit's middle is believed to be, in the world.
fn middle(world_from_first: &Transform, first_from_duct: [f64; 3], deposit: &Deposit) -> Point2<f64> {
    let at = |ends: [f64; 2]| (ends[0] + ends[1]) / 2.0;
    let pose = compose(first_from_duct, [at(deposit.along_m), at(deposit.left_m), 0.0]);
    world_from_believed(world_from_first, pose).translation.vector.xy().into()
}

/// Whether a place is above an object, or right beside it.
fn covers(object: &Object, network: &Network, place: &Point2<f64>) -> bool {
    let corners = object.solid(&network.centreline).corners;
    let within = |axis: usize| {
        let of = || corners.iter().map(|corner| corner[axis]);
        let (from, to) = (of().fold(f64::INFINITY, f64::min), of().fold(f64::NEG_INFINITY, f64::max));
        (from - BESIDE_M..=to + BESIDE_M).contains(&place[axis])
    };
    within(0) && within(1)
}

fn thickness_m(object: &Object) -> f64 {
    let ObjectShape::Box { size_m } = object.shape;
    size_m[2]
}

fn is_resolved(object: &Object) -> bool {
    let ObjectShape::Box { size_m } = object.shape;
    let is_wide = size_m[0] >= RESOLVED_SIZE_M[0] && size_m[1] >= RESOLVED_SIZE_M[1];
    is_wide && (RESOLVED_M..=THICKEST_M).contains(&size_m[2])
}

/// Whether the robot saw the floor from before the object to behind it, by its true way along the path.
fn was_come_by(object: &Object, frames: &[FrameRecord]) -> bool {
    let ObjectShape::Box { size_m } = object.shape;
    let along = || frames.iter().map(|frame| frame.truth.distance_m);
    let (from_m, to_m) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
    object.at_m - size_m[0] / 2.0 > from_m + SEEN_AHEAD_M[0] && object.at_m + size_m[0] / 2.0 < to_m + SEEN_AHEAD_M[1]
}
