//! Costs in several objectives: which dominate which, the fronts of a set, the volume it dominates.
//!
//! Every objective is minimised. Dominance with constraints is K. Deb's (*An efficient constraint handling method for genetic algorithms*,
//! Computer Methods in Applied Mechanics and Engineering 186, 2000); for several objectives, and the sorting into fronts: K. Deb, A. Pratap,
//! S. Agarwal and T. Meyarivan, *A Fast and Elitist Multiobjective Genetic Algorithm: NSGA-II*, IEEE Transactions on Evolutionary Computation
//! 6(2), 2002, definition 1 and section III.A. The volume is that of E. Zitzler and L. Thiele (PPSN V, 1998), exact, by L. While,
//! L. Bradstreet and L. Barone, *A Fast Way of Calculating Exact Hypervolumes* (WFG), IEEE Transactions on Evolutionary Computation 16(1),
//! 2012: quick for some dozens of points in two to four objectives; in more, its time grows exponentially. Their slicing and their sorting
//! of the last objective are left out.
//!
//! Where an objective is not a finite number (NaN, an infinity of either sign), none of that point's objectives was measured: they count as
//! positive infinity, all of them. One alone would keep a run that broke off among the best, by what it had saved. A violation that is not a
//! number is an infinite one.

/// What a candidate costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Costs {
    /// One number an objective, the less the better; every point of a set has as many.
    pub objectives: Vec<f64>,
    /// By how much the constraints are broken, in total; 0 or less if all are kept.
    pub violation: f64,
}

impl Costs {
    /// Whether every constraint is kept.
    pub fn is_feasible(&self) -> bool {
        self.violation <= 0.0
    }

    /// Whether every objective is a finite number.
    pub fn is_measured(&self) -> bool {
        self.objectives.iter().all(|objective| objective.is_finite())
    }

    /// Whether this is better: it keeps the constraints that the other breaks; or breaks them less; or, where both keep them, it is nowhere
    /// worse and somewhere better. A strict partial order, whatever the numbers.
    pub fn dominates(&self, other: &Self) -> bool {
        match (self.is_feasible(), other.is_feasible()) {
            (false, false) => self.violation < other.violation || (other.violation.is_nan() && self.violation < f64::INFINITY),
            (true, true) if self.is_measured() && other.is_measured() => {
                weakly(&self.objectives, &other.objectives) && self.objectives != other.objectives
            }
            (true, true) => self.is_measured() && !other.is_measured(),
            (feasible, _) => feasible,
        }
    }
}

/// Whether the one is nowhere worse.
fn weakly(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).all(|(a, b)| a <= b)
}

/// The fronts, best first, as numbers in ascending order: what nothing dominates; of the rest what nothing of the rest dominates; and so on.
pub fn fronts(costs: &[Costs]) -> Vec<Vec<usize>> {
    let mut fronts = Vec::new();
    let mut left: Vec<usize> = (0..costs.len()).collect();
    while !left.is_empty() {
        let is_dominated = |i: &usize| left.iter().any(|j| costs[*j].dominates(&costs[*i]));
        let (rest, front) = left.iter().copied().partition(is_dominated);
        fronts.push(front);
        left = rest;
    }
    fronts
}

/// The volume between a set and the reference point: of all that some feasible point dominates and that dominates the reference. In the
/// product of the objectives' units; the same to the last bit in whatever order. Points that are infeasible, not measured or not below the
/// reference in every objective add nothing.
pub fn hypervolume(costs: &[Costs], reference: &[f64]) -> f64 {
    let points = costs.iter().filter(|costs| counts(costs, reference)).map(|costs| costs.objectives.clone());
    volume(points.collect(), reference)
}

/// By how much the volume would be less without each, the others staying: 0 for what is dominated, or there twice.
pub fn contributions(costs: &[Costs], reference: &[f64]) -> Vec<f64> {
    let of = |i: usize| {
        let others = costs.iter().enumerate().filter(|(j, other)| *j != i && counts(other, reference));
        let others = others.map(|(_, other)| other.objectives.as_slice());
        if counts(&costs[i], reference) { exclusive(&costs[i].objectives, others, reference).max(0.0) } else { 0.0 }
    };
    (0..costs.len()).map(of).collect()
}

fn counts(costs: &Costs, reference: &[f64]) -> bool {
    costs.is_feasible() && costs.is_measured() && costs.objectives.iter().zip(reference).all(|(x, r)| x < r)
}

