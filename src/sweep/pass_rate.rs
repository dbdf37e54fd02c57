//! How often cases pass, and how well that is known.

use crate::scenario::sweep_file::StopRule;

/// The 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % interval of a probability of which `passed` of `count` trials came true: Wilson's score interval (Wilson 1927, equation 1;
/// Brown, Cai and DasGupta 2001 recommend it for small counts). Of no trials it is everything.
pub fn wilson(passed: u64, count: u64) -> [f64; 2] {
    if count == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (count as f64, passed as f64 / count as f64);
    let z2 = Z * Z;
    let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    // At either end the interval ends there; rounding would leave a trace.
    [if passed == 0 { 0.0 } else { (centre - half).max(0.0) }, if passed == count { 1.0 } else { (centre + half).min(1.0) }]
}

/// How many of a point's replicates count, of which these are known in their order: all up to the first at which the rule holds.
/// `None` if it does not hold yet.
pub fn enough(rule: &StopRule, passed: impl Iterator<Item = bool>) -> Option<u32> {
    let mut so_far = SoFar::default();
    for pass in passed {
        if so_far.is_enough_with(rule, pass) {
            return Some(so_far.count);
        }
    }
    None
}

/// A point's replicates as far as they are known in their order.
#[derive(Clone, Copy, Debug, Default)]
pub struct SoFar {
    /// How many there are.
    pub count: u32,
    passed: u64,
}

impl SoFar {
    /// Takes the next one in; whether that is enough.
    pub fn is_enough_with(&mut self, rule: &StopRule, passed: bool) -> bool {
        self.count += 1;
        self.passed += u64::from(passed);
        let [low, high] = wilson(self.passed, u64::from(self.count));
        self.count >= rule.least_replicates && (high - low) / 2.0 <= rule.pass_rate_half_width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R 4.3, `prop.test(x, n, correct = FALSE)$conf.int`, whose interval is Wilson's.
    #[test]
    fn intervals_are_those_of_another_program() {
        for (passed, count, [low, high]) in
            [(8, 10, [0.490_162_5, 0.943_317_8]), (0, 10, [0.0, 0.277_532_8]), (50, 100, [0.403_831_5, 0.596_168_5])]
        {
            let [found_low, found_high] = wilson(passed, count);
            assert!(
                (found_low - low).abs() < 1e-6 && (found_high - high).abs() < 1e-6,
                "{passed}/{count}: {found_low} {found_high}"
            );
        }
        assert_eq!(wilson(10, 10)[1], 1.0);
        assert_eq!(wilson(0, 0), [0.0, 1.0]);
    }

    #[test]
    fn a_point_stops_at_the_first_replicate_that_says_enough() {
        let rule = StopRule { pass_rate_half_width: 0.2, least_replicates: 3 };
        // All pass: the interval of 6 is 0.61 to 1, half of it 0.195; of 5 it is 0.217.
        assert_eq!(enough(&rule, std::iter::repeat_n(true, 20)), Some(6));
        assert_eq!(enough(&rule, std::iter::repeat_n(true, 5)), None);
        assert_eq!(enough(&StopRule { least_replicates: 9, ..rule }, std::iter::repeat_n(true, 20)), Some(9));
        // A coin takes longer, and what comes after does not matter.
        let coin = enough(&rule, (0..40).map(|i| i % 2 == 0));
        assert_eq!(coin, enough(&rule, (0..40).map(|i| i % 2 == 0 || i > 30)));
        assert!(coin > Some(15), "{coin:?}");
    }
}
