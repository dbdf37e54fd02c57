//! Which fitting explains best what rays found: maximum likelihood over the families' dimensions.
//!
//! The likelihood of a ray is that of a beam whose range is normally distributed about what the plan says, or anything at all (S. Thrun,
//! W. Burgard, D. Fox, Probabilistic Robotics, MIT Press 2005, section 6.3); its negative logarithm is a square that is capped. Dimensions
//! are sought by compass search (T. G. Kolda, R. M. Lewis, V. Torczon, SIAM Review 45, 2003): there are corners, behind which ranges jump.

use super::model::{Bounds, Family, MOST, Model};
use super::outlook::{Fitting, Side};
use super::plan::Plan;

/// A ray in the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) from: [f64; 2],
    /// Unit vector.
    pub(super) way: [f64; 2],
    pub(super) range_m: f64,
    /// Whether something is there, or it is only free up to there.
    pub(super) hit: bool,
}

/// Standard deviation of a range: this, and so much more by its square, in metres and 1/m.
const RANGE_M: f64 = 0.012;
const RANGE_SHARE_1_M: f64 = 0.012;
/// Standard deviation of a wall's place across it, in metres: dents, and the robot's own place.
const WALL_M: f64 = 0.008;
/// Rays that graze a wall more than this say no less of it: sine.
const LEAST_SIN: f64 = 0.05;
/// Beyond so many deviations a range is anything at all.
const CAP: f64 = 3.0;
/// First step in a fitting's place along the duct, in metres.
const PLACE_M: f64 = 0.06;
/// Plans are drawn up roughly by every so many-th ray ...
const ROUGH: Search = Search { stride: 3, first_halving: 0, halvings: 2, most_plans: 40, within: 0.12 };
/// ... and the best of them by all.
const FINE: Search = Search { stride: 1, first_halving: 1, halvings: 4, most_plans: 60, within: 0.05 };
/// From within an arc all is known but its last part.
const WITHIN: Search = Search { stride: 1, first_halving: 2, halvings: 4, most_plans: 40, within: 0.0 };
/// What a dimension costs: it must explain so much more.
const DIMENSION: f64 = 0.004;

/// Angles of an arc that are tried from within it, in degrees, and by how much one must explain more than the one that was known.
const TURNS_DEG: [i32; 2] = [20, 180];
const TURN_STEP_DEG: usize = 2;
const TURN_BETTER: f64 = 0.002;
/// What is held already needs so much less to go on being held: fittings do not change.
const HELD: f64 = 0.02;

const FAMILIES: [Family; 12] = [
    Family::Straight,
    Family::DeadEnd,
    Family::Obstacle,
    Family::Mitre,
    Family::Radius,
    Family::Branch,
    Family::FarShoe,
    Family::Cross,
    Family::Bullhead,
    Family::Wye,
    Family::Transition,
    Family::Offset,
];

/// A stage of the search.
#[derive(Clone, Copy, Debug)]
struct Search {
    /// Every so many-th ray is looked at.
    stride: usize,
    /// The first steps are halved so often before it, and then so often again, at most.
    first_halving: i32,
    halvings: usize,
    /// Plans after which a search ends.
    most_plans: usize,
    /// Models so much worse than the best are not sought.
    within: f64,
}

/// What explains the rays best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Match {
    pub(super) model: Model,
    /// Mean over the rays of their capped squares: 0 all explained, 1 none.
    pub(super) cost: f64,
    /// The same of the best fitting that has another name.
    pub(super) other: f64,
    /// Rays that it rests on.
    pub(super) sights: usize,
}

/// Looks for it.
#[derive(Clone, Debug)]
pub(super) struct Matcher {
    plan: Plan,
    /// What each family was found to be last.
    last: Vec<Model>,
    found: Vec<(Model, f64)>,
}

impl Matcher {
    pub(super) fn new() -> Self {
        Self { plan: Plan::new(), last: Vec::with_capacity(32), found: Vec::with_capacity(64) }
    }

    /// Forgets what was found.
    pub(super) fn clear(&mut self) {
        self.last.clear();
    }

    fn cost(&mut self, model: &Model, sights: &[Sight], stride: usize, width_m: f64) -> f64 {
        if model.is_nothing() {
            return 1.0;
        }
        model.draw(width_m, &mut self.plan);
        let mut sum = 0.0;
        for sight in sights.iter().step_by(stride) {
            let Some(meeting) = self.plan.meets(sight.from, sight.way) else {
                sum += if sight.hit { 1.0 } else { 0.0 };
                continue;
            };
            let over_m = meeting.range_m - sight.range_m;
            if !sight.hit && over_m >= 0.0 {
                continue;
            }
            let range_m = RANGE_M + RANGE_SHARE_1_M * sight.range_m * sight.range_m;
            let wall_m = WALL_M / meeting.sin_incidence.max(LEAST_SIN);
            let off = over_m * over_m / (CAP * CAP * (range_m * range_m + wall_m * wall_m));
            sum += off.min(1.0);
        }
        sum / sights.len().div_ceil(stride) as f64 + model.oddity() + DIMENSION * (1 + model.family.bounds(width_m).1) as f64
    }

