//! Whoever proposes candidates: one that is asked for them, and told what they came to (Collette, Hansen, Pujol, Salazar Aponte and Le Riche,
//! *On Object-Oriented Programming of Optimizers*, 2010).

use super::search::Trial;
use crate::scenario::sweep_file::Level;

/// A proposer is gone, or says what makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Lost {
    /// What came, and where.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

/// One that proposes candidates.
pub trait AskTell {
    /// What it is called.
    fn name(&self) -> String;

    /// What the default came to, before anything is asked, and its values where all scenarios agree on them.
    ///
    /// # Errors
    /// Where it does not listen any more.
    fn begin(&mut self, default: &Trial, values: &[Option<f64>]) -> Result<(), Lost>;

    /// Candidates that are to be tried next, each a value of every parameter; none where it has finished.
    ///
    /// # Errors
    /// Where it does not answer, or answers what is no candidate.
    fn ask(&mut self) -> Result<Vec<Vec<Level>>, Lost>;

    /// What they came to, in the order in which they were proposed.
    ///
    /// # Errors
    /// Where it does not listen any more.
    fn tell(&mut self, trials: &[Trial]) -> Result<(), Lost>;

    /// Whether it has come to rest, where it can: it would begin again elsewhere.
    fn is_at_rest(&self) -> bool;
}
