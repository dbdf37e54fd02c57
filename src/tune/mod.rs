//! Tuning: parameters that do well on some ducts, held against the default on ducts that the search never saw.
//!
//! In data-flow order:
//!
//! - [`candidate`]: a point of the unit box as settings of a scenario; - [`objective`]: what its runs come to; - [`front`]: which of several
//!   objectives' candidates no other betters;
//! - [`jacobi`], [`cma_es`], [`restarts`], [`mo_cma_es`]: the evolution strategies, of one objective and of several;
//! - [`ask_tell`]: one that is asked for candidates and told what they came to: - [`proposer`]: what is built in; - [`outside`]: any other
//!   program, over lines of JSON; - [`journal`]: what it proposed, for when it or this program dies;
//! - [`search`]: candidates, generation by generation, each a sweep of its own; - [`comparison`]: the find against the default;
//! - [`trials`]: a row a candidate; - [`summary`]: what it comes to.

pub mod ask_tell;
#[cfg(test)]
mod bbob;
pub mod candidate;
pub mod cma_es;
pub mod comparison;
pub mod front;
pub mod jacobi;
pub mod journal;
pub mod mo_cma_es;
pub mod objective;
pub mod outside;
pub mod proposer;
pub mod ranking;
pub mod restarts;
pub mod search;
pub mod summary;
pub mod trials;
