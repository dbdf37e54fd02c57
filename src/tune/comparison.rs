//! The find against the default, on runs that both had: same ducts, same seeds.
//!
//! What a gain is to hold on are ducts, and seeds of one duct are no other ducts: its pairs are put together first, and an interval and a test
//! are those of the ducts. Where only one duct was held out its seeds are all there is, and what is found holds on it alone.

use serde::Serialize;

use super::objective::over;
use crate::scenario::study_file::Over;
use crate::stream::uniform;

/// Streams of random numbers: which units a bootstrap draws, which signs a test flips.
const BOOTSTRAP: u64 = 0xc3d0_0000;
const FLIP: u64 = 0xc3e0_0000;
/// Draws of each.
const DRAWS: u64 = 10_000;
/// Units up to which all signs are tried.
const EXACT: usize = 13;

/// What a paired comparison came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pairs of runs.
    pub pairs: usize,
    /// What counts as independent: ducts, or where there is one alone its pairs.
    pub units: usize,
    /// Whether these are ducts.
    pub by_duct: bool,
    /// Cost of the default and of the find, in the mean over the units.
    pub default_cost: f64,
    /// See `default_cost`.
    pub best_cost: f64,
    /// Mean of default less find: positive if the find is better.
    pub gain: f64,
    /// Its 95 % interval: percentiles of a bootstrap over the units.
    pub interval: [f64; 2],
    /// How probable a gain of this size or more, to either side, is if neither is better: a permutation test that flips the signs of the units'
    /// differences.
    pub p_value: f64,
    /// Units on which the find is better.
    pub better: usize,
}

impl Comparison {
    /// Of the costs of default and find, duct by duct and pair by pair; `None` without any. The pairs of a duct make one as the objective puts
    /// runs together, by their mean, worst or quantile, and all ducts count alike; of one duct alone it is the mean over its pairs.
    pub fn of(ducts: &[Vec<[f64; 2]>], rule: Over, seed: u64) -> Option<Self> {
        let ducts: Vec<&Vec<[f64; 2]>> = ducts.iter().filter(|pairs| !pairs.is_empty()).collect();
        let by_duct = ducts.len() > 1;
        let units: Vec<[f64; 2]> = match ducts.as_slice() {
            [] => return None,
            [alone] => (*alone).clone(),
            several => several.iter().map(|pairs| together(rule, pairs)).collect(),
        };
        let count = units.len();
        let [default_cost, best_cost] = together(Over::Mean, &units);
        let differences: Vec<f64> = units.iter().map(|[default, best]| default - best).collect();
        let mut means: Vec<f64> = (0..DRAWS)
            .map(|draw| {
                let one = |nth: u64| differences[((uniform(seed, draw, BOOTSTRAP + nth) * count as f64) as usize).min(count - 1)];
                (0..count as u64).map(one).sum::<f64>() / count as f64
            })
            .collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[((share * DRAWS as f64) as usize).min(DRAWS as usize - 1)];
        Some(Self {
            pairs: ducts.iter().map(|pairs| pairs.len()).sum(),
            units: count,
            by_duct,
            default_cost,
            best_cost,
            gain: default_cost - best_cost,
            interval: [at(0.025), at(0.975)],
            p_value: p_value(&differences, seed),
            better: differences.iter().filter(|difference| **difference > 0.0).count(),
        })
    }

    /// Whether the find is better by more than noise: the interval is above zero, and the test says so at this level.
    pub fn is_better(&self, level: f64) -> bool {
        self.interval[0] > 0.0 && self.p_value < level
    }

    /// Whether it is worse by more than noise.
    pub fn is_worse(&self, level: f64) -> bool {
        self.interval[1] < 0.0 && self.p_value < level
    }
}

/// What default and find cost in so many pairs, each as one number.
pub fn together(rule: Over, pairs: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|which| over(rule, &pairs.iter().map(|pair| pair[which]).collect::<Vec<_>>()))
}

