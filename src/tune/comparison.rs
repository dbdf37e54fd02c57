//! The find against the default, on runs that both had: same ducts, same seeds.

use serde::Serialize;

use crate::stream::uniform;

/// Streams of random numbers: which pairs a bootstrap draws, which signs a test flips.
const BOOTSTRAP: u64 = 0xc3d0_0000;
const FLIP: u64 = 0xc3e0_0000;
/// Draws of each.
const DRAWS: u64 = 10_000;
/// Pairs up to which all signs are tried.
const EXACT: usize = 13;

/// What a paired comparison came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pairs.
    pub pairs: usize,
    /// Mean cost of the default and of the find.
    pub default_cost: f64,
    /// See `default_cost`.
    pub best_cost: f64,
    /// Mean of default less find: positive if the find is better.
    pub gain: f64,
    /// Its 95 % interval: percentiles of a bootstrap over the pairs.
    pub interval: [f64; 2],
    /// How probable a gain of this size or more, to either side, is if neither is better: a permutation test that flips the signs of the pairs'
    /// differences.
    pub p_value: f64,
    /// Pairs in which the find is better.
    pub better: usize,
}

impl Comparison {
    /// Of the costs of default and find, pair by pair; `None` without any.
    pub fn of(pairs: &[[f64; 2]], seed: u64) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let count = pairs.len();
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / count as f64;
        let differences: Vec<f64> = pairs.iter().map(|[default, best]| default - best).collect();
        let gain = mean(&|[default, best]| default - best);
        let mut means: Vec<f64> = (0..DRAWS)
            .map(|draw| {
                let one = |nth: u64| differences[((uniform(seed, draw, BOOTSTRAP + nth) * count as f64) as usize).min(count - 1)];
                (0..count as u64).map(one).sum::<f64>() / count as f64
            })
            .collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[((share * DRAWS as f64) as usize).min(DRAWS as usize - 1)];
        Some(Self {
            pairs: count,
            default_cost: mean(&|[default, _]| *default),
            best_cost: mean(&|[_, best]| *best),
            gain,
            interval: [at(0.025), at(0.975)],
            p_value: p_value(&differences, seed),
            better: differences.iter().filter(|difference| **difference > 0.0).count(),
        })
    }

    /// Whether the find is better by more than noise: the interval is above zero, and so is the test at 5 %.
    pub fn is_better(&self) -> bool {
        self.interval[0] > 0.0 && self.p_value < 0.05
    }

    /// Whether it is worse by more than noise.
    pub fn is_worse(&self) -> bool {
        self.interval[1] < 0.0 && self.p_value < 0.05
    }
}

/// Two-sided, of the mean against zero: over all signs where there are few pairs, over drawn ones otherwise.
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
        let found = Comparison::of(&pairs, 1).expect("pairs");
        assert!((found.p_value - 2.0 / 256.0).abs() < 1e-12, "{found:?}");
        assert!(found.is_better() && found.better == 8 && found.interval[0] >= 1.0 && found.interval[1] <= 1.7);
        assert!((found.gain - 1.35).abs() < 1e-12);
    }

    /// Where neither is better a test at 5 % says so in one of twenty cases, and an interval of 95 % misses zero as often.
    #[test]
    fn noise_is_told_from_a_gain() {
        let (mut rejected, mut missed) = (0, 0);
        for seed in 0..300 {
            let pairs: Vec<[f64; 2]> = (0..20).map(|i| [uniform(seed, i, 1), uniform(seed, i, 2)]).collect();
            let found = Comparison::of(&pairs, seed).expect("pairs");
            rejected += u32::from(found.p_value < 0.05);
            missed += u32::from(found.interval[0] > 0.0 || found.interval[1] < 0.0);
        }
        // Binomial, 300 at 5 %: 15, and 3.8 of deviation. Percentile intervals of 20 pairs are a little narrow.
        assert!((5..=27).contains(&rejected), "{rejected}");
        assert!((5..=36).contains(&missed), "{missed}");
        assert!(Comparison::of(&[], 1).is_none());
    }
}
