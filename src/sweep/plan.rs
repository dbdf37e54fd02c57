//! A sweep's plan as it stands beside its results, `plan.json`: the sweep with the texts of its bases, so that any machine with the
//! same program can make the same cases of it.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::case::{BUILD_ID, Cases};
use super::store::{Store, StoreError};
use crate::scenario::sweep_file::{Base, SweepFile, SweepPass};

/// The plan's object in its store.
pub const NAME: &str = "plan.json";

/// A plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of this document's format.
    pub format: u32,
    /// Version of the program.
    pub version: String,
    /// Hash of the program's sources: only the same one may work on it.
    pub build: String,
    /// What renders: `cpu`, or `wgpu` with the adapter and its driver.
    pub renderer: String,
    /// How many points there are.
    pub points: u64,
    /// How many cases there are.
    pub cases: u64,
    /// XXH3-128 of the sweep as it stands below: a plan that was edited is none.
    pub hash: String,
    /// The sweep.
    pub sweep: SweepFile,
}

/// Why a store's plan cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// There is no plan.
    #[error("{0} holds no {NAME}: `ductloop sweep plan FILE --out {0}` writes one")]
    None(String),
    /// The document is not one.
    #[error("{0}/{NAME} is no plan of a sweep: {1}")]
    Unreadable(String, serde_json::Error),
    /// It is not as it was written.
    #[error("{0}/{NAME} was changed since it was written: plan anew with `ductloop sweep plan FILE --out {0} --force`")]
    Changed(String),
    /// Another program wrote it.
    #[error(
        "{place}/{NAME} was made by another build of ductloop ({theirs}), whose results would differ: plan anew with \
         `ductloop sweep plan FILE --out {place} --force`"
    )]
    OtherBuild {
        /// The store.
        place: String,
        /// The build that made it.
        theirs: String,
    },
    /// Another sweep is there.
    #[error("{0} holds another sweep, or this one as it was before its file, its base or the program changed")]
    OtherSweep(String),
    /// A document cannot be made.
    #[error("{NAME} cannot be made: {0}")]
    Json(#[from] serde_json::Error),
}

impl Plan {
    /// The plan of a sweep that `renderer` renders.
    pub fn of(sweep: SweepFile, renderer: &str) -> Self {
        let cases = Cases::of(&sweep, renderer);
        let (points, count) = (cases.points(), cases.count());
        Self {
            format: 1,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: BUILD_ID.to_owned(),
            renderer: renderer.to_owned(),
            points,
            cases: count,
            hash: hash_of(&sweep),
            sweep,
        }
    }

    /// Its cases.
    pub fn cases(&self) -> Cases<'_> {
        Cases::of(&self.sweep, &self.renderer)
    }

    /// Reads a store's plan, which must be of this program.
    ///
    /// # Errors
    /// Where there is none, or it is not of this program.
    pub fn read(store: &Store) -> Result<Self, PlanError> {
        let place = || store.place().to_owned();
        let bytes = store.get(NAME)?.ok_or_else(|| PlanError::None(place()))?;
        let plan: Self = serde_json::from_slice(&bytes).map_err(|error| PlanError::Unreadable(place(), error))?;
        if plan.build != BUILD_ID {
            return Err(PlanError::OtherBuild { place: place(), theirs: plan.build });
        }
        let as_written = plan.format == 1 && plan.hash == hash_of(&plan.sweep) && (plan.points, plan.cases) == plan.counts();
        if as_written { Ok(plan) } else { Err(PlanError::Changed(place())) }
    }

    fn counts(&self) -> (u64, u64) {
        let cases = self.cases();
        (cases.points(), cases.count())
    }

    /// What of the plan bears on its cases, as text: not how the bases' files are called, what the sweep is for, or what is kept of it.
    pub fn identity(&self) -> String {
        let bases = self.sweep.bases.iter().map(|base| Base { file: String::new(), ..base.clone() }).collect();
        let sweep =
            SweepFile { about: String::new(), bases, metrics: Vec::new(), pass: SweepPass::default(), ..self.sweep.clone() };
        format!("{} {} {}", self.build, self.renderer, as_text(&sweep))
    }

    /// Puts the plan into a store. One that is there already must be the same, unless `force`; results that are there stay: those of
    /// cases that are in both plans count, the others are not looked at.
    ///
    /// # Errors
    /// Where another plan is there, or the store cannot be written.
    pub fn write(&self, store: &Store, force: bool) -> Result<(), PlanError> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        if force {
            return Ok(store.replace(NAME, text.into_bytes())?);
        }
        let there = match store.get(NAME)? {
            Some(there) => Some(there),
            None if store.create(NAME, text.clone().into_bytes())? => return Ok(()),
            None => store.get(NAME)?,
        };
        match there.map(|there| serde_json::from_slice::<Self>(&there)) {
            // Not written again: where a disk is full, a call still goes on from what is kept.
            Some(Ok(there)) if there == *self => Ok(()),
            // The same cases: what is kept of them, or how a file is called, may have changed.
            Some(Ok(there)) if there.identity() == self.identity() => Ok(store.replace(NAME, text.into_bytes())?),
            _ => Err(PlanError::OtherSweep(store.place().to_owned())),
        }
    }
}

fn hash_of(sweep: &SweepFile) -> String {
    format!("{:032x}", xxh3_128(as_text(sweep).as_bytes()))
}

/// A sweep as JSON, of which everything in it is capable.
fn as_text(sweep: &SweepFile) -> String {
    serde_json::to_string(sweep).unwrap_or_default()
}
