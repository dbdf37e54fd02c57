//! What is done: the parts of a store, read whatever their size. Each finished case is a part of its own at once, `parts/HASH.parquet`, so
//! that nothing finished is ever lost; a worker packs its own into `parts/pack-COUNT-HASH.parquet` now and then, so that a hundred
//! thousand cases are not as many files.

use std::time::Duration;

use xxhash_rust::xxh3::xxh3_64;

use super::case::CaseHash;
use super::outcome::Outcome;
use super::part::{self, PartError};
use super::store::{Store, StoreError};

/// Folder of the parts.
const FOLDER: &str = "parts";
/// Cases that a worker packs into one part.
pub const PACK: usize = 64;
/// How old what is half written must be to be nobody's.
const HALF_WRITTEN: Duration = Duration::from_secs(3600);

/// A part that could not be read.
#[derive(Debug)]
pub struct Damaged {
    /// The object.
    pub name: String,
    /// What is wrong with it.
    pub error: PartError,
}

/// The name of a case's part.
fn name_of(hash: CaseHash) -> String {
    format!("{FOLDER}/{hash:032x}.parquet")
}

/// How many cases a store's parts hold, by their names alone: cheap enough to ask every second. Cases of other plans count.
///
/// # Errors
/// Where the store cannot be read.
pub fn count(store: &Store) -> Result<u64, StoreError> {
    let packed = |name: &str| name.strip_prefix(FOLDER)?.strip_prefix("/pack-")?.split('-').next()?.parse().ok();
    Ok(store.list(FOLDER)?.iter().map(|name| packed(name).unwrap_or(1)).sum())
}

/// How an outcome is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// In a part of its own.
    Alone,
    /// With others.
    Packed,
}

/// Reads every part. What is in two of them comes twice. Damaged parts are told of and left alone.
///
/// # Errors
/// Where the store cannot be read.
pub fn read(store: &Store, mut take: impl FnMut(Outcome, Kept)) -> Result<Vec<Damaged>, StoreError> {
    let mut damaged = Vec::new();
    let mut seen = std::collections::BTreeSet::new();
    loop {
        let mut vanished = false;
        for name in store.list(FOLDER)? {
            if seen.contains(&name) {
                continue;
            }
            // Another worker may have packed it since.
            let Some(bytes) = store.get(&name)? else {
                vanished = true;
                continue;
            };
            match part::read(bytes) {
                Ok(outcomes) => {
                    let alone = outcomes.len() == 1 && name == name_of(outcomes[0].hash);
                    outcomes.into_iter().for_each(|outcome| take(outcome, if alone { Kept::Alone } else { Kept::Packed }));
                }
                Err(error) => damaged.push(Damaged { name: name.clone(), error }),
            }
            seen.insert(name);
        }
        if !vanished {
            return Ok(damaged);
        }
    }
}

/// Takes damaged parts away, so that their cases are done again: those that are still damaged, as another worker may have been faster.
///
/// # Errors
/// Where one cannot be taken away.
pub fn discard(store: &Store, damaged: &[Damaged]) -> Result<(), StoreError> {
    for Damaged { name, .. } in damaged {
        if store.get(name)?.is_some_and(|bytes| part::read(bytes).is_err()) {
            store.delete(name)?;
        }
    }
    Ok(())
}

/// Writes many outcomes as one part, unless there is one of the same; whether it did.
///
/// # Errors
/// Where it cannot be written.
pub fn pack(store: &Store, outcomes: &[Outcome]) -> Result<bool, WriteError> {
    let hashes: Vec<u8> = outcomes.iter().flat_map(|outcome| outcome.hash.to_le_bytes()).collect();
    let name = format!("{FOLDER}/pack-{}-{:016x}.parquet", outcomes.len(), xxh3_64(&hashes));
    Ok(store.create(&name, part::write(outcomes)?)?)
}

/// Takes away what killed writers left half written, wherever a sweep has files. A write takes seconds at most, so that what is older than
/// an hour is nobody's; should a worker write it after all, its write fails and says so.
pub fn tidy(store: &Store) {
    ["", FOLDER, "plots"].into_iter().for_each(|folder| store.tidy(folder, HALF_WRITTEN));
}

/// Writes outcomes as they come.
#[derive(Debug)]
pub struct Writer<'a> {
    store: &'a Store,
    /// Those with a part of their own that this has written or adopted.
    singles: Vec<Outcome>,
}

/// Why an outcome could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The store would not take it.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The part could not be made.
    #[error("a part of the results cannot be made: {0}")]
    Part(#[from] parquet::errors::ParquetError),
}

impl<'a> Writer<'a> {
    /// Into a store.
    pub fn new(store: &'a Store) -> Self {
        Self { store, singles: Vec::new() }
    }

    /// Writes one case's outcome, unless somebody else has.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn put(&mut self, outcome: Outcome) -> Result<(), WriteError> {
        if self.store.create(&name_of(outcome.hash), part::write(std::slice::from_ref(&outcome))?)? {
            self.singles.push(outcome);
        }
        if self.singles.len() >= PACK { self.pack() } else { Ok(()) }
    }

    /// Takes over an outcome that has a part of its own, as killed workers leave some: it is packed with this one's, or, where it is `packed`
    /// already, loses the part of its own. Should its worker still live, it packs it once more, which is no harm.
    ///
    /// # Errors
    /// Where the pack cannot be written.
    pub fn adopt(&mut self, outcome: Outcome, packed: bool) -> Result<(), WriteError> {
        if packed {
            return Ok(self.store.delete(&name_of(outcome.hash))?);
        }
        self.singles.push(outcome);
        if self.singles.len() >= PACK { self.pack() } else { Ok(()) }
    }

    /// Packs what has a part of its own. Killed between the two steps it leaves cases twice, which is no harm.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn pack(&mut self) -> Result<(), WriteError> {
        if self.singles.len() < 2 {
            return Ok(());
        }
        let singles = std::mem::take(&mut self.singles);
        // One of this name is somebody else's, or was damaged: what has a part of its own keeps it.
        if !pack(self.store, &singles)? {
            return Ok(());
        }
        singles.iter().try_for_each(|outcome| self.store.delete(&name_of(outcome.hash)))?;
        Ok(())
    }
}
