//! MO-CMA-ES: a set of elitist evolution strategies that together approach the front of several objectives.
//!
//! C. Igel, N. Hansen and S. Roth, *Covariance Matrix Adaptation for Multi-objective Optimization*, Evolutionary Computation 15(1), 2007: the
//! generational mu x (1+1) strategy (algorithm 4), its updates of step size and covariance (procedures of section 2) with the parameters of
//! table 1 for one offspring a parent, its rule of success among them. Every parent has one offspring; of both generations together the first
//! half survives, in the order of [`super::ranking`].
//!
//! Where it differs from the paper:
//! - The order knows constraints, and objectives of different units.
//! - The search lives in the unit box: of what leaves it the nearest point inside is taken, without the paper's penalty, and the step that
//!   leads there. Reflected, as [`super::restarts`] does, steps have to shrink to come near a best that lies on a side: on ZDT1 in ten
//!   coordinates the front's share after 500 evaluations is 0.85 that way and 0.95 this way, and where it lies inside both are as good.
//! - No step is larger than the box, and the first ones are a tenth of it.
//!
//! It does not begin again: at rest it goes on with ever smaller steps. It keeps no archive: whoever runs it sees every candidate. All numbers
//! come from the seed by counter.

use super::front::Costs;
use super::ranking::ranking;
use crate::stream::{normal, uniform};

/// Stream of random numbers of steps; a coordinate's number is added, twice.
const NORMAL: u64 = 0xc3f0_0000;
/// Stream of random numbers of beginnings; a coordinate's number is added, twice.
const BEGINNING: u64 = 0xc3f8_0000;
/// First step size, as a share of the box. The first parents are all over it, so that the steps need not be: in medians over 21 seeds of
/// spheres, ZDT1, ZDT4 and turned ellipsoids in 5 to 10 coordinates, after 300 and 500 evaluations, 0.03 to 0.1 is best, 0.2 is worse, and 0.3
/// and more is no better than random search on some.
const SIGMA: f64 = 0.1;
/// Largest step along any coordinate, as a share of the box: of larger ones most would end on a side.
const MOST_STEP: f64 = 1.0;

/// The search, in the unit box: asked for points, told what they cost.
#[derive(Clone, Debug)]
pub struct MoCmaEs {
    seed: u64,
    constants: Constants,
    coordinates: usize,
    /// How many individuals survive a generation.
    mu: usize,
    generation: u64,
    /// None before the first are told.
    parents: Vec<(Individual, Costs)>,
    asked: Vec<Individual>,
}

/// Table 1 of 2007, with one offspring a parent.
#[derive(Clone, Copy, Debug)]
struct Constants {
    damping: f64,
    target: f64,
    threshold: f64,
    c_p: f64,
    c_c: f64,
    c_cov: f64,
}

impl Constants {
    fn of(coordinates: usize) -> Self {
        let n = coordinates as f64;
        let target = 1.0 / 5.5;
        let (c_p, c_c, c_cov) = (target / (2.0 + target), 2.0 / (n + 2.0), 2.0 / (n * n + 6.0));
        Self { damping: 1.0 + n / 2.0, target, threshold: 0.44, c_p, c_c, c_cov }
    }
}

/// How many parents for so many evaluations: a third of their root, so that each has three times the root of offspring. Fewer find a smaller
/// part of the front, more have no time to adapt: in as many generations as there are coordinates, a step shrinks by no more than a third or
/// so. In medians over 21 seeds of spheres, ZDT1 and turned ellipsoids in 5 to 12 coordinates, the volume that all candidates together dominate
/// was largest with 4 to 12 parents after 200 evaluations, with 4 to 6 after 500, with 4 to 12 after 1000. Five at least, to have a choice.
pub fn default_parents(evaluations: usize) -> usize {
    ((evaluations as f64).sqrt() / 3.0).round().max(5.0) as usize
}

/// A point and how it looks around itself.
#[derive(Clone, Debug)]
struct Individual {
    /// Where it is.
    point: Vec<f64>,
    /// How it came there from its parent, in step sizes.
    step: Vec<f64>,
    /// Share of offspring that succeed, smoothed.
    success: f64,
    sigma: f64,
    /// Evolution path.
    path: Vec<f64>,
    /// Covariance matrix, by rows.
    covariance: Vec<f64>,
}

