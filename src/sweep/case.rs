//! Points and replicates to cases. A case is just what `ductloop run BASE --set path=value … --seed N` runs.

use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::design::{Point, Points};
use crate::scenario::sweep_file::SweepFile;

/// Hash of the program's sources, presets and lock file.
pub const BUILD_ID: &str = env!("DUCTLOOP_BUILD_ID");

/// A case's name: 32 hexadecimal digits where it is written.
pub type CaseHash = u128;

/// One run of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its number: all replicates of the first point come first.
    pub index: u64,
    /// Number of its point.
    pub point: u64,
    /// Number of its replicate, from 0.
    pub replicate: u32,
    /// Its seed.
    pub seed: u64,
    /// Base and factors' values.
    pub at: Point,
    /// The factors' settings, `path=value`.
    pub settings: Vec<String>,
    /// XXH3-128 of all that its result follows from: base, settings, seed, build, and what renders.
    pub hash: CaseHash,
}

/// The cases of a sweep: each is a function of its number.
pub struct Cases<'a> {
    sweep: &'a SweepFile,
    points: Points<'a>,
    /// The hash so far of each base: what all of its cases have in common.
    begun: Vec<Xxh3>,
}

impl<'a> Cases<'a> {
    /// Of a sweep that is rendered by `renderer`: `cpu`, or what names an adapter and its driver.
    pub fn of(sweep: &'a SweepFile, renderer: &str) -> Self {
        let begun = sweep.bases.iter().map(|base| {
            let mut hash = Xxh3::new();
            for part in ["ductloop case 1", BUILD_ID, renderer, &base.text] {
                absorb(&mut hash, part);
            }
            // What bears on a case's outcome without being a field of its scenario.
            absorb(&mut hash, &format!("{:?}", sweep.wall_limit_s));
            sweep.settings.iter().for_each(|setting| absorb(&mut hash, setting));
            hash
        });
        Self { sweep, points: Points::of(sweep), begun: begun.collect() }
    }

    /// The sweep.
    pub fn sweep(&self) -> &'a SweepFile {
        self.sweep
    }

    /// How many points there are.
    pub fn points(&self) -> u64 {
        self.points.count()
    }

    /// Replicates of each point.
    pub fn replicates(&self) -> u32 {
        self.sweep.replicates
    }

    /// How many cases there are.
    pub fn count(&self) -> u64 {
        self.points().saturating_mul(u64::from(self.replicates()))
    }

    /// The case of this number.
    pub fn case(&self, index: u64) -> Case {
        let replicates = u64::from(self.replicates());
        self.replicate(index / replicates, (index % replicates) as u32)
    }

    /// A replicate of a point.
    pub fn replicate(&self, point: u64, replicate: u32) -> Case {
        let at = self.points.point(point);
        let settings: Vec<String> = self
            .sweep
            .factors
            .iter()
            .zip(&at.values)
            .filter_map(|(factor, value)| Some(format!("{}={}", factor.path, value.as_ref()?.toml())))
            .collect();
        let seed = self.seed(point, replicate);
        let mut hash = self.begun[at.base].clone();
        settings.iter().for_each(|setting| absorb(&mut hash, setting));
        hash.update(&seed.to_le_bytes());
        let index = point * u64::from(self.replicates()) + u64::from(replicate);
        Case { index, point, replicate, seed, at, settings, hash: hash.digest128() }
    }

    /// Seeds are what a scenario takes: below 2^63.
    fn seed(&self, point: u64, replicate: u32) -> u64 {
        let first = self.sweep.seed;
        if self.sweep.common_random_numbers {
            // After the last seed comes the first.
            return (first + u64::from(replicate)) & (i64::MAX as u64);
        }
        let of = [first, point, u64::from(replicate)].map(u64::to_le_bytes).concat();
        xxh3_64(&of) >> 1
    }
}

/// Takes a text in, so that no two lists of texts look alike.
fn absorb(hash: &mut Xxh3, text: &str) {
    hash.update(&(text.len() as u64).to_le_bytes());
    hash.update(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const BASE: &str = "format = 1\nkind = \"scenario\"\nname = \"b\"\n[robot]\npreset = \"incra1\"\n[sensor]\npreset = \"wide\"\n\
                        [duct]\nwidth_m = 0.5\nheight_m = 0.3\nrun = [{ straight_m = 3.0 }]\n";

    fn sweep(head: &str, base: &str) -> SweepFile {
        let text = format!(
            "format = 1\nkind = \"sweep\"\nname = \"s\"\nbase = \"b.toml\"\nreplicates = 3\n{head}\n[factor]\nduct.width_m = [0.4, 0.5]\n"
        );
        SweepFile::from_toml_str(&text, &[("b.toml", base)]).unwrap_or_else(|wrong| panic!("{wrong}"))
    }

    fn hashes(sweep: &SweepFile, renderer: &str) -> BTreeSet<CaseHash> {
        let cases = Cases::of(sweep, renderer);
        (0..cases.count()).map(|index| cases.case(index).hash).collect()
    }

    #[test]
    fn every_case_has_a_hash_of_its_own_that_changes_with_all_it_follows_from() {
        let before = hashes(&sweep("", BASE), "cpu");
        assert_eq!(before.len(), 6);
        assert_eq!(before, hashes(&sweep("about = \"says nothing of a run\"", BASE), "cpu"));
        for other in [
            hashes(&sweep("", &BASE.replace("3.0", "3.5")), "cpu"),
            hashes(&sweep("seed = 10", BASE), "cpu"),
            hashes(&sweep("wall_limit_s = 5", BASE), "cpu"),
            hashes(&sweep("scenario.robot.speed_m_s = 0.2", BASE), "cpu"),
            hashes(&sweep("", BASE), "wgpu llvmpipe"),
        ] {
            assert!(before.is_disjoint(&other));
        }
        // A shifted seed shares the seeds that it has in common, and the cases with them.
        assert_eq!(before.intersection(&hashes(&sweep("seed = 2", BASE), "cpu")).count(), 4);
    }

    #[test]
    fn common_random_numbers_are_the_same_at_every_point() {
        let seeds = |sweep: &SweepFile| {
            let cases = Cases::of(sweep, "cpu");
            (0..6).map(|index| cases.case(index).seed).collect::<Vec<_>>()
        };
        assert_eq!(seeds(&sweep("seed = 7", BASE)), [7, 8, 9, 7, 8, 9]);
        let own = seeds(&sweep("common_random_numbers = false", BASE));
        assert_eq!(own.iter().collect::<BTreeSet<_>>().len(), 6);
        assert!(own.iter().all(|seed| *seed <= i64::MAX as u64));
    }

    #[test]
    fn a_case_is_the_scenario_that_its_settings_make() {
        let sweep = sweep("", BASE);
        let case = Cases::of(&sweep, "cpu").case(4);
        assert_eq!((case.point, case.replicate, case.settings.as_slice()), (1, 1, ["duct.width_m=0.5".to_owned()].as_slice()));
        let scenario = sweep.scenario(case.at.base, &case.settings, case.seed).unwrap_or_else(|wrong| panic!("{wrong}"));
        assert_eq!((scenario.duct.width_m, scenario.seed), (0.5, 2));
    }
}