/// Two-sided, of the mean against zero: over all signs where there are few units, over drawn ones otherwise.
fn p_value(differences: &[f64], seed: u64) -> f64 {
    let count = differences.len();
    let seen = differences.iter().sum::<f64>().abs();
    let as_large = |flips: &dyn Fn(usize) -> bool| {
        let sum: f64 = differences.iter().enumerate().map(|(i, d)| if flips(i) { -d } else { *d }).sum();
        // Rounding is no difference.
        sum.abs() >= seen * (1.0 - 1e-12)
    };
    if count <= EXACT {
        let all = 1_u64 << count;
        let hits = (0..all).filter(|signs| as_large(&|i| signs >> i & 1 == 1)).count();
        return hits as f64 / all as f64;
    }
    let hits = (0..DRAWS).filter(|draw| as_large(&|i| uniform(seed, *draw, FLIP + i as u64) < 0.5)).count();
    // The one that was seen is one of them (B. Phipson and G. Smyth 2010).
    (hits as f64 + 1.0) / (DRAWS as f64 + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fisher's exact reasoning: of eight pairs that all say the same, one sign pattern in 128 is as extreme.
    #[test]
    fn the_test_is_exact_for_few_pairs() {
        let pairs: Vec<[f64; 2]> = (0..8).map(|i| [2.0 + 0.1 * f64::from(i), 1.0]).collect();
        let found = Comparison::of(&[pairs], Over::Mean, 1).expect("pairs");
        assert!((found.p_value - 2.0 / 256.0).abs() < 1e-12, "{found:?}");
        assert!(found.is_better(0.05) && found.better == 8 && found.interval[0] >= 1.0 && found.interval[1] <= 1.7);
        assert!((found.gain - 1.35).abs() < 1e-12);
    }

    /// Ducts differ from each other, and seeds hardly do: of three ducts with four seeds each, where neither is better, a test that took pairs
    /// for units would find a difference in two of five cases. Three ducts cannot show one at 5 %, eight seldom do.
    #[test]
    fn seeds_of_a_duct_are_no_ducts() {
        let rejected = |ducts: u64| {
            let found = |seed: u64| {
                let duct = |duct: u64| {
                    let effect = uniform(seed, duct, 1) - 0.5;
                    let pair = |i: u64| [1.0 + effect + 0.05 * (uniform(seed, 100 * duct + i, 2) - 0.5), 1.0];
                    (0..4).map(pair).collect::<Vec<_>>()
                };
                Comparison::of(&(0..ducts).map(duct).collect::<Vec<_>>(), Over::Mean, seed).expect("pairs")
            };
            (0..200).filter(|seed| found(*seed).p_value < 0.05).count()
        };
        assert_eq!(rejected(3), 0);
        // Binomial, 200 at 5 %: 10, and 3.1 of deviation.
        assert!((2..=19).contains(&rejected(8)), "{}", rejected(8));
    }

    /// Who is after the worst is judged by each duct's worst run: four seeds that are better by a little and one that is much worse are no gain.
    #[test]
    fn the_worst_is_judged_by_the_worst() {
        let ducts: Vec<Vec<[f64; 2]>> = (0..8).map(|_| (0..5).map(|i| [1.0, if i == 0 { 1.5 } else { 0.8 }]).collect()).collect();
        let [mean, worst] = [Over::Mean, Over::Worst].map(|rule| Comparison::of(&ducts, rule, 1).expect("pairs"));
        assert!(mean.is_better(0.05) && (mean.gain - 0.06).abs() < 1e-12, "{mean:?}");
        assert!(worst.is_worse(0.05) && (worst.gain + 0.5).abs() < 1e-12, "{worst:?}");
    }

    /// Where neither is better a test at 5 % says so in one of twenty cases, and an interval of 95 % misses zero as often.
    #[test]
    fn noise_is_told_from_a_gain() {
        let (mut rejected, mut missed) = (0, 0);
        for seed in 0..300 {
            let pairs: Vec<[f64; 2]> = (0..20).map(|i| [uniform(seed, i, 1), uniform(seed, i, 2)]).collect();
            let found = Comparison::of(&[pairs], Over::Mean, seed).expect("pairs");
            rejected += u32::from(found.p_value < 0.05);
            missed += u32::from(found.interval[0] > 0.0 || found.interval[1] < 0.0);
        }
        // Binomial, 300 at 5 %: 15, and 3.8 of deviation. Percentile intervals of 20 pairs are a little narrow.
        assert!((5..=27).contains(&rejected), "{rejected}");
        assert!((5..=36).contains(&missed), "{missed}");
        assert!(Comparison::of(&[], Over::Mean, 1).is_none());
    }
}