impl Individual {
    fn at(point: Vec<f64>, constants: &Constants) -> Self {
        let n = point.len();
        let covariance = (0..n * n).map(|i| if i % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self { point, step: vec![0.0; n], success: constants.target, sigma: SIGMA, path: vec![0.0; n], covariance }
    }

    /// Its offspring, by these standard normal numbers (algorithm 4, lines 4 to 6).
    fn offspring(&self, z: &[f64]) -> Self {
        let n = z.len();
        let factor = cholesky(&self.covariance, n);
        let step: Vec<f64> = (0..n).map(|i| (0..=i).map(|j| factor[i * n + j] * z[j]).sum()).collect();
        let within = |(x, y): (&f64, &f64)| {
            let to = x + self.sigma * y;
            let inside = to.clamp(0.0, 1.0);
            // What was cut off was no step.
            (inside, if inside == to { *y } else { (inside - x) / self.sigma })
        };
        let (point, step) = self.point.iter().zip(&step).map(within).unzip();
        Self { point, step, ..self.clone() }
    }

    /// Largest variance along a coordinate, in step sizes.
    fn most_variance(&self) -> f64 {
        let n = self.point.len();
        (0..n).map(|i| self.covariance[i * n + i]).fold(0.0, f64::max)
    }

    /// Procedure "updateStepSize".
    fn adapt_step(&mut self, constants: &Constants, succeeds: bool) {
        let Constants { damping, target, c_p, .. } = *constants;
        self.success = (1.0 - c_p) * self.success + if succeeds { c_p } else { 0.0 };
        self.sigma *= libm::exp((self.success - target) / (1.0 - target) / damping);
    }

    /// Makes the step no larger than the box.
    fn bound_step(&mut self) {
        // The lower bound of the deviation keeps the step size finite where the covariance vanishes.
        self.sigma = self.sigma.min(MOST_STEP / self.most_variance().sqrt().max(1e-100));
    }

    /// Procedure "updateCovariance".
    fn adapt_shape(&mut self, constants: &Constants) {
        let Constants { threshold, c_c, c_cov, .. } = *constants;
        let n = self.point.len();
        // Where most offspring succeed steps are too small to tell a direction.
        let tells = self.success < threshold;
        let gain = if tells { (c_c * (2.0 - c_c)).sqrt() } else { 0.0 };
        for (path, y) in self.path.iter_mut().zip(&self.step) {
            *path = (1.0 - c_c) * *path + gain * y;
        }
        let keep = 1.0 - c_cov + if tells { 0.0 } else { c_cov * c_c * (2.0 - c_c) };
        for (i, value) in self.covariance.iter_mut().enumerate() {
            *value = keep * *value + c_cov * self.path[i / n] * self.path[i % n];
        }
    }
}

impl MoCmaEs {
    /// So many parents, anywhere in the box.
    ///
    /// # Panics
    /// Without coordinates or parents.
    pub fn new(coordinates: usize, parents: usize, seed: u64) -> Self {
        assert!(coordinates > 0 && parents > 0, "{coordinates} coordinates, {parents} parents");
        let constants = Constants::of(coordinates);
        let mut search =
            Self { seed, constants, coordinates, mu: parents, generation: 0, parents: Vec::new(), asked: Vec::new() };
        search.asked = search.beginning().into_iter().map(|point| Individual::at(point, &constants)).collect();
        search
    }

    /// A Latin hypercube (McKay, Beckman and Conover, Technometrics 21(2), 1979): along each coordinate the parents share out the box.
    fn beginning(&self) -> Vec<Vec<f64>> {
        let along = |coordinate: usize| {
            let draw = |i: usize, which: u64| uniform(self.seed, i as u64, BEGINNING + 2 * coordinate as u64 + which);
            let mut order: Vec<usize> = (0..self.mu).collect();
            order.sort_by(|a, b| draw(*a, 0).total_cmp(&draw(*b, 0)));
            let mut values = vec![0.0; self.mu];
            for (place, i) in order.into_iter().enumerate() {
                values[i] = (place as f64 + draw(i, 1)) / self.mu as f64;
            }
            values
        };
        let columns: Vec<Vec<f64>> = (0..self.coordinates).map(along).collect();
        (0..self.mu).map(|i| columns.iter().map(|values| values[i]).collect()).collect()
    }

