//! Factors to design points.

use crate::scenario::sweep_file::{Design, Factor, Level, Levels, SweepFile};
use crate::stream::uniform;

/// Streams of random numbers that a design draws from; a factor's number is added.
const LATIN: u64 = 0x1a71_0000;
const WITHIN_STRATUM: u64 = 0x1a72_0000;
const RANDOM: u64 = 0x1a73_0000;

/// A combination of values on a base.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Index of the base.
    pub base: usize,
    /// Value of each factor; `None` is the base's own.
    pub values: Vec<Option<Level>>,
}

/// The points of a sweep: each is a function of its number.
#[derive(Debug)]
pub struct Points<'a> {
    sweep: &'a SweepFile,
    /// Stratum of each point, for each factor of a Latin hypercube.
    strata: Vec<Vec<u32>>,
}

impl<'a> Points<'a> {
    /// Of a sweep.
    pub fn of(sweep: &'a SweepFile) -> Self {
        let strata = match sweep.design {
            Design::LatinHypercube { samples } => {
                (0..sweep.factors.len() as u64).map(|factor| permutation(samples as u32, sweep.seed, LATIN + factor)).collect()
            }
            _ => Vec::new(),
        };
        Self { sweep, strata }
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.of_a_base().saturating_mul(self.sweep.bases.len() as u64)
    }

    fn of_a_base(&self) -> u64 {
        let sizes = self.sweep.factors.iter().map(|factor| listed(factor).len() as u64);
        match self.sweep.design {
            Design::Grid => sizes.fold(1, u64::saturating_mul),
            Design::OneAtATime => 1 + sizes.sum::<u64>(),
            Design::Listed => sizes.min().unwrap_or(1),
            Design::Sobol { samples } | Design::LatinHypercube { samples } | Design::Random { samples } => samples,
        }
    }

    /// The point of this number, from 0; all points of the first base come first.
    pub fn point(&self, index: u64) -> Point {
        let (base, within) = (index / self.of_a_base(), index % self.of_a_base());
        let factors = &self.sweep.factors;
        let values = match self.sweep.design {
            Design::Grid => {
                let mut rest = within as usize;
                let last_first = factors.iter().rev().map(|factor| {
                    let levels = listed(factor);
                    let level = levels[rest % levels.len()].clone();
                    rest /= levels.len();
                    Some(level)
                });
                let mut values: Vec<_> = last_first.collect();
                values.reverse();
                values
            }
            Design::OneAtATime => {
                // The base itself is the first.
                let mut before = 1;
                let value = |factor: &Factor| {
                    let levels = listed(factor);
                    let level = (within as usize).checked_sub(before).and_then(|index| levels.get(index)).cloned();
                    before += levels.len();
                    level
                };
                factors.iter().map(value).collect()
            }
            Design::Listed => factors.iter().map(|factor| listed(factor).get(within as usize).cloned()).collect(),
            Design::Sobol { .. } | Design::LatinHypercube { .. } | Design::Random { .. } => {
                factors.iter().enumerate().map(|(number, factor)| Some(factor.at(self.share(within, number)))).collect()
            }
        };
        Point { base: base as usize, values }
    }

    /// Where in its distribution a factor stands at a point, 0 to below 1.
    fn share(&self, point: u64, factor: usize) -> f64 {
        let (seed, number) = (self.sweep.seed, factor as u64);
        match self.sweep.design {
            // The generator has 256 dimensions; another seed gives as many more.
            Design::Sobol { .. } => {
                let (set, dimension) = ((factor / 256) as u32, (factor % 256) as u32);
                f64::from(sobol_burley::sample(point as u32, dimension, (seed as u32).wrapping_add(set)))
            }
            Design::LatinHypercube { samples } => {
                let stratum = f64::from(self.strata[factor][point as usize]);
                (stratum + uniform(seed, point, WITHIN_STRATUM + number)) / samples as f64
            }
            _ => uniform(seed, point, RANDOM + number),
        }
    }
}

/// The values of a factor in a design that lists its points.
fn listed(factor: &Factor) -> &[Level] {
    match &factor.levels {
        Levels::List(levels) => levels,
        // Refused when the file is read.
        Levels::Range { .. } | Levels::Normal { .. } => &[],
    }
}

