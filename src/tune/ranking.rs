//! Candidates with several objectives in order: the better ones first, and of those the ones that spread well.
//!
//! The order of MO-CMA-ES (C. Igel, N. Hansen and S. Roth, *Covariance Matrix Adaptation for Multi-objective Optimization*, Evolutionary
//! Computation 15(1), 2007, section 3.1 with the contributing hypervolume): front by front ([`super::front`]); within a front, the one that
//! contributes the least volume is last, that which does so without it last but one, and so on.
//!
//! The volume is that of the front with each objective scaled to the range it has there, since units differ, against the point 1.1 in each.
//! Scaling multiplies all contributions by the same factor; what it settles is where the reference lies. The best in each objective come
//! first whatever they contribute; so with two objectives the reference settles no more than which of these two is the first.
//!
//! Equal ones stay in the order they had. So do those that break the constraints equally, or of which not every objective was measured: what
//! else they cost says little.

use super::front::{Costs, contributions, fronts};

/// Reference point, in every objective, where the front reaches from 0 to 1.
const REFERENCE: f64 = 1.1;

/// The numbers of the candidates, best first.
pub fn ranking(costs: &[Costs]) -> Vec<usize> {
    fronts(costs).into_iter().flat_map(|front| spread(front, costs)).collect()
}

/// A front, from the one without which most would be lost to the one without which least.
fn spread(mut front: Vec<usize>, costs: &[Costs]) -> Vec<usize> {
    let mut scaled: Vec<Costs> = front.iter().map(|i| costs[*i].clone()).collect();
    let mut is_best = vec![false; front.len()];
    let objectives = scaled[0].objectives.len();
    for objective in 0..objectives {
        if let Some(best) = scale(&mut scaled, objective) {
            is_best[best] = true;
        }
    }
    let mut gone = Vec::with_capacity(front.len());
    while !front.is_empty() {
        let alone = contributions(&scaled, &vec![REFERENCE; objectives]);
        let key = |i: usize| (is_best[i], alone[i]);
        // Of equal ones the last.
        let least = (1..front.len()).fold(0, |least, i| if key(i) <= key(least) { i } else { least });
        gone.push(front.remove(least));
        scaled.remove(least);
        is_best.remove(least);
    }
    gone.reverse();
    gone
}

/// Scales an objective to 0 to 1; returns where it is best, the first of equal ones, if it was measured anywhere.
fn scale(front: &mut [Costs], objective: usize) -> Option<usize> {
    let of = |costs: &Costs| costs.objectives[objective];
    let measured: Vec<usize> = (0..front.len()).filter(|i| front[*i].is_feasible() && front[*i].is_measured()).collect();
    let best = measured.iter().copied().min_by(|a, b| of(&front[*a]).total_cmp(&of(&front[*b])))?;
    // Halves, since the range of finite numbers may be infinite.
    let least = of(&front[best]) / 2.0;
    let range = measured.iter().map(|i| of(&front[*i]) / 2.0 - least).fold(0.0, f64::max);
    for i in measured {
        let x = &mut front[i].objectives[objective];
        *x = if range > 0.0 { (*x / 2.0 - least) / range } else { 0.0 };
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(points: &[(f64, f64)]) -> Vec<Costs> {
        points.iter().map(|(a, b)| Costs { objectives: vec![*a, *b], violation: 0.0 }).collect()
    }

    fn who(costs: &[Costs], most: usize) -> Vec<usize> {
        let mut first = ranking(costs)[..most].to_vec();
        first.sort_unstable();
        first
    }

    /// Between the ends stand alone 0.4 x 0.05, 0.1 x 0.45 and 0.4 x 0.4; once the first is gone, the second 0.1 x 0.5.
    #[test]
    fn the_least_contribution_is_last() {
        let line = set(&[(0.0, 1.0), (0.1, 0.95), (0.5, 0.5), (0.6, 0.1), (1.0, 0.0)]);
        assert_eq!(who(&line, 4), [0, 2, 3, 4]);
        assert_eq!(who(&line, 3), [0, 3, 4]);
        assert_eq!(who(&line, 2), [0, 4]);
        let behind: Vec<Costs> = set(&[(5.0, 5.0)]).into_iter().chain(line).collect();
        assert_eq!(who(&behind, 5), [1, 2, 3, 4, 5]);
    }

    /// Metres or kilometres: powers of two change no digit. Numbers as large as there are do not overflow.
    #[test]
    fn units_make_no_difference() {
        let points: Vec<(f64, f64)> = (0..20).map(|i| f64::from(i) / 19.0).map(|t| (t * t, (1.0 - t) * (1.0 - t * t))).collect();
        let in_units = |a: f64, b: f64| set(&points.iter().map(|(x, y)| (a * x - a / 2.0, b * y)).collect::<Vec<_>>());
        let large = 2.0 * (f64::MAX / 4.0);
        assert_eq!(ranking(&in_units(1024.0, 1.0 / 4096.0)), ranking(&in_units(1.0, 1.0)));
        assert_eq!(ranking(&in_units(2.0_f64.sqrt() * large, 1.0)).len(), 20);
    }

    #[test]
    fn equal_ones_stay_in_order() {
        assert_eq!(who(&set(&[(1.0, 2.0); 4]), 2), [0, 1]);
        let broken = Costs { objectives: vec![0.0, 0.0], violation: 1.0 };
        assert_eq!(who(&vec![broken.clone(); 3], 1), [0]);
        let unmeasured = set(&[(f64::NAN, 0.0), (f64::INFINITY, 1.0), (3.0, f64::NEG_INFINITY), (7.0, 8.0)]);
        assert_eq!(who(&unmeasured, 2), [0, 3]);
        assert_eq!(who(&[vec![broken], unmeasured].concat(), 4), [1, 2, 3, 4]);
    }
}