    /// The points of the next generation, each in the box: the first parents, then an offspring a parent.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        if self.generation > 0 {
            let offspring = |(k, (parent, _)): (usize, &(Individual, Costs))| {
                let index = self.generation * self.mu as u64 + k as u64;
                let z: Vec<f64> =
                    (0..self.coordinates as u64).map(|coordinate| normal(self.seed, index, NORMAL + 2 * coordinate)).collect();
                parent.offspring(&z)
            };
            self.asked = self.parents.iter().enumerate().map(offspring).collect();
        }
        self.asked.iter().map(|one| one.point.clone()).collect()
    }

    /// What they cost, in their order (algorithm 4, lines 7 to 13).
    ///
    /// # Panics
    /// If there are not as many costs as points asked, or not as many objectives in each.
    pub fn tell(&mut self, costs: &[Costs]) {
        assert!(costs.len() == self.asked.len(), "{} costs of {} points", costs.len(), self.asked.len());
        let mut all: Vec<(Individual, Costs)> = std::mem::take(&mut self.parents);
        all.extend(std::mem::take(&mut self.asked).into_iter().zip(costs.iter().cloned()));
        let objectives = all[0].1.objectives.len();
        assert!(all.iter().all(|(_, costs)| costs.objectives.len() == objectives), "{objectives} objectives in each");
        let mut place = vec![0; all.len()];
        for (at, i) in ranking(&all.iter().map(|(_, costs)| costs.clone()).collect::<Vec<_>>()).into_iter().enumerate() {
            place[i] = at;
        }
        if self.generation > 0 {
            let (parents, offspring) = all.split_at_mut(self.mu);
            for (k, (parent, offspring)) in parents.iter_mut().zip(offspring).enumerate() {
                // Of the paper of 2010 (T. Voss, N. Hansen and C. Igel, GECCO) it would be enough to survive: with few parents many offspring
                // do that only fill a gap, and steps grow. By that rule the front's share is 0.95 on two spheres after 500 evaluations, by
                // this one 0.97; it was less on all of six problems, medians of 21 seeds.
                let succeeds = place[self.mu + k] < place[k];
                parent.0.adapt_step(&self.constants, succeeds);
                offspring.0.adapt_step(&self.constants, succeeds);
                offspring.0.adapt_shape(&self.constants);
                parent.0.bound_step();
                offspring.0.bound_step();
            }
        }
        self.parents = all.into_iter().zip(place).filter_map(|(one, at)| (at < self.mu).then_some(one)).collect();
        self.generation += 1;
    }

    /// Generations told so far.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Who survived, each in the box, and what they cost.
    pub fn parents(&self) -> impl Iterator<Item = (Vec<f64>, &Costs)> {
        self.parents.iter().map(|(parent, costs)| (parent.point.clone(), costs))
    }

    /// The largest step of any parent along each coordinate, as a share of the box: at rest all are small.
    pub fn deviations(&self) -> Vec<f64> {
        let of = |i: usize| {
            let parents = self.parents.iter().map(|(parent, _)| parent).chain(&self.asked);
            parents.map(|one| one.sigma * one.covariance[i * (self.coordinates + 1)].sqrt()).fold(0.0, f64::max)
        };
        (0..self.coordinates).map(of).collect()
    }
}

