//! Does what is not done yet, on all cores. Each case has a thread to itself.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, mpsc};

use super::case::{CaseHash, Cases};
use super::ledger::{self, Damaged, Kept, WriteError, Writer};
use super::outcome::Outcome;
use super::pass_rate::SoFar;
use super::plan::Plan;
use super::single_case::{self, Attempt};
use super::store::{Store, StoreError};
use crate::closed_loop::RunError;
use crate::engine::Engine;
use crate::metrics::Verdict;
use crate::scenario::sweep_file::StopRule;

/// A share of a sweep: every `count`-th point from the one numbered `index`, both from 1. A point is never shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1.
    pub index: u64,
    /// Of how many.
    pub count: u64,
}

impl Shard {
    /// The whole sweep.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// How many of `points` points it has.
    pub fn points(self, points: u64) -> u64 {
        (points + self.count - self.index) / self.count
    }

    /// The number of its `nth` point.
    fn point(self, nth: u64) -> u64 {
        self.index - 1 + nth * self.count
    }
}

/// How far the work is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Cases of the shard; with a stopping rule the most that there may be.
    pub cases: u64,
    /// Those that are done, here or before.
    pub done: u64,
    /// Those done before.
    pub found: u64,
    /// Those done of which the verdict is not "pass".
    pub failed: u64,
}

/// Why work cannot go on. What is finished is kept.
#[derive(Debug, thiserror::Error)]
pub enum WorkError {
    /// The store cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// An outcome cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// What renders was lost.
    #[error("{0}")]
    Lost(RunError),
}

/// What carries the work out.
#[derive(Clone, Copy, Debug)]
pub struct Means<'a> {
    /// Plan to work on.
    pub plan: &'a Plan,
    /// Where its results go.
    pub store: &'a Store,
    /// What renders.
    pub engine: &'a Engine,
    /// Cases at a time.
    pub threads: usize,
    /// Name of this machine.
    pub host: &'a str,
}

/// Finishes a shard. `damaged` is told of parts that cannot be read, whose cases are done again; `watch` sees the tally after each
/// case, from any thread, and is asked at every frame of every case whether to go on, with `None`. Broken off, what is finished stays.
///
/// # Errors
/// Where results cannot be read or written, or the graphics adapter is lost.
pub fn work(
    means: Means<'_>,
    shard: Shard,
    damaged: impl Fn(&Damaged),
    watch: &(dyn Fn(Option<Tally>) -> ControlFlow<()> + Sync),
) -> Result<Tally, WorkError> {
    let cases = means.plan.cases();
    let mut done = BTreeMap::new();
    let (mut alone, mut packed) = (BTreeMap::new(), BTreeSet::new());
    let broken = ledger::read(means.store, |outcome, kept| {
        done.insert(outcome.hash, outcome.passed());
        match kept {
            Kept::Alone => drop(alone.insert(outcome.hash, outcome)),
            // Of a machine that was too slow: another's may be better.
            Kept::Packed if outcome.verdict == Verdict::Timeout => {}
            Kept::Packed => drop(packed.insert(outcome.hash)),
        }
    })?;
    broken.iter().for_each(damaged);
    ledger::discard(means.store, &broken)?;
    ledger::tidy(means.store);
    let points = shard.points(cases.points());
    let replicates = u64::from(cases.replicates());
    let mut writer = Writer::new(means.store);
    if !alone.is_empty() {
        // Those of this shard: others may be at the rest.
        for nth in 0..points * replicates {
            let hash = cases.replicate(shard.point(nth % points), (nth / points) as u32).hash;
            if let Some(outcome) = alone.remove(&hash) {
                writer.adopt(outcome, packed.contains(&hash))?;
            }
        }
    }
    let tally = Mutex::new(Tally { cases: points * replicates, ..Tally::default() });
    let crew =
        Crew { means, cases: &cases, tally: &tally, watch, writer: Mutex::new(writer), broken_off: AtomicBool::new(false) };
    match cases.sweep().stop {
        // All first replicates, then all second ones: a sweep that is broken off has seen all of its points.
        None => crew.round(&mut done, points * replicates, |nth| (shard.point(nth % points), (nth / points) as u32))?,
        Some(rule) => by_rounds(&crew, &rule, &mut done, &(0..points).map(|nth| shard.point(nth)).collect::<Vec<_>>())?,
    }
    let mut writer = crew.writer.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    writer.pack()?;
    let tally = *lock(&tally);
    Ok(tally)
}

/// Replicates of the points that have not had enough, a few at a time. Which count is for [`super::table`] to say, by the same rule.
fn by_rounds(crew: &Crew<'_>, rule: &StopRule, done: &mut BTreeMap<CaseHash, bool>, points: &[u64]) -> Result<(), WorkError> {
    let replicates = crew.cases.replicates();
    let mut open: Vec<(u64, SoFar)> = points.iter().map(|point| (*point, SoFar::default())).collect();
    let mut next = 0;
    while next < replicates && !open.is_empty() && !crew.broken_off.load(Ordering::Relaxed) {
        // Enough for every thread to have something.
        let ahead = crew.means.threads.div_ceil(open.len()) as u32;
        let ahead = ahead.max(if next == 0 { rule.least_replicates } else { 1 }).min(replicates - next);
        let count = open.len() as u64;
        crew.round(done, count * u64::from(ahead), |nth| (open[(nth % count) as usize].0, next + (nth / count) as u32))?;
        next += ahead;
        open.retain_mut(|(point, so_far)| {
            while so_far.count < next {
                match done.get(&crew.cases.replicate(*point, so_far.count).hash) {
                    Some(passed) if so_far.is_enough_with(rule, *passed) => return false,
                    Some(_) => {}
                    // Broken off.
                    None => break,
                }
            }
            true
        });
    }
    Ok(())
}

