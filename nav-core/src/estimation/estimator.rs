//! The filter: steps, looks, the gate, and looks that come late.

use std::collections::VecDeque;

use nalgebra::{Matrix3, SMatrix, SVector};

use super::belief::{Belief, Look};
use super::chi_square;
use super::motion::{HEADING, ICR, LATERAL, PER_TRACK, STATES, Step, Travel, WIDTH};
use super::params::EstimationParams;
use crate::messages::Tick;
use crate::perception::side_walls::SideWalls;

/// Where the filter believes the robot to stand, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Offset of the base from the duct's centreline, left positive, in metres.
    pub lateral_m: f64,
    /// Heading relative to the duct, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Width of the duct, in metres.
    pub width_m: f64,
    /// Effective track W_eff = chi W, in metres.
    pub effective_track_m: f64,
    /// How far the centre of rotation lies ahead of the base's origin, in metres.
    pub icr_m: f64,
    /// Covariance of the five, in this order.
    pub covariance: SMatrix<f64, STATES, STATES>,
    /// What became of the last look at the walls.
    pub outcome: Outcome,
    /// Looks refused by the gate so far.
    pub refused: u32,
    /// Times that the filter began anew because of a run of refusals.
    pub begun_anew: u32,
}

/// What became of a look at the walls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Outcome {
    /// There was none.
    #[default]
    None,
    /// It was taken in.
    Taken {
        /// Normalised innovation squared.
        nis: f64,
        /// Its degrees of freedom.
        freedom: usize,
    },
    /// It was further off than the gate allows.
    Refused {
        /// Normalised innovation squared.
        nis: f64,
        /// Its degrees of freedom.
        freedom: usize,
    },
    /// The filter began with it: the first, or after a run of refusals.
    Begun,
    /// It was exposed before anything that the filter remembers, or it is not a measurement at all: its covariance is none.
    Useless,
}

impl Estimate {
    /// Standard deviation of state `i`: lateral, heading, width, effective track, x_ICR.
    pub fn deviation(&self, i: usize) -> f64 {
        self.covariance[(i, i)].max(0.0).sqrt()
    }

    /// Normalised estimation error squared over lateral offset, heading and width, three degrees of freedom, against the truth.
    pub fn nees(&self, lateral_m: f64, heading_rad: f64, width_m: f64) -> Option<f64> {
        let off = nalgebra::Vector3::new(
            self.lateral_m - lateral_m,
            crate::angle::wrap(self.heading_rad - heading_rad),
            self.width_m - width_m,
        );
        Some(off.dot(&(self.pose_covariance().try_inverse()? * off)))
    }

    /// Minus the natural logarithm of the density that it gives the truth, of lateral offset, heading and width, in metres and radians: (NEES +
    /// ln det(2 pi P)) / 2. A proper score: in the mean it is least where errors are just as they are said to be.
    pub fn log_loss(&self, lateral_m: f64, heading_rad: f64, width_m: f64) -> Option<f64> {
        let spread = libm::log((2.0 * std::f64::consts::PI * self.pose_covariance()).determinant());
        Some(0.5 * (self.nees(lateral_m, heading_rad, width_m)? + spread)).filter(|loss| loss.is_finite())
    }

    /// Covariance of lateral offset, heading and width.
    fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }
}

/// While it is to be steady, a run of refusals must be so many times as long before the filter begins anew.
const STEADY: usize = 3;
/// Frames that a look may come late.
const REMEMBERED: usize = 8;

/// A reading of the encoders: the step that led to it, what was believed after it, and the look that was taken in there.
#[derive(Clone, Copy, Debug)]
struct Moment {
    tick: Tick,
    travel: Travel,
    belief: Belief,
    look: Option<SideWalls>,
}

/// An extended Kalman filter over lateral offset, heading, duct width, effective track and x_ICR.
#[derive(Clone, Debug)]
pub struct Estimator {
    params: EstimationParams,
    width_m: f64,
    track_m: f64,
    count_m: f64,
    /// Chi-square bounds of the gate, by degrees of freedom.
    gate: [f64; 4],
    belief: Belief,
    past: VecDeque<Moment>,
    /// Whether anything was ever seen.
    placed: bool,
    run: usize,
    outcome: Outcome,
    refused: u32,
    begun_anew: u32,
    width_is_known: bool,
}

/// Standard deviation of a width that is known, in metres: small beside any wall's error, and not so small that its square is lost.
const KNOWN_WIDTH_M: f64 = 1e-6;

impl Estimator {
    /// A filter that has seen nothing. Told: the duct's width, the effective track, and the way of one encoder count, in metres.
    pub fn new(params: EstimationParams, width_m: f64, track_m: f64, count_m: f64) -> Self {
        let gate = [0, 1, 2, 3].map(|freedom| chi_square::quantile(freedom, params.gate_probability));
        Self {
            params,
            width_m,
            track_m,
            count_m,
            gate,
            belief: Belief::unseen(&params, width_m, track_m),
            past: VecDeque::with_capacity(REMEMBERED),
            placed: false,
            run: 0,
            outcome: Outcome::None,
            refused: 0,
            begun_anew: 0,
            width_is_known: false,
        }
    }

    /// The duct's width is what it was told, in every duct: it is not estimated.
    pub fn with_known_width(self) -> Self {
        let params = EstimationParams { width_m: KNOWN_WIDTH_M, width_walk_m: 0.0, ..self.params };
        Self { params, width_is_known: true, belief: Belief::unseen(&params, self.width_m, self.track_m), ..self }
    }

    /// Its parameters.
    pub fn params(&self) -> &EstimationParams {
        &self.params
    }

