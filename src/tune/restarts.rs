//! CMA-ES in a box, begun again with twice the points whenever it has come to rest.
//!
//! A. Auger and N. Hansen, *A Restart CMA Evolution Strategy With Increasing Population Size*, CEC 2005: each new run begins anywhere in the
//! box. What falls beside the box is drawn again, and after a hundred times reflected at its sides; nothing outside is ever run. (Reflected at
//! once, a minimum near a side has a mirror image, between the two of which the search does not decide: Rastrigin's function in
//! [-5, 5]^10 took more than five times as long.)

use super::cma_es::{CmaEs, default_lambda};
use crate::stream::uniform;

/// Stream of random numbers of beginnings; a coordinate's number is added.
const BEGINNING: u64 = 0xc3b0_0000;
/// First step size, as a share of the box: a third of it is what the tutorial (section C) advises.
pub const SIGMA: f64 = 0.3;
/// How often a point is drawn that falls beside the box.
const ATTEMPTS: u64 = 100;
/// A covariance whose axes differ by more than this, squared, has lost its smallest one in rounding.
const MOST_CONDITION: f64 = 1e14;
/// Step sizes that grow beyond this many boxes find nothing.
const MOST_SIGMA: f64 = 1e3;

/// When a run has come to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Steps, as a share of the box in every coordinate, below which there is nothing left to find.
    pub step: f64,
    /// Difference of costs below which they are the same: of the best of the last generations (10 + 30 n / lambda of them), and of one's own.
    pub cost: f64,
}

/// The search, in the unit box.
#[derive(Clone, Debug)]
pub struct Restarts {
    seed: u64,
    sigma: f64,
    rest: Rest,
    run: CmaEs,
    /// How often it has begun again.
    restarts: u64,
    /// Best cost of each generation of this run.
    bests: Vec<f64>,
    last: Vec<f64>,
}

impl Restarts {
    /// From this point of the unit box on, with this step size and the default number of points.
    pub fn new(start: Vec<f64>, sigma: f64, rest: Rest, seed: u64) -> Self {
        let lambda = default_lambda(start.len());
        let run = CmaEs::new(start, sigma, lambda, seed);
        Self { seed, sigma, rest, run, restarts: 0, bests: Vec::new(), last: Vec::new() }
    }

    /// How often it has begun again.
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Its step size along each coordinate, as a share of the box.
    pub fn deviations(&self) -> Vec<f64> {
        self.run.deviations()
    }

    /// The points of the next generation, each in the box.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.is_at_rest() {
            self.restarts += 1;
            let n = self.run.mean().len() as u64;
            let start = (0..n).map(|coordinate| uniform(self.seed, self.restarts, BEGINNING + coordinate)).collect();
            // Another seed for each run, so that its numbers are its own.
            let seed = self.seed.wrapping_add(self.restarts.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            self.run = CmaEs::new(start, self.sigma, 2 * self.run.lambda(), seed);
            (self.bests, self.last) = (Vec::new(), Vec::new());
        }
        let within = |point: &[f64]| point.iter().all(|x| (0.0..=1.0).contains(x));
        self.run.ask(within, ATTEMPTS).into_iter().map(|point| point.into_iter().map(reflected).collect()).collect()
    }

    /// What they cost, in their order.
    pub fn tell(&mut self, costs: &[f64]) {
        self.run.tell(costs);
        self.bests.push(costs.iter().copied().fold(f64::INFINITY, f64::min));
        self.last = costs.to_vec();
    }

    /// Whether this run finds nothing any more.
    pub fn is_at_rest(&self) -> bool {
        if self.bests.is_empty() {
            return false;
        }
        let deviations = self.run.deviations();
        let n = deviations.len();
        let recent = 10 + (30 * n).div_ceil(self.run.lambda());
        let spread = |costs: &[f64]| {
            let most = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            most - costs.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let is_flat = self.bests.len() >= recent
            && spread(&self.bests[self.bests.len() - recent..]) < self.rest.cost
            && spread(&self.last) < self.rest.cost;
        is_flat
            || deviations.iter().all(|deviation| *deviation < self.rest.step)
            || deviations.iter().any(|deviation| *deviation > MOST_SIGMA)
            || self.run.condition() > MOST_CONDITION
            || self.run.has_no_effect()
    }
}

/// A coordinate reflected into 0 to 1.
pub(super) fn reflected(x: f64) -> f64 {
    let within = (x - 2.0 * (x / 2.0).floor()).clamp(0.0, 2.0);
    if within <= 1.0 { within } else { 2.0 - within }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: Rest = Rest { step: 1e-9, cost: 1e-12 };

    #[test]
    fn what_leaves_the_box_is_reflected() {
        for (x, within) in [(0.3, 0.3), (-0.2, 0.2), (1.25, 0.75), (2.1, 0.1), (-1.4, 0.6), (1.0, 1.0), (0.0, 0.0)] {
            assert!((reflected(x) - within).abs() < 1e-12, "{x}");
        }
    }

    /// Rastrigin's function has a minimum in every unit cell; single runs end in one of them, restarts find the least. In five dimensions
    /// over 5.12 to both sides.
    #[test]
    fn restarts_find_rastrigins_least_minimum() {
        let cost = |point: &[f64]| -> f64 {
            let x = point.iter().map(|u| 10.24 * u - 5.12 + 0.3);
            x.map(|x| x * x - 10.0 * libm::cos(2.0 * std::f64::consts::PI * x) + 10.0).sum()
        };
        let mut found = 0;
        for seed in 0..10 {
            let mut search = Restarts::new(vec![0.9; 5], SIGMA, REST, seed);
            let mut evaluations = 0;
            while evaluations < 60_000 {
                let points = search.ask();
                evaluations += points.len();
                let costs: Vec<f64> = points.iter().map(|point| cost(point)).collect();
                search.tell(&costs);
                if costs.iter().any(|cost| *cost < 1e-8) {
                    found += 1;
                    break;
                }
            }
        }
        assert!(found >= 9, "{found} of 10");
    }

    /// The least of a slope lies in a corner of the box.
    #[test]
    fn a_corner_is_found() {
        let mut search = Restarts::new(vec![0.5; 4], SIGMA, REST, 1);
        let mut best = f64::INFINITY;
        for _ in 0..120 {
            let costs: Vec<f64> = search.ask().iter().map(|point| point.iter().sum()).collect();
            best = costs.iter().copied().fold(best, f64::min);
            search.tell(&costs);
        }
        assert!(best < 1e-3, "{best}");
    }
}
