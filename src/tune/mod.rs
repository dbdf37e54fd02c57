//! Tuning: parameters that do well on some ducts, held against the default on ducts that the search never saw.
//!
//! In data-flow order:
//!
//! - [`candidate`]: a point of the unit box as settings of a scenario; - [`objective`]: what its runs come to; - [`front`]: which of several
//!   objectives' candidates no other betters; - [`ranking`]: the others behind them;
//! - [`jacobi`], [`cma_es`], [`restarts`], [`mo_cma_es`]: the evolution strategies, of one objective and of several;
//! - [`ask_tell`]: one that is asked for candidates and told what they came to: - [`proposer`]: what is built in; - [`outside`]: any other
//!   program, over lines of JSON; - [`journal`]: what it proposed, for when it or this program dies;
//! - [`search`]: candidates, generation by generation, each a sweep of its own;
//! - [`held_out`]: the find and the default on ducts that were not seen, with their [`comparison`]: interval and test;
//! - [`trials`]: a row a candidate; - [`sensitivity`]: costs over parameters; - [`verdict`], [`summary`]: what it comes to, in words and figures.

pub mod ask_tell;
#[cfg(test)]
mod bbob;
pub mod candidate;
pub mod cma_es;
pub mod comparison;
pub mod front;
pub mod held_out;
pub mod jacobi;
pub mod journal;
pub mod mo_cma_es;
pub mod objective;
pub mod outside;
pub mod proposer;
pub mod ranking;
pub mod restarts;
pub mod search;
pub mod sensitivity;
pub mod summary;
pub mod trials;
pub mod verdict;
