//! Who proposes candidates: asked for points of the unit box, told what they cost.

use super::restarts::{Rest, Restarts};
use crate::scenario::study_file::{Optimiser, StudyFile};
use crate::stream::uniform;

/// Stream of random numbers of independent draws; a coordinate's number is added.
const DRAW: u64 = 0xc3c0_0000;
/// Points that a baseline proposes at a time.
const BATCH: u64 = 16;
/// Rest of a search that names none: a thousandth of each range.
const STEP: f64 = 1e-3;
/// Costs that differ by less are the same.
const COST: f64 = 1e-12;

/// A proposer.
#[derive(Clone, Debug)]
pub enum Proposer {
    /// Learns from what it is told.
    CmaEs(Box<Restarts>),
    /// A scrambled Sobol sequence (Burley 2020), from this point on.
    Sobol {
        /// Coordinates.
        coordinates: usize,
        /// Seed of the scrambling.
        seed: u64,
        /// Number of the next point.
        next: u64,
    },
    /// Independent draws, from this one on.
    Random {
        /// Coordinates.
        coordinates: usize,
        /// Seed.
        seed: u64,
        /// Number of the next point.
        next: u64,
    },
}

impl Proposer {
    /// That of a study; the evolution strategy begins in the middle of the box.
    pub fn of(study: &StudyFile) -> Self {
        let (coordinates, seed) = (study.parameters.len(), study.seed);
        match study.optimiser {
            Optimiser::CmaEs => {
                let rest = Rest { step: study.stop.step.unwrap_or(STEP), cost: COST };
                Self::CmaEs(Box::new(Restarts::new(vec![0.5; coordinates], rest, seed)))
            }
            Optimiser::Sobol => Self::Sobol { coordinates, seed, next: 0 },
            Optimiser::Random => Self::Random { coordinates, seed, next: 0 },
        }
    }

    /// Points that are to be tried next.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        match self {
            Self::CmaEs(search) => search.ask(),
            Self::Sobol { coordinates, seed, next } => {
                let first = *next;
                *next += BATCH;
                // The generator has 256 dimensions and 65 536 points; another seed gives as many more of both.
                let at = |point: u64, coordinate: usize| {
                    let seed = (*seed as u32).wrapping_add((coordinate / 256) as u32).wrapping_add((point >> 16) as u32);
                    f64::from(sobol_burley::sample((point & 0xffff) as u32, (coordinate % 256) as u32, seed))
                };
                (first..first + BATCH).map(|point| (0..*coordinates).map(|c| at(point, c)).collect()).collect()
            }
            Self::Random { coordinates, seed, next } => {
                let first = *next;
                *next += BATCH;
                let at = |point: u64, coordinate: usize| uniform(*seed, point, DRAW + coordinate as u64);
                (first..first + BATCH).map(|point| (0..*coordinates).map(|c| at(point, c)).collect()).collect()
            }
        }
    }

    /// What they cost, in their order.
    pub fn tell(&mut self, costs: &[f64]) {
        if let Self::CmaEs(search) = self {
            search.tell(costs);
        }
    }

    /// Whether it has come to rest, where it can: it would begin again elsewhere.
    pub fn is_at_rest(&self) -> bool {
        matches!(self, Self::CmaEs(search) if search.is_at_rest())
    }
}
