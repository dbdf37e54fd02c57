//! The optimisers that are built in, as ones that are asked and told; in the unit box.

use super::ask_tell::{AskTell, Lost};
use super::candidate;
use super::mo_cma_es::{MoCmaEs, default_parents};
use super::objective::rank;
use super::restarts::{Rest, Restarts, SIGMA};
use super::search::Trial;
use crate::scenario::study_file::{Optimiser, StudyFile};
use crate::scenario::sweep_file::{Factor, Level};
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
pub struct Proposer {
    parameters: Vec<Factor>,
    search: Method,
    name: &'static str,
    /// How many it proposed last.
    proposed: usize,
}

#[derive(Clone, Debug)]
enum Method {
    /// Learns from what it is told.
    CmaEs(Box<Restarts>),
    /// The same of several objectives, and what step is rest.
    MoCmaEs(Box<MoCmaEs>, f64),
    /// A scrambled Sobol sequence (Burley 2020).
    Sobol(Sequence),
    /// Independent draws.
    Random(Sequence),
}

/// Points that follow from their number alone.
#[derive(Clone, Copy, Debug)]
struct Sequence {
    coordinates: usize,
    seed: u64,
    /// Number of the next point.
    next: u64,
}

impl Sequence {
    fn batch(&mut self, at: impl Fn(u64, usize) -> f64) -> Vec<Vec<f64>> {
        let first = self.next;
        self.next += BATCH;
        (first..self.next).map(|point| (0..self.coordinates).map(|coordinate| at(point, coordinate)).collect()).collect()
    }
}

impl Proposer {
    /// That of a study; the evolution strategy begins in the middle of the box.
    pub fn of(study: &StudyFile) -> Self {
        let (coordinates, seed) = (study.parameters.len(), study.seed);
        let sequence = Sequence { coordinates, seed, next: 0 };
        let step = study.stop.step.unwrap_or(STEP);
        let (name, search) = match study.optimiser {
            Optimiser::CmaEs if study.objectives.len() > 1 => {
                let search =
                    MoCmaEs::new(coordinates, default_parents((study.runs / study.runs_of_a_candidate()) as usize), seed);
                ("MO-CMA-ES", Method::MoCmaEs(Box::new(search), step))
            }
            Optimiser::CmaEs => {
                let rest = Rest { step, cost: COST };
                ("CMA-ES", Method::CmaEs(Box::new(Restarts::new(vec![0.5; coordinates], SIGMA, rest, seed))))
            }
            Optimiser::Sobol => ("Sobol sequence", Method::Sobol(sequence)),
            Optimiser::Random => ("random search", Method::Random(sequence)),
        };
        Self { parameters: study.parameters.clone(), search, name, proposed: 0 }
    }

    fn points(&mut self) -> Vec<Vec<f64>> {
        match &mut self.search {
            Method::CmaEs(search) => search.ask(),
            Method::MoCmaEs(search, _) => search.ask(),
            Method::Sobol(sequence) => {
                let seed = sequence.seed;
                // The generator has 256 dimensions and 65 536 points; another seed gives as many more of both.
                sequence.batch(|point, coordinate| {
                    let seed = (seed as u32).wrapping_add((coordinate / 256) as u32).wrapping_add((point >> 16) as u32);
                    f64::from(sobol_burley::sample((point & 0xffff) as u32, (coordinate % 256) as u32, seed))
                })
            }
            Method::Random(sequence) => {
                let seed = sequence.seed;
                sequence.batch(|point, coordinate| uniform(seed, point, DRAW + coordinate as u64))
            }
        }
    }
}

impl AskTell for Proposer {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn begin(&mut self, _: &Trial, _: &[Option<f64>]) -> Result<(), Lost> {
        Ok(())
    }

    fn ask(&mut self) -> Result<Vec<Vec<Level>>, Lost> {
        let points = self.points();
        self.proposed = points.len();
        Ok(points.iter().map(|point| candidate::values(&self.parameters, point)).collect())
    }

    fn tell(&mut self, trials: &[Trial]) -> Result<(), Lost> {
        // Where the budget cuts a generation short nothing follows that could be learned from it.
        if trials.len() < self.proposed {
            return Ok(());
        }
        match &mut self.search {
            Method::CmaEs(search) => search.tell(&ranks(trials)),
            Method::MoCmaEs(search, _) => search.tell(&trials.iter().map(|trial| trial.costs.clone()).collect::<Vec<_>>()),
            Method::Sobol(_) | Method::Random(_) => {}
        }
        Ok(())
    }

    fn is_at_rest(&self) -> bool {
        match &self.search {
            Method::CmaEs(search) => search.is_at_rest(),
            Method::MoCmaEs(search, step) => search.deviations().iter().all(|deviation| deviation < step),
            Method::Sobol(_) | Method::Random(_) => false,
        }
    }
}

/// What orders a generation of one objective: those that had all of their runs by what they came to; the others are behind, in the order that
/// their first runs gave.
fn ranks(trials: &[Trial]) -> Vec<f64> {
    let some = |full: bool| trials.iter().filter(move |trial| trial.is_full == full).map(|trial| rank(&trial.costs));
    let worst = some(true).fold(f64::NEG_INFINITY, f64::max);
    let first = some(false).fold(f64::INFINITY, f64::min);
    let of = |trial: &Trial| rank(&trial.costs) + if trial.is_full { 0.0 } else { worst - first };
    trials.iter().map(of).collect()
}