    /// The duct's width as it was told, in metres.
    pub fn told_width_m(&self) -> f64 {
        self.width_m
    }

    /// Carries the belief on to `tick`, when the encoders were read, by what the wheels turned since the reading before; returns the way
    /// along the duct, in metres.
    pub fn advance(&mut self, travel: Travel, tick: Tick) -> f64 {
        let along_m = Step::of(&self.belief.state(), travel).along_m;
        self.belief.advance(travel, &self.params, self.count_m, self.track_m);
        self.outcome = Outcome::None;
        self.remember(tick, travel);
        along_m
    }

    fn remember(&mut self, tick: Tick, travel: Travel) {
        if self.past.len() == REMEMBERED {
            self.past.pop_front();
        }
        self.past.push_back(Moment { tick, travel, belief: self.belief, look: None });
    }

    /// Takes in what a frame that was exposed at `exposed` shows. If the belief has gone on since, it goes back to the reading of that
    /// tick, or the last one before it, and comes forward again by the same steps and looks. While it is `steady`, only a long run of
    /// refusals is a reason to begin anew.
    pub fn look(&mut self, walls: &SideWalls, exposed: Tick, steady: bool) -> Outcome {
        if self.past.is_empty() {
            self.remember(exposed, Travel::default());
        }
        self.outcome = match self.past.iter().rposition(|moment| moment.tick <= exposed) {
            Some(at) => self.look_at(walls, at, steady),
            None => Outcome::Useless,
        };
        if !self.belief.is_sound(self.track_m) {
            // Numbers that no robot has: nothing of them is kept.
            self.belief = Belief::unseen(&self.params, self.width_m, self.track_m);
            self.past.clear();
            self.placed = false;
            self.outcome = Outcome::Useless;
        }
        self.outcome
    }

    fn look_at(&mut self, walls: &SideWalls, at: usize, steady: bool) -> Outcome {
        let mut belief = self.past[at].belief;
        if let Some(look) = self.past[at].look.and_then(|walls| belief.look(&walls, &self.params)) {
            belief.take(&look);
        }
        let Some(mut look) = belief.look(walls, &self.params) else { return Outcome::Useless };
        let (nis, freedom) = (look.nis(), look.freedom);
        let mut outcome = Outcome::Taken { nis, freedom };
        if self.placed && nis > self.gate[freedom] {
            self.refused += 1;
            self.run += 1;
            let most = if steady { STEADY * self.params.gate_run } else { self.params.gate_run };
            if self.run <= most {
                return Outcome::Refused { nis, freedom };
            }
            self.begun_anew += 1;
            belief.lose_place(self.width_m);
            // A duct that became another is why, as well as a robot that was moved.
            belief.widen_width(self.params.width_m);
            match belief.look(walls, &self.params) {
                Some(again) => look = again,
                None => return Outcome::Useless,
            }
            outcome = Outcome::Begun;
        } else if !self.placed {
            outcome = Outcome::Begun;
        }
        self.run = 0;
        self.placed = true;
        self.take(belief, &look, walls, at);
        outcome
    }

    /// Takes a look in at the moment `at`, and comes forward from there.
    fn take(&mut self, before: Belief, look: &Look, walls: &SideWalls, at: usize) {
        let mut belief = before;
        belief.take(look);
        // A moment's belief is that before its look; a second look at one moment, or a new beginning, goes on from what is there.
        let second = self.past[at].look.is_some();
        self.past[at].belief = if second { belief } else { before };
        self.past[at].look = if second { None } else { Some(*walls) };
        for later in self.past.iter_mut().skip(at + 1) {
            belief.advance(later.travel, &self.params, self.count_m, self.track_m);
            later.belief = belief;
            if let Some(look) = later.look.and_then(|walls| belief.look(&walls, &self.params)) {
                belief.take(&look);
            }
        }
        self.belief = belief;
    }

    /// It is in another duct, or another way round, from now on: there it stands at this lateral offset (metres) and heading (radians), in
    /// a width (metres), each with its standard deviation. What it knows of its wheels it keeps.
    pub fn enter(&mut self, lateral_m: [f64; 2], heading_rad: [f64; 2], width_m: [f64; 2]) {
        let width_m = if self.width_is_known { [self.width_m, KNOWN_WIDTH_M] } else { width_m };
        self.belief.enter(lateral_m, heading_rad, width_m);
        self.past.clear();
        self.run = 0;
    }

    /// What it believes now: at the last reading of the encoders.
    pub fn estimate(&self) -> Estimate {
        let mean: SVector<f64, STATES> = self.belief.state();
        let track_m = 1.0 / mean[PER_TRACK];
        // W = 1 / k, so dW = -W^2 dk.
        let mut by_mean = SMatrix::<f64, STATES, STATES>::identity();
        by_mean[(PER_TRACK, PER_TRACK)] = -track_m * track_m;
        let covariance: SMatrix<f64, STATES, STATES> = self.belief.covariance.fixed_view::<STATES, STATES>(0, 0).into_owned();
        Estimate {
            lateral_m: mean[LATERAL],
            heading_rad: mean[HEADING],
            width_m: mean[WIDTH],
            effective_track_m: track_m,
            icr_m: mean[ICR],
            covariance: by_mean * covariance * by_mean.transpose(),
            outcome: self.outcome,
            refused: self.refused,
            begun_anew: self.begun_anew,
        }
    }

    /// Lateral offset, heading and way along the duct after the wheels will have turned so far: what nobody has seen yet.
    pub fn foresee(&self, travel: Travel) -> (f64, f64, f64) {
        let step = Step::of(&self.belief.state(), travel);
        (step.state[LATERAL], step.state[HEADING], step.along_m)
    }
}
