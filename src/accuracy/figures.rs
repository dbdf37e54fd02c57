//! Figures of many readings: bias, RMS, worst, detection, consistency.

use ductloop_nav::perception::Wall;

use super::trial::{Reading, SIDES, Trial};
use crate::scenario::Pipeline;
use crate::stage_scores::{CentreScore, LineScore, WallScore};

/// An error that is this many stated deviations large is confident and wrong.
pub const CONFIDENT_AND_WRONG: f64 = 6.0;
/// An error of up to this many is right.
pub const RIGHT: f64 = 3.0;

/// Errors of one quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// How many there are to be measured.
    pub there: usize,
    /// How many were.
    pub count: usize,
    /// Of how many of these a deviation was stated.
    pub stated: usize,
    sum: f64,
    square: f64,
    worst: f64,
    worst_at: Option<(usize, u64)>,
    normalised_square: f64,
    /// How many of the measured have a bound, the sums of the squares of their errors and of their bounds.
    bounded: usize,
    bounded_square: f64,
    bound_square: f64,
}

/// The figures of a pipeline over some readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// Readings.
    pub poses: usize,
    /// Of these, readings of frames that show where the robot stands: a side wall with enough columns of stripe.
    pub shown: usize,
    /// Of those, readings with an answer: lateral offset and heading.
    pub detected: usize,
    /// Of those, readings whose lateral offset and heading are both right within three stated deviations.
    pub within_3_sigma: usize,
    /// Readings, of all, with an error beyond six stated deviations: (cell, pose).
    pub beyond_6_sigma: Vec<(usize, u64)>,
    /// Whether any deviation was stated.
    pub states_deviations: bool,
    /// Distance of side walls from the base's origin, in metres; only walls that count.
    pub wall_distance: Spread,
    /// Heading relative to them, in radians.
    pub wall_heading: Spread,
    /// Angle between their normals and the true ones, in radians.
    pub wall_normal: Spread,
    /// Heading, in radians.
    pub heading: Spread,
    /// Lateral offset, in metres.
    pub lateral: Spread,
    /// Stripe centres.
    pub centres: CentreScore,
    /// Lines.
    pub lines: LineScore,
}

impl Spread {
    /// Takes in one that is to be measured, its error if it was, the stated deviation, and the least that there could be.
    ///
    /// `at` is its (cell, pose).
    pub fn add(&mut self, at: (usize, u64), error: Option<f64>, sigma: Option<f64>, bound: Option<f64>) {
        self.there += 1;
        let Some(error) = error else { return };
        self.count += 1;
        self.sum += error;
        self.square += error * error;
        if self.worst_at.is_none() || error.abs() > self.worst.abs() {
            (self.worst, self.worst_at) = (error, Some(at));
        }
        if let Some(sigma) = sigma {
            self.stated += 1;
            self.normalised_square += (error / sigma) * (error / sigma);
        }
        if let Some(bound) = bound {
            self.bounded += 1;
            self.bounded_square += error * error;
            self.bound_square += bound * bound;
        }
    }

    fn mean_of(&self, sum: f64) -> Option<f64> {
        (self.count > 0).then(|| sum / self.count as f64)
    }

    /// Mean error.
    pub fn bias(&self) -> Option<f64> {
        self.mean_of(self.sum)
    }

    /// Root of the mean square error.
    pub fn rms(&self) -> Option<f64> {
        self.mean_of(self.square).map(f64::sqrt)
    }

    /// The error that is largest either way.
    pub fn worst(&self) -> Option<f64> {
        self.mean_of(self.worst).map(|_| self.worst)
    }

    /// Where it is: (cell, pose).
    pub fn worst_at(&self) -> Option<(usize, u64)> {
        self.worst_at
    }

    /// Mean square of error over stated deviation: 1 where the deviations are true.
    pub fn nees(&self) -> Option<f64> {
        (self.stated > 0).then(|| self.normalised_square / self.stated as f64)
    }

    /// Root of the mean square of the bounds, over what was measured.
    pub fn bound(&self) -> Option<f64> {
        (self.bounded > 0).then(|| (self.bound_square / self.bounded as f64).sqrt())
    }