/// The numbers below `count` in random order (Fisher and Yates, Knuth's algorithm P).
fn permutation(count: u32, seed: u64, stream: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..count as usize).rev() {
        let other = (uniform(seed, last as u64, stream) * (last + 1) as f64) as usize;
        order.swap(last, other);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(design: &str, factors: &str) -> SweepFile {
        const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                            [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";
        let text = format!("format = 1\nkind = \"sweep\"\nname = \"s\"\nbase = \"b.toml\"\n{design}\n[factor]\n{factors}");
        SweepFile::from_toml_str(&text, &[("b.toml", BASE)]).unwrap_or_else(|wrong| panic!("{wrong}"))
    }

    const RANGES: &str = "duct.width_m = { from = 0.3, to = 1.2 }\nrobot.speed_m_s = { from = 0.1, to = 0.5 }";

    fn shares(sweep: &SweepFile) -> Vec<[f64; 2]> {
        let points = Points::of(sweep);
        let at = |point: &Point, i: usize, [from, to]: [f64; 2]| {
            (point.values[i].as_ref().and_then(Level::number).unwrap_or(f64::NAN) - from) / (to - from)
        };
        (0..points.count()).map(|i| points.point(i)).map(|p| [at(&p, 0, [0.3, 1.2]), at(&p, 1, [0.1, 0.5])]).collect()
    }

    #[test]
    fn a_grid_has_every_combination_and_the_last_factor_is_fastest() {
        let sweep =
            sweep("", "duct.width_m = [0.4, 0.5]\nsensor.preset = [\"wide\", \"incra1\"]\nrobot.speed_m_s = [0.1, 0.2, 0.3]");
        let points = Points::of(&sweep);
        assert_eq!(points.count(), 12);
        let told = |index| points.point(index).values.iter().flatten().map(Level::shown).collect::<Vec<_>>().join(" ");
        let firsts = ["0.4 wide 0.1", "0.4 wide 0.2", "0.4 wide 0.3", "0.4 incra1 0.1"];
        assert_eq!((0..4).map(told).collect::<Vec<_>>(), firsts);
        assert_eq!(told(11), "0.5 incra1 0.3");
        let mut all: Vec<_> = (0..12).map(told).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 12);
    }

    #[test]
    fn one_at_a_time_changes_one_at_a_time() {
        let sweep = sweep("design = \"one-at-a-time\"", "duct.width_m = [0.4, 0.6]\nrobot.speed_m_s = [0.1, 0.2, 0.3]");
        let points = Points::of(&sweep);
        assert_eq!(points.count(), 6);
        let changed: Vec<usize> = (0..6).map(|i| points.point(i).values.iter().flatten().count()).collect();
        assert_eq!(changed, [0, 1, 1, 1, 1, 1]);
        assert_eq!(points.point(2).values[0].as_ref().map(Level::shown).as_deref(), Some("0.6"));
        assert_eq!(points.point(5).values[1].as_ref().map(Level::shown).as_deref(), Some("0.3"));
    }

    #[test]
    fn listed_values_go_in_step() {
        let sweep = sweep("design = \"listed\"", "duct.width_m = [0.4, 0.6]\nrobot.speed_m_s = [0.1, 0.3]");
        let points = Points::of(&sweep);
        let told = |index| points.point(index).values.iter().flatten().map(Level::shown).collect::<Vec<_>>().join(" ");
        assert_eq!((points.count(), told(0), told(1)), (2, "0.4 0.1".into(), "0.6 0.3".into()));
    }

    #[test]
    fn every_stratum_of_a_latin_hypercube_has_one_point() {
        let sweep = sweep("design = \"latin-hypercube\"\nsamples = 50", RANGES);
        for axis in 0..2 {
            let mut strata: Vec<usize> = shares(&sweep).iter().map(|share| (share[axis] * 50.0) as usize).collect();
            assert!(!strata.is_sorted(), "the order is drawn");
            strata.sort_unstable();
            assert_eq!(strata, (0..50).collect::<Vec<_>>());
        }
    }

    /// A (0, m, 2)-net in base 2: each of the elementary intervals of area 1/64 holds one of 64 points (Niederreiter 1987; Owen's
    /// scrambling keeps that).
    #[test]
    fn a_sobol_sequence_is_a_net() {
        let sweep = sweep("design = \"sobol\"\nsamples = 64", RANGES);
        let shares = shares(&sweep);
        for bits in 0..=6 {
            let (columns, rows) = (1 << bits, 1 << (6 - bits));
            let mut counts = vec![0; 64];
            for [x, y] in &shares {
                counts[(x * f64::from(columns)) as usize * rows as usize + (y * f64::from(rows)) as usize] += 1;
            }
            assert_eq!(counts, vec![1; 64], "{columns} x {rows}");
        }
    }

    #[test]
    fn what_is_drawn_is_the_seeds_alone() {
        for design in ["sobol", "latin-hypercube", "random"] {
            let of = |seed: u64| shares(&sweep(&format!("seed = {seed}\ndesign = \"{design}\"\nsamples = 8"), RANGES));
            assert_eq!(of(1), of(1));
            assert_ne!(of(1), of(2), "{design}");
        }
    }
}