/// Threads at work.
struct Crew<'a> {
    means: Means<'a>,
    cases: &'a Cases<'a>,
    tally: &'a Mutex<Tally>,
    watch: &'a (dyn Fn(Option<Tally>) -> ControlFlow<()> + Sync),
    writer: Mutex<Writer<'a>>,
    broken_off: AtomicBool,
}

/// What the threads of a round have taken.
#[derive(Default)]
struct Claimed {
    /// Number of the next case.
    next: AtomicU64,
    /// Cases that somebody runs or has run.
    hashes: Mutex<BTreeSet<CaseHash>>,
    /// Cases that came again: equal points share a result.
    again: Mutex<Vec<CaseHash>>,
}

impl Crew<'_> {
    /// Does `count` cases, of which `which` says point and replicate, and notes them as done.
    fn round(
        &self,
        done: &mut BTreeMap<CaseHash, bool>,
        count: u64,
        which: impl Fn(u64) -> (u64, u32) + Sync,
    ) -> Result<(), WorkError> {
        let claimed = Claimed::default();
        let known = &*done;
        let (which, claimed) = (&which, &claimed);
        let threads = (self.means.threads.max(1) as u64).min(count);
        // Disks take their time to flush: one thread writes while the others simulate, a few outcomes behind at most.
        let (sender, receiver) = mpsc::sync_channel(2 * threads as usize);
        let (results, written) = std::thread::scope(|scope| {
            let scribe = scope.spawn(|| self.write(receiver));
            let crew: Vec<_> = (0..threads)
                .map(|_| {
                    let sender = sender.clone();
                    scope.spawn(move || self.hand(known, claimed, count, which, &sender))
                })
                .collect();
            drop(sender);
            let results: Vec<_> = crew.into_iter().map(joined).collect();
            (results, joined(scribe))
        });
        written?;
        for result in results {
            done.extend(result?);
        }
        for hash in lock(&claimed.again).iter() {
            // Those whose first claim was broken off stay undone.
            if let Some(passed) = done.get(hash) {
                self.tell(*passed, true);
            }
        }
        Ok(())
    }

    /// Writes outcomes as they come, and counts them.
    fn write(&self, outcomes: mpsc::Receiver<Outcome>) -> Result<(), WorkError> {
        let mut writer = lock(&self.writer);
        for outcome in outcomes {
            let passed = outcome.passed();
            writer.put(outcome).inspect_err(|_| self.broken_off.store(true, Ordering::Relaxed))?;
            self.tell(passed, false);
        }
        Ok(())
    }

    /// One thread: takes the next case until there are none.
    fn hand(
        &self,
        known: &BTreeMap<CaseHash, bool>,
        claimed: &Claimed,
        count: u64,
        which: &(impl Fn(u64) -> (u64, u32) + Sync),
        outcomes: &mpsc::SyncSender<Outcome>,
    ) -> Result<Vec<(CaseHash, bool)>, WorkError> {
        let mut finished = Vec::new();
        while !self.broken_off.load(Ordering::Relaxed) {
            let nth = claimed.next.fetch_add(1, Ordering::Relaxed);
            if nth >= count {
                break;
            }
            let (point, replicate) = which(nth);
            let case = self.cases.replicate(point, replicate);
            if let Some(passed) = known.get(&case.hash) {
                self.tell(*passed, true);
                continue;
            }
            // A design may draw a point twice.
            if !lock(&claimed.hashes).insert(case.hash) {
                lock(&claimed.again).push(case.hash);
                continue;
            }
            let Means { plan, engine, host, .. } = self.means;
            match single_case::run(&plan.sweep, &case, engine, host, || self.go_on()) {
                Attempt::Over(outcome) => {
                    finished.push((case.hash, outcome.passed()));
                    // Nobody takes it where it cannot be written: then the writer says why.
                    if outcomes.send(*outcome).is_err() {
                        break;
                    }
                }
                Attempt::BrokenOff => break,
                Attempt::Lost(error) => {
                    self.broken_off.store(true, Ordering::Relaxed);
                    return Err(WorkError::Lost(error));
                }
            }
        }
        Ok(finished)
    }

    /// Counts a case.
    fn tell(&self, passed: bool, found: bool) {
        let tally = {
            let mut tally = lock(self.tally);
            tally.done += 1;
            tally.found += u64::from(found);
            tally.failed += u64::from(!passed);
            *tally
        };
        if (self.watch)(Some(tally)).is_break() {
            self.broken_off.store(true, Ordering::Relaxed);
        }
    }

    fn go_on(&self) -> ControlFlow<()> {
        if (self.watch)(None).is_break() || self.broken_off.load(Ordering::Relaxed) {
            self.broken_off.store(true, Ordering::Relaxed);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn joined<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_have_every_point_once() {
        for (points, count) in [(10, 3), (2, 5), (7, 1), (0, 4)] {
            let mut all: Vec<u64> = (1..=count)
                .flat_map(|index| {
                    let shard = Shard { index, count };
                    (0..shard.points(points)).map(move |nth| shard.point(nth))
                })
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..points).collect::<Vec<_>>(), "{points} over {count}");
        }
    }
}