    /// RMS error over that of the bound, over the same.
    pub fn bound_ratio(&self) -> Option<f64> {
        (self.bound_square > 0.0).then(|| (self.bounded_square / self.bound_square).sqrt())
    }

    /// Share of what was to be measured that was.
    pub fn detection(&self) -> Option<f64> {
        (self.there > 0).then(|| self.count as f64 / self.there as f64)
    }
}

impl Figures {
    /// Of a pipeline, over the trials.
    pub fn of<'a>(trials: impl Iterator<Item = &'a Trial>, pipeline: Pipeline) -> Self {
        let mut figures = Self::default();
        for trial in trials {
            for reading in trial.readings.iter().filter(|reading| reading.pipeline == pipeline) {
                figures.add(trial, reading);
            }
        }
        figures
    }

    fn add(&mut self, trial: &Trial, reading: &Reading) {
        let score = &reading.score;
        let at = (trial.cell, trial.index);
        self.poses += 1;
        let walls: Vec<&WallScore> = SIDES.into_iter().filter_map(|wall: Wall| score.wall(wall)).collect();
        let mut normalised = score.normalised().chain(walls.iter().flat_map(|wall| wall.normalised()));
        // A deviation that is no number is as wrong as a small one.
        if normalised.any(|ratio| ratio.is_nan() || ratio.abs() > CONFIDENT_AND_WRONG) {
            self.beyond_6_sigma.push(at);
        }
        self.states_deviations |= score.normalised().next().is_some();
        self.add_centres(&score.centres);
        self.lines.lines += score.lines.lines;
        self.lines.square_px2 += score.lines.square_px2;
        for wall in walls.into_iter().filter(|wall| reading.counts(wall.wall)) {
            let side = SIDES.iter().position(|side| *side == wall.wall);
            let bound = side.and_then(|side| trial.bounds.walls[side]);
            self.wall_distance.add(at, wall.distance_error_m, wall.distance_sigma_m, bound.map(|bound| bound.distance_m));
            self.wall_heading.add(at, wall.heading_error_rad, wall.heading_sigma_rad, bound.map(|bound| bound.heading_rad));
            self.wall_normal.add(at, wall.normal_error_rad, None, None);
        }
        if reading.shows_pose() {
            self.shown += 1;
            self.heading.add(at, score.heading_error_rad, score.heading_sigma_rad, trial.bounds.heading_rad);
            self.lateral.add(at, score.lateral_error_m, score.lateral_sigma_m, trial.bounds.lateral_m);
            if reading.is_answered() {
                self.detected += 1;
                let mut ratios = score.normalised().peekable();
                let stated = ratios.peek().is_some();
                self.within_3_sigma += usize::from(stated && ratios.all(|ratio| ratio.abs() <= RIGHT));
            }
        }
    }

    fn add_centres(&mut self, one: &CentreScore) {
        let all = &mut self.centres;
        all.claimed += one.claimed;
        all.right += one.right;
        all.there += one.there;
        all.found += one.found;
        all.square_px2 += one.square_px2;
        all.nees += one.nees;
    }

    /// Share of the frames that show where the robot stands with an answer.
    pub fn detection(&self) -> Option<f64> {
        (self.shown > 0).then(|| self.detected as f64 / self.shown as f64)
    }

    /// Share of the frames that show where the robot stands with an answer right within three stated deviations; `None` from a
    /// pipeline that states none.
    pub fn within_3_sigma(&self) -> Option<f64> {
        (self.shown > 0 && self.states_deviations).then(|| self.within_3_sigma as f64 / self.shown as f64)
    }

    /// Readings with an error beyond six stated deviations; `None` from a pipeline that states none.
    pub fn beyond_6_sigma(&self) -> Option<usize> {
        self.states_deviations.then_some(self.beyond_6_sigma.len())
    }

    /// Mean square of error over stated deviation, of lateral offset, heading and the walls' distances together.
    pub fn nees(&self) -> Option<f64> {
        let parts = [&self.lateral, &self.heading, &self.wall_distance];
        let stated: usize = parts.iter().map(|spread| spread.stated).sum();
        (stated > 0).then(|| parts.iter().map(|spread| spread.normalised_square).sum::<f64>() / stated as f64)
    }
}