    /// Finds it, among fittings that begin about at one of these places along the duct.
    /// What was held to be there before is favoured.
    pub(super) fn find(&mut self, sights: &[Sight], width_m: f64, places_m: &[f64], held: Fitting) -> Option<Match> {
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        for family in FAMILIES {
            for side in [Side::Left, Side::Right] {
                if side == Side::Right && !family.has_side() {
                    continue;
                }
                let (bounds, count) = family.bounds(width_m);
                let begun = family.beginnings().iter().flat_map(|begin| {
                    places_m.iter().map(move |at_m| {
                        let mut dimensions = [*at_m, 0.0, 0.0, 0.0];
                        for index in 0..count {
                            let value = begin[index] * if family.is_angle(index) { 1.0 } else { width_m };
                            dimensions[1 + index] = value.clamp(bounds[index].least, bounds[index].most);
                        }
                        Model { family, side, dimensions }
                    })
                });
                let last = self.last.iter().copied().find(|model| model.family == family && model.side == side);
                // What was found last, and what may be found anew: the last one may be stuck where the search cannot leave it.
                found.extend(last.map(|model| (model, self.cost(&model, sights, ROUGH.stride, width_m))));
                let begun = begun.map(|model| (model, self.cost(&model, sights, ROUGH.stride, width_m)));
                found.extend(begun.min_by(|a, b| a.1.total_cmp(&b.1)));
            }
        }
        for search in [ROUGH, FINE] {
            let least = found.iter().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
            for (model, cost) in found.iter_mut().filter(|(_, cost)| *cost <= least + search.within) {
                (*model, *cost) = self.refine(*model, sights, &search, width_m);
            }
        }
        self.last.clear();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (model, _) in &found {
            if !self.last.iter().any(|last| last.family == model.family && last.side == model.side) {
                self.last.push(*model);
            }
        }
        for (_, cost) in found.iter_mut().filter(|(model, _)| model.fitting() == held) {
            *cost -= HELD;
        }
        let best = found.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let answer = best.map(|(model, cost)| {
            let others = found.iter().filter(|(other, _)| other.fitting() != model.fitting());
            Match { model, cost, other: others.map(|(_, cost)| *cost).fold(1.0, f64::min), sights: sights.len() }
        });
        self.found = found;
        answer
    }

    /// How far an arc goes round, and what else it is then: the angle that explains the rays better than the one that it has by now.
    pub(super) fn arc(&mut self, arc: &Model, sights: &[Sight], width_m: f64) -> Model {
        // That ducts mostly turn no farther than a right angle does not count any more.
        let known = self.cost(arc, sights, 1, width_m) - arc.oddity();
        let (mut best, mut least) = (*arc, known - TURN_BETTER);
        for angle in (TURNS_DEG[0]..=TURNS_DEG[1]).step_by(TURN_STEP_DEG).map(|degrees| f64::from(degrees).to_radians()) {
            let turned = Model { dimensions: [arc.dimensions[0], angle, arc.dimensions[2], arc.dimensions[3]], ..*arc };
            let cost = self.cost(&turned, sights, 1, width_m) - turned.oddity();
            if cost < least {
                (best, least) = (turned, cost);
            }
        }
        self.refine(best, sights, &WITHIN, width_m).0
    }

    /// Compass search from a model on.
    fn refine(&mut self, mut model: Model, sights: &[Sight], search: &Search, width_m: f64) -> (Model, f64) {
        let (bounds, count) = model.family.bounds(width_m);
        let first = libm::exp2(f64::from(-search.first_halving));
        let mut steps = [PLACE_M, bounds[0].step, bounds[1].step, bounds[2].step].map(|step| step * first);
        let mut cost = self.cost(&model, sights, search.stride, width_m);
        let (mut halvings, mut plans) = (0, 0);
        while halvings < search.halvings && plans < search.most_plans {
            let mut is_better = false;
            for index in 0..=count.min(MOST - 1) {
                for sign in [1.0, -1.0] {
                    let mut next = model;
                    next.dimensions[index] += sign * steps[index];
                    if index > 0 {
                        let Bounds { least, most, .. } = bounds[index - 1];
                        next.dimensions[index] = next.dimensions[index].clamp(least, most);
                    }
                    plans += 1;
                    let then = self.cost(&next, sights, search.stride, width_m);
                    if then < cost {
                        (model, cost, is_better) = (next, then, true);
                        break;
                    }
                }
            }
            if !is_better {
                steps = steps.map(|step| step / 2.0);
                halvings += 1;
            }
        }
        (model, cost)
    }
}