/// The lower factor of a symmetric matrix, both by rows; along an axis whose variance is lost in rounding it is 0.
fn cholesky(matrix: &[f64], n: usize) -> Vec<f64> {
    let mut factor = vec![0.0; n * n];
    for j in 0..n {
        let rest =
            |i: usize, factor: &[f64]| matrix[i * n + j] - (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum::<f64>();
        let pivot = rest(j, &factor);
        if pivot > 1e-15 * matrix[j * n + j] {
            let root = pivot.sqrt();
            for i in j..n {
                factor[i * n + j] = rest(i, &factor) / root;
            }
        }
    }
    factor
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tune::front::hypervolume;

    /// Squared distances to the points that are 1/4 and 3/4 in each coordinate, as shares of the squared distance of these two.
    fn spheres(u: &[f64]) -> Vec<f64> {
        let to = |c: f64| u.iter().map(|u| (u - c) * (u - c)).sum::<f64>() / (0.25 * u.len() as f64);
        vec![to(0.25), to(0.75)]
    }

    /// Ellipsoids about these two, of condition 1e6: ELLI1 of Igel, Hansen and Roth but for the box and a factor; level or turned.
    fn ellipsoids(u: &[f64], is_turned: bool) -> Vec<f64> {
        let n = u.len() as f64;
        let weight = |i: usize| libm::pow(1e6, i as f64 / (n - 1.0));
        // Reflection at a plane (Householder) that holds both centres: a normal whose components add up to 0.
        let normal: Vec<f64> = (0..u.len()).map(|i| i as f64 - (n - 1.0) / 2.0).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let share = if is_turned { 2.0 * dot(&normal, u) / dot(&normal, &normal) } else { 0.0 };
        let turned: Vec<f64> = u.iter().zip(&normal).map(|(u, v)| u - share * v).collect();
        let to = |c: f64| turned.iter().enumerate().map(|(i, u)| weight(i) * (u - c) * (u - c)).sum::<f64>();
        let between: f64 = (0..u.len()).map(|i| 0.25 * weight(i)).sum();
        vec![to(0.25) / between, to(0.75) / between]
    }

    fn feasible(objectives: Vec<f64>) -> Costs {
        Costs { objectives, violation: 0.0 }
    }

    /// Every candidate of a run in five coordinates with eight parents.
    fn run(seed: u64, evaluations: usize, of: impl Fn(&[f64]) -> Costs) -> Vec<Costs> {
        let mut search = MoCmaEs::new(5, 8, seed);
        let mut all = Vec::new();
        while all.len() < evaluations {
            let costs: Vec<Costs> = search.ask().iter().map(|u| of(u)).collect();
            search.tell(&costs);
            all.extend(costs);
        }
        all
    }

    /// Median over nine seeds of the volume below (1, 1).
    fn median(of: impl Fn(u64) -> Vec<Costs>) -> f64 {
        let mut volumes: Vec<f64> = (0..9).map(|seed| hypervolume(&of(seed), &[1.0, 1.0])).collect();
        volumes.sort_by(f64::total_cmp);
        volumes[4]
    }

    /// The front is the straight line between the centres: at a share t of it the costs are t^2 and (1 - t)^2, and the volume below (1, 1) is
    /// the integral of 1 - (1 - sqrt f)^2, 5/6. Where the mean of the coordinates has to be 1/2 or more, t is, and the integral begins at
    /// f = 1/4: 67/96. DEAP 1.4.4 (StrategyMultiObjective, the same beginning, reflected, eight parents, 500 evaluations) comes to 0.950 of 5/6
    /// in the median of 21 seeds, random search to 0.869; this to 0.972.
    #[test]
    fn two_spheres_in_five_coordinates() {
        let free = median(|seed| run(seed, 500, |u| feasible(spheres(u)))) / (5.0 / 6.0);
        let random = |seed: u64| {
            let at = |i: u64| (0..5).map(|c| uniform(seed, i, c)).collect::<Vec<f64>>();
            (0..500).map(|i| feasible(spheres(&at(i)))).collect()
        };
        let by_chance = median(random) / (5.0 / 6.0);
        assert!((0.96..1.0).contains(&free) && free > by_chance + 0.05, "{free}, by chance {by_chance}");
        let bounded = |u: &[f64]| Costs { objectives: spheres(u), violation: (0.5 - u.iter().sum::<f64>() / 5.0).max(0.0) };
        let bound = median(|seed| run(seed, 500, bounded)) / (67.0 / 96.0);
        assert!((0.9..1.0).contains(&bound), "{bound}");
    }

    /// The best of ZDT1 (E. Zitzler, K. Deb and L. Thiele, 2000) lies on sides of the box: all coordinates but the first are 0, and f_2 = 1 -
    /// sqrt(f_1). In ten coordinates, below (1.1, 6): 6.6 - 1/3.
    #[test]
    fn a_front_on_the_sides_of_the_box_is_found() {
        let zdt1 = |u: &[f64]| {
            let g = 1.0 + u[1..].iter().sum::<f64>();
            vec![u[0], g * (1.0 - (u[0] / g).sqrt())]
        };
        let volume = |seed: u64| {
            let mut search = MoCmaEs::new(10, 8, seed);
            let mut all = Vec::new();
            while all.len() < 500 {
                let costs: Vec<Costs> = search.ask().iter().map(|u| feasible(zdt1(u))).collect();
                search.tell(&costs);
                all.extend(costs);
            }
            hypervolume(&all, &[1.1, 6.0]) / (6.6 - 1.0 / 3.0)
        };
        let mut volumes: Vec<f64> = (0..9).map(volume).collect();
        volumes.sort_by(f64::total_cmp);
        assert!((0.93..1.0).contains(&volumes[4]), "{volumes:?}");
    }

    /// Of condition 1e6, and turned: what is missing of 5/6 is little, and as much where no coordinate is an axis.
    #[test]
    fn a_turned_problem_is_as_easy() {
        let missing = |is_turned| 1.0 - median(|seed| run(seed, 1000, |u| feasible(ellipsoids(u, is_turned)))) / (5.0 / 6.0);
        let [level, aslant] = [missing(false), missing(true)];
        assert!(level < 0.02 && aslant < 0.02 && (0.5..2.0).contains(&(aslant / level)), "{level} and {aslant}");
    }

    /// One parent and one objective are the elitist CMA-ES of the same paper. On an ellipsoid of condition 1e6 in five coordinates, turned, it
    /// takes 1425 evaluations in the median of 21 seeds to 1e-10; DEAP 1.4.4 (StrategyOnePlusLambda, from such points) takes 1423. On the
    /// sphere they take 431 and 437.
    #[test]
    fn one_parent_takes_as_many_evaluations_as_elsewhere() {
        let evaluations = |seed: u64, condition: f64| {
            let mut search = MoCmaEs::new(5, 1, seed);
            for count in 1..10_000 {
                let x: Vec<f64> = search.ask()[0].iter().map(|u| u - 0.4).collect();
                let share = 2.0 * x.iter().sum::<f64>() / 5.0;
                let cost =
                    x.iter().enumerate().map(|(i, x)| libm::pow(condition, i as f64 / 4.0) * (x - share) * (x - share)).sum();
                if cost < 1e-10 {
                    return count;
                }
                search.tell(&[feasible(vec![cost])]);
            }
            u64::MAX
        };
        for (condition, elsewhere) in [(1.0, 437), (1e6, 1423)] {
            let mut all: Vec<u64> = (0..21).map(|seed| evaluations(seed, condition)).collect();
            all.sort_unstable();
            assert!(all[10].abs_diff(elsewhere) * 10 < elsewhere && all[20] < u64::MAX, "condition {condition}: {all:?}");
        }
    }

    /// Powers of two change no digit of what is asked; nor does who computes the costs, or when.
    #[test]
    fn units_make_no_difference() {
        let asked = |a: f64, b: f64| {
            let mut search = MoCmaEs::new(3, 6, 4);
            let generation = |_| {
                let points = search.ask();
                assert_eq!(points, search.ask());
                let costs: Vec<Costs> = points.iter().map(|u| spheres(u)).map(|f| feasible(vec![a * f[0], b * f[1]])).collect();
                search.tell(&costs);
                points
            };
            (0..30).map(generation).collect::<Vec<_>>()
        };
        assert_eq!(asked(1.0, 1.0), asked(4096.0, 1.0 / 1024.0));
    }

    /// What is told may be anything: points stay in the box, steps finite and no larger than it.
    #[test]
    fn any_costs_are_borne() {
        let odd = [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 0.0, -0.0, f64::MIN_POSITIVE, 1.0];
        // Always odd; always better than before; always worse.
        for kind in 0..3 {
            let mut search = MoCmaEs::new(2, 4, kind);
            for generation in 0..5000_u64 {
                let points = search.ask();
                assert!(points.iter().flatten().all(|x| (0.0..=1.0).contains(x)), "{kind}, {generation}: {points:?}");
                let any = |i: u64, which: u64| odd[(uniform(kind, generation * 4 + i, which) * 10.0) as usize];
                let costs = |i: u64| match kind {
                    0 => Costs { objectives: (0..3).map(|which| any(i, which)).collect(), violation: any(i, 3) },
                    1 => feasible(vec![-((generation * 4 + i) as f64); 2]),
                    _ => feasible(vec![generation as f64; 2]),
                };
                search.tell(&(0..4).map(costs).collect::<Vec<_>>());
                assert!(search.deviations().iter().all(|step| (0.0..1.0 + 1e-9).contains(step)), "{:?}", search.deviations());
            }
            assert!(kind != 2 || search.deviations().iter().all(|step| *step < 1e-9), "not at rest");
            assert!(search.parents().all(|(point, costs)| point.len() == 2 && costs.objectives.len() >= 2));
        }
    }

    #[test]
    fn first_parents_share_out_the_box() {
        let points = MoCmaEs::new(3, 10, 7).ask();
        for coordinate in 0..3 {
            let mut places: Vec<usize> = points.iter().map(|point| (10.0 * point[coordinate]) as usize).collect();
            places.sort_unstable();
            assert_eq!(places, (0..10).collect::<Vec<_>>());
        }
        assert_eq!([100, 200, 500, 1000].map(default_parents), [5, 5, 7, 11]);
    }
}
