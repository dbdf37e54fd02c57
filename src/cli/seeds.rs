//! Seeds as they are typed: `1..20`, `1,5,9`, `1..3,7`.

use std::ops::RangeInclusive;

/// Largest seed: TOML knows no larger whole number, and the run's folder holds the seed as TOML.
const LARGEST: u64 = i64::MAX as u64;

/// Seeds to run a scenario with: one or more, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Seeds {
    /// As typed, both ends included.
    ranges: Vec<RangeInclusive<u64>>,
}

impl Seeds {
    /// How many there may be.
    pub(crate) const MOST: u64 = 100_000;

    /// From ranges `A..B` (or `A..=B`: the same, both ends are included) and single seeds, with commas between.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let ranges: Vec<_> = text.split(',').map(range).collect::<Result<_, _>>()?;
        // No sum over the ranges overflows this.
        let count: u128 = ranges.iter().map(|range| u128::from(range.end() - range.start()) + 1).sum();
        if count > u128::from(Self::MOST) {
            return Err(format!("these are {count} seeds, and {} is the most: name fewer, in several calls", Self::MOST));
        }
        let mut sorted: Vec<_> = ranges.iter().collect();
        sorted.sort_by_key(|range| *range.start());
        match sorted.windows(2).find(|pair| pair[1].start() <= pair[0].end()) {
            Some(pair) => Err(format!("seed {} is there twice: name each seed once", pair[1].start())),
            None => Ok(Self { ranges }),
        }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.iter().count()
    }

    /// Each of them, in the order in which they were typed.
    pub(crate) fn iter(&self) -> impl Iterator<Item = u64> {
        self.ranges.iter().cloned().flatten()
    }
}

/// One seed.
///
/// # Errors
/// The bounds, where it is none.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|seed| *seed <= LARGEST).ok_or_else(|| format!("a whole number from 0 to {LARGEST}"))
}

/// What stands between two commas.
fn range(text: &str) -> Result<RangeInclusive<u64>, String> {
    let text = text.trim();
    if text.is_empty() {
        return Err("a seed is missing, as in `1..20`, `1,5,9` or `1..3,7`".into());
    }
    let one = |text: &str| seed(text.trim()).map_err(|what| format!("`{}` is no seed, which is {what}", text.trim()));
    let Some((from, to)) = text.split_once("..") else { return one(text).map(|seed| seed..=seed) };
    let to = to.strip_prefix('=').unwrap_or(to);
    if from.trim().is_empty() || to.trim().is_empty() {
        return Err(format!("`{text}` lacks an end, and both are needed, as in `1..20`"));
    }
    let (from, to) = (one(from)?, one(to)?);
    if from > to { Err(format!("`{text}` runs backwards and holds no seed: `{to}..{from}` does")) } else { Ok(from..=to) }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn list(text: &str) -> Result<Vec<u64>, String> {
        Seeds::parse(text).map(|seeds| seeds.iter().collect())
    }

    #[test]
    fn ranges_lists_and_mixtures_include_both_ends_and_keep_their_order() {
        let is = |text: &str, seeds: &[u64]| assert_eq!(list(text).as_deref(), Ok(seeds), "{text}");
        is("1..4", &[1, 2, 3, 4]);
        is("1..=4", &[1, 2, 3, 4]);
        is("9,1,5", &[9, 1, 5]);
        is("5..6,1..3,9", &[5, 6, 1, 2, 3, 9]);
        is(" 0 .. 1 , 7 ", &[0, 1, 7]);
        is("3", &[3]);
        is("3..3", &[3]);
        is("9223372036854775806..9223372036854775807", &[LARGEST - 1, LARGEST]);
        assert_eq!(Seeds::parse("0..99999").map(|seeds| seeds.count()), Ok(100_000));
    }

    #[test]
    fn what_is_refused_says_what_would_be_right() {
        for (text, words) in [
            ("", "a seed is missing, as in `1..20`"),
            ("1,,3", "a seed is missing"),
            ("1..3,", "a seed is missing"),
            ("1..", "lacks an end"),
            ("..3", "lacks an end"),
            ("..", "lacks an end"),
            ("1..=", "lacks an end"),
            ("20..1", "`20..1` runs backwards and holds no seed: `1..20` does"),
            ("-1..3", "`-1` is no seed, which is a whole number from 0 to 9223372036854775807"),
            ("1..2.5", "`2.5` is no seed"),
            ("1...3", "`.3` is no seed"),
            ("1..9223372036854775808", "`9223372036854775808` is no seed"),
            ("one", "`one` is no seed"),
            ("0..100000", "these are 100001 seeds, and 100000 is the most"),
            ("0..9223372036854775807", "these are 9223372036854775808 seeds"),
            ("1..60000,100000..150000", "these are 110001 seeds"),
            ("1..5,3", "seed 3 is there twice"),
            ("7,7", "seed 7 is there twice"),
            ("4..6,1..4", "seed 4 is there twice"),
        ] {
            let said = list(text).expect_err(text);
            assert!(said.contains(words), "{text}: {said}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Any list of ranges is the seeds that counting up each of them gives, if none is there twice.
        #[test]
        fn ranges_are_what_counting_gives(
            ranges in proptest::collection::vec((0u64..400, 0u64..40, any::<bool>()), 1..8)
        ) {
            let word = |(from, more, equals): &(u64, u64, bool)| match (more, equals) {
                (0, true) => format!("{from}"),
                (more, true) => format!("{from}..={}", from + more),
                (more, false) => format!("{from}..{}", from + more),
            };
            let text = ranges.iter().map(word).collect::<Vec<_>>().join(",");
            let mut counted = Vec::new();
            for (from, more, _) in &ranges {
                counted.extend(*from..=from + more);
            }
            let once = counted.iter().collect::<BTreeSet<_>>().len() == counted.len();
            match list(&text) {
                Ok(seeds) => {
                    prop_assert!(once, "{text}");
                    prop_assert_eq!(seeds, counted);
                }
                Err(said) => prop_assert!(!once && said.contains("twice"), "{text}: {said}"),
            }
        }

        /// Whatever is typed is refused in words, or is at least one seed and no more than may be, each within bounds and there once.
        #[test]
        fn whatever_is_typed_is_seeds_or_refused(text in "[0-9.,= +-]{0,24}|\\PC{0,12}") {
            match Seeds::parse(&text) {
                Ok(seeds) => {
                    let all: BTreeSet<_> = seeds.iter().collect();
                    prop_assert!(!all.is_empty() && all.len() as u64 <= Seeds::MOST && all.len() == seeds.count());
                    prop_assert!(all.iter().all(|seed| *seed <= LARGEST));
                }
                Err(said) => prop_assert!(!said.is_empty()),
            }
        }
    }
}