/// Of points all below the reference: what each dominates and those behind it do not, summed (WFG, "hv").
fn volume(mut points: Vec<Vec<f64>>, reference: &[f64]) -> f64 {
    // In lexicographic order only what comes before a point can dominate it.
    points.sort_by(|a, b| {
        a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut front: Vec<Vec<f64>> = Vec::with_capacity(points.len());
    for point in points {
        if !front.iter().any(|better| weakly(better, &point)) {
            front.push(point);
        }
    }
    let behind = |k: usize| front[k + 1..].iter().map(Vec::as_slice);
    (0..front.len()).fold(0.0, |sum, k| sum + exclusive(&front[k], behind(k), reference))
}

/// What the point dominates and the others do not: its box, without what the others dominate of that box (WFG, "exclhv" and "limitset").
fn exclusive<'a>(point: &[f64], others: impl Iterator<Item = &'a [f64]>, reference: &[f64]) -> f64 {
    let whole: f64 = point.iter().zip(reference).map(|(x, r)| r - x).product();
    let limited = others.map(|other| other.iter().zip(point).map(|(a, b)| a.max(*b)).collect());
    whole - volume(limited.collect(), reference)
}

/// The same with every objective from 0, the least of the set, to 1, the largest; 0 where all are equal.
pub fn scaled(costs: &[Costs]) -> Vec<Costs> {
    let objectives = costs.first().map_or(0, |costs| costs.objectives.len());
    let ends = |objective: usize| {
        let values = || costs.iter().map(|costs| costs.objectives[objective]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let ends: Vec<[f64; 2]> = (0..objectives).map(ends).collect();
    let share = |(value, [least, most]): (&f64, &[f64; 2])| if most > least { (value - least) / (most - least) } else { 0.0 };
    let of =
        |costs: &Costs| Costs { objectives: costs.objectives.iter().zip(&ends).map(share).collect(), violation: costs.violation };
    costs.iter().map(of).collect()
}

/// The compromise of a front: nearest to the least of all objectives at once, each scaled to the front's range (M. Zeleny's compromise
/// programming, 1973, with Euclid's distance); the first of equal ones.
pub fn compromise(costs: &[Costs]) -> Option<usize> {
    let scaled = scaled(costs);
    let distance = |index: usize| scaled[index].objectives.iter().map(|share| share * share).sum::<f64>();
    (0..costs.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn feasible(objectives: &[f64]) -> Costs {
        Costs { objectives: objectives.to_vec(), violation: 0.0 }
    }

    fn close(a: f64, b: f64) -> bool {
        // Some dozens of sums and differences of volumes of at most 1e4.
        (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()))
    }

    #[test]
    fn debs_rule_orders_before_pareto_does() {
        let broken = |by: f64| Costs { objectives: vec![-9.0, -9.0], violation: by };
        let [good, other] = [feasible(&[1.0, 2.0]), feasible(&[2.0, 1.0])];
        assert!(good.dominates(&feasible(&[1.0, 3.0])) && !good.dominates(&good) && !good.dominates(&other));
        for violation in [1e-300, 1.0, f64::INFINITY, f64::NAN] {
            assert!(good.dominates(&broken(violation)) && !broken(violation).dominates(&good), "{violation}");
            assert!(!broken(violation).dominates(&broken(violation)), "{violation}");
        }
        assert!(broken(1.0).dominates(&broken(2.0)) && broken(2.0).dominates(&broken(f64::NAN)));
        assert!(!broken(f64::INFINITY).dominates(&broken(f64::NAN)) && !broken(f64::NAN).dominates(&broken(f64::INFINITY)));
        assert_eq!(
            fronts(&[broken(2.0), good, broken(1.0), feasible(&[3.0, 3.0]), other]),
            [vec![1, 4], vec![3], vec![2], vec![0]]
        );
    }

    #[test]
    fn what_was_not_measured_is_behind_what_was() {
        let bad = [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|bad| feasible(&[0.0, bad]));
        let set: Vec<Costs> = bad.into_iter().chain([feasible(&[5.0, 5.0])]).collect();
        assert_eq!(fronts(&set), [vec![4], vec![0, 1, 2, 3]]);
        assert_eq!(hypervolume(&set, &[6.0, 7.0]), 2.0);
        assert_eq!(contributions(&set, &[6.0, 7.0]), [0.0, 0.0, 0.0, 0.0, 2.0]);
    }

    /// The corners of a cube: point i is 0 in objective i and 1 in the others, the reference 2 everywhere. Each dominates the unit cube that
    /// ends there, all share it, and one more, alone: m + 1 in m objectives.
    #[test]
    fn corners_of_a_cube() {
        for m in 1..=5 {
            let corner = |i: usize| feasible(&(0..m).map(|j| if i == j { 0.0 } else { 1.0 }).collect::<Vec<_>>());
            let set: Vec<Costs> = (0..m).map(corner).collect();
            assert_eq!(hypervolume(&set, &vec![2.0; m]), if m == 1 { 2.0 } else { m as f64 + 1.0 });
            assert_eq!(contributions(&set, &vec![2.0; m]), vec![if m == 1 { 2.0 } else { 1.0 }; m]);
        }
    }

    /// A staircase of n steps from (0, 1) to (1, 0): (n - 1) / (2 n) below (1, 1), every inner corner 1 / n^2 of it, the ends nothing.
    #[test]
    fn a_staircase() {
        let set: Vec<Costs> = (0..=8).map(|i| feasible(&[f64::from(i) / 8.0, 1.0 - f64::from(i) / 8.0])).collect();
        assert_eq!(hypervolume(&set, &[1.0, 1.0]), 7.0 / 16.0);
        let alone = contributions(&set, &[1.0, 1.0]);
        assert_eq!((alone[0], alone[8]), (0.0, 0.0));
        assert!(alone[1..8].iter().all(|alone| *alone == 1.0 / 64.0), "{alone:?}");
    }

    /// The volume of a union of boxes by inclusion and exclusion, over all subsets.
    fn by_inclusion(set: &[Costs], reference: &[f64]) -> f64 {
        let of = |subset: u32| {
            let members = || set.iter().enumerate().filter(move |(i, _)| subset >> i & 1 == 1);
            let sides = reference.iter().enumerate().map(|(j, r)| {
                let most = members().map(|(_, costs)| costs.objectives[j]).fold(f64::NEG_INFINITY, f64::max);
                (r - most).max(0.0)
            });
            sides.product::<f64>() * if subset.count_ones() % 2 == 1 { 1.0 } else { -1.0 }
        };
        (1..1 << set.len()).map(of).sum()
    }

    /// Up to seven points in one to four objectives, on a coarse grid, so that equal ones are frequent; some beyond the reference of 8.
    fn sets() -> impl Strategy<Value = (usize, Vec<Costs>)> {
        let point = |m: usize| proptest::collection::vec((0..10_u8).prop_map(f64::from), m).prop_map(|point| feasible(&point));
        (1..=4_usize).prop_flat_map(move |m| (Just(m), proptest::collection::vec(point(m), 1..=7)))
    }

    proptest! {
        #[test]
        fn volumes_are_those_of_inclusion_and_exclusion((m, set) in sets()) {
            let reference = vec![8.0; m];
            let all = hypervolume(&set, &reference);
            prop_assert!(close(all, by_inclusion(&set, &reference)), "{all}");
            for (i, contribution) in contributions(&set, &reference).into_iter().enumerate() {
                let mut without = set.clone();
                without.remove(i);
                prop_assert!(close(contribution, all - hypervolume(&without, &reference)), "{i}: {contribution}");
            }
        }

        #[test]
        fn order_does_not_matter((m, set) in sets(), turns in 0..7_usize) {
            let reference = vec![7.3; m];
            let mut turned = set.clone();
            turned.reverse();
            turned.rotate_left(turns % set.len());
            prop_assert_eq!(hypervolume(&set, &reference), hypervolume(&turned, &reference));
            let rank = |of: &[Costs]| -> Vec<Vec<Vec<f64>>> {
                let sorted = |front: &Vec<usize>| {
                    let mut front: Vec<Vec<f64>> = front.iter().map(|i| of[*i].objectives.clone()).collect();
                    front.sort_by(|a, b| a.partial_cmp(b).unwrap());
                    front
                };
                fronts(of).iter().map(sorted).collect()
            };
            prop_assert_eq!(rank(&set), rank(&turned));
        }
    }

    /// Of a front from (0, 4) to (10, 0) the nearest to (0, 0) in shares of the range; units make no difference.
    #[test]
    fn the_compromise_is_nearest_to_the_least_of_all() {
        for unit in [1.0, 1e6] {
            let front: Vec<Costs> =
                [[0.0, 4.0], [3.0, 1.0], [4.0, 0.9], [10.0, 0.0]].map(|[a, b]| feasible(&[a, unit * b])).into();
            assert_eq!(compromise(&front), Some(1), "(0.3, 0.25) against (0.4, 0.225)");
            assert_eq!(scaled(&front)[1].objectives, [0.3, 0.25]);
        }
        assert_eq!(compromise(&[feasible(&[2.0, 3.0])]), Some(0));
        assert_eq!(compromise(&[]), None);
    }
}
